//! Why robots do not mill, and what would have to be changed about them; for robots that do, what could
//! be saved.
//!
//! A changed robot is the measured one with other values on some axes, made worse as any measured robot
//! is: what is written down as needed can be written into the profile, and swept.

mod improvement;
mod repair;

use std::path::Path;

use rsrs_core::diagram::DiagramCell;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::robot::other_profile::OtherProfile;
use rsrs_core::statistics::share::Share;
use serde::Serialize;

use crate::best_setting::search::{Changes, Search, Tried};
use crate::best_setting::{self, BestSetting, Subject, confirm};
use crate::sweep::result::SweepResult;
use improvement::savings;

/// What is asked.
#[derive(Clone, Copy)]
pub struct DiagnoseOptions<'a> {
    /// Sweep file, or the folder of a sweep, whose settings are tried; else a built-in grid is.
    pub sweep: Option<&'a Path>,
    /// What a change costs, by axis; changes are put in order by it.
    pub costs: &'a [(Axis, f64)],
    /// How the best setting is looked for.
    pub best: best_setting::SearchOptions<'a>,
}

/// What is wrong with a robot, or nothing.
#[derive(Clone, Debug, Serialize)]
pub struct Diagnosis {
    /// Their best setting.
    #[serde(flatten)]
    pub best: BestSetting,
    /// Settings that were tried.
    pub n_settings: usize,
    /// The robots as measured, if they do not mill made worse.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub as_measured: Option<AsMeasured>,
    /// Changes after which they mill, the first one first; none if they do. As JSON these and the next two
    /// are written with a sentence each, by `rsrs_render`.
    #[serde(skip)]
    pub causes: Vec<NeededChange>,
    /// Capabilities that by themselves are of no help, however good.
    #[serde(skip)]
    pub hopeless: Vec<Hopeless>,
    /// What may be worse, if the robots mill.
    #[serde(skip)]
    pub spare: Vec<Spare>,
}

/// How often robots mill as measured, in the setting in which they do most often.
#[derive(Clone, Debug, Serialize)]
pub struct AsMeasured {
    /// The setting.
    pub cell: Cell,
    /// Share of mills in fresh runs.
    pub b_s: f64,
    /// Its lower bound, at 95 %.
    pub b_s_low: f64,
}

/// A change after which the robots mill as often as wanted.
#[derive(Clone, Debug, Serialize)]
pub struct NeededChange {
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
    /// Share of mills with it in fresh runs, in the world in which they are rarer.
    pub b_s: f64,
    /// Fresh runs in each world.
    #[serde(skip)]
    pub n_replicates: u64,
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
}

/// Finds out why robots do not mill.
///
/// The path is that of a profile, a sweep file, or the folder of a sweep; of the latter two the
/// robot, how it is made worse, and the settings are taken.
pub fn diagnose(path: &Path, options: DiagnoseOptions<'_>) -> anyhow::Result<Diagnosis> {
    for (axis, cost) in options.costs {
        anyhow::ensure!(
            cost.is_finite() && *cost >= 0.0,
            "the cost of {axis} is {cost}, expected a number from 0"
        );
    }
    let subject =
        Subject::read(path, (options.sweep, OtherProfile::Insisted), options.best.robots)?;
    let result = subject.swept(path, options.best)?;
    let mut diagnosis = Diagnosis {
        best: BestSetting::new(&result, options.best)?,
        n_settings: result.diagram.cells.len(),
        as_measured: None,
        causes: Vec::new(),
        hopeless: Vec::new(),
        spare: Vec::new(),
    };
    let search = Search::new(&result, options.best)?;
    let tried = tried(&result);
    if diagnosis.best.viable {
        diagnosis.spare = spare(&search, &tried)?;
        return Ok(diagnosis);
    }
    diagnosis.as_measured = as_measured(&result, options.best)?;
    let found = repair::repairs(&search, &tried)?;
    diagnosis.causes = in_order(found.causes, options.costs);
    diagnosis.hopeless = found.hopeless;
    Ok(diagnosis)
}

