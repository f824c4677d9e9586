//! Many worlds at once: the sweep's kernel.
//!
//! A lane of a vector is a world, so that a robot's step in 4, 8 or 16 replicates of a cell costs
//! as many instructions as in one. The bits are those of [`crate::world`]: the same operations in
//! the same order, whatever the width, for every feature of a profile. Replicates are judged where
//! they are simulated, by the judge of [`rsrs_core::judge::order`] and [`rsrs_core::judge::phase`] itself, which is
//! written over any number; a test holds both to the reference, bit by bit.
//!
//! What makes it quick, besides the lanes: each pair of robots is looked at once for both of them;
//! contact, which is rare, is looked into only where something touches; in worlds without noise from
//! step to step a robot's turn is one of two constants; and of a run's past only the window that
//! the judge reads is kept.
//!
//! The vector unit is chosen when the program runs, not when it is built. AVX2 and AVX-512 have
//! vectors of their own; all else (SSE2, NEON) is plain Rust over arrays of four.

#![expect(
    clippy::inline_always,
    reason = "what is not inlined into the function of a vector unit does without its instructions"
)]

use std::ops::Range;

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::behaviour::rule::Rules;
use rsrs_core::judge::order::Parameter;
use rsrs_core::judge::phase::{self, JudgeError, Verdict};
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::judge::window::samples_in;
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::Command;

use crate::draw::{RunKey, Seed};
use crate::episode::run_episode_into;
use crate::placement::PlacementError;
use crate::turn::LIMIT_RAD;
use crate::vector::portable::Portable;
#[cfg(target_arch = "x86_64")]
use crate::vector::{avx2::Avx2, avx512::Avx512};

mod advance;
mod engine;
mod judge;
mod noise;
mod outside;
mod rows;
mod sense;
mod swarms;

use engine::{Engine, UnitEngine};
pub(crate) use outside::Lanes;

/// A vector unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VectorUnit {
    /// Four worlds at a time, on any machine: SSE2, NEON.
    Portable,
    /// Eight worlds at a time.
    Avx2,
    /// Sixteen worlds at a time.
    Avx512,
}

impl VectorUnit {
    /// The units that this machine has, the widest first.
    pub fn available() -> Vec<Self> {
        [Self::Avx512, Self::Avx2, Self::Portable]
            .into_iter()
            .filter(|unit| unit.engine().is_some())
            .collect()
    }

