//! What to do after a comparison: the most informative experiment, or back to the robots.

use serde::Serialize;

use crate::diagram::axis::Cell;
use crate::statistics::comparison::{
    CellRuns, Comparison, MOST_RUNS, Share, Verdict, decide, runs_until,
};
use crate::statistics::pooled::{PooledTest, predicted};
use crate::statistics::posterior::probability_at_least;

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
        /// Probability of ever seeing so much evidence there if both milled equally often, corrected
        /// for the number of cells.
        p_corrected: f64,
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
    /// The least number of further runs that decide with a probability of [`DECIDES`], as far as is
    /// known now how often real robots mill; `None` if [`MOST_RUNS`] do not.
    pub runs: Option<u64>,
    /// The probability that so many decide, or, if there is no such number, that [`MOST_RUNS`] do.
    pub chance: f64,
}

/// How probable it is that the runs that are asked for decide.
pub const DECIDES: f64 = 0.8;

/// Less information than this, in bits, is none.
const NO_INFORMATION: f64 = 1e-3;

/// Recommends what to do next.
///
/// A violation sends back to step 1. Else the undecided cell is run on in which one further run is
/// expected to be most informative; and when the runs support the claim, the one of the others.
///
/// # Arguments
///
/// * `comparison`, `runs` — what was compared and what it rests on, in the same order.
/// * `others` — swept cells that were not run, with their simulated runs.
///
/// # Source
///
/// The expected information of an experiment is that of D. V. Lindley, Annals of Mathematical
/// Statistics 27, 1956. "Return to step 1" is §III, after `eq:simulatorreq`.
pub fn next_step(comparison: &Comparison, runs: &[CellRuns], others: &[CellRuns]) -> NextStep {
    let margin = comparison.pooled.margin;
    if comparison.verdict == Verdict::Violated {
        return return_to_step_1(comparison);
    }
    let is_supported = comparison.verdict == Verdict::Supported;
    let candidates = if is_supported || runs.is_empty() { others } else { runs };
    let informed = candidates.iter().map(|runs| information_bits(runs, margin)).enumerate();
    let best = informed
        .filter(|(_, bits)| *bits > NO_INFORMATION)
        // Of equals the first.
        .rev()
        .max_by(|one, other| one.1.total_cmp(&other.1));
    let Some((index, information_bits)) = best else {
        return NextStep::Nothing;
    };
    let cell = &candidates[index];
    let shares = |runs: &CellRuns| (Share::milling(&runs.real), Share::milling(&runs.simulated));
    let chance = if is_supported || runs.is_empty() {
        // A cell that was not run is decided for itself.
        Chance { test: PooledTest::new(&[shares(cell)], margin), cell: 0, real: shares(cell).0 }
    } else {
        let shares: Vec<(Share, Share)> = runs.iter().map(shares).collect();
        Chance { test: PooledTest::new(&shares, margin), cell: index, real: shares[index].0 }
    };
    let n = runs_until(|n| chance.to_decide(n) >= DECIDES);
    NextStep::Run(Experiment {
        cell: cell.cell.clone(),
        n_real: cell.real.total(),
        information_bits,
        runs: n,
        chance: chance.to_decide(n.unwrap_or(MOST_RUNS)),
    })
}

fn return_to_step_1(comparison: &Comparison) -> NextStep {
    let worst = comparison
        .cells
        .iter()
        .max_by(|one, two| one.e_violated.total_cmp(&two.e_violated))
        .expect("without cells there is no evidence");
    NextStep::ReturnToStep1 {
        cell: worst.cell.clone(),
        b_r: worst.real.value(),
        b_s: worst.simulated.value(),
        p_corrected: worst.p_violated,
    }
}

/// Expected information of one further real run on the claim, in bits.
fn information_bits(runs: &CellRuns, margin: f64) -> f64 {
    let (real, simulated) = (Share::milling(&runs.real), Share::milling(&runs.simulated));
    let holds = |real: Share| probability_at_least(real, simulated, margin);
    let mills = (real.hits as f64 + 1.0) / (real.n as f64 + 2.0);
    let left = |hits: u64| entropy_bits(holds(after(real, hits, 1)));
    entropy_bits(holds(real)) - mills * left(1) - (1.0 - mills) * left(0)
}

fn after(real: Share, hits: u64, n: u64) -> Share {
    Share { hits: real.hits + hits, n: real.n + n }
}

fn entropy_bits(probability: f64) -> f64 {
    let term = |share: f64| if share > 0.0 { -share * libm::log2(share) } else { 0.0 };
    term(probability) + term(1.0 - probability)
}

/// How probable it is that further runs in one cell decide, if nothing is known of its real robots but
/// their runs so far.
struct Chance {
    test: PooledTest,
    cell: usize,
    real: Share,
}

impl Chance {
    fn to_decide(&self, n: u64) -> f64 {
        let verdict = |hits: u64| decide(self.test.log_e_after(self.cell, Share { hits, n }));
        let n_violating = first(n + 1, |hits| verdict(hits) != Verdict::Violated);
        let n_not_supporting = first(n + 1, |hits| verdict(hits) == Verdict::Supported);
        let chance = |hits: u64| predicted(self.real, Share { hits, n });
        let violating: f64 = (0..n_violating).map(chance).sum();
        let supporting: f64 = (n_not_supporting.max(n_violating)..=n).map(chance).sum();
        violating + supporting
    }
}

/// The first number at which a condition holds that holds from there on; `end` if it never does.
fn first(end: u64, holds: impl Fn(u64) -> bool) -> u64 {
    let (mut low, mut high) = (0, end);
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}
