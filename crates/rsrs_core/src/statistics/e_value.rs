//! Evidence that may be looked at after every run: e-values of both claims of a comparison.
//!
//! An e-value is a number that is expected to be at most 1 if a hypothesis holds, and the e-values
//! here are nonnegative supermartingales in the runs: by Ville's inequality one of them *ever*
//! reaches 20 with a probability of at most 1/20. So an analyst who looks after each run, stops
//! when it pleases, or goes on after a look errs no more often than stated. The price is that a
//! fixed number of runs would decide with fewer of them.
//!
//! *What simulated robots do* is itself estimated from runs only. It enters as its posterior, with
//! a uniform prior: every e-value is the probability of the real runs under an alternative over
//! their probability under the hypothesis, each integrated over that posterior.
//!
//! *Worse.* The hypothesis is `B_r >= B_s` in every cell. Under the alternatives, real robots have
//! in all cells the odds of milling divided by one of [`ODDS_DIVIDED_BY`].
//!
//! *As good, but for a margin.* The hypothesis is that `B_r`, averaged over all runs, is less than
//! the average of `B_s - margin`. A gambler with one unit bets a share `bet` of what may be bet,
//! `1 / (1 - margin)`, on every run: it is multiplied by `1 + bet (x - B_s + margin)`, `x` being 1 if
//! the run milled and else 0. With the same bet for all runs this is expected to be at most 1 if the
//! *average* is that low, however it is spread over the cells, because a geometric mean is at most
//! the arithmetic one. The gambler's capital is split among [`BETS`].
//!
//! # Source
//!
//! J. Ville, "Étude critique de la notion de collectif", 1939; G. Shafer, "Testing by betting",
//! Journal of the Royal Statistical Society A 184, 2021; I. Waudby-Smith and A. Ramdas, "Estimating
//! means of bounded random variables by betting", Journal of the Royal Statistical Society B 86,
//! 2024; for running averages of means that differ, Y. J. Choe and A. Ramdas, "Comparing sequential
//! forecasters", Operations Research 72, 2024.

use std::f64::consts::SQRT_2;

use crate::statistics::beta;
use crate::statistics::posterior::GAUSS;
use crate::statistics::share::Share;

/// How much worse real robots are under the alternatives, all of equal weight: their odds of milling
/// are those of simulated ones divided by this.
pub const ODDS_DIVIDED_BY: [f64; 8] = [SQRT_2, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 256.0];

/// Shares of the greatest possible bet, with the part of the capital that is bet so.
///
/// Real robots that nearly always mill are found out soonest by great bets, those that fall short by
/// little less than the margin by small ones.
pub const BETS: [(f64, f64); 5] = [(0.15, 0.1), (0.35, 0.1), (0.6, 0.2), (0.8, 0.3), (1.0, 0.3)];

/// Posterior of the share of stable milling of a simulated cell.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedShare {
    /// Their weights add up to 1.
    nodes: Vec<Node>,
    mean: f64,
    variance: f64,
}

/// A share that the simulated robots may have.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    share: f64,
    /// The rest; where nearly all mill it is too small to be computed as 1 minus the share.
    missed: f64,
    log_weight: f64,
}

impl Node {
    /// The share with these log odds, weighed with a beta distribution.
    fn at(log_odds: f64, weight: f64, a: f64, b: f64) -> Self {
        let share = 1.0 / (1.0 + libm::exp(-log_odds));
        let missed = 1.0 / (1.0 + libm::exp(log_odds));
        // A step of log odds is one of `share * missed` of the share.
        let log_weight = libm::log(weight) + a * libm::log(share) + b * libm::log(missed);
        Self { share, missed, log_weight }
    }
}

/// Probability on either side of the nodes.
const TAIL: f64 = 1e-15;

/// Panels of five nodes on which the posterior is held.
const PANELS: u32 = 32;

impl SimulatedShare {
    /// The posterior after simulated runs, with a uniform prior.
    pub fn after(runs: Share) -> Self {
        let (a, b) = (runs.hits as f64 + 1.0, (runs.n - runs.hits) as f64 + 1.0);
        // Real runs that go otherwise than simulated ones shift the weight far into the tails; on the
        // scale of log odds, every alternative shifts it by as much everywhere.
        let log_odds = |share: f64, missed: f64| libm::log(share / missed);
        let (least, fewest) = (beta::quantile(a, b, TAIL), beta::quantile(b, a, TAIL));
        let (low, high) = (log_odds(least, 1.0 - least), log_odds(1.0 - fewest, fewest));
        let half = (high - low) / f64::from(PANELS) / 2.0;
        let mut nodes: Vec<Node> = (0..PANELS)
            .flat_map(|panel| {
                let middle = low + half * f64::from(2 * panel + 1);
                GAUSS.map(|(node, weight)| Node::at(middle + half * node, weight, a, b))
            })
            .collect();
        let log_total = log_sum(nodes.iter().map(|node| node.log_weight));
        for node in &mut nodes {
            node.log_weight -= log_total;
        }
        let mean = a / (a + b);
        Self { nodes, mean, variance: mean * (1.0 - mean) / (a + b + 1.0) }
    }

    /// The logarithm of an expectation over the posterior of what has this logarithm.
    fn log_mean(&self, log_of: impl Fn(&Node) -> f64) -> f64 {
        log_sum(self.nodes.iter().map(|node| node.log_weight + log_of(node)))
    }
}

