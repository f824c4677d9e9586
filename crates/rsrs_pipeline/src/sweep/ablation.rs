//! Which of the factors that make a simulated robot worse does it: each alone, and all but each.

use anyhow::Context;
use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::DiagramCell;
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::quantity::Cell;
use rsrs_core::robot::harsher::{Harsher, HarsherFactors};
use rsrs_core::statistics::share::Share;
use rsrs_sim::sweep::{Runs, confirmation_seed, sweep};
use serde::Serialize;

use crate::execution::Execution;
use crate::sweep::result::SweepResult;
use crate::sweep::source::ResolvedSweep;

/// Most runs of each variant.
pub const REPLICATES: u64 = 200;

/// What every factor does to how often a cell mills.
#[derive(Clone, Debug, Serialize)]
pub struct Ablation {
    /// The cell.
    pub cell: Cell,
    /// Runs behind each share.
    pub n_replicates: u64,
    /// Share of stable milling with robots as measured.
    pub b_s_as_measured: f64,
    /// Share with all factors.
    pub b_s_with_all: f64,
    /// Factor by factor, of those that change this robot.
    pub factors: Vec<FactorEffect>,
}

/// What one factor does.
#[derive(Clone, Debug, Serialize)]
pub struct FactorEffect {
    /// Its key under `harsher:`.
    pub factor: &'static str,
    /// What it makes of the robots.
    #[serde(skip)]
    pub meaning: &'static str,
    /// Share of stable milling with this factor alone.
    pub b_s_alone: f64,
    /// Share with all factors but this one.
    pub b_s_without: f64,
}

/// Runs one cell of a sweep with each factor alone and with all but each.
///
/// # Arguments
///
/// * `replicates` — runs of each variant.
///
/// # Returns
///
/// `None` if no factor changes the robot.
///
/// # Errors
///
/// If the cell cannot be simulated, or it is called off.
pub fn ablate(
    source: &ResolvedSweep,
    cell: &Cell,
    replicates: u64,
    execution: Execution<'_>,
) -> anyhow::Result<Option<Ablation>> {
    let factors = source.sweep.factors(&source.profile);
    let ablations = factors.ablations(&source.profile);
    if ablations.is_empty() {
        return Ok(None);
    }
    let one_by_one = ablations.iter().flat_map(|ablation| [ablation.alone, ablation.without]);
    let variants = [HarsherFactors::NONE, factors].into_iter().chain(one_by_one);
    let conditions = variants
        .map(|factors| conditions(source, cell, factors))
        .collect::<anyhow::Result<Vec<Conditions>>>()?;
    let runs = Runs {
        seed: confirmation_seed(confirmation_seed(source.sweep.seed)),
        replicates,
        duration_s: source.sweep.duration_s,
        n_threads: execution.n_threads,
    };
    let swept = execution.simulate("comparing factors", |watch| sweep(&conditions, runs, watch))?;
    let counts = swept.counts(conditions.len());
    let shares: Vec<f64> = counts.iter().map(|counts| Share::milling(counts).value()).collect();
    let (of_all, of_each) = shares.split_at(2);
    let effects = ablations.iter().zip(of_each.chunks(2)).zip(conditions[2..].chunks(2));
    // What the sweep itself sets, under `fixed` or `axes`, no factor changes.
    let effects = effects.filter(|(_, alone)| alone[0] != conditions[0]);
    let effects = effects.map(|((ablation, shares), _)| FactorEffect {
        factor: ablation.key,
        meaning: ablation.meaning,
        b_s_alone: shares[0],
        b_s_without: shares[1],
    });
    Ok(Some(Ablation {
        cell: cell.clone(),
        n_replicates: replicates,
        b_s_as_measured: of_all[0],
        b_s_with_all: of_all[1],
        factors: effects.collect(),
    }))
}

/// The cell of a sweep that mills most often with the robots as measured; of equals the first.
///
/// # Returns
///
/// `None` if the sweep's robots are those as measured.
///
/// # Errors
///
/// As [`ablate`].
pub fn best_as_measured(
    source: &ResolvedSweep,
    replicates: u64,
    execution: Execution<'_>,
) -> anyhow::Result<Option<Cell>> {
    let Some(measured) = source.as_measured() else {
        return Ok(None);
    };
    let (cells, conditions): (Vec<Cell>, Vec<Conditions>) =
        measured.cells("sweep.yaml")?.into_iter().unzip();
    let SweepFile { seed, duration_s, .. } = source.sweep;
    let runs = Runs {
        seed: confirmation_seed(seed),
        replicates,
        duration_s,
        n_threads: execution.n_threads,
    };
    let swept =
        execution.simulate("robots as measured", |watch| sweep(&conditions, runs, watch))?;
    let counts = swept.counts(cells.len());
    let shares = counts.iter().map(|counts| Share::milling(counts).hits).rev();
    let best = cells.into_iter().rev().zip(shares).max_by_key(|(_, hits)| *hits);
    Ok(best.map(|(cell, _)| cell))
}

/// Of a sweep in which no cell mills in most runs, what the factors do in the cell that mills most
/// often as measured.
///
/// # Returns
///
/// `None` if some cell mills in most runs, or no factor changes the robot.
///
/// # Errors
///
/// As [`ablate`].
pub fn of_barren_sweep(
    result: &SweepResult,
    execution: Execution<'_>,
) -> anyhow::Result<Option<Ablation>> {
    let mills = |entry: &DiagramCell| entry.counts.wanted_share() >= 0.5;
    if result.diagram.cells.iter().any(mills) {
        return Ok(None);
    }
    let replicates = REPLICATES.min(result.source.sweep.replicates);
    match best_as_measured(&result.source, replicates, execution)? {
        Some(cell) => ablate(&result.source, &cell, replicates, execution),
        None => Ok(None),
    }
}

fn conditions(
    source: &ResolvedSweep,
    cell: &Cell,
    factors: HarsherFactors,
) -> anyhow::Result<Conditions> {
    let sweep = SweepFile { harsher: Harsher::from(factors), ..source.sweep.clone() };
    let source = ResolvedSweep { sweep, ..source.clone() };
    let cells = source.cells("sweep.yaml")?;
    let found = cells.into_iter().find(|(swept, _)| swept == cell);
    Ok(found.with_context(|| format!("the sweep has no cell {cell}"))?.1)
}

impl Ablation {
    /// The factor without which most is won, if that is more than chance.
    pub fn worst(&self) -> Option<&FactorEffect> {
        let worst = self
            .factors
            .iter()
            .max_by(|one, other| one.b_s_without.total_cmp(&other.b_s_without))?;
        // By chance, two shares differ by less than this in 99 of 100 cases.
        let chance = 2.58 * libm::sqrt(2.0 * 0.25 / self.n_replicates as f64);
        (worst.b_s_without - self.b_s_with_all > chance).then_some(worst)
    }
}
