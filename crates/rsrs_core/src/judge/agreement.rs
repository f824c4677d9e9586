//! How far two judges of the same runs agree, beyond what chance explains.

use std::collections::BTreeSet;

use serde::Serialize;

use crate::judge::phase::Phase;
use crate::statistics::interval::Interval;

/// How far two judges agree on the runs that both have labelled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Agreement {
    /// Runs that both have labelled.
    pub n: u64,
    /// Runs on whose phase they agree.
    pub n_same: u64,
    /// Share of runs on which they agree, from 0 to 1.
    pub share: f64,
    /// The exact 95 % interval of that share.
    pub share_interval: Interval,
    /// The share on which they would agree if each spread its own labels over the runs at random.
    pub share_by_chance: f64,
    /// Cohen's kappa: 1 for judges who always agree, 0 for as often as by chance, negative for less;
    /// `None` if both gave all runs one and the same label, where agreement proves nothing.
    pub kappa: Option<f64>,
    /// Its 95 % interval, from -1 to 1.
    pub kappa_interval: Option<Interval>,
}

/// The quantile of the normal distribution that leaves 2.5 % above it.
const QUANTILE: f64 = 1.959_963_984_540_054;

impl Agreement {
    /// Holds the labels that two judges gave each run against each other; `None` without runs.
    ///
    /// From `2k²` runs on, with `k` phases in use, the interval of kappa is that of large samples.
    /// For fewer, and where the judges agree on all runs or on none, that one can be far too short,
    /// even of no width at all; there, it is the exact interval of the share, taken through kappa's
    /// definition with agreement by chance as observed.
    ///
    /// # Source
    ///
    /// J. Cohen, "A coefficient of agreement for nominal scales", Educational and Psychological
    /// Measurement 20, 1960; its standard error by J. L. Fleiss, J. Cohen, B. S. Everitt,
    /// "Large sample standard errors of kappa and weighted kappa", Psychological Bulletin 72, 1969,
    /// as in statsmodels' `cohens_kappa`. `2k²`: D. V. Cicchetti, "Testing the normal approximation
    /// and minimal sample size requirements of weighted kappa when the number of categories is
    /// large", Applied Psychological Measurement 5, 1981.
    ///
    /// # Example
    ///
    /// Twenty runs with the same label prove nothing: a judge that never looks gives the same.
    ///
    /// ```
    /// use rsrs_core::judge::agreement::Agreement;
    /// use rsrs_core::judge::phase::Phase;
    ///
    /// let (mill, apart) = (Phase::STABLE_MILLING, Phase::DISPERSION);
    /// let blind = Agreement::new(&[(mill, mill); 20]).expect("there are runs");
    /// assert_eq!((blind.share, blind.kappa), (1.0, None));
    ///
    /// let mut runs = [(mill, mill); 20];
    /// runs[..10].fill((apart, apart));
    /// let agreed = Agreement::new(&runs).expect("there are runs");
    /// assert_eq!(agreed.kappa, Some(1.0));
    /// assert!(agreed.kappa_interval.expect("kappa has one").low < 0.7);
    /// ```
    pub fn new(labels: &[(Phase, Phase)]) -> Option<Self> {
        if labels.is_empty() {
            return None;
        }
        let table = Table::new(labels);
        let n = labels.len() as u64;
        let n_same = labels.iter().filter(|(one, other)| one == other).count() as u64;
        let share = n_same as f64 / n as f64;
        let share_interval = Interval::clopper_pearson(n_same, n);
        let by_chance = table.by_chance();
        let is_blind = table.is_of_one_phase();
        let kappa_of = |share: f64| (share - by_chance) / (1.0 - by_chance);
        let kappa = (!is_blind).then(|| kappa_of(share));
        let kappa_interval = kappa.map(|kappa| {
            let (low, high) = if n_same == 0 || n_same == n || n < table.large_sample() {
                (kappa_of(share_interval.low), kappa_of(share_interval.high))
            } else {
                let width = QUANTILE * table.variance(kappa, n).sqrt();
                (kappa - width, kappa + width)
            };
            Interval { low: low.clamp(-1.0, 1.0), high: high.clamp(-1.0, 1.0) }
        });
        Some(Self {
            n,
            n_same,
            share,
            share_interval,
            share_by_chance: by_chance,
            kappa,
            kappa_interval,
        })
    }
}

