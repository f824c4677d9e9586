//! Many runs: every cell of a sweep, every replicate of a cell, on any number of threads.

mod block;
mod worker_pool;

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

use rsrs_core::conditions::Conditions;
use rsrs_core::digest::mix;
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::order::Parameter;
use rsrs_core::judge::phase::{JudgeError, Phase};
use rsrs_core::judge::window::samples_in;

use crate::batch::BatchError;
use crate::draw::{RunKey, Seed};
use crate::placement::{self, PlacementError};

pub use block::{Block, CellReplicates, MOST_ROWS, blocks};
pub use worker_pool::{BlockError, Completion, KeepBlock, Work, run_blocks};

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
    pub evidence: OrderParameters,
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

/// Runs and judges every replicate of every cell, each with conditions of its own, and holds all
/// outcomes in memory.
///
/// Each replicate depends on its own conditions, seed and number only, so the outcomes are the same
/// for any number of threads, and a cell keeps its outcomes when the grid around it changes.
///
/// # Panics
///
/// If `watch.progress` does.
pub fn sweep(conditions: &[Conditions], runs: Runs, watch: Watch<'_>) -> Result<Swept, SweepError> {
    sweep_measuring(conditions, runs, watch, &[])
}

/// As [`sweep`], with order parameters measured that the behaviours do not ask for.
///
/// # Panics
///
/// As [`sweep`].
pub fn sweep_measuring(
    conditions: &[Conditions],
    runs: Runs,
    watch: Watch<'_>,
    also: &[Parameter],
) -> Result<Swept, SweepError> {
    let Runs { seed, replicates, duration_s, n_threads } = runs;
    let total = conditions.len() * replicates as usize;
    let start = Progress { done: 0, total };
    let work = Work { conditions, seed, duration_s, n_threads, start, also };
    let cells = (0..conditions.len()).map(|cell| {
        (cell as u64, Block { pieces: vec![CellReplicates { cell, replicates: 0..replicates }] })
    });
    let whole_cells: Mutex<BTreeMap<u64, Vec<ReplicateOutcome>>> = Mutex::default();
    let keep = |cell, _: &Block, outcomes| -> Result<(), Infallible> {
        whole_cells.lock().expect("no thread panics while holding it").insert(cell, outcomes);
        Ok(())
    };
    let ending = run_blocks(work, cells, watch, &keep).map_err(|error| match error {
        BlockError::Sweep(error) => error,
        BlockError::KeepBlock(never) => match never {},
    })?;
    let whole_cells = whole_cells.into_inner().expect("no thread panics while holding it");
    let outcomes = whole_cells.into_values().flatten().collect();
    Ok(Swept { outcomes, is_cancelled: ending == Completion::CalledOff })
}

/// Looks for what keeps a sweep from being run, before anything is: a cell without robots, with too
/// little time for the judge or without the arena that its behaviour is about, or whose robots do
/// not fit where they are to start.
pub fn check(conditions: &[Conditions], runs: Runs) -> Result<(), SweepError> {
    conditions.iter().enumerate().try_for_each(|(cell, conditions)| {
        let n_steps = conditions.steps(runs.duration_s);
        let impossible = |error| Err(SweepError::new(cell, error));
        if conditions.robots == 0 {
            return impossible(JudgeError::NoRobots.into());
        }
        let window = conditions.behaviour.window();
        if n_steps < samples_in(window.least_s(), conditions.period_s) as u64 {
            let duration_s = n_steps as f64 * conditions.period_s;
            return impossible(JudgeError::TooShort { duration_s, window }.into());
        }
        if let Err(error) = conditions.behaviour.rules().check_known(&conditions.bodies()) {
            return impossible(error.into());
        }
        let seed = Seed { seed: runs.seed, replicate: 0 };
        match placement::place(conditions, RunKey::new(seed, conditions.digest())) {
            Ok(_) => Ok(()),
            Err(error) => impossible(error.into()),
        }
    })
}

/// The seed of the confirmation of a sweep: another one, below 2^63, that follows from it.
///
/// A cell that was chosen because it looked best looks better than it is; only runs on seeds that no
/// replicate of the sweep has seen estimate how good it is.
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
