//! Chooses the most robust milling cell of a sweep.

use std::path::Path;

use anyhow::Context;
use rsrs_core::axis::Cell;
use rsrs_core::choice::{AsMeasured, AtCircliness, Choice, REGION_B_S_LOW, rank};
use rsrs_core::comparison::Share;
use rsrs_core::diagram::DiagramCell;
use rsrs_core::order::Evidence;
use rsrs_core::phase::Phase;
use rsrs_sim::sweep::{Runs, Swept};
use serde::Serialize;

use crate::files::write_file;
use crate::progress::watched;
use crate::result_folder;
use crate::sweep_result::SweepResult;
use crate::sweep_source::ResolvedSweep;

/// Fresh runs that confirm the winner where nothing else is asked for.
pub const CONFIRM: u64 = 1000;

/// How to choose.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Fresh runs that confirm the winner; at least 1.
    pub confirm: u64,
    /// Least confirmed lower bound of `B_s` of a viable cell, from 0 to 1.
    pub viable: f64,
    /// Threads to run on.
    pub n_threads: usize,
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
    /// The best cell, if one was good enough to be confirmed.
    pub best: Option<Choice>,
    /// The cell that milled most often in the sweep, if none was good enough to be confirmed.
    pub best_swept: Option<BestSwept>,
}

/// The cell that milled most often in a sweep; of equals the first.
#[derive(Clone, Debug, Serialize)]
pub struct BestSwept {
    cell: Cell,
    b_s: f64,
    b_s_low: f64,
    b_s_high: f64,
    n_replicates: u64,
}

/// Chooses the most robust milling cell of a sweep and confirms it on fresh seeds.
///
/// # Arguments
///
/// * `folder` — that of the sweep.
///
/// # Errors
///
/// If the folder is not a sweep's, or the confirmation is called off.
pub fn choose(folder: &Path, options: Options) -> anyhow::Result<Chosen> {
    let result = result_folder::read(folder)?;
    let kind = result.source.sweep.interval_kind();
    let Some(candidate) = rank(&result.diagram, kind).into_iter().next() else {
        let best = BestSwept::of(&result);
        let reason = format!(
            "no cell's B_s has a lower bound of {REGION_B_S_LOW}; the best, {}, mills in {:.1} % of \
             {} runs (95 % interval {:.1} to {:.1} %)",
            best.cell,
            100.0 * best.b_s,
            best.n_replicates,
            100.0 * best.b_s_low,
            100.0 * best.b_s_high
        );
        let best_swept = Some(best);
        let none = NoViableCell { cell: None, reason, best: None, best_swept };
        return Ok(Chosen::NoViableCell(none));
    };
    let fresh = confirm(options, &result.source, candidate.index)?;
    let mut choice = Choice::new(&candidate, fresh.counts(1)[0]);
    let evidence: Vec<Evidence> = fresh.outcomes.iter().map(|outcome| outcome.evidence).collect();
    choice.by_circliness = AtCircliness::of(&evidence);
    if let Some(measured) = result.source.as_measured() {
        let fresh = confirm(options, &measured, candidate.index)?;
        choice.as_measured = Some(AsMeasured::of(&fresh.counts(1)[0]));
    }
    if choice.is_viable(options.viable) {
        return Ok(Chosen::Viable(choice));
    }
    let reason = format!(
        "the best, {}, mills in {:.1} % of fresh runs, lower bound {:.1} %, wanted {:.1} %",
        choice.cell,
        100.0 * choice.b_s,
        100.0 * choice.b_s_low,
        100.0 * options.viable
    );
    let none = NoViableCell { cell: None, reason, best: Some(choice), best_swept: None };
    Ok(Chosen::NoViableCell(none))
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
fn confirm(options: Options, source: &ResolvedSweep, index: usize) -> anyhow::Result<Swept> {
    let cells = source.cells("sweep.yaml")?;
    let runs = Runs {
        seed: source.sweep.seed,
        replicates: options.confirm,
        duration_s: source.sweep.duration_s,
        n_threads: options.n_threads,
    };
    watched("confirming", |watch| rsrs_sim::sweep::confirm(&cells[index].1, runs, watch))
}

impl BestSwept {
    fn of(result: &SweepResult) -> Self {
        let share = |entry: &DiagramCell| entry.counts.share(Phase::StableMilling);
        let cells = result.diagram.cells.iter().rev();
        let best = cells.max_by(|one, other| share(one).total_cmp(&share(other)));
        let DiagramCell { cell, counts } = best.expect("a sweep has cells").clone();
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
        "as measured, not made worse, it mills in {:.1} % of {} ({:.1} to {:.1} %)",
        100.0 * measured.share,
        measured.n_replicates,
        100.0 * measured.low,
        100.0 * measured.high
    );
    let warning = ": being worse helps here, so expect fewer mills on the floor than simulated";
    Some(if choice.worse_is_better() { share + warning } else { share })
}
