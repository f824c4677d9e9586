//! Worlds whose robots have several sensors, or one that is not plain.

use rsrs_core::conditions::{Arena, Conditions, Placement, SimulatedSensor, Walls};

use rsrs_core::robot::profile::Sees;
use rsrs_core::robot::region::Region;
use rsrs_core::robot::sensor::{Detects, Reading, SensorDetails};
use rsrs_core::robot::unicycle::Pose;
use rsrs_sim::batch::runs_in_lanes;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::{episode_digests, run_episode};
use rsrs_sim::world::World;
use rsrs_testing::conditions::exact_reading;

use crate::support::{HARSHER, SEED, assert_judged_alike, at, flockbots, perfect_at, reported};

const LINE: Region = Region::Cone { half_angle_rad: 0.0, range_m: 2.0 };
const CONE: Region = Region::Cone { half_angle_rad: 0.2, range_m: 0.75 };

/// Perfect robots at these poses in a square of 4 m.
fn perfect(poses: Vec<Pose>) -> Conditions {
    let arena = Arena { side_m: 4.0, walls: Walls::Stop };
    Conditions { arena, ..perfect_at(poses) }
}

/// A perfect sensor.
fn sensor(name: &str, region: Region, details: SensorDetails) -> SimulatedSensor {
    SimulatedSensor {
        name: name.to_owned(),
        sees: Sees::Body,
        region,
        true_positive: 1.0,
        false_positive: 0.0,
        latency_steps: 0,
        details,
    }
}

fn of_walls() -> SensorDetails {
    SensorDetails { detects: Detects::Wall, ..SensorDetails::default() }
}

fn hidden(details: SensorDetails) -> SensorDetails {
    SensorDetails { hidden_by: vec![Detects::Robot], ..details }
}

/// The robots of [`HARSHER`] with a ternary first sensor, and one to the left that is late.
fn ternary() -> Conditions {
    let mut conditions = flockbots(0.15, 0.75, &HARSHER);
    conditions.arena = Arena { side_m: 3.0, walls: Walls::Stop };
    let robot = &mut conditions.robot;
    robot.region = Region::Cone { half_angle_rad: 0.1, range_m: 1.5 };
    robot.details = hidden(SensorDetails {
        taken_for: [("wall".to_owned(), 0.1)].into(),
        or: vec![Reading {
            name: "wall".to_owned(),
            detects: Detects::Wall,
            true_positive: 0.9,
            false_positive: 0.05,
            taken_for: [("detection".to_owned(), 0.05)].into(),
        }],
        ..SensorDetails::default()
    });
    let square = vec![[0.0, -0.2], [0.4, -0.2], [0.4, 0.2], [0.0, 0.2]];
    let left = SensorDetails { bearing_rad: 1.2, ..SensorDetails::default() };
    robot.further_sensors = vec![SimulatedSensor {
        true_positive: 0.9,
        false_positive: 0.05,
        latency_steps: 2,
        ..sensor("left", Region::Polygon { corners_m: square }, left)
    }];
    conditions
}

#[test]
fn a_further_sensor_that_nobody_asks_changes_no_bit_of_the_motion() {
    let ring = (0..9).map(|robot| {
        let angle_rad = f64::from(robot) * 0.69;
        at(0.6 * libm::cos(angle_rad), 0.6 * libm::sin(angle_rad), angle_rad + 0.3)
    });
    let plain = perfect(ring.collect());
    let mut several = plain.clone();
    several.robot.further_sensors = vec![sensor("wall", LINE, of_walls())];
    let mut own = several.clone();
    own.own_robots.insert(3, own.robot.clone());

    let expected = run_episode(&plain, SEED, 120.0).unwrap();
    assert_eq!(run_episode(&several, SEED, 120.0).unwrap(), expected);
    assert_eq!(run_episode(&own, SEED, 120.0).unwrap(), expected, "of a robot of its own, too");
}

#[test]
fn a_sensor_sees_along_its_bearing() {
    let around = [at(0.0, 0.0, 0.4), at(0.5, 0.3, 0.0), at(-0.4, 0.45, 0.0), at(0.1, -0.6, 0.0)];
    for step in 0..60 {
        let bearing_rad = f64::from(step) * 0.1 - 3.0;
        let mut turned = perfect(around.to_vec());
        let details = SensorDetails { bearing_rad, ..SensorDetails::default() };
        turned.robot.further_sensors = vec![sensor("aside", CONE, details)];
        let mut poses = around.to_vec();
        poses[0].heading_rad += bearing_rad;
        let ahead = perfect(poses);

        let aside = reported(&turned)[0].contains(&"aside".to_owned());
        let expected = World::new(&ahead, SEED).unwrap().sense()[0];
        assert_eq!(aside, expected, "{bearing_rad} rad");
    }
}

