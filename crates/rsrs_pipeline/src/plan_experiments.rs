//! How many real runs decide `B_r(E) ≥ B_s(E)`, asked before the first of them.

pub mod fixed;

use std::path::Path;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rsrs_core::comparison::experiment_plan::{Decided, ExperimentPlan, PlannedCell, plan};
use rsrs_core::conditions::Conditions;
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::quantity::Cell;
use rsrs_core::statistics::e_value::TestedCell;
use rsrs_core::statistics::share::Share;
use rsrs_sim::sweep::confirmation_seed;
use serde::Serialize;

use crate::compare::prediction::{Note, Prediction, nothing_chosen};
use crate::execution::Execution;
use crate::sweep::folder;
use crate::sweep::result::SweepResult;

/// What is asked.
#[derive(Clone)]
pub struct PlanOptions<'a> {
    /// Cells in which runs are planned; if none are named, the chosen one.
    pub cells: Vec<Cell>,
    /// By how much real robots may mill less often, as for [`crate::compare::compare`].
    pub margin: f64,
    /// The probability with which the runs are to decide, strictly between 0 and 1.
    pub wanted: f64,
    /// Runs of robots as measured in each cell, by which real ones are taken to mill; at least 1.
    pub replicates: u64,
    /// On how many threads, watched by whom.
    pub execution: Execution<'a>,
}

/// Runs of robots as measured where nothing else is asked for: with fewer, how often robots mill is not
/// known well enough to state a probability within 3 points.
pub const REPLICATES: u64 = 20_000;

/// The probability of a decision that is asked for where nothing else is.
pub const WANTED: f64 = 0.8;

/// How many runs in which cells decide, and how.
#[derive(Clone, Debug, Serialize)]
pub struct PlannedExperiments {
    /// What is compared; in the sweep, and not written again.
    #[serde(skip)]
    pub behaviour: Behaviour,
    /// Runs in all cells together, if enough decide.
    pub runs: Option<u64>,
    /// The probability of a decision that was wanted.
    pub wanted: f64,
    /// By how much real robots may mill less often.
    pub margin: f64,
    /// The cells, the first to be run first.
    pub cells: Vec<PlannedRuns>,
    /// Runs until the decision, on average.
    pub mean_runs: f64,
    /// What is decided after each number of runs.
    pub by_runs: Vec<Decided>,
    /// What a reader must not overlook; as JSON it is written as a sentence, by `rsrs_render`.
    #[serde(skip)]
    pub note: Option<Note>,
}

/// The runs of one cell.
#[derive(Clone, Debug, Serialize)]
pub struct PlannedRuns {
    /// The cell.
    pub cell: Cell,
    /// Runs there, if enough decide.
    pub runs: Option<u64>,
    /// Share of simulated runs that mill: what real ones are held against.
    pub b_s: f64,
    /// So many simulated runs.
    pub n_simulated: u64,
    /// Share of runs that mill with robots as measured: what is expected of real ones.
    pub b_m: f64,
    /// So many runs.
    pub n_as_measured: u64,
    /// Whether it is the chosen cell of the sweep, which `rsrs run` takes where none is named.
    #[serde(skip)]
    pub is_chosen: bool,
    /// Whether something is claimed there: simulated robots surely mill more often than the margin.
    #[serde(skip)]
    pub is_claimed: bool,
}

impl PlannedExperiments {
    /// Whether no run of the cells decides, because nothing is claimed in any of them.
    pub fn claims_nothing(&self) -> bool {
        self.runs.is_none() && self.cells.iter().all(|cell| !cell.is_claimed)
    }
}

/// Plans the runs of cells of the sweep in a folder, if real robots mill as often as simulated ones
/// as measured.
///
/// # Errors
///
/// If a cell was not swept or is named twice, or no cell is named and none was chosen.
pub fn plan_experiments(
    folder: &Path,
    options: &PlanOptions,
) -> anyhow::Result<PlannedExperiments> {
    let subject = Subject::read(folder, options)?;
    let planned: Vec<PlannedCell> = subject.cells.iter().map(|(_, planned)| *planned).collect();
    let mut generator = ChaCha8Rng::seed_from_u64(subject.seed);
    let ExperimentPlan { runs, by_runs, mean_runs } =
        plan(&planned, options.margin, options.wanted, &mut || generator.random());
    let n_cells = planned.len() as u64;
    let of_cell = |position: u64| runs.map(|runs| (runs + n_cells - 1 - position) / n_cells);
    Ok(PlannedExperiments {
        behaviour: subject.behaviour,
        runs,
        wanted: options.wanted,
        margin: options.margin,
        cells: subject.rows(|position| of_cell(position as u64)),
        mean_runs,
        by_runs,
        note: subject.note,
    })
}

