//! Holds recorded runs against the sweep that predicts them.

pub mod at_hand;
pub mod fixed;
pub mod not_counted;
pub mod prediction;
pub mod run_matching;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rsrs_core::comparison::left_out::{Attempts, CellAttempts};
use rsrs_core::comparison::next_experiment::{NextStep, next_step, return_to_step_1};
use rsrs_core::comparison::{CellRuns, Verdict};
use rsrs_core::diagram::DiagramCell;
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::quantity::Cell;
use rsrs_core::robot::other_profile::OtherProfile;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::statistics::share::Share;

use crate::compare::at_hand::AtHand;
use crate::compare::fixed::FixedCampaign;
use crate::compare::not_counted::{LeftOutRun, NotCountedCause};
use crate::compare::prediction::{Note, Prediction, Simulated};
use crate::compare::run_matching::{Admitted, admit};
use crate::error::{help_of, in_one_line};
use crate::label::{LabelOptions, Labelled, Labeller, label_bag, label_by};
use crate::sweep::folder;
use crate::sweep::result::SweepResult;

/// Which runs are compared with a sweep, and how.
#[derive(Clone, Debug)]
pub struct CompareOptions {
    /// Bags of runs: rosbag2 folders or single `.mcap` files.
    pub bags: Vec<PathBuf>,
    /// Whose labels of them count.
    pub labels: Labeller,
    /// Whether runs that went on without a robot that was lost count, too.
    pub with_lost_robots: bool,
    /// Whether runs count whose poses cannot be those of the commanded robots, or of which a robot did not
    /// move.
    pub with_implausible: bool,
    /// By how much real robots may mill less often than simulated ones and still support the claim, as
    /// a share from 0 to 0.5, to be chosen before the first run; `None` takes the one that was fixed, or
    /// [`MARGIN`](rsrs_core::comparison::MARGIN).
    pub margin: Option<f64>,
    /// Where poses come from; `None` takes the source by which each run went.
    pub poses: Option<PoseSource>,
    /// What to do about runs of robots with another profile than that of the sweep.
    pub other_profile: OtherProfile,
}

/// Recorded runs, held against a sweep.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// What follows from all runs together, whatever those that were left out after their start would
    /// have come to; of a campaign whose number of runs was fixed, what its test comes to.
    pub verdict: Verdict,
    /// The statistics, with what they rest on.
    pub attempts: Attempts,
    /// The simulated runs of each cell that was compared.
    pub simulated: Vec<Simulated>,
    /// The runs.
    pub runs: Runs,
    /// Whose labels count.
    pub labels: Labeller,
    /// Where the campaign stands, if its number of runs was fixed before the first: the verdict rests on
    /// its test then, and not on the evidence.
    pub fixed: Option<FixedCampaign>,
    /// The experiment that is most informative, or back to the robots.
    pub next: NextStep,
    /// The files by which it is run.
    pub at_hand: AtHand,
    /// What is to be noted about the choice of the cell.
    pub note: Option<Note>,
}

/// The runs of a comparison.
#[derive(Clone, Debug, Default)]
pub struct Runs {
    /// Those that count, with cell and label.
    pub counted: Vec<(Cell, Admitted, Labelled)>,
    /// Those that do not.
    pub left_out: Vec<LeftOutRun>,
}

