//! What to do after a comparison: the most informative experiment, or back to the robots.

use serde::Serialize;

use crate::comparison::experiment_plan::{ExperimentPlan, PlannedCell, plan_in, soonest};
use crate::comparison::{CellRuns, Comparison, Verdict};
use crate::quantity::Cell;
use crate::statistics::posterior::probability_at_least;
use crate::statistics::share::Share;

/// What to do next.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum NextStep {
    /// Reality is worse than the simulation: measure the robots again, and build a harsher simulator.
    #[serde(rename = "return_to_step_1")]
    ReturnToStep1 {
        /// Where it is most certainly worse.
        cell: Cell,
        /// Share of real runs that milled there.
        b_r: f64,
        /// Share of simulated ones.
        b_s: f64,
        /// Evidence there that real robots mill less often.
        e_violated: f64,
    },
    /// Run this experiment.
    Run(Experiment),
    /// No experiment in a swept cell is informative any more.
    Nothing,
}

/// The most informative experiment.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Experiment {
    /// Its cell.
    pub cell: Cell,
    /// Real runs that there are.
    pub n_real: u64,
    /// Expected information of one further run on whether `B_r >= B_s - margin` there, in bits; at
    /// most 1.
    pub information_bits: f64,
    /// The least number of further runs that decide with a probability of [`DECIDES`], compared after
    /// each, if real robots mill as those so far and as simulated ones as measured; `None` if
    /// [`MOST_RUNS`] do not.
    ///
    /// [`MOST_RUNS`]: crate::comparison::MOST_RUNS
    pub runs: Option<u64>,
    /// The probability that so many decide, or, if there is no such number, that [`MOST_RUNS`] do.
    ///
    /// [`MOST_RUNS`]: crate::comparison::MOST_RUNS
    pub chance: f64,
    /// Share of simulated runs of robots as measured that mill there; `None` if there are none.
    pub b_m: Option<f64>,
    /// So many of them.
    pub n_as_measured: u64,
}

/// How probable it is that the runs that are asked for decide.
pub const DECIDES: f64 = 0.8;

/// Less information than this, in bits, is none.
const NO_INFORMATION: f64 = 1e-3;

/// Recommends what to do next.
///
/// A violation sends back to step 1. While nothing is decided, the cell in which one further run is
/// expected to be most informative is run on; once the runs support the claim, it is the most informative
/// one of `others`. If no cell that was run makes a claim, it is the one of `others` that does and has the
/// greatest part of the error, as the chosen cell has; of equals, the one in which simulated robots mill
/// most often. Without runs, it is the one of those that decides with the fewest; of equals the same.
///
/// The comparison rests on `runs`, in the same order; `others` are the simulated runs of swept cells that
/// were not run, and `as_measured` gives those of robots as measured in a cell, none where they are not
/// known.
///
/// # Source
///
/// The expected information of an experiment is that of D. V. Lindley, Annals of Mathematical
/// Statistics 27, 1956. "Return to step 1" is §III, after `eq:simulatorreq`.
pub fn next_step(
    comparison: &Comparison,
    runs: &[CellRuns],
    others: &[CellRuns],
    as_measured: &dyn Fn(&Cell) -> Share,
) -> NextStep {
    let margin = comparison.pooled.margin;
    if comparison.verdict == Verdict::Violated {
        return return_to_step_1(comparison);
    }
    let planned = |runs: &CellRuns| PlannedCell {
        simulated: Share::milling(&runs.simulated),
        as_measured: as_measured(&runs.cell),
        so_far: Share::milling(&runs.real),
        part: runs.part,
    };
    if runs.is_empty() {
        return first_step(others, margin, &planned);
    }
    let claims_nothing = comparison.verdict == Verdict::NoClaim;
    let is_anew = comparison.verdict == Verdict::Supported || claims_nothing;
    let candidates = if is_anew { others } else { runs };
    let informed = candidates.iter().map(|runs| information_bits(runs, margin)).enumerate();
    let first = |index: usize| if claims_nothing { rank(&candidates[index]) } else { [0.0; 2] };
    let best = informed
        .filter(|(_, bits)| *bits > NO_INFORMATION)
        .filter(|(index, _)| !claims_nothing || candidates[*index].tested().claims(margin))
        // Of equals the first.
        .rev()
        .max_by(|one, other| {
            let [part, share] = first(one.0);
            let [other_part, other_share] = first(other.0);
            let by_part = part.total_cmp(&other_part).then(share.total_cmp(&other_share));
            by_part.then(one.1.total_cmp(&other.1))
        });
    let Some((index, _)) = best else {
        return NextStep::Nothing;
    };
    let cell = &candidates[index];
    let plan = if is_anew {
        // A cell that was not run is decided for itself.
        plan_in(&[planned(cell)], 0, margin, DECIDES)
    } else {
        let cells: Vec<PlannedCell> = runs.iter().map(planned).collect();
        plan_in(&cells, index, margin, DECIDES)
    };
    NextStep::Run(experiment(cell, planned(cell).as_measured, &plan, margin))
}

