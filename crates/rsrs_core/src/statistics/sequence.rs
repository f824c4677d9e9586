//! How sure a share is, however long one goes on looking: a confidence sequence.
//!
//! An interval of Clopper and Pearson covers the truth in 95 % of all cases if the number of runs
//! was fixed before the first. An analyst who looks after every run and stops at a convenient
//! moment errs more often: in the long run always. A confidence sequence covers the truth *at all
//! times at once* with 95 %, so it may be looked at after every run, and it does not matter why one
//! stopped. Its price is its width: at 100 runs about 1.6 times that of Clopper and Pearson, at
//! 1,000 about 1.8 times.

use crate::statistics::beta;
use crate::statistics::interval::Interval;

/// Probability that a sequence ever misses the truth.
pub const ERROR: f64 = 0.05;

/// The interval of a confidence sequence after `n` runs, `hits` of which did: with a probability of
/// `1 - error` the sequence of these intervals, one after each run, never misses the truth. Without
/// runs it is from 0 to 1. The error is strictly between 0 and 1; that of an interval of 95 % is
/// [`ERROR`].
///
/// For a share `p`, the likelihood ratio of a share drawn evenly from 0 to 1 against `p`,
///
/// `M(p) = B(hits + 1, n - hits + 1) / (p^hits (1 - p)^(n - hits))`,
///
/// is a nonnegative martingale with mean 1 if `p` is true, so by Ville's inequality it ever reaches
/// `1 / error` with a probability of at most `error`. The interval holds every `p` for which it is
/// below that now. It depends on the counts alone and not on their order.
///
/// *Many cells.* Each cell of a diagram has a sequence of its own, so of 100 cells about 5 may err
/// at some time. All `n_cells` hold at once with a probability of `1 - error` if each is asked for
/// `error / n_cells` (Boole's inequality).
///
/// # Panics
///
/// If there are more hits than runs.
///
/// # Source
///
/// H. Robbins, "Statistical methods related to the law of the iterated logarithm", Annals of
/// Mathematical Statistics 41, 1970; J. Ville, "Étude critique de la notion de collectif", 1939. As
/// the beta-binomial mixture in S. R. Howard et al., "Time-uniform, nonparametric, nonasymptotic
/// confidence sequences", Annals of Statistics 49, 2021.
///
/// # Example
///
/// Sixteen of sixteen, if sixteen was not fixed before.
///
/// ```
/// use rsrs_core::statistics::sequence::{ERROR, interval};
///
/// let interval = interval(16, 16, ERROR);
/// assert_eq!(format!("{:.2} to {:.2}", interval.low, interval.high), "0.69 to 1.00");
/// ```
pub fn interval(hits: u64, n: u64, error: f64) -> Interval {
    assert!(hits <= n, "{hits} hits of {n} runs");
    if n == 0 {
        return Interval { low: 0.0, high: 1.0 };
    }
    let evidence = Evidence::new(hits, n);
    let most = -libm::log(error);
    let share = hits as f64 / n as f64;
    // Against the observed share itself there is no evidence, and it grows to either side.
    let low = if hits == 0 { 0.0 } else { edge(0.0, share, |p| evidence.against(p) < most) };
    let high = if hits == n { 1.0 } else { edge(1.0, share, |p| evidence.against(p) < most) };
    Interval { low, high }
}

/// The evidence of the counts against a share.
struct Evidence {
    hit: f64,
    missed: f64,
    log_mixture: f64,
}

impl Evidence {
    fn new(hits: u64, n: u64) -> Self {
        let (hit, missed) = (hits as f64, (n - hits) as f64);
        Self { hit, missed, log_mixture: beta::log_beta(hit + 1.0, missed + 1.0) }
    }

    /// `log M(p)`.
    fn against(&self, share: f64) -> f64 {
        let hits = if self.hit > 0.0 { self.hit * libm::log(share) } else { 0.0 };
        let misses = if self.missed > 0.0 { self.missed * libm::log1p(-share) } else { 0.0 };
        self.log_mixture - hits - misses
    }
}

/// The last number outside on the way from one that is outside to one that is inside.
fn edge(mut outside: f64, mut inside: f64, is_inside: impl Fn(f64) -> bool) -> f64 {
    loop {
        let middle = outside + (inside - outside) / 2.0;
        if middle <= outside.min(inside) || middle >= outside.max(inside) {
            return outside;
        }
        if is_inside(middle) {
            inside = middle;
        } else {
            outside = middle;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-11, "found {found}, expected {expected}");
    }

    #[test]
    fn where_all_or_none_did_the_interval_is_known_in_closed_form() {
        for n in [1_u64, 2, 16, 100, 100_000] {
            let bound = libm::pow(ERROR / (n as f64 + 1.0), 1.0 / n as f64);

            let (all, none) = (interval(n, n, ERROR), interval(0, n, ERROR));

            assert_near(all.low, bound);
            assert_eq!(all.high.to_bits(), 1.0_f64.to_bits());
            assert_near(none.high, 1.0 - bound);
            assert_eq!(none.low.to_bits(), 0.0_f64.to_bits());
        }
    }

    #[test]
    fn hits_and_misses_are_mirror_images() {
        for (hits, n) in [(0, 1), (1, 3), (5, 16), (500, 600)] {
            let (one, other) = (interval(hits, n, ERROR), interval(n - hits, n, ERROR));

            assert_near(one.low, 1.0 - other.high);
            assert_near(one.high, 1.0 - other.low);
        }
    }

    #[test]
    fn the_interval_is_everything_before_the_first_run() {
        assert_eq!(interval(0, 0, ERROR), Interval { low: 0.0, high: 1.0 });
    }
}
