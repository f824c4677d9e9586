//! The work of a sweep: rounds of blocks, each kept as soon as it is finished.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

use rsrs_core::adaptive::{Knowledge, Schedule};
use rsrs_core::axis::Cell;
use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::{DiagramCell, PhaseCounts, PhaseDiagram};
use rsrs_sim::sweep::{
    Block, BlockError, Ending, Piece, Progress, ReplicateOutcome, Runs, SweepError, Watch, Work,
    blocks, check, run_blocks,
};

use crate::failure::{WithHelp, with_help};
use crate::interrupt;
use crate::progress::ReplicateBar;
use crate::result_folder;
use crate::result_folder::unfinished::{self, Site, Unfinished};
use crate::sweep_result::SweepResult;
use crate::sweep_source::ResolvedSweep;

/// Sweeps into a folder: from its beginning, from where it was interrupted, or not at all if the
/// results of this very sweep are there.
///
/// # Arguments
///
/// * `folder` — the folder to make.
/// * `source` — the sweep, after a name for errors.
/// * `n_threads` — how many to run on.
///
/// # Errors
///
/// If a cell cannot be simulated, the folder holds anything else, it cannot be written, or the sweep
/// is called off; after the last two it can be resumed.
pub fn sweep_into(
    folder: &Path,
    (name, source): (&str, ResolvedSweep),
    n_threads: usize,
) -> anyhow::Result<SweepResult> {
    let (cells, conditions): (Vec<Cell>, Vec<Conditions>) = source.cells(name)?.into_iter().unzip();
    let runs = Runs {
        seed: source.sweep.seed,
        replicates: source.sweep.replicates,
        duration_s: source.sweep.duration_s,
        n_threads,
    };
    check(&conditions, runs).map_err(|error| explain(name, &cells, error))?;
    let site = match unfinished::open(folder, &source)? {
        Site::Finished => return result_folder::read(folder),
        Site::Unfinished(site) => site,
    };
    let cancel = interrupt::listen()?;
    let sweeping = Sweeping { site: &site, folder, conditions: &conditions, runs, cancel };
    let schedule =
        source.sweep.adaptive.map(|adaptive| Schedule::new(adaptive, runs.replicates, &cells));
    match sweeping.rounds(schedule.as_ref()) {
        Ok(Swept { counts, rounds }) => {
            let entries = cells.into_iter().zip(counts);
            let cells = entries.map(|(cell, counts)| DiagramCell { cell, counts }).collect();
            let diagram = PhaseDiagram { axes: source.sweep.swept_axes(), cells };
            let result = SweepResult { source, diagram };
            let work = numbered(&conditions, runs.duration_s, &rounds);
            site.finish(&result, work, n_threads).map_err(|error| kept(folder, error))?;
            Ok(result)
        }
        Err(Failure::Impossible { error, is_empty }) => {
            // It will never be finished; what it has so far, if anything, is not thrown away.
            if is_empty {
                site.abandon()?;
            }
            Err(explain(name, &cells, error))
        }
        Err(Failure::Other(error)) => Err(error),
    }
}

/// What is known of every cell at the end of an adaptive sweep; `None` of any other.
pub fn knowledge(result: &SweepResult) -> Option<Vec<Knowledge>> {
    let adaptive = result.source.sweep.adaptive?;
    let entries = &result.diagram.cells;
    let cells: Vec<Cell> = entries.iter().map(|entry| entry.cell.clone()).collect();
    let counts: Vec<PhaseCounts> = entries.iter().map(|entry| entry.counts).collect();
    let schedule = Schedule::new(adaptive, result.source.sweep.replicates, &cells);
    Some((0..counts.len()).map(|cell| schedule.knowledge(&counts, cell)).collect())
}

/// A sweep at work.
struct Sweeping<'a> {
    site: &'a Unfinished,
    folder: &'a Path,
    conditions: &'a [Conditions],
    runs: Runs,
    /// Becomes true at Ctrl-C.
    cancel: &'a AtomicBool,
}

/// Replicates of a round, by cell.
type Round = Vec<Piece>;

/// What was swept.
struct Swept {
    /// Shape `[n_cells]`.
    counts: Vec<PhaseCounts>,
    rounds: Vec<Round>,
}

enum Failure {
    /// A cell cannot be simulated.
    Impossible {
        error: SweepError,
        /// Whether no block was kept.
        is_empty: bool,
    },
    Other(anyhow::Error),
}

impl From<anyhow::Error> for Failure {
    fn from(error: anyhow::Error) -> Self {
        Self::Other(error)
    }
}

