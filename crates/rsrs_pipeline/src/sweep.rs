//! Step 3, exploration: every cell of a sweep into a phase diagram. The work goes in rounds of blocks,
//! each kept as soon as it is finished.

pub mod ablation;
pub mod folder;
pub mod merge;
pub mod replicate_table;
pub mod result;
pub mod settling;
pub mod shard;
pub mod share_difference;
pub mod source;

use std::path::Path;
use std::sync::Mutex;

use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::adaptive::{Knowledge, Schedule};
use rsrs_core::diagram::sweep_file::{Axes, SweepFile};
use rsrs_core::diagram::{DiagramCell, PhaseDiagram};
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::judge::phase::JudgeError;
use rsrs_core::quantity::Cell;
use rsrs_sim::sweep::{
    Block, BlockError, CellReplicates, Completion, Progress, ReplicateOutcome, Runs, SweepError,
    Watch, Work, blocks, check, run_blocks,
};

use crate::error::{WithHelp, helped, with_help};
use crate::execution::{Execution, RunCounter};
use crate::sweep::folder::unfinished::{self, FolderState, Unfinished};
use crate::sweep::result::SweepResult;
use crate::sweep::shard::Shard;
use crate::sweep::source::ResolvedSweep;

/// Draws the results of a sweep into a folder.
pub type Draw = fn(&Path, &SweepResult) -> anyhow::Result<()>;

/// Sweeps into a folder: from its beginning, from where it was interrupted, or not at all if the
/// results of this very sweep are there.
///
/// Errors call the sweep `name`; `draw` draws the results beside their tables.
///
/// # Errors
///
/// If a cell cannot be simulated, the folder holds anything else, it cannot be written, or the
/// sweep is called off; after the last two it can be resumed.
pub fn sweep_into(
    folder: &Path,
    name: &str,
    source: ResolvedSweep,
    execution: Execution<'_>,
    draw: Draw,
) -> anyhow::Result<SweepResult> {
    let plan = Plan::new(name, &source, execution.n_threads)?;
    let unfinished = match unfinished::open(folder, &source)? {
        FolderState::Finished => return folder::read(folder),
        FolderState::Unfinished(unfinished) => unfinished,
    };
    let sweeping =
        Sweeping { plan: &plan, unfinished: &unfinished, folder, shard: None, execution };
    let schedule = source
        .sweep
        .adaptive
        .map(|adaptive| Schedule::new(adaptive, plan.runs.replicates, &plan.cells));
    match sweeping.rounds(schedule.as_ref()) {
        Ok(SweptRounds { counts, rounds }) => {
            let result = plan.result(source, &counts);
            let work = plan.numbered(&rounds);
            let command = unfinished::command(folder);
            unfinished
                .finish(&result, work, (execution.n_threads, draw))
                .map_err(|error| kept(folder, &command, error))?;
            Ok(result)
        }
        Err(failure) => Err(plan.give_up(name, unfinished, failure)),
    }
}

/// Sweeps into no folder, at most 100 runs of each cell; cells in which the robots find no place are left out.
pub fn sweep_in_memory(
    name: &str,
    mut source: ResolvedSweep,
    execution: Execution<'_>,
) -> anyhow::Result<SweepResult> {
    let mut cells = source.cells(name)?;
    let n_cells = cells.len();
    let SweepFile { seed, duration_s, .. } = source.sweep;
    let runs = Runs { seed, replicates: 1, duration_s, n_threads: 1 };
    let mut why = None;
    cells.retain(|(_, conditions)| match check(std::slice::from_ref(conditions), runs) {
        Ok(()) => true,
        Err(error) => {
            why.get_or_insert(error);
            false
        }
    });
    if let Some(why) = why.filter(|_| cells.is_empty()) {
        return Err(with_help(
            format!("{name}: in none of {n_cells} settings can these robots be simulated: {why}"),
            "name settings in which they can with `--sweep SWEEP`",
        ));
    }
    let cells = cells.into_iter().map(|(cell, _)| cell).collect();
    source.sweep =
        SweepFile { cells: Some(cells), axes: Axes::default(), adaptive: None, ..source.sweep };
    source.sweep.replicates = source.sweep.replicates.min(ENOUGH);
    let plan = Plan::new(name, &source, execution.n_threads)?;
    let doing = "looking for the best setting";
    let Runs { seed, replicates, duration_s, .. } = plan.runs;
    let swept = execution.simulate(doing, &plan.conditions, (seed, replicates), duration_s)?;
    Ok(plan.result(source, &swept.counts(plan.conditions.len())))
}

