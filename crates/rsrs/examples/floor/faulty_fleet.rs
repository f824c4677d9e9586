//! A stand-in for the laboratory's floor: robots as they were measured, with faults on top of it that
//! the simulator does not have.
//!
//! It shares nothing with the simulator's worlds but where robots start and how they decide. Time
//! goes on in steps of 10 ms, in double precision, and every robot decides by its own clock.
//! The wheels lag behind their commands and sometimes slip, one at a time; bodies push each other
//! apart.

use std::f64::consts::TAU;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rsrs_core::conditions::{Conditions, GainDistribution};
use rsrs_core::robot::controller::{Command, decide};
use rsrs_core::robot::region::Region;
use rsrs_core::robot::unicycle::Pose;
use rsrs_pipeline::episode::recorder::RobotStep;
use rsrs_sim::draw::{RunKey, Seed};
use rsrs_sim::placement::{self, PlacementError};
use serde::Serialize;

/// Physical time step, in seconds.
const STEP_S: f64 = 0.01;
const STEP_NS: u64 = 10_000_000;

/// Distance between the wheels, in metres: that of a robot 15 cm wide.
const WHEEL_BASE_M: f64 = 0.12;

/// What real robots do and the simulator does not: chosen before anything was run, not fitted.
#[derive(Serialize)]
pub struct Faults {
    /// Time constant of each wheel's speed, in seconds.
    pub motor_lag_s: f64,
    /// How often a robot's wheel begins to slip, per second.
    pub slips_per_s: f64,
    /// Shortest and longest slip, in seconds.
    pub slip_s: (f64, f64),
    /// Share of its speed that a slipping wheel keeps.
    pub grip: f64,
    /// Standard deviation of a robot's control period, in seconds.
    pub jitter_s: f64,
}

/// The faults of the stand-in.
pub const FAULTS: Faults =
    Faults { motor_lag_s: 0.1, slips_per_s: 0.02, slip_s: (0.1, 0.4), grip: 0.6, jitter_s: 0.01 };

/// One robot.
struct Robot {
    pose: Pose,
    speed_gain: f64,
    turn_gain: f64,
    /// Speeds of the left and the right wheel, in metres per second.
    wheels_m_s: [f64; 2],
    /// The wheel that slips, and until when, in seconds.
    slip: Option<(usize, f64)>,
    next_decision_s: f64,
    command: Command,
}

/// Robots with the faults of [`FAULTS`].
pub struct FaultyFleet {
    conditions: Conditions,
    time_step: u64,
    robots: Vec<Robot>,
    random: ChaCha8Rng,
}

impl FaultyFleet {
    /// Places robots as measured, with a cone for a sensor, and draws their gains.
    pub fn new(conditions: &Conditions, seed: Seed) -> Result<Self, PlacementError> {
        let poses = placement::place(conditions, RunKey::new(seed, conditions.digest()))?;
        let mut random = ChaCha8Rng::seed_from_u64(seed.seed);
        random.set_stream(seed.replicate);
        let robots = poses
            .into_iter()
            .map(|pose| Robot {
                pose,
                speed_gain: draw_gain(&conditions.robot.speed_gain, &mut random),
                turn_gain: draw_gain(&conditions.robot.turn_gain, &mut random),
                wheels_m_s: [0.0; 2],
                slip: None,
                next_decision_s: random.random::<f64>() * conditions.period_s,
                command: Command::STOP,
            })
            .collect();
        Ok(Self { conditions: conditions.clone(), time_step: 0, robots, random })
    }

    /// Time since the start, in seconds.
    pub fn time_s(&self) -> f64 {
        self.time_step as f64 * STEP_S
    }

    /// Time since the start, in nanoseconds.
    pub fn time_ns(&self) -> u64 {
        self.time_step * STEP_NS
    }

