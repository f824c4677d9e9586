//! Chooses the most robust milling cell of a sweep.

pub mod extension;
mod smaller_placement;

use std::path::Path;

use anyhow::Context;
use rsrs_core::conditions::{Conditions, Placement};
use rsrs_core::diagram::axis::Cell;
use rsrs_core::diagram::choice::{AsMeasured, AtCircliness, Candidate, Choice, OneRobotLess, rank};
use rsrs_core::diagram::{DiagramCell, PhaseDiagram};
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::phase::{self, Phase, label};
use rsrs_core::statistics::comparison::Share;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use rsrs_sim::sweep::{Runs, Swept, confirmation_seed};
use serde::Serialize;

use crate::execution::Execution;
use crate::files::write_file;
use crate::sweep::folder;
use crate::sweep::result::SweepResult;
use crate::sweep::settling;
use crate::sweep::source::ResolvedSweep;
use crate::wording::counted;
pub use smaller_placement::SmallerPlacement;

/// Fresh runs that confirm a candidate, in each world, where nothing else is asked for.
pub const CONFIRM: u64 = 1000;

/// How to choose.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// Fresh runs that confirm a candidate, in each world; at least 1.
    pub confirm: u64,
    /// Least confirmed lower bound of `B_s` of a viable cell in both worlds, from 0 to 1.
    pub viable: f64,
    /// On how many threads, watched by whom.
    pub execution: Execution<'a>,
}

/// What came of choosing.
#[derive(Clone, Debug)]
pub enum Chosen {
    /// A viable cell, confirmed.
    Viable(Choice),
    /// No cell is good enough.
    NoViableCell(NoViableCell),
}

/// What there was where nothing is viable.
#[derive(Clone, Debug, Serialize)]
pub struct NoViableCell {
    /// Always `None`: where a choice has its cell, there is none.
    cell: Option<Cell>,
    /// Why no cell is viable.
    pub reason: String,
    /// The best of the cells that were confirmed, if one was worth it.
    pub best: Option<Choice>,
    /// The cell that milled most often in the sweep, made worse.
    pub best_swept: BestSwept,
    /// A disc in which robots would have to start for that cell to be viable, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smaller_placement: Option<SmallerPlacement>,
}

/// The cell that milled most often in a sweep, made worse; of equals the one that milled most often as
/// measured, of these the first.
#[derive(Clone, Debug, Serialize)]
pub struct BestSwept {
    cell: Cell,
    b_s: f64,
    b_s_low: f64,
    b_s_high: f64,
    n_replicates: u64,
}

/// Chooses the most robust milling cell of a sweep: candidates are confirmed on fresh seeds, in both
/// worlds, from the most robust on, until one holds. Whether that one is settled at the duration of
/// the sweep is part of the choice.
///
/// # Arguments
///
/// * `folder` — that of the sweep.
///
/// # Errors
///
/// If the folder is not that of a sweep of both worlds, or a confirmation is called off.
pub fn choose(folder: &Path, options: Options<'_>) -> anyhow::Result<Chosen> {
    let result = folder::read(folder)?;
    let kind = result.source.sweep.interval_kind();
    let candidates = rank(result.worlds()?, kind, options.viable);
    let mut best: Option<Choice> = None;
    for (candidate, n_tried) in candidates.iter().zip(1..) {
        let mut choice = confirmed(&result.source, candidate, options)?;
        choice.candidates_tried = Some(n_tried);
        if choice.is_viable(options.viable) {
            choice.settling =
                settling::of_cell(&result.source, candidate.index, options.execution)?;
            let conditions = result.source.conditions_of(candidate.index)?;
            choice.converged_s = converged_s(&result.source, &conditions)?;
            choice.one_robot_less = one_robot_less(&result.source, conditions, options)?;
            return Ok(Chosen::Viable(choice));
        }
        if best.as_ref().is_none_or(|best| choice.least_low() > best.least_low()) {
            best = Some(choice);
        }
    }
    let mut none = match best {
        Some(best) => NoViableCell {
            cell: None,
            reason: none_confirmed(&best, candidates.len(), options.viable),
            best: Some(best),
            best_swept: BestSwept::of(&result),
            smaller_placement: None,
        },
        None => NoViableCell::swept(BestSwept::of(&result), options.viable),
    };
    let index = result.diagram.locate(none.best_cell())?;
    none.smaller_placement = smaller_placement::find(&result.source, index, options)?;
    Ok(Chosen::NoViableCell(none))
}

/// When half of the mills among the first fresh runs of a cell had begun, in seconds; `None` if there
/// is none.
fn converged_s(source: &ResolvedSweep, conditions: &Conditions) -> anyhow::Result<Option<f64>> {
    /// So many runs are enough for a median.
    const RUNS: u64 = 100;
    let (seed, bodies) = (confirmation_seed(source.sweep.seed), conditions.bodies());
    let mut times_s = Vec::new();
    for replicate in 0..RUNS {
        let seed = Seed { seed, replicate };
        let trajectory = run_episode(conditions, seed, source.sweep.duration_s)?;
        let phase = label(&trajectory, &bodies)?.phase;
        times_s.extend(phase::converged_s(&trajectory, &bodies, phase));
    }
    times_s.sort_by(f64::total_cmp);
    Ok(times_s.get(times_s.len() / 2).copied())
}

