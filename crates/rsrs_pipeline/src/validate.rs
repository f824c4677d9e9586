//! Step 2: whether real trajectories lie inside the reach of the simulated robot, which is nowhere the
//! better one.

mod cause;
pub mod file;

use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_core::capability::{self, CapabilityViolation, LostCapability};
use rsrs_core::conditions::Conditions;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::robot::profile::{RobotProfile, TrialOrigin};
use rsrs_core::trials::fit::{SensorMap, sensor_map};
use rsrs_core::trials::trial::{DrivenTrial, detection_trials};
use rsrs_sim::reachable_set::{ReachOptions, smallest_factors, validate as contain};

use crate::error::{helped, with_help};
use crate::files::names;
use crate::measure::trial_files::{Trajectories, table, trajectories};
use crate::provenance::ResultProvenance;
use crate::sweep::folder;
use crate::sweep::result::SweepResult;
use crate::sweep::source::ResolvedSweep;
use file::{Judged, ValidationReport};

/// What a simulated robot is compared with.
#[derive(Clone, Debug)]
pub struct ValidateOptions {
    /// Real trajectories of robots that drive alone, or push one object: tables, or bags.
    pub trajectories: Vec<PathBuf>,
    /// Table of detections.
    pub detection: Option<PathBuf>,
    /// Whether trajectories of the simulator may stand in for real ones.
    pub stand_in: StandIn,
    /// Values of the capabilities that the sweep varies: one robot is judged.
    pub at: Cell,
    /// The class whose robot is judged, where classes have profiles of their own.
    pub class: Option<String>,
    /// How the reach is simulated; the seed is that of the sweep.
    pub reach: ReachOptions,
}

/// Whether trajectories of the simulator may stand in for real ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StandIn {
    /// They are refused.
    Refused,
    /// They are judged, and the result says so.
    Allowed,
}

/// A simulated robot that was held against trials.
pub struct Validated {
    /// What was held against each other.
    pub case: Case,
    /// What came out.
    pub answer: ValidationReport,
    /// The sweep, if it was a folder.
    pub swept: Option<SweepResult>,
}

/// What is held against each other.
pub struct Case {
    /// The sweep; of one class, with its profile.
    pub source: ResolvedSweep,
    class: Option<String>,
    /// Conditions of the cells at which the simulated robot is judged; one or more.
    pub conditions: Vec<Conditions>,
    at: Cell,
    /// The trials.
    pub trials: Vec<DrivenTrial>,
    /// The same from their standstills, where that is known.
    from_rest: Vec<DrivenTrial>,
    /// Where the sensor detects, if detections were given.
    pub sensor: Option<SensorMap>,
    /// How far trajectories and detections are a simulator's.
    pub origin: Option<TrialOrigin>,
    options: ReachOptions,
}

/// Judges the simulated robot of a sweep file, or of the folder of a sweep.
///
/// # Errors
///
/// If the sweep has several simulated robots and `at` and `class` do not name one.
pub fn validate(sweep: &Path, options: &ValidateOptions) -> anyhow::Result<Validated> {
    let swept = if sweep.is_dir() { Some(folder::read(sweep)?) } else { None };
    let source = match &swept {
        Some(swept) => swept.source.clone(),
        None => ResolvedSweep::read_either(sweep)?,
    };
    let case = read(&sweep.display().to_string(), source, options)?;
    let answer = judge(&case)?;
    Ok(Validated { case, answer, swept })
}

