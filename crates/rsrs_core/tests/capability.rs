//! The order of capabilities: the simulated robot is nowhere better than the measured one.

use rsrs_core::capability::{sensor_violations, violations};
use rsrs_core::conditions::{Conditions, Settings};
use rsrs_core::diagram::sweep_file::SweepFile;
use rsrs_core::quantity::{Axis, Worse};
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::profile::{RobotProfile, Sees};
use rsrs_core::robot::region::Region;
use rsrs_core::trials::fit::{Rate, SensorMap, SensorPoint};

const SWEEP: &str = include_str!("../../../launch_configs/sweeps/flockbot_speed_turn.yaml");
const PROFILES: [&str; 3] = [
    rsrs_testing::conditions::FLOCKBOT,
    include_str!("../../../launch_configs/profiles/smars.yaml"),
    include_str!("../../../launch_configs/profiles/lta.yaml"),
];

fn profile(text: &str) -> RobotProfile {
    RobotProfile::parse("p.yaml", text).expect("the profiles that ship are valid")
}

/// The cells of a sweep for robots that may be commanded anything.
fn cells(measured: &RobotProfile, sweep: &str) -> Vec<Conditions> {
    let mut measured = measured.clone();
    measured.actuation.speed.limits_m_s = [0.01, 1.0];
    measured.actuation.turn.limits_rad_s = [0.05, 5.0];
    let sweep = SweepFile::parse("s.yaml", sweep).expect("the sweep that ships is valid");
    let cells = sweep.resolve("s.yaml", &measured).expect("it can be simulated");
    cells.into_iter().map(|(_, conditions)| conditions).collect()
}

#[test]
fn the_default_factors_make_every_robot_of_ours_worse_in_every_cell() {
    for text in PROFILES {
        let measured = profile(text);
        for conditions in cells(&measured, SWEEP) {
            assert_eq!(violations(&measured, &conditions).unwrap(), []);
        }
    }
}

#[test]
fn each_better_capability_is_named() {
    let measured = profile(PROFILES[0]);
    let as_measured = cells(&measured, SWEEP)[0].clone();
    let named = |change: fn(&mut Conditions)| -> Vec<String> {
        let mut conditions = as_measured.clone();
        change(&mut conditions);
        let found = violations(&measured, &conditions).unwrap();
        found.into_iter().map(|violation| violation.capability.into_owned()).collect()
    };

    assert_eq!(named(|_| ()), Vec::<&str>::new());
    assert_eq!(named(|c| c.robot.true_positive = 0.99), ["true positive rate"]);
    assert_eq!(named(|c| c.robot.false_positive = 0.06), ["false positive rate"]);
    assert_eq!(named(|c| c.robot.speed_gain.robot_sd = 0.01), ["speed gain, sd between robots"]);
    assert_eq!(named(|c| c.robot.turn_gain.robot_sd = 0.01), ["turn gain, sd between robots"]);
    assert_eq!(named(|c| c.robot.speed_gain.mean = 1.0), ["gain of the speed"]);
    assert_eq!(named(|c| c.robot.turn_gain.mean = 1.1), ["gain of the turning rate"]);
    assert_eq!(named(|c| c.period_s = 0.1), ["control period (s)"]);
    assert_eq!(
        named(|c| c.robot.region = Region::Cone { half_angle_rad: 0.2, range_m: 0.8 }),
        ["sensing region"]
    );
    assert_eq!(named(|c| c.robot.sees = Sees::Centre), Vec::<&str>::new());
    let contact = "what robots do when they touch";
    assert_eq!(named(|c| c.robot.contact = ContactModel::Push), [contact]);
}

