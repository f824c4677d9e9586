//! The loop that one would write first: double precision, a struct for each robot, a branch for
//! each rule, the platform's trigonometry, every pair from both sides.

use rsrs_core::conditions::Conditions;
use rsrs_core::robot::region::Region;
use rsrs_core::robot::unicycle::Pose;
use rsrs_sim::draw::{Key, Purpose, RunKey, Seed, Stream};
use rsrs_sim::placement::place;

struct Robot {
    pose: Pose,
    speed_gain: f64,
    turn_gain: f64,
    key: Key,
}

/// A world without SIMD, lanes or tables; walls stop, robots see bodies in a cone.
pub struct PlainWorld {
    robots: Vec<Robot>,
    conditions: Conditions,
    step: u32,
}

impl PlainWorld {
    /// Places the robots.
    ///
    /// # Panics
    ///
    /// If they do not fit.
    pub fn new(conditions: &Conditions, seed: Seed) -> Self {
        let run = RunKey::new(seed, conditions.digest());
        let robot = |(robot, pose): (usize, Pose)| {
            let gain = |purpose| 0.97 + 0.05 * Stream::new(run, robot, purpose).truncated_normal();
            Robot {
                pose,
                speed_gain: gain(Purpose::SpeedGain),
                turn_gain: gain(Purpose::TurnGain),
                key: run.key(robot, Purpose::Detection),
            }
        };
        let poses = place(conditions, run).expect("the robots fit");
        Self {
            robots: poses.into_iter().enumerate().map(robot).collect(),
            conditions: conditions.clone(),
            step: 0,
        }
    }

    /// Makes one step.
    ///
    /// # Panics
    ///
    /// If the robots have no cones, or more than two commands.
    #[expect(clippy::disallowed_methods, reason = "the yardstick is what one would write first")]
    pub fn step(&mut self) {
        let robot = &self.conditions.robot;
        let Region::Cone { half_angle_rad, range_m } = robot.region else {
            unreachable!("the benchmarks' robots have cones")
        };
        let (edge_y, edge_x) = half_angle_rad.sin_cos();
        let (body_m, contact_m) = (robot.radius_m, 2.0 * robot.radius_m);
        let reach_m = range_m + body_m;
        let front = robot.front_half_angle_rad.cos();
        let wall_m = self.conditions.arena.side_m / 2.0 - robot.radius_m;
        let controller = self.conditions.controller.parameters().expect("two commands");
        let found: Vec<(bool, bool)> = (0..self.robots.len())
            .map(|me| {
                let pose = self.robots[me].pose;
                let (sine, cosine) = pose.heading_rad.sin_cos();
                let (mut seen, mut blocked) = (false, false);
                for (index, other) in self.robots.iter().enumerate() {
                    if index == me {
                        continue;
                    }
                    let (dx_m, dy_m) = (other.pose.x_m - pose.x_m, other.pose.y_m - pose.y_m);
                    let d2_m2 = dx_m * dx_m + dy_m * dy_m;
                    let forward_m = dx_m * cosine + dy_m * sine;
                    let lateral_m = dy_m * cosine - dx_m * sine;
                    if d2_m2 <= reach_m * reach_m {
                        // From the edge of the cone, and along it.
                        let beside_m = lateral_m.abs() * edge_x - forward_m * edge_y;
                        let along_m = lateral_m.abs() * edge_y + forward_m * edge_x;
                        let beyond_m = along_m - along_m.clamp(0.0, range_m);
                        if beside_m <= 0.0
                            || beside_m * beside_m + beyond_m * beyond_m <= body_m * body_m
                        {
                            seen = true;
                        }
                    }
                    if d2_m2 < contact_m * contact_m && forward_m > front * d2_m2.sqrt() {
                        blocked = true;
                    }
                }
                (seen, blocked)
            })
            .collect();
        for (robot, (seen, blocked)) in self.robots.iter_mut().zip(found) {
            let probability = if seen { 0.80 } else { 0.08 };
            let detected = f64::from(robot.key.uniform24(self.step)) / 16_777_216.0 < probability;
            let (sine, cosine) = robot.pose.heading_rad.sin_cos();
            if !blocked {
                let travel_m = controller.speed_m_s * robot.speed_gain * self.conditions.period_s;
                let (x_m, y_m) =
                    (robot.pose.x_m + travel_m * cosine, robot.pose.y_m + travel_m * sine);
                if x_m.abs() <= wall_m && y_m.abs() <= wall_m {
                    (robot.pose.x_m, robot.pose.y_m) = (x_m, y_m);
                }
            }
            let turn_rate_rad_s =
                if detected { controller.turn_rate_rad_s } else { -controller.turn_rate_rad_s };
            robot.pose.heading_rad += turn_rate_rad_s * robot.turn_gain * self.conditions.period_s;
        }
        self.step += 1;
    }

    /// Where the robots are.
    pub fn poses(&self) -> impl Iterator<Item = Pose> + '_ {
        self.robots.iter().map(|robot| robot.pose)
    }
}
