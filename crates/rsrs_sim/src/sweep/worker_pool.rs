//! Where blocks are worked on: threads that share them, vector by vector.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::order::Parameter;
use rsrs_core::judge::phase::Verdict;

use super::block::Block;
use super::{Progress, ReplicateOutcome, SweepError, Watch};
use crate::batch::Batch;

/// What the blocks of a sweep have in common.
#[derive(Clone, Copy, Debug)]
pub struct Work<'a> {
    /// One entry for each cell.
    pub conditions: &'a [Conditions],
    /// Seed of the sweep, below 2^63.
    pub seed: u64,
    /// Simulated time of each replicate, in seconds.
    pub duration_s: f64,
    /// Threads to run on; the outcomes are the same for any number. 0 counts as 1.
    pub n_threads: usize,
    /// Where the count of replicates begins.
    pub start: Progress,
    /// Order parameters that are measured besides those of the behaviour.
    pub also: &'a [Parameter],
}

/// Why blocks were not finished.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BlockError<E> {
    /// A cell cannot be run.
    #[error(transparent)]
    Sweep(SweepError),
    /// What was finished could not be kept.
    #[error("a finished block cannot be kept")]
    KeepBlock(#[source] E),
}

/// How the work ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Completion {
    /// Every block was finished and kept.
    Finished,
    /// It was called off; the blocks that were finished are kept.
    CalledOff,
}

/// What is done with the outcomes of a finished block, in the order of [`Block::rows`].
pub type KeepBlock<'a, E> =
    &'a (dyn Fn(u64, &Block, Vec<ReplicateOutcome>) -> Result<(), E> + Sync);

/// Runs and judges every replicate of some numbered blocks; `keep` is called once for each finished
/// one, from any thread.
///
/// Blocks are begun in order and finished in any; at most one more is open at a time than there are
/// threads, so memory does not grow with their number. The error is that of the first block that
/// failed, in the order in which they were begun.
///
/// # Panics
///
/// If `blocks`, `keep` or `watch.progress` does.
pub fn run_blocks<E: Send>(
    work: Work<'_>,
    blocks: impl Iterator<Item = (u64, Block)> + Send,
    watch: Watch<'_>,
    keep: KeepBlock<'_, E>,
) -> Result<Completion, BlockError<E>> {
    let batch = Batch::new();
    let at_once = |conditions| batch.at_once(conditions, work.duration_s) as u64;
    let worker_pool = WorkerPool {
        work,
        watch,
        keep,
        at_once: work.conditions.iter().map(at_once).collect(),
        dispenser: Mutex::new(Dispenser { blocks, begun: 0, units: VecDeque::new() }),
        n_done: AtomicUsize::new(work.start.done),
        is_called_off: AtomicBool::new(false),
        failure: Mutex::new(None),
        has_failed: AtomicBool::new(false),
    };
    std::thread::scope(|scope| {
        for _ in 1..work.n_threads {
            scope.spawn(|| worker_pool.work());
        }
        worker_pool.work();
    });
    let failure = worker_pool.failure.into_inner().expect("no thread panics while holding it");
    match failure {
        Some((_, error)) => Err(error),
        None if worker_pool.is_called_off.into_inner() => Ok(Completion::CalledOff),
        None => Ok(Completion::Finished),
    }
}

/// Replicates of one cell that one thread runs together: few, so that the threads end together and
/// the 1,000 of a confirmation are shared.
struct Job {
    block: Arc<OpenBlock>,
    /// Its place in the block.
    index: usize,
    cell: usize,
    replicates: Range<u64>,
}

struct OpenBlock {
    /// How many were begun before it.
    order: u64,
    number: u64,
    block: Block,
    finished: Mutex<Finished>,
}

/// What is finished of a block.
struct Finished {
    units: Vec<Vec<ReplicateOutcome>>,
    n_missing: usize,
}

/// Hands out units, block after block.
struct Dispenser<I> {
    blocks: I,
    begun: u64,
    units: VecDeque<Job>,
}

/// A failure, after its place in the work: block and unit.
type Failure<E> = ((u64, usize), BlockError<E>);

/// What the threads share.
struct WorkerPool<'a, I, E> {
    work: Work<'a>,
    watch: Watch<'a>,
    keep: KeepBlock<'a, E>,
    /// How many replicates of each cell are best run together on this machine.
    at_once: Vec<u64>,
    dispenser: Mutex<Dispenser<I>>,
    n_done: AtomicUsize,
    is_called_off: AtomicBool,
    /// The first failure in the order of the work.
    failure: Mutex<Option<Failure<E>>>,
    has_failed: AtomicBool,
}

