//! Many runs: every cell of a sweep, every replicate of a cell, on any number of threads.

use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::PhaseCounts;
use rsrs_core::digest::mix;
use rsrs_core::order::Evidence;
use rsrs_core::phase::{JudgeError, Phase};

use crate::batch::{Batch, BatchError, Judged};
use crate::placement::PlacementError;

/// How every cell is run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Runs {
    /// Seed of the sweep, below 2^63.
    pub seed: u64,
    /// Replicates of each cell.
    pub replicates: u64,
    /// Simulated time of each replicate, in seconds.
    pub duration_s: f64,
    /// Threads to run on; the results are the same for any number. 0 counts as 1.
    pub n_threads: usize,
}

/// Who looks on, and may call off.
#[derive(Clone, Copy)]
pub struct Watch<'a> {
    /// Called for each replicate that is done, from any thread; replicates are done some at a time.
    pub progress: &'a (dyn Fn(Progress) + Sync),
    /// Once it is true, no further replicates are begun.
    pub cancel: &'a AtomicBool,
}

/// How far a sweep has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Replicates that are done.
    pub done: usize,
    /// All replicates.
    pub total: usize,
}

/// What became of one replicate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReplicateOutcome {
    /// Index of the cell among the conditions that were swept.
    pub cell: usize,
    /// Number of the replicate in its cell, from 0.
    pub replicate: u64,
    /// What the swarm settled into.
    pub phase: Phase,
    /// The order parameters behind it.
    pub evidence: Evidence,
    /// When stable milling began, in seconds; `None` if it did not.
    pub converged_s: Option<f64>,
}

/// The outcomes of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct Swept {
    /// By cell, then by replicate; of a sweep that was called off, its whole cells only.
    pub outcomes: Vec<ReplicateOutcome>,
    /// Whether the sweep was called off before its end.
    pub is_cancelled: bool,
}

/// Why a sweep ended early.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SweepError {
    /// The robots of a cell do not fit where they are to start.
    #[error("cell number {cell}: {source}")]
    Placement {
        /// Index of the cell.
        cell: usize,
        /// Why.
        source: PlacementError,
    },
    /// The runs of a cell cannot be judged.
    #[error("cell number {cell}: {source}")]
    Judge {
        /// Index of the cell.
        cell: usize,
        /// Why.
        source: JudgeError,
    },
}

impl SweepError {
    fn new(cell: usize, error: BatchError) -> Self {
        match error {
            BatchError::Placement(source) => Self::Placement { cell, source },
            BatchError::Judge(source) => Self::Judge { cell, source },
        }
    }
}

/// Runs and judges every replicate of every cell.
///
/// Each replicate depends on its own conditions, seed and number only, so the outcomes are the same
/// for any number of threads, and a cell keeps its outcomes when the grid around it changes.
///
/// # Arguments
///
/// * `conditions` — one entry for each cell.
/// * `runs` — how often, how long, from which seed.
/// * `watch` — progress and cancellation.
///
/// # Errors
///
/// [`SweepError`] of the first cell that cannot be run.
pub fn sweep(conditions: &[Conditions], runs: Runs, watch: Watch<'_>) -> Result<Swept, SweepError> {
    let batch = Batch::new();
    let units: Vec<Unit> = (0..conditions.len())
        .flat_map(|cell| {
            let at_once = batch.at_once(&conditions[cell], runs.duration_s) as u64;
            (0..runs.replicates).step_by(at_once as usize).map(move |first| {
                let last = runs.replicates.min(first + at_once);
                Unit { cell, replicates: first..last }
            })
        })
        .collect();
    let floor = Floor {
        conditions,
        runs,
        watch,
        units: &units,
        next: AtomicUsize::new(0),
        n_done: AtomicUsize::new(0),
        has_failed: AtomicBool::new(false),
        finished: Mutex::new(units.iter().map(|_| None).collect()),
    };
    std::thread::scope(|scope| {
        for _ in 0..runs.n_threads.clamp(1, units.len().max(1)) {
            scope.spawn(|| floor.work());
        }
    });
    floor.gather()
}

/// Runs one cell again on seeds that no replicate of the sweep has seen.
///
/// A cell that was chosen because it looked best looks better than it is; only fresh runs say how
/// good it is.
///
/// # Arguments
///
/// * `conditions` — the chosen cell.
/// * `runs` — as for [`sweep`], with the *sweep's* seed: the fresh one is derived from it by
///   [`confirmation_seed`].
/// * `watch` — progress and cancellation.
///
/// # Errors
///
/// As [`sweep`].
pub fn confirm(conditions: &Conditions, runs: Runs, watch: Watch<'_>) -> Result<Swept, SweepError> {
    let runs = Runs { seed: confirmation_seed(runs.seed), ..runs };
    sweep(std::slice::from_ref(conditions), runs, watch)
}