#[test]
fn each_capability_is_compared_in_the_direction_of_its_row() {
    let mut pushing = profile(PROFILES[0]);
    (pushing.body.contact, pushing.body.contact_friction) = (ContactModel::Push, Some(0.3));
    let imperfect = [
        (Axis::TruePositive, 0.9),
        (Axis::LatencySteps, 2.0),
        (Axis::Gust, 0.02),
        (Axis::YawLag, 0.2),
        (Axis::GainNoise, 0.02),
        (Axis::SpeedGain, 0.9),
        (Axis::TurnGain, 1.1),
        (Axis::TurnBias, 0.02),
        (Axis::HeadingNoise, 0.02),
    ];
    let measured = pushing.with_capabilities(&imperfect).unwrap();
    let values = vec![(Axis::Speed, 0.15), (Axis::TurnRate, 0.75), (Axis::Robots, 9.0)];
    let settings = Settings { values, ..Settings::default() };
    let found = |axis: Axis, value: f64| {
        let robot = measured.with_capabilities(&[(axis, value)]).unwrap();
        violations(&measured, &Conditions::resolve(&robot, &settings).unwrap()).unwrap()
    };
    let directions = Axis::ALL.into_iter().filter_map(|axis| Some((axis, axis.worse()?)));

    for (axis, direction) in directions {
        let now = measured.capability(axis).unwrap();
        let [better, worse] = match direction {
            Worse::More => [0.5 * now, 1.5 * now],
            Worse::Less => [1.1 * now, 0.9 * now],
            Worse::FartherFromOne => [1.0, 1.0 + 1.5 * (now - 1.0)],
        };

        assert_ne!(found(axis, better), [], "{axis} of {better}");
        assert_eq!(found(axis, worse), [], "{axis} of {worse}");
    }
}

#[test]
fn more_friction_of_bodies_that_push_is_worse() {
    let mut measured = profile(PROFILES[0]);
    (measured.body.contact, measured.body.contact_friction) = (ContactModel::Push, Some(0.3));
    let mut conditions = cells(&measured, SWEEP)[0].clone();
    let mut is_better = |friction: f64| {
        conditions.robot.contact_friction = friction;
        let found = violations(&measured, &conditions).unwrap();
        found.iter().any(|violation| violation.capability == "friction of bodies that push")
    };

    assert_eq!([0.2, 0.3, 0.4].map(&mut is_better), [true, false, false]);
}

#[test]
fn a_region_is_held_against_another_shape() {
    let mut measured = profile(PROFILES[1]);
    let polygon = vec![[0.1, -0.1], [0.5, -0.1], [0.5, 0.1], [0.1, 0.1]];
    measured.sensing.polygon_m = Some(polygon.clone());
    let mut conditions = cells(&measured, SWEEP)[0].clone();
    let is_named = |conditions: &Conditions| {
        let found = violations(&measured, conditions).unwrap();
        found.iter().any(|violation| violation.capability == "sensing region")
    };

    assert!(!is_named(&conditions));
    conditions.robot.region =
        Region::Polygon { corners_m: polygon.iter().map(|[x, y]| [x * 1.01, *y]).collect() };
    assert!(is_named(&conditions));
    conditions.robot.region = Region::Cone { half_angle_rad: 0.1, range_m: 0.4 };
    assert!(is_named(&conditions), "its tip is nearer than 0.1 m");
}

#[test]
fn the_text_contains_both_numbers() {
    let measured = profile(PROFILES[0]);
    let mut conditions = cells(&measured, SWEEP)[0].clone();
    conditions.robot.true_positive = 0.99;

    let found = violations(&measured, &conditions).unwrap();

    insta::assert_snapshot!(found[0], @"true positive rate: simulated 0.99, measured 0.98; expected the simulated robot to be at most as capable, so the same or less");
}

fn map(hits: u64, alarms: u64) -> SensorMap {
    let node =
        |distance_m, hits| SensorPoint { distance_m, bearing_rad: 0.0, rate: Rate::new(hits, 100) };
    SensorMap {
        nodes: vec![node(0.3, hits), node(2.0, 0)],
        contour_m: Vec::new(),
        polygon_m: Vec::new(),
        true_positive: Rate::new(hits, 100),
        false_positive: Rate::new(alarms, 1000),
        reach: Vec::new(),
        left_out_rad: Vec::new(),
        outermost_rad: Vec::new(),
    }
}

#[test]
fn detections_are_held_against_the_simulated_sensor() {
    let robot = &cells(&profile(PROFILES[0]), SWEEP)[0].robot;

    assert_eq!(sensor_violations(&map(98, 65), robot), []);
    assert_eq!(sensor_violations(&map(75, 85), robot), [], "chance");
    let found = sensor_violations(&map(60, 130), robot);
    insta::assert_snapshot!(found[0], @"at 0.3 m, 0 rad the robots detected 60 of 100 (at most 0.697), the simulated robot detects 0.8");
    insta::assert_snapshot!(found[1], @"without a neighbour the robots detected 130 of 1000 (at least 0.1098), the simulated robot detects 0.07995");
}