/// Runs of each cell of a sweep into no folder, in each world, at most.
const ENOUGH: u64 = 100;

/// Does one machine's part of a sweep as [`sweep_into`] does all of it, leaves it in its folder for
/// [`merge`], and returns how many replicates that is; `None` if the folder holds the whole sweep.
///
/// An adaptive sweep is refused, because its work follows from what all machines find.
///
/// [`merge`]: crate::sweep::merge::merge
pub fn sweep_shard(
    folder: &Path,
    name: &str,
    source: &ResolvedSweep,
    shard: Shard,
    execution: Execution<'_>,
) -> anyhow::Result<Option<u64>> {
    if source.sweep.adaptive.is_some() {
        return Err(with_help(
            format!(
                "{name}: an adaptive sweep has no shards: what it simulates next follows from all of it"
            ),
            "sweep it on one machine, or without `adaptive`",
        ));
    }
    let plan = Plan::new(name, source, execution.n_threads)?;
    let unfinished = match unfinished::open(folder, source)? {
        FolderState::Finished => return Ok(None),
        FolderState::Unfinished(unfinished) => unfinished,
    };
    let mut counts = vec![PhaseCounts::default(); plan.conditions.len()];
    let sweeping =
        Sweeping { plan: &plan, unfinished: &unfinished, folder, shard: Some(shard), execution };
    let round = plan.first_round();
    match sweeping.work_on(&round, 0, &mut counts, &*execution.observer.count("sweeping", "runs")) {
        Ok(()) => Ok(Some(counts.iter().map(PhaseCounts::total).sum())),
        Err(failure) => Err(plan.give_up(name, unfinished, failure)),
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

pub(crate) struct Plan {
    cells: Vec<Cell>,
    /// Those of all cells with the robots made worse, and after them those of all cells with the
    /// robots as measured, if they are others.
    conditions: Vec<Conditions>,
    runs: Runs,
}

/// Replicates of a round, by cell.
type Round = Vec<CellReplicates>;

impl Plan {
    /// What a sweep asks for; errors call its file `name`.
    pub fn new(name: &str, source: &ResolvedSweep, n_threads: usize) -> anyhow::Result<Self> {
        let (cells, mut conditions): (Vec<Cell>, Vec<Conditions>) =
            source.cells(name)?.into_iter().unzip();
        if let Some(measured) = source.as_measured() {
            conditions.extend(measured.cells(name)?.into_iter().map(|(_, conditions)| conditions));
        }
        let runs = Runs {
            seed: source.sweep.seed,
            replicates: source.sweep.replicates,
            duration_s: source.sweep.duration_s,
            n_threads,
        };
        check(&conditions, runs).map_err(|error| explain(name, &cells, error))?;
        Ok(Self { cells, conditions, runs })
    }

    /// All blocks with their numbers, of a sweep that is not adaptive.
    pub fn blocks(&self) -> impl Iterator<Item = (u64, Block)> + '_ {
        (0..).zip(blocks(&self.conditions, self.runs.duration_s, self.first_round()))
    }

    /// What came out, from the counts in the order of the conditions.
    fn result(&self, source: ResolvedSweep, counts: &[PhaseCounts]) -> SweepResult {
        let axes = source.sweep.swept_axes();
        let diagram = |counts: &[PhaseCounts]| PhaseDiagram {
            axes: axes.clone(),
            cells: (self.cells.iter().cloned().zip(counts))
                .map(|(cell, counts)| DiagramCell { cell, counts: *counts })
                .collect(),
        };
        let mut worlds = counts.chunks(self.cells.len()).map(diagram);
        let simulated = worlds.next().expect("a sweep has cells");
        SweepResult { diagram: simulated, as_measured: worlds.next(), source }
    }

    fn first_round(&self) -> Round {
        let cells = 0..self.conditions.len();
        cells.map(|cell| CellReplicates { cell, replicates: 0..self.runs.replicates }).collect()
    }

    /// All blocks of some rounds with their numbers.
    fn numbered<'a>(&'a self, rounds: &'a [Round]) -> impl Iterator<Item = (u64, Block)> + 'a {
        // A round begins with a new block.
        let blocks = rounds.iter().flat_map(|round| {
            blocks(&self.conditions, self.runs.duration_s, round.iter().cloned())
        });
        (0..).zip(blocks)
    }

    /// Ends a sweep that failed, with the cause.
    fn give_up(&self, name: &str, unfinished: Unfinished, failure: Failure) -> anyhow::Error {
        match failure {
            Failure::Impossible { error, is_empty } => {
                // It will never be finished; what it has so far, if anything, is not thrown away.
                let abandoned = if is_empty { unfinished.abandon() } else { Ok(()) };
                abandoned.err().unwrap_or_else(|| explain(name, &self.cells, error))
            }
            Failure::Other(error) => error,
        }
    }
}

struct Sweeping<'a> {
    plan: &'a Plan,
    unfinished: &'a Unfinished,
    folder: &'a Path,
    /// What of it is done here, if not all.
    shard: Option<Shard>,
    execution: Execution<'a>,
}

