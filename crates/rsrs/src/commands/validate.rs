//! `rsrs validate`: step 2, are the real trajectories inside the simulated reach?

mod cause;
mod drawings;
mod text;

use std::path::{Path, PathBuf};

use rsrs_core::axis::{Axis, Cell};
use rsrs_core::capability::{self, CapabilityViolation, LostCapability};
use rsrs_core::conditions::Conditions;
use rsrs_core::fit::{SensorMap, sensor_map};
use rsrs_core::profile::RobotProfile;
use rsrs_core::trial::{DrivenTrial, detection_trials};
use rsrs_sim::reach::{ReachOptions, smallest_factors, validate};

use crate::commands::{Format, report};
use crate::failure::Outcome;
use rsrs_pipeline::error::{explained, with_help};
use rsrs_pipeline::measure::trial_files::{Trajectories, table, trajectories};
use rsrs_pipeline::provenance::Provenance;
use rsrs_pipeline::sweep::folder;
use rsrs_pipeline::sweep::result::SweepResult;
use rsrs_pipeline::sweep::source::ResolvedSweep;
use rsrs_pipeline::validation_file::{Answer, Judged};

/// Check that the simulated robot is worse than the real ones: step 2 of the method.
///
/// Simulated robots drive the commands of real trials; 99 % of them say where such a robot can be.
/// Real trials must lie inside at every time; robots that the simulator can be are refused in at most
/// 5 of 100 cases, because it is known how often they leave. So far apart as to contain anything says
/// nothing, so the area of every region is printed. The simulated robot must also be nowhere better
/// than its profile, and detections must not contradict its sensor. Exit code 3 says that one of
/// these does not hold. A robot that is worse in all of this does not by itself make reality at least
/// as good as the simulation; `rsrs compare` tests that.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs validate results/flockbot --trajectories tracker.csv --detection detection.csv
  rsrs validate sweep.yaml --trajectories drive_1 drive_2 -o validation
  rsrs validate results/flockbot --trajectories tracker.csv --format json")]
pub struct Arguments {
    /// Sweep file (YAML), or the folder of a sweep.
    sweep: PathBuf,
    /// Real trajectories of robots that drive alone:
    /// `robot,trial,time_s,x_m,y_m,heading_rad,commanded_m_s,commanded_rad_s`, or bags.
    #[arg(long, value_name = "CSV|BAG", num_args = 1.., required = true)]
    trajectories: Vec<PathBuf>,
    /// Detections: `robot,distance_m,bearing_rad,samples,detections`; no distance is no neighbour.
    #[arg(long, value_name = "CSV")]
    detection: Option<PathBuf>,
    /// Values on the capabilities that the sweep sweeps, as AXIS=VALUE,…: one robot is judged.
    #[arg(long, value_name = "AXIS=V")]
    at: Option<Cell>,
    /// Simulated robots, 200 or more (default: 2000).
    #[arg(long, value_name = "N")]
    robots: Option<usize>,
    /// How far measured positions may be off, in m (default: 0.005).
    #[arg(long, value_name = "M")]
    tolerance: Option<f64>,
    /// How far measured headings may be off, in rad (default: 0.01).
    #[arg(long, value_name = "RAD")]
    tolerance_heading: Option<f64>,
    /// Folder for validation.json and the pictures (default: the folder of the sweep, if it is one;
    /// then its diagram says so, too).
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// What is held against each other.
struct Case {
    source: ResolvedSweep,
    /// Conditions of the cells at which the simulated robot is judged; one or more.
    conditions: Vec<Conditions>,
    at: Cell,
    trials: Vec<DrivenTrial>,
    /// The same from their standstills, where that is known.
    from_rest: Vec<DrivenTrial>,
    sensor: Option<SensorMap>,
    options: ReachOptions,
}

/// Runs the command.
///
/// # Errors
///
/// If a file is wrong, or the sweep has several simulated robots and `--at` does not say which.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let swept = if arguments.sweep.is_dir() { Some(folder::read(&arguments.sweep)?) } else { None };
    let source = match &swept {
        Some(swept) => swept.source.clone(),
        None => ResolvedSweep::read(&arguments.sweep)?,
    };
    let case = case(arguments, source)?;
    let answer = judge(&case)?;
    match (&arguments.output, &swept) {
        (Some(folder), _) => {
            drawings::write(folder, &case, &answer)?;
            answer.write(folder)?;
        }
        (None, Some(swept)) => {
            drawings::write(&arguments.sweep, &case, &answer)?;
            note(&arguments.sweep, swept, &answer)?;
        }
        (None, None) => {}
    }
    report(arguments.format, &answer, &text::text(&answer))?;
    Ok(if answer.is_harsher { Outcome::Done } else { Outcome::NegativeAnswer })
}

/// Makes the answer known to the sweep: beside its files, and on its picture.
fn note(folder: &Path, swept: &SweepResult, answer: &Answer) -> anyhow::Result<()> {
    answer.write(folder)?;
    folder::draw(folder, swept)
}

