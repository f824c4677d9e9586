//! The laws of the world.

use crate::support::{HARSHER, PERFECT, SEED, flockbots};
use rsrs_core::conditions::{Arena, Conditions, Walls};
use rsrs_core::robot::controller::{Command, decide};
use rsrs_core::robot::profile::Sees;
use rsrs_core::robot::region::Region;
use rsrs_core::robot::unicycle::{self, ActuationGain, Pose};
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::{episode_digests, run_episode};
use rsrs_sim::world::World;

fn world(conditions: &Conditions) -> World {
    World::new(conditions, SEED).expect("the robots fit")
}

/// Runs a world under its controller and returns the detections of every step.
fn run(world: &mut World, conditions: &Conditions, n_steps: usize) -> Vec<Vec<bool>> {
    (0..n_steps)
        .map(|_| {
            let detections = world.sense().to_vec();
            let commands: Vec<Command> = detections
                .iter()
                .map(|seen| {
                    decide(*seen, conditions.controller.parameters().expect("two commands"))
                })
                .collect();
            world.advance(&commands);
            detections
        })
        .collect()
}

#[test]
fn a_robot_without_noise_is_a_unicycle() {
    let conditions = Conditions { robots: 1, ..flockbots(0.15, 0.75, &PERFECT) };
    let gain = ActuationGain { speed: 0.97, turn: 0.97 };
    let mut world = world(&conditions);
    let mut expected = world.poses().next().expect("one robot");

    for step in 0..1000 {
        let command =
            Command { speed_m_s: 0.15, turn_rate_rad_s: if step % 7 < 3 { 0.75 } else { -0.75 } };
        world.sense();
        world.advance(&[command]);
        expected = unicycle::step(expected, command, gain, 0.13);
    }

    // Single precision: 1,000 roundings of some 1e-7 m and 1e-7 rad each.
    let found = world.poses().next().expect("one robot");
    let turned = found.heading_rad - expected.heading_rad;
    assert!((found.x_m - expected.x_m).abs() < 1e-4, "{found:?} {expected:?}");
    assert!((found.y_m - expected.y_m).abs() < 1e-4, "{found:?} {expected:?}");
    assert!(libm::sin(turned / 2.0).abs() < 1e-4, "{found:?} {expected:?}");
}

/// The state after 300 s of nine harsher Flockbots. It changes only when the world does.
const GOLDEN: u64 = 0x77c6_244c_6942_22ed;

#[test]
fn an_episode_has_the_bits_that_it_always_had() {
    let conditions = flockbots(0.15, 0.75, &HARSHER);
    let mut world = world(&conditions);

    run(&mut world, &conditions, 2307);

    assert_eq!(world.digest(), GOLDEN, "found {:#018x}", world.digest());
}

#[test]
fn a_longer_run_passes_through_the_states_of_a_shorter_one() {
    let conditions = flockbots(0.15, 0.75, &HARSHER);

    let short = run_episode(&conditions, SEED, 60.0).expect("the robots fit");
    let long = run_episode(&conditions, SEED, 120.0).expect("the robots fit");

    assert_eq!(short.n_samples(), 461);
    assert_eq!(short.poses, long.poses[..short.poses.len()]);
    assert_eq!(short.commands, long.commands[..short.commands.len()]);
}

#[test]
fn the_digests_of_an_episode_are_those_of_its_world_step_by_step() {
    let conditions = flockbots(0.15, 0.75, &HARSHER);
    let mut world = world(&conditions);

    let digests = episode_digests(&conditions, SEED, 10.0).expect("the robots fit");

    assert_eq!(digests.len(), 76);
    for digest in digests {
        assert_eq!(digest, world.digest());
        run(&mut world, &conditions, 1);
    }
}

#[test]
fn sensing_twice_changes_nothing() {
    let mut conditions = flockbots(0.15, 0.75, &HARSHER);
    conditions.robot.latency_steps = 2;
    let mut once = world(&conditions);
    let mut twice = world(&conditions);

    for _ in 0..200 {
        let digest = twice.digest();
        twice.sense();
        assert_eq!(twice.digest(), digest);
        run(&mut once, &conditions, 1);
        run(&mut twice, &conditions, 1);
    }

    assert_eq!(once.digest(), twice.digest());
}

#[test]
fn another_replicate_is_another_run() {
    let conditions = flockbots(0.15, 0.75, &HARSHER);
    let other = World::new(&conditions, Seed { seed: 1, replicate: 1 }).expect("the robots fit");

    assert_ne!(other.digest(), world(&conditions).digest());
}

#[test]
fn a_certain_sensor_always_reports_and_an_impossible_one_never() {
    for (probability, expected) in [(1.0, true), (0.0, false)] {
        let mut conditions = flockbots(0.15, 0.75, &HARSHER);
        conditions.robot.true_positive = probability;
        conditions.robot.false_positive = probability;

        let detections = run(&mut world(&conditions), &conditions, 500);

        assert!(detections.iter().flatten().all(|detected| *detected == expected));
    }
}

