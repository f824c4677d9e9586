//! Conditions that the tests share: nine Flockbots, without the gain table and the provenance of
//! their profile.

use std::sync::atomic::AtomicBool;

use rsrs_core::conditions::{Conditions, GainDistribution, Placement};
use rsrs_core::judge::phase::{self, Verdict};
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::{Command, ControllerParameters};
use rsrs_core::robot::sensor::Readings;
use rsrs_core::robot::unicycle::Pose;

use rsrs_sim::batch::Batch;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use rsrs_sim::sweep::{Runs, Swept, Watch, sweep};
use rsrs_sim::world::World;

use rsrs_testing::conditions::flockbot_conditions;
use rsrs_testing::draw::Draw;

pub const SEED: Seed = Seed { seed: 1, replicate: 0 };

/// A robot's imperfections: standard deviation of both gains, detection, false positives.
pub struct Imperfection {
    pub gain_sd: f64,
    pub true_positive: f64,
    pub false_positive: f64,
}

pub const PERFECT: Imperfection =
    Imperfection { gain_sd: 0.0, true_positive: 1.0, false_positive: 0.0 };

pub const HARSHER: Imperfection =
    Imperfection { gain_sd: 0.05, true_positive: 0.80, false_positive: 0.08 };

/// Nine Flockbots at a speed and turning rate, placed in a disc of 0.825 m.
pub fn flockbots(speed_m_s: f64, turn_rate_rad_s: f64, imperfection: &Imperfection) -> Conditions {
    let mut conditions = flockbot_conditions();
    let usual = conditions.robot.speed_gain;
    let gain = GainDistribution { robot_sd: imperfection.gain_sd, ..usual };
    conditions.controller = ControllerParameters::mirrored(speed_m_s, turn_rate_rad_s).into();
    (conditions.robot.speed_gain, conditions.robot.turn_gain) = (gain, gain);
    conditions.robot.true_positive = imperfection.true_positive;
    conditions.robot.false_positive = imperfection.false_positive;
    conditions
}

pub fn at(x_m: f64, y_m: f64, heading_rad: f64) -> Pose {
    Pose { x_m, y_m, heading_rad }
}

/// Robots without noise at given poses.
pub fn perfect_at(poses: Vec<Pose>) -> Conditions {
    let mut conditions = flockbots(0.15, 0.75, &PERFECT);
    conditions.robots = poses.len();
    conditions.placement = Placement::Given { starts: vec![poses] };
    conditions
}

/// The same that follow commands exactly, with a kind of contact.
pub fn exact(contact: ContactModel, poses: Vec<Pose>) -> Conditions {
    let mut conditions = perfect_at(poses);
    conditions.robot.contact = contact;
    conditions.robot.speed_gain.mean = 1.0;
    conditions.robot.turn_gain.mean = 1.0;
    conditions
}

/// A command that drives so far in a step, straight ahead.
pub fn drive(way_m: f64) -> Command {
    Command { speed_m_s: way_m / 0.13, turn_rate_rad_s: 0.0 }
}

/// A world after steps of these commands, whatever the robots see.
pub fn driven(conditions: &Conditions, commands: &[Command], n_steps: usize) -> World {
    conditions.check().expect("it makes a world");
    let mut world = World::new(conditions, SEED).expect("they are there");
    for _ in 0..n_steps {
        world.sense();
        world.advance(commands);
    }
    world
}

/// What each robot reports at the start: the names of its readings that are true.
pub fn reported(conditions: &Conditions) -> Vec<Vec<String>> {
    conditions.check().expect("a world");
    let names = conditions.robot.reading_names();
    let mut world = World::new(conditions, SEED).expect("they fit");
    let of_robot = |readings: &Readings| {
        let names = names.iter().enumerate().filter(|(place, _)| readings.has(*place));
        names.map(|(_, name)| name.to_owned()).collect()
    };
    world.sense_all().iter().map(of_robot).collect()
}

/// Sweeps without an observer.
pub fn quietly(conditions: &[Conditions], runs: Runs) -> Swept {
    let watch = Watch { progress: &|_| {}, cancel: &AtomicBool::new(false) };
    sweep(conditions, runs, watch).expect("the robots fit and the runs are long enough")
}

/// What the judge says of a run in the reference world.
pub fn judged_by_reference(conditions: &Conditions, seed: Seed, duration_s: f64) -> Verdict {
    let trajectory = run_episode(conditions, seed, duration_s).expect("the robots fit");
    let rules = conditions.behaviour.rules();
    phase::label_with(&trajectory, &conditions.bodies(), &rules).expect("long enough")
}

/// Holds that runs of two minutes are judged, wherever they are simulated, as those of the reference are.
pub fn assert_judged_alike(conditions: &Conditions, replicates: u64) {
    let verdicts = Batch::new().judge(conditions, 1, 0..replicates, 120.0).expect("they fit");
    assert_eq!(verdicts.len() as u64, replicates);
    for (replicate, verdict) in (0..).zip(verdicts) {
        let expected = judged_by_reference(conditions, Seed { seed: 1, replicate }, 120.0);
        assert_eq!(verdict, expected, "{replicate}");
    }
}

/// The digest of a world after 400 steps in which robots turn left where something is detected, and else right.
pub fn steered_digest(conditions: &Conditions) -> String {
    let mut world = World::new(conditions, SEED).expect("they fit");
    for _ in 0..400 {
        let command = |detected: &bool| {
            let turn_rate_rad_s = if *detected { 0.75 } else { -0.75 };
            Command { speed_m_s: 0.15, turn_rate_rad_s }
        };
        let commands: Vec<Command> = world.sense().iter().map(command).collect();
        world.advance(&commands);
    }
    format!("{:016x}", world.digest())
}

/// A crowd in which all robots drive anywhere, step by step.
pub struct Crowd {
    pub conditions: Conditions,
    draw: Draw,
}

impl Crowd {
    pub fn new(conditions: Conditions) -> Self {
        Self { conditions, draw: Draw::new(3) }
    }

    pub fn commands(&mut self) -> Vec<Command> {
        let most_m_s = self.conditions.controller.fastest().speed_m_s;
        let mut command = || Command {
            speed_m_s: most_m_s * (2.0 * self.draw.uniform() - 0.5),
            turn_rate_rad_s: 4.0 * (self.draw.uniform() - 0.5),
        };
        (0..self.conditions.robots).map(|_| command()).collect()
    }
}