/// The seed of the confirmation of a sweep: another one, below 2^63, that follows from it.
pub fn confirmation_seed(sweep_seed: u64) -> u64 {
    let seed = mix(sweep_seed ^ CONFIRMATION) >> 1;
    if seed == sweep_seed { seed ^ 1 } else { seed }
}

/// "confirm" in ASCII.
const CONFIRMATION: u64 = 0x636f_6e66_6972_6d00;

impl Swept {
    /// How the replicates of each cell ended; shape `[n_cells]`, with zeros for cells that were not
    /// run.
    pub fn counts(&self, n_cells: usize) -> Vec<PhaseCounts> {
        let mut counts = vec![PhaseCounts::default(); n_cells];
        for outcome in &self.outcomes {
            counts[outcome.cell].add(outcome.phase);
        }
        counts
    }
}

/// Replicates of one cell that one thread runs together: few, so that the threads end together and
/// the 1,000 of a confirmation are shared.
struct Unit {
    cell: usize,
    replicates: Range<u64>,
}

type UnitResult = Result<Vec<ReplicateOutcome>, SweepError>;

/// What the threads of one sweep share.
struct Floor<'a> {
    conditions: &'a [Conditions],
    runs: Runs,
    watch: Watch<'a>,
    units: &'a [Unit],
    next: AtomicUsize,
    n_done: AtomicUsize,
    has_failed: AtomicBool,
    finished: Mutex<Vec<Option<UnitResult>>>,
}

impl Floor<'_> {
    /// Takes units in order until there are none, one has failed, or the sweep is called off.
    fn work(&self) {
        let mut batch = Batch::new();
        while !self.has_failed.load(Ordering::Relaxed) && !self.is_cancelled() {
            let index = self.next.fetch_add(1, Ordering::Relaxed);
            let Some(unit) = self.units.get(index) else {
                return;
            };
            let result = self.run_unit(unit, &mut batch);
            if result.is_err() {
                self.has_failed.store(true, Ordering::Relaxed);
            }
            let mut finished = self.finished.lock().expect("no thread panics while holding it");
            finished[index] = Some(result);
        }
    }

    fn run_unit(&self, unit: &Unit, batch: &mut Batch) -> UnitResult {
        let (cell, replicates) = (unit.cell, unit.replicates.clone());
        let runs = (self.runs.seed, replicates.clone());
        let judged = batch
            .judge(&self.conditions[cell], runs, self.runs.duration_s)
            .map_err(|error| SweepError::new(cell, error))?;
        let total = self.conditions.len() * self.runs.replicates as usize;
        for _ in replicates.clone() {
            let done = self.n_done.fetch_add(1, Ordering::Relaxed) + 1;
            (self.watch.progress)(Progress { done, total });
        }
        let outcome = |(replicate, judged): (u64, Judged)| ReplicateOutcome {
            cell,
            replicate,
            phase: judged.verdict.phase,
            evidence: judged.verdict.evidence,
            converged_s: judged.converged_s,
        };
        Ok(replicates.zip(judged).map(outcome).collect())
    }

    fn is_cancelled(&self) -> bool {
        self.watch.cancel.load(Ordering::Relaxed)
    }

    /// Units are begun in order, and what is begun is finished, so the first failure is the same
    /// for any number of threads.
    fn gather(self) -> Result<Swept, SweepError> {
        let finished = self.finished.into_inner().expect("no thread panics while holding it");
        let is_cancelled = finished.iter().any(Option::is_none);
        let mut whole_cells = vec![true; self.conditions.len()];
        let mut outcomes = Vec::new();
        for (unit, result) in self.units.iter().zip(finished) {
            match result {
                Some(result) => outcomes.extend(result?),
                None => whole_cells[unit.cell] = false,
            }
        }
        outcomes.retain(|outcome| whole_cells[outcome.cell]);
        Ok(Swept { outcomes, is_cancelled })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_confirmation_has_a_seed_of_its_own() {
        for seed in (0..1000).chain([u64::MAX >> 1]) {
            assert_ne!(confirmation_seed(seed), seed);
            assert!(confirmation_seed(seed) < 1 << 63);
        }
    }
}
