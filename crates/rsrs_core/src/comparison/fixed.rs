//! A test at a number of runs that was fixed before the first of them.
//!
//! Who looks once, at a number of runs that was written down beforehand, needs fewer of them than who may
//! look after every run. What was written down is in the record of each run.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::comparison::{MOST_RUNS, SIGNIFICANCE, Verdict};
use crate::statistics::beta;
use crate::statistics::interval::Interval;
use crate::statistics::share::Share;

/// What was fixed before the first run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FixedDesign {
    /// Number of runs, in all cells together.
    pub runs: u64,
    /// By how much real robots may mill less often than simulated ones, a share from 0 to 0.5.
    pub margin: f64,
}

/// One of the runs that were fixed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixedRun {
    /// Which one of them, from 1.
    pub number: u64,
    /// Number of runs, in all cells together.
    pub runs: u64,
    /// By how much real robots may mill less often than simulated ones.
    pub margin: f64,
}

impl FixedRun {
    /// What was fixed.
    pub fn design(self) -> FixedDesign {
        let Self { runs, margin, .. } = self;
        FixedDesign { runs, margin }
    }
}

/// The part of the error that is given to what is not known of simulated robots.
const OF_SIMULATED: f64 = 0.01;
/// What is left for the real runs.
const OF_REAL: f64 = SIGNIFICANCE - OF_SIMULATED;

/// A cell of the design.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedCell {
    /// Real runs in it; at least one.
    pub runs: u64,
    /// Its simulated runs.
    pub simulated: Share,
}

impl FixedCell {
    /// Whether simulated robots surely do what is wanted more often than the margin.
    pub fn claims(&self, margin: f64) -> bool {
        self.simulated.interval().low > margin
    }
}

/// Which numbers of mills decide.
///
/// Each verdict is wrong with a probability of at most [`SIGNIFICANCE`], whatever robots do: 0.01 of it for
/// bounds of what simulated robots do (Clopper and Pearson, shared among the cells), and 0.04 for the real
/// runs, which are held against these bounds.
///
/// # Source
///
/// For `B_r >= B_s - margin` on average, W. Hoeffding, "On the distribution of the number of successes in
/// independent trials", 1956: above its mean such a number is at most as widely spread as a binomial one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FixedTest {
    /// Runs in cells that make a claim.
    pub n_claimed: u64,
    /// The claim is supported by so many mills or more among those; `None` if by no number.
    pub supported_from: Option<u64>,
    /// It is violated by so many mills or fewer among all runs; `None` if by no number.
    pub violated_up_to: Option<u64>,
}

impl FixedTest {
    /// The test of a design, with a margin from 0 to less than 1.
    pub fn new(cells: &[FixedCell], margin: f64) -> Self {
        let tail = OF_SIMULATED / cells.len().max(1) as f64;
        let bounds =
            |cell: &FixedCell| Interval::with_tails(cell.simulated.hits, cell.simulated.n, tail);
        let claimed: Vec<&FixedCell> = cells.iter().filter(|cell| cell.claims(margin)).collect();
        let n_claimed = claimed.iter().map(|cell| cell.runs).sum();
        let short = |cell: &&FixedCell| cell.runs as f64 * (bounds(cell).high - margin).max(0.0);
        let mean = claimed.iter().map(short).sum::<f64>() / (n_claimed as f64).max(1.0);
        let supported_from =
            (1..=n_claimed).find(|mills| at_least(*mills, n_claimed, mean) <= OF_REAL);
        let least = sums(cells.iter().map(|cell| (cell.runs, bounds(cell).low)));
        let mut up_to = 0.0;
        let is_rare = |probability: &&f64| {
            up_to += **probability;
            up_to <= OF_REAL
        };
        let n_rare = least.iter().take_while(is_rare).count() as u64;
        Self { n_claimed, supported_from, violated_up_to: n_rare.checked_sub(1) }
    }

    /// What follows, once all runs are made, from the least number of mills that there may be in
    /// cells that make a claim, and the greatest that there may be in all cells.
    pub fn verdict(&self, mills: u64, all_mills: u64) -> Verdict {
        if self.violated_up_to.is_some_and(|most| all_mills <= most) {
            Verdict::Violated
        } else if self.supported_from.is_some_and(|least| mills >= least) {
            Verdict::Supported
        } else if self.n_claimed == 0 {
            Verdict::NoClaim
        } else {
            Verdict::Undecided
        }
    }
}

/// The probability of so many hits or more in `n` runs of the same chance; at least one.
fn at_least(hits: u64, n: u64, chance: f64) -> f64 {
    beta::distribution(hits as f64, (n - hits + 1) as f64, chance)
}

/// How probable each number of hits is, from none on.
fn sums(runs: impl Iterator<Item = (u64, f64)>) -> Vec<f64> {
    let each = runs.flat_map(|(n, chance)| (0..n).map(move |_| chance));
    each.fold(vec![1.0], |before, chance| {
        let mut after = vec![0.0; before.len() + 1];
        for (hits, probability) in before.iter().enumerate() {
            after[hits] += probability * (1.0 - chance);
            after[hits + 1] += probability * chance;
        }
        after
    })
}

/// A cell in which real runs are planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedCell {
    /// Simulated runs that the real ones will be compared with.
    pub simulated: Share,
    /// The share of real runs that is expected to end as wanted.
    pub expected: f64,
}

