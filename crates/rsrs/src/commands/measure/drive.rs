//! `rsrs measure drive`: trials over ROS 2 under the lease, recorded.

mod operator;
mod period_table;
mod placing;
mod planned;
mod result;
mod standing;
mod table_file;
mod trial_nodes;
mod trial_table;

use std::path::PathBuf;

use rsrs_core::controller::ControllerParameters;
use rsrs_core::trial::Neighbour;
use rsrs_experiment_runner::plan::{Plan, Trial, TrialRequest, Unmeasured};
use rsrs_fleet::record;

use crate::commands::{Backend, Format, report, runtime};
use crate::failure::Outcome;
use operator::Ready;
use placing::Placing;
use result::TrialResult;
use rsrs_pipeline::run::RunSummary;
use trial_nodes::{RunTarget, TrialNodes};

/// Drive one trial, or all trials of a plan, recorded in bags: a robot moves by one constant command,
/// or stands and senses.
///
/// The command is sent under the run's lease, so a silent runner stops the robot. What the robot did
/// is read from its poses if they are published; otherwise you are asked what tape and stopwatch say.
/// With `--distance` and `--bearing` it stands while another robot stands there (on the fleet you are
/// told where to put it), and its detections are counted; with `--alone` they are false ones.
///
/// `--plan` makes all trials of a folder of `rsrs measure plan` that are not in its tables yet, and
/// those in which commands paused; `--template` those of one table. Killed at any moment, the same
/// command goes on.
///
/// On the fleet, this command is the robots' controller. A robot with `lease: gate` needs its node
/// running without one (`rsrs node robot --without-controller …`); one with `lease: controller` needs
/// nothing of ours. A robot that was not measured yet needs no profile in the fleet file. Clear the
/// floor ahead: the robot reacts to nothing.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs measure drive launch_configs/fleets/nine_virtual.yaml --robot robot_1 --speed 0.15 --duration 20
  rsrs measure drive fleet.yaml --robot robot_3 --turn-rate 0.75 --duration 10 --backend fleet \\
      --interface wlan0 --table turn.csv
  rsrs measure drive fleet.yaml --robot robot_3 --distance 0.4 --bearing 0.2 --table detection.csv
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
        conflicts_with_all = ["robot", "speed", "turn_rate", "duration", "distance", "alone", "table", "template"]
    )]
    plan: Option<PathBuf>,
    /// One table of `rsrs measure plan`: fill in all rows that have no result, each as soon as it is
    /// known.
    #[arg(
        long,
        value_name = "CSV",
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
    /// What moves the robot (default: sim).
    #[arg(long, value_enum, default_value = "sim", hide_default_value = true)]
    backend: Backend,
    /// Network interface of the fleet, by name or address (or `RSRS_INTERFACE`).
    #[arg(long, value_name = "NAME|IP")]
    interface: Option<String>,
    /// Seed of the simulated robot (default: 1); each seed is another trial.
    #[arg(long, value_name = "SEED", default_value = "1", hide_default_value = true, value_parser = clap::value_parser!(u64).range(..rsrs_core::sweep_file::SEED_LIMIT))]
    seed: u64,
    /// Folder of the bag; it must not exist (default: named after the run, in this folder). For a
    /// plan, the folder of all its bags (default: `bags` in it); for a template, too (default: named
    /// after the table, beside it).
    #[arg(short, long, value_name = "BAG")]
    output: Option<PathBuf>,
    /// Table of straight runs, turns, arcs or detections to add the result to; made if it is not there.
    #[arg(long, value_name = "CSV")]
    table: Option<PathBuf>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// Readings beyond this say no more of a sensor.
const MOST_SAMPLES: u64 = 1_000_000;
/// Detections come this often where nothing else says it, in seconds: those of the Flockbot.
const USUAL_PERIOD_S: f64 = 0.13;
/// Nobody drives by detections that are rarer, in seconds.
const LONGEST_PERIOD_S: f64 = 2.0;