/// The settings with the robots as they are, made worse, the best first.
fn tried(result: &SweepResult) -> Vec<Tried> {
    let of = |entry: &DiagramCell| Tried {
        cell: entry.cell.clone(),
        share: Share::milling(&entry.counts),
    };
    let mut tried: Vec<Tried> = result.diagram.cells.iter().map(of).collect();
    tried.sort_by(|one, other| other.share.value().total_cmp(&one.share.value()));
    tried
}

/// The robots as measured in their best setting, on fresh seeds; `None` if they are not made worse.
fn as_measured(
    result: &SweepResult,
    options: best_setting::SearchOptions<'_>,
) -> anyhow::Result<Option<AsMeasured>> {
    let (Some(diagram), Some(source)) = (&result.as_measured, result.source.as_measured()) else {
        return Ok(None);
    };
    let share = |index: usize| diagram.cells[index].counts.wanted_share();
    let most = (0..diagram.cells.len()).rev();
    let most = most.max_by(|one, other| share(*one).total_cmp(&share(*other)));
    let most = most.expect("a sweep has cells");
    let conditions = [source.conditions_of(most)?];
    let counts = confirm(&conditions, &source, (options.confirm, options))?.counts(1)[0];
    let share = Share::milling(&counts);
    let cell = diagram.cells[most].cell.clone();
    Ok(Some(AsMeasured { cell, b_s: share.value(), b_s_low: share.interval().low }))
}

/// Puts causes in order: by cost where it is known, else as they were found. Changes that need each
/// other stay together.
fn in_order(mut causes: Vec<NeededChange>, costs: &[(Axis, f64)]) -> Vec<NeededChange> {
    let cost = |axis: Axis| costs.iter().find(|(other, _)| *other == axis).map(|(_, cost)| *cost);
    for cause in &mut causes {
        cause.cost = cost(cause.capability);
    }
    let of_all = |cause: &NeededChange| -> f64 {
        let all = std::iter::once(cause.capability).chain(cause.with.iter().copied());
        // What has no price comes last.
        all.map(|axis| cost(axis).unwrap_or(f64::INFINITY)).sum()
    };
    causes.sort_by(|one, other| of_all(one).total_cmp(&of_all(other)));
    causes
}

/// Finds how much worse each capability may be while all others stay, from the settings that were
/// tried with the robot as it is.
fn spare(search: &Search<'_>, unchanged: &[Tried]) -> anyhow::Result<Vec<Spare>> {
    let mut found = Vec::new();
    for improvement in savings(&search.source.profile) {
        let mut fails = None;
        let mut holds = (improvement.now, unchanged.to_vec());
        for &value in &improvement.values {
            let tried =
                search.again(&vec![(improvement.axis, value)], &holds.1, improvement.axis.key())?;
            if search.suffices(&tried) {
                holds = (value, tried);
            } else {
                fails = Some((value, tried));
                break;
            }
        }
        // From what is too little towards what the robot has.
        let (from, tried) = fails.unwrap_or_else(|| holds.clone());
        let way = improvement::Improvement { now: from, ..improvement.clone() };
        let at = |share: f64| -> Changes { vec![(way.axis, way.towards(improvement.now, share))] };
        let smallest = search.smallest(&at, [&tried, &holds.1], improvement.axis.key())?;
        let Some((changes, confirmed)) = smallest else { continue };
        let enough = changes[0].1;
        if (enough - improvement.now).abs() <= 1e-9 {
            continue;
        }
        found.push(Spare {
            capability: improvement.axis,
            now: improvement.now,
            enough,
            b_s: confirmed.b_s,
            b_s_low: confirmed.b_s_low,
            cell: confirmed.cell,
        });
    }
    Ok(found)
}
