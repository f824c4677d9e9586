//! `rsrs measure`: step 1, from trials on the floor to a profile.

pub mod drive;
pub mod fit;
pub mod plan;

use crate::failure::Outcome;

/// Measure the robots: which trials to run, drive them, and fit them.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    step: Step,
}

#[derive(clap::Subcommand)]
enum Step {
    Plan(plan::Arguments),
    Drive(drive::Arguments),
    Fit(fit::Arguments),
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    match &arguments.step {
        Step::Plan(arguments) => plan::run(arguments),
        Step::Drive(arguments) => drive::run(arguments),
        Step::Fit(arguments) => fit::run(arguments),
    }
}
