//! Why robots do not mill, and what would have to be changed about them; for robots that do, what could
//! be saved.
//!
//! A changed robot is the measured one with other values on some axes, made worse as any measured robot
//! is: what is written down as needed can be written into the profile, and swept.

mod remedy;
mod repair;
mod sentence;
mod surplus;
mod text;

use std::path::Path;

use rsrs_core::diagram::axis::{Axis, Cell};
use rsrs_core::robot::other_profile::OtherProfile;
use serde::Serialize;

use crate::best_setting::grid::Grid;
use crate::best_setting::search::Changes;
use crate::best_setting::{Subject, nowhere};
use crate::execution::Execution;

pub use crate::best_setting::search::AsMeasured;

/// What is asked.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Sweep file, or the folder of a sweep, whose settings are tried; else a built-in grid is.
    pub sweep: Option<&'a Path>,
    /// The share of mills that is wanted, above 0 and below 1.
    pub wanted: f64,
    /// Fresh runs that confirm an answer, in each world; at least 1.
    pub confirm: u64,
    /// What a change costs, by axis; changes are put in order by it.
    pub costs: &'a [(Axis, f64)],
    /// On how many threads, watched by whom.
    pub execution: Execution<'a>,
}

/// Fresh runs that confirm an answer where nothing else is asked for.
pub const CONFIRM: u64 = 1000;

/// What is wrong with a robot, or nothing.
#[derive(Clone, Debug, Serialize)]
pub struct Diagnosis {
    /// Name of the kind of robot.
    pub robot: String,
    /// The share of mills that was wanted.
    pub wanted: f64,
    /// Whether the robots mill so often in some setting, made worse and as measured.
    pub viable: bool,
    /// The setting in which they mill most often.
    pub cell: Cell,
    /// Share of mills there in fresh runs, in the world in which they are rarer.
    pub b_s: f64,
    /// Its lower bound.
    pub b_s_low: f64,
    /// Fresh runs in each world.
    pub n_replicates: u64,
    /// Settings that were tried.
    pub n_settings: usize,
    /// The robots as measured, if they do not mill made worse.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_measured: Option<AsMeasured>,
    /// Changes after which they mill, the first one first; none if they do.
    pub causes: Vec<Cause>,
    /// Capabilities that by themselves are of no help, however good.
    pub hopeless: Vec<Hopeless>,
    /// What may be worse, if the robots mill.
    pub spare: Vec<Spare>,
}

/// A change after which the robots mill as often as wanted.
#[derive(Clone, Debug, Serialize)]
pub struct Cause {
    /// The capability; speed and turning rate stand for the limits.
    pub capability: Axis,
    /// What the robot has, as measured.
    pub now: f64,
    /// The nearest value that suffices.
    pub needed: f64,
    /// Share of mills with it in fresh runs, in the world in which they are rarer.
    pub b_s: f64,
    /// Its lower bound.
    pub b_s_low: f64,
    /// Fresh runs in each world.
    pub n_replicates: u64,
    /// Whether it suffices without another change.
    pub alone: bool,
    /// The other changes that it needs.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub with: Vec<Axis>,
    /// Whether robots that are perfect in everything else do not mill without it.
    pub necessary: bool,
    /// What it costs, if that was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cost: Option<f64>,
    /// The setting.
    pub cell: Cell,
    /// The change in words.
    pub change: String,
}

/// A capability that by itself is of no help.
#[derive(Clone, Debug, Serialize)]
pub struct Hopeless {
    /// The capability.
    pub capability: Axis,
    /// What the robot has, as measured.
    pub now: f64,
    /// The value that helped most.
    pub best: f64,
    /// Share of mills with it, in the few runs that it was given.
    pub b_s: f64,
}

/// A capability that is better than it needs to be.
#[derive(Clone, Debug, Serialize)]
pub struct Spare {
    /// The capability.
    pub capability: Axis,
    /// What the robot has, as measured.
    pub now: f64,
    /// What would do, if all else stays.
    pub enough: f64,
    /// Share of mills with it in fresh runs, in the world in which they are rarer.
    pub b_s: f64,
    /// Its lower bound.
    pub b_s_low: f64,
    /// The setting.
    pub cell: Cell,
    /// In words.
    pub text: String,
}

/// Finds out why robots do not mill.
///
/// # Arguments
///
/// * `path` — profile, sweep file, or folder of a sweep; of the latter two the robot, how it is made
///   worse, and the settings are taken.
///
/// # Errors
///
/// If a file is not what it should be, no setting can be simulated, or it is called off.
pub fn diagnose(path: &Path, options: Options<'_>) -> anyhow::Result<Diagnosis> {
    let subject = Subject::read(path, (options.sweep, OtherProfile::Insisted), Grid::of_robot)?;
    for (axis, cost) in options.costs {
        anyhow::ensure!(
            cost.is_finite() && *cost >= 0.0,
            "the cost of {axis} is {cost}, expected a number from 0"
        );
    }
    let search = subject.search(options.wanted, options.confirm, options.execution);
    let Subject { profile, grid, .. } = &subject;
    let unchanged = Changes::new();
    let tried = search.best(&unchanged, "as it is")?;
    let now = search.confirmed_best(&unchanged, &tried)?.ok_or_else(|| nowhere(path, &search))?;
    let viable = now.b_s_low >= options.wanted;
    let mut diagnosis = Diagnosis {
        robot: profile.name.clone(),
        wanted: options.wanted,
        viable,
        cell: now.cell,
        b_s: now.b_s,
        b_s_low: now.b_s_low,
        n_replicates: now.n_replicates,
        n_settings: grid.cells.len(),
        as_measured: None,
        causes: Vec::new(),
        hopeless: Vec::new(),
        spare: Vec::new(),
    };
    if viable {
        diagnosis.spare = surplus::spare(&search, &tried)?;
        return Ok(diagnosis);
    }
    diagnosis.as_measured = search.confirmed_as_measured()?;
    let found = repair::repairs(&search, &tried)?;
    diagnosis.causes = in_order(found.causes, options.costs);
    diagnosis.hopeless = found.hopeless;
    Ok(diagnosis)
}

/// Puts causes in order: by cost where it is known, else as they were found. Changes that need each
/// other stay together.
fn in_order(mut causes: Vec<Cause>, costs: &[(Axis, f64)]) -> Vec<Cause> {
    let cost = |axis: Axis| costs.iter().find(|(other, _)| *other == axis).map(|(_, cost)| *cost);
    for cause in &mut causes {
        cause.cost = cost(cause.capability);
    }
    let of_all = |cause: &Cause| -> f64 {
        let all = std::iter::once(cause.capability).chain(cause.with.iter().copied());
        // What has no price comes last.
        all.map(|axis| cost(axis).unwrap_or(f64::INFINITY)).sum()
    };
    causes.sort_by(|one, other| of_all(one).total_cmp(&of_all(other)));
    causes
}