#[test]
fn a_detection_arrives_late_by_the_latency() {
    let mut conditions = flockbots(0.15, 0.75, &HARSHER);
    (conditions.robot.true_positive, conditions.robot.false_positive) = (1.0, 1.0);
    conditions.robot.latency_steps = 3;

    let detections = run(&mut world(&conditions), &conditions, 10);

    let arrivals: Vec<bool> = detections.iter().map(|all| all[0]).collect();
    assert_eq!(arrivals, [[false; 3].as_slice(), &[true; 7]].concat());
}

#[test]
fn one_robot_sees_itself_neither_in_a_cone_nor_around_itself() {
    let square = vec![[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
    let cone = Region::Cone { half_angle_rad: 0.2, range_m: 0.75 };
    for (region, sees) in [
        (cone.clone(), Sees::Body),
        (cone, Sees::Centre),
        (Region::Polygon { corners_m: square.clone() }, Sees::Body),
        (Region::Polygon { corners_m: square }, Sees::Centre),
    ] {
        let mut conditions = Conditions { robots: 1, ..flockbots(0.15, 0.75, &PERFECT) };
        (conditions.robot.region, conditions.robot.sees) = (region, sees);
        let mut world = world(&conditions);

        let detections = run(&mut world, &conditions, 100);

        assert!(detections.iter().flatten().all(|detected| !detected));
        assert_eq!(world.blocked(), [false]);
    }
}

#[test]
fn no_robots_are_a_world_too_and_two_meet() {
    let none = Conditions { robots: 0, ..flockbots(0.15, 0.75, &PERFECT) };
    let two = Conditions { robots: 2, ..flockbots(0.15, 0.75, &PERFECT) };

    let empty = run_episode(&none, SEED, 60.0).expect("no robots fit anywhere");
    let detections = run(&mut world(&two), &two, 2000);

    assert_eq!((empty.n_samples(), empty.poses.len()), (0, 0));
    assert!(detections.iter().flatten().any(|detected| *detected));
}

#[test]
fn walls_hold_what_would_leave() {
    let side_m = 2.0;
    for (walls, is_held) in [(Walls::Stop, true), (Walls::Clamp, true), (Walls::None, false)] {
        let mut conditions = flockbots(0.15, 0.0, &PERFECT);
        conditions.arena = Arena { side_m, walls };
        let mut world = world(&conditions);

        run(&mut world, &conditions, 200);

        let limit_m = side_m / 2.0 - 0.075 + 1e-6;
        let is_inside = |pose: Pose| pose.x_m.abs() <= limit_m && pose.y_m.abs() <= limit_m;
        assert_eq!(world.poses().all(is_inside), is_held, "{walls:?}");
    }
}

#[test]
fn a_yaw_lag_softens_the_turn_and_gusts_carry_a_robot_that_stands() {
    let mut lagging = Conditions { robots: 1, ..flockbots(0.0, 0.75, &PERFECT) };
    lagging.robot.yaw_lag_s = 1.0;
    let mut gusty = Conditions { robots: 1, ..flockbots(0.0, 0.75, &PERFECT) };
    gusty.robot.gust_sd_m_s = 0.1;
    let (mut lagging_world, mut gusty_world) = (world(&lagging), world(&gusty));
    let before: Vec<Pose> = lagging_world.poses().chain(gusty_world.poses()).collect();

    run(&mut lagging_world, &lagging, 1);
    run(&mut gusty_world, &gusty, 50);

    let after: Vec<Pose> = lagging_world.poses().chain(gusty_world.poses()).collect();
    let turned_rad = after[0].heading_rad - before[0].heading_rad;
    assert!(libm::sin(turned_rad + 0.75 * 0.97 * 0.13 * 0.13).abs() < 1e-6, "{turned_rad}");
    assert!(libm::hypot(after[1].x_m - before[1].x_m, after[1].y_m - before[1].y_m) > 0.01);
}

#[test]
#[should_panic(expected = "every robot senses before any robot moves")]
fn moving_without_sensing_is_a_mistake() {
    world(&flockbots(0.15, 0.75, &PERFECT)).advance(&[Command::STOP; 9]);
}

#[test]
#[should_panic(expected = "the command of robot 2 is not finite")]
fn a_command_that_is_not_finite_is_a_mistake() {
    let mut commands = [Command::STOP; 9];
    commands[2].turn_rate_rad_s = f64::NAN;
    let mut world = world(&flockbots(0.15, 0.75, &PERFECT));

    world.sense();
    world.advance(&commands);
}

proptest::proptest! {
    #[test]
    fn no_robot_goes_further_in_a_step_than_commanded(
        speed_m_s in 0.0..1.0,
        turn_rate_rad_s in 0.0..20.0,
        replicate in 0_u64..1000,
    ) {
        let conditions = flockbots(speed_m_s, turn_rate_rad_s, &HARSHER);
        let seed = Seed { seed: 1, replicate };
        let trajectory = run_episode(&conditions, seed, 10.0).expect("the robots fit");

        // Gains are at most three standard deviations above their mean; 1e-6 m is for rounding.
        let most_m = speed_m_s * (0.97 + 3.0 * 0.05) * 0.13 + 1e-6;
        for (before, after) in trajectory.poses.iter().zip(&trajectory.poses[9..]) {
            let moved_m = libm::hypot(after.x_m - before.x_m, after.y_m - before.y_m);
            assert!(moved_m <= most_m, "{moved_m} {most_m}");
        }
    }
}
