//! How often simulated robots mill is known from runs only: evidence that holds whatever it is.
//!
//! Nothing is assumed about `B_s`, the share of simulated runs that mill. For every value `b` that it may
//! have there is a capital that is expected to be at most 1 if `b` is true: that of bets on the real runs,
//! made as if `b` were known, times that of bets on the simulated runs against `b`. One of the values is
//! the true one, so the *least* of these capitals over all `b` is expected to be at most 1, too; of several
//! cells, the least over all of their shares together. Where `b` is far from what the simulated runs show,
//! the bets on these have won much, so the least lies near it.
//!
//! A bet on simulated runs multiplies the capital by `exp(θ x) / (1 - b + b exp(θ))` for each, `x` being 1
//! if it milled and else 0: that is expected to be 1 if `b` is true, for every stake `θ`, which is
//! fixed before; a negative one wins where `b` is too great, a positive one where it is too small.
//!
//! *The least is found exactly.* The logarithm of each bet's capital is a convex function of the shares, of
//! the form of [`Term`], and so is the logarithm of the sum of capitals. Such a function lies nowhere below
//! its tangent: at the point that a search ends with, the tangent bounds what any other shares could have
//! in less, and that is taken off ([`Portfolio::least`]).
//!
//! # Source
//!
//! L. Wasserman, A. Ramdas and S. Balakrishnan, "Universal inference", Proceedings of the National Academy
//! of Sciences 117, 2020, for the least over what is not known; S. Boyd and L. Vandenberghe, "Convex
//! Optimization", 2004, 3.1.3 and 3.1.5.

use crate::statistics::share::Share;

/// Stakes on simulated runs, in parts of the stake that suits one cell with its bets on real runs, each
/// with the part of the capital that is staked so. Nothing suits the first runs, an eighth campaigns in many
/// cells, of which each has its part of the runs; four times as much bounds shares that are far from what
/// was simulated.
pub const STAKES: [(f64, f64); 4] = [(0.0, 0.1), (0.125, 0.35), (1.0, 0.45), (4.0, 0.1)];

/// The greatest stake on all simulated runs together that suits one cell, in roots of their number: greater
/// ones cost more than they can win.
pub const GREATEST_STAKE: f64 = 5.0;

/// The logarithm of a bet's capital in one cell, as a function of the share `b` of simulated runs that mill:
/// `constant + slope b - n ln(1 + u b) - m ln(1 + v b)`, which is convex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Term {
    /// Everything that does not depend on the share.
    pub constant: f64,
    /// Of the bets on real runs that mill as often as simulated ones but for a margin.
    pub slope: f64,
    /// Real runs `n`, and `u`, of the bets on real runs that mill less often; `u` is above -1.
    pub real: (f64, f64),
    /// Simulated runs `m`, and `v`, of the bets on these; `v` is above -1.
    pub simulated: (f64, f64),
}

impl Term {
    /// That of a stake on simulated runs alone: `stake` is what suits one cell, on all runs
    /// together, and its sign is what is bet on; `part` is one of [`STAKES`].
    pub fn staked(runs: Share, stake: f64, part: f64) -> Self {
        let n = runs.n as f64;
        let greatest = GREATEST_STAKE * n.sqrt();
        let stake = stake.clamp(-greatest, greatest) * part / n.max(1.0);
        Self {
            constant: stake * runs.hits as f64,
            simulated: (n, libm::expm1(stake)),
            ..Self::default()
        }
    }

    /// Its value if simulated robots have this share.
    pub fn at(&self, share: f64) -> f64 {
        let of = |(n, per_run): (f64, f64)| {
            if n > 0.0 { n * libm::log1p(per_run * share) } else { 0.0 }
        };
        self.constant + self.slope * share - of(self.real) - of(self.simulated)
    }

    /// Its first and second derivative.
    fn slopes(&self, share: f64) -> [f64; 2] {
        let of = |(n, per_run): (f64, f64)| {
            let ratio = per_run / (1.0 + per_run * share);
            [n * ratio, n * ratio * ratio]
        };
        let ([first, second], [of_simulated, again]) = (of(self.real), of(self.simulated));
        [self.slope - first - of_simulated, second + again]
    }
}

/// Bets among which a capital is divided, in some cells.
#[derive(Clone, Debug)]
pub struct Portfolio {
    /// Of each bet the logarithm of its part of the capital.
    log_parts: Vec<f64>,
    /// Cell by cell, the term of each bet.
    cells: Vec<Vec<Term>>,
}

