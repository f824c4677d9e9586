//! Worlds in lanes that are commanded from outside: what [`crate::world`] is for one.

use rsrs_core::conditions::Conditions;
use rsrs_core::judge::number::{Mask, Number};
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::Pose;

use super::sense::Body;
use super::swarms::{CommandedBy, Swarms};
use crate::draw::RunKey;
use crate::placement::PlacementError;
use crate::vector::simd::Simd;

/// The worlds of one vector. What is of all robots is world by world, robot by robot: shape
/// `[n_worlds * n_robots]`.
pub trait Lanes: Send {
    /// Senses for all robots.
    fn sense(&mut self, detections: &mut [bool]);

    /// Moves all robots by one control period; they were sensed, and commands are finite.
    fn advance(&mut self, commands: &[Command]);

    /// Where the robots are.
    fn poses(&self, poses: &mut [Pose]);

    /// Names the states, as [`crate::world::World::digest`] does.
    fn digests(&self) -> Vec<u64>;
}

/// The lanes of a vector unit.
pub struct UnitLanes<S: Simd> {
    simd: S,
    n_worlds: usize,
    swarms: Swarms<S>,
    bodies: Vec<Body<S::F>>,
    arrived: Vec<S::M>,
    commands: Vec<(S::F, S::F)>,
}

impl<S: Simd> UnitLanes<S> {
    /// Places the robots of one world to as many as there are lanes.
    pub fn new(simd: S, conditions: &Conditions, runs: &[RunKey]) -> Result<Self, PlacementError> {
        assert!((1..=S::LANES).contains(&runs.len()), "a lane for each world");
        let (n_robots, zero) = (conditions.robots, simd.single(0.0));
        let mut bodies = vec![Body { x_m: zero, y_m: zero, cosine: zero, sine: zero }; n_robots];
        let who = (simd, CommandedBy::Outside);
        let swarms = Swarms::placed(who, conditions, runs, &mut bodies)?;
        let (arrived, commands) = (vec![simd.no(); n_robots], vec![(zero, zero); n_robots]);
        Ok(Self { simd, n_worlds: runs.len(), swarms, bodies, arrived, commands })
    }
}

impl<S: Simd> Lanes for UnitLanes<S> {
    fn sense(&mut self, detections: &mut [bool]) {
        self.swarms.sense(&self.bodies, &mut self.arrived);
        let n_robots = self.bodies.len();
        for (robot, arrived) in self.arrived.iter().enumerate() {
            let bits = arrived.bits();
            for lane in 0..self.n_worlds {
                detections[lane * n_robots + robot] = bits >> lane & 1 == 1;
            }
        }
    }

    fn advance(&mut self, commands: &[Command]) {
        let (n_robots, last) = (self.bodies.len(), self.n_worlds - 1);
        for (robot, command) in self.commands.iter_mut().enumerate() {
            // Spare lanes repeat the last world.
            let of = |lane: usize| commands[lane.min(last) * n_robots + robot];
            *command = (
                self.simd.singles(|lane| of(lane).speed_m_s as f32),
                self.simd.singles(|lane| of(lane).turn_rate_rad_s as f32),
            );
        }
        self.swarms.advance(&mut self.bodies, &self.commands);
    }

    fn poses(&self, poses: &mut [Pose]) {
        let n_robots = self.bodies.len();
        for (robot, body) in self.bodies.iter().enumerate() {
            for lane in 0..self.n_worlds {
                let number = |numbers: S::F| f64::from(numbers.lane(lane));
                let (cosine, sine) = (number(body.cosine), number(body.sine));
                poses[lane * n_robots + robot] = Pose {
                    x_m: number(body.x_m),
                    y_m: number(body.y_m),
                    heading_rad: libm::atan2(sine, cosine),
                };
            }
        }
    }

    fn digests(&self) -> Vec<u64> {
        (0..self.n_worlds).map(|lane| self.swarms.digest_of(&self.bodies, lane)).collect()
    }
}
