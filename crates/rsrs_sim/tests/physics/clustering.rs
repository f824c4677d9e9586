//! Robots that cluster objects do here what they do in a world that was written in Python from the documentation,
//! and moves bodies apart in another way.

use std::path::Path;
use std::process::Command as Process;

use rsrs_core::conditions::{Arena, Conditions, Placement, Walls};
use rsrs_core::judge::order::{OrderParameters, Parameter};
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::state_machine::{Row, StateMachine};
use rsrs_core::robot::controller::{Command, Controller};
use rsrs_core::robot::region::Region;
use rsrs_core::robot::sensor::{Detects, Reading, SensorDetails};
use rsrs_core::world::{ObjectGroup, WorldFile};
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use rsrs_testing::python;
use serde_json::json;

use crate::support::perfect_flockbots;

/// Greatest speed of a wheel in metres per second, and distance of the wheels in metres.
const WHEEL_M_S: f64 = 0.128;
const AXLE_M: f64 = 0.051;
const ROBOT_M: f64 = 0.037;
const OBJECT_M: f64 = 0.05;
const ROBOTS: usize = 5;
const OBJECTS: usize = 20;
const RANGE_M: f64 = 3.0;
const SIDE_M: f64 = 3.0;
const BOX_M: f64 = 2.8;
const PERIOD_S: f64 = 0.1;
const TIMES_S: [f64; 4] = [0.0, 60.0, 120.0, 240.0];
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

/// Where nothing is seen, a robot, and an object.
fn commands() -> [Command; 3] {
    [wheels(0.5, 1.0), wheels(0.1, 0.5), wheels(1.0, 0.5)]
}

fn e_pucks() -> Conditions {
    let mut conditions = perfect_flockbots();
    conditions.robots = ROBOTS;
    conditions.placement = Placement::BoxFacingAnyWay { width_m: BOX_M, height_m: BOX_M };
    conditions.arena = Arena { side_m: SIDE_M, walls: Walls::Clamp };
    let objects =
        ObjectGroup { count: Some(OBJECTS), places_m: None, radius_m: OBJECT_M, friction: 0.0 };
    conditions.world = WorldFile { objects: vec![objects], ..WorldFile::NOTHING };
    conditions.period_s = PERIOD_S;
    let robot = &mut conditions.robot;
    robot.radius_m = ROBOT_M;
    robot.contact = ContactModel::Push;
    robot.region = Region::Cone { half_angle_rad: 0.0, range_m: RANGE_M };
    robot.details = SensorDetails {
        hidden_by: vec![Detects::Robot, Detects::Object],
        or: vec![Reading {
            name: "object".to_owned(),
            detects: Detects::Object,
            true_positive: 1.0,
            false_positive: 0.0,
            taken_for: [].into(),
        }],
        ..SensorDetails::default()
    };
    let [nothing, robot, object] = commands();
    let row = |when: &[(&str, bool)], command| Row {
        state: "start".to_owned(),
        when: when.iter().map(|(name, is_true)| ((*name).to_owned(), *is_true)).collect(),
        command,
        next: Vec::new(),
    };
    conditions.controller = Controller::Machine(StateMachine {
        rows: vec![
            row(&[("object", true)], object),
            row(&[("detection", true)], robot),
            row(&[], nothing),
        ],
        numbers: [].into(),
        starts: [].into(),
        sensors: conditions.robot.reading_names(),
    });
    conditions.check().expect("they make a world");
    conditions
}

/// Mean and standard error of the share of objects in the largest cluster at each time.
fn ours(conditions: &Conditions) -> Vec<(f64, f64)> {
    let clustered = Parameter::from_key("objects_clustered").expect("it is in the table");
    let bodies = conditions.bodies();
    let of_run = |replicate| {
        let last_s = TIMES_S[TIMES_S.len() - 1] + PERIOD_S;
        let run = run_episode(conditions, Seed { seed: 7, replicate }, last_s).expect("they fit");
        TIMES_S.map(|time_s| {
            let sample = (time_s / PERIOD_S).round() as usize;
            clustered.of(&OrderParameters::with(&run, sample..sample + 1, &bodies, &[clustered]))
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
fn objects_are_clustered_as_in_another_world_that_shares_no_code() {
    let conditions = e_pucks();
    let commands = commands();
    let described = json!({
        "robots": ROBOTS, "objects": OBJECTS, "runs": RUNS, "robot_m": ROBOT_M,
        "object_m": OBJECT_M, "box_m": BOX_M, "side_m": SIDE_M, "period_s": PERIOD_S,
        "range_m": RANGE_M, "times_s": TIMES_S,
        "speeds_m_s": commands.map(|it| it.speed_m_s),
        "turn_rates_rad_s": commands.map(|it| it.turn_rate_rad_s),
    });
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("clustering.json");
    std::fs::write(&file, described.to_string()).expect("the target directory can be written");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/physics/clustering.py");

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
    assert!(ours[3].0 > ours[0].0 + 0.05, "they gather: {ours:?}");
}
