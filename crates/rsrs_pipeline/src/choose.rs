//! Chooses the most robust cell of a sweep.

pub mod extension;
pub mod pseudo_realities;
pub mod with_factors;

use std::path::Path;

use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::DiagramCell;
use rsrs_core::diagram::choice::{Choice, most_frequent};
use rsrs_core::quantity::Cell;
use rsrs_core::statistics::share::Share;
use rsrs_sim::draw::Seed;
use rsrs_sim::sweep::confirmation_seed;
use serde::Serialize;

use crate::best_setting::{Best, best};
use crate::files::write_json;
use crate::sweep::folder;
use crate::sweep::result::SweepResult;
use crate::sweep::settling;
use crate::sweep::source::ResolvedSweep;

pub use crate::best_setting::{CONFIRM, SearchOptions};

/// What came of choosing.
#[derive(Clone, Debug)]
pub enum Chosen {
    /// A viable cell, confirmed.
    Viable(Choice),
    /// No cell is good enough.
    NoViableCell(NoViableCell),
}

/// What there was where nothing is viable.
#[derive(Clone, Debug)]
pub struct NoViableCell {
    /// The share that was wanted.
    pub wanted: f64,
    /// Cells that might have been viable.
    pub n_candidates: usize,
    /// The best of the cells that were confirmed.
    pub best: Choice,
    /// The cell that came most often to the wanted phase in the sweep, in the world in which that is
    /// rarer.
    pub best_swept: BestSwept,
}

/// The share of a cell in its sweep, made worse.
#[derive(Clone, Debug, Serialize)]
pub struct BestSwept {
    cell: Cell,
    b_s: f64,
    b_s_low: f64,
    b_s_high: f64,
    n_replicates: u64,
}

/// Chooses the best setting of the sweep in a folder, by the search of `best_setting`. Whether that
/// is settled at the duration of the sweep is part of the choice.
pub fn choose(folder: &Path, options: SearchOptions<'_>) -> anyhow::Result<Chosen> {
    choose_in(folder::read(folder)?, options)
}

fn choose_in(whole: SweepResult, options: SearchOptions<'_>) -> anyhow::Result<Chosen> {
    let digest = whole.source.digest();
    let result = whole.of_robots(options.robots)?;
    let Best { mut choice, index, n_candidates } = best(&result, options)?;
    choice.sweep_digest = Some(digest);
    if choice.is_viable(options.wanted) {
        choice.settling = settling::of_cell(&result.source, index, options.execution)?;
        choice.converged_s = converged_s(&result.source, &result.source.conditions_of(index)?)?;
        return Ok(Chosen::Viable(choice));
    }
    Ok(Chosen::NoViableCell(NoViableCell {
        wanted: options.wanted,
        n_candidates,
        best_swept: BestSwept::new(&result, options)?,
        best: choice,
    }))
}

/// When half of the wanted runs among the first fresh ones of a cell had begun, in seconds; `None` if
/// there is none.
fn converged_s(source: &ResolvedSweep, conditions: &Conditions) -> anyhow::Result<Option<f64>> {
    /// So many runs are enough for a median.
    const RUNS: u64 = 100;
    let seed = confirmation_seed(source.sweep.seed);
    let runs = (0..RUNS).map(|replicate| Seed { seed, replicate });
    settling::median_time_s(conditions, source.sweep.duration_s, runs)
}

/// Writes a choice into a file.
pub fn write(path: &Path, choice: &Choice) -> anyhow::Result<()> {
    write_json(path, choice)
}

impl BestSwept {
    fn new(result: &SweepResult, options: SearchOptions<'_>) -> anyhow::Result<Self> {
        let kind = result.source.sweep.interval_kind();
        let best = most_frequent(result.worlds()?, kind, options.wanted);
        let DiagramCell { cell, counts } = result.diagram.cells[best.index].clone();
        let milling = Share::milling(&counts);
        let interval = kind.interval(milling.hits, milling.n);
        Ok(Self {
            cell,
            b_s: milling.value(),
            b_s_low: interval.low,
            b_s_high: interval.high,
            n_replicates: milling.n,
        })
    }
}
