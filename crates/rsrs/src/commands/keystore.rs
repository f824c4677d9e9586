//! `rsrs keystore`: who belongs to a fleet, and what each of them may do.

pub mod create;
pub mod harden;
pub mod members;

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::Context;

use crate::failure::Outcome;

const DAY: Duration = Duration::from_secs(24 * 3600);

fn since_1970() -> anyhow::Result<Duration> {
    SystemTime::now().duration_since(UNIX_EPOCH).context("the clock is before 1970")
}

/// Make keystores, so that robots obey only their own runner and controllers.
#[derive(clap::Subcommand)]
pub enum Command {
    Create(create::Arguments),
    Harden(harden::Arguments),
    Show(members::ShowArguments),
    Renew(members::RenewArguments),
    Revoke(members::RevokeArguments),
}

pub fn run(command: &Command) -> anyhow::Result<Outcome> {
    match command {
        Command::Create(arguments) => create::run(arguments),
        Command::Harden(arguments) => harden::run(arguments),
        Command::Show(arguments) => members::show(arguments),
        Command::Renew(arguments) => members::renew(arguments),
        Command::Revoke(arguments) => members::revoke(arguments),
    }
}
