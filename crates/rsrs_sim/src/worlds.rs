//! Many worlds of the same conditions, side by side, that take commands from outside: for learning.
//!
//! Each passes through the states of the [`World`] with its replicate under the same commands, to the bit.
//! Robots that are alike and stop on contact are in the lanes of a vector, others in a world each.

use std::ops::Range;

use rsrs_core::conditions::Conditions;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::Pose;

use crate::batch::{Batch, Lanes, VectorUnit, can_be_commanded};
use crate::draw::{RunKey, Seed};
use crate::placement::PlacementError;
use crate::world::World;

/// Worlds side by side. What is of all robots is world by world, robot by robot: shape
/// `[n_worlds * n_robots]`.
pub struct Worlds {
    n_robots: usize,
    /// So many worlds in all parts but the last one.
    n_in_part: usize,
    /// Robots in all worlds together.
    n_bodies: usize,
    most: Command,
    parts: Vec<Part>,
    is_sensed: bool,
}

enum Part {
    Lanes(Box<dyn Lanes>),
    World(Box<World>),
}

impl Worlds {
    /// The worlds of some replicates of a seed, which are commanded at most as much as `most` to either
    /// side.
    pub fn new(
        conditions: &Conditions,
        seed: u64,
        replicates: Range<u64>,
        most: Command,
    ) -> Result<Self, PlacementError> {
        Self::on(&VectorUnit::available(), conditions, (seed, replicates), most)
    }

    /// The same on the first of these units that this machine has; in a world each where it has none.
    pub fn on(
        units: &[VectorUnit],
        conditions: &Conditions,
        (seed, replicates): (u64, Range<u64>),
        most: Command,
    ) -> Result<Self, PlacementError> {
        let digest = conditions.digest();
        let all: Vec<u64> = replicates.collect();
        let batch = units.iter().copied().find_map(Batch::on);
        let batch = batch.filter(|_| can_be_commanded(conditions, most));
        let n_in_part = batch.as_ref().map_or(1, Batch::lanes);
        let parts = all.chunks(n_in_part).map(|replicates| {
            let seeds = replicates.iter().map(|replicate| Seed { seed, replicate: *replicate });
            let runs: Vec<RunKey> = seeds.map(|seed| RunKey::new(seed, digest)).collect();
            if let Some(batch) = &batch {
                return Ok(Part::Lanes(batch.commanded(conditions, &runs)?));
            }
            let seed = Seed { seed, replicate: replicates[0] };
            Ok(Part::World(Box::new(World::new(conditions, seed)?)))
        });
        Ok(Self {
            n_robots: conditions.robots,
            n_in_part,
            n_bodies: all.len() * conditions.robots,
            most,
            parts: parts.collect::<Result<_, PlacementError>>()?,
            is_sensed: false,
        })
    }

    /// Senses for all robots. Sensing again before the next step changes nothing.
    ///
    /// # Panics
    ///
    /// If `detections` has another length than there are robots in all worlds.
    pub fn sense(&mut self, detections: &mut [bool]) {
        assert_eq!(detections.len(), self.n_bodies, "a detection for each robot");
        let of_parts = detections.chunks_mut(self.n_in_part * self.n_robots);
        for (part, detections) in self.parts.iter_mut().zip(of_parts) {
            match part {
                Part::Lanes(lanes) => lanes.sense(detections),
                Part::World(world) => detections.copy_from_slice(world.sense()),
            }
        }
        self.is_sensed = true;
    }

    /// Moves every robot by one control period.
    ///
    /// # Panics
    ///
    /// If the worlds were not sensed since the last step, there is not one command for each robot, or a
    /// command is beyond what the worlds were made for.
    pub fn advance(&mut self, commands: &[Command]) {
        assert!(self.is_sensed, "every robot senses before any robot moves");
        assert_eq!(commands.len(), self.n_bodies, "a command for each robot");
        let Command { speed_m_s, turn_rate_rad_s } = self.most;
        let is_within = |command: &Command| {
            command.speed_m_s.abs() <= speed_m_s && command.turn_rate_rad_s.abs() <= turn_rate_rad_s
        };
        assert!(commands.iter().all(is_within), "no command is beyond {:?}", self.most);
        let of_parts = commands.chunks(self.n_in_part * self.n_robots);
        for (part, commands) in self.parts.iter_mut().zip(of_parts) {
            match part {
                Part::Lanes(lanes) => lanes.advance(commands),
                Part::World(world) => world.advance(commands),
            }
        }
        self.is_sensed = false;
    }

    /// Where the robots are, their headings from -π to π.
    pub fn poses(&self) -> Vec<Pose> {
        let nowhere = Pose { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 };
        let mut poses = vec![nowhere; self.n_bodies];
        let of_parts = poses.chunks_mut(self.n_in_part * self.n_robots);
        for (part, poses) in self.parts.iter().zip(of_parts) {
            match part {
                Part::Lanes(lanes) => lanes.poses(poses),
                Part::World(world) => {
                    poses.iter_mut().zip(world.poses()).for_each(|(to, pose)| *to = pose);
                }
            }
        }
        poses
    }

    /// Names the state of every world, as [`World::digest`] does; shape `[n_worlds]`.
    pub fn digests(&self) -> Vec<u64> {
        let of_part = |part: &Part| match part {
            Part::Lanes(lanes) => lanes.digests(),
            Part::World(world) => vec![world.digest()],
        };
        self.parts.iter().flat_map(of_part).collect()
    }
}
