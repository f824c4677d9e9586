//! Reality against the simulator: does `B_r(E) >= B_s(E)` hold?
//!
//! The inequality is tested, never assumed: a robot that is better in every capability does not
//! by itself mill more often.

use serde::{Deserialize, Serialize};

use crate::diagram::PhaseCounts;
use crate::diagram::axis::Cell;
use crate::judge::phase::Phase;
use crate::statistics::interval::Interval;
use crate::statistics::pooled::{LogEvidence, Pooled, PooledTest, e_value, p_value};
use crate::statistics::posterior::probability_at_least;

pub use crate::statistics::share::Share;

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

/// The evidence of the runs on `eq:finalgap`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// In at least one of the cells, reality mills less often than the simulator.
    Violated,
    /// Averaged over the runs, reality mills at least as often as the simulator, or less often by at
    /// most the margin.
    Supported,
    /// The runs do not decide yet.
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
    /// Fisher's exact probability of so few real mills if `B_r = B_s`; one-sided, for a number of runs
    /// that was fixed before the first.
    pub p_value: f64,
    /// The same, corrected for the number of cells after Holm.
    pub p_corrected: f64,
    /// Posterior probability that `B_r >= B_s - margin`, with uniform priors.
    pub p_supported: f64,
    /// Evidence that `B_r < B_s` here, however often one looked.
    pub e_violated: f64,
    /// Its inverse, at most 1, corrected for the number of cells after Holm.
    pub p_violated: f64,
    /// Evidence that `B_r >= B_s - margin` here, however often one looked.
    pub e_supported: f64,
    /// Its inverse, at most 1, corrected for the number of cells after Holm.
    pub p_not_supported: f64,
    /// What follows for this cell; violated only if all cells together are.
    pub verdict: Verdict,
    /// If undecided: how many further real runs would support the inequality here if all of them mill;
    /// `None` also if [`MOST_RUNS`] would not.
    pub further_runs: Option<u64>,
}

/// How real runs went beside the simulator's majority, as the paper counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Tally {
    /// Real runs that ended as simulated, or equally far from milling.
    pub same: u64,
    /// Real runs that came closer to stable milling than simulated.
    pub easier: u64,
    /// Real runs that came less close.
    pub harder: u64,
}

/// All cells, compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Cell by cell, in the order given.
    pub cells: Vec<CellComparison>,
    /// All runs of all cells together, on which the verdict rests.
    pub pooled: Pooled,
    /// What follows from all runs.
    pub verdict: Verdict,
    /// If undecided: how many further real runs would support the inequality if all of them mill,
    /// those cells run next that were run least; `None` also if [`MOST_RUNS`] would not.
    pub further_runs: Option<u64>,
    /// Run by run.
    pub tally: Tally,
}

/// By how much `B_r` may fall short of `B_s` and still support the inequality, unless asked
/// otherwise.
pub const MARGIN: f64 = 0.1;

/// Bound on the probability of a wrong verdict of either kind, however often one looks.
pub const SIGNIFICANCE: f64 = 0.05;

/// More runs than this are not asked for: they decide nothing in a laboratory.
pub const MOST_RUNS: u64 = 1024;

impl Comparison {
    /// Compares real runs with simulated ones, with the usual [`MARGIN`].
    pub fn of(runs: &[CellRuns]) -> Self {
        Self::with_margin(runs, MARGIN)
    }

    /// Compares real runs with simulated ones.
    ///
    /// The verdict rests on all runs together. It is `violated` if they would be improbable did real
    /// robots mill at least as often as simulated ones in every cell; then those cells are named that
    /// show it alone, corrected for their number. It is `supported` if they would be improbable did real
    /// robots, averaged over the runs, mill less often by more than the margin. Either is wrong
    /// with a probability of at most [`SIGNIFICANCE`], whatever number of runs one looked at before.
    ///
    /// # Arguments
    ///
    /// * `runs` — cell by cell.
    /// * `margin` — by how much `B_r` may fall short, from 0 to less than 1.
    ///
    /// # Source
    ///
    /// `eq:finalgap`; the tally of the caption of `fig:phase_plot2`; [`crate::statistics::e_value`].
    pub fn with_margin(runs: &[CellRuns], margin: f64) -> Self {
        let shares: Vec<(Share, Share)> = runs
            .iter()
            .map(|runs| (Share::milling(&runs.real), Share::milling(&runs.simulated)))
            .collect();
        let test = PooledTest::new(&shares, margin);
        let verdict = decide(test.log_e());
        let corrected = Corrected::of(&shares, &test);
        let cells = (0..runs.len())
            .map(|index| compare_cell(&runs[index], &test, index, &corrected, verdict))
            .collect();
        let simulated: Vec<Share> = shares.iter().map(|(_, simulated)| *simulated).collect();
        let further = |n: u64| test.log_e_if_all_mill(n);
        Self {
            cells,
            pooled: test.summary(&simulated, enough()),
            verdict,
            further_runs: (verdict == Verdict::Undecided && !runs.is_empty())
                .then(|| runs_until(|n| further(n) >= enough()))
                .flatten(),
            tally: tally(runs),
        }
    }
}