/// What runs are planned of.
struct Subject {
    behaviour: Behaviour,
    seed: u64,
    /// The cells, with what is known of them.
    cells: Vec<(Cell, PlannedCell)>,
    /// The chosen cell, if one was chosen.
    chosen: Option<Cell>,
    margin: f64,
    /// What a reader must not overlook.
    note: Option<Note>,
}

impl Subject {
    fn read(folder: &Path, options: &PlanOptions) -> anyhow::Result<Self> {
        let result = folder::read(folder)?;
        let prediction = Prediction::new(folder, &result)?;
        let cells = cells(folder, &result, &prediction, options)?;
        let cell = |index: &usize| result.diagram.cells[*index].cell.clone();
        let planned = |(index, as_measured): (&usize, Share)| {
            let simulated = Share::milling(&prediction.of_cell(*index)?.phases);
            let (so_far, part) = (Share::default(), prediction.part(*index));
            Ok((cell(index), PlannedCell { simulated, as_measured, so_far, part }))
        };
        let cells = cells.iter().zip(as_measured(&result, &cells, options)?).map(planned);
        Ok(Self {
            behaviour: result.source.sweep.behaviour.known(),
            seed: result.source.sweep.seed,
            cells: cells.collect::<anyhow::Result<_>>()?,
            chosen: prediction.chosen.as_ref().map(|(index, _)| cell(index)),
            margin: options.margin,
            note: prediction.note(),
        })
    }

    /// The cells with so many runs each, by their positions.
    fn rows(&self, runs: impl Fn(usize) -> Option<u64>) -> Vec<PlannedRuns> {
        let row = |(position, (cell, planned)): (usize, &(Cell, PlannedCell))| PlannedRuns {
            cell: cell.clone(),
            runs: runs(position),
            b_s: planned.simulated.value(),
            n_simulated: planned.simulated.n,
            b_m: planned.as_measured.value(),
            n_as_measured: planned.as_measured.n,
            is_chosen: self.chosen.as_ref() == Some(cell),
            is_claimed: {
                let PlannedCell { simulated, so_far: real, part, .. } = *planned;
                TestedCell { real, simulated, part }.claims(self.margin)
            },
        };
        self.cells.iter().enumerate().map(row).collect()
    }
}

/// The cells by their indices in the diagram.
fn cells(
    folder: &Path,
    result: &SweepResult,
    prediction: &Prediction<'_>,
    options: &PlanOptions<'_>,
) -> anyhow::Result<Vec<usize>> {
    if options.cells.is_empty() {
        let chosen = prediction.chosen.as_ref().map(|(index, _)| vec![*index]);
        return chosen.ok_or_else(|| nothing_chosen(folder));
    }
    let mut cells = Vec::new();
    for cell in &options.cells {
        let index = result.diagram.locate(cell)?;
        anyhow::ensure!(!cells.contains(&index), "the cell {cell} is named twice");
        cells.push(index);
    }
    Ok(cells)
}

/// Runs each of some cells with robots as measured, on seeds of its own.
fn as_measured(
    result: &SweepResult,
    cells: &[usize],
    options: &PlanOptions<'_>,
) -> anyhow::Result<Vec<Share>> {
    let source = result.source.as_measured();
    let source = source.as_ref().unwrap_or(&result.source);
    let conditions = cells
        .iter()
        .map(|index| source.conditions_of(*index))
        .collect::<anyhow::Result<Vec<Conditions>>>()?;
    // Neither that of the sweep nor that of its confirmation.
    let seed = confirmation_seed(confirmation_seed(source.sweep.seed));
    let (runs, duration_s) = ((seed, options.replicates), source.sweep.duration_s);
    let swept = options.execution.simulate("robots as measured", &conditions, runs, duration_s)?;
    Ok(swept.counts(cells.len()).iter().map(Share::milling).collect())
}
