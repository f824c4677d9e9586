//! All runs of all cells, held against the simulator at once.
//!
//! A campaign of one run in each of nine cells is strong evidence, though no single cell is: if
//! nowhere fewer than 85 % should mill and none of nine does, no correction for many cells may hide
//! it.

use serde::Serialize;

use crate::statistics::beta;
use crate::statistics::e_value::{CellEvidence, SimulatedShare, log_e_at_least, log_e_less};
use crate::statistics::share::Share;

/// The pooled evidence of all runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pooled {
    /// Real runs.
    pub n_real: u64,
    /// Those that milled.
    pub n_milled: u64,
    /// How many would mill if real robots milled as often as simulated ones.
    pub n_expected: f64,
    /// By how much `B_r` may fall short of `B_s`.
    pub margin: f64,
    /// Evidence that in some cell `B_r < B_s`: expected to be at most 1 if in none.
    pub e_violated: f64,
    /// Its inverse, at most 1: the probability of ever seeing so much evidence if `B_r >= B_s`
    /// everywhere.
    pub p_violated: f64,
    /// Evidence that `B_r`, averaged over the runs, is at least the average of `B_s - margin`.
    pub e_supported: f64,
    /// Its inverse, at most 1: the probability of ever seeing so much evidence if it is less.
    pub p_not_supported: f64,
    /// Probability of at most so many mills if real robots milled as often as simulated ones, exact for
    /// a number of runs that was fixed before the first.
    pub p_value: f64,
    /// The least margin, in hundredths, with which the claim would be supported now: real robots mill
    /// less often by at most this; `None` if the runs exclude nothing.
    pub shortfall_at_most: Option<f64>,
}

/// The runs of a campaign and what is simulated of their cells, ready to be tested again and again.
#[derive(Clone, Debug)]
pub struct PooledTest {
    cells: Vec<(Share, SimulatedShare)>,
    evidence: Vec<CellEvidence>,
    margin: f64,
}

/// Logarithms of the evidence in some runs, one for each hypothesis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogEvidence {
    /// That in some cell `B_r < B_s`.
    pub less: f64,
    /// That all cells together are as good as simulated but for the margin.
    pub at_least: f64,
}

impl LogEvidence {
    /// The evidence of some cells together.
    pub fn of(cells: &[CellEvidence]) -> Self {
        Self { less: log_e_less(cells), at_least: log_e_at_least(cells) }
    }
}

impl PooledTest {
    /// A campaign so far.
    ///
    /// # Arguments
    ///
    /// * `cells` — real and simulated runs of each cell.
    /// * `margin` — by how much real robots may fall short, from 0 to less than 1.
    pub fn new(cells: &[(Share, Share)], margin: f64) -> Self {
        let with_posterior =
            |(real, simulated): &(Share, Share)| (*real, SimulatedShare::after(*simulated));
        let cells: Vec<(Share, SimulatedShare)> = cells.iter().map(with_posterior).collect();
        let evidence = evidence(&cells, margin);
        Self { cells, evidence, margin }
    }

    /// The evidence of all runs.
    pub fn log_e(&self) -> LogEvidence {
        LogEvidence::of(&self.evidence)
    }

    /// The same for one cell alone.
    pub fn log_e_of(&self, cell: usize) -> LogEvidence {
        LogEvidence::of(std::slice::from_ref(&self.evidence[cell]))
    }

    /// The same for one cell alone after further runs in it.
    pub fn log_e_of_after(&self, cell: usize, further: Share) -> LogEvidence {
        LogEvidence::of(&[self.evidence_after(cell, further)])
    }

    /// The same for all cells after further runs in one.
    pub fn log_e_after(&self, cell: usize, further: Share) -> LogEvidence {
        let mut evidence = self.evidence.clone();
        evidence[cell] = self.evidence_after(cell, further);
        LogEvidence::of(&evidence)
    }

    fn evidence_after(&self, cell: usize, further: Share) -> CellEvidence {
        let (real, simulated) = &self.cells[cell];
        let real = Share { hits: real.hits + further.hits, n: real.n + further.n };
        CellEvidence::of(real, simulated, self.margin)
    }

    /// By how much real robots may fall short.
    pub fn margin(&self) -> f64 {
        self.margin
    }

    /// The logarithm of the evidence that all are as good but for the margin after further runs that all
    /// mill, shared out among the cells, those with the fewest runs first.
    pub fn log_e_if_all_mill(&self, further: u64) -> f64 {
        let mut runs: Vec<Share> = self.cells.iter().map(|(real, _)| *real).collect();
        for _ in 0..further {
            if let Some(least) = runs.iter_mut().min_by_key(|runs| runs.n) {
                *least = Share { hits: least.hits + 1, n: least.n + 1 };
            }
        }
        let cells = runs.iter().zip(&self.cells);
        let evidence: Vec<CellEvidence> = cells
            .map(|(real, (_, simulated))| CellEvidence::of(*real, simulated, self.margin))
            .collect();
        log_e_at_least(&evidence)
    }

