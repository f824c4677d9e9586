//! `rsrs measure drive`: one trial on one robot, over ROS 2 under the lease, recorded.

mod operator;
mod result;

use std::path::PathBuf;

use rsrs_core::controller::ControllerParameters;
use rsrs_experiment_runner::plan::{Plan, TrialRequest};
use rsrs_fleet::fleet_file::CmdVel;
use rsrs_fleet::record::{self, EndingKind};
use rsrs_ros::interfaces;
use rsrs_ros::logging::{self, Level};
use rsrs_ros::session::SessionOptions;

use crate::commands::run::{
    Backend, RunSummary, asked_to_stop, chosen_network, on_simulated_fleet, runtime, say_note,
    watched,
};
use crate::commands::{Format, report};
use crate::failure::{Outcome, with_help};
use crate::node_process::NodeProcess;
use crate::own_network::OwnNetwork;
use crate::simulated_fleet::{CONSTANT, SimulatedFleet};
use result::TrialResult;

/// Drive one trial: one robot, one constant command, recorded in a bag.
///
/// The command is sent under the run's lease, so a silent runner stops the robot. What the robot did
/// is read from its poses if they are published; otherwise you are asked what tape and stopwatch say.
/// A robot of the fleet needs its node running without a controller (`rsrs node robot
/// --without-controller …`): this command is the controller. Clear the floor ahead: the robot
/// reacts to nothing.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs measure drive launch_configs/fleets/nine_virtual.yaml --robot robot_1 --speed 0.15 --duration 20
  rsrs measure drive fleet.yaml --robot robot_3 --turn-rate 0.75 --duration 10 --backend fleet \\
      --interface wlan0 --table turn.csv
  rsrs measure fit --bags trial_* --detection detection.csv --name flockbot -o flockbot.yaml")]
pub struct Arguments {
    /// Fleet file (YAML).
    fleet: PathBuf,
    /// The robot to drive.
    #[arg(long, value_name = "NAME")]
    robot: String,
    /// Forward speed, in m/s (default: 0, a turn in place).
    #[arg(
        long,
        value_name = "M_PER_S",
        required_unless_present = "turn_rate",
        allow_negative_numbers = true
    )]
    speed: Option<f64>,
    /// Turning rate counterclockwise, in rad/s (default: 0, a straight run).
    #[arg(long, value_name = "RAD_PER_S", allow_negative_numbers = true)]
    turn_rate: Option<f64>,
    /// How long, in s.
    #[arg(long, value_name = "S")]
    duration: f64,
    /// What moves the robot (default: sim).
    #[arg(long, value_enum, default_value = "sim", hide_default_value = true)]
    backend: Backend,
    /// Network interface of the fleet, by name or address (or `RSRS_INTERFACE`).
    #[arg(long, value_name = "NAME|IP")]
    interface: Option<String>,
    /// Seed of the simulated robot (default: 1); each seed is another trial.
    #[arg(long, value_name = "SEED", default_value = "1", hide_default_value = true, value_parser = clap::value_parser!(u64).range(..rsrs_core::sweep_file::SEED_LIMIT))]
    seed: u64,
    /// Folder of the bag; it must not exist (default: named after the run, in this folder).
    #[arg(short, long, value_name = "BAG")]
    output: Option<PathBuf>,
    /// Table of straight runs or of turns to add the result to; made if it is not there.
    #[arg(long, value_name = "CSV")]
    table: Option<PathBuf>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// Runs the command.
///
/// # Errors
///
/// If a file is wrong, something is missing at preflight, the run was not completed, or nobody says
/// how far the robot came.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let plan = Plan::of_trial(&request(arguments))?;
    if let Some(table) = &arguments.table {
        result::check_table(table, plan.record.conditions.controller)?;
    }
    let summary = match arguments.backend {
        Backend::Sim => {
            // Before the first thread is started.
            let network = OwnNetwork::enter()?;
            logging::init(Level::Warn, std::env::var("RUST_LOG").ok().as_deref());
            runtime()?.block_on(simulated(&plan, &network))?
        }
        Backend::Fleet => {
            logging::init(Level::Warn, std::env::var("RUST_LOG").ok().as_deref());
            let network = chosen_network(arguments.interface.as_deref())?;
            runtime()?.block_on(on_fleet(&plan, &network))?
        }
    };
    let bag = completed(&plan, &summary)?;
    let found = match TrialResult::of_bag(&bag, &plan)? {
        Some(found) => found,
        None => operator::ask(&bag, &plan)?,
    };
    if let Some(table) = &arguments.table {
        found.append_to(table)?;
    }
    report(arguments.format, &found, &found.text())?;
    Ok(if summary.n_lost == 0 { Outcome::Done } else { Outcome::NegativeAnswer })
}

fn request(arguments: &Arguments) -> TrialRequest {
    TrialRequest {
        fleet: arguments.fleet.clone(),
        robot: arguments.robot.clone(),
        command: ControllerParameters {
            speed_m_s: arguments.speed.unwrap_or(0.0),
            turn_rate_rad_s: arguments.turn_rate.unwrap_or(0.0),
        },
        duration_s: arguments.duration,
        backend: match arguments.backend {
            Backend::Sim => record::Backend::Simulator,
            Backend::Fleet => record::Backend::Fleet,
        },
        bag: arguments.output.clone(),
        seed: arguments.seed,
    }
}

async fn simulated(plan: &Plan, network: &OwnNetwork) -> anyhow::Result<RunSummary> {
    let mut fleet = SimulatedFleet::start_constant(network, &plan.record.robots)?;
    let summary = on_simulated_fleet(plan, network, &mut fleet).await;
    fleet.stop().await?;
    summary
}

async fn on_fleet(plan: &Plan, network: &SessionOptions) -> anyhow::Result<RunSummary> {
    let mut parameters = CONSTANT.to_vec();
    if plan.robots[0].cmd_vel == CmdVel::Twist {
        parameters.extend(["-p", "cmd_vel_type:=twist"]);
    }
    let address = network.interfaces.first().map(ToString::to_string).unwrap_or_default();
    let start = |command: &mut std::process::Command| {
        command.env(interfaces::VARIABLE, address);
    };
    let mut controller = NodeProcess::start("controller", &plan.record.robots, &parameters, start)?;
    let stop = async {
        tokio::select! {
            reason = asked_to_stop() => reason,
            reason = controller.ended() => reason,
        }
    };
    let summary = watched(plan, network, stop).await;
    controller.stop().await?;
    summary
}

/// The bag of a run that was completed.
fn completed(plan: &Plan, summary: &RunSummary) -> anyhow::Result<PathBuf> {
    if !summary.not_standing.is_empty() {
        say_note(&format!(
            "not confirmed to stand, go and look: {}",
            summary.not_standing.join(", ")
        ));
    }
    match &summary.bag {
        Some(bag) if summary.ending == EndingKind::Completed.key() => Ok(bag.clone()),
        _ => {
            let robot = &plan.robots[0].name;
            let message =
                format!("trial {}: {}", summary.ending, summary.reason.replace("; ", "\n  "));
            Err(with_help(
                message,
                format!(
                    "a robot of the fleet needs its node, without its controller: \
                     `rsrs node robot --robots {robot} --without-controller …`"
                ),
            ))
        }
    }
}
