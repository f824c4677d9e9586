//! How often a robot mills in its best setting, and whether fresh runs confirm it.

use rsrs_core::conditions::{Conditions, Settings};
use rsrs_core::diagram::PhaseCounts;
use rsrs_core::diagram::axis::{Axis, Cell};
use rsrs_core::robot::harsher::{Harsher, HarsherFactors};
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::statistics::interval::Interval;
use rsrs_core::statistics::share::Share;
use rsrs_sim::sweep::{Runs, Swept, check, confirmation_seed, sweep};
use serde::Serialize;

use super::grid::Grid;
use super::settings::{first_of_each, with_settings};
use crate::error::in_one_line;
use crate::execution::Execution;

pub use super::settings::promising;

/// Other values on some capabilities and on the limits, which are those of speed and turning rate.
pub type Changes = Vec<(Axis, f64)>;

/// Looks for the setting in which a robot mills most often.
#[derive(Clone, Copy)]
pub struct Search<'a> {
    /// The robot.
    pub measured: &'a RobotProfile,
    /// How it is made worse.
    pub harsher: Harsher,
    /// In which settings.
    pub grid: &'a Grid,
    /// The share of mills that is wanted.
    pub wanted: f64,
    /// Fresh runs that confirm an answer, in each world.
    pub confirm: u64,
    /// On how many threads, watched by whom.
    pub execution: Execution<'a>,
}

/// Which robots are simulated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Robots {
    /// Made worse.
    Harsher,
    /// As measured.
    AsMeasured,
}

/// A setting, and how often robots mill in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried {
    /// The setting.
    pub cell: Cell,
    /// Runs that milled, of all.
    pub share: Share,
}

/// A setting that fresh runs confirm.
#[derive(Clone, Debug, PartialEq)]
pub struct Confirmed {
    /// The setting.
    pub cell: Cell,
    /// Share of mills, in the world in which they are rarer.
    pub b_s: f64,
    /// Its lower bound; with several attempts, however many, all of them hold together at 95 %.
    pub b_s_low: f64,
    /// Fresh runs in each world.
    pub n_replicates: u64,
}

/// How often robots mill as measured, in their best setting.
#[derive(Clone, Debug, Serialize)]
pub struct AsMeasured {
    /// The setting.
    pub cell: Cell,
    /// Share of mills.
    pub b_s: f64,
    /// Its lower bound, at 95 %.
    pub b_s_low: f64,
}

/// A round of successive halving: the best cells of the round before are run more often.
#[derive(Clone, Copy, Debug)]
struct HalvingRound {
    /// Cells that are left.
    n_cells: usize,
    /// Runs of each of them.
    replicates: u64,
}

const fn round(n_cells: usize, replicates: u64) -> HalvingRound {
    HalvingRound { n_cells, replicates }
}

/// All settings.
const WIDE: &[HalvingRound] = &[round(usize::MAX, 4), round(40, 12), round(12, 24), round(4, 100)];
/// Settings that were good for some robot or other.
const PROMISING: &[HalvingRound] = &[round(usize::MAX, 8), round(10, 24), round(4, 100)];
/// Settings that were good for nearly the same robot.
const NARROW: &[HalvingRound] = &[round(usize::MAX, 12), round(5, 40), round(2, 120)];
/// After so many rounds it is seen whether more are worth it.
const FIRST_LOOK: usize = 2;
/// A share that is so much below what is wanted then is not looked at more closely.
const FAR: f64 = 0.3;
/// What a share seen in some hundred runs must exceed what is wanted by, so that fresh runs confirm it.
const MARGIN: f64 = 0.035;
/// Settings of each end that are tried between them.
const KEPT: usize = 8;
/// Values that are confirmed until one holds.
pub const ATTEMPTS: u32 = 4;
/// Probability that any of the lower bounds of all attempts is above the truth.
const TAIL: f64 = 0.025;

