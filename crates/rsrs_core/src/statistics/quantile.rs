//! Quantiles of the distributions of normal samples: Student's t, chi-squared and Fisher's F.

use crate::statistics::beta;

/// The number that Student's t does not exceed with a probability strictly between 0 and 1.
pub fn student(df: f64, probability: f64) -> f64 {
    let within = (2.0 * probability - 1.0).abs();
    // t² / (df + t²) is beta distributed.
    let share = beta::quantile(0.5, df / 2.0, within);
    (df * share / (1.0 - share)).sqrt().copysign(probability - 0.5)
}

/// The probability that the size of Student's t exceeds a number.
pub fn student_two_sided(df: f64, t: f64) -> f64 {
    beta::distribution(df / 2.0, 0.5, df / (df + t * t))
}

/// The number that a chi-squared variable does not exceed with a probability.
pub fn chi_squared(df: f64, probability: f64) -> f64 {
    let is_below = |number: f64| gamma_distribution(df / 2.0, number / 2.0) < probability;
    let mut high = df + 10.0;
    while is_below(high) {
        high *= 2.0;
    }
    beta::bisected([0.0, high], is_below)
}

/// The number that Fisher's F does not exceed with a probability.
pub fn fisher(numerator_df: f64, denominator_df: f64, probability: f64) -> f64 {
    let share = beta::quantile(numerator_df / 2.0, denominator_df / 2.0, probability);
    denominator_df * share / (numerator_df * (1.0 - share))
}

/// `P(a, x)`, the regularised lower incomplete gamma function.
///
/// # Source
///
/// NIST Digital Library of Mathematical Functions, 8.7.1 below the mean and 8.9.2 above.
fn gamma_distribution(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let front = libm::exp(a * libm::log(x) - x - libm::lgamma(a));
    if x < a + 1.0 {
        let (mut term, mut sum, mut over) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-17 {
            over += 1.0;
            term *= x / over;
            sum += term;
        }
        return front * sum;
    }
    let mut base = x + 1.0 - a;
    let mut numerator = 1e300;
    let mut denominator = 1.0 / base;
    let mut fraction = denominator;
    for term in 1..100_000_u32 {
        let coefficient = -f64::from(term) * (f64::from(term) - a);
        base += 2.0;
        denominator = 1.0 / (coefficient * denominator + base);
        numerator = base + coefficient / numerator;
        let change = numerator * denominator;
        fraction *= change;
        if (change - 1.0).abs() < 1e-15 {
            break;
        }
    }
    1.0 - front * fraction
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: f64, expected: f64) {
        assert!((found / expected - 1.0).abs() < 1e-9, "found {found}, expected {expected}");
    }

    #[test]
    fn the_quantiles_are_those_of_printed_tables() {
        // NIST/SEMATECH e-Handbook, 1.3.6.7, to the digits given there.
        assert!((student(4.0, 0.975) - 2.776).abs() < 5e-4);
        assert!((student(100.0, 0.975) - 1.984).abs() < 5e-4);
        assert!((chi_squared(10.0, 0.975) - 20.483).abs() < 5e-4);
        assert!((chi_squared(10.0, 0.025) - 3.247).abs() < 5e-4);
        assert!((fisher(3.0, 10.0, 0.95) - 3.708).abs() < 5e-4);
    }

    #[test]
    fn t_is_symmetric_and_its_square_is_f() {
        assert_near(student(7.0, 0.025), -student(7.0, 0.975));
        assert_near(student(7.0, 0.975) * student(7.0, 0.975), fisher(1.0, 7.0, 0.95));
        assert_near(student_two_sided(7.0, student(7.0, 0.975)), 0.05);
    }
}