/// The evidence in the real runs of one cell, before the alternatives are mixed.
#[derive(Clone, Debug, PartialEq)]
pub struct CellEvidence {
    n: f64,
    mean: f64,
    variance: f64,
    margin: f64,
    /// For each of [`ODDS_DIVIDED_BY`], the logarithm of its likelihood ratio.
    less: [f64; ODDS_DIVIDED_BY.len()],
    /// For each of [`BETS`], the logarithm of what became of one unit.
    at_least: [f64; BETS.len()],
}

/// Where the margin is greater than the simulated share, the hypothesis leaves real robots this chance
/// to mill, when the posterior is weighed with what they did.
const LEAST_SHARE: f64 = 0.005;

impl CellEvidence {
    /// Holds real runs against simulated ones.
    ///
    /// # Arguments
    ///
    /// * `real` — the real runs of the cell so far.
    /// * `simulated` — what simulated robots do there.
    /// * `margin` — by how much real robots may fall short, from 0 to less than 1.
    pub fn of(real: Share, simulated: &SimulatedShare, margin: f64) -> Self {
        let log_likelihood = log_likelihood(real);
        let if_equal = simulated.log_mean(|node| log_likelihood(node.share, node.missed));
        let less = ODDS_DIVIDED_BY.map(|factor| {
            let worse = simulated.log_mean(|Node { share, missed, .. }| {
                let (missed, all) = (factor * missed, share + factor * missed);
                log_likelihood(share / all, missed / all)
            });
            worse - if_equal
        });
        let log_short = |node: &Node| {
            let short = node.share - margin;
            if short < LEAST_SHARE {
                log_likelihood(LEAST_SHARE, 1.0 - LEAST_SHARE)
            } else {
                log_likelihood(short, node.missed + margin)
            }
        };
        let if_short = simulated.log_mean(log_short);
        let at_least = BETS.map(|(part, _)| {
            let bet = part / (1.0 - margin);
            let won = simulated.log_mean(|node| {
                // Where simulated robots mill less often than the margin, nothing can fall short, and
                // nothing is won: how probable that is counts once, in the chance above the margin.
                let if_mills = 1.0 + bet * (node.missed + margin).min(1.0);
                let if_not = (1.0 - bet * (node.share - margin).max(0.0)).max(1e-300);
                log_short(node) + log_likelihood(if_mills, if_not)
            });
            won - if_short
        });
        let SimulatedShare { mean, variance, .. } = *simulated;
        Self { n: real.n as f64, mean, variance, margin, less, at_least }
    }
}

/// The logarithm of `hit^hits missed^misses`.
fn log_likelihood(runs: Share) -> impl Fn(f64, f64) -> f64 {
    let (hits, misses) = (runs.hits as f64, (runs.n - runs.hits) as f64);
    move |hit, missed| {
        let of_hits = if hits > 0.0 { hits * libm::log(hit) } else { 0.0 };
        let of_misses = if misses > 0.0 { misses * libm::log(missed) } else { 0.0 };
        of_hits + of_misses
    }
}

/// The logarithm of the e-value against `B_r >= B_s` in every one of these cells.
///
/// One half of it bets that real robots are worse by as much in all cells, the other half is spread
/// over the cells, so that one that is much worse is found among many that are not.
pub fn log_e_less(cells: &[CellEvidence]) -> f64 {
    let run: Vec<&CellEvidence> = cells.iter().filter(|cell| cell.n > 0.0).collect();
    if run.is_empty() {
        return 0.0;
    }
    let log_weight = -libm::log(ODDS_DIVIDED_BY.len() as f64);
    let in_all = log_sum(
        (0..ODDS_DIVIDED_BY.len())
            .map(|effect| log_weight + run.iter().map(|cell| cell.less[effect]).sum::<f64>()),
    );
    let in_one =
        log_sum(run.iter().flat_map(|cell| cell.less)) + log_weight - libm::log(run.len() as f64);
    log_sum([in_all, in_one].into_iter()) - std::f64::consts::LN_2
}

/// The logarithm of the e-value against `B_r` being less, averaged over all runs, than the average of
/// `B_s - margin`.
///
/// Where even the simulated average is hardly above the margin, there is little to be less than, and
/// the evidence is that much stronger.
pub fn log_e_at_least(cells: &[CellEvidence]) -> f64 {
    if cells.iter().all(|cell| cell.n == 0.0) {
        return 0.0;
    }
    let won = log_sum(BETS.iter().enumerate().map(|(index, (_, capital))| {
        libm::log(*capital) + cells.iter().map(|cell| cell.at_least[index]).sum::<f64>()
    }));
    won - libm::log(chance_above_margin(cells))
}

/// Posterior probability that the simulated average is above the margin, as that of the beta
/// distribution with its mean and variance; exact for one cell.
fn chance_above_margin(cells: &[CellEvidence]) -> f64 {
    let n: f64 = cells.iter().map(|cell| cell.n).sum();
    let mean: f64 = cells.iter().map(|cell| cell.n / n * cell.mean).sum();
    let variance: f64 = cells.iter().map(|cell| (cell.n / n).powi(2) * cell.variance).sum();
    let size = mean * (1.0 - mean) / variance - 1.0;
    let margin = cells.iter().map(|cell| cell.margin).fold(0.0, f64::max);
    (1.0 - beta::distribution(mean * size, (1.0 - mean) * size, margin)).max(1e-12)
}

/// The logarithm of a sum of what has these logarithms.
fn log_sum(logs: impl Iterator<Item = f64> + Clone) -> f64 {
    let greatest = logs.clone().fold(f64::NEG_INFINITY, f64::max);
    if greatest == f64::NEG_INFINITY {
        return greatest;
    }
    greatest + libm::log(logs.map(|log| libm::exp(log - greatest)).sum())
}
