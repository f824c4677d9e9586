//! The command line of RSRS: one file for each subcommand.

mod admission;
mod commands;
mod comparison_report;
mod experiment_bar;
mod failure;
mod interrupt;
mod labelling;
mod own_network;
mod picture;
mod progress;
mod provenance;
mod recorded_run;
mod replicate_table;
mod result_folder;
mod simulated_fleet;
mod starter_files;
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
  rsrs dry-run
  rsrs sweep launch_configs/sweeps/flockbot_speed_turn.yaml -o results/flockbot
  rsrs choose results/flockbot
  rsrs diagram results/flockbot -o flockbot.svg
  rsrs run launch_configs/experiments/flockbot_milling.yaml --from results/flockbot

Exit codes: 0 done, 1 failed, 2 bad arguments, 3 done with a negative answer.";

#[derive(Subcommand)]
enum Command {
    DryRun(commands::dry_run::Arguments),
    Sweep(commands::sweep::Arguments),
    Diagram(commands::diagram::Arguments),
    Choose(commands::choose::Arguments),
    Run(commands::run::Arguments),
    Label(commands::label::Arguments),
    Compare(commands::compare::Arguments),
    Node(commands::node::Arguments),
    Completions(commands::completions::Arguments),
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let result = match &arguments.command {
        Command::DryRun(arguments) => commands::dry_run::run(arguments),
        Command::Sweep(arguments) => commands::sweep::run(arguments),
        Command::Diagram(arguments) => commands::diagram::run(arguments),
        Command::Choose(arguments) => commands::choose::run(arguments),
        Command::Run(arguments) => commands::run::run(arguments),
        Command::Label(arguments) => commands::label::run(arguments),
        Command::Compare(arguments) => commands::compare::run(arguments),
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