    /// The evidence of the campaign so far.
    ///
    /// # Arguments
    ///
    /// * `simulated` — the simulated runs of each cell, as in [`PooledTest::new`].
    /// * `enough` — the logarithm of the evidence that decides.
    pub fn summary(&self, simulated: &[Share], enough: f64) -> Pooled {
        let LogEvidence { less, at_least } = self.log_e();
        let real: Vec<Share> = self.cells.iter().map(|(real, _)| *real).collect();
        let expected = |(real, simulated): (&Share, &Share)| real.n as f64 * simulated.value();
        Pooled {
            n_real: real.iter().map(|real| real.n).sum(),
            n_milled: real.iter().map(|real| real.hits).sum(),
            n_expected: real.iter().zip(simulated).map(expected).sum(),
            margin: self.margin,
            e_violated: e_value(less),
            p_violated: p_value(less),
            e_supported: e_value(at_least),
            p_not_supported: p_value(at_least),
            p_value: poisson_binomial_at_most(&real, simulated),
            shortfall_at_most: self.shortfall(enough),
        }
    }

    fn shortfall(&self, enough: f64) -> Option<f64> {
        let is_supported = |hundredths: u32| {
            let evidence = evidence(&self.cells, f64::from(hundredths) / 100.0);
            log_e_at_least(&evidence) >= enough
        };
        let (mut low, mut high) = (0, 99);
        if !is_supported(high) {
            return None;
        }
        while low < high {
            let middle = u32::midpoint(low, high);
            if is_supported(middle) {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        Some(f64::from(high) / 100.0)
    }
}

fn evidence(cells: &[(Share, SimulatedShare)], margin: f64) -> Vec<CellEvidence> {
    cells.iter().map(|(real, simulated)| CellEvidence::of(*real, simulated, margin)).collect()
}

/// An e-value from its logarithm; as great as a number of JSON can be.
pub fn e_value(log_e: f64) -> f64 {
    libm::exp(log_e).min(f64::MAX)
}

/// The probability of ever seeing so much evidence if the hypothesis holds, after Ville.
pub fn p_value(log_e: f64) -> f64 {
    libm::exp(-log_e).min(1.0)
}

/// Probability of at most so many real mills in all cells, if in each real robots mill as often as
/// simulated ones, of which only runs are known.
///
/// The number of mills in a cell has the beta-binomial distribution: a binomial one whose share is
/// that of the simulator's posterior. Their sum is a Poisson binomial one with uncertain shares.
///
/// # Arguments
///
/// * `real`, `simulated` — runs, cell by cell.
///
/// # Source
///
/// Y. H. Wang, "On the number of successes in independent trials", Statistica Sinica 3, 1993.
pub fn poisson_binomial_at_most(real: &[Share], simulated: &[Share]) -> f64 {
    let mut sum = vec![1.0];
    for (real, simulated) in real.iter().zip(simulated) {
        let of_cell: Vec<f64> =
            (0..=real.n).map(|hits| predicted(*simulated, Share { hits, n: real.n })).collect();
        let mut convolved = vec![0.0; sum.len() + of_cell.len() - 1];
        for (one, of_one) in sum.iter().enumerate() {
            for (other, of_other) in of_cell.iter().enumerate() {
                convolved[one + other] += of_one * of_other;
            }
        }
        sum = convolved;
    }
    let n_milled: u64 = real.iter().map(|real| real.hits).sum();
    sum.iter().take(n_milled as usize + 1).sum::<f64>().min(1.0)
}

/// Probability that so many of further runs mill, after what was seen, with a uniform prior: the
/// beta-binomial distribution.
pub fn predicted(seen: Share, further: Share) -> f64 {
    let (a, b) = (seen.hits as f64 + 1.0, (seen.n - seen.hits) as f64 + 1.0);
    let (hits, n) = (further.hits as f64, further.n as f64);
    let log_ways = -libm::log(n + 1.0) - beta::log_beta(n - hits + 1.0, hits + 1.0);
    libm::exp(log_ways + beta::log_beta(hits + a, n - hits + b) - beta::log_beta(a, b))
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
            let found = predicted(Share { hits, n }, Share { hits: more, n: of });

            assert!((found - expected).abs() < 1e-9, "{hits}/{n}: {found} {expected}");
        }
    }
}
