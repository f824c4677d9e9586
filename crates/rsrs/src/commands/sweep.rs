//! `rsrs sweep`: step 3, exploration.

use std::path::{Path, PathBuf};

use rsrs_core::adaptive::{Adaptive, Knowledge};
use rsrs_core::diagram::{PhaseCounts, PhaseDiagram};
use rsrs_core::phase::Phase;
use rsrs_sim::sweep::{Swept, Watch};
use serde::Serialize;

use crate::commands::{Format, report};
use crate::failure::{Outcome, with_help};
use crate::interrupt;
use crate::progress::{ReplicateBar, threads};
use crate::shard::Shard;
use crate::sweep_result::SweepResult;
use crate::sweep_source::ResolvedSweep;
use crate::sweeping::{knowledge, sweep_shard};
use crate::wording::counted;

pub use crate::sweeping::sweep_into;

/// Simulate every cell of a sweep into a phase diagram.
///
/// Every replicate follows from the seed, the cell and its own number: the folder is the same byte
/// for byte for any number of threads, however often the sweep was interrupted, and a cell keeps its
/// results when the grid around it changes. After Ctrl-C, a crash or a full disk, the same command
/// goes on where it was.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs sweep launch_configs/sweeps/flockbot_speed_turn.yaml -o results/flockbot
  rsrs sweep launch_configs/sweeps/flockbot_speed_turn.yaml -o results/precise --adaptive
  rsrs sweep results/flockbot/sweep.yaml -o results/flockbot     finish what was interrupted
  rsrs sweep sweep.yaml -o part_1 --shard 1/2                    one of two machines' part")]
pub struct Arguments {
    /// Sweep file (YAML), or the `sweep.yaml` of a result folder.
    sweep: PathBuf,
    /// Folder to make; it must not exist, unless it holds this very sweep.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Simulate on where the phase is uncertain, until every cell is certain.
    ///
    /// The sweep file's `replicates` are what each cell begins with. A cell has enough when its
    /// interval is narrow or its phase is settled; next to a cell on the other side of one half, it
    /// must be narrow. The intervals hold although the runs decided their number.
    #[arg(long)]
    adaptive: bool,
    /// Width of an interval of `B_s` that is narrow enough, as a share (default: 0.2).
    #[arg(long, value_name = "SHARE", requires = "adaptive")]
    width: Option<f64>,
    /// Replicates that a cell gets at most (default: 1000).
    #[arg(long, value_name = "N", requires = "adaptive")]
    most_replicates: Option<u64>,
    /// Simulate only every N-th part, the I-th, and leave it for `rsrs merge`.
    ///
    /// So a sweep is spread over machines: each makes a folder of its own.
    #[arg(long, value_name = "I/N", conflicts_with = "adaptive")]
    shard: Option<Shard>,
    /// Threads (default: as many as the machine runs at once).
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

#[derive(Serialize)]
struct Report {
    folder: PathBuf,
    cells: usize,
    /// Of each cell; of an adaptive sweep, those it begins with.
    replicates: u64,
    /// Replicates of all cells.
    runs: u64,
    phases: Vec<(Phase, usize)>,
    /// How cells ended, of an adaptive sweep.
    #[serde(skip_serializing_if = "Option::is_none")]
    adaptive: Option<Endings>,
}

#[derive(Serialize)]
struct ShardReport {
    folder: PathBuf,
    shard: String,
    /// Replicates of this shard; `None` where the folder holds the whole sweep.
    runs: Option<u64>,
}

/// How many cells of an adaptive sweep ended how.
#[derive(Clone, Copy, Serialize)]
struct Endings {
    settled: usize,
    narrow: usize,
    exhausted: usize,
}

/// Runs the command.
///
/// # Errors
///
/// If a file is wrong, a cell cannot be simulated, or the folder cannot be written.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let name = arguments.sweep.display().to_string();
    let mut source = ResolvedSweep::read_either(&arguments.sweep)?;
    if arguments.adaptive {
        source.sweep.adaptive = Some(arguments.adapt(source.sweep.adaptive.unwrap_or_default()));
        source.sweep.check(&name)?;
    }
    let n_threads = threads(arguments.threads);
    if let Some(shard) = arguments.shard {
        return run_shard(arguments, (&name, &source), (shard, n_threads));
    }
    let result = sweep_into(&arguments.output, (&name, source), n_threads)?;
    tell(arguments.format, &arguments.output, &result)?;
    Ok(Outcome::Done)
}

