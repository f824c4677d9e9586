//! `rsrs keystore`: who belongs to a fleet, and what each of them may do.

pub mod create;
pub mod harden;

use crate::failure::Outcome;

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
    }
}