/// Rounds over all cells after which a search ends, wherever it is.
const ROUNDS: u32 = 200;

/// Steps within one cell.
const STEPS: u32 = 60;

/// What is taken off the logarithm of the least capital is at most this where the search converges.
const ACCURACY: f64 = 1e-5;

impl Portfolio {
    /// A capital of one, divided among bets with these parts, which have a term each in every cell.
    pub fn new(parts: &[f64], cells: Vec<Vec<Term>>) -> Self {
        Self { log_parts: parts.iter().map(|part| libm::log(*part)).collect(), cells }
    }

    /// The logarithm of the least capital over all shares of the cells, with a search that begins
    /// at `shares`; 0 without cells.
    pub fn least(&self, shares: &[f64]) -> f64 {
        self.least_towards(shares, None)
    }

    /// Whether the logarithm of the least capital over all shares of the cells is at least `enough`; the search, which
    /// begins at `shares`, ends where that is known.
    pub fn is_at_least(&self, shares: &[f64], enough: f64) -> bool {
        self.least_towards(shares, Some(enough)) >= enough
    }

    fn least_towards(&self, shares: &[f64], enough: Option<f64>) -> f64 {
        let mut shares = shares.to_vec();
        let mut logs = self.log_parts.clone();
        for (share, terms) in shares.iter().zip(&self.cells) {
            for (log, term) in logs.iter_mut().zip(terms) {
                *log += term.at(*share);
            }
        }
        for _ in 0..ROUNDS {
            for cell in 0..shares.len() {
                self.move_to_least(cell, &mut shares, &mut logs);
                if enough.is_some_and(|enough| log_sum(&logs) < enough) {
                    return log_sum(&logs);
                }
            }
            let deficit = self.deficit(&shares, &logs);
            if deficit <= ACCURACY
                || enough.is_some_and(|enough| log_sum(&logs) - deficit >= enough)
            {
                break;
            }
        }
        log_sum(&logs) - self.deficit(&shares, &logs)
    }

    /// First and second derivative of the logarithm of the capital by one share.
    fn slopes(&self, cell: usize, share: f64, logs: &[f64]) -> [f64; 2] {
        let greatest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let [mut all, mut first, mut square, mut second] = [0.0; 4];
        for (log, term) in logs.iter().zip(&self.cells[cell]) {
            let (weight, [slope, curvature]) = (libm::exp(log - greatest), term.slopes(share));
            all += weight;
            first += weight * slope;
            square += weight * slope * slope;
            second += weight * curvature;
        }
        let mean = first / all;
        [mean, second / all + square / all - mean * mean]
    }

    /// Moves the share of one cell to where the capital is least, the others being what they are: by
    /// Newton's steps, halving where these leave what is left.
    fn move_to_least(&self, cell: usize, shares: &mut [f64], logs: &mut [f64]) {
        let (mut low, mut high) = (0.0_f64, 1.0_f64);
        let mut share = shares[cell];
        for _ in 0..STEPS {
            let [slope, curvature] = self.slopes(cell, share, logs);
            if slope > 0.0 {
                high = share;
            } else {
                low = share;
            }
            let newton = share - slope / curvature;
            let next = if newton > low && newton < high {
                newton
            } else if slope < 0.0 && high - low < 1e-12 {
                high
            } else {
                low + (high - low) / 2.0
            };
            let moved = (next - share).abs();
            for (log, term) in logs.iter_mut().zip(&self.cells[cell]) {
                *log += term.at(next) - term.at(share);
            }
            share = next;
            if moved <= 1e-13 {
                break;
            }
        }
        shares[cell] = share;
    }

    /// How much less than here the logarithm of the capital could be anywhere, by its tangent.
    fn deficit(&self, shares: &[f64], logs: &[f64]) -> f64 {
        let of_cell = |(cell, share): (usize, &f64)| {
            let [slope, _] = self.slopes(cell, *share, logs);
            if slope > 0.0 { slope * share } else { -slope * (1.0 - share) }
        };
        shares.iter().enumerate().map(of_cell).sum()
    }
}

/// The logarithm of a sum of what has these logarithms.
pub fn log_sum(logs: &[f64]) -> f64 {
    let greatest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if greatest == f64::NEG_INFINITY {
        return greatest;
    }
    greatest + libm::log(logs.iter().map(|log| libm::exp(log - greatest)).sum())
}
