//! `rsrs measure drive`: trials over ROS 2 under the lease, recorded.

mod operator;
mod placing;

use std::num::ParseFloatError;
use std::path::PathBuf;

use rsrs_core::bounds::Bounds;
use rsrs_core::robot::controller::ControllerParameters;
use rsrs_core::trials::trial::{Neighbour, Trial};
use rsrs_experiment_runner::backends;
use rsrs_fleet::record::Backend;
use rsrs_operate::drive::{DriveOptions, SingleTrial, drive, fill_plan, fill_table};

use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::fleet_network::{InterfaceArguments, enter};
use placing::Placing;
use rsrs_render::driven_trials;

/// Drive one trial, or all trials of a plan, recorded in bags: a robot moves by one constant command,
/// or stands and senses.
///
/// The command is sent under the run's lease, so a silent runner stops the robot. What the robot did
/// is read from its poses if they are published; otherwise you are asked for what tape and
/// stopwatch show. With `--distance` and `--bearing` it stands while another robot stands there (on
/// the fleet you are shown where to put it), and its detections are counted; with `--alone` they
/// are false ones.
///
/// `--plan` and `--template` fill in tables, and `--table` adds to one: each row states what moved the
/// robot, and trials of the simulator are not added to those of robots.
///
/// `--plan` makes all trials of a folder of `rsrs measure plan` that are not in its tables yet, and
/// those in which commands paused; `--template` those of one table. If killed, they go on when typed
/// again.
///
/// On the fleet, this command is the robots' controller. A robot with `lease: gate` needs its node
/// running without one (`rsrs node robot --without-controller …`); one with `lease: controller` needs
/// nothing of ours. A robot that was not measured yet needs no profile in the fleet file. Clear the
/// floor ahead: the robot reacts to nothing.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs measure drive launch_configs/fleets/nine_virtual.yaml --robot robot_1 \\
      --speed 0.15 --duration 20
  rsrs measure drive fleet.yaml --robot robot_3 --turn-rate 0.75 --duration 10 --backend fleet \\
      --interface wlan0 --table turn.csv
  rsrs measure drive fleet.yaml --robot robot_3 --distance 0.4 --bearing 0.2 --backend fleet \\
      --interface wlan0 --table detection.csv
  rsrs measure drive fleet.yaml --plan trials --backend fleet --interface wlan0
  rsrs measure drive fleet.yaml --template trials/detection.csv --backend fleet --interface wlan0
  rsrs measure fit --bags trial_* --name flockbot -o flockbot.yaml")]
pub struct Arguments {
    /// Fleet file (YAML).
    fleet: PathBuf,
    /// The robot that moves, or that senses.
    #[arg(long, value_name = "NAME", required_unless_present_any = ["template", "plan"])]
    robot: Option<String>,
    /// Forward speed, in m/s (default: 0, a turn in place).
    #[arg(
        long,
        value_name = "M_PER_S",
        required_unless_present_any = ["turn_rate", "distance", "alone", "template", "plan"],
        allow_negative_numbers = true
    )]
    speed: Option<f64>,
    /// Turning rate counterclockwise, in rad/s (default: 0, a straight run).
    #[arg(long, value_name = "RAD_PER_S", allow_negative_numbers = true)]
    turn_rate: Option<f64>,
    /// How long it moves, in s.
    #[arg(
        long,
        value_name = "S",
        required_unless_present_any = ["distance", "alone", "template", "plan"]
    )]
    duration: Option<f64>,
    /// Stand, with another robot at this distance, centre to centre, in m.
    #[arg(long, value_name = "M", requires = "bearing", conflicts_with_all = ["speed", "turn_rate", "duration"])]
    distance: Option<f64>,
    /// Bearing of the other robot, left is positive, in rad.
    #[arg(long, value_name = "RAD", requires = "distance", allow_negative_numbers = true)]
    bearing: Option<f64>,
    /// Stand, with nothing to be detected.
    #[arg(long, conflicts_with_all = ["speed", "turn_rate", "duration", "distance"])]
    alone: bool,
    /// Readings of a robot that stands (default: 100).
    #[arg(long, value_name = "N", default_value = "100", hide_default_value = true, value_parser = clap::value_parser!(u64).range(1..=MOST_SAMPLES))]
    samples: u64,
    /// Folder of `rsrs measure plan`: make all trials that are not in its tables yet, and fill in each
    /// row as soon as it is measured.
    #[arg(
        long,
        value_name = "DIR",
        requires = "backend",
        conflicts_with_all = ["robot", "speed", "turn_rate", "duration", "distance", "alone", "table", "template"]
    )]
    plan: Option<PathBuf>,
    /// One table of `rsrs measure plan`: fill in all rows that have no result, each as soon as it is
    /// known.
    #[arg(
        long,
        value_name = "CSV",
        requires = "backend",
        conflicts_with_all = ["robot", "speed", "turn_rate", "duration", "distance", "alone", "table"]
    )]
    template: Option<PathBuf>,
    /// Program that places the robots of the fleet before each trial, instead of asking you: it gets
    /// one line of JSON on its standard input (docs/campaigns.md).
    #[arg(long, value_name = "PROGRAM")]
    place_command: Option<String>,
    /// Do not ask before the robots of a plan drive: the floor around them is clear wherever they are.
    #[arg(long)]
    yes: bool,
    /// Interval of the detections of a robot without a profile, in s (default: as measured in the
    /// plan's trials so far, else 0.13).
    #[arg(long, value_name = "S", value_parser = period)]
    period: Option<f64>,
    /// What moves the robot (default: sim); required if results go into tables, where each row states
    /// it.
    #[arg(long, value_parser = backends("The simulator, in a network of its own"))]
    backend: Option<Backend>,
    #[command(flatten)]
    network: InterfaceArguments,
    /// Seed of the simulated robot (default: 1); each seed is another trial.
    #[arg(long, value_name = "SEED", default_value = "1", hide_default_value = true, value_parser = clap::value_parser!(u64).range(..rsrs_core::diagram::sweep_file::SEED_LIMIT))]
    seed: u64,
    /// Folder of the bag; it must not exist (default: named after the run, in this folder). For a
    /// plan or a template, the folder of all its bags (default: `bags` in the plan's folder; named
    /// after the table, beside it).
    #[arg(short, long, value_name = "BAG")]
    output: Option<PathBuf>,
    /// Table of straight runs, turns, arcs or detections to add the result to; made if it is not there.
    #[arg(long, value_name = "CSV", requires = "backend")]
    table: Option<PathBuf>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// Readings beyond this add nothing about a sensor.
