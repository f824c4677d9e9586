//! Simulated robots drive what real ones drove.

use rsrs_core::conditions::Conditions;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::trials::trial::DrivenTrial;

use super::{Kind, Path};
use crate::world::World;

/// Sends the commands of trials to worlds of one robot.
pub struct Driver<'a> {
    robot: &'a RobotProfile,
    /// Mean gains that the conditions have.
    speed_gain: f64,
    turn_gain: f64,
    period_s: f64,
    /// Steps of standing still before each drive.
    n_rest: usize,
}

impl<'a> Driver<'a> {
    /// A driver for worlds under these conditions.
    pub fn new(robot: &'a RobotProfile, conditions: &Conditions) -> Self {
        let period_s = conditions.period_s;
        // After five time constants a turn has died down to less than 1 %, and a calm has become
        // as gusty as it gets.
        let longest_s = if conditions.robot.gust_sd_m_s > 0.0 {
            conditions.robot.gust_time_constant_s.max(conditions.robot.yaw_lag_s)
        } else {
            conditions.robot.yaw_lag_s
        };
        Self {
            robot,
            speed_gain: conditions.robot.speed_gain.mean,
            turn_gain: conditions.robot.turn_gain.mean,
            period_s,
            n_rest: (5.0 * longest_s / period_s).ceil() as usize,
        }
    }

    /// Drives every kind as often as a real robot did, one drive after the other.
    ///
    /// # Returns
    ///
    /// Displacements at the horizons of each kind; shape `[n_kinds][n_repeats][n_horizons]`.
    pub fn all(&self, world: &mut World, kinds: &[Kind]) -> Vec<Vec<Path>> {
        let kind = |kind: &Kind| {
            let once = |_| {
                for _ in 0..self.n_rest {
                    step(world, Command::STOP);
                }
                self.once(world, kind.longest, &kind.horizons_s)
            };
            (0..kind.n_repeats).map(once).collect()
        };
        kinds.iter().map(kind).collect()
    }

    fn once(&self, world: &mut World, trial: &DrivenTrial, horizons_s: &[f64]) -> Path {
        // What was going when it was seen first had come up to its turning rate.
        for _ in 0..libm::round(trial.going_s / self.period_s) as usize {
            step(world, self.as_at_reference(trial.command_at(0.0)));
        }
        let start = pose(world);
        let (mut before, mut now) = (start, start);
        let mut path = Vec::with_capacity(horizons_s.len());
        let mut n_steps = 0_u32;
        for horizon_s in horizons_s {
            while f64::from(n_steps) * self.period_s < *horizon_s {
                let command = trial.command_at(f64::from(n_steps) * self.period_s);
                step(world, self.as_at_reference(command));
                before = now;
                now = unwrapped(pose(world), before.heading_rad);
                n_steps += 1;
            }
            let late = f64::from(n_steps) - horizon_s / self.period_s;
            path.push(displacement(start, between(now, before, late)));
        }
        path
    }

    /// The world's mean gains are those at one command; this command makes them those at its own.
    fn as_at_reference(&self, command: Command) -> Command {
        let actuation = &self.robot.actuation;
        let speed = actuation.speed.gain_at(command.speed_m_s.abs()).mean / self.speed_gain;
        let turn = actuation.turn.gain_at(command.turn_rate_rad_s.abs(), command.speed_m_s).mean;
        Command {
            speed_m_s: command.speed_m_s * speed,
            turn_rate_rad_s: command.turn_rate_rad_s * (turn / self.turn_gain),
        }
    }
}

fn step(world: &mut World, command: Command) {
    world.sense();
    world.advance(&[command]);
}

fn pose(world: &World) -> Pose {
    world.poses().next().expect("a world of one robot has its pose")
}

/// The heading that looks the same and is nearest to the one before.
fn unwrapped(pose: Pose, before_rad: f64) -> Pose {
    let turns = ((pose.heading_rad - before_rad) / std::f64::consts::TAU).round();
    Pose { heading_rad: pose.heading_rad - turns * std::f64::consts::TAU, ..pose }
}

/// A pose some share of the way from one to another.
fn between(from: Pose, to: Pose, share: f64) -> Pose {
    let mix = |from: f64, to: f64| from + share * (to - from);
    Pose {
        x_m: mix(from.x_m, to.x_m),
        y_m: mix(from.y_m, to.y_m),
        heading_rad: mix(from.heading_rad, to.heading_rad),
    }
}

/// A pose in the frame of another.
fn displacement(start: Pose, pose: Pose) -> Pose {
    let (sine, cosine) = libm::sincos(start.heading_rad);
    let (dx_m, dy_m) = (pose.x_m - start.x_m, pose.y_m - start.y_m);
    Pose {
        x_m: dx_m * cosine + dy_m * sine,
        y_m: dy_m * cosine - dx_m * sine,
        heading_rad: pose.heading_rad - start.heading_rad,
    }
}
