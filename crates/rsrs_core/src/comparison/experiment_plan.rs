//! How many real runs decide a comparison, asked before the first of them.
//!
//! Real robots are taken to mill as often as simulated ones that are as measured, as far as their runs
//! show: the chance of the next run is that of the posterior after those and all before it in its cell
//! (Pólya's urn), with a uniform prior. Campaigns are drawn, each with a comparison after every run that
//! stops it as soon as it decides, as [`crate::comparison`] allows.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::comparison::{MOST_RUNS, Verdict, decided};
use crate::statistics::e_value::TestedCell;
use crate::statistics::pooled::PooledTest;
use crate::statistics::share::Share;

/// A cell in which real runs are planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedCell {
    /// Simulated runs that the real ones will be compared with.
    pub simulated: Share,
    /// Simulated runs of robots as measured, by which real ones are expected to mill; none where
    /// nothing is known of them.
    pub as_measured: Share,
    /// Real runs that there are.
    pub so_far: Share,
    /// Its part of the error, as for the comparison.
    pub part: f64,
}

/// How many runs, and what they decide.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ExperimentPlan {
    /// The least number of runs in all cells together that decide with the wanted probability; `None`
    /// if [`MOST_RUNS`] do not.
    pub runs: Option<u64>,
    /// What is decided after so many runs, the last entry being that of [`Self::runs`] or, without it,
    /// of [`MOST_RUNS`].
    pub by_runs: Vec<Decided>,
    /// Runs until the decision, on average; undecided campaigns count with all of theirs.
    pub mean_runs: f64,
}

/// Probabilities after a number of runs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Decided {
    /// Runs in all cells together.
    pub runs: u64,
    /// That they have decided.
    pub decided: f64,
    /// That the verdict is `supported`.
    pub supported: f64,
    /// That it is `violated`.
    pub violated: f64,
}

/// Campaigns in several cells that are drawn: probabilities are off by 0.018 at most, in 95 of 100 cases.
pub const CAMPAIGNS: u32 = 2_000;

/// Plans how many further runs in the cell at `index` decide, those of the others being what they are:
/// exactly, and with a comparison after every run. Margin and `wanted` are those of [`plan`].
///
/// # Panics
///
/// If there is no such cell.
pub fn plan_in(cells: &[PlannedCell], index: usize, margin: f64, wanted: f64) -> ExperimentPlan {
    plan_within(MOST_RUNS, (cells, index), margin, wanted)
}

/// The same with so many runs at most, of which there is at least one.
fn plan_within(
    most_runs: u64,
    (cells, index): (&[PlannedCell], usize),
    margin: f64,
    wanted: f64,
) -> ExperimentPlan {
    let cell = cells[index];
    let mut real: Vec<Share> = cells.iter().map(|cell| cell.so_far).collect();
    // The probability that the campaign is undecided and has so many mills among the further runs.
    let mut undecided = vec![1.0];
    let (mut supported, mut violated, mut mean_runs) = (0.0, 0.0, 0.0);
    let mut by_runs: Vec<Decided> = Vec::new();
    let mut deciding = DecidingCounts::default();
    for runs in 1..=most_runs {
        mean_runs += undecided.iter().sum::<f64>();
        let mut after = vec![0.0; undecided.len() + 1];
        for (hits, probability) in undecided.iter().enumerate() {
            let further = Share { hits: hits as u64, n: runs - 1 };
            let mills = next_mills(cell.as_measured, cell.so_far + further);
            after[hits] += probability * (1.0 - mills);
            after[hits + 1] += probability * mills;
        }
        deciding.move_to(runs, |hits| {
            real[index] = cell.so_far + Share { hits, n: runs };
            verdict(cells, &real, margin)
        });
        for (hits, probability) in (0_u64..).zip(&mut after) {
            if hits < deciding.n_violating {
                violated += std::mem::take(probability);
            } else if hits >= deciding.first_supporting {
                supported += std::mem::take(probability);
            }
        }
        undecided = after;
        by_runs.push(Decided { runs, decided: supported + violated, supported, violated });
        if supported + violated >= wanted {
            break;
        }
    }
    let last = by_runs[by_runs.len() - 1];
    let runs = (last.decided >= wanted).then_some(last.runs);
    ExperimentPlan { runs, by_runs, mean_runs }
}

/// Which of some cells decides for itself with the fewest runs, by its position, and its plan; of equals the
/// first. Where [`MOST_RUNS`] decide in none, it is the one in which they do most probably. `None` if there
/// are no cells; margin and `wanted` are those of [`plan`].
pub fn soonest(cells: &[PlannedCell], margin: f64, wanted: f64) -> Option<(usize, ExperimentPlan)> {
    let mut best: Option<(usize, ExperimentPlan)> = None;
    for (index, cell) in cells.iter().enumerate() {
        let fewest = best.as_ref().and_then(|(_, plan)| plan.runs);
        let most_runs = fewest.map_or(MOST_RUNS, |runs| runs - 1);
        if most_runs == 0 {
            break;
        }
        let plan = plan_within(most_runs, (&[*cell], 0), margin, wanted);
        let is_better = best.as_ref().is_none_or(|(_, best)| {
            plan.runs.is_some() || best.runs.is_none() && plan.chance() > best.chance()
        });
        if is_better {
            best = Some((index, plan));
        }
    }
    best
}