    /// Poses of all robots; shape `[n_robots]`.
    pub fn poses(&self) -> impl Iterator<Item = Pose> + '_ {
        self.robots.iter().map(|robot| robot.pose)
    }

    /// The last command of every robot; shape `[n_robots]`.
    pub fn commands(&self) -> impl Iterator<Item = Command> + '_ {
        self.robots.iter().map(|robot| robot.command)
    }

    /// Lets 10 ms pass; returns the decisions of those robots whose time had come.
    pub fn advance(&mut self) -> Vec<RobotStep> {
        let steps = self.decide();
        let poses: Vec<Pose> = self.poses().collect();
        for robot in 0..self.robots.len() {
            let free = if self.is_blocked(robot, &poses) { 0.0 } else { 1.0 };
            self.drive(robot, free);
        }
        self.push_apart();
        self.time_step += 1;
        steps
    }

    fn decide(&mut self) -> Vec<RobotStep> {
        let time_s = self.time_s();
        let poses: Vec<Pose> = self.poses().collect();
        let mut steps = Vec::new();
        for robot in 0..self.robots.len() {
            if self.robots[robot].next_decision_s > time_s {
                continue;
            }
            let sensor = &self.conditions.robot;
            let chance =
                if self.sees(robot, &poses) { sensor.true_positive } else { sensor.false_positive };
            let detected = self.random.random::<f64>() < chance;
            let command =
                decide(detected, self.conditions.controller.parameters().expect("two commands"));
            let jitter_s = FAULTS.jitter_s * normal(&mut self.random);
            let time_ns = self.time_ns();
            let state = &mut self.robots[robot];
            let (pose, obeyed) = (state.pose, state.command);
            steps.push(RobotStep {
                robot,
                time_ns,
                pose,
                obeyed,
                readings: detected.into(),
                command,
            });
            state.next_decision_s += self.conditions.period_s + jitter_s;
            state.command = command;
        }
        steps
    }

    /// Whether the body of any other robot touches the cone of this one, as in `eq:output`.
    fn sees(&self, robot: usize, poses: &[Pose]) -> bool {
        let Region::Cone { half_angle_rad, range_m } = self.conditions.robot.region else {
            unreachable!("the stand-in has Flockbots, whose sensor is a cone")
        };
        let radius_m = self.conditions.robot.radius_m;
        let (sine, cosine) = libm::sincos(half_angle_rad);
        others(robot, poses).any(|[forward_m, left_m]| {
            let aside_m = left_m.abs();
            if libm::atan2(aside_m, forward_m) <= half_angle_rad {
                return libm::hypot(forward_m, aside_m) <= range_m + radius_m;
            }
            // Beside the cone the nearest point lies on its edge.
            let along_m = (forward_m * cosine + aside_m * sine).clamp(0.0, range_m);
            libm::hypot(forward_m - along_m * cosine, aside_m - along_m * sine) <= radius_m
        })
    }

    /// Whether another robot stands in front, which stops this one (§IV step 2).
    fn is_blocked(&self, robot: usize, poses: &[Pose]) -> bool {
        let body = &self.conditions.robot;
        others(robot, poses).any(|[forward_m, left_m]| {
            let reach_m = 2.0 * body.radius_m;
            let is_touching = forward_m * forward_m + left_m * left_m < reach_m * reach_m;
            is_touching && libm::atan2(left_m, forward_m).abs() < body.front_half_angle_rad
        })
    }

    /// Drives a robot for one step; `free` is 0 if its way is blocked, else 1.
    fn drive(&mut self, robot: usize, free: f64) {
        let time_s = self.time_s();
        self.slip(robot, time_s);
        let state = &mut self.robots[robot];
        let speed_m_s = state.command.speed_m_s * state.speed_gain;
        let half_turn_m_s = state.command.turn_rate_rad_s * state.turn_gain * WHEEL_BASE_M / 2.0;
        let share = 1.0 - libm::exp(-STEP_S / FAULTS.motor_lag_s);
        for (wheel, wanted_m_s) in
            state.wheels_m_s.iter_mut().zip([speed_m_s - half_turn_m_s, speed_m_s + half_turn_m_s])
        {
            *wheel += (wanted_m_s - *wheel) * share;
        }
        let mut wheels_m_s = state.wheels_m_s;
        if let Some((wheel, _)) = state.slip {
            wheels_m_s[wheel] *= FAULTS.grip;
        }
        let [left_m_s, right_m_s] = wheels_m_s;
        let turn_rad = (right_m_s - left_m_s) / WHEEL_BASE_M * STEP_S;
        let way_m = free * f64::midpoint(left_m_s, right_m_s) * STEP_S;
        let (sine, cosine) = libm::sincos(state.pose.heading_rad + turn_rad / 2.0);
        let half_side_m = self.conditions.arena.side_m / 2.0;
        let inside = |at_m: f64| at_m.clamp(-half_side_m, half_side_m);
        state.pose = Pose {
            x_m: inside(state.pose.x_m + way_m * cosine),
            y_m: inside(state.pose.y_m + way_m * sine),
            heading_rad: libm::remainder(state.pose.heading_rad + turn_rad, TAU),
        };
    }

    /// Begins and ends slips.
    fn slip(&mut self, robot: usize, time_s: f64) {
        let slip = &mut self.robots[robot].slip;
        if slip.is_some_and(|(_, until_s)| until_s <= time_s) {
            *slip = None;
        }
        if slip.is_none() && self.random.random::<f64>() < FAULTS.slips_per_s * STEP_S {
            let (shortest_s, longest_s) = FAULTS.slip_s;
            let lasts_s = shortest_s + (longest_s - shortest_s) * self.random.random::<f64>();
            *slip = Some((usize::from(self.random.random::<bool>()), time_s + lasts_s));
        }
    }

    /// Two bodies are never in one place: each gives way by half.
    fn push_apart(&mut self) {
        let apart_m = 2.0 * self.conditions.robot.radius_m;
        for robot in 0..self.robots.len() {
            for other in robot + 1..self.robots.len() {
                let (one, two) = (self.robots[robot].pose, self.robots[other].pose);
                let [dx_m, dy_m] = [two.x_m - one.x_m, two.y_m - one.y_m];
                let distance_m = libm::hypot(dx_m, dy_m);
                if distance_m >= apart_m || distance_m == 0.0 {
                    continue;
                }
                let give_way = (apart_m - distance_m) / 2.0 / distance_m;
                self.robots[robot].pose.x_m -= dx_m * give_way;
                self.robots[robot].pose.y_m -= dy_m * give_way;
                self.robots[other].pose.x_m += dx_m * give_way;
                self.robots[other].pose.y_m += dy_m * give_way;
            }
        }
    }
}

/// Where all other robots are, forward and to the left of one, in metres.
fn others(robot: usize, poses: &[Pose]) -> impl Iterator<Item = [f64; 2]> + '_ {
    let own = poses[robot];
    let (sine, cosine) = libm::sincos(own.heading_rad);
    let is_other = move |(other, _): &(usize, &Pose)| *other != robot;
    poses.iter().enumerate().filter(is_other).map(move |(_, pose)| {
        let [dx_m, dy_m] = [pose.x_m - own.x_m, pose.y_m - own.y_m];
        [dx_m * cosine + dy_m * sine, dy_m * cosine - dx_m * sine]
    })
}

fn draw_gain(gain: &GainDistribution, random: &mut ChaCha8Rng) -> f64 {
    gain.mean + gain.robot_sd * normal(random)
}

/// A normal draw, cut off at three standard deviations.
fn normal(random: &mut ChaCha8Rng) -> f64 {
    loop {
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - random.random::<f64>()));
        let draw = radius * libm::cos(TAU * random.random::<f64>());
        if draw.abs() <= 3.0 {
            return draw;
        }
    }
}