/// Reads what is compared; errors call the sweep `name`.
fn read(name: &str, source: ResolvedSweep, options: &ValidateOptions) -> anyhow::Result<Case> {
    let source = judged_source(name, source, options.class.as_deref())?;
    let at = options.at.clone();
    let conditions = judged_conditions(name, &source, &at)?;
    let detections = options.detection.as_ref();
    let detections = detections.map(|path| table(path, detection_trials)).transpose()?;
    let sensor = detections
        .as_ref()
        .map(|detections| sensor_map(detections, source.profile.body.radius_m).map_err(helped))
        .transpose()?;
    let Trajectories { driven: mut trials, from_rest, moved_by, simulated } =
        trajectories(&options.trajectories, options.class.as_deref())?;
    if source.sweep.world().is_none_or(|world| world.objects.is_empty()) {
        // What nobody pushed is as if it were not there.
        for trial in trials.iter_mut().filter(|trial| !trial.moves_object()) {
            trial.samples.iter_mut().for_each(|sample| sample.object_m = None);
        }
    }
    let of_detections = detections.map(|detections| detections.moved_by).unwrap_or_default();
    let origin = (moved_by + of_detections).origin();
    if origin.is_some() && options.stand_in == StandIn::Refused {
        let of_table = options.detection.iter().filter(|_| of_detections.simulator > 0);
        let files: Vec<&PathBuf> = simulated.iter().chain(of_table).collect();
        return Err(with_help(
            format!("the robots of {} were moved by the simulator", names(&files)),
            "give trajectories of real robots; `--simulated` takes them all the same, and the result \
             says so",
        ));
    }
    let class = options.class.clone();
    let options = ReachOptions { seed: source.sweep.seed, ..options.reach };
    Ok(Case { source, class, conditions, at, trials, from_rest, sensor, origin, options })
}

/// The sweep of the robots that are to be judged.
fn judged_source(
    file: &str,
    source: ResolvedSweep,
    class: Option<&str>,
) -> anyhow::Result<ResolvedSweep> {
    if let Some(class) = class {
        return source.of_class(class).context(file.to_owned());
    }
    if !source.has_profiles_of_classes() {
        return Ok(source);
    }
    let classes = source.sweep.world().into_iter().flat_map(|world| &world.classes);
    let options: Vec<String> = classes.map(|class| format!("`--class {}`", class.name)).collect();
    Err(with_help(
        format!(
            "{file} has classes with profiles of their own, so it has several simulated robots"
        ),
        format!("name the one to judge, with trials of its own: {}", options.join(" or ")),
    ))
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
            format!("{file}: {axis} is not a capability that this sweep varies ({have})"),
            "leave it out of `--at`",
        ));
    }
    let open: Vec<Axis> = capabilities.into_iter().filter(|axis| at.get(*axis).is_none()).collect();
    if !open.is_empty() {
        let example: Vec<String> = open.iter().map(|axis| format!("{}=…", axis.key())).collect();
        return Err(with_help(
            format!("{file} sweeps {}, so it has several simulated robots", keys(&open)),
            format!("name the one to judge: `--at {}`", example.join(",")),
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

fn judge(case: &Case) -> anyhow::Result<ValidationReport> {
    let source = &case.source;
    let (measured, factors) = (&source.profile, source.sweep.factors(&source.profile));
    let robot = factors.apply(measured)?;
    let settings = source.sweep.settings().with_cell(&case.at);
    let validation = contain(&robot, &settings, &case.trials, &case.options).map_err(helped)?;
    let turning = if validation.is_contained {
        None
    } else {
        cause::turning(measured, factors, &settings, case)?
    };
    let smallest_factors = if validation.is_contained || turning.is_some() {
        None
    } else {
        smallest_factors(measured, factors, &settings, &case.trials, &case.options)?
            .map(|smallest| smallest.factors)
    };
    let capability_violations = better_capabilities(case)?;
    let sensor_violations = case
        .sensor
        .as_ref()
        .map(|map| capability::sensor_violations(map, &case.conditions[0].robot));
    let senses_worse = sensor_violations.as_ref().is_none_or(Vec::is_empty);
    Ok(ValidationReport {
        judged: Judged::new(source, case.class.as_deref(), &case.at),
        is_harsher: validation.is_contained && capability_violations.is_empty() && senses_worse,
        validation,
        capability_violations,
        lost_capabilities: lost_capabilities(case, robot),
        sensor_violations,
        smallest_factors,
        turning,
        trials_of: case.origin,
        provenance: ResultProvenance::new(measured),
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