/// Shares of runs by the label of the one judge (rows) and of the other (columns).
struct Table {
    /// Shape `[n_phases][n_phases]`, of the phases in use.
    cells: Vec<Vec<f64>>,
    rows: Vec<f64>,
    columns: Vec<f64>,
}

impl Table {
    fn new(labels: &[(Phase, Phase)]) -> Self {
        let phases: BTreeSet<Phase> =
            labels.iter().flat_map(|(one, other)| [*one, *other]).collect();
        let n = labels.len() as f64;
        let share = |is: &dyn Fn(&(Phase, Phase)) -> bool| {
            labels.iter().filter(|label| is(label)).count() as f64 / n
        };
        let row =
            |one: Phase| phases.iter().map(|other| share(&|it| *it == (one, *other))).collect();
        Self {
            cells: phases.iter().map(|phase| row(*phase)).collect(),
            rows: phases.iter().map(|phase| share(&|(one, _)| one == phase)).collect(),
            columns: phases.iter().map(|phase| share(&|(_, other)| other == phase)).collect(),
        }
    }

    /// Whether both judges have used one phase only, and the same one.
    fn is_of_one_phase(&self) -> bool {
        (0..self.rows.len()).any(|phase| self.cells[phase][phase].to_bits() == 1.0_f64.to_bits())
    }

    /// From how many runs on the normal approximation holds.
    fn large_sample(&self) -> u64 {
        let n_used = self.rows.len() as u64;
        2 * n_used * n_used
    }

    fn by_chance(&self) -> f64 {
        self.rows.iter().zip(&self.columns).map(|(row, column)| row * column).sum()
    }

    /// The variance of kappa over samples of so many runs.
    fn variance(&self, kappa: f64, n: u64) -> f64 {
        let by_chance = self.by_chance();
        let missed = 1.0 - kappa;
        let (mut agreed, mut disagreed) = (0.0, 0.0);
        for row in 0..self.rows.len() {
            for column in 0..self.rows.len() {
                let share = self.cells[row][column];
                if row == column {
                    let square = 1.0 - (self.rows[row] + self.columns[row]) * missed;
                    agreed += share * square * square;
                } else {
                    let sum = self.columns[row] + self.rows[column];
                    disagreed += share * sum * sum;
                }
            }
        }
        let centre = kappa - by_chance * missed;
        let numerator = agreed + missed * missed * disagreed - centre * centre;
        numerator / ((1.0 - by_chance) * (1.0 - by_chance) * n as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STABLE: Phase = Phase::STABLE_MILLING;
    const SEMI_STABLE: Phase = Phase::SEMI_STABLE_MILLING;
    const DISPERSED: Phase = Phase::DISPERSION;
    const COLLIDING: Phase = Phase::COLLIDING_UNSTABLE;

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-12, "found {found}, expected {expected}");
    }

    #[test]
    fn few_runs_that_all_agree_are_no_certainty() {
        let few = [(STABLE, STABLE), (DISPERSED, DISPERSED)];

        let interval = Agreement::new(&few).unwrap().kappa_interval.unwrap();

        assert!(interval.low < 0.0 && interval.high.to_bits() == 1.0_f64.to_bits(), "{interval:?}");
    }

    #[test]
    fn judges_who_each_use_one_phase_but_not_the_same_differ_as_by_chance() {
        let agreement = Agreement::new(&[(SEMI_STABLE, COLLIDING); 5]).unwrap();

        near(agreement.kappa.unwrap(), 0.0);
        assert_eq!((agreement.share, agreement.share_by_chance), (0.0, 0.0));
    }

    #[test]
    fn without_runs_there_is_no_agreement() {
        assert_eq!(Agreement::new(&[]), None);
    }
}
