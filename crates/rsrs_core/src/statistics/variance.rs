//! Spreads with how sure they are: intervals of variances and of differences of variances.

use serde::{Deserialize, Serialize};

use crate::statistics::interval::TAIL;
use crate::statistics::quantile;

/// A number with its two-sided 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The best guess.
    pub value: f64,
    /// Lower bound; `None` if the data cannot give one.
    pub low: Option<f64>,
    /// Upper bound; `None` if the data cannot give one.
    pub high: Option<f64>,
}

/// One mean square of an analysis of variance, and how it enters a variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanSquare {
    /// What its expectation is multiplied with; negative for what is taken off.
    pub weight: f64,
    /// The mean square; not negative.
    pub value: f64,
    /// Its degrees of freedom; positive.
    pub df: f64,
}

impl Estimate {
    /// The mean of independent normal numbers of one variance, with Student's interval, which one
    /// number alone does not have.
    ///
    /// # Panics
    ///
    /// If there is no number.
    ///
    /// # Source
    ///
    /// Student, "The probable error of a mean", Biometrika 6, 1908; checked against scipy.
    pub fn of_mean(numbers: &[f64]) -> Self {
        let value = mean(numbers);
        let Some(sd) = sd(numbers) else { return Self { value, low: None, high: None } };
        let n = numbers.len() as f64;
        let away = quantile::student(n - 1.0, 1.0 - TAIL) * sd / n.sqrt();
        Self { value, low: Some(value - away), high: Some(value + away) }
    }

    /// A variance that is a combination of mean squares; neither it nor its bounds are below zero.
    ///
    /// One mean square alone gets the exact chi-squared interval. Differences, such as the variance
    /// between robots, have no exact one; the modified large-sample interval becomes exact at both
    /// ends (one mean square dominating, or many degrees of freedom) and covers the truth in 93 to
    /// 98 % in between, as the recovery test of this crate shows again.
    ///
    /// # Source
    ///
    /// N. Ting, R. K. Burdick, F. A. Graybill, S. Jeyaratnam, T.-F. C. Lu, "Confidence intervals on
    /// linear combinations of variance components that are unrestricted in sign", Journal of
    /// Statistical Computation and Simulation 35, 1990.
    pub fn of_variance(terms: &[MeanSquare]) -> Self {
        let value: f64 = terms.iter().map(|term| term.weight * term.value).sum();
        let below = squared_reach(terms, Bound::Low).max(0.0).sqrt();
        let above = squared_reach(terms, Bound::High).max(0.0).sqrt();
        Self {
            value: value.max(0.0),
            low: Some((value - below).max(0.0)),
            high: Some((value + above).max(0.0)),
        }
    }

    /// The standard deviation of a variance, times a factor.
    #[must_use]
    pub fn sd(self, factor: f64) -> Self {
        let root = |variance: f64| variance.sqrt() * factor;
        Self { value: root(self.value), low: self.low.map(root), high: self.high.map(root) }
    }
}

/// Mean of numbers.
///
/// # Panics
///
/// If there is none.
pub fn mean(numbers: &[f64]) -> f64 {
    assert!(!numbers.is_empty(), "no numbers have no mean");
    numbers.iter().sum::<f64>() / numbers.len() as f64
}

/// Sum of squared distances from the mean.
pub fn squared_deviations(numbers: &[f64]) -> f64 {
    let mean = mean(numbers);
    numbers.iter().map(|number| (number - mean) * (number - mean)).sum()
}

/// Standard deviation with `n - 1`; `None` for fewer than two numbers.
pub fn sd(numbers: &[f64]) -> Option<f64> {
    let freedom = numbers.len().checked_sub(1).filter(|freedom| *freedom > 0)?;
    Some((squared_deviations(numbers) / freedom as f64).sqrt())
}

#[derive(Clone, Copy, PartialEq)]
enum Bound {
    Low,
    High,
}

