//! The controllers of a swarm at work, one decision of each robot for each step.

use rsrs_core::conditions::Conditions;
use rsrs_core::draw::{Key, Seed};
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::controller::state_machine::{Memory, Program, transition_key};
use rsrs_core::robot::sensor::Readings;

/// What decides for each robot, and what each remembers.
///
/// Its draws are keyed by run, robot and step, so that a run repeats to the bit.
pub struct Controllers {
    program: Program,
    robots: Vec<(Memory, Key)>,
}

impl Controllers {
    /// The controllers at the start of a run, under conditions that were checked.
    pub fn new(conditions: &Conditions, seed: Seed) -> Self {
        let digest = conditions.controller.digest();
        let classes = conditions.world.class_names_of(conditions.robots).into_iter().enumerate();
        let robot = |(robot, class)| {
            (conditions.controller.start(class), transition_key(seed, digest, robot))
        };
        Self { program: conditions.controller.program(), robots: classes.map(robot).collect() }
    }

    /// Appends the command of each robot for what it reports; both have the shape `[n_robots]`.
    ///
    /// # Panics
    ///
    /// If there are not the readings of each robot, or not those that the conditions' robots have.
    pub fn decide(&mut self, readings: &[Readings], commands: &mut Vec<Command>) {
        assert_eq!(readings.len(), self.robots.len(), "what each robot reports");
        let robots = self.robots.iter_mut().zip(readings);
        commands
            .extend(robots.map(|((memory, key), found)| self.program.decide(*found, memory, *key)));
    }
}