/// Compares recorded runs with the cells of the sweep in a folder that they belong to.
///
/// Whether a run counts is decided by what was recorded of its ending, before any bag is labelled;
/// one that cannot be labelled then does not count either, nor one whose poses or motions cannot be
/// those that were commanded. What was left out for a cause after its start may have ended in any
/// way, and a verdict stands only if it stands whatever that was
/// ([`rsrs_core::comparison::left_out`]).
///
/// Bags that are of another experiment, or cannot be read, are an error that has all of them, each
/// with its reason.
pub fn compare(folder: &Path, options: &CompareOptions) -> anyhow::Result<Comparison> {
    let result = folder::read(folder)?;
    let prediction = Prediction::new(folder, &result)?;
    let cell = |index: usize| &result.diagram.cells[index].cell;
    let mut runs = Runs::default();
    let admitted = admit(&result, &options.bags, options.other_profile)?;
    let design = fixed::design(&admitted)?;
    let margin = fixed::margin(options.margin, design)?;
    let at_hand = AtHand::new(folder, &admitted);
    for run in admitted {
        let of_cell = cell(run.cell);
        let counts = |cause: &NotCountedCause| {
            *cause == NotCountedCause::RobotLost && options.with_lost_robots
        };
        match run.cause().filter(|(cause, _)| !counts(cause)) {
            Some(cause) => runs.left_out.push(run.left_out(of_cell, cause)),
            None => match label(&run, options) {
                Ok(labelled) => match implausible(&labelled, options) {
                    Some(cause) => runs.left_out.push(run.left_out(of_cell, cause)),
                    None => runs.counted.push((of_cell.clone(), run, labelled)),
                },
                Err(error) => {
                    let cause = (NotCountedCause::NotLabelled, without_bag(&run.bag, &error));
                    runs.left_out.push(run.left_out(of_cell, cause));
                }
            },
        }
    }

    let mut real: BTreeMap<usize, (PhaseCounts, u64)> = BTreeMap::new();
    for (_, run, labelled) in &runs.counted {
        real.entry(run.cell).or_default().0.add(labelled.phase);
    }
    for run in runs.left_out.iter().filter(|run| run.not_counted.after_start) {
        real.entry(run.cell).or_default().1 += 1;
    }
    let mut simulated = Vec::new();
    let mut cells = Vec::new();
    for (index, (real, n_left_out)) in real {
        let of_cell = prediction.of_cell(index)?;
        if real.total() > 0 {
            simulated.push(of_cell);
        }
        let cell = cell(index).clone();
        cells.push(CellAttempts {
            runs: CellRuns { cell, real, simulated: of_cell.phases, part: prediction.part(index) },
            n_left_out,
        });
    }
    let attempts = Attempts::with_margin(&cells, margin);
    let (comparison, deciding) = attempts.deciding();
    let as_measured = |cell: &Cell| {
        let index = result.diagram.locate(cell).ok();
        index.and_then(|index| prediction.as_measured(index)).unwrap_or_default()
    };
    let others = not_run(&result, &prediction, deciding);
    let share = |index| Ok(Share::milling(&prediction.of_cell(index)?.phases));
    let fixed = design.map(|design| FixedCampaign::new(design, &runs, share)).transpose()?;
    // The test of a design is given once, and there is no verdict before, nor one for a cell by itself.
    let next = match &fixed {
        None => next_step(comparison, deciding, &others, &as_measured),
        Some(fixed) if fixed.verdict == Verdict::Violated => return_to_step_1(&attempts.counted),
        Some(_) => NextStep::Nothing,
    };
    Ok(Comparison {
        verdict: fixed.as_ref().map_or_else(|| attempts.verdict(), |fixed| fixed.verdict),
        attempts,
        simulated,
        runs,
        labels: options.labels.clone(),
        fixed,
        next,
        at_hand,
        note: prediction.note(),
    })
}

/// The cells of a sweep that were not run, with the simulated runs that theirs would be compared with;
/// the sweep's own where a choice does not state how its fresh ones ended.
fn not_run(result: &SweepResult, prediction: &Prediction<'_>, run: &[CellRuns]) -> Vec<CellRuns> {
    let is_left = |(_, entry): &(usize, &DiagramCell)| run.iter().all(|it| it.cell != entry.cell);
    let left = result.diagram.cells.iter().enumerate().filter(is_left).map(|(index, entry)| {
        let fresh = prediction.of_cell(index).map(|simulated| simulated.phases);
        CellRuns {
            cell: entry.cell.clone(),
            real: PhaseCounts::default(),
            simulated: fresh.unwrap_or(entry.counts),
            part: prediction.part(index),
        }
    });
    left.collect()
}

fn label(run: &Admitted, options: &CompareOptions) -> anyhow::Result<Labelled> {
    match &options.labels {
        Labeller::Judge => {
            label_bag(&run.bag, LabelOptions { poses: options.poses, ..LabelOptions::default() })
        }
        Labeller::Human(who) => label_by(&run.bag, who),
    }
}

/// Why a labelled run shows something else than its swarm, unless that counts.
fn implausible(labelled: &Labelled, options: &CompareOptions) -> Option<(NotCountedCause, String)> {
    let found: Vec<&str> = labelled.implausible.iter().map(|found| found.text.as_str()).collect();
    let is_left_out = !found.is_empty() && !options.with_implausible;
    is_left_out.then(|| (NotCountedCause::Implausible, found.join("; ")))
}

/// An error on one line, without the name of the bag before it, and with what to do.
fn without_bag(bag: &Path, error: &anyhow::Error) -> String {
    let text = in_one_line(error);
    let name = format!("{}: ", bag.display());
    let text = text.strip_prefix(&name).unwrap_or(&text);
    // The causes of an error that names the bag begin with it, too.
    let text = text.replace(&name, "");
    match help_of(error) {
        Some(help) => format!("{text}; {help}"),
        None => text,
    }
}
