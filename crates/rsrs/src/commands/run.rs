//! `rsrs run`: step 4, one experiment over ROS 2, recorded.

use std::path::PathBuf;

use rsrs_experiment_runner::plan::{Plan, Request};
use rsrs_experiment_runner::{backends, place_checks};
use rsrs_fleet::placement::PlaceCheck;
use rsrs_fleet::record::Backend;

use crate::commands::{Format, report};
use crate::experiment_arguments::ExperimentArguments;
use crate::experiment_bar::TerminalOperator;
use crate::failure::Outcome;
use crate::fleet_network::{InterfaceArguments, enter, other_middleware, refuse_flags_of_a_fleet};
use crate::notes::print_always;
use crate::profile_arguments::ProfileArguments;
use rsrs_operate::run::{on_target, refuse_unfinished};
use rsrs_render::run_summary::{text, unconfirmed};
use rsrs_ros::runtime::runtime;

/// Run one experiment over ROS 2, and record it.
///
/// With the simulator, everything that the run needs is started and ended with it, in a network of its
/// own. With the fleet, the robots' nodes must be running, and `--interface` names their network; a
/// countdown of 3 s comes before the robots move, and Ctrl-C stops them at any time. Exit code 3 means
/// that the run ended but does not count, that a robot is not confirmed to stand, or that data was
/// lost: on a topic that must lose none, or because the recorder did not keep up.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs run launch_configs/experiments/flockbot_milling.yaml -o milling
  rsrs run launch_configs/experiments/flockbot_milling.yaml --from results/flockbot
  rsrs run milling.yaml --backend fleet --interface wlan0
  rsrs run milling.yaml --backend fleet --interface wlan0 --place-command './drive_to_places.py'")]
pub struct Arguments {
    #[command(flatten)]
    setup: ExperimentArguments,
    /// What moves the robots (default: sim).
    #[arg(long, value_parser = backends("The simulator, in a network of its own"), default_value = "sim", hide_default_value = true)]
    backend: Backend,
    #[command(flatten)]
    network: InterfaceArguments,
    /// Seed of the simulated world (default: the experiment file's).
    #[arg(long, value_name = "SEED", value_parser = clap::value_parser!(u64).range(..rsrs_core::diagram::sweep_file::SEED_LIMIT))]
    seed: Option<u64>,
    /// Program that places the robots of a fleet before the run: it gets one line of JSON on its
    /// standard input; another exit code than 0 stops the run (docs/campaigns.md).
    #[arg(long, value_name = "PROGRAM")]
    place_command: Option<String>,
    /// What to do, before a fleet moves, about robots that do not stand where they should (default: on).
    #[arg(long, value_parser = place_checks())]
    place_check: Option<PlaceCheck>,
    #[command(flatten)]
    other: ProfileArguments,
    /// Folder of the bag; it must not exist (default: named after the run, in this folder).
    #[arg(short, long, value_name = "BAG")]
    output: Option<PathBuf>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    refuse_flags_of_a_fleet(
        arguments.backend,
        &arguments.network,
        arguments.place_command.as_deref(),
        arguments.place_check,
    )?;
    let plan = Plan::read(&Request {
        experiment: arguments.setup.experiment.clone(),
        cell: arguments.setup.cell.clone(),
        from: arguments.setup.from.clone(),
        backend: arguments.backend,
        bag: arguments.output.clone(),
        seed: arguments.seed,
        place_check: arguments.place_check.unwrap_or_default(),
        other_profile: arguments.other.profile(),
    })?;
    let place_command = arguments.place_command.as_deref();
    let target = enter(arguments.backend, &arguments.network.interface)?;
    let summary =
        runtime()?.block_on(on_target(&plan, &target, place_command, &TerminalOperator))?;
    if !summary.not_standing.is_empty() {
        print_always(unconfirmed(&summary.not_standing));
    }
    refuse_unfinished(&summary, other_middleware())?;
    report(arguments.format, &summary, text(&summary, &plan.record, arguments.seed))?;
    Ok(if summary.is_whole(&plan.record) { Outcome::Done } else { Outcome::NegativeAnswer })
}
