//! Robots of several classes segregate here as in a world that was written in Python from the documentation, and moves
//! bodies apart in another way.

use std::path::Path;
use std::process::Command as Process;

use rsrs_core::conditions::{Arena, Conditions, Placement, Walls};
use rsrs_core::judge::order::{OrderParameters, Parameter};
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::state_machine::{Row, StateMachine};
use rsrs_core::robot::controller::{Command, Controller};
use rsrs_core::robot::profile::Sees;
use rsrs_core::robot::region::Region;
use rsrs_core::robot::sensor::{Detects, Reading, SensorDetails};
use rsrs_core::world::{RobotClass, WorldFile};
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use rsrs_testing::python;
use serde_json::json;

use crate::support::perfect_flockbots;

/// Greatest speed of a wheel in metres per second, and distance of the wheels in metres.
const WHEEL_M_S: f64 = 0.2;
const AXLE_M: f64 = 0.14;
const ROBOT_M: f64 = 0.085;
const ROBOTS: usize = 12;
const CLASSES: usize = 3;
const HALF_ANGLE_RAD: f64 = 0.35;
const RANGE_M: f64 = 2.0;
const SIDE_M: f64 = 3.0;
const BOX_M: f64 = 1.8;
const PERIOD_S: f64 = 0.1;
/// How far apart bodies of one cluster are at most, in metres.
const APART_M: f64 = 0.05;
const TIMES_S: [f64; 4] = [0.0, 20.0, 60.0, 120.0];
const RUNS: u64 = 40;
/// By how much two means may differ besides chance.
const POINTS: f64 = 0.02;

/// What a robot on two wheels does when these turn at shares of their greatest speed.
fn wheels(left: f64, right: f64) -> Command {
    Command {
        speed_m_s: WHEEL_M_S * f64::midpoint(left, right),
        turn_rate_rad_s: WHEEL_M_S * (right - left) / AXLE_M,
    }
}

/// Where nothing is seen, kin, and another robot: those of P. Mitrano et al., MRS 2019.
fn commands() -> [Command; 3] {
    [wheels(-1.0, 1.0 / 3.0), wheels(1.0 / 3.0, 1.0), wheels(-1.0, 1.0)]
}

fn foot_bots() -> Conditions {
    let mut conditions = perfect_flockbots();
    conditions.robots = ROBOTS;
    conditions.placement = Placement::BoxFacingAnyWay { width_m: BOX_M, height_m: BOX_M };
    conditions.arena = Arena { side_m: SIDE_M, walls: Walls::Clamp };
    let class = |place: usize| RobotClass { name: format!("class_{place}"), count: None };
    let classes = (0..CLASSES).map(class).collect();
    conditions.world = WorldFile { classes, ..WorldFile::NOTHING };
    conditions.period_s = PERIOD_S;
    let robot = &mut conditions.robot;
    robot.radius_m = ROBOT_M;
    robot.contact = ContactModel::Push;
    robot.sees = Sees::Centre;
    robot.region = Region::Cone { half_angle_rad: HALF_ANGLE_RAD, range_m: RANGE_M };
    robot.details = SensorDetails {
        detects: Detects::Kin,
        hidden_by: vec![Detects::Robot],
        or: vec![Reading {
            name: "other".to_owned(),
            detects: Detects::Other,
            true_positive: 1.0,
            false_positive: 0.0,
            taken_for: [].into(),
        }],
        ..SensorDetails::default()
    };
    let [nothing, kin, other] = commands();
    let row = |when: &[(&str, bool)], command| Row {
        state: "start".to_owned(),
        when: when.iter().map(|(name, is_true)| ((*name).to_owned(), *is_true)).collect(),
        command,
        next: Vec::new(),
    };
    conditions.controller = Controller::Machine(StateMachine {
        rows: vec![
            row(&[("detection", true)], kin),
            row(&[("other", true)], other),
            row(&[], nothing),
        ],
        numbers: [].into(),
        starts: [].into(),
        sensors: conditions.robot.reading_names(),
    });
    conditions.check().expect("they make a world");
    conditions
}

/// Mean and standard error of the share of a class in its largest cluster at each time.
fn ours(conditions: &Conditions) -> Vec<(f64, f64)> {
    let segregated = Parameter::from_key("segregated").expect("it is in the table");
    let bodies = conditions.bodies();
    let of_run = |replicate| {
        let last_s = TIMES_S[TIMES_S.len() - 1] + PERIOD_S;
        let run = run_episode(conditions, Seed { seed: 7, replicate }, last_s).expect("they fit");
        TIMES_S.map(|time_s| {
            let sample = (time_s / PERIOD_S).round() as usize;
            let window = sample..sample + 1;
            segregated.of(&OrderParameters::with(&run, window, &bodies, &[segregated]))
        })
    };
    let runs: Vec<[f64; 4]> = (0..RUNS).map(of_run).collect();
    let n = RUNS as f64;
    (0..TIMES_S.len())
        .map(|time| {
            let mean = runs.iter().map(|run| run[time]).sum::<f64>() / n;
            let squares: f64 = runs.iter().map(|run| (run[time] - mean).powi(2)).sum();
            (mean, (squares / (n - 1.0) / n).sqrt())
        })
        .collect()
}

#[test]
fn classes_segregate_as_in_another_world_that_shares_no_code() {
    let conditions = foot_bots();
    let commands = commands();
    let described = json!({
        "robots": ROBOTS, "classes": CLASSES, "runs": RUNS, "robot_m": ROBOT_M, "box_m": BOX_M,
        "side_m": SIDE_M, "period_s": PERIOD_S, "half_angle_rad": HALF_ANGLE_RAD,
        "range_m": RANGE_M, "apart_m": APART_M, "times_s": TIMES_S,
        "speeds_m_s": commands.map(|it| it.speed_m_s),
        "turn_rates_rad_s": commands.map(|it| it.turn_rate_rad_s),
    });
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("segregation.json");
    std::fs::write(&file, described.to_string()).expect("the target directory can be written");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/physics/segregation.py");

    let ours = ours(&conditions);
    let python = python::python_with(&python::SCIENCE);
    let printed = python::must_run(Process::new(python).arg(script).arg(&file));
    let theirs: Vec<(f64, f64)> = serde_json::from_str(&printed).expect("a list of pairs");

    for (time_s, ((our_mean, our_error), (their_mean, their_error))) in
        TIMES_S.into_iter().zip(ours.iter().zip(&theirs))
    {
        let most = POINTS + 4.0 * libm::hypot(*our_error, *their_error);
        assert!((our_mean - their_mean).abs() < most, "{time_s} s: {ours:?} {theirs:?}");
    }
    assert!(ours[3].0 > ours[0].0 + 0.1, "they segregate: {ours:?}");
}
