//! The command line of RSRS: one file for each subcommand.

mod commands;
mod failure;
mod interrupt;
mod picture;
mod progress;
mod provenance;
mod replicate_table;
mod result_folder;
mod sweep_source;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::failure::Outcome;

/// From paper to floor: simulate a robot swarm worse than it is, and find where it mills.
#[derive(Parser)]
#[command(version, max_term_width = 100, help_expected = true, after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  rsrs sweep launch_configs/sweeps/flockbot_speed_turn.yaml -o results/flockbot
  rsrs choose results/flockbot
  rsrs diagram results/flockbot -o flockbot.svg

Exit codes: 0 done, 1 failed, 2 bad arguments, 3 done with a negative answer.";

#[derive(Subcommand)]
enum Command {
    Sweep(commands::sweep::Arguments),
    Diagram(commands::diagram::Arguments),
    Choose(commands::choose::Arguments),
    Label(commands::label::Arguments),
    Node(commands::node::Arguments),
    Completions(commands::completions::Arguments),
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let result = match &arguments.command {
        Command::Sweep(arguments) => commands::sweep::run(arguments),
        Command::Diagram(arguments) => commands::diagram::run(arguments),
        Command::Choose(arguments) => commands::choose::run(arguments),
        Command::Label(arguments) => commands::label::run(arguments),
        Command::Node(arguments) => commands::node::run(arguments),
        Command::Completions(arguments) => Ok(commands::completions::run::<Arguments>(arguments)),
    };
    match result {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::NegativeAnswer) => ExitCode::from(3),
        Err(error) => {
            failure::say(&error);
            ExitCode::FAILURE
        }
    }
}
