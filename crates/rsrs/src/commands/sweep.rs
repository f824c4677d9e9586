//! `rsrs sweep`: step 3, exploration.

use std::path::{Path, PathBuf};

use rsrs_core::axis::Cell;
use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::{DiagramCell, PhaseDiagram};
use rsrs_core::phase::Phase;
use rsrs_sim::sweep::{Runs, Swept, Watch};
use serde::Serialize;

use crate::commands::{Format, report};
use crate::failure::{Outcome, with_help};
use crate::interrupt;
use crate::progress::{ReplicateBar, threads};
use crate::result_folder::{self, Existing, SweepResult};
use crate::sweep_source::ResolvedSweep;

/// Simulate every cell of a sweep into a phase diagram.
///
/// Every replicate follows from the seed, the cell and its own number: the folder is the same byte
/// for byte for any number of threads, and a cell keeps its results when the grid around it changes.
#[derive(clap::Args)]
pub struct Arguments {
    /// Sweep file (YAML).
    sweep: PathBuf,
    /// Folder to make; it must not exist, unless it holds this very sweep.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
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
    replicates: u64,
    phases: Vec<(Phase, usize)>,
}

/// Runs the command.
///
/// # Errors
///
/// If a file is wrong, a cell cannot be simulated, or the folder cannot be written.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let source = ResolvedSweep::read(&arguments.sweep)?;
    let name = arguments.sweep.display().to_string();
    let result = sweep_into(&arguments.output, (&name, source), threads(arguments.threads))?;
    report(arguments.format, &summary(arguments, &result), &text(arguments, &result))?;
    Ok(Outcome::Done)
}

/// Sweeps into a folder; one that holds this very sweep is only read.
///
/// # Arguments
///
/// * `folder` — the folder to make.
/// * `source` — the sweep, after a name for errors.
/// * `n_threads` — how many to run on.
///
/// # Errors
///
/// If a cell cannot be simulated, the folder holds anything else, or it cannot be written.
pub fn sweep_into(
    folder: &Path,
    (name, source): (&str, ResolvedSweep),
    n_threads: usize,
) -> anyhow::Result<SweepResult> {
    let cells = source.cells(name)?;
    if result_folder::look(folder, &source)? == Existing::SameSweep {
        return result_folder::read(folder);
    }
    let (cells, conditions): (Vec<Cell>, Vec<Conditions>) = cells.into_iter().unzip();
    let runs = Runs {
        seed: source.sweep.seed,
        replicates: source.sweep.replicates,
        duration_s: source.sweep.duration_s,
        n_threads,
    };
    let swept = watched("sweeping", |watch| rsrs_sim::sweep::sweep(&conditions, runs, watch))?;
    let counts = swept.counts(cells.len());
    let cells = cells.into_iter().zip(counts).map(|(cell, counts)| DiagramCell { cell, counts });
    let diagram = PhaseDiagram { axes: source.sweep.swept_axes(), cells: cells.collect() };
    let result = SweepResult { source, diagram };
    result_folder::write(folder, &result, &swept)?;
    Ok(result)
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

fn summary(arguments: &Arguments, result: &SweepResult) -> Report {
    Report {
        folder: arguments.output.clone(),
        cells: result.diagram.cells.len(),
        replicates: result.source.sweep.replicates,
        phases: majorities(&result.diagram),
    }
}

fn text(arguments: &Arguments, result: &SweepResult) -> String {
    let phases: Vec<String> = majorities(&result.diagram)
        .into_iter()
        .filter(|(_, n)| *n > 0)
        .map(|(phase, n)| format!("{n} {phase}"))
        .collect();
    let folder = arguments.output.display();
    format!(
        "{} cells × {} replicates of {} s: {}\n{folder}/diagram.svg\n{folder}/cells.csv\n\
         {folder}/replicates.parquet\nnext: rsrs choose {folder} -o {folder}/choice.json",
        result.diagram.cells.len(),
        result.source.sweep.replicates,
        result.source.sweep.duration_s,
        phases.join(", "),
    )
}