impl ExperimentPlan {
    /// The probability that the last of its numbers of runs has decided.
    pub fn chance(&self) -> f64 {
        self.by_runs.last().map_or(0.0, |last| last.decided)
    }
}

/// Which counts of mills decide. More of them never speak against the inequality, and one further run moves
/// a bound by little, so that it is looked for from where it was.
#[derive(Clone, Copy, Debug, Default)]
struct DecidingCounts {
    /// So many, from none on, violate it.
    n_violating: u64,
    /// The first that supports it; one more than there are runs where none does.
    first_supporting: u64,
}

impl DecidingCounts {
    fn move_to(&mut self, runs: u64, mut verdict: impl FnMut(u64) -> Verdict) {
        let end = runs + 1;
        let mut moved = |from: u64, is_before: &dyn Fn(Verdict) -> bool| {
            let mut bound = from.min(end);
            while bound < end && is_before(verdict(bound)) {
                bound += 1;
            }
            while bound > 0 && !is_before(verdict(bound - 1)) {
                bound -= 1;
            }
            bound
        };
        self.n_violating = moved(self.n_violating, &|verdict| verdict == Verdict::Violated);
        self.first_supporting =
            moved(self.first_supporting, &|verdict| verdict != Verdict::Supported);
    }
}

/// Plans how many runs, shared out evenly among the cells one after the other, decide with the
/// probability `wanted`, strictly between 0 and 1. In one cell it is [`plan_in`].
///
/// The margin is that of the comparison, and `uniform` draws independent numbers, evenly distributed
/// from 0 to 1.
///
/// # Panics
///
/// If there are no cells.
pub fn plan(
    cells: &[PlannedCell],
    margin: f64,
    wanted: f64,
    uniform: &mut dyn FnMut() -> f64,
) -> ExperimentPlan {
    assert!(!cells.is_empty(), "runs are planned in at least one cell");
    if cells.len() == 1 {
        return plan_in(cells, 0, margin, wanted);
    }
    let so_far: Vec<Share> = cells.iter().map(|cell| cell.so_far).collect();
    let mut undecided = vec![so_far; CAMPAIGNS as usize];
    let share = |n: u32| f64::from(n) / f64::from(CAMPAIGNS);
    let (mut n_supported, mut n_violated) = (0, 0);
    let mut total_runs = 0;
    let mut by_runs: Vec<Decided> = Vec::new();
    for (runs, index) in (1..=MOST_RUNS).zip((0..cells.len()).cycle()) {
        total_runs += undecided.len();
        // Many campaigns have the same counts.
        let mut verdicts: BTreeMap<Vec<u64>, Verdict> = BTreeMap::new();
        undecided.retain_mut(|campaign| {
            let mills = uniform() < next_mills(cells[index].as_measured, campaign[index]);
            campaign[index] = campaign[index] + Share { hits: u64::from(mills), n: 1 };
            let hits = campaign.iter().map(|real| real.hits).collect();
            let verdict = verdicts.entry(hits).or_insert_with(|| verdict(cells, campaign, margin));
            match verdict {
                Verdict::Undecided | Verdict::NoClaim => return true,
                Verdict::Supported => n_supported += 1,
                Verdict::Violated => n_violated += 1,
            }
            false
        });
        let (supported, violated) = (share(n_supported), share(n_violated));
        by_runs.push(Decided { runs, decided: supported + violated, supported, violated });
        if supported + violated >= wanted {
            break;
        }
    }
    let last = by_runs[by_runs.len() - 1];
    ExperimentPlan {
        runs: (last.decided >= wanted).then_some(last.runs),
        by_runs,
        mean_runs: total_runs as f64 / f64::from(CAMPAIGNS),
    }
}

/// The chance that the next run mills, after those of robots as measured and those of the campaign.
fn next_mills(as_measured: Share, so_far: Share) -> f64 {
    let (hits, n) = (as_measured.hits + so_far.hits, as_measured.n + so_far.n);
    (hits as f64 + 1.0) / (n as f64 + 2.0)
}

/// What so many real runs of each cell decide; undecided where nothing is claimed.
fn verdict(cells: &[PlannedCell], real: &[Share], margin: f64) -> Verdict {
    let tested = cells.iter().zip(real).map(|(cell, real)| TestedCell {
        real: *real,
        simulated: cell.simulated,
        part: cell.part,
    });
    decided(&PooledTest::new(&tested.collect::<Vec<_>>(), margin))
}

#[cfg(test)]
mod tests {
    use rand::rngs::ChaCha8Rng;
    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::comparison::{MARGIN, enough};

