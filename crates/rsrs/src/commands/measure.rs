//! `rsrs measure`: step 1, from trials on the floor to a profile.

pub mod drive;
pub mod fit;
pub mod plan;

use crate::failure::Outcome;

/// Measure the robots: which trials to run, drive them, and fit them.
#[derive(clap::Subcommand)]
pub enum Command {
    Plan(plan::Arguments),
    Drive(drive::Arguments),
    Fit(fit::Arguments),
}

pub fn run(command: &Command) -> anyhow::Result<Outcome> {
    match command {
        Command::Plan(arguments) => plan::run(arguments),
        Command::Drive(arguments) => drive::run(arguments),
        Command::Fit(arguments) => fit::run(arguments),
    }
}
