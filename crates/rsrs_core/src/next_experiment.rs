//! What to do after a comparison: the experiment that would tell most, or back to the robots.

use serde::Serialize;

use crate::axis::Cell;
use crate::beta::log_beta;
use crate::comparison::{
    CellRuns, Comparison, MARGIN, SIGNIFICANCE, SUPPORT, Share, Verdict, fisher_less,
};
use crate::posterior::probability_at_least;

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
        /// Probability of so few real mills if both milled equally often, corrected for the number of
        /// cells.
        p_corrected: f64,
    },
    /// Run this experiment.
    Run(Experiment),
    /// No experiment in a swept cell would tell anything more.
    Nothing,
}

/// The experiment that would tell most.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Experiment {
    /// Its cell.
    pub cell: Cell,
    /// Real runs that there are.
    pub n_real: u64,
    /// What one further run is expected to say about whether `B_r >= B_s - 0.1` there, in bits; at most
    /// 1.
    pub information_bits: f64,
    /// The least number of further runs that decide the cell with a probability of [`DECIDES`], as
    /// far as is known now how often real robots mill; `None` if [`MOST_RUNS`] do not.
    pub runs: Option<u64>,
}

/// How probable it is that the runs that are asked for decide.
pub const DECIDES: f64 = 0.8;

/// More runs than this are not asked for: they decide nothing in a laboratory.
pub const MOST_RUNS: u64 = 1024;

/// Less information than this, in bits, is none.
const NO_INFORMATION: f64 = 1e-3;

/// Says what to do next.
///
/// A violated cell sends back to step 1. Else the undecided cell is run on in which one further run is
/// expected to tell most; and when every cell that was run supports the claim, the one of the others.
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
    let violated = comparison.cells.iter().filter(|cell| cell.verdict == Verdict::Violated);
    if let Some(worst) = violated.min_by(|one, two| one.p_corrected.total_cmp(&two.p_corrected)) {
        return NextStep::ReturnToStep1 {
            cell: worst.cell.clone(),
            b_r: worst.real.value(),
            b_s: worst.simulated.value(),
            p_corrected: worst.p_corrected,
        };
    }
    let undecided = comparison.cells.iter().zip(runs);
    let undecided = undecided.filter(|(cell, _)| cell.verdict == Verdict::Undecided);
    let undecided: Vec<&CellRuns> = undecided.map(|(_, runs)| runs).collect();
    let (candidates, n_cells) = if undecided.is_empty() {
        (others.iter().collect(), runs.len() + 1)
    } else {
        (undecided, runs.len())
    };
    let informed = candidates.into_iter().map(|runs| (information_bits(runs), runs));
    let best = informed
        .filter(|(bits, _)| *bits > NO_INFORMATION)
        // Of equals the first.
        .rev()
        .max_by(|one, other| one.0.total_cmp(&other.0));
    best.map_or(NextStep::Nothing, |(information_bits, cell)| {
        NextStep::Run(Experiment {
            cell: cell.cell.clone(),
            n_real: cell.real.total(),
            information_bits,
            runs: runs_that_decide(cell, n_cells),
        })
    })
}

/// What one further real run is expected to say about the claim, in bits.
fn information_bits(runs: &CellRuns) -> f64 {
    let (real, simulated) = (Share::milling(&runs.real), Share::milling(&runs.simulated));
    let holds = |real: Share| probability_at_least(real, simulated, MARGIN);
    let mills = (real.hits as f64 + 1.0) / (real.n as f64 + 2.0);
    let left = |hits: u64| entropy_bits(holds(after(real, (hits, 1))));
    entropy_bits(holds(real)) - mills * left(1) - (1.0 - mills) * left(0)
}

fn after(real: Share, (hits, n): (u64, u64)) -> Share {
    Share { hits: real.hits + hits, n: real.n + n }
}

fn entropy_bits(probability: f64) -> f64 {
    let term = |share: f64| if share > 0.0 { -share * libm::log2(share) } else { 0.0 };
    term(probability) + term(1.0 - probability)
}

/// The least number of further runs that decide with [`DECIDES`].
fn runs_that_decide(runs: &CellRuns, n_cells: usize) -> Option<u64> {
    let decides = |n: u64| chance_to_decide(runs, (n, n_cells)) >= DECIDES;
    let mut enough = 1;
    while !decides(enough) {
        enough *= 2;
        if enough > MOST_RUNS {
            return None;
        }
    }
    let mut too_few = enough / 2;
    while enough - too_few > 1 {
        let middle = too_few + (enough - too_few) / 2;
        if decides(middle) {
            enough = middle;
        } else {
            too_few = middle;
        }
    }
    Some(enough)
}

/// How probable it is that so many further runs support or violate the claim, if nothing is known of
/// real robots but their runs so far.
fn chance_to_decide(runs: &CellRuns, (n, n_cells): (u64, usize)) -> f64 {
    let (real, simulated) = (Share::milling(&runs.real), Share::milling(&runs.simulated));
    let violates = |hits: u64| {
        fisher_less(after(real, (hits, n)), simulated) * (n_cells as f64) < SIGNIFICANCE
    };
    let supports =
        |hits: u64| probability_at_least(after(real, (hits, n)), simulated, MARGIN) >= SUPPORT;
    let n_violating = first(n + 1, |hits| !violates(hits));
    let n_not_supporting = first(n + 1, supports);
    let chance = |hits: u64| predicted(real, (hits, n));
    let violating: f64 = (0..n_violating).map(chance).sum();
    let supporting: f64 = (n_not_supporting.max(n_violating)..=n).map(chance).sum();
    violating + supporting
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

/// Probability that so many of further runs mill, after what was seen, with a uniform prior: the
/// beta-binomial distribution.
fn predicted(real: Share, (hits, n): (u64, u64)) -> f64 {
    let (a, b) = (real.hits as f64 + 1.0, (real.n - real.hits) as f64 + 1.0);
    let (hits, n) = (hits as f64, n as f64);
    let log_ways = -libm::log(n + 1.0) - log_beta(n - hits + 1.0, hits + 1.0);
    libm::exp(log_ways + log_beta(hits + a, n - hits + b) - log_beta(a, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn predicted_runs_are_those_of_the_beta_binomial_distribution() {
        // Its closed form with the `lgamma` of Python's standard library.
        for ((hits, n), (more, of), expected) in [
            ((0, 0), (2, 4), 0.2),
            ((3, 3), (5, 5), 0.444_444_444_444),
            ((9, 10), (7, 10), 0.129_736_104_968_303),
        ] {
            let found = predicted(Share { hits, n }, (more, of));

            assert!((found - expected).abs() < 1e-9, "{hits}/{n}: {found} {expected}");
        }
    }
}
