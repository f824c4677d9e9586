//! Simulated robots drive what real ones drove, and push what these pushed.

use rsrs_core::conditions::Conditions;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::trials::trial::DrivenTrial;

use super::{Drives, Kind, Moved, ReachOptions};
use crate::draw::{Purpose, RunKey, Seed, Stream};
use crate::world::World;

/// Where the object is when nobody is to push it: further than a robot drives in any trial.
const ASIDE_M: [f64; 2] = [1e5, 1e5];

/// Sends the commands of trials to worlds of one robot.
pub struct Driver<'a> {
    robot: &'a RobotProfile,
    /// Mean gains that the conditions have.
    speed_gain: f64,
    turn_gain: f64,
    period_s: f64,
    /// Steps of standing still before each drive.
    n_rest: usize,
    /// How far off a tracker may be, in metres and in radians.
    tolerance_m: f64,
    tolerance_rad: f64,
    /// Of the conditions.
    digest: u64,
}

impl<'a> Driver<'a> {
    /// A driver for worlds under these conditions.
    pub fn new(robot: &'a RobotProfile, conditions: &Conditions, options: &ReachOptions) -> Self {
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
            tolerance_m: options.tolerance_m,
            tolerance_rad: options.tolerance_rad,
            digest: conditions.digest(),
        }
    }

    /// Drives every kind as often as a real robot did, one drive after the other, to the
    /// displacements at its horizons.
    pub fn all(&self, world: &mut World, kinds: &[Kind], seed: Seed) -> Drives {
        put_aside(world);
        let mut errors = Stream::new(RunKey::new(seed, self.digest), 0, Purpose::TrackerError);
        let kind = |kind: &Kind| {
            let once = |_| {
                for _ in 0..self.n_rest {
                    step(world, Command::STOP);
                }
                self.once(world, kind, &mut errors)
            };
            (0..kind.n_repeats).map(once).collect()
        };
        kinds.iter().map(kind).collect()
    }

    /// Where the object of a trial may have been at its start, in the frame of the robot's, in metres: ahead, left. A
    /// millimetre decides on which side a robot loses what it pushes, and trackers are off by more.
    fn object_start_m(&self, trial: &DrivenTrial, errors: &mut Stream) -> Option<[f64; 2]> {
        let place_m = trial.object_start_m()?;
        let mut uniform = |most: f64| most * (2.0 * errors.uniform() - 1.0);
        let [x_m, y_m] = [0, 1].map(|_| uniform(self.tolerance_m));
        let seen_from = Pose { x_m, y_m, heading_rad: uniform(self.tolerance_rad) };
        Some(seen_from.place_m(place_m))
    }

    fn once(&self, world: &mut World, kind: &Kind, errors: &mut Stream) -> Moved {
        let Kind { longest: trial, horizons_s, .. } = kind;
        // What was going when it was seen first had come up to its turning rate.
        for _ in 0..libm::round(trial.going_s / self.period_s) as usize {
            step(world, self.as_at_reference(trial.command_at(0.0)));
        }
        let robot = pose(world);
        let object_m = self.object_start_m(trial, errors).map(|place_m| robot.place_m(place_m));
        if let Some(place_m) = object_m {
            world.put_object(0, place_m);
        }
        // The object heads all the time as the robot did at the start.
        let object = |world: &World| {
            let [x_m, y_m] =
                world.objects_m().next().expect("a world with an object has its place");
            Pose { x_m, y_m, ..robot }
        };
        let start: Vec<Pose> = [robot].into_iter().chain(object_m.map(|_| object(world))).collect();
        let (mut before, mut now) = (start.clone(), start.clone());
        let mut moved = vec![Vec::with_capacity(horizons_s.len()); start.len()];
        let mut n_steps = 0_u32;
        for horizon_s in horizons_s {
            while f64::from(n_steps) * self.period_s < *horizon_s {
                let command = trial.command_at(f64::from(n_steps) * self.period_s);
                step(world, self.as_at_reference(command));
                std::mem::swap(&mut before, &mut now);
                now[0] = unwrapped(pose(world), before[0].heading_rad);
                if let Some(now) = now.get_mut(1) {
                    *now = object(world);
                }
                n_steps += 1;
            }
            let late = f64::from(n_steps) - horizon_s / self.period_s;
            for (body, path) in moved.iter_mut().enumerate() {
                path.push(now[body].mixed(before[body], late).relative_to(start[body]));
            }
        }
        put_aside(world);
        moved
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

fn put_aside(world: &mut World) {
    if world.objects_m().next().is_some() {
        world.put_object(0, ASIDE_M);
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
