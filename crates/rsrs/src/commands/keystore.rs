//! `rsrs keystore`: who belongs to a fleet, and what each of them may do.

pub mod create;
pub mod harden;
pub mod members;

use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::Context;
use rsrs_pipeline::wording::shell::quoted;

use crate::failure::Outcome;

const DAY: Duration = Duration::from_secs(24 * 3600);

fn since_1970() -> anyhow::Result<Duration> {
    SystemTime::now().duration_since(UNIX_EPOCH).context("the clock is before 1970")
}

/// What copies the enclave of a robot to it, and gives its key to the user of its service: a key that was
/// copied belongs to root, also where one was that did not.
fn copy_lines(keystore: &Path) -> String {
    let from = quoted(keystore.join("./enclaves/ROBOT"));
    format!(
        "  rsync -rpRL --mkpath --rsync-path='sudo rsync' {from} ROBOT:/etc/rsrs/keystore/\n  \
         ssh ROBOT sudo chown rsrs /etc/rsrs/keystore/enclaves/ROBOT/key.pem"
    )
}

/// Make keystores with which robots obey nobody but their own runner and controllers.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    Create(create::Arguments),
    Harden(harden::Arguments),
    Show(members::ShowArguments),
    Renew(members::RenewArguments),
    Revoke(members::RevokeArguments),
}

/// Runs the command.
///
/// # Errors
///
/// Those of the subcommands.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    match &arguments.what {
        What::Create(arguments) => create::run(arguments),
        What::Harden(arguments) => harden::run(arguments),
        What::Show(arguments) => members::show(arguments),
        What::Renew(arguments) => members::renew(arguments),
        What::Revoke(arguments) => members::revoke(arguments),
    }
}
