//! A stand-in for the laboratory's floor: robots as they were measured, with faults on top of it that
//! the simulator does not have.
//!
//! It shares nothing with the simulator. Time goes on in steps of 10 ms, in double precision, and every robot
//! decides by its own clock. Motors have inertia, and a wheel slips now and then; sensors cast rays, which end at
//! the first body; robots that touch push each other, where those of the simulator stop.

use anyhow::{Context, bail};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rsrs_core::conditions::{Conditions, GainDistribution, Placement};
use rsrs_core::robot::controller::{Command, ControllerParameters};
use rsrs_core::robot::region::Region;
use rsrs_core::robot::unicycle::Pose;
use rsrs_pipeline::episode::recorder::RobotStep;
use rsrs_sim::draw::Seed;
use serde::Serialize;

use crate::mechanics::{self, MOTOR_MOST_M_S2, Motor, N_RAYS, moved, nearest_m, push_apart};

/// Physical time step, in seconds.
const STEP_S: f64 = 0.01;
const STEP_NS: u64 = 10_000_000;

/// Distance between the wheels, in metres: that of a robot 15 cm wide.
const WHEEL_BASE_M: f64 = 0.12;

/// How far apart two robots start at least, from body to body, in metres.
const GAP_M: f64 = 0.015;

/// What real robots do and the simulator does not: chosen before anything was run, not fitted.
#[derive(Serialize)]
pub struct Faults {
    /// Time constant of each wheel's speed, in seconds.
    pub motor_lag_s: f64,
    /// The most that a motor changes the speed of its wheel, in m/s².
    pub motor_most_m_s2: f64,
    /// Rays of a sensor.
    pub n_rays: usize,
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
pub const FAULTS: Faults = Faults {
    motor_lag_s: 0.1,
    motor_most_m_s2: MOTOR_MOST_M_S2,
    n_rays: N_RAYS,
    slips_per_s: 0.02,
    slip_s: (0.1, 0.4),
    grip: 0.6,
    jitter_s: 0.01,
};

/// Friction is in the gains that were measured.
const MOTOR: Motor = Motor { lag_s: FAULTS.motor_lag_s, friction_m_s2: 0.0 };

struct Robot {
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
    controller: ControllerParameters,
    time_step: u64,
    robots: Vec<Robot>,
    /// x and y in metres, heading in radians; shape `[n_robots]`.
    poses: Vec<[f64; 3]>,
    random: ChaCha8Rng,
}

impl FaultyFleet {
    /// Places robots as measured, with a cone for a sensor, and draws their gains.
    pub fn new(conditions: &Conditions, seed: Seed) -> anyhow::Result<Self> {
        let controller = conditions.controller.parameters().context("give two commands")?;
        let mut random = ChaCha8Rng::seed_from_u64(seed.seed);
        random.set_stream(seed.replicate);
        let poses = starts(conditions, &mut random)?;
        let robots = (0..conditions.robots)
            .map(|_| Robot {
                speed_gain: draw_gain(&conditions.robot.speed_gain, &mut random),
                turn_gain: draw_gain(&conditions.robot.turn_gain, &mut random),
                wheels_m_s: [0.0; 2],
                slip: None,
                next_decision_s: random.random::<f64>() * conditions.period_s,
                command: Command::STOP,
            })
            .collect();
        let conditions = conditions.clone();
        Ok(Self { conditions, controller, time_step: 0, robots, poses, random })
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
        self.poses.iter().map(pose)
    }

    /// The last command of every robot; shape `[n_robots]`.
    pub fn commands(&self) -> impl Iterator<Item = Command> + '_ {
        self.robots.iter().map(|robot| robot.command)
    }

    /// Lets 10 ms pass; returns the decisions of those robots whose time had come.
    pub fn advance(&mut self) -> Vec<RobotStep> {
        let steps = self.decide();
        for robot in 0..self.robots.len() {
            self.drive(robot);
        }
        push_apart(&mut self.poses, self.conditions.robot.radius_m);
        self.time_step += 1;
        steps
    }

