//! Whether cells are settled at their duration: their runs, looked at at two thirds and at the end; and when
//! they came to what they end in.

use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::settling::{Settling, edge};
use rsrs_core::judge::phase::{Phase, converged_s, label_with};
use rsrs_core::quantity::Cell;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use serde::Serialize;

use crate::execution::Execution;
use crate::sweep::result::SweepResult;
use crate::sweep::source::ResolvedSweep;

/// Runs of a cell that `choose` looks at, and `episode` at most.
const MOST_RUNS: u64 = 200;
/// Runs of each cell at the edge that `sweep` looks at, at most.
const MOST_RUNS_AT_EDGE: u64 = 16;

/// A cell that is not settled.
#[derive(Clone, Debug, Serialize)]
pub struct Unsettled {
    /// The cell.
    pub cell: Cell,
    /// How many of its runs change.
    #[serde(flatten)]
    pub settling: Settling,
}

/// Whether one cell of a sweep is settled; `None` if its runs are too short for that.
pub fn of_cell(
    source: &ResolvedSweep,
    index: usize,
    execution: Execution<'_>,
) -> anyhow::Result<Option<Settling>> {
    of_runs(source, index, MOST_RUNS, execution)
}

/// The same by the sweep's own runs of the cell, which may be few where each takes long; `None` also of a single run,
/// which can show nothing.
pub fn of_cell_as_swept(
    source: &ResolvedSweep,
    index: usize,
    execution: Execution<'_>,
) -> anyhow::Result<Option<Settling>> {
    match source.sweep.replicates.min(MOST_RUNS) {
        0 | 1 => Ok(None),
        replicates => of_runs(source, index, replicates, execution),
    }
}

fn of_runs(
    source: &ResolvedSweep,
    index: usize,
    replicates: u64,
    execution: Execution<'_>,
) -> anyhow::Result<Option<Settling>> {
    let conditions = source.conditions_of(index)?;
    let found = of_conditions(source, &[conditions], replicates, execution)?;
    Ok(found.and_then(|found| found.into_iter().next()))
}

/// When half of those of some runs that ended as wanted had come to it, in seconds; `None` if none did.
pub fn median_time_s(
    conditions: &Conditions,
    duration_s: f64,
    runs: impl Iterator<Item = Seed>,
) -> anyhow::Result<Option<f64>> {
    let (bodies, rules) = (conditions.bodies(), conditions.behaviour.rules());
    let mut times_s = Vec::new();
    for seed in runs {
        let trajectory = run_episode(conditions, seed, duration_s)?;
        let phase = label_with(&trajectory, &bodies, &rules)?.phase;
        times_s.extend(converged_s(&trajectory, &bodies, phase));
    }
    times_s.sort_by(f64::total_cmp);
    Ok(times_s.get(times_s.len() / 2).copied())
}

/// How many cells are at the edge of a sweep's milling region, and those of them that are not
/// settled.
pub fn at_edge(
    result: &SweepResult,
    execution: Execution<'_>,
) -> anyhow::Result<(usize, Vec<Unsettled>)> {
    let edge = edge(&result.diagram);
    let cells = result.source.cells("sweep.yaml")?;
    let of_edge: Vec<Conditions> = edge.iter().map(|index| cells[*index].1.clone()).collect();
    let n = MOST_RUNS_AT_EDGE.min(result.source.sweep.replicates);
    let found = of_conditions(&result.source, &of_edge, n, execution)?.unwrap_or_default();
    let unsettled = edge.iter().zip(found).filter(|(_, settling)| !settling.is_settled());
    let unsettled = unsettled
        .map(|(index, settling)| Unsettled { cell: cells[*index].0.clone(), settling })
        .collect();
    Ok((edge.len(), unsettled))
}

/// A longer run passes through the states of a shorter one, so the same runs are made twice, to two
/// thirds and to their end.
fn of_conditions(
    source: &ResolvedSweep,
    conditions: &[Conditions],
    replicates: u64,
    execution: Execution<'_>,
) -> anyhow::Result<Option<Vec<Settling>>> {
    let duration_s = source.sweep.duration_s;
    let window = source.sweep.behaviour.known().window();
    let from_s = Settling::last_third_s(duration_s, window);
    let Some(from_s) = from_s.filter(|_| !conditions.is_empty()) else {
        return Ok(None);
    };
    let phases = |duration_s| -> anyhow::Result<Vec<Phase>> {
        let doing = "checking whether phases still change";
        let runs = (source.sweep.seed, replicates);
        let swept = execution.simulate(doing, conditions, runs, duration_s)?;
        Ok(swept.outcomes.into_iter().map(|outcome| outcome.phase).collect())
    };
    let (before, after) = (phases(from_s)?, phases(duration_s)?);
    let n = usize::try_from(replicates)?;
    let cells = before.chunks(n).zip(after.chunks(n));
    Ok(Some(cells.map(|(before, after)| Settling::new(before, after, from_s)).collect()))
}
