//! How sure a share is: exact confidence intervals.

use serde::{Deserialize, Serialize};

use crate::statistics::beta;

/// A two-sided 95 % confidence interval of a probability.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Lower bound, from 0 to 1.
    pub low: f64,
    /// Upper bound, from 0 to 1.
    pub high: f64,
}

/// Probability that the truth lies below the interval, and again above it.
pub(crate) const TAIL: f64 = 0.025;

impl Interval {
    /// The interval of Clopper and Pearson for `hits` of `n` runs: it covers the true probability
    /// in at least 95 % of all cases, for any number of runs. Without runs it is from 0 to 1.
    ///
    /// # Panics
    ///
    /// If there are more hits than runs.
    ///
    /// # Source
    ///
    /// C. J. Clopper, E. S. Pearson, Biometrika 26, 1934.
    ///
    /// # Example
    ///
    /// Sixteen of sixteen are no certainty.
    ///
    /// ```
    /// use rsrs_core::statistics::interval::Interval;
    ///
    /// let interval = Interval::clopper_pearson(16, 16);
    /// assert_eq!(format!("{:.2} to {:.2}", interval.low, interval.high), "0.79 to 1.00");
    /// ```
    pub fn clopper_pearson(hits: u64, n: u64) -> Self {
        Self::with_tails(hits, n, TAIL)
    }

    /// Bounds of Clopper and Pearson. The truth lies below the lower one with a probability of at
    /// most `tail`, strictly between 0 and 0.5, and above the upper one likewise.
    ///
    /// # Panics
    ///
    /// If there are more hits than runs.
    ///
    /// # Source
    ///
    /// As [`Self::clopper_pearson`].
    pub fn with_tails(hits: u64, n: u64, tail: f64) -> Self {
        assert!(hits <= n, "{hits} hits of {n} runs");
        Self::of_amounts(hits as f64, (n - hits) as f64, tail)
    }

    /// As [`Self::with_tails`], for amounts that need not be whole.
    pub(crate) fn of_amounts(hit: f64, missed: f64, tail: f64) -> Self {
        let low = if hit > 0.0 { beta::quantile(hit, missed + 1.0, tail) } else { 0.0 };
        let high = if missed > 0.0 { beta::quantile(hit + 1.0, missed, 1.0 - tail) } else { 1.0 };
        Self { low, high }
    }

    /// Upper bound minus lower bound.
    pub fn width(self) -> f64 {
        self.high - self.low
    }

    /// Whether a number lies within, bounds included.
    pub fn contains(self, number: f64) -> bool {
        (self.low..=self.high).contains(&number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_is_that_of_scipy() {
        // scipy 1.17: scipy.stats.binomtest(k, n).proportion_ci(0.95, "exact")
        for (hits, n, low, high) in [
            (0, 16, 0.0, 0.205_907_214_207_823_12),
            (1, 16, 0.001_581_111_722_769_200_5, 0.302_320_738_434_561_03),
            (13, 16, 0.543_543_453_768_388_3, 0.959_526_266_094_054_1),
            (16, 16, 0.794_092_785_792_176_9, 1.0),
            (3, 3, 0.292_401_773_821_286_7, 1.0),
            (868, 1000, 0.845_434_553_391_940_6, 0.888_371_987_027_211_1),
            (1, 1000, 2.531_748_749_167_463_4e-5, 0.005_558_924_279_849_9),
        ] {
            let interval = Interval::clopper_pearson(hits, n);

            assert!((interval.low - low).abs() < 1e-11, "{hits} of {n}: {interval:?}");
            assert!((interval.high - high).abs() < 1e-11, "{hits} of {n}: {interval:?}");
        }
    }

    #[test]
    fn all_none_and_nothing_are_exact_at_their_ends() {
        assert_eq!(Interval::clopper_pearson(0, 0), Interval { low: 0.0, high: 1.0 });
        assert_eq!(Interval::clopper_pearson(0, 5).low.to_bits(), 0.0_f64.to_bits());
        assert_eq!(Interval::clopper_pearson(5, 5).high.to_bits(), 1.0_f64.to_bits());
    }
}
