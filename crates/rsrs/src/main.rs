//! The command line of RSRS: one file for each subcommand.

mod bag_arguments;
mod command_line;
mod commands;
mod experiment_arguments;
mod experiment_bar;
mod failure;
mod fleet_network;
mod interrupt;
mod keyboard;
mod notes;
mod numbers;
mod output;
mod page_arguments;
mod pose_arguments;
mod profile_arguments;
mod progress;
mod progress_log;
mod question;
mod setting_arguments;
mod starter_files;
mod threads_argument;
mod watch;
mod wheel_arguments;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use rsrs_core::program;

use crate::failure::Outcome;
use crate::output::Output;

/// From paper to floor: simulate a robot swarm worse than it is, and find where it mills.
#[derive(Parser)]
#[command(version, max_term_width = 100, help_expected = true, after_help = EXAMPLES)]
struct Arguments {
    #[command(flatten)]
    output: Output,
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

Exit codes: 0 done, 1 failed, 2 bad arguments, 3 done with a negative answer, 130 Ctrl-C.";

#[derive(Subcommand)]
enum Command {
    DryRun(commands::dry_run::Arguments),
    Init(commands::init::Arguments),
    Schema(commands::schema::Arguments),
    #[command(subcommand)]
    Measure(commands::measure::Command),
    Validate(commands::validate::Arguments),
    Sweep(commands::sweep::Arguments),
    Merge(commands::merge::Arguments),
    Diagram(commands::diagram::Arguments),
    Diff(commands::diff::Arguments),
    Episode(commands::episode::Arguments),
    Choose(commands::choose::Arguments),
    Answer(commands::answer::Arguments),
    Diagnose(commands::diagnose::Arguments),
    Explore(commands::explore::Arguments),
    PlanExperiments(commands::plan_experiments::Arguments),
    Run(commands::run::Arguments),
    Campaign(commands::campaign::Arguments),
    Place(commands::place::Arguments),
    Watch(commands::watch::Arguments),
    Stop(commands::stop::Arguments),
    #[command(subcommand)]
    Keystore(commands::keystore::Command),
    Label(commands::label::Arguments),
    Draw(commands::draw::Arguments),
    Film(commands::film::Arguments),
    #[command(subcommand)]
    Bag(commands::bag::Command),
    Replay(commands::replay::Arguments),
    Compare(commands::compare::Arguments),
    Report(commands::report::Arguments),
    Node(commands::node::Arguments),
    Completions(commands::completions::Arguments),
}

fn main() -> ExitCode {
    program::set_commit(env!("RSRS_COMMIT"));
    let arguments: Arguments = match command_line::parse() {
        Ok(arguments) => arguments,
        Err(code) => return code,
    };
    arguments.output.apply();
    let result = match &arguments.command {
        Command::DryRun(arguments) => commands::dry_run::run(arguments),
        Command::Init(arguments) => commands::init::run(arguments),
        Command::Schema(arguments) => commands::schema::run::<Arguments>(arguments),
        Command::Measure(arguments) => commands::measure::run(arguments),
        Command::Validate(arguments) => commands::validate::run(arguments),
        Command::Sweep(arguments) => commands::sweep::run(arguments),
        Command::Merge(arguments) => commands::merge::run(arguments),
        Command::Diagram(arguments) => commands::diagram::run(arguments),
        Command::Diff(arguments) => commands::diff::run(arguments),
        Command::Episode(arguments) => commands::episode::run(arguments),
        Command::Choose(arguments) => commands::choose::run(arguments),
        Command::Answer(arguments) => commands::answer::run(arguments),
        Command::Diagnose(arguments) => commands::diagnose::run(arguments),
        Command::Explore(arguments) => commands::explore::run(arguments),
        Command::PlanExperiments(arguments) => commands::plan_experiments::run(arguments),
        Command::Run(arguments) => commands::run::run(arguments),
        Command::Campaign(arguments) => commands::campaign::run(arguments),
        Command::Place(arguments) => commands::place::run(arguments),
        Command::Watch(arguments) => commands::watch::run(arguments),
        Command::Stop(arguments) => commands::stop::run(arguments),
        Command::Keystore(arguments) => commands::keystore::run(arguments),
        Command::Label(arguments) => commands::label::run(arguments),
        Command::Draw(arguments) => commands::draw::run(arguments),
        Command::Film(arguments) => commands::film::run(arguments),
        Command::Bag(arguments) => commands::bag::run(arguments),
        Command::Replay(arguments) => commands::replay::run(arguments),
        Command::Compare(arguments) => commands::compare::run(arguments),
        Command::Report(arguments) => commands::report::run(arguments),
        Command::Node(arguments) => commands::node::run(arguments),
        Command::Completions(arguments) => commands::completions::run::<Arguments>(arguments),
    };
    rsrs_ros::shutdown::leave(match result {
        Ok(Outcome::Done) => 0,
        Ok(Outcome::NegativeAnswer) => 3,
        Err(error) => {
            let code = failure::report_error(error);
            interrupt::exit_code().unwrap_or(code)
        }
    })
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use clap::CommandFactory;

    use super::Arguments;

    /// Flags whose values are written in another way in a command: what they hold is a table there, or two
    /// bounds, or another thing of that name.
    const OTHERWISE: [(&str, &[&str]); 9] = [
        ("commands", &["N"]),
        ("output", &["BAG", "PROFILE", "FILE"]),
        ("period", &["CSV"]),
        ("robots", &["NAME,…"]),
        ("speed", &["CSV", "LOW,HIGH"]),
        ("trajectories", &["CSV|BAG"]),
        ("turn", &["CSV"]),
        ("turn-rate", &["LOW,HIGH"]),
        ("width", &["PX", "SHARE"]),
    ];

    #[test]
    fn a_flag_means_one_thing() {
        let mut values: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        let mut commands = vec![Arguments::command()];
        while let Some(command) = commands.pop() {
            commands.extend(command.get_subcommands().cloned());
            for argument in command.get_arguments().filter(|it| it.get_action().takes_values()) {
                let Some(flag) = argument.get_long() else { continue };
                let names = argument.get_value_names().unwrap_or_default();
                let names: Vec<&str> = names.iter().map(clap::builder::Str::as_str).collect();
                values.entry(flag.to_owned()).or_default().insert(names.join(" "));
            }
        }
        assert!(values.len() > 50, "found only {values:?}");
        for (flag, otherwise) in OTHERWISE {
            let names = values.get_mut(flag).unwrap_or_else(|| panic!("there is no --{flag}"));
            names.retain(|name| !otherwise.contains(&name.as_str()));
        }

        values.retain(|_, names| names.len() > 1);

        assert!(values.is_empty(), "flags with several meanings: {values:?}");
    }
}
