//! `rsrs keystore`: who belongs to a fleet, and what each of them may do.

pub mod create;
pub mod harden;
pub mod members;

use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::Context;
use jiff::Timestamp;
use rsrs_files::quoted;
use rsrs_keystore::problem::{EnclaveProblem, cures};

use crate::failure::Outcome;

const DAY: Duration = Duration::from_secs(24 * 3600);

fn since_1970() -> anyhow::Result<Duration> {
    SystemTime::now().duration_since(UNIX_EPOCH).context("the clock is before 1970")
}

/// What copies the enclave of a robot to its computer, and gives its key to the user of its service: a key
/// that was copied belongs to root, also where one was that did not. A host is not called as a robot in a
/// namespace is: rsync would take that for a folder.
fn copy_lines(keystore: &Path) -> String {
    let from = quoted(keystore.join("./enclaves/ROBOT"));
    format!(
        "  rsync -rpRL --mkpath --rsync-path='sudo rsync' {from} HOST:/etc/rsrs/keystore/\n  \
         ssh HOST sudo chown rsrs /etc/rsrs/keystore/enclaves/ROBOT/key.pem"
    )
}

/// The same for an enclave on a computer of a person, such as `/stop` on a laptop.
fn copy_line_of_others(keystore: &Path) -> String {
    format!("  rsync -rpRL --mkpath {} HOST:keystore/", quoted(keystore.join("./enclaves/stop")))
}

/// A moment as a day.
fn day(at: Duration) -> String {
    let moment = i64::try_from(at.as_secs()).ok().and_then(|s| Timestamp::from_second(s).ok());
    moment.map_or_else(|| "never".to_owned(), |moment| moment.strftime("%Y-%m-%d").to_string())
}

/// What to type next about problems, a line each.
fn next(keystore: &Path, fleet: Option<&Path>, problems: &[EnclaveProblem]) -> Option<String> {
    let cures = cures(keystore, fleet, problems);
    (!cures.is_empty()).then(|| format!("next:\n  {}", cures.join("\n  ")))
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
