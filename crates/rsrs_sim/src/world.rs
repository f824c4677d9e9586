//! The reference world: a swarm in single precision, defined to the bit.
//!
//! Any faster kernel must pass through exactly these states. So the order of operations is part of
//! the definition, and there is no fused multiply-add, no platform function, no square root in the
//! pair loop, and no sum over robots: only `+ - * /`, compare and select.
//!
//! **Sense**, for every robot, before any robot moves. For every robot `'`, itself included (at
//! distance zero it is neither in front nor a neighbour, so it is neither seen nor in the way):
//! ```text
//! dx = x' - x                      dy = y' - y
//! d2 = dx*dx + dy*dy               forward = dx*cos + dy*sin       lateral = dy*cos - dx*sin
//! seen    |= region(forward, lateral, d2)                          see `view`
//! blocked |= d2 < (2r)² and forward*|forward| > cosφ|cosφ| * d2    see `contact`
//! ```
//! then `detection = uniform24(step) < (seen ? true_positive : false_positive)`, delivered
//! `latency_steps` later; until the first arrives, nothing is detected.
//!
//! **Advance**, with one command `(u1, u2)` for each robot, rounded to single precision once:
//! ```text
//! travel = blocked ? 0 : (u1 * (gain1 + sd*normal)) * dt
//! to     = (x + travel*cos, y + travel*sin)          the heading before the turn
//! gust   = decay*gust + kick*normal                  to += gust * dt, also when blocked
//! (x, y) = border(from, to)
//! rate   = u2 * (gain2 + sd*normal) + bias
//! yaw    = yaw + (rate - yaw) * share                if there is a lag; then rate = yaw
//! angle  = rate*dt + sd*normal
//! (c, s) = turn(angle)
//! (cos, sin) = (cos*c - sin*s, sin*c + cos*s) * (1.5 - 0.5*(cos² + sin²))
//! ```
//! The last factor is one Newton step that keeps the heading's length at one. A term whose standard
//! deviation is zero is left out altogether, addition and draw.
//!
//! # Source
//!
//! `eq:disc_kine`, `eq:disc_func`, `eq:output`, §IV step 2.

use rsrs_core::conditions::Conditions;
use rsrs_core::controller::Command;
use rsrs_core::digest::Digest;
use rsrs_core::unicycle::Pose;

use crate::detections::Detections;
use crate::draw::{RunKey, Seed};
use crate::placement::{self, PlacementError};
use crate::robots::{Drive, Robots, Rules};
use crate::view::View;

/// A swarm of robots, one step at a time.
///
/// # Example
///
/// ```no_run
/// # use rsrs_core::{conditions::Conditions, controller::{Command, decide}};
/// # use rsrs_sim::{draw::Seed, world::World};
/// # fn example(conditions: &Conditions) -> Result<(), rsrs_sim::placement::PlacementError> {
/// let mut world = World::new(conditions, Seed { seed: 1, replicate: 0 })?;
/// let commands: Vec<Command> =
///     world.sense().iter().map(|detected| decide(*detected, conditions.controller)).collect();
/// world.advance(&commands);
/// # Ok(())
/// # }
/// ```
pub struct World {
    rules: Rules,
    step: u64,
    robots: Robots,
    seen: Vec<bool>,
    blocked: Vec<bool>,
    detections: Detections,
    is_sensed: bool,
}

impl World {
    /// Places the robots and draws their idiosyncrasies.
    ///
    /// # Errors
    ///
    /// [`PlacementError`] if the robots do not fit where they are to start.
    pub fn new(conditions: &Conditions, seed: Seed) -> Result<Self, PlacementError> {
        let run = RunKey::new(seed, conditions.digest());
        let poses = placement::place(conditions, run)?;
        let n_robots = conditions.robots;
        Ok(Self {
            rules: Rules::new(conditions),
            step: 0,
            robots: Robots::new(conditions, run, &poses),
            seen: vec![false; n_robots],
            blocked: vec![false; n_robots],
            detections: Detections::new(n_robots, conditions.robot.latency_steps),
            is_sensed: false,
        })
    }

    /// Number of robots.
    pub fn n_robots(&self) -> usize {
        self.robots.x_m.len()
    }

    /// Steps made so far.
    pub fn step_index(&self) -> u64 {
        self.step
    }