impl Sweeping<'_> {
    /// Goes through the rounds: a single one, unless the sweep is adaptive.
    fn rounds(&self, schedule: Option<&Schedule>) -> Result<Swept, Failure> {
        let bar = ReplicateBar::new("sweeping");
        let mut swept = Swept {
            counts: vec![PhaseCounts::default(); self.conditions.len()],
            rounds: Vec::new(),
        };
        loop {
            let round = self.next_round(schedule, &swept.counts);
            if round.is_empty() {
                return Ok(swept);
            }
            let n_before = numbered(self.conditions, self.runs.duration_s, &swept.rounds).count();
            self.work_on(&round, (n_before as u64, &mut swept.counts), &bar)?;
            swept.rounds.push(round);
        }
    }

    fn next_round(&self, schedule: Option<&Schedule>, counts: &[PhaseCounts]) -> Round {
        let more = if let Some(schedule) = schedule {
            schedule.next_round(counts)
        } else {
            let missing = |counts: &PhaseCounts| self.runs.replicates - counts.total();
            counts.iter().map(missing).collect()
        };
        let piece = |(cell, more): (usize, u64)| {
            let n = counts[cell].total();
            Piece { cell, replicates: n..n + more }
        };
        more.into_iter().enumerate().map(piece).filter(|piece| piece.n_rows() > 0).collect()
    }

    /// Finishes the blocks of a round and counts their phases.
    ///
    /// # Arguments
    ///
    /// * `n_before` — blocks of the rounds before.
    fn work_on(
        &self,
        round: &Round,
        (n_before, counts): (u64, &mut Vec<PhaseCounts>),
        bar: &ReplicateBar,
    ) -> Result<(), Failure> {
        let n_rows_before: u64 = counts.iter().map(PhaseCounts::total).sum();
        let blocks = || {
            let blocks = blocks(self.conditions, self.runs.duration_s, round.iter().cloned());
            (n_before..).zip(blocks)
        };
        for (number, block) in blocks() {
            let kept = self.site.read(number, &block)?;
            count(counts, kept.iter().flatten());
        }
        let done: u64 = counts.iter().map(PhaseCounts::total).sum();
        let total = n_rows_before + round.iter().map(Piece::n_rows).sum::<u64>();
        let start = Progress { done: as_count(done), total: as_count(total) };
        if start.done == start.total {
            return Ok(());
        }
        let doing = if n_before > 0 { "sweeping on where it is uncertain" } else { "sweeping" };
        bar.begin(doing, start);
        let missing = blocks().filter(|(number, _)| !self.site.has(*number));
        self.run(missing, (start, counts), bar)
    }

    fn run(
        &self,
        missing: impl Iterator<Item = (u64, Block)> + Send,
        (start, counts): (Progress, &mut Vec<PhaseCounts>),
        bar: &ReplicateBar,
    ) -> Result<(), Failure> {
        let Runs { seed, duration_s, n_threads, .. } = self.runs;
        let work = Work { conditions: self.conditions, seed, duration_s, n_threads, start };
        let watch = Watch { progress: &|progress| bar.show(progress), cancel: self.cancel };
        let shared = Mutex::new(counts);
        let keep = |number, block: &Block, outcomes: Vec<ReplicateOutcome>| -> anyhow::Result<()> {
            self.site.keep(number, block, &outcomes)?;
            count(&mut shared.lock().expect("no thread panics while holding it"), &outcomes);
            Ok(())
        };
        let ending = run_blocks(work, missing, watch, &keep);
        let counts = shared.into_inner().expect("no thread panics while holding it");
        let n_kept: u64 = counts.iter().map(PhaseCounts::total).sum();
        match ending {
            Ok(Ending::Finished) => Ok(()),
            Ok(Ending::CalledOff) => Err(Failure::Other(with_help(
                format!(
                    "called off; {n_kept} of {} runs are kept in {}",
                    start.total,
                    self.folder.display()
                ),
                format!("go on with `{}`", unfinished::command(self.folder)),
            ))),
            Err(BlockError::Keep(error)) => Err(Failure::Other(kept(self.folder, error))),
            Err(BlockError::Sweep(error)) => {
                Err(Failure::Impossible { error, is_empty: n_kept == 0 })
            }
        }
    }
}

fn count<'a>(counts: &mut [PhaseCounts], outcomes: impl IntoIterator<Item = &'a ReplicateOutcome>) {
    for outcome in outcomes {
        counts[outcome.cell].add(outcome.phase);
    }
}

/// All blocks of some rounds with their numbers.
fn numbered<'a>(
    conditions: &'a [Conditions],
    duration_s: f64,
    rounds: &'a [Round],
) -> impl Iterator<Item = (u64, Block)> + 'a {
    // A round begins with a new block.
    let blocks =
        rounds.iter().flat_map(move |round| blocks(conditions, duration_s, round.iter().cloned()));
    (0..).zip(blocks)
}

fn as_count(number: u64) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}

/// An error after which nothing is lost.
fn kept(folder: &Path, error: anyhow::Error) -> anyhow::Error {
    WithHelp {
        message: format!(
            "the sweep in {} cannot go on; what is finished is kept",
            folder.display()
        ),
        help: format!("mend this and go on with `{}`", unfinished::command(folder)),
        cause: Some(error.into()),
    }
    .into()
}

/// Names the cell that cannot be simulated.
fn explain(name: &str, cells: &[Cell], error: SweepError) -> anyhow::Error {
    let (SweepError::Placement { cell, .. } | SweepError::Judge { cell, .. }) = &error;
    let cell = &cells[*cell];
    match error {
        SweepError::Placement { source, .. } => {
            with_help(format!("{name}: cell `{cell}`: {source}"), source.help())
        }
        SweepError::Judge { source, .. } => {
            anyhow::anyhow!("{name}: cell `{cell}` cannot be judged: {source}")
        }
    }
}