impl Search<'_> {
    /// Tries all settings with a changed robot.
    ///
    /// # Returns
    ///
    /// Settings, the best first; empty if the changed robot is none, or fits in none of them.
    ///
    /// # Errors
    ///
    /// If the runs are called off or fail.
    pub fn best(&self, changes: &Changes, doing: &str) -> anyhow::Result<Vec<Tried>> {
        let cells = with_settings(&self.grid.cells, changes);
        self.tried((changes, Robots::Harsher), &cells, (WIDE, doing))
    }

    /// Tries promising settings with a changed robot.
    ///
    /// # Arguments
    ///
    /// * `cells` — of [`promising`].
    ///
    /// # Errors
    ///
    /// As [`Search::best`].
    pub fn best_of(
        &self,
        changes: &Changes,
        cells: &[Cell],
        doing: &str,
    ) -> anyhow::Result<Vec<Tried>> {
        let cells = with_settings(cells, changes);
        self.tried((changes, Robots::Harsher), &cells, (PROMISING, doing))
    }

    /// Tries the settings that were best for nearly the same robot.
    ///
    /// # Errors
    ///
    /// As [`Search::best`].
    pub fn again(
        &self,
        changes: &Changes,
        tried: &[Tried],
        doing: &str,
    ) -> anyhow::Result<Vec<Tried>> {
        let cells: Vec<Cell> =
            tried.iter().take(2 * KEPT).map(|tried| tried.cell.clone()).collect();
        self.tried((changes, Robots::Harsher), &cells, (NARROW, doing))
    }

    /// How often the robots mill as measured, in their best setting, confirmed on fresh seeds.
    ///
    /// # Returns
    ///
    /// `None` if the robots are not made worse, or there is no setting.
    ///
    /// # Errors
    ///
    /// As [`Search::best`].
    pub fn confirmed_as_measured(&self) -> anyhow::Result<Option<AsMeasured>> {
        let none = Changes::new();
        if self.harsher.factors(self.measured) == HarsherFactors::NONE {
            return Ok(None);
        }
        let rounds = (WIDE, "as measured");
        let tried = self.tried((&none, Robots::AsMeasured), &self.grid.cells, rounds)?;
        let Some(best) = tried.first() else { return Ok(None) };
        let conditions = self.conditions((&none, Robots::AsMeasured), &best.cell)?;
        let seed = confirmation_seed(self.grid.seed);
        let share = self.shares(&[conditions], (seed, self.confirm), "confirming")?[0];
        Ok(Some(AsMeasured {
            cell: best.cell.clone(),
            b_s: share.value(),
            b_s_low: share.interval().low,
        }))
    }

    /// Why the robots cannot be simulated in a setting; `None` if they can.
    pub fn why_not(&self, cell: &Cell) -> Option<String> {
        match self.conditions((&Changes::new(), Robots::Harsher), cell) {
            Err(error) => Some(in_one_line(&error)),
            Ok(conditions) => check(&[conditions], self.runs(self.grid.seed, 1))
                .err()
                .map(|error| error.to_string()),
        }
    }

    /// Whether the best of some settings is likely to be confirmed.
    pub fn suffices(&self, tried: &[Tried]) -> bool {
        tried.first().is_some_and(|best| best.share.value() >= (self.wanted + MARGIN).min(0.995))
    }

    /// Finds the smallest change that reaches what is wanted.
    ///
    /// # Arguments
    ///
    /// * `at` — the changes for a share of the way, from 0, where they do not suffice, to 1, where
    ///   they do.
    /// * `ends` — settings that were tried at both ends.
    ///
    /// # Returns
    ///
    /// The share of the way, and how it was confirmed; `None` if fresh runs confirm none.
    ///
    /// # Errors
    ///
    /// As [`Search::best`].
    pub fn smallest(
        &self,
        at: &dyn Fn(f64) -> Changes,
        ends: [&[Tried]; 2],
        doing: &str,
    ) -> anyhow::Result<Option<(Changes, Confirmed)>> {
        let cells = first_of_each(&ends, KEPT);
        let (mut fails, mut holds) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = f64::midpoint(fails, holds);
            // Whole numbers have nothing between them.
            if at(middle) == at(holds) {
                holds = middle;
                continue;
            }
            let changes = at(middle);
            let cells = with_settings(&cells, &changes);
            let tried = self.tried((&changes, Robots::Harsher), &cells, (NARROW, doing))?;
            if self.suffices(&tried) { holds = middle } else { fails = middle }
        }
        for attempt in 0..ATTEMPTS {
            // A value that fresh runs do not confirm is followed by one nearer to the good end.
            let further = f64::from(attempt) / f64::from(ATTEMPTS - 1);
            let changes = at(holds + (1.0 - holds) * further * further);
            let cells = with_settings(&cells, &changes);
            let tried = self.tried((&changes, Robots::Harsher), &cells, (NARROW, doing))?;
            let Some(best) = tried.first() else { continue };
            let confirmed = self.confirmed(&changes, &best.cell, attempt)?;
            if confirmed.b_s_low >= self.wanted {
                return Ok(Some((changes, confirmed)));
            }
        }
        Ok(None)
    }

    /// Runs a changed robot in one setting on fresh seeds, made worse and as measured.
    ///
    /// # Arguments
    ///
    /// * `attempt` — from 0; each has seeds of its own.
    ///
    /// # Errors
    ///
    /// As [`Search::best`].
    pub fn confirmed(
        &self,
        changes: &Changes,
        cell: &Cell,
        attempt: u32,
    ) -> anyhow::Result<Confirmed> {
        let mut conditions = Vec::new();
        for robots in [Robots::Harsher, Robots::AsMeasured] {
            let world = self.conditions((changes, robots), cell)?;
            if !conditions.contains(&world) {
                conditions.push(world);
            }
        }
        let seed = (0..=attempt).fold(self.grid.seed, |seed, _| confirmation_seed(seed));
        let shares = self.shares(&conditions, (seed, self.confirm), "confirming")?;
        let tail = tail(attempt);
        let low = |share: &Share| Interval::with_tails(share.hits, share.n, tail).low;
        let rarer = shares.iter().min_by(|one, other| low(one).total_cmp(&low(other)));
        let rarer = rarer.expect("there is at least one world");
        Ok(Confirmed {
            cell: cell.clone(),
            b_s: rarer.value(),
            b_s_low: low(rarer),
            n_replicates: rarer.n,
        })
    }

    /// Confirms the best settings of a changed robot, until one holds.
    ///
    /// # Returns
    ///
    /// The one that holds, else the best of them; `None` if there is no setting.
    ///
    /// # Errors
    ///
    /// As [`Search::best`].
    pub fn confirmed_best(
        &self,
        changes: &Changes,
        tried: &[Tried],
    ) -> anyhow::Result<Option<Confirmed>> {
        let mut best: Option<Confirmed> = None;
        for (attempt, candidate) in (0..ATTEMPTS).zip(tried) {
            let confirmed = self.confirmed(changes, &candidate.cell, attempt)?;
            let is_enough = confirmed.b_s_low >= self.wanted;
            if best.as_ref().is_none_or(|best| confirmed.b_s_low > best.b_s_low) {
                best = Some(confirmed);
            }
            // The others were worse, and this one is not near.
            if is_enough || candidate.share.value() < self.wanted - FAR {
                break;
            }
        }
        Ok(best)
    }

    /// Runs some settings in rounds, more and more often where mills are frequent.
    fn tried(
        &self,
        (changes, robots): (&Changes, Robots),
        cells: &[Cell],
        (rounds, doing): (&[HalvingRound], &str),
    ) -> anyhow::Result<Vec<Tried>> {
        let mut tried: Vec<(Tried, Conditions)> = Vec::new();
        for cell in cells {
            // A robot that is none, or that finds no place, mills nowhere.
            let Ok(conditions) = self.conditions((changes, robots), cell) else { continue };
            if self.is_possible(&conditions) {
                let cell = cell.clone();
                tried.push((Tried { cell, share: Share::default() }, conditions));
            }
        }
        for (number, HalvingRound { n_cells, replicates }) in rounds.iter().enumerate() {
            let best = tried.first().map_or(0.0, |(best, _)| best.share.value());
            if number >= FIRST_LOOK && best < self.wanted - FAR {
                break;
            }
            let n_kept = tried.len().min(*n_cells);
            let conditions: Vec<Conditions> =
                tried[..n_kept].iter().map(|(_, conditions)| conditions.clone()).collect();
            let seed = self.grid.seed ^ number as u64;
            let shares = self.shares(&conditions, (seed, *replicates), doing)?;
            for ((tried, _), share) in tried.iter_mut().zip(shares) {
                tried.share.hits += share.hits;
                tried.share.n += share.n;
            }
            // Those that were run most often come first.
            tried[..n_kept]
                .sort_by(|(one, _), (other, _)| other.share.value().total_cmp(&one.share.value()));
        }
        Ok(tried.into_iter().map(|(tried, _)| tried).collect())
    }

    /// The conditions of a changed robot in a setting.
    ///
    /// # Errors
    ///
    /// If there is no such robot, or it cannot be simulated there.
    pub fn conditions(
        &self,
        (changes, robots): (&Changes, Robots),
        cell: &Cell,
    ) -> anyhow::Result<Conditions> {
        let capabilities: Changes =
            changes.iter().copied().filter(|(axis, _)| axis.is_capability()).collect();
        let robot = self.measured.with_capabilities(&capabilities)?;
        let robot = match robots {
            Robots::AsMeasured => robot,
            Robots::Harsher => HarsherFactors {
                // A cone that is turned becomes a polygon, which is no reason to make it smaller.
                polygon_scale: self.harsher.factors(self.measured).polygon_scale,
                ..self.harsher.factors(&robot)
            }
            .apply(&robot)?,
        };
        let settings: Settings = self.grid.settings.with_cell(cell);
        Ok(Conditions::resolve(&robot, &settings)?)
    }

    fn runs(&self, seed: u64, replicates: u64) -> Runs {
        let n_threads = self.execution.n_threads;
        Runs { seed, replicates, duration_s: self.grid.duration_s, n_threads }
    }

    /// The conditions of a changed robot in a setting, made worse and as measured.
    ///
    /// # Returns
    ///
    /// `None` if there is no such robot, or it cannot be simulated there.
    pub fn in_both_worlds(&self, changes: &Changes, cell: &Cell) -> Option<[Conditions; 2]> {
        let of = |robots| {
            let conditions = self.conditions((changes, robots), cell).ok()?;
            self.is_possible(&conditions).then_some(conditions)
        };
        Some([of(Robots::Harsher)?, of(Robots::AsMeasured)?])
    }

    /// Whether robots find a place under some conditions, and their runs can be judged.
    pub fn is_possible(&self, conditions: &Conditions) -> bool {
        check(std::slice::from_ref(conditions), self.runs(self.grid.seed, 1)).is_ok()
    }

    /// How so many runs under each of some conditions end.
    ///
    /// # Errors
    ///
    /// As [`Search::best`].
    pub fn counts(
        &self,
        conditions: &[Conditions],
        (seed, replicates): (u64, u64),
        doing: &str,
    ) -> anyhow::Result<Vec<PhaseCounts>> {
        Ok(self.simulate(conditions, (seed, replicates), doing)?.counts(conditions.len()))
    }

    /// What so many runs under each of some conditions come to.
    ///
    /// # Errors
    ///
    /// As [`Search::best`].
    pub fn simulate(
        &self,
        conditions: &[Conditions],
        (seed, replicates): (u64, u64),
        doing: &str,
    ) -> anyhow::Result<Swept> {
        let runs = self.runs(seed, replicates);
        self.execution.simulate(doing, |watch| sweep(conditions, runs, watch))
    }

    fn shares(
        &self,
        conditions: &[Conditions],
        runs: (u64, u64),
        doing: &str,
    ) -> anyhow::Result<Vec<Share>> {
        Ok(self.counts(conditions, runs, doing)?.iter().map(Share::milling).collect())
    }
}

/// The way is halved so often.
const BISECTIONS: u32 = 5;

/// The tail of the lower bound of an attempt, from 0: a half, a sixth, a twelfth … of [`TAIL`], in all no
/// more than that, however many attempts there are.
fn tail(attempt: u32) -> f64 {
    let number = f64::from(attempt) + 1.0;
    TAIL / (number * (number + 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bounds_of_all_attempts_hold_together() {
        let all: f64 = (0..100_000).map(tail).sum();

        assert!(all <= TAIL && all > 0.999 * TAIL, "{all}");
    }
}