/// Square of the distance from the variance to one of its bounds: `V_L` or `V_U` of the source.
fn squared_reach(terms: &[MeanSquare], bound: Bound) -> f64 {
    // For the lower bound, added terms may be too large by G and taken off ones too small by H;
    // for the upper bound, the other way round.
    let reach = |term: &MeanSquare| match (bound, term.weight > 0.0) {
        (Bound::Low, true) | (Bound::High, false) => over(term.df),
        (Bound::Low, false) | (Bound::High, true) => under(term.df),
    };
    let size = |term: &MeanSquare| term.weight.abs() * term.value;
    let mut total = 0.0;
    for (position, term) in terms.iter().enumerate() {
        let own = reach(term) * size(term);
        total += own * own;
        for other in &terms[position + 1..] {
            total += crossed(terms, bound, term, other) * size(term) * size(other);
        }
    }
    total
}

/// `G`: how far a mean square may lie above its expectation.
fn over(df: f64) -> f64 {
    1.0 - df / quantile::chi_squared(df, 1.0 - TAIL)
}

/// `H`: how far a mean square may lie below its expectation.
fn under(df: f64) -> f64 {
    df / quantile::chi_squared(df, TAIL) - 1.0
}

/// The factor of a product of two mean squares: `G_qr`, `H_qr` or `G*_qt` of the source.
fn crossed(terms: &[MeanSquare], bound: Bound, one: &MeanSquare, other: &MeanSquare) -> f64 {
    let one_is_added = one.weight > 0.0;
    if one_is_added == (other.weight > 0.0) {
        return together(terms, bound, one, other);
    }
    let (added, taken) = if one_is_added { (one, other) } else { (other, one) };
    let (ratio, added_reach, taken_reach) = match bound {
        Bound::Low => {
            (quantile::fisher(added.df, taken.df, 1.0 - TAIL), over(added.df), under(taken.df))
        }
        Bound::High => {
            (quantile::fisher(added.df, taken.df, TAIL), under(added.df), over(taken.df))
        }
    };
    let own = added_reach * ratio;
    ((ratio - 1.0) * (ratio - 1.0) - own * own - taken_reach * taken_reach) / ratio
}

fn together(terms: &[MeanSquare], bound: Bound, one: &MeanSquare, other: &MeanSquare) -> f64 {
    let is_added = one.weight > 0.0;
    if is_added != (bound == Bound::Low) {
        return 0.0;
    }
    let n_alike = terms.iter().filter(|term| (term.weight > 0.0) == is_added).count();
    let (n, m) = (one.df, other.df);
    let (own, others, both) = (over(n), over(m), over(n + m));
    let joint = both * both * (n + m) * (n + m) / (n * m);
    (joint - own * own * n / m - others * others * m / n) / (n_alike as f64 - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_mean_square_gets_the_chi_squared_interval() {
        let variance = Estimate::of_variance(&[MeanSquare { weight: 1.0, value: 4.0, df: 9.0 }]);

        // 9 * 4 over the chi-squared quantiles 19.0228 and 2.7004 of a printed table.
        assert!((variance.low.unwrap() - 36.0 / 19.0228).abs() < 1e-4, "{variance:?}");
        assert!((variance.high.unwrap() - 36.0 / 2.7004).abs() < 1e-3, "{variance:?}");
    }

    #[test]
    fn a_difference_of_variances_is_never_negative() {
        let terms = [
            MeanSquare { weight: 0.5, value: 1.0, df: 4.0 },
            MeanSquare { weight: -0.5, value: 2.0, df: 10.0 },
        ];

        let variance = Estimate::of_variance(&terms);

        assert!(variance.value == 0.0 && variance.low == Some(0.0));
        assert!(variance.high.unwrap() > 0.0, "{variance:?}");
    }

    #[test]
    fn one_number_has_a_mean_and_no_interval() {
        assert_eq!(Estimate::of_mean(&[0.9]), Estimate { value: 0.9, low: None, high: None });
    }
}
