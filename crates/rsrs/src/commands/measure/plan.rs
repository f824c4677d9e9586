//! `rsrs measure plan`: which trials are worth running.

use std::path::PathBuf;

use rsrs_core::numerals::counted;
use rsrs_core::trials::plan::{Plan, PlanRequest};

use crate::commands::{Format, report};
use crate::failure::{Outcome, bad_arguments};
use rsrs_pipeline::measure::plan_folder::{enabled_robots, write};
use rsrs_render::driven_trials::planned;

/// List the trials that are worth running, and make the tables to fill in.
///
/// Robots are spread over the fleet, commands over the safe limits, each repeated as often as the
/// wanted precision takes. The defaults are the paper's procedure with a Flockbot.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs measure plan --robots 5 --speed 0.05,0.30 --turn-rate 0.25,2.0
  rsrs measure plan launch_configs/fleets/nine_virtual.yaml -o trials
  rsrs measure plan fleet.yaml --speed 0.05,0.30 --turn-rate 0.25,2.0 -o trials")]
pub struct Arguments {
    /// Fleet file (YAML); it needs no profile yet. Without one, the robots are `robot_1` and so on.
    fleet: Option<PathBuf>,
    /// Robots to measure at most (default: 5).
    #[arg(long, value_name = "N")]
    robots: Option<usize>,
    /// Least and greatest safe speed, in m/s (default: 0.02,0.3).
    #[arg(long, value_name = "LOW,HIGH", value_parser = limits)]
    speed: Option<[f64; 2]>,
    /// Least and greatest safe turning rate, in rad/s (default: 0.1,2.5).
    #[arg(long, value_name = "LOW,HIGH", value_parser = limits)]
    turn_rate: Option<[f64; 2]>,
    /// Commands of each kind, evenly spaced within the limits (default: 5).
    #[arg(long, value_name = "N")]
    commands: Option<usize>,
    /// Half of the width of the 95 % interval of each robot's gain (default: 0.02).
    #[arg(long, value_name = "GAIN")]
    precision: Option<f64>,
    /// Spread of the gain between trials that is expected (default: 0.02).
    #[arg(long, value_name = "GAIN")]
    trial_sd: Option<f64>,
    /// Length of the straight track, in m (default: 2).
    #[arg(long, value_name = "M")]
    track: Option<f64>,
    /// How far the sensor is expected to reach, centre to centre, in m (default: 0.75).
    #[arg(long, value_name = "M")]
    range: Option<f64>,
    /// How far to each side the sensor is expected to see, in rad (default: 0.35).
    #[arg(long, value_name = "RAD")]
    half_angle: Option<f64>,
    /// Interval of its readings, in s: the control period (default: 0.13).
    #[arg(long, value_name = "S")]
    period: Option<f64>,
    /// Radius of a robot's body, in m; no two centres come nearer than twice that (default: 0.075).
    #[arg(long, value_name = "M")]
    radius: Option<f64>,
    /// Distances of the detection grid (default: about one in each body, 5 to 15).
    #[arg(long, value_name = "N")]
    distances: Option<usize>,
    /// Bearings of the detection grid (default: 9).
    #[arg(long, value_name = "N")]
    bearings: Option<usize>,
    /// Half of the width of the 95 % interval of each rate of detections (default: 0.1).
    #[arg(long, value_name = "SHARE")]
    rate_precision: Option<f64>,
    /// Folder to make for the sheet and the tables; it must not exist.
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

fn limits(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|number| number.trim().parse().map_err(|error| format!("`{number}`: {error}")))
        .collect::<Result<_, _>>()?;
    numbers.try_into().map_err(|found: Vec<f64>| {
        let found = counted(found.len() as u64, "number");
        format!("found {found}, expected the least and the greatest: 0.02,0.3")
    })
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let plan = Plan::new(request(arguments)?).map_err(|error| bad_arguments(error.into()))?;
    let mut text = plan.text();
    if let Some(folder) = &arguments.output {
        write(folder, &plan)?;
        text.push_str(&planned(folder, arguments.fleet.as_deref(), arguments.radius));
    }
    report(arguments.format, &plan, &text)?;
    Ok(Outcome::Done)
}

fn request(arguments: &Arguments) -> anyhow::Result<PlanRequest> {
    let usual = PlanRequest::default();
    let n_robots = arguments.robots.unwrap_or(usual.n_robots);
    let robots = match &arguments.fleet {
        Some(fleet) => enabled_robots(fleet)?,
        None => (1..=n_robots).map(|robot| format!("robot_{robot}")).collect(),
    };
    Ok(PlanRequest {
        robots,
        n_robots,
        limits_m_s: arguments.speed.unwrap_or(usual.limits_m_s),
        limits_rad_s: arguments.turn_rate.unwrap_or(usual.limits_rad_s),
        n_commands: arguments.commands.unwrap_or(usual.n_commands),
        track_m: arguments.track.unwrap_or(usual.track_m),
        gain_precision: arguments.precision.unwrap_or(usual.gain_precision),
        trial_sd: arguments.trial_sd.unwrap_or(usual.trial_sd),
        rate_precision: arguments.rate_precision.unwrap_or(usual.rate_precision),
        range_m: arguments.range.unwrap_or(usual.range_m),
        half_angle_rad: arguments.half_angle.unwrap_or(usual.half_angle_rad),
        radius_m: arguments.radius.unwrap_or(usual.radius_m),
        period_s: arguments.period.unwrap_or(usual.period_s),
        n_distances: arguments.distances,
        n_bearings: arguments.bearings.unwrap_or(usual.n_bearings),
    })
}