const MOST_SAMPLES: u64 = 1_000_000;

fn period(text: &str) -> Result<f64, String> {
    let period_s: f64 = text.parse().map_err(|error: ParseFloatError| error.to_string())?;
    if Bounds::PERIOD.contains(period_s) {
        return Ok(period_s);
    }
    let Bounds { least, most } = Bounds::PERIOD;
    Err(format!("expected seconds, {least} to {most}"))
}

impl Arguments {
    fn backend(&self) -> Backend {
        self.backend.unwrap_or(Backend::Simulator)
    }
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let options = DriveOptions {
        fleet: arguments.fleet.clone(),
        backend: arguments.backend(),
        output: arguments.output.clone(),
        seed: arguments.seed,
        period_s: arguments.period,
    };
    let enter = || enter(arguments.backend(), &arguments.network.interface);
    let placing = Placing::new(arguments)?;
    if let Some(filled) = match (&arguments.plan, &arguments.template) {
        (Some(folder), _) => Some(fill_plan(&options, folder, enter, &placing)?),
        (None, Some(table)) => Some(fill_table(&options, table, enter, &placing)?),
        (None, None) => None,
    } {
        report(arguments.format, &filled, driven_trials::filled(&filled))?;
        return Ok(if filled.is_whole() { Outcome::Done } else { Outcome::NegativeAnswer });
    }
    let trial = asked(arguments);
    let robot = arguments.robot.as_deref().unwrap_or_default();
    // Who drives one robot by hand stands beside it.
    let asks = !matches!((&placing, trial), (Placing::Person { .. }, Trial::Drive { .. }));
    let single = SingleTrial { robot, trial, table: arguments.table.as_deref(), asks };
    let made = drive(&options, single, enter, &placing)?;
    let Some((found, summary)) = made else {
        return Ok(Outcome::Done);
    };
    let text = driven_trials::single(&found.bag, &found.table(), found.paused_s);
    report(arguments.format, &found, text)?;
    let is_whole = summary.n_lost == 0 && found.paused_s.is_none();
    Ok(if is_whole { Outcome::Done } else { Outcome::NegativeAnswer })
}

/// The trial that the command line itself asks for.
fn asked(arguments: &Arguments) -> Trial {
    if let Some(duration_s) = arguments.duration {
        let command = ControllerParameters::mirrored(
            arguments.speed.unwrap_or(0.0),
            arguments.turn_rate.unwrap_or(0.0),
        );
        return Trial::Drive { command, duration_s };
    }
    let place = arguments.distance.zip(arguments.bearing);
    let neighbour = place.map(|(distance_m, bearing_rad)| Neighbour { distance_m, bearing_rad });
    Trial::Stand { neighbour, samples: arguments.samples }
}
