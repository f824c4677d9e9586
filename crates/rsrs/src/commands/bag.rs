//! `rsrs bag`: what is in a recording, and what can be saved of a damaged one.

pub mod info;
pub mod recover;

use crate::failure::Outcome;

/// Look into bags, and save what can be saved of damaged ones.
#[derive(clap::Subcommand)]
pub enum Command {
    Info(info::Arguments),
    Recover(recover::Arguments),
}

pub fn run(command: &Command) -> anyhow::Result<Outcome> {
    match command {
        Command::Info(arguments) => info::run(arguments),
        Command::Recover(arguments) => recover::run(arguments),
    }
}
