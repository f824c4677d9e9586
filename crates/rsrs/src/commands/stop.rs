//! `rsrs stop`: stops every robot, whatever runs, and waits until each reports it.

use std::path::PathBuf;

use rsrs_fleet::stopper::StopCommand;
use rsrs_ros::logging::{self, Level};
use rsrs_ros::security::Member;

use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::fleet_network::{InterfaceArguments, chosen_network, other_middleware};
use crate::interrupt::requested;
use crate::notes::print_always;
use rsrs_operate::stop::command_all;
use rsrs_pipeline::measure::plan_folder::enabled_robots;
use rsrs_render::stop::{Named, next, table};
use rsrs_ros::runtime::runtime;

/// Stop every robot; return when all have acknowledged.
///
/// Needs no runner. Robots are found by their statuses and by leases; `--fleet` names those that should
/// be there. The robots stay locked after the command has ended: no run starts before `rsrs stop
/// --release`, and robots that were stopped in a run stand until a new run arms them. No other
/// publisher on the e-stop topic can undo it; a release names those that still hold it. Exit code 3
/// means that a robot has not acknowledged within 7 s (10 s in a secured fleet, which needs the enclave
/// `/stop`: docs/security.md): go and look.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs stop --interface wlan0
  rsrs stop --interface wlan0 --fleet launch_configs/fleets/nine_virtual.yaml
  rsrs stop --interface wlan0 --release")]
pub struct Arguments {
    #[command(flatten)]
    network: InterfaceArguments,
    /// Fleet file (YAML): its enabled robots must acknowledge, seen or not.
    #[arg(long, value_name = "FLEET")]
    fleet: Option<PathBuf>,
    /// Release the lock instead; refused while robots are in a run.
    #[arg(long)]
    release: bool,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    logging::init(Level::Warn);
    rsrs_ros::session::start_again_after_deadlock();
    let network = chosen_network(&arguments.network.interface, Member::Stop)?;
    let robots = arguments.fleet.as_deref().map_or_else(|| Ok(Vec::new()), enabled_robots)?;
    let command = if arguments.release { StopCommand::Release } else { StopCommand::Engage };
    let summary = runtime()?
        .block_on(async { command_all(&network, command, &robots, requested()).await })?;
    report(arguments.format, &summary, table(&summary))?;
    let named = if robots.is_empty() { Named::Nobody } else { Named::ByFleetFile };
    let other_middleware = other_middleware().map(|other| other.to_string());
    print_always(next(&summary, named, other_middleware.as_deref()));
    Ok(if summary.acknowledged { Outcome::Done } else { Outcome::NegativeAnswer })
}
