//! A floor that shares nothing with the simulator, not even its controller or its draws.
//!
//! Bodies are solid, and push each other. Wheels are driven by motors that lag, are limited in what they give, and
//! lose some of it to friction. A sensor casts rays, of which each ends at the first body. What goes wrong lasts: a
//! wheel slips for a while, and a sensor is blind or sees ghosts for a while. Each robot decides by a clock of its
//! own, which jitters. Time goes on in steps of 5 ms, in double precision.
//!
//! All numbers were chosen before anything was run on it.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::{Deserialize, Serialize};

use crate::mechanics::{Motor, moved, nearest_m, normal, push_apart};

const STEP_S: f64 = 0.005;

const RADIUS_M: f64 = 0.075;
const WHEEL_BASE_M: f64 = 0.12;

/// Standard deviations, by robot: of both wheels' size, of the difference between them, and of the motors.
const WHEEL_SIZE_SD: f64 = 0.02;
const WHEEL_PAIR_SD: f64 = 0.005;
const MOTOR_SD: f64 = 0.05;
/// A motor approaches what it is asked for with this time constant, in seconds.
const MOTOR_LAG_S: f64 = 0.12;
/// What friction takes of its acceleration, in m/s².
const FRICTION_M_S2: f64 = 0.05;
/// A robot turns by so much less than its wheels would have it.
const SCRUB: f64 = 0.10;

/// How often a wheel begins to slip, per second and robot, for how long, and the share of its speed that it keeps.
const SLIPS_PER_S: f64 = 0.05;
const SLIP_S: (f64, f64) = (0.1, 0.4);
const GRIP: f64 = 0.6;

/// Rays of a sensor leave the front of the body; how far they reach, and by how much that varies.
const HALF_ANGLE_RAD: f64 = 0.30;
const RANGE_M: f64 = 0.75;
const RANGE_SD_M: f64 = 0.03;
/// How often a sensor becomes blind, or sees ghosts, per second, and for how long.
const BLIND_PER_S: f64 = 0.10;
const BLIND_S: (f64, f64) = (0.3, 1.2);
const GHOSTS_PER_S: f64 = 0.03;
const GHOSTS_S: (f64, f64) = (0.2, 0.6);

/// A robot's control period and its standard deviation, in seconds.
const PERIOD_S: f64 = 0.13;
const JITTER_S: f64 = 0.01;

/// Draws that make the robots; those of a drive have its seed, from 1 on.
const OF_ROBOTS: u64 = 0;

/// What is asked for.
#[derive(Deserialize)]
pub struct Drive {
    /// Which robots drive; each number is one robot, the same in every drive.
    robots: Vec<u64>,
    /// Where they start: x and y in metres, heading in radians.
    starts: Vec<[f64; 3]>,
    /// Speed in m/s and turning rate in rad/s while nothing is detected.
    unseen: [f64; 2],
    /// The same while something is.
    seen: [f64; 2],
    /// How many control periods the drive lasts.
    n_periods: usize,
    /// From 1 on.
    seed: u64,
}

/// What robots did, sampled every `period_s` seconds.
#[derive(Serialize)]
pub struct Driven {
    period_s: f64,
    /// Shape `[n_samples][n_robots][3]`.
    poses: Vec<Vec<[f64; 3]>>,
    /// Shape `[n_samples][n_robots][2]`.
    commands: Vec<Vec<[f64; 2]>>,
    /// Shape `[n_samples][n_robots]`.
    detections: Vec<Vec<bool>>,
    /// Seconds from each decision of the first robot to its next.
    periods_s: Vec<f64>,
}

struct Robot {
    /// Of the left and the right wheel: actual over believed size.
    wheels: [f64; 2],
    motor: Motor,
    /// x and y in metres, heading in radians.
    pose: [f64; 3],
    /// Of the left and the right wheel, over the floor, in m/s.
    speeds_m_s: [f64; 2],
    command: [f64; 2],
    detects: bool,
    next_decision_s: f64,
    /// The wheel that slips, and until when.
    slip: (usize, f64),
    blind_until_s: f64,
    ghosts_until_s: f64,
}

/// Lets robots drive from their starts.
pub fn drive(task: &Drive) -> Driven {
    let mut random = ChaCha8Rng::seed_from_u64(task.seed);
    let mut robots: Vec<Robot> = task
        .robots
        .iter()
        .zip(&task.starts)
        .map(|(&number, &pose)| Robot::new(number, pose, &mut random))
        .collect();
    let mut driven = Driven {
        period_s: PERIOD_S,
        poses: Vec::new(),
        commands: Vec::new(),
        detections: Vec::new(),
        periods_s: Vec::new(),
    };
    let mut decided_s = None;
    let mut step: u32 = 0;
    while driven.commands.len() < task.n_periods {
        let time_s = f64::from(step) * STEP_S;
        // With a pose stands what was decided in the period that begins with it.
        if time_s >= driven.poses.len() as f64 * PERIOD_S {
            if !driven.poses.is_empty() {
                driven.commands.push(robots.iter().map(|robot| robot.command).collect());
                driven.detections.push(robots.iter().map(|robot| robot.detects).collect());
            }
            if driven.poses.len() < task.n_periods {
                driven.poses.push(poses_of(&robots));
            }
        }
        for robot in 0..robots.len() {
            if robots[robot].next_decision_s > time_s {
                continue;
            }
            decide(&mut robots, robot, task, time_s, &mut random);
            if robot == 0 {
                driven.periods_s.extend(decided_s.map(|last_s| time_s - last_s));
                decided_s = Some(time_s);
            }
        }
        for robot in &mut robots {
            robot.go_wrong(time_s, &mut random);
            robot.roll(time_s);
        }
        let mut poses = poses_of(&robots);
        push_apart(&mut poses, RADIUS_M);
        robots.iter_mut().zip(poses).for_each(|(robot, pose)| robot.pose = pose);
        step += 1;
    }
    driven
}

