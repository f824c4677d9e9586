//! Holds recorded runs against the sweep that predicts them.

pub mod report;
pub mod run_matching;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rsrs_core::diagram::choice::Choice;
use rsrs_core::diagram::{DiagramCell, PhaseCounts};
use rsrs_core::statistics::comparison::{CellRuns, Comparison};
use rsrs_core::statistics::next_experiment::next_step;
use rsrs_fleet::record::EndingKind;

use crate::compare::report::{Report, Runs, Simulated};
use crate::compare::run_matching::{Admitted, LABEL, admit, refuse};
use crate::error::with_help;
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
            let is_whole = run.ending.lost.is_empty() || options.with_lost_robots;
            run.ending.kind == EndingKind::Completed && is_whole
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

/// The cells of a sweep.
struct Prediction<'a> {
    folder: &'a Path,
    result: &'a SweepResult,
    /// The chosen cell, by its index in the diagram.
    chosen: Option<(usize, Choice)>,
}

impl<'a> Prediction<'a> {
    fn of(folder: &'a Path, result: &'a SweepResult) -> anyhow::Result<Self> {
        let chosen = match folder::read_choice(folder)? {
            None => None,
            Some(choice) => {
                let SweepResult { source, .. } = result;
                let digest = choice.sweep_digest.as_deref();
                source.sweep.check_choice(&source.profile, digest).map_err(|error| {
                    let message = format!("choice.json in {} {error}", folder.display());
                    with_help(message, choose_again(folder))
                })?;
                let index = result.diagram.locate(&choice.cell).map_err(|error| {
                    let message =
                        format!("choice.json in {} is of another sweep: {error}", folder.display());
                    with_help(message, choose_again(folder))
                })?;
                Some((index, choice))
            }
        };
        Ok(Self { folder, result, chosen })
    }

    fn note(&self) -> Option<String> {
        let folder = self.folder.display();
        let Some((_, choice)) = &self.chosen else {
            return Some(format!(
                "{folder} has no choice.json; a cell that was picked from this sweep looks better \
                 than it is, until `rsrs choose {folder} -o {folder}/choice.json` confirms it"
            ));
        };
        let measured = choice.as_measured.filter(|_| choice.worse_is_better())?;
        Some(format!(
            "in the chosen cell, simulated robots as measured mill in {:.1} % of {} runs, and made \
             worse in {:.1} %: being worse helps there, and fewer real mills need no other reason",
            100.0 * measured.share,
            measured.n_replicates,
            100.0 * choice.b_s
        ))
    }

    /// Replicates of the sweep; of the chosen cell its fresh ones, because those of the sweep have
    /// chosen it and flatter it.
    fn of_cell(&self, index: usize) -> anyhow::Result<Simulated> {
        match &self.chosen {
            Some((chosen, choice)) if *chosen == index => match choice.phases {
                Some(phases) => Ok(Simulated { phases, is_confirmed: true }),
                None => Err(with_help(
                    format!(
                        "choice.json in {} does not say how its fresh runs ended",
                        self.folder.display()
                    ),
                    choose_again(self.folder),
                )),
            },
            _ => Ok(Simulated {
                phases: self.result.diagram.cells[index].counts,
                is_confirmed: false,
            }),
        }
    }
}

fn choose_again(folder: &Path) -> String {
    let folder = folder.display();
    format!("choose again: `rsrs choose {folder} -o {folder}/choice.json`")
}
