//! How probable it is that one share is at least another, after so many runs of each.

use crate::statistics::beta;
use crate::statistics::share::Share;

/// `P(B_r >= B_s - margin)` after both were counted, with uniform priors and a margin from 0 to 1;
/// accurate to 1e-9.
pub fn probability_at_least(real: Share, simulated: Share, margin: f64) -> f64 {
    let shape = |share: Share| (share.hits as f64 + 1.0, (share.n - share.hits) as f64 + 1.0);
    let ((real_a, real_b), (a, b)) = (shape(real), shape(simulated));
    // Outside of these bounds there is less than 2e-13 of the simulated share.
    let (low, high) = (beta::quantile(a, b, 1e-13), beta::quantile(a, b, 1.0 - 1e-13));
    let integrand = |share: f64| {
        beta::density(a, b, share) * (1.0 - beta::distribution(real_a, real_b, share - margin))
    };
    // The integrand has a kink where the real share may be anything.
    let kink = margin.clamp(low, high);
    let total: f64 = [(low, kink), (kink, high)]
        .into_iter()
        .flat_map(|(from, to)| panels(from, to))
        .map(|(from, to)| adaptive(&integrand, (from, to), DEPTH))
        .sum();
    total.clamp(0.0, 1.0)
}

/// Panels in which either side of the kink is integrated, so that no peak falls between points.
const PANELS: u32 = 16;

/// Times a panel is halved at most.
const DEPTH: u32 = 30;

/// Error that one panel may have.
const TOLERANCE: f64 = 1e-12;

fn panels(from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> {
    let edge = move |panel: u32| from + (to - from) * f64::from(panel) / f64::from(PANELS);
    (0..PANELS).map(move |panel| (edge(panel), edge(panel + 1)))
}

/// Halves a panel until the halves agree with the whole.
fn adaptive(integrand: &impl Fn(f64) -> f64, (from, to): (f64, f64), depth: u32) -> f64 {
    let middle = from + (to - from) / 2.0;
    let whole = gauss(integrand, from, to);
    let halves = gauss(integrand, from, middle) + gauss(integrand, middle, to);
    if depth == 0 || (whole - halves).abs() <= TOLERANCE {
        return halves;
    }
    adaptive(integrand, (from, middle), depth - 1) + adaptive(integrand, (middle, to), depth - 1)
}

/// Nodes and weights of Gauss-Legendre quadrature with five points on [-1, 1].
const GAUSS: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

fn gauss(integrand: &impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let (middle, half) = (from + (to - from) / 2.0, (to - from) / 2.0);
    GAUSS.iter().map(|(node, weight)| weight * integrand(middle + half * node)).sum::<f64>() * half
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_posterior_is_that_of_exact_integration() {
        // mpmath 1.3 with 40 digits: quad of the density of B_s times 1 - I_{s-0.1} of B_r.
        for (real_hits, real_n, hits, n, expected) in [
            (3, 3, 868, 1000, 0.653_031_747_682_258),
            (0, 3, 868, 1000, 0.002_971_382_496_671_86),
            (1, 3, 868, 1000, 0.041_831_660_842_079_5),
            (10, 10, 868, 1000, 0.945_169_269_242_977),
            (9, 10, 12, 16, 0.922_889_143_661_98),
            (0, 5, 0, 16, 0.959_937_781_391_891),
            (0, 0, 0, 0, 0.595),
            (980, 1000, 990, 1000, 1.0),
        ] {
            let real = Share { hits: real_hits, n: real_n };

            let found = probability_at_least(real, Share { hits, n }, 0.1);

            assert!((found - expected).abs() < 1e-9, "{real:?} {hits}/{n}: {found} {expected}");
        }
    }

    #[test]
    fn many_real_runs_against_few_simulated_ones_are_not_missed() {
        let real = Share { hits: 90_000, n: 100_000 };

        let found = probability_at_least(real, Share { hits: 8, n: 8 }, 0.1);

        // The real share is 0.9 for certain, and B_s - 0.1 cannot exceed it by more than its spread.
        assert!(found > 0.97, "{found}");
    }
}