    fn decide(&mut self) -> Vec<RobotStep> {
        let time_s = self.time_s();
        let ControllerParameters { speed_m_s, turn_rate_rad_s, undetected } = self.controller;
        let seen = Command { speed_m_s, turn_rate_rad_s };
        let unseen = undetected.unwrap_or(Command { speed_m_s, turn_rate_rad_s: -turn_rate_rad_s });
        let mut steps = Vec::new();
        for robot in 0..self.robots.len() {
            if self.robots[robot].next_decision_s > time_s {
                continue;
            }
            let sensor = &self.conditions.robot;
            let chance =
                if self.sees(robot) { sensor.true_positive } else { sensor.false_positive };
            let detected = self.random.random::<f64>() < chance;
            let command = if detected { seen } else { unseen };
            let jitter_s = FAULTS.jitter_s * normal(&mut self.random);
            let time_ns = self.time_ns();
            let state = &mut self.robots[robot];
            let (pose, obeyed) = (pose(&self.poses[robot]), state.command);
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

    /// Whether a ray of a robot's cone meets a body (`eq:output`).
    fn sees(&self, robot: usize) -> bool {
        let Region::Cone { half_angle_rad, range_m } = self.conditions.robot.region else {
            unreachable!("the stand-in has Flockbots, whose sensor is a cone")
        };
        let radius_m = self.conditions.robot.radius_m;
        nearest_m(&self.poses, robot, radius_m, 0.0, half_angle_rad) <= range_m
    }

    /// Drives a robot for one step.
    fn drive(&mut self, robot: usize) {
        let time_s = self.time_s();
        self.slip(robot, time_s);
        let state = &mut self.robots[robot];
        let speed_m_s = state.command.speed_m_s * state.speed_gain;
        let half_turn_m_s = state.command.turn_rate_rad_s * state.turn_gain * WHEEL_BASE_M / 2.0;
        for (wheel_m_s, asked_m_s) in
            state.wheels_m_s.iter_mut().zip([speed_m_s - half_turn_m_s, speed_m_s + half_turn_m_s])
        {
            *wheel_m_s = MOTOR.turned_m_s(*wheel_m_s, asked_m_s, STEP_S);
        }
        let mut wheels_m_s = state.wheels_m_s;
        if let Some((wheel, _)) = state.slip {
            wheels_m_s[wheel] *= FAULTS.grip;
        }
        let [left_m_s, right_m_s] = wheels_m_s;
        let turn_rad = (right_m_s - left_m_s) / WHEEL_BASE_M * STEP_S;
        let way_m = f64::midpoint(left_m_s, right_m_s) * STEP_S;
        let half_side_m = self.conditions.arena.side_m / 2.0;
        let inside = |at_m: f64| at_m.clamp(-half_side_m, half_side_m);
        let [x_m, y_m, heading_rad] = moved(self.poses[robot], way_m, turn_rad);
        self.poses[robot] = [inside(x_m), inside(y_m), heading_rad];
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
}

fn pose(&[x_m, y_m, heading_rad]: &[f64; 3]) -> Pose {
    Pose { x_m, y_m, heading_rad }
}

/// Where robots start: anywhere in the disc, each facing away from its centre, none at another.
fn starts(conditions: &Conditions, random: &mut ChaCha8Rng) -> anyhow::Result<Vec<[f64; 3]>> {
    let Placement::DiscFacingOut { radius_m } = conditions.placement else {
        bail!("the stand-in's robots start in a disc");
    };
    let apart_m = 2.0 * conditions.robot.radius_m + GAP_M;
    let mut poses: Vec<[f64; 3]> = Vec::new();
    for _ in 0..100_000 {
        if poses.len() == conditions.robots {
            return Ok(poses);
        }
        let [x_m, y_m] = [(); 2].map(|()| radius_m * (2.0 * random.random::<f64>() - 1.0));
        let is_inside = libm::hypot(x_m, y_m) <= radius_m;
        if is_inside && poses.iter().all(|it| libm::hypot(it[0] - x_m, it[1] - y_m) >= apart_m) {
            poses.push([x_m, y_m, libm::atan2(y_m, x_m)]);
        }
    }
    bail!("a disc of {radius_m} m does not hold {} robots", conditions.robots)
}

fn draw_gain(gain: &GainDistribution, random: &mut ChaCha8Rng) -> f64 {
    gain.mean + gain.robot_sd * normal(random)
}

/// A normal draw, cut off at three standard deviations.
fn normal(random: &mut ChaCha8Rng) -> f64 {
    loop {
        let draw = mechanics::normal(random);
        if draw.abs() <= 3.0 {
            return draw;
        }
    }
}