    /// A cell that was not run, with hits and runs simulated and as measured.
    fn cell(runs: [(u64, u64); 2]) -> PlannedCell {
        let [simulated, as_measured] = runs.map(|(hits, n)| Share { hits, n });
        PlannedCell { simulated, as_measured, so_far: Share::default(), part: 1.0 }
    }

    /// One in which the robots as measured mill more often.
    fn better() -> PlannedCell {
        cell([(900, 1000), (960, 1000)])
    }

    fn planned(cells: &[PlannedCell], wanted: f64) -> ExperimentPlan {
        let mut generator = ChaCha8Rng::seed_from_u64(7);
        plan(cells, MARGIN, wanted, &mut || generator.random())
    }

    #[test]
    fn robots_that_always_mill_decide_after_as_many_runs_as_a_comparison_asks_for() {
        let cell = cell([(900, 1000), (1_000_000, 1_000_000)]);
        let tested = TestedCell { real: Share::default(), simulated: cell.simulated, part: 1.0 };
        let further = PooledTest::new(&[tested], MARGIN);
        let is_enough = |runs: &u64| further.is_supported_by(*runs, enough());
        let expected = (1..200).find(is_enough);

        let plan = planned(&[cell], 0.9);

        assert_eq!(plan.runs, expected);
        assert!((plan.by_runs.last().unwrap().supported - 1.0).abs() < 1e-3);
    }

    #[test]
    fn robots_that_mill_much_more_rarely_than_those_made_worse_violate_soon() {
        let cell = cell([(950, 1000), (200, 1000)]);

        let plan = planned(&[cell], 0.9);

        let last = plan.by_runs.last().unwrap();
        assert!(plan.runs.unwrap() < 10 && last.violated > 0.85, "{plan:?}");
    }

    #[test]
    fn where_nothing_decides_it_is_reported() {
        // A shortfall of the margin is neither.
        let cell = cell([(90_000, 100_000), (84_000, 100_000)]);

        let plan = planned(&[cell], 0.999);

        assert_eq!(plan.by_runs.len() as u64, plan.runs.unwrap_or(MOST_RUNS));
        assert!(plan.by_runs.windows(2).all(|pair| pair[0].decided <= pair[1].decided));
    }

    #[test]
    fn runs_that_there_are_need_not_be_made_again() {
        let cell = better();
        // As often as is expected of them.
        let later = PlannedCell { so_far: Share { hits: 19, n: 20 }, ..cell };

        let all = planned(&[cell], 0.8).runs.unwrap();
        let further = planned(&[later], 0.8).runs.unwrap();

        assert!(1 < further && further < all, "{further} {all}");
    }

    #[test]
    fn one_cell_is_planned_exactly_as_drawn_campaigns_go() {
        let cell = better();
        let exact = plan_in(&[cell], 0, MARGIN, 0.8);
        let (mut generator, n) = (ChaCha8Rng::seed_from_u64(7), 4000);

        let is_decided = |_: &u32| {
            let mut so_far = Share::default();
            (0..exact.runs.unwrap()).any(|_| {
                let mills = generator.random::<f64>() < next_mills(cell.as_measured, so_far);
                so_far = so_far + Share { hits: u64::from(mills), n: 1 };
                verdict(&[cell], &[so_far], MARGIN) != Verdict::Undecided
            })
        };
        let drawn = (0..n).filter(is_decided).count() as f64 / f64::from(n);

        let decided = exact.by_runs.last().unwrap().decided;
        // Four standard deviations of the share of 4000 campaigns.
        assert!((drawn - decided).abs() < 0.026, "{drawn} {decided}");
    }

    #[test]
    fn the_cell_that_decides_soonest_is_found_without_planning_the_others_to_their_end() {
        let slow = cell([(900, 1000), (880, 1000)]);
        let often = cell([(990, 1000), (990, 1000)]);
        let runs = |cell| plan_in(&[cell], 0, MARGIN, 0.8).runs.unwrap_or(u64::MAX);
        let all = [slow, often, better()].map(runs);
        assert!(all[0] > all[1] && all[1] > all[2], "{all:?}");

        for cells in [[slow, better(), often], [better(), slow, often]] {
            let (index, plan) = soonest(&cells, MARGIN, 0.8).unwrap();

            assert_eq!((cells[index], plan.runs), (better(), Some(all[2])));
        }
        let first = soonest(&[better(), better()], MARGIN, 0.8).unwrap().0;
        assert_eq!(first, 0, "of equals the first");
        assert_eq!(soonest(&[], MARGIN, 0.8), None);
    }

    #[test]
    fn several_cells_take_turns_and_are_judged_together() {
        let cell = better();

        let one = planned(&[cell], 0.8).runs.unwrap();
        let third = PlannedCell { part: 1.0 / 3.0, ..cell };
        let three = planned(&[third; 3], 0.8).runs.unwrap();

        // The same robots in three cells: the pooled claim takes about as many runs.
        assert!(three.abs_diff(one) <= one / 4 + 1, "{one} {three}");
    }
}