#[test]
fn a_wall_is_detected_where_the_region_reaches_it_and_no_robot_stands_between() {
    // The wall is at x = 2.
    let mut facing = perfect(vec![at(0.5, 0.0, 0.0), at(0.5, 1.0, 2.5), at(0.2, -1.0, 0.0)]);
    let line = Region::Cone { half_angle_rad: 0.0, range_m: 1.6 };
    facing.robot.further_sensors = vec![sensor("wall", line, of_walls())];
    assert_eq!(reported(&facing), [vec!["wall"], vec![], vec![]], "the last is 1.8 m away");

    let mut between = perfect(vec![at(0.5, 0.0, 0.0), at(1.5, 0.07, 3.0)]);
    between.robot.further_sensors =
        vec![sensor("wall", LINE, of_walls()), sensor("free_wall", LINE, hidden(of_walls()))];
    assert_eq!(reported(&between)[0], ["wall"], "0.07 m aside its body hides the wall");
    let Placement::Given { starts } = &mut between.placement else { unreachable!() };
    starts[0][1].y_m = 0.08;
    assert_eq!(reported(&between)[0], ["wall", "free_wall"]);
}

#[test]
fn of_several_kinds_the_nearest_is_reported_and_what_it_hides_is_not() {
    let mut one_of = perfect(vec![at(0.0, 0.0, 0.0), at(1.2, 0.0, 3.0)]);
    one_of.robot.region = Region::Cone { half_angle_rad: 0.3, range_m: 2.5 };
    one_of.robot.details.or = vec![exact_reading("wall", Detects::Wall)];
    assert_eq!(reported(&one_of)[0], ["detection"], "a robot in front of a wall");
    // Beside the wall, ahead and to the side: the wall is 0.25 m away, and the robot 1.2 m.
    let Placement::Given { starts } = &mut one_of.placement else { unreachable!() };
    (starts[0][0], starts[0][1]) = (at(0.0, 1.9, 0.12), at(1.19, 1.9, 3.0));
    assert_eq!(reported(&one_of)[0], ["wall"]);
    let Placement::Given { starts } = &mut one_of.placement else { unreachable!() };
    starts[0][1] = at(-1.0, -1.0, 3.0);
    assert_eq!(reported(&one_of)[0], ["wall"], "and where no robot is");

    // A robot that another one hides is not seen, though its body reaches into the cone.
    let mut behind = perfect(vec![at(0.0, 0.0, 0.0), at(0.5, 0.1, 0.0), at(-1.0, 0.0, 0.0)]);
    behind.robot.region = Region::Cone { half_angle_rad: 0.05, range_m: 2.0 };
    assert_eq!(reported(&behind)[0], ["detection"]);
    behind.robot.details = hidden(SensorDetails::default());
    let Placement::Given { starts } = &mut behind.placement else { unreachable!() };
    starts[0][2] = at(0.25, 0.12, 0.0);
    assert_eq!(reported(&behind)[0], Vec::<String>::new());
}

#[test]
fn what_is_reported_of_each_thing_is_its_row_of_the_confusion_table() {
    let mut conditions = ternary();
    conditions.robot.details.bearing_rad = 0.0;
    conditions.robots = 3;
    // A robot in front, a wall in front, nothing in front: robots that stand.
    let starts = vec![vec![at(0.0, 0.0, 0.0), at(0.5, 0.0, 0.0), at(0.0, -0.5, 1.6)]];
    conditions.placement = Placement::Given { starts };
    conditions.arena.side_m = 2.5;
    let expected = [[0.8, 0.1], [0.05, 0.9], [0.8, 0.1]];
    let mut world = World::new(&conditions, SEED).unwrap();
    let mut counts = [[0_u32; 2]; 3];
    let n_steps = 20_000;
    for _ in 0..n_steps {
        for (counts, readings) in counts.iter_mut().zip(world.sense_all()) {
            assert!(!(readings.has(0) && readings.has(1)), "one thing at a time");
            counts[0] += u32::from(readings.has(0));
            counts[1] += u32::from(readings.has(1));
        }
        world.advance(&[rsrs_core::robot::controller::Command::STOP; 3]);
    }

    for (robot, (counts, expected)) in counts.iter().zip(expected).enumerate() {
        for (count, expected) in counts.iter().zip(expected) {
            let share = f64::from(*count) / f64::from(n_steps);
            let four_sigma = 4.0 * (expected * (1.0 - expected) / f64::from(n_steps)).sqrt();
            assert!((share - expected).abs() < four_sigma, "robot {robot}: {share} of {expected}");
        }
    }
}

#[test]
fn each_sensor_has_its_own_latency() {
    let mut conditions = perfect(vec![at(0.0, 0.0, 0.0), at(0.5, 0.0, 3.0)]);
    let plain = SensorDetails::default;
    conditions.robot.further_sensors = vec![
        SimulatedSensor { latency_steps: 3, ..sensor("late", CONE, plain()) },
        sensor("soon", CONE, plain()),
    ];
    let mut world = World::new(&conditions, SEED).unwrap();
    let mut arrived = Vec::new();
    for _ in 0..5 {
        arrived.push([1, 2].map(|place| world.sense_all()[0].has(place)));
        world.advance(&[rsrs_core::robot::controller::Command::STOP; 2]);
    }

    let expected = [[false, true], [false, true], [false, true], [true, true], [true, true]];
    assert_eq!(arrived, expected);
}

#[test]
fn several_sensors_are_swept_in_the_reference_world_and_repeat_to_the_bit() {
    let conditions = ternary();
    conditions.check().expect("a world");
    assert!(!runs_in_lanes(&conditions, 120.0));
    let digests =
        |replicate| episode_digests(&conditions, Seed { seed: 3, replicate }, 120.0).unwrap();
    assert_eq!(digests(0), digests(0));
    assert_ne!(digests(0), digests(1));

    assert_judged_alike(&conditions, 2);
}