    #[cfg(target_arch = "x86_64")]
    fn engine(self) -> Option<Box<dyn Engine>> {
        match self {
            Self::Portable => Some(Box::new(UnitEngine::new(Portable))),
            Self::Avx2 => Some(Box::new(UnitEngine::new(Avx2::find()?))),
            Self::Avx512 => Some(Box::new(UnitEngine::new(Avx512::find()?))),
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn engine(self) -> Option<Box<dyn Engine>> {
        (self == Self::Portable).then(|| Box::new(UnitEngine::new(Portable)) as _)
    }
}

/// Why replicates of a cell could not be run and judged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BatchError {
    /// The robots do not fit where they are to start.
    #[error(transparent)]
    Placement(#[from] PlacementError),
    /// The runs cannot be judged.
    #[error(transparent)]
    Judge(#[from] JudgeError),
}

/// The vector units of this machine, and the memory they work in.
///
/// One for each thread; it is used again from cell to cell.
pub struct Batch {
    /// The widest first.
    engines: Vec<Box<dyn Engine>>,
    trajectory: Trajectory,
    also: Vec<Parameter>,
}

impl Default for Batch {
    fn default() -> Self {
        Self::new()
    }
}

impl Batch {
    /// A batch on all units of this machine: the narrowest that has a lane for each replicate runs
    /// them.
    pub fn new() -> Self {
        Self::with_units(&VectorUnit::available())
    }

    /// A batch on one unit; `None` if this machine does not have it.
    pub fn on(unit: VectorUnit) -> Option<Self> {
        unit.engine().map(|_| Self::with_units(&[unit]))
    }

    fn with_units(units: &[VectorUnit]) -> Self {
        Self {
            engines: units.iter().filter_map(|unit| unit.engine()).collect(),
            trajectory: Trajectory::new(1.0, 0),
            also: Vec::new(),
        }
    }

    /// The same with order parameters measured that the behaviours do not ask for.
    #[must_use]
    pub fn measuring(self, also: &[Parameter]) -> Self {
        Self { also: also.to_vec(), ..self }
    }

    /// Replicates that are run at once: the lanes of the widest unit.
    pub fn lanes(&self) -> usize {
        self.engines[0].lanes()
    }

    /// Worlds on the widest unit that take commands from outside, as many as it has lanes at most.
    pub(crate) fn commanded(
        &self,
        conditions: &Conditions,
        runs: &[RunKey],
    ) -> Result<Box<dyn Lanes>, PlacementError> {
        self.engines[0].commanded(conditions, runs)
    }

    /// How many replicates of a cell are best run together: the lanes of the widest unit, or 1 for
    /// a cell that is run one world at a time.
    pub fn at_once(&self, conditions: &Conditions, duration_s: f64) -> usize {
        if runs_in_lanes(conditions, duration_s) { self.lanes() } else { 1 }
    }

    /// Runs and judges replicates of one cell, with the seed of the sweep, for `duration_s` of
    /// simulated time each: one entry for each replicate, to the bit what [`phase::label_with`]
    /// finds in [`crate::episode::run_episode`].
    pub fn judge(
        &mut self,
        conditions: &Conditions,
        seed: u64,
        replicates: Range<u64>,
        duration_s: f64,
    ) -> Result<Vec<Verdict>, BatchError> {
        let digest = conditions.digest();
        let rules = &Rules { also: self.also.clone(), ..conditions.behaviour.rules() };
        let all: Vec<u64> = replicates.collect();
        let mut judged = Vec::with_capacity(all.len());
        for replicates in all.chunks(self.lanes()) {
            let run = |replicate: &u64| RunKey::new(Seed { seed, replicate: *replicate }, digest);
            let runs: Vec<RunKey> = replicates.iter().map(run).collect();
            let in_lanes = if runs_in_lanes(conditions, duration_s) {
                // A replicate that cannot be placed is left to the reference, which reports it.
                self.engine_for(runs.len())
                    .judge((conditions, rules), &runs, duration_s)
                    .ok()
                    .flatten()
            } else {
                None
            };
            if let Some(in_lanes) = in_lanes {
                judged.extend(in_lanes);
                continue;
            }
            for replicate in replicates {
                let seed = Seed { seed, replicate: *replicate };
                judged.push(self.judge_by_reference((conditions, rules), seed, duration_s)?);
            }
        }
        Ok(judged)
    }

    fn judge_by_reference(
        &mut self,
        (conditions, rules): (&Conditions, &Rules),
        seed: Seed,
        duration_s: f64,
    ) -> Result<Verdict, BatchError> {
        run_episode_into(conditions, seed, duration_s, &mut self.trajectory)?;
        Ok(phase::label_with(&self.trajectory, &conditions.bodies(), rules)?)
    }

    /// The digests of all states of replicates, each before its step is made, as
    /// [`crate::episode::episode_digests`] gives them for one; shape `[n_replicates][n_steps]`.
    ///
    /// # Panics
    ///
    /// If the robots are not all alike, do not stop on contact, have more than one plain sensor, or a controller with
    /// states: the lanes have no others.
    pub fn digests(
        &mut self,
        conditions: &Conditions,
        seed: u64,
        replicates: Range<u64>,
        n_steps: u64,
    ) -> Result<Vec<Vec<u64>>, PlacementError> {
        assert_in_lanes(conditions);
        let runs = runs(conditions, seed, replicates);
        let mut digests = Vec::with_capacity(runs.len());
        for runs in runs.chunks(self.lanes()) {
            digests.extend(self.engine_for(runs.len()).digests(conditions, runs, n_steps)?);
        }
        Ok(digests)
    }

    /// Makes steps of replicates and looks at nothing: the kernel alone, for benchmarks.
    ///
    /// # Panics
    ///
    /// As [`Self::digests`].
    pub fn step_only(
        &mut self,
        conditions: &Conditions,
        seed: u64,
        replicates: Range<u64>,
        n_steps: u64,
    ) -> Result<(), PlacementError> {
        assert_in_lanes(conditions);
        let runs = runs(conditions, seed, replicates);
        runs.chunks(self.lanes())
            .try_for_each(|runs| self.engine_for(runs.len()).step_only(conditions, runs, n_steps))
    }

    /// The narrowest unit with a lane for each of so many replicates.
    fn engine_for(&mut self, n_runs: usize) -> &mut dyn Engine {
        let index = self.engines.iter().rposition(|engine| engine.lanes() >= n_runs);
        self.engines[index.expect("no more runs than the widest unit has lanes")].as_mut()
    }
}

fn runs(conditions: &Conditions, seed: u64, replicates: Range<u64>) -> Vec<RunKey> {
    let digest = conditions.digest();
    replicates.map(|replicate| RunKey::new(Seed { seed, replicate }, digest)).collect()
}

/// More robots than this are run one world at a time, with a grid.
const MOST_ROBOTS: usize = 256;

/// More states than this are not kept for the judge; the reference keeps them all.
const MOST_STATES: usize = 1 << 20;

/// The greatest number that [`crate::draw::normal`] gives, rounded up.
const MOST_NORMAL: f64 = 6.0;

/// Lanes of the widest unit of any machine.
pub const MOST_LANES: usize = 16;

fn assert_in_lanes(conditions: &Conditions) {
    assert!(
        are_for_lanes(conditions),
        "the lanes have robots that are alike, stop and have one plain sensor, in a square without objects and obstacles, \
         and none fails"
    );
    assert!(decides_in_lanes(conditions), "the lanes have two commands over one detection");
}

/// Whether the lanes have what these robots are: one kind for all, which stops on contact and has one plain sensor, in a
/// square without objects and obstacles, and none fails.
fn are_for_lanes(conditions: &Conditions) -> bool {
    conditions.are_robots_alike()
        && conditions.robot.contact == ContactModel::Stop
        && conditions.robot.has_one_plain_sensor()
        && conditions.world.n_objects() == 0
        && conditions.free_space().is_none()
        && conditions.world.failures.is_empty()
}

/// Whether the lanes have its controller: two commands over one detection. A machine with states runs in
/// the reference world.
fn decides_in_lanes(conditions: &Conditions) -> bool {
    conditions.controller.parameters().is_some()
}

/// Whether the lanes can run robots that are commanded from outside, at most so much to either side.
pub(crate) fn can_be_commanded(conditions: &Conditions, most: Command) -> bool {
    are_for_lanes(conditions)
        && (1..=MOST_ROBOTS).contains(&conditions.robots)
        && is_moderate(conditions, most)
}

/// Whether no step is longer than what the lanes compute as the reference does.
fn is_moderate(conditions: &Conditions, fastest: Command) -> bool {
    let robot = &conditions.robot;
    let most = |gain: rsrs_core::conditions::GainDistribution| {
        gain.mean.abs() + MOST_NORMAL * (gain.robot_sd + gain.step_sd)
    };
    let rate_rad_s =
        fastest.turn_rate_rad_s * most(robot.turn_gain) + MOST_NORMAL * robot.turn_bias_sd_rad_s;
    let angle_rad = rate_rad_s * conditions.period_s + MOST_NORMAL * robot.heading_noise_sd_rad;
    let way_m = fastest.speed_m_s * most(robot.speed_gain) * conditions.period_s;
    angle_rad < f64::from(LIMIT_RAD) && way_m < 1e6
}

/// Whether replicates of a cell are run and judged in the lanes of a vector, on any machine. All others are
/// run one world at a time by the reference: what the lanes do not have (`are_for_lanes`, `decides_in_lanes`),
/// what is refused, and what is far from what robots do.
pub fn runs_in_lanes(conditions: &Conditions, duration_s: f64) -> bool {
    let window = conditions.behaviour.window();
    let n_samples = conditions.steps(duration_s);
    let is_long_enough = n_samples >= samples_in(window.least_s(), conditions.period_s) as u64;
    let n_kept = || window.n_needed(n_samples as usize, conditions.period_s);
    are_for_lanes(conditions)
        && decides_in_lanes(conditions)
        && (1..=MOST_ROBOTS).contains(&conditions.robots)
        && is_long_enough
        && conditions.robots.saturating_mul(n_kept()) <= MOST_STATES
        && is_moderate(conditions, conditions.controller.fastest())
}