/// The logarithm of the evidence that decides.
pub fn enough() -> f64 {
    -libm::log(SIGNIFICANCE)
}

/// What follows from evidence.
pub fn decide(evidence: LogEvidence) -> Verdict {
    if evidence.less >= enough() {
        Verdict::Violated
    } else if evidence.at_least >= enough() {
        Verdict::Supported
    } else {
        Verdict::Undecided
    }
}

/// Probabilities of every cell, corrected for the number of cells.
struct Corrected {
    exact: Vec<f64>,
    violated: Vec<f64>,
    not_supported: Vec<f64>,
}

impl Corrected {
    fn of(shares: &[(Share, Share)], test: &PooledTest) -> Self {
        let corrected = |of_cell: &dyn Fn(usize) -> f64| {
            holm(&(0..shares.len()).map(of_cell).collect::<Vec<f64>>())
        };
        Self {
            exact: corrected(&|cell| fisher_less(shares[cell].0, shares[cell].1)),
            violated: corrected(&|cell| p_value(test.log_e_of(cell).less)),
            not_supported: corrected(&|cell| p_value(test.log_e_of(cell).at_least)),
        }
    }
}

fn compare_cell(
    runs: &CellRuns,
    test: &PooledTest,
    index: usize,
    corrected: &Corrected,
    of_all: Verdict,
) -> CellComparison {
    let (real, simulated) = (Share::milling(&runs.real), Share::milling(&runs.simulated));
    let (p_violated, p_not_supported) = (corrected.violated[index], corrected.not_supported[index]);
    let LogEvidence { less, at_least } = test.log_e_of(index);
    let verdict = if of_all == Verdict::Violated && p_violated <= SIGNIFICANCE {
        Verdict::Violated
    } else if p_not_supported <= SIGNIFICANCE {
        Verdict::Supported
    } else {
        Verdict::Undecided
    };
    let if_all_mill =
        |n: u64| test.log_e_of_after(index, Share { hits: n, n }).at_least >= enough();
    CellComparison {
        cell: runs.cell.clone(),
        real,
        real_interval: real.interval(),
        simulated,
        simulated_interval: simulated.interval(),
        p_value: fisher_less(real, simulated),
        p_corrected: corrected.exact[index],
        p_supported: probability_at_least(real, simulated, test.margin()),
        e_violated: e_value(less),
        p_violated,
        e_supported: e_value(at_least),
        p_not_supported,
        verdict,
        further_runs: (verdict == Verdict::Undecided).then(|| runs_until(if_all_mill)).flatten(),
    }
}

/// The least number of runs, of at most [`MOST_RUNS`], from which on a condition holds.
pub(crate) fn runs_until(is_enough: impl Fn(u64) -> bool) -> Option<u64> {
    let mut enough = 1;
    while !is_enough(enough) {
        enough *= 2;
        if enough > MOST_RUNS {
            return None;
        }
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
    Some(enough)
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
            match distance_from_wanted(phase).cmp(&distance_from_wanted(expected)) {
                std::cmp::Ordering::Less => tally.easier += n,
                std::cmp::Ordering::Equal => tally.same += n,
                std::cmp::Ordering::Greater => tally.harder += n,
            }
        }
    }
    tally
}

fn distance_from_wanted(phase: Phase) -> u8 {
    match phase {
        Phase::StableMilling | Phase::Aggregated | Phase::SpreadOut => 0,
        Phase::SemiStableMilling | Phase::PartlyAggregated | Phase::PartlySpreadOut => 1,
        Phase::Unformed | Phase::NotAggregated | Phase::NotSpreadOut => 2,
        Phase::Dispersion | Phase::CollidingUnstable => 3,
    }
}