struct SweptRounds {
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
    /// The command that goes on with this work.
    fn command(&self) -> String {
        let command = unfinished::command(self.folder);
        match self.shard {
            None => command,
            Some(shard) => format!("{command} --shard {shard}"),
        }
    }

    /// Goes through the rounds: a single one, unless the sweep is adaptive.
    fn rounds(&self, schedule: Option<&Schedule>) -> Result<SweptRounds, Failure> {
        let counter = self.execution.observer.count("sweeping", "runs");
        let mut swept = SweptRounds {
            counts: vec![PhaseCounts::default(); self.plan.conditions.len()],
            rounds: Vec::new(),
        };
        loop {
            let round = self.next_round(schedule, &swept.counts);
            if round.is_empty() {
                return Ok(swept);
            }
            let n_before = self.plan.numbered(&swept.rounds).count();
            self.work_on(&round, n_before as u64, &mut swept.counts, &*counter)?;
            swept.rounds.push(round);
        }
    }

    fn next_round(&self, schedule: Option<&Schedule>, counts: &[PhaseCounts]) -> Round {
        let Some(schedule) = schedule else {
            let is_done = counts.iter().all(|counts| counts.total() == self.plan.runs.replicates);
            return if is_done { Round::new() } else { self.plan.first_round() };
        };
        let piece = |(cell, more): (usize, u64)| {
            let n = counts[cell].total();
            CellReplicates { cell, replicates: n..n + more }
        };
        // Each world decides for itself where it is uncertain.
        let worlds = counts.chunks(self.plan.cells.len());
        let more = worlds.flat_map(|counts| schedule.next_round(counts));
        more.enumerate().map(piece).filter(|piece| piece.n_rows() > 0).collect()
    }

    /// Finishes the blocks of a round, which come after `n_before` of the rounds before, and counts
    /// their phases.
    fn work_on(
        &self,
        round: &Round,
        n_before: u64,
        counts: &mut Vec<PhaseCounts>,
        counter: &dyn RunCounter,
    ) -> Result<(), Failure> {
        let n_rows_before: u64 = counts.iter().map(PhaseCounts::total).sum();
        let Plan { conditions, runs, .. } = self.plan;
        let is_ours = |number| self.shard.is_none_or(|shard| shard.has(number));
        let blocks = || {
            let blocks = blocks(conditions, runs.duration_s, round.iter().cloned());
            (n_before..).zip(blocks).filter(|(number, _)| is_ours(*number))
        };
        for (number, block) in blocks() {
            let kept = self.unfinished.read(number, &block)?;
            count(counts, kept.iter().flatten());
        }
        let done: u64 = counts.iter().map(PhaseCounts::total).sum();
        let total = n_rows_before + blocks().map(|(_, block)| block.n_rows()).sum::<u64>();
        let start = Progress { done: as_count(done), total: as_count(total) };
        if start.done == start.total {
            return Ok(());
        }
        let doing = if n_before > 0 { "sweeping on where it is uncertain" } else { "sweeping" };
        counter.begin(doing, start);
        let missing = blocks().filter(|(number, _)| !self.unfinished.has(*number));
        self.run(missing, start, counts, counter)
    }