/// How many runs, and what they decide.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FixedPlan {
    /// Runs of each cell, in their order.
    #[serde(skip)]
    pub runs: Vec<u64>,
    /// Which numbers of mills decide.
    #[serde(flatten)]
    pub test: FixedTest,
    /// The probability that they decide.
    pub decided: f64,
    /// That the verdict is `supported`.
    pub supported: f64,
    /// That it is `violated`.
    pub violated: f64,
}

/// Plans the least number of runs, shared out evenly among the cells, that decides with the wanted
/// probability: that of [`MOST_RUNS`] where no fewer do, which says how surely they decide.
pub fn plan(cells: &[PlannedCell], margin: f64, wanted: f64) -> FixedPlan {
    let first = (cells.len() as u64).max(1);
    let plans = (first..=MOST_RUNS.max(first)).map(|runs| plan_of(cells, runs, margin));
    let mut last = None;
    for plan in plans {
        let is_enough = plan.decided >= wanted;
        last = Some(plan);
        if is_enough {
            break;
        }
    }
    last.expect("there is a number of runs")
}

fn plan_of(cells: &[PlannedCell], runs: u64, margin: f64) -> FixedPlan {
    let n_cells = cells.len() as u64;
    let of_cell = |position: u64| (runs + n_cells - 1 - position) / n_cells;
    let planned: Vec<FixedCell> = (0..)
        .zip(cells)
        .map(|(position, cell)| FixedCell { runs: of_cell(position), simulated: cell.simulated })
        .collect();
    let test = FixedTest::new(&planned, margin);
    let drawn = |is_in: &dyn Fn(&FixedCell) -> bool| {
        let both = planned.iter().zip(cells).filter(|(cell, _)| is_in(cell));
        sums(both.map(|(cell, planned)| (cell.runs, planned.expected)))
    };
    let (claimed, all) = (drawn(&|cell| cell.claims(margin)), drawn(&|_| true));
    let supported =
        test.supported_from.map_or(0.0, |least| claimed.iter().skip(index(least)).sum());
    let violated = test.violated_up_to.map_or(0.0, |most| all.iter().take(index(most) + 1).sum());
    FixedPlan {
        runs: planned.iter().map(|cell| cell.runs).collect(),
        test,
        decided: supported + violated,
        supported,
        violated,
    }
}

fn index(number: u64) -> usize {
    usize::try_from(number).expect("runs that one laboratory makes")
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: Share = Share { hits: 880, n: 1000 };

    #[test]
    fn the_numbers_are_those_of_scipy() {
        // scipy 1.17: beta.ppf of 0.99 and 0.01 for 880 of 1000, then binom.sf and binom.cdf.
        let test = FixedTest::new(&[FixedCell { runs: 40, simulated: KNOWN }], 0.2);

        assert_eq!(
            test,
            FixedTest { n_claimed: 40, supported_from: Some(34), violated_up_to: Some(29) }
        );
    }

    #[test]
    fn either_verdict_is_wrong_in_at_most_5_of_100_designs_whatever_robots_do() {
        for (b_s, n_simulated) in [(0.5, 100), (0.88, 100), (0.88, 1000), (0.97, 400)] {
            let of_simulated = sums([(n_simulated, b_s)].into_iter());
            for (runs, margin) in [(9, 0.3), (24, 0.25), (60, 0.1)] {
                // The worst robots that violate each claim.
                for (b_r, wrong) in [(b_s - margin, Verdict::Supported), (b_s, Verdict::Violated)] {
                    let of_real = sums([(runs, b_r)].into_iter());
                    let mut error = 0.0;
                    for (hits, probability) in
                        (0..).zip(&of_simulated).filter(|(_, it)| **it > 1e-9)
                    {
                        let simulated = Share { hits, n: n_simulated };
                        let test = FixedTest::new(&[FixedCell { runs, simulated }], margin);
                        let errs = |mills: &u64| test.verdict(*mills, *mills) == wrong;
                        let of_mills = (0..).zip(&of_real).filter(|(mills, _)| errs(mills));
                        error += probability * of_mills.map(|(_, it)| it).sum::<f64>();
                    }
                    assert!(error <= SIGNIFICANCE, "{b_s} {n_simulated} {runs} {margin}: {error}");
                    assert!(error > 0.0, "a test that never decides shows nothing");
                }
            }
        }
    }

    #[test]
    fn nothing_is_supported_where_nothing_is_claimed_and_cells_are_taken_together() {
        let rare = FixedCell { runs: 20, simulated: Share { hits: 0, n: 100 } };
        let often = FixedCell { runs: 20, simulated: KNOWN };

        assert_eq!(FixedTest::new(&[rare], 0.1).verdict(20, 20), Verdict::NoClaim);
        let both = FixedTest::new(&[rare, often], 0.25);
        assert_eq!(both.n_claimed, 20);
        assert_eq!(both.verdict(20, 40), Verdict::Supported);
        assert_eq!(both.verdict(2, 2), Verdict::Violated);
        assert_eq!(both.verdict(15, 15), Verdict::Undecided);
    }

    #[test]
    fn fewer_runs_decide_than_if_one_may_look_after_each() {
        let simulated = Share { hits: 870, n: 1000 };
        let fixed = plan(&[PlannedCell { simulated, expected: 0.87 }], 0.25, 0.8);

        assert!(fixed.decided >= 0.8, "{fixed:?}");
        assert!(fixed.runs[0] < 25, "{fixed:?}");
        let never =
            plan(&[PlannedCell { simulated: Share { hits: 0, n: 9 }, expected: 0.5 }], 0.1, 0.8);
        assert_eq!(never.runs, [MOST_RUNS]);
    }
}
