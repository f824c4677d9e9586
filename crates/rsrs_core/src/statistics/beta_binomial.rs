//! Shares that differ from group to group, by more than chance.

use crate::statistics::beta;
use crate::statistics::share::Share;

/// How a share is distributed over groups of runs, freed of the chance in each group's runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GroupedShare {
    /// Mean of the groups.
    pub mean: f64,
    /// Standard deviation between groups; 0 if they differ by no more than chance.
    pub sd: f64,
}

impl GroupedShare {
    /// Estimates it by moments, of groups of any sizes that are not 0.
    ///
    /// # Source
    ///
    /// J. C. Kleinman, *Proportions with extraneous variance: single and independent samples*, Journal of the American
    /// Statistical Association 68:46-54 (1973), with weights that are the sizes.
    pub fn new(groups: &[Share]) -> Self {
        let n: f64 = groups.iter().map(|group| group.n as f64).sum();
        let hits: u64 = groups.iter().map(|group| group.hits).sum();
        let mean = hits as f64 / n;
        let spread: f64 =
            groups.iter().map(|group| group.n as f64 * (group.value() - mean).powi(2)).sum();
        let squares: f64 = groups.iter().map(|group| (group.n as f64).powi(2)).sum();
        let free = groups.len() as f64 - 1.0;
        // The expectation of `spread` is binomial * (free * (1 - rho) + rho * (n - squares / n)).
        let binomial = mean * (1.0 - mean);
        let rho = (spread / binomial - free) / (n - squares / n - free);
        let sd = libm::sqrt((rho * binomial).max(0.0));
        Self { mean, sd: if sd.is_finite() { sd } else { 0.0 } }
    }

    /// The share that so many of the groups do not exceed, from 0 to 1, if groups are distributed as a beta
    /// distribution.
    pub fn quantile(self, probability: f64) -> f64 {
        let Self { mean, sd } = self;
        let weight = mean * (1.0 - mean) / (sd * sd) - 1.0;
        if sd == 0.0 || weight <= 0.0 {
            return mean;
        }
        beta::quantile(mean * weight, (1.0 - mean) * weight, probability)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::digest::mix;

    /// An even number from 0 to 1, the same for the same counter.
    fn even(counter: u64) -> f64 {
        (mix(counter) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Groups of `runs` whose shares are drawn from a beta distribution.
    fn drawn((a, b): (f64, f64), n_groups: u64, runs: u64) -> Vec<Share> {
        let group = |number: u64| {
            let share = beta::quantile(a, b, even(number));
            let hits = (0..runs).filter(|run| even((number << 20) + 77 + run) < share).count();
            Share { hits: hits as u64, n: runs }
        };
        (0..n_groups).map(group).collect()
    }

    #[test]
    fn the_distribution_that_groups_are_drawn_from_is_found_whatever_their_runs() {
        let (a, b) = (6.0, 2.0);
        let sd = libm::sqrt(a * b / ((a + b) * (a + b) * (a + b + 1.0)));
        for runs in [4, 8, 50] {
            let found = GroupedShare::new(&drawn((a, b), 4_000, runs));

            assert!((found.mean - 0.75).abs() < 0.015, "{found:?}");
            assert!((found.sd - sd).abs() < 0.015, "{found:?} {sd}");
            assert!((found.quantile(0.1) - beta::quantile(a, b, 0.1)).abs() < 0.02, "{found:?}");
        }
    }

    #[test]
    fn groups_that_differ_by_chance_alone_have_one_share() {
        let found = GroupedShare::new(&drawn((3e6, 1e6), 4_000, 8));

        assert!(found.sd < 0.03 && found.quantile(0.1) > 0.70, "{found:?}");
        for hits in [0, 8] {
            let same = GroupedShare::new(&[Share { hits, n: 8 }; 20]);
            let share = hits as f64 / 8.0;
            assert_eq!((same.mean, same.sd, same.quantile(0.1)), (share, 0.0, share));
        }
    }
}