/// Where to begin.
fn first_step(
    cells: &[CellRuns],
    margin: f64,
    planned: &dyn Fn(&CellRuns) -> PlannedCell,
) -> NextStep {
    let mut claiming: Vec<&CellRuns> =
        cells.iter().filter(|cell| cell.tested().claims(margin)).collect();
    claiming.sort_by(|one, other| {
        let ([part, share], [other_part, other_share]) = (rank(one), rank(other));
        other_part.total_cmp(&part).then(other_share.total_cmp(&share))
    });
    let of_each: Vec<PlannedCell> = claiming.iter().map(|cell| planned(cell)).collect();
    match soonest(&of_each, margin, DECIDES) {
        Some((index, plan)) => {
            let as_measured = of_each[index].as_measured;
            NextStep::Run(experiment(claiming[index], as_measured, &plan, margin))
        }
        None => NextStep::Nothing,
    }
}

/// Which of several cells comes first: the one with the greater part, as the chosen cell has, then the one in
/// which simulated robots mill more often.
fn rank(cell: &CellRuns) -> [f64; 2] {
    [cell.part, Share::milling(&cell.simulated).value()]
}

fn experiment(
    cell: &CellRuns,
    as_measured: Share,
    plan: &ExperimentPlan,
    margin: f64,
) -> Experiment {
    Experiment {
        cell: cell.cell.clone(),
        n_real: cell.real.total(),
        information_bits: information_bits(cell, margin),
        runs: plan.runs,
        chance: plan.chance(),
        b_m: (as_measured.n > 0).then(|| as_measured.value()),
        n_as_measured: as_measured.n,
    }
}

/// Back to the robots, for the cell in which they are most certainly worse.
///
/// # Panics
///
/// If no cell was compared.
pub fn return_to_step_1(comparison: &Comparison) -> NextStep {
    let worst = comparison
        .cells
        .iter()
        .max_by(|one, two| one.e_violated.total_cmp(&two.e_violated))
        .expect("without cells there is no evidence");
    NextStep::ReturnToStep1 {
        cell: worst.cell.clone(),
        b_r: worst.real.value(),
        b_s: worst.simulated.value(),
        e_violated: worst.e_violated,
    }
}

/// Expected information of one further real run on the claim, in bits.
fn information_bits(runs: &CellRuns, margin: f64) -> f64 {
    let (real, simulated) = (Share::milling(&runs.real), Share::milling(&runs.simulated));
    let holds = |real: Share| probability_at_least(real, simulated, margin);
    let mills = (real.hits as f64 + 1.0) / (real.n as f64 + 2.0);
    let left = |hits: u64| entropy_bits(holds(real + Share { hits, n: 1 }));
    entropy_bits(holds(real)) - mills * left(1) - (1.0 - mills) * left(0)
}

fn entropy_bits(probability: f64) -> f64 {
    let term = |share: f64| if share > 0.0 { -share * libm::log2(share) } else { 0.0 };
    term(probability) + term(1.0 - probability)
}
