//! Reality against the simulator: does `B_r(E) >= B_s(E)` hold?
//!
//! The inequality is tested, never assumed: a robot that is better in every capability does not
//! by itself mill more often.

use serde::{Deserialize, Serialize};

use crate::axis::Cell;
use crate::diagram::PhaseCounts;
use crate::interval::Interval;
use crate::phase::Phase;
use crate::posterior::probability_at_least;

pub use crate::share::Share;

/// What was counted in one cell.
#[derive(Clone, Debug, PartialEq)]
pub struct CellRuns {
    /// The cell.
    pub cell: Cell,
    /// How its real runs ended.
    pub real: PhaseCounts,
    /// How its simulated replicates ended: of a chosen cell those of the confirmation.
    pub simulated: PhaseCounts,
}

/// What the runs say about `eq:finalgap`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Reality mills less often than the simulator; more than chance explains.
    Violated,
    /// Reality mills at least as often, or at most 0.1 less often, with a probability of 0.95.
    Supported,
    /// Too few runs to say.
    Undecided,
}

/// One cell, compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CellComparison {
    /// The cell.
    pub cell: Cell,
    /// Real runs that milled.
    pub real: Share,
    /// Interval of `B_r`.
    pub real_interval: Interval,
    /// Simulated replicates that milled.
    pub simulated: Share,
    /// Interval of `B_s`.
    pub simulated_interval: Interval,
    /// Fisher's exact probability of so few real mills if `B_r = B_s`; one-sided.
    pub p_value: f64,
    /// The same, corrected for the number of cells after Holm.
    pub p_corrected: f64,
    /// Posterior probability that `B_r >= B_s - 0.1`, with uniform priors.
    pub p_supported: f64,
    /// What follows.
    pub verdict: Verdict,
    /// If undecided: how many further real runs would support the inequality if all of them mill.
    pub further_runs: Option<u64>,
}

/// How real runs went beside the simulator's majority, as the paper counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Real runs that ended as the simulator said, or equally far from milling.
    pub same: u64,
    /// Real runs that came closer to stable milling than the simulator said.
    pub easier: u64,
    /// Real runs that came less close.
    pub harder: u64,
}

/// All cells, compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Cell by cell, in the order given.
    pub cells: Vec<CellComparison>,
    /// Violated if any cell is; supported if all are.
    pub verdict: Verdict,
    /// Run by run.
    pub tally: Tally,
}

/// By how much `B_r` may fall short of `B_s` and still support the inequality.
pub const MARGIN: f64 = 0.1;

/// A corrected probability below this violates the inequality.
pub const SIGNIFICANCE: f64 = 0.05;

/// A posterior probability from this on supports it.
pub const SUPPORT: f64 = 0.95;

impl Comparison {
    /// Compares real runs with simulated ones, cell by cell.
    ///
    /// # Source
    ///
    /// `eq:finalgap`; the tally of the caption of `fig:phase_plot2`.
    pub fn of(runs: &[CellRuns]) -> Self {
        let p_values: Vec<f64> = runs
            .iter()
            .map(|runs| fisher_less(Share::milling(&runs.real), Share::milling(&runs.simulated)))
            .collect();
        let cells: Vec<CellComparison> = runs
            .iter()
            .zip(p_values.iter().zip(holm(&p_values)))
            .map(|(runs, (p_value, p_corrected))| compare_cell(runs, *p_value, p_corrected))
            .collect();
        let any = |verdict| cells.iter().any(|cell| cell.verdict == verdict);
        let verdict = if any(Verdict::Violated) {
            Verdict::Violated
        } else if any(Verdict::Undecided) || cells.is_empty() {
            Verdict::Undecided
        } else {
            Verdict::Supported
        };
        Self { cells, verdict, tally: tally(runs) }
    }
}

fn compare_cell(runs: &CellRuns, p_value: f64, p_corrected: f64) -> CellComparison {
    let (real, simulated) = (Share::milling(&runs.real), Share::milling(&runs.simulated));
    let p_supported = probability_at_least(real, simulated, MARGIN);
    let verdict = if p_corrected < SIGNIFICANCE {
        Verdict::Violated
    } else if p_supported >= SUPPORT {
        Verdict::Supported
    } else {
        Verdict::Undecided
    };
    CellComparison {
        cell: runs.cell.clone(),
        real,
        real_interval: real.interval(),
        simulated,
        simulated_interval: simulated.interval(),
        p_value,
        p_corrected,
        p_supported,
        verdict,
        further_runs: (verdict == Verdict::Undecided).then(|| further_runs(real, simulated)),
    }
}

/// The least number of further runs, all milling, after which the inequality is supported.
fn further_runs(real: Share, simulated: Share) -> u64 {
    let is_enough = |further: u64| {
        let real = Share { hits: real.hits + further, n: real.n + further };
        probability_at_least(real, simulated, MARGIN) >= SUPPORT
    };
    let mut enough = 1;
    while !is_enough(enough) {
        enough *= 2;
    }
    let mut too_few = enough / 2;
    while enough - too_few > 1 {
        let middle = too_few + (enough - too_few) / 2;
        if is_enough(middle) {
            enough = middle;
        } else {
            too_few = middle;
        }
    }
    enough
}

/// Fisher's exact test that the real share is not below the simulated one.
///
/// # Returns
///
/// The probability of at most so many real hits, given all hits; 1 without runs on either side.
///
/// # Source
///
/// R. A. Fisher, Journal of the Royal Statistical Society 85, 1922.
pub fn fisher_less(real: Share, simulated: Share) -> f64 {
    let hits = real.hits + simulated.hits;
    let n = real.n + simulated.n;
    let least = real.n.saturating_sub(n - hits);
    let log_all = log_choose(n, real.n);
    let probability = |real_hits: u64| {
        let log_ways = log_choose(hits, real_hits) + log_choose(n - hits, real.n - real_hits);
        libm::exp(log_ways - log_all)
    };
    (least..=real.hits).map(probability).sum::<f64>().min(1.0)
}

fn log_choose(n: u64, k: u64) -> f64 {
    let log_factorial = |n: u64| libm::lgamma(n as f64 + 1.0);
    log_factorial(n) - log_factorial(k) - log_factorial(n - k)
}

/// Corrects probabilities for being several, after Holm.
///
/// # Source
///
/// S. Holm, Scandinavian Journal of Statistics 6, 1979.
pub fn holm(p_values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|left, right| p_values[*left].total_cmp(&p_values[*right]));
    let mut corrected = vec![0.0; p_values.len()];
    let mut greatest = 0.0_f64;
    for (rank, cell) in order.into_iter().enumerate() {
        let factor = (p_values.len() - rank) as f64;
        greatest = greatest.max((p_values[cell] * factor).min(1.0));
        corrected[cell] = greatest;
    }
    corrected
}

fn tally(runs: &[CellRuns]) -> Tally {
    let mut tally = Tally::default();
    for cell in runs {
        let Some(expected) = cell.simulated.majority() else {
            continue;
        };
        for phase in Phase::ALL {
            let n = cell.real.get(phase);
            match distance_from_milling(phase).cmp(&distance_from_milling(expected)) {
                std::cmp::Ordering::Less => tally.easier += n,
                std::cmp::Ordering::Equal => tally.same += n,
                std::cmp::Ordering::Greater => tally.harder += n,
            }
        }
    }
    tally
}

fn distance_from_milling(phase: Phase) -> u8 {
    match phase {
        Phase::StableMilling => 0,
        Phase::SemiStableMilling => 1,
        Phase::Unformed => 2,
        Phase::Dispersion | Phase::CollidingUnstable => 3,
    }
}
