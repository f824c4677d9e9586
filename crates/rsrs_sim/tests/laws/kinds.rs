//! Worlds with robots that have a profile of their own.

use crate::support::{PERFECT, SEED, assert_judged_alike, at, flockbots, perfect_at};
use rsrs_core::conditions::{Conditions, SimulatedRobot};
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::region::Region;
use rsrs_core::robot::unicycle::Pose;
use rsrs_sim::batch::runs_in_lanes;

use rsrs_sim::episode::episode_digests;
use rsrs_sim::world::World;

fn with_own(
    mut conditions: Conditions,
    robot: usize,
    change: impl FnOnce(&mut SimulatedRobot),
) -> Conditions {
    let mut own = conditions.robot.clone();
    change(&mut own);
    conditions.own_robots.insert(robot, own);
    conditions.check().expect("it makes a world");
    conditions
}

#[test]
fn a_robot_of_its_own_that_is_like_the_others_changes_no_bit() {
    let ring = (0..9).map(|robot| {
        let angle_rad = f64::from(robot) * 0.69;
        at(0.6 * libm::cos(angle_rad), 0.6 * libm::sin(angle_rad), angle_rad + 0.3)
    });
    let alike = perfect_at(ring.collect());
    let own = with_own(alike.clone(), 4, |_| {});

    let expected = episode_digests(&alike, SEED, 300.0).unwrap();
    assert_eq!(episode_digests(&own, SEED, 300.0).unwrap(), expected);
    let other = with_own(alike, 4, |robot| robot.speed_gain.mean *= 0.99);
    assert_ne!(episode_digests(&other, SEED, 300.0).unwrap(), expected);
}

#[test]
fn each_robot_is_moved_by_its_own_numbers() {
    let conditions = perfect_at(vec![at(0.0, 0.0, 0.0), at(0.0, 3.0, 0.0), at(0.0, 6.0, 0.0)]);
    let conditions = with_own(conditions, 1, |robot| {
        robot.speed_gain.mean = 0.5;
        robot.turn_gain.mean = 2.0;
    });
    let mut world = World::new(&conditions, SEED).unwrap();

    world.sense();
    world.advance(&[Command { speed_m_s: 0.1, turn_rate_rad_s: 0.2 }; 3]);

    let poses: Vec<Pose> = world.poses().collect();
    for (robot, speed_gain, turn_gain) in [(0, 0.97, 0.97), (1, 0.5, 2.0), (2, 0.97, 0.97)] {
        let Pose { x_m, heading_rad, .. } = poses[robot];
        assert!((x_m - speed_gain * 0.1 * 0.13).abs() < 1e-6, "{robot}: {x_m}");
        assert!((heading_rad - turn_gain * 0.2 * 0.13).abs() < 1e-6, "{robot}: {heading_rad}");
    }
}

#[test]
fn each_robot_sees_as_far_as_its_own_sensor_and_a_large_body_from_farther_away() {
    // Two robots face each other, 0.8 m apart; a cone of 0.75 m reaches a body of 0.075 m there.
    let facing = || perfect_at(vec![at(0.0, 0.0, 0.0), at(0.8, 0.0, std::f64::consts::PI)]);
    let seen = |conditions: &Conditions| World::new(conditions, SEED).unwrap().sense().to_vec();
    let short = |robot: &mut SimulatedRobot| {
        robot.region = Region::Cone { half_angle_rad: 0.2, range_m: 0.7 };
    };
    assert_eq!(seen(&facing()), [true, true]);
    assert_eq!(seen(&with_own(facing(), 1, short)), [true, false]);

    let enlarged = with_own(facing(), 1, short);
    let enlarged = with_own(enlarged, 0, |robot| robot.radius_m = 0.2);
    assert_eq!(seen(&enlarged), [true, true], "a large body is seen from farther away");
    let blind = with_own(facing(), 0, |robot| robot.true_positive = 0.0);
    assert_eq!(seen(&blind), [false, true]);
    let late = with_own(facing(), 0, |robot| robot.latency_steps = 2);
    let mut world = World::new(&late, SEED).unwrap();
    let first_seen = (0..4).map(|_| {
        let seen = world.sense().to_vec();
        world.advance(&[Command::STOP; 2]);
        seen
    });
    let expected = [[false, true], [false, true], [true, true], [true, true]];
    assert_eq!(first_seen.collect::<Vec<_>>(), expected);
}

#[test]
fn two_bodies_touch_where_their_own_radii_meet() {
    let blocked = |radius_m: f64| {
        let apart = perfect_at(vec![at(0.0, 0.0, 0.0), at(0.2, 0.0, 1.0)]);
        let conditions = with_own(apart, 1, |robot| robot.radius_m = radius_m);
        let mut world = World::new(&conditions, SEED).unwrap();
        world.sense();
        world.blocked().to_vec()
    };

    assert_eq!(blocked(0.12), [false, false], "0.195 m of 0.2 m");
    // A table may not put them so near; a world may come so far.
    let near = perfect_at(vec![at(0.0, 0.0, 0.0), at(0.16, 0.0, 0.0)]);
    let mut large = near.clone();
    let own = SimulatedRobot { radius_m: 0.1, ..near.robot.clone() };
    large.own_robots.insert(1, own);
    let error = large.check().unwrap_err().to_string();
    assert!(error.contains("0.175"), "their two radii: {error}");
    let mut world = World::new(&large, SEED).unwrap();
    world.sense();
    assert_eq!(world.blocked(), [true, false], "0.16 m is less than 0.175 m");
}

#[test]
fn robots_that_differ_are_judged_by_the_reference_and_not_in_lanes() {
    let mut conditions = flockbots(0.15, 0.75, &PERFECT);
    assert!(runs_in_lanes(&conditions, 120.0));
    conditions = with_own(conditions, 2, |robot| robot.speed_gain.mean = 0.4);
    assert!(!runs_in_lanes(&conditions, 120.0));

    assert_judged_alike(&conditions, 2);
}

#[test]
fn the_largest_body_has_room_at_the_start() {
    let conditions = flockbots(0.15, 0.75, &PERFECT);
    let conditions = with_own(conditions, 8, |robot| robot.radius_m = 0.12);
    let poses: Vec<Pose> = World::new(&conditions, SEED).unwrap().poses().collect();

    for (index, one) in poses.iter().enumerate() {
        for other in &poses[index + 1..] {
            let apart_m = libm::hypot(one.x_m - other.x_m, one.y_m - other.y_m);
            assert!(apart_m >= 2.0 * 0.12, "{apart_m}");
        }
    }
}