    fn run(
        &self,
        missing: impl Iterator<Item = (u64, Block)> + Send,
        start: Progress,
        counts: &mut Vec<PhaseCounts>,
        counter: &dyn RunCounter,
    ) -> Result<(), Failure> {
        let Runs { seed, duration_s, n_threads, .. } = self.plan.runs;
        let (conditions, also) = (&self.plan.conditions[..], &[][..]);
        let work = Work { conditions, seed, duration_s, n_threads, start, also };
        let watch = Watch {
            progress: &|progress| counter.show(progress),
            cancel: self.execution.observer.cancel(),
        };
        let shared = Mutex::new(counts);
        let keep = |number, block: &Block, outcomes: Vec<ReplicateOutcome>| -> anyhow::Result<()> {
            self.unfinished.keep(number, block, &outcomes)?;
            count(&mut shared.lock().expect("no thread panics while holding it"), &outcomes);
            Ok(())
        };
        let ending = run_blocks(work, missing, watch, &keep);
        let counts = shared.into_inner().expect("no thread panics while holding it");
        let n_kept: u64 = counts.iter().map(PhaseCounts::total).sum();
        match ending {
            Ok(Completion::Finished) => Ok(()),
            Ok(Completion::CalledOff) => Err(Failure::Other(with_help(
                format!(
                    "interrupted; {n_kept} of {} runs are kept in {}",
                    start.total,
                    self.folder.display()
                ),
                format!("go on with `{}`", self.command()),
            ))),
            Err(BlockError::KeepBlock(error)) => {
                Err(Failure::Other(kept(self.folder, &self.command(), error)))
            }
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

fn as_count(number: u64) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}

/// An error after which nothing is lost.
fn kept(folder: &Path, command: &str, error: anyhow::Error) -> anyhow::Error {
    helped(WithHelp {
        message: format!(
            "the sweep in {} cannot go on; what is finished is kept",
            folder.display()
        ),
        help: format!("mend this and go on with `{command}`"),
        cause: Some(error.into()),
    })
}

/// Names the cell that cannot be simulated.
fn explain(name: &str, cells: &[Cell], error: SweepError) -> anyhow::Error {
    let (SweepError::Placement { cell, .. } | SweepError::Judge { cell, .. }) = &error;
    let cell = &cells[cell % cells.len()];
    match error {
        SweepError::Placement { source, .. } => {
            let message = format!("{name}: cell `{cell}`: {source}");
            helped(source).context(message)
        }
        SweepError::Judge { source, .. } => {
            let message = format!("{name}: cell `{cell}` cannot be judged: {source}");
            match source {
                JudgeError::NoObjects { .. } => with_help(
                    message,
                    "name a world that has some: `world: world.yaml` with `objects: [{count: 20, radius_m: 0.05}]`",
                ),
                JudgeError::NoGoals { .. } => with_help(
                    message,
                    "name a world that has some: `world: world.yaml` with `goals: [{place_m: [1, 0], radius_m: 0.3}]`",
                ),
                JudgeError::NoClasses { .. } => with_help(
                    message,
                    "name a world that has some: `world: world.yaml` with `classes: [{name: a}, {name: b}]`",
                ),
                JudgeError::NoArena { .. } => with_help(
                    message,
                    "give it one: `fixed: {arena_m: 3, walls: stop}`, of so many metres a side",
                ),
                JudgeError::TooShort { window, .. } => {
                    let least = window.least_s();
                    let message = format!("{name}: runs are too short to be judged: {source}");
                    with_help(message, format!("give them `duration_s: {least}` or more"))
                }
                _ => anyhow::anyhow!(message),
            }
        }
    }
}