/// Reports a finished sweep.
///
/// # Errors
///
/// If standard output cannot be written.
pub fn tell(format: Format, folder: &Path, result: &SweepResult) -> anyhow::Result<()> {
    report(format, &summary(folder, result), &text(folder, result))
}

fn run_shard(
    arguments: &Arguments,
    source: (&str, &ResolvedSweep),
    (shard, n_threads): (Shard, usize),
) -> anyhow::Result<Outcome> {
    let folder = arguments.output.clone();
    let runs = sweep_shard(&folder, source, (shard, n_threads))?;
    let text = match runs {
        Some(runs) => format!(
            "shard {shard}: {}\nnext, with all shards in one place: rsrs merge {} … -o DIR",
            counted(runs, "run"),
            folder.display()
        ),
        None => format!("{} holds the whole sweep; no shard was needed", folder.display()),
    };
    let summary = ShardReport { folder, shard: shard.to_string(), runs };
    report(arguments.format, &summary, &text)?;
    Ok(Outcome::Done)
}

/// Runs simulations under a progress bar and Ctrl-C.
///
/// # Errors
///
/// That of the simulations, or that they were called off.
pub fn watched<E: std::error::Error + Send + Sync + 'static>(
    doing: &str,
    work: impl FnOnce(Watch<'_>) -> Result<Swept, E>,
) -> anyhow::Result<Swept> {
    let bar = ReplicateBar::new(doing);
    let cancel = interrupt::listen()?;
    let swept = work(Watch { progress: &|progress| bar.show(progress), cancel })?;
    if swept.is_cancelled {
        return Err(with_help("called off; nothing was written", "run the same command again"));
    }
    Ok(swept)
}

/// How many cells have which phase as their most frequent one.
pub fn majorities(diagram: &PhaseDiagram) -> Vec<(Phase, usize)> {
    let n =
        |phase| diagram.cells.iter().filter(|entry| entry.counts.majority() == Some(phase)).count();
    Phase::ALL.into_iter().map(|phase| (phase, n(phase))).collect()
}

impl Arguments {
    /// What the command line says of an adaptive sweep, before what the file says.
    fn adapt(&self, file: Adaptive) -> Adaptive {
        Adaptive {
            width: self.width.unwrap_or(file.width),
            most_replicates: self.most_replicates.unwrap_or(file.most_replicates),
        }
    }
}

fn endings(result: &SweepResult) -> Option<Endings> {
    let knowledge = knowledge(result)?;
    let n = |sought| knowledge.iter().filter(|found| **found == sought).count();
    Some(Endings {
        settled: n(Knowledge::Settled),
        narrow: n(Knowledge::Narrow),
        exhausted: n(Knowledge::Exhausted),
    })
}

fn n_runs(result: &SweepResult) -> impl Iterator<Item = u64> + '_ {
    result.diagram.cells.iter().map(|entry| &entry.counts).map(PhaseCounts::total)
}

fn summary(folder: &Path, result: &SweepResult) -> Report {
    Report {
        folder: folder.to_path_buf(),
        cells: result.diagram.cells.len(),
        replicates: result.source.sweep.replicates,
        runs: n_runs(result).sum(),
        phases: majorities(&result.diagram),
        adaptive: endings(result),
    }
}

fn text(folder: &Path, result: &SweepResult) -> String {
    let phases: Vec<String> = majorities(&result.diagram)
        .into_iter()
        .filter(|(_, n)| *n > 0)
        .map(|(phase, n)| format!("{n} {phase}"))
        .collect();
    let folder = folder.display();
    let sweep = &result.source.sweep;
    let replicates = match endings(result) {
        None => format!("{} replicates of {} s", sweep.replicates, sweep.duration_s),
        Some(endings) => format!(
            "{} to {} replicates of {} s, {} in all ({} cells settled, {} narrow, {} at the most)",
            n_runs(result).min().unwrap_or(0),
            n_runs(result).max().unwrap_or(0),
            sweep.duration_s,
            n_runs(result).sum::<u64>(),
            endings.settled,
            endings.narrow,
            endings.exhausted
        ),
    };
    format!(
        "{} cells × {replicates}: {}\n{folder}/diagram.svg\n{folder}/cells.csv\n\
         {folder}/replicates.parquet\nnext: rsrs choose {folder} -o {folder}/choice.json",
        result.diagram.cells.len(),
        phases.join(", "),
    )
}