fn case(arguments: &Arguments, source: ResolvedSweep) -> anyhow::Result<Case> {
    let name = arguments.sweep.display().to_string();
    let at = arguments.at.clone().unwrap_or_default();
    let conditions = judged_conditions(&name, &source, &at)?;
    let usual = ReachOptions::default();
    let options = ReachOptions {
        n_robots: arguments.robots.unwrap_or(usual.n_robots),
        tolerance_m: arguments.tolerance.unwrap_or(usual.tolerance_m),
        tolerance_rad: arguments.tolerance_heading.unwrap_or(usual.tolerance_rad),
        seed: source.sweep.seed,
        ..usual
    };
    let sensor = arguments
        .detection
        .as_ref()
        .map(|path| {
            let detections = table(path, detection_trials)?;
            sensor_map(&detections, source.profile.body.radius_m).map_err(|error| {
                let (message, help) = (error.to_string(), error.help());
                explained(error, message, Some(&help))
            })
        })
        .transpose()?;
    let Trajectories { driven: trials, from_rest } = trajectories(&arguments.trajectories)?;
    Ok(Case { source, conditions, at, trials, from_rest, sensor, options })
}

/// The cells at which the simulated robot is the one to be judged.
fn judged_conditions(
    file: &str,
    source: &ResolvedSweep,
    at: &Cell,
) -> anyhow::Result<Vec<Conditions>> {
    let swept = source.sweep.swept_axes();
    let keys = |axes: &[Axis]| axes.iter().map(|axis| axis.key()).collect::<Vec<_>>().join(", ");
    let capabilities: Vec<Axis> =
        swept.iter().copied().filter(|axis| axis.is_capability()).collect();
    if let Some((axis, _)) = at.iter().find(|(axis, _)| !capabilities.contains(axis)) {
        let have = if capabilities.is_empty() { "none".to_owned() } else { keys(&capabilities) };
        return Err(with_help(
            format!("{file}: {axis} is no capability that this sweep sweeps ({have})"),
            "leave it out of `--at`",
        ));
    }
    let open: Vec<Axis> = capabilities.into_iter().filter(|axis| at.get(*axis).is_none()).collect();
    if !open.is_empty() {
        let example: Vec<String> = open.iter().map(|axis| format!("{}=…", axis.key())).collect();
        return Err(with_help(
            format!("{file} sweeps {}, so it has several simulated robots", keys(&open)),
            format!("say which one to judge: `--at {}`", example.join(",")),
        ));
    }
    let is_at = |cell: &Cell| at.iter().all(|(axis, value)| cell.get(axis) == Some(value));
    let cells = source.cells(file)?.into_iter().filter(|(cell, _)| is_at(cell));
    let conditions: Vec<Conditions> = cells.map(|(_, conditions)| conditions).collect();
    if conditions.is_empty() {
        return Err(with_help(
            format!("{file} has no cell at {at}"),
            "give values that the sweep has",
        ));
    }
    Ok(conditions)
}

fn judge(case: &Case) -> anyhow::Result<Answer> {
    let source = &case.source;
    let (measured, factors) = (&source.profile, source.sweep.factors(&source.profile));
    let robot = factors.apply(measured)?;
    let settings = source.sweep.settings().with_cell(&case.at);
    let validation = validate(&robot, &settings, &case.trials, &case.options)?;
    let turning = if validation.is_contained {
        None
    } else {
        cause::turning((measured, factors), &settings, case)?
    };
    let smallest_factors = if validation.is_contained || turning.is_some() {
        None
    } else {
        smallest_factors((measured, factors), &settings, &case.trials, &case.options)?
            .map(|smallest| smallest.factors)
    };
    let capability_violations = better_capabilities(case)?;
    let sensor_violations = case
        .sensor
        .as_ref()
        .map(|map| capability::sensor_violations(map, &case.conditions[0].robot));
    let senses_worse = sensor_violations.as_ref().is_none_or(Vec::is_empty);
    Ok(Answer {
        judged: Judged::of(source, &case.at),
        is_harsher: validation.is_contained && capability_violations.is_empty() && senses_worse,
        validation,
        capability_violations,
        lost_capabilities: lost_capabilities(case, robot),
        sensor_violations,
        smallest_factors,
        turning,
        provenance: Provenance::of(measured),
    })
}

/// Every capability of which the first cell's robot has next to nothing left.
fn lost_capabilities(case: &Case, mut simulated: RobotProfile) -> Vec<LostCapability> {
    // What the sweep itself sets goes before the factors.
    let set = &case.conditions[0].robot;
    simulated.sensing.true_positive = set.true_positive;
    simulated.sensing.false_positive = set.false_positive;
    simulated.actuation.speed.robot_sd = set.speed_gain.robot_sd;
    simulated.actuation.turn.robot_sd = set.turn_gain.robot_sd;
    capability::lost_capabilities(&case.source.profile, &simulated)
}

/// Every capability in which the simulated robot is the better one at some cell, once.
fn better_capabilities(case: &Case) -> anyhow::Result<Vec<CapabilityViolation>> {
    let mut found: Vec<CapabilityViolation> = Vec::new();
    for conditions in &case.conditions {
        for violation in capability::violations(&case.source.profile, conditions)? {
            if found.iter().all(|known| known.capability != violation.capability) {
                found.push(violation);
            }
        }
    }
    Ok(found)
}