impl Robot {
    fn new(number: u64, pose: [f64; 3], random: &mut ChaCha8Rng) -> Self {
        let mut made = ChaCha8Rng::seed_from_u64(OF_ROBOTS);
        made.set_stream(number);
        let size = 1.0 + WHEEL_SIZE_SD * normal(&mut made);
        let pair = WHEEL_PAIR_SD * normal(&mut made);
        Self {
            wheels: [size - pair, size + pair],
            motor: Motor {
                lag_s: MOTOR_LAG_S * (1.0 + MOTOR_SD * normal(&mut made)),
                friction_m_s2: FRICTION_M_S2,
            },
            pose,
            speeds_m_s: [0.0; 2],
            command: [0.0; 2],
            detects: false,
            next_decision_s: PERIOD_S * random.random::<f64>(),
            slip: (0, 0.0),
            blind_until_s: 0.0,
            ghosts_until_s: 0.0,
        }
    }

    /// Begins what lasts for a while.
    fn go_wrong(&mut self, time_s: f64, random: &mut ChaCha8Rng) {
        let mut begins = |until_s: f64, per_s: f64, (shortest_s, longest_s): (f64, f64)| {
            let is_so = until_s <= time_s && random.random::<f64>() < per_s * STEP_S;
            let lasts_s = shortest_s + (longest_s - shortest_s) * random.random::<f64>();
            is_so.then_some(time_s + lasts_s)
        };
        let slip = begins(self.slip.1, SLIPS_PER_S, SLIP_S);
        let blind = begins(self.blind_until_s, BLIND_PER_S, BLIND_S);
        let ghosts = begins(self.ghosts_until_s, GHOSTS_PER_S, GHOSTS_S);
        if let Some(until_s) = slip {
            self.slip = (usize::from(random.random::<bool>()), until_s);
        }
        self.blind_until_s = blind.unwrap_or(self.blind_until_s);
        self.ghosts_until_s = ghosts.unwrap_or(self.ghosts_until_s);
    }

    /// Turns both wheels for one step, and moves by what they do.
    fn roll(&mut self, time_s: f64) {
        let [speed_m_s, rate_rad_s] = self.command;
        let half_turn_m_s = rate_rad_s * WHEEL_BASE_M / 2.0;
        let mut over_floor_m_s = [0.0; 2];
        for (wheel, asked_m_s) in
            [speed_m_s - half_turn_m_s, speed_m_s + half_turn_m_s].into_iter().enumerate()
        {
            let speed_m_s = self.speeds_m_s[wheel];
            self.speeds_m_s[wheel] = self.motor.turned_m_s(speed_m_s, asked_m_s, STEP_S);
            over_floor_m_s[wheel] = self.speeds_m_s[wheel] * self.wheels[wheel];
        }
        let (slipping, until_s) = self.slip;
        if until_s > time_s {
            over_floor_m_s[slipping] *= GRIP;
        }
        let [left_m_s, right_m_s] = over_floor_m_s;
        let turn_rad = (1.0 - SCRUB) * (right_m_s - left_m_s) / WHEEL_BASE_M * STEP_S;
        let way_m = f64::midpoint(left_m_s, right_m_s) * STEP_S;
        self.pose = moved(self.pose, way_m, turn_rad);
    }
}

fn poses_of(robots: &[Robot]) -> Vec<[f64; 3]> {
    robots.iter().map(|robot| robot.pose).collect()
}

/// A robot looks, and obeys one of its two commands from then on.
fn decide(robots: &mut [Robot], robot: usize, task: &Drive, time_s: f64, random: &mut ChaCha8Rng) {
    let range_m = RANGE_M + RANGE_SD_M * normal(random);
    let is_seen =
        nearest_m(&poses_of(robots), robot, RADIUS_M, RADIUS_M, HALF_ANGLE_RAD) <= range_m;
    let period_s = PERIOD_S + JITTER_S * normal(random);
    let state = &mut robots[robot];
    state.detects =
        if state.blind_until_s > time_s { false } else { is_seen || state.ghosts_until_s > time_s };
    state.command = if state.detects { task.seen } else { task.unseen };
    state.next_decision_s += period_s;
}
