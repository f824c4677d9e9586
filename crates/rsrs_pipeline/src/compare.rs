//! Holds recorded runs against the sweep that predicts them.

mod prediction;
pub mod report;
pub mod run_matching;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rsrs_core::diagram::{DiagramCell, PhaseCounts};
use rsrs_core::statistics::comparison::{CellRuns, Comparison};
use rsrs_core::statistics::next_experiment::next_step;
use rsrs_fleet::record::EndingKind;

pub(crate) use crate::compare::prediction::{Prediction, choose_again};
use crate::compare::report::{AtHand, Report, Runs, Simulated};
use crate::compare::run_matching::{Admitted, LABEL, admit, refuse};
use crate::label::{LabelOptions, Labelled, Labeller, label_bag, label_by};
use crate::sweep::folder;
use crate::sweep::result::SweepResult;

/// Which runs are compared with a sweep, and how.
#[derive(Clone, Debug)]
pub struct Options {
    /// Bags of runs: rosbag2 folders or single `.mcap` files.
    pub bags: Vec<PathBuf>,
    /// Whose labels of them count.
    pub labels: Labeller,
    /// Whether runs that went on without a robot that was lost count, too.
    pub with_lost_robots: bool,
    /// By how much real robots may mill less often than simulated ones and still support the claim, as
    /// a share from 0 to 0.5; to be chosen before the first run.
    pub margin: f64,
}

/// Compares recorded runs with the cells of a sweep that they belong to.
///
/// Whether a run counts is decided by what was recorded of its ending, before any bag is labelled.
///
/// # Arguments
///
/// * `folder` — that of the sweep.
///
/// # Errors
///
/// If the folder is not a sweep's; if bags are of another experiment, cannot be read, or cannot be
/// labelled: all of them, each with its reason.
pub fn compare(folder: &Path, options: &Options) -> anyhow::Result<Report> {
    let result = folder::read(folder)?;
    let prediction = Prediction::of(folder, &result)?;
    let (counted, others): (Vec<Admitted>, Vec<Admitted>) =
        admit(&result, &options.bags)?.into_iter().partition(|run| {
            let counts = run.record.counts_without(&run.ending.lost) || options.with_lost_robots;
            run.ending.kind == EndingKind::Completed && counts
        });
    let labelled = label_all(&counted, &options.labels)?;

    let mut real: BTreeMap<usize, PhaseCounts> = BTreeMap::new();
    for (run, labelled) in counted.iter().zip(&labelled) {
        real.entry(run.cell).or_default().add(labelled.phase);
    }
    let cell = |index: usize| result.diagram.cells[index].cell.clone();
    let simulated = real
        .keys()
        .map(|index| prediction.of_cell(*index))
        .collect::<anyhow::Result<Vec<Simulated>>>()?;
    let cells: Vec<CellRuns> = real
        .into_iter()
        .zip(&simulated)
        .map(|((index, real), simulated)| CellRuns {
            cell: cell(index),
            real,
            simulated: simulated.phases,
        })
        .collect();
    let comparison = Comparison::with_margin(&cells, options.margin);
    let next = next_step(&comparison, &cells, &not_run(&result, &cells));
    let counted =
        counted.into_iter().zip(labelled).map(|(run, label)| (cell(run.cell), run, label));
    let runs = Runs { counted: counted.collect(), others };
    let next = (next, AtHand::of(folder));
    let mut report = Report::new(&comparison, &cells, &simulated, runs, next);
    report.labels = options.labels.to_string();
    report.notes.extend(prediction.note());
    Ok(report)
}

/// The cells of a sweep that were not run.
///
/// The sweep's own replicates may flatter them, but no verdict rests on these.
fn not_run(result: &SweepResult, run: &[CellRuns]) -> Vec<CellRuns> {
    let is_left = |entry: &&DiagramCell| run.iter().all(|runs| runs.cell != entry.cell);
    let left = result.diagram.cells.iter().filter(is_left).map(|entry| CellRuns {
        cell: entry.cell.clone(),
        real: PhaseCounts::default(),
        simulated: entry.counts,
    });
    left.collect()
}

fn label_all(runs: &[Admitted], labeller: &Labeller) -> anyhow::Result<Vec<Labelled>> {
    let mut labelled = Vec::new();
    let mut refusals = Vec::new();
    for run in runs {
        let label = match labeller {
            Labeller::Judge => label_bag(&run.bag, LabelOptions::default()),
            Labeller::Human(who) => label_by(&run.bag, who),
        };
        match label {
            Ok(label) => labelled.push(label),
            Err(refusal) => refusals.push(refusal),
        }
    }
    refuse(LABEL, &refusals, runs.len())?;
    Ok(labelled)
}