fn period(text: &str) -> Result<f64, String> {
    let period_s: f64 =
        text.parse().map_err(|error| format!("{error}, expected a number such as 0.13"))?;
    if period_s > 0.0 && period_s <= LONGEST_PERIOD_S {
        return Ok(period_s);
    }
    Err(format!("expected seconds, above 0 and at most {LONGEST_PERIOD_S}"))
}

/// Runs the command.
///
/// # Errors
///
/// If a file is wrong, something is missing at preflight, the run was not completed, or nobody says
/// how far the robot came.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    if let Some(folder) = &arguments.plan {
        return planned::fill_plan(arguments, folder);
    }
    if let Some(table) = &arguments.template {
        return planned::fill_table(arguments, table);
    }
    let request = usual_request(arguments, asked(arguments));
    let plan = Plan::of_trial(&request)?;
    if let Some(table) = &arguments.table {
        result::check_table(table, &request.trial)?;
    }
    let placing = Placing::new(arguments)?;
    let floor = RunTarget::enter(arguments.backend, arguments.interface.as_deref())?;
    let Some((found, summary)) = conduct((&placing, &floor), (&plan, request.trial))? else {
        return Ok(Outcome::Done);
    };
    if let Some(table) = &arguments.table {
        found.append_to(table)?;
    }
    report(arguments.format, &found, &found.text())?;
    let is_whole = summary.n_lost == 0 && found.paused_s.is_none();
    Ok(if is_whole { Outcome::Done } else { Outcome::NegativeAnswer })
}

/// Makes one trial; `None` if the operator does not want it.
fn conduct(
    (placing, floor): (&Placing, &RunTarget),
    (plan, trial): (&Plan, Trial),
) -> anyhow::Result<Option<(TrialResult, RunSummary)>> {
    let runtime = runtime()?;
    // Who drives one robot by hand stands beside it.
    let asks = !matches!((placing, trial), (Placing::Person { .. }, Trial::Drive { .. }));
    if asks && runtime.block_on(placing.ready(&plan.robots[0].name, &trial))? != Ready::Go {
        return Ok(None);
    }
    runtime.block_on(async {
        let mut trial_nodes = TrialNodes::start(floor, plan)?;
        let made = made(&mut trial_nodes, (plan, trial)).await;
        trial_nodes.stop().await?;
        made.map(Some)
    })
}

async fn made(
    trial_nodes: &mut TrialNodes<'_>,
    (plan, trial): (&Plan, Trial),
) -> anyhow::Result<(TrialResult, RunSummary)> {
    if let Trial::Stand { neighbour, samples } = trial {
        let (found, summary) = standing::stand(trial_nodes, plan, samples).await?;
        return Ok((TrialResult::of_readings(plan, neighbour, found), summary));
    }
    let summary = trial_nodes.conduct(plan).await?;
    let found = match TrialResult::of_bag(&plan.bag, plan)? {
        Some(found) => found,
        None => operator::ask(&plan.bag, plan).await?,
    };
    Ok((found, summary))
}

/// The trial that the command line itself asks for.
fn asked(arguments: &Arguments) -> Trial {
    if let Some(duration_s) = arguments.duration {
        let command = ControllerParameters {
            speed_m_s: arguments.speed.unwrap_or(0.0),
            turn_rate_rad_s: arguments.turn_rate.unwrap_or(0.0),
        };
        return Trial::Drive { command, duration_s };
    }
    let place = arguments.distance.zip(arguments.bearing);
    let neighbour = place.map(|(distance_m, bearing_rad)| Neighbour { distance_m, bearing_rad });
    Trial::Stand { neighbour, samples: arguments.samples }
}

/// A trial under what the command line says.
fn usual_request(arguments: &Arguments, trial: Trial) -> TrialRequest {
    TrialRequest {
        fleet: arguments.fleet.clone(),
        robot: arguments.robot.clone().unwrap_or_default(),
        trial,
        backend: match arguments.backend {
            Backend::Sim => record::Backend::Simulator,
            Backend::Fleet => record::Backend::Fleet,
        },
        bag: arguments.output.clone(),
        seed: arguments.seed,
        unmeasured: Unmeasured {
            limits: None,
            period_s: arguments.period.unwrap_or(USUAL_PERIOD_S),
        },
    }
}
