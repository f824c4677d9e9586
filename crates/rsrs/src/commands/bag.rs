//! `rsrs bag`: what is in a recording, and what can be saved of a damaged one.

pub mod info;
pub mod recover;

use crate::failure::Outcome;

/// Look into bags, and save what can be saved of damaged ones.
#[derive(clap::Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    Info(info::Arguments),
    Recover(recover::Arguments),
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    match &arguments.what {
        What::Info(arguments) => info::run(arguments),
        What::Recover(arguments) => recover::run(arguments),
    }
}
