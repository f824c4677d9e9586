//! Robots that fail at a time: they stand still, or their sensors report what they reported then.
//!
//! Nothing ends a failure. A robot that stands is a body as before, which others may push. Which robots those are of which a
//! world gives only the count is drawn for each replicate, each entry by itself.

use rsrs_core::conditions::Conditions;
use rsrs_core::robot::sensor::Readings;
use rsrs_core::world::Failure;

use crate::draw::{Purpose, RunKey, Seed, Stream};

/// The failures of a world, robot by robot.
pub(crate) struct Failures {
    /// The first step from which a robot stands, and from which its sensors stick; shape `[n_robots]` each.
    stands_from: Vec<Option<u64>>,
    sticks_from: Vec<Option<u64>>,
    /// What sensors stick at, once they do; shape `[n_robots]`.
    stuck: Vec<Option<Readings>>,
    n_readings: usize,
    /// What all robots report now: of the first reading, and of all; shape `[n_robots]` each.
    detection: Vec<bool>,
    readings: Vec<Readings>,
}

/// Robots that stand still in the replicate of a seed from some time on, in the order of their numbers from 0.
pub fn standing(conditions: &Conditions, seed: Seed) -> Vec<usize> {
    let failures = Failures::new(conditions, RunKey::new(seed, conditions.digest()));
    let stands_from = failures.map(|failures| failures.stands_from).unwrap_or_default();
    let standing = stands_from.iter().enumerate().filter(|(_, from)| from.is_some());
    standing.map(|(robot, _)| robot).collect()
}

impl Failures {
    /// The failures in a replicate; `None` where nobody fails.
    pub fn new(conditions: &Conditions, run: RunKey) -> Option<Self> {
        let failures = &conditions.world.failures;
        if failures.is_empty() {
            return None;
        }
        let n_robots = conditions.robots;
        let never = || vec![None; n_robots];
        let (mut stands_from, mut sticks_from) = (never(), never());
        for (entry, failure) in failures.iter().enumerate() {
            // The first step that is not before it.
            let step = (failure.at_s / conditions.period_s - 1e-9).ceil().max(0.0) as u64;
            let fail = |from: &mut Option<u64>| {
                *from = Some(from.map_or(step, |earlier| earlier.min(step)));
            };
            for robot in robots(failure, n_robots, Stream::new(run, entry, Purpose::Failure)) {
                if failure.stops {
                    fail(&mut stands_from[robot]);
                }
                if failure.sensors_stick {
                    fail(&mut sticks_from[robot]);
                }
            }
        }
        Some(Self {
            stands_from,
            sticks_from,
            stuck: vec![None; n_robots],
            n_readings: conditions.robot.reading_names().n_readings(),
            detection: vec![false; n_robots],
            readings: vec![Readings::default(); n_robots],
        })
    }

    /// Whether a robot stands in a step.
    pub fn stands(&self, robot: usize, step: u64) -> bool {
        self.stands_from[robot].is_some_and(|from| step >= from)
    }

    /// Takes what sensors report in a step, shape `[n_robots]`, and has those stick that fail.
    pub fn take(&mut self, step: u64, reported: impl Iterator<Item = Readings>) {
        for (robot, reported) in reported.enumerate() {
            let sticks = self.sticks_from[robot].is_some_and(|from| step >= from);
            let now = if sticks { *self.stuck[robot].get_or_insert(reported) } else { reported };
            self.readings[robot] = now;
            self.detection[robot] = now.detection();
        }
    }

    /// What robots report of the first reading; shape `[n_robots]`.
    pub fn detection(&self) -> &[bool] {
        &self.detection
    }

    /// What robots report; shape `[n_robots]`.
    pub fn readings(&self) -> &[Readings] {
        &self.readings
    }

    /// Each reading of the robots whose sensors stick.
    pub fn stuck(&self) -> impl Iterator<Item = bool> + '_ {
        let n_readings = self.n_readings;
        let stuck = self.stuck.iter().flatten();
        stuck.flat_map(move |readings| (0..n_readings).map(|reading| readings.has(reading)))
    }
}

/// Who fails, from 0.
fn robots(failure: &Failure, n_robots: usize, mut stream: Stream) -> Vec<usize> {
    if let Some(robot) = failure.robot {
        return vec![robot - 1];
    }
    let mut all: Vec<usize> = (0..n_robots).collect();
    let count = failure.count.unwrap_or(0).min(n_robots);
    for drawn in 0..count {
        let left = n_robots - drawn;
        let at = drawn + ((stream.uniform() * left as f64) as usize).min(left - 1);
        all.swap(drawn, at);
    }
    all.truncate(count);
    all
}