    /// Senses for all robots. Sensing again before the next step changes nothing.
    ///
    /// # Returns
    ///
    /// What each sensor reports now: `y`, shape `[n_robots]`.
    pub fn sense(&mut self) -> &[bool] {
        let found = (self.seen.as_mut_slice(), self.blocked.as_mut_slice());
        let (robots, contact) = (&self.robots, self.rules.contact);
        match &self.rules.view {
            View::Cone(cone) => robots.sense_pairs(contact, found, |forward, lateral, d2| {
                cone.sees(forward, lateral, d2)
            }),
            View::PolygonCentre(polygon) => {
                robots.sense_pairs(contact, found, |forward, lateral, d2| {
                    (d2 > 0.0) & polygon.contains(forward, lateral)
                });
            }
            View::PolygonBody(polygon) => {
                robots.sense_pairs(contact, found, |forward, lateral, _| {
                    (forward > 0.0) & polygon.contains(forward, lateral)
                });
            }
        }
        let row = self.detections.row_mut(self.step);
        for ((detection, traits), seen) in row.iter_mut().zip(&self.robots.traits).zip(&self.seen) {
            let limit = if *seen { self.rules.true_positive } else { self.rules.false_positive };
            *detection = traits.detection.uniform24(self.step as u32) < limit;
        }
        self.is_sensed = true;
        self.detections.delivered(self.step)
    }

    /// Which robots could not drive on when they last sensed; shape `[n_robots]`.
    pub fn blocked(&self) -> &[bool] {
        &self.blocked
    }

    /// Moves every robot by one control period.
    ///
    /// # Arguments
    ///
    /// * `commands` — one command for each robot, shape `[n_robots]`.
    ///
    /// # Panics
    ///
    /// If the world was not sensed since the last step, if the number of commands is not the number
    /// of robots, or if a command is not finite in single precision.
    pub fn advance(&mut self, commands: &[Command]) {
        assert!(self.is_sensed, "every robot senses before any robot moves");
        assert_eq!(commands.len(), self.n_robots(), "one command for each robot");
        for (robot, command) in commands.iter().enumerate() {
            let speed_m_s = command.speed_m_s as f32;
            let turn_rate_rad_s = command.turn_rate_rad_s as f32;
            assert!(
                speed_m_s.is_finite() && turn_rate_rad_s.is_finite(),
                "the command of robot {robot} is not finite: {command:?}"
            );
            let is_blocked = self.blocked[robot];
            let drive = Drive { speed_m_s, turn_rate_rad_s, is_blocked, step: self.step as u32 };
            self.robots.advance(&self.rules, robot, drive);
        }
        self.step += 1;
        self.is_sensed = false;
    }

    /// Names the state: equal digests after the same number of steps mean equal futures under equal
    /// commands.
    ///
    /// It covers the step, position and heading of every robot to the bit, and what a pose does not
    /// show: gusts, lagging turning rates and detections under way, where there are any.
    pub fn digest(&self) -> u64 {
        let mut digest = Digest::new("world");
        digest.word(self.step);
        let robots = &self.robots;
        let mut columns = vec![&robots.x_m, &robots.y_m, &robots.cosine, &robots.sine];
        if self.rules.gusts.is_some() {
            columns.extend([&robots.gust_x_m_s, &robots.gust_y_m_s]);
        }
        if self.rules.yaw_share.is_some() {
            columns.push(&robots.yaw_rate_rad_s);
        }
        for number in columns.into_iter().flatten() {
            digest.bytes(&number.to_bits().to_le_bytes());
        }
        for detection in self.detections.under_way(self.step) {
            digest.bytes(&[u8::from(*detection)]);
        }
        digest.value()
    }

    /// Position and heading of every robot, the heading from -π to π.
    pub fn poses(&self) -> impl Iterator<Item = Pose> + '_ {
        let robots = &self.robots;
        (0..self.n_robots()).map(|robot| Pose {
            x_m: f64::from(robots.x_m[robot]),
            y_m: f64::from(robots.y_m[robot]),
            heading_rad: libm::atan2(
                f64::from(robots.sine[robot]),
                f64::from(robots.cosine[robot]),
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example::flockbot_conditions;
    use rsrs_core::controller::decide;

    fn run(world: &mut World, conditions: &Conditions, n_steps: usize) {
        for _ in 0..n_steps {
            let commands: Vec<Command> = world
                .sense()
                .iter()
                .map(|detected| decide(*detected, conditions.controller))
                .collect();
            world.advance(&commands);
        }
    }

    #[test]
    fn the_order_of_the_robots_does_not_matter() {
        let mut conditions = flockbot_conditions();
        conditions.robot.gust_sd_m_s = 0.005;
        conditions.robot.speed_gain.step_sd = 0.02;
        conditions.robot.heading_noise_sd_rad = 0.01;
        let seed = Seed { seed: 1, replicate: 0 };
        let mut forward = World::new(&conditions, seed).unwrap();
        let mut backward = World::new(&conditions, seed).unwrap();
        backward.robots.reverse();

        run(&mut forward, &conditions, 2000);
        run(&mut backward, &conditions, 2000);
        backward.robots.reverse();

        assert_eq!(backward.digest(), forward.digest());
    }
}
