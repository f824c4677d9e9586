//! Simulated robots that are measured: the fit gives back what they were simulated with, with intervals
//! that cover it.
//!
//! Of 500 populations a coverage of 95 % has a standard error of 1 %.

use rsrs_core::conditions::{Conditions, Settings, Walls};
use rsrs_core::quantity::Axis;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::profile::{RobotProfile, TurnGain};
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::statistics::variance::Estimate;
use rsrs_core::trials::fit::yaw_lag;
use rsrs_core::trials::trial::{DrivenSample, DrivenTrial, reduced};
use rsrs_sim::draw::Seed;
use rsrs_sim::world::World;

use rsrs_testing::conditions::flockbot;
const N_POPULATIONS: u64 = 500;
const N_ROBOTS: u64 = 5;
const N_TRIALS: usize = 3;
const N_STEPS: usize = 90;
const IN_PLACE: Command = Command { speed_m_s: 0.0, turn_rate_rad_s: 0.75 };
const ARC: Command = Command { speed_m_s: 0.15, turn_rate_rad_s: 0.75 };

/// A Flockbot whose turning rate lags, and that turns less while it drives.
fn robot(yaw_lag_s: f64) -> RobotProfile {
    let mut profile = flockbot();
    profile.actuation.turn.gain_by_command = vec![TurnGain { commanded_rad_s: 0.75, mean: 0.915 }];
    profile.actuation.turn.driving_gain_by_command =
        Some(vec![TurnGain { commanded_rad_s: 0.75, mean: 0.884 }]);
    profile.actuation.turn.heading_noise_sd_rad = 0.003;
    profile.actuation.yaw_lag_s = yaw_lag_s;
    profile
}

fn conditions(profile: &RobotProfile, command: Command) -> Conditions {
    let values = vec![
        (Axis::Speed, command.speed_m_s),
        (Axis::TurnRate, command.turn_rate_rad_s),
        (Axis::Robots, 1.0),
    ];
    let settings = Settings { values, walls: Walls::None, ..Settings::default() };
    Conditions::resolve(profile, &settings).expect("it can be simulated")
}

/// Trials of one command by all robots of a population, each from a standstill.
fn population(profile: &RobotProfile, command: Command, seed: u64) -> Vec<DrivenTrial> {
    let conditions = conditions(profile, command);
    let mut trials = Vec::new();
    for robot in 0..N_ROBOTS {
        let seed = Seed { seed, replicate: robot };
        let mut world = World::new(&conditions, seed).expect("one robot has room");
        for trial in 0..N_TRIALS {
            for _ in 0..40 {
                step(&mut world, Command::STOP);
            }
            trials.push(DrivenTrial {
                robot: format!("robot_{robot}"),
                trial: trial.to_string(),
                going_s: 0.0,
                samples: driven(&mut world, command, conditions.period_s),
            });
        }
    }
    trials
}

fn step(world: &mut World, command: Command) {
    world.sense();
    world.advance(&[command]);
}

fn driven(world: &mut World, command: Command, period_s: f64) -> Vec<DrivenSample> {
    let mut before_rad = 0.0;
    let mut samples = Vec::with_capacity(N_STEPS + 1);
    for sample in 0..=N_STEPS {
        let pose = world.poses().next().expect("one robot");
        let turns = ((pose.heading_rad - before_rad) / std::f64::consts::TAU).round();
        before_rad = pose.heading_rad - turns * std::f64::consts::TAU;
        let pose = Pose { heading_rad: before_rad, ..pose };
        samples.push(DrivenSample {
            time_s: sample as f64 * period_s,
            pose,
            command,
            object_m: None,
        });
        step(world, command);
    }
    samples
}

fn holds(estimate: Estimate, truth: f64) -> bool {
    let bounds = (estimate.low.expect("five robots"), estimate.high.expect("five robots"));
    bounds.0 <= truth && truth <= bounds.1
}

#[test]
fn gains_of_arcs_and_the_lag_of_the_turning_rate_are_fitted_with_intervals_that_cover() {
    let lag_s = 0.5;
    let profile = robot(lag_s);
    let (mut covers_arc, mut covers_lag, mut certain) = (0, 0, 0);
    for seed in 0..N_POPULATIONS {
        let arcs = population(&profile, ARC, 10_000 + seed);
        let period_s = profile.computation.period_s;

        let lag = yaw_lag(&arcs, period_s).expect("they turn");
        // What a stopwatch sees once the turn is under way.
        let under_way: Vec<DrivenTrial> = arcs
            .iter()
            .map(|trial| DrivenTrial { samples: trial.samples[30..].to_vec(), ..trial.clone() })
            .collect();
        let arc = reduced("arcs", &under_way).arc;
        let gains: Vec<f64> = (0..arc.robots.len())
            .map(|robot| {
                let of_robot = arc.rows.iter().filter(|row| row.robot == robot);
                let gains: Vec<f64> = of_robot
                    .map(|row| row.turn.angle_rad / row.turn.duration_s / row.turn.commanded_rad_s)
                    .collect();
                gains.iter().sum::<f64>() / gains.len() as f64
            })
            .collect();

        covers_arc += u64::from(holds(Estimate::of_mean(&gains), 0.884));
        covers_lag += u64::from(holds(lag.lag_s, lag_s));
        certain += u64::from(lag.is_certain());
    }

    for (what, n_covering) in [("arcs", covers_arc), ("lag", covers_lag)] {
        assert!((465..=490).contains(&n_covering), "{what}: {n_covering} of {N_POPULATIONS}");
    }
    assert_eq!(certain, N_POPULATIONS, "half a second is no chance");
}

#[test]
fn robots_without_a_lag_are_not_reported_to_have_one() {
    let profile = robot(0.0);
    let mut certain = 0;
    for seed in 0..N_POPULATIONS {
        let turns = population(&profile, IN_PLACE, 20_000 + seed);

        let lag = yaw_lag(&turns, profile.computation.period_s).expect("they turn");

        certain += u64::from(lag.is_certain());
    }

    // An interval of 95 % misses on one side in 2.5 %, 12 of 500 with a standard error of 3.5.
    assert!(certain <= 23, "{certain} of {N_POPULATIONS}");
}

#[test]
fn robots_turn_by_the_gain_of_arcs_while_they_drive_and_by_the_other_in_place() {
    let mut profile = robot(0.0);

    let gain = |profile: &RobotProfile, command| conditions(profile, command).robot.turn_gain.mean;
    assert_eq!((gain(&profile, IN_PLACE), gain(&profile, ARC)), (0.915, 0.884));
    let harsher =
        rsrs_core::robot::harsher::HarsherFactors::default().apply(&profile).expect("harsher");
    assert_eq!((gain(&harsher, IN_PLACE), gain(&harsher, ARC)), (0.915, 0.884));
    profile.actuation.turn.driving_gain_by_command = None;
    assert_eq!((gain(&profile, IN_PLACE), gain(&profile, ARC)), (0.915, 0.915));
}
