//! The beta distribution, of which the exact statistics of shares are made.

/// `I_x(a, b)`: the probability that a beta-distributed number with the positive shape parameters
/// `a` and `b` is at most `x`, from 0 to 1; beyond, the ends count.
///
/// # Source
///
/// NIST Digital Library of Mathematical Functions, 8.17.22, by Lentz's method.
pub fn distribution(a: f64, b: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    if x >= 1.0 {
        return 1.0;
    }
    // The continued fraction converges fast on the lower side of the mean only.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - lower_tail(b, a, 1.0 - x);
    }
    lower_tail(a, b, x)
}

/// The density at `x`, strictly between 0 and 1.
pub fn density(a: f64, b: f64, x: f64) -> f64 {
    libm::exp((a - 1.0) * libm::log(x) + (b - 1.0) * libm::log1p(-x) - log_beta(a, b))
}

/// The number that is not exceeded with a probability from 0 to 1.
pub fn quantile(a: f64, b: f64, probability: f64) -> f64 {
    bisected([0.0, 1.0], |number| distribution(a, b, number) < probability)
}

/// Where what holds at the low end ceases to hold.
pub fn bisected([mut low, mut high]: [f64; 2], holds: impl Fn(f64) -> bool) -> f64 {
    loop {
        let middle = low + (high - low) / 2.0;
        if middle <= low || middle >= high {
            return middle;
        }
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// The logarithm of the beta function.
pub fn log_beta(a: f64, b: f64) -> f64 {
    libm::lgamma(a) + libm::lgamma(b) - libm::lgamma(a + b)
}

/// Terms of the continued fraction after which something is wrong; it needs about the square root
/// of the parameters.
const MAX_TERMS: u32 = 100_000;

fn lower_tail(a: f64, b: f64, x: f64) -> f64 {
    let front = libm::exp(a * libm::log(x) + b * libm::log1p(-x) - log_beta(a, b)) / a;
    let not_zero = |number: f64| if number.abs() < 1e-300 { 1e-300 } else { number };
    let mut numerator = 1.0;
    let mut denominator = 1.0 / not_zero(1.0 - (a + b) * x / (a + 1.0));
    let mut fraction = denominator;
    for term in 1..MAX_TERMS {
        let m = f64::from(term);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut change = 1.0;
        for coefficient in [even, odd] {
            denominator = 1.0 / not_zero(1.0 + coefficient * denominator);
            numerator = not_zero(1.0 + coefficient / numerator);
            change = numerator * denominator;
            fraction *= change;
        }
        if (change - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * fraction
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: f64, expected: f64) {
        assert!((found / expected - 1.0).abs() < 1e-10, "found {found}, expected {expected}");
    }

    #[test]
    fn the_distribution_is_that_of_scipy() {
        // scipy 1.17: scipy.special.betainc(a, b, x)
        for (a, b, x, expected) in [
            (1.0, 1.0, 0.3, 0.3),
            (0.5, 3.0, 0.2, 0.733_430_296_619_931),
            (16.0, 1.0, 0.9, 0.185_302_018_885_184_16),
            (3.0, 17.0, 0.4, 0.994_536_074_331_239_3),
            (871.0, 131.0, 0.86, 0.190_602_712_055_193_63),
            (871.0, 131.0, 0.8, 3.559_434_658_305_051_6e-9),
            (5000.0, 5000.0, 0.49, 0.022_742_032_324_574_61),
        ] {
            assert_near(distribution(a, b, x), expected);
        }
    }

    #[test]
    fn the_quantile_is_the_inverse_of_the_distribution() {
        for (a, b) in [(1.0, 1.0), (0.5, 3.0), (16.0, 1.0), (871.0, 131.0)] {
            for probability in [1e-6, 0.025, 0.5, 0.975] {
                assert_near(distribution(a, b, quantile(a, b, probability)), probability);
            }
        }
    }
}