/// Runs a cell with one robot less on fresh seeds, made worse.
///
/// # Returns
///
/// `None` if the cell stays viable, or there is only one robot.
fn one_robot_less(
    source: &ResolvedSweep,
    mut conditions: Conditions,
    options: Options<'_>,
) -> anyhow::Result<Option<OneRobotLess>> {
    let is_given = matches!(conditions.placement, Placement::Given { .. });
    if conditions.robots < 2 || is_given {
        return Ok(None);
    }
    conditions.robots -= 1;
    let fresh = confirm_conditions(options, source, &conditions)?;
    let milling = Share::milling(&fresh.counts(1)[0]);
    let interval = milling.interval();
    let less = OneRobotLess {
        robots: conditions.robots,
        b_s: milling.value(),
        b_s_low: interval.low,
        b_s_high: interval.high,
    };
    Ok((interval.high < options.viable).then_some(less))
}

/// Confirms a candidate on fresh seeds, in both worlds.
fn confirmed(
    source: &ResolvedSweep,
    candidate: &Candidate,
    options: Options<'_>,
) -> anyhow::Result<Choice> {
    let fresh = confirm(options, source, candidate.index)?;
    let mut choice = Choice::new(candidate, fresh.counts(1)[0]);
    choice.sweep_digest = Some(source.digest());
    let judged: Vec<(Phase, OrderParameters)> =
        fresh.outcomes.iter().map(|outcome| (outcome.phase, outcome.evidence)).collect();
    choice.by_circliness = AtCircliness::of(&judged);
    if let Some(measured) = source.as_measured() {
        let fresh = confirm(options, &measured, candidate.index)?;
        choice.as_measured = Some(AsMeasured::of(&fresh.counts(1)[0]));
    }
    Ok(choice)
}

fn none_confirmed(best: &Choice, n_candidates: usize, viable: f64) -> String {
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let measured = best.as_measured.map_or_else(String::new, |measured| {
        format!("; as measured {}, lower bound {}", percent(measured.share), percent(measured.low))
    });
    format!(
        "the best of {}, {}, {} in {} of fresh runs, lower bound {}{measured}; wanted {}",
        counted(n_candidates as u64, "candidate"),
        best.cell,
        best.behaviour().verb().does,
        percent(best.b_s),
        percent(best.b_s_low),
        percent(viable)
    )
}

impl NoViableCell {
    fn swept(best: BestSwept, viable: f64) -> Self {
        let reason = format!(
            "no cell may mill in {:.1} % of runs, made worse and as measured; made worse the best, \
             {}, mills in {:.1} % of {} runs (95 % interval {:.1} to {:.1} %)",
            100.0 * viable,
            best.cell,
            100.0 * best.b_s,
            best.n_replicates,
            100.0 * best.b_s_low,
            100.0 * best.b_s_high
        );
        Self { cell: None, reason, best: None, best_swept: best, smaller_placement: None }
    }
}

/// Writes a choice into a file.
///
/// # Errors
///
/// If the file cannot be written.
pub fn write(path: &Path, choice: &Choice) -> anyhow::Result<()> {
    let json = serde_json::to_string_pretty(choice).context("the choice as JSON")?;
    write_file(path, format!("{json}\n").as_bytes())
}

/// Runs a cell of a sweep on fresh seeds.
fn confirm(options: Options<'_>, source: &ResolvedSweep, index: usize) -> anyhow::Result<Swept> {
    confirm_conditions(options, source, &source.conditions_of(index)?)
}

fn confirm_conditions(
    options: Options<'_>,
    source: &ResolvedSweep,
    conditions: &Conditions,
) -> anyhow::Result<Swept> {
    let runs = Runs {
        seed: source.sweep.seed,
        replicates: options.confirm,
        duration_s: source.sweep.duration_s,
        n_threads: options.execution.n_threads,
    };
    options
        .execution
        .simulate("confirming", |watch| rsrs_sim::sweep::confirm(conditions, runs, watch))
}

impl NoViableCell {
    /// The cell that came nearest.
    pub fn best_cell(&self) -> &Cell {
        self.best.as_ref().map_or(&self.best_swept.cell, |choice| &choice.cell)
    }
}

impl BestSwept {
    fn of(result: &SweepResult) -> Self {
        let share =
            |diagram: &PhaseDiagram, index: usize| diagram.cells[index].counts.wanted_share();
        let measured = result.as_measured.as_ref().unwrap_or(&result.diagram);
        let best = (0..result.diagram.cells.len()).rev().max_by(|&one, &other| {
            let made_worse = share(&result.diagram, one).total_cmp(&share(&result.diagram, other));
            made_worse.then(share(measured, one).total_cmp(&share(measured, other)))
        });
        let best = best.expect("a sweep has cells");
        let DiagramCell { cell, counts } = result.diagram.cells[best].clone();
        let milling = Share::milling(&counts);
        let interval = result.source.sweep.interval_kind().interval(milling.hits, milling.n);
        Self {
            cell,
            b_s: milling.value(),
            b_s_low: interval.low,
            b_s_high: interval.high,
            n_replicates: milling.n,
        }
    }
}

/// What robots as measured do in the chosen cell, if that was asked.
pub fn as_measured(choice: &Choice) -> Option<String> {
    let measured = choice.as_measured?;
    let share = format!(
        "as measured, not made worse, it {} in {:.1} % of {} ({:.1} to {:.1} %)",
        choice.behaviour().verb().does,
        100.0 * measured.share,
        measured.n_replicates,
        100.0 * measured.low,
        100.0 * measured.high
    );
    let warning = ": being worse helps here, so expect less of it on the floor than simulated";
    Some(if choice.worse_is_better() { share + warning } else { share })
}