impl<I: Iterator<Item = (u64, Block)>, E> WorkerPool<'_, I, E> {
    /// Takes units in order until there are none, one has failed, or the work is called off.
    ///
    /// What is begun is finished, so the first failure is the same for any number of threads.
    fn work(&self) {
        let mut batch = Batch::new().measuring(self.work.also);
        while !self.has_failed.load(Ordering::Relaxed) {
            let is_cancelled = self.watch.cancel.load(Ordering::Relaxed);
            let Some(unit) = self.next_unit() else {
                return;
            };
            if is_cancelled {
                self.is_called_off.store(true, Ordering::Relaxed);
                return;
            }
            match self.run(&unit, &mut batch) {
                Ok(outcomes) => self.put(&unit, outcomes),
                Err(error) => self.fail((unit.block.order, unit.index), BlockError::Sweep(error)),
            }
        }
    }

    fn next_unit(&self) -> Option<Job> {
        let mut dispenser = self.dispenser.lock().expect("no thread panics while holding it");
        if dispenser.units.is_empty() {
            let (number, block) = dispenser.blocks.next()?;
            let order = dispenser.begun;
            dispenser.begun += 1;
            dispenser.units = self.units((order, number), block);
        }
        dispenser.units.pop_front()
    }

    fn units(&self, (order, number): (u64, u64), block: Block) -> VecDeque<Job> {
        let ranges: Vec<(usize, Range<u64>)> = block
            .pieces
            .iter()
            .flat_map(|piece| {
                let (cell, Range { start, end }) = (piece.cell, piece.replicates.clone());
                let at_once = self.at_once[cell];
                let firsts = (start..end).step_by(at_once as usize);
                firsts.map(move |first| (cell, first..end.min(first + at_once)))
            })
            .collect();
        let units = ranges.iter().map(|_| Vec::new()).collect();
        let finished = Mutex::new(Finished { units, n_missing: ranges.len() });
        let block = Arc::new(OpenBlock { order, number, block, finished });
        let unit = |(index, (cell, replicates))| Job {
            block: Arc::clone(&block),
            index,
            cell,
            replicates,
        };
        ranges.into_iter().enumerate().map(unit).collect()
    }

    fn run(&self, unit: &Job, batch: &mut Batch) -> Result<Vec<ReplicateOutcome>, SweepError> {
        let (cell, replicates) = (unit.cell, unit.replicates.clone());
        let Work { conditions, seed, duration_s, .. } = &self.work;
        let judged = batch
            .judge(&conditions[cell], *seed, replicates.clone(), *duration_s)
            .map_err(|error| SweepError::new(cell, error))?;
        for _ in replicates.clone() {
            let done = self.n_done.fetch_add(1, Ordering::Relaxed) + 1;
            (self.watch.progress)(Progress { done, total: self.work.start.total });
        }
        let outcome = |(replicate, verdict): (u64, Verdict)| ReplicateOutcome {
            cell,
            replicate,
            phase: verdict.phase,
            evidence: verdict.evidence,
        };
        Ok(replicates.zip(judged).map(outcome).collect())
    }

    /// Puts the outcomes of a unit into its block, and keeps the block if they were the last.
    fn put(&self, unit: &Job, outcomes: Vec<ReplicateOutcome>) {
        let open = &unit.block;
        let whole = {
            let mut finished = open.finished.lock().expect("no thread panics while holding it");
            finished.units[unit.index] = outcomes;
            finished.n_missing -= 1;
            (finished.n_missing == 0).then(|| std::mem::take(&mut finished.units))
        };
        if let Some(units) = whole {
            let outcomes = units.into_iter().flatten().collect();
            if let Err(error) = (self.keep)(open.number, &open.block, outcomes) {
                self.fail((open.order, usize::MAX), BlockError::KeepBlock(error));
            }
        }
    }

    fn fail(&self, place: (u64, usize), error: BlockError<E>) {
        let mut failure = self.failure.lock().expect("no thread panics while holding it");
        if failure.as_ref().is_none_or(|(other, _)| place < *other) {
            *failure = Some((place, error));
        }
        self.has_failed.store(true, Ordering::Relaxed);
    }
}
