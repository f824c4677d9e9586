//! Worlds side by side under commands from outside, against the reference world: bit by bit.

use proptest::prelude::*;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rsrs_core::conditions::{Conditions, GainDistribution, Walls};
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::region::Region;
use rsrs_sim::batch::VectorUnit;
use rsrs_sim::draw::Seed;
use rsrs_sim::placement::PlacementError;
use rsrs_sim::world::World;
use rsrs_sim::worlds::Worlds;

use crate::support::{HARSHER, flockbots};

const MOST: Command = Command { speed_m_s: 0.3, turn_rate_rad_s: 2.0 };

/// Commands within the limits, to either side, some of them nothing.
fn draw(commands: &mut [Command], random: &mut ChaCha8Rng) {
    for command in commands {
        let mut number = |most: f64| match random.random_range(0..8) {
            0 => 0.0,
            _ => random.random_range(-most..most),
        };
        *command = Command {
            speed_m_s: number(MOST.speed_m_s),
            turn_rate_rad_s: number(MOST.turn_rate_rad_s),
        };
    }
}

/// Steps worlds and reference worlds by the same commands, and holds them against each other.
fn hold(conditions: &Conditions, unit: &[VectorUnit], n_worlds: u64, n_steps: u64) {
    let n_robots = conditions.robots;
    let mut worlds = Worlds::on(unit, conditions, (3, 5..5 + n_worlds), MOST).expect("they fit");
    let reference = |replicate| World::new(conditions, Seed { seed: 3, replicate });
    let mut references = (5..5 + n_worlds)
        .map(reference)
        .collect::<Result<Vec<World>, PlacementError>>()
        .expect("they fit");
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let n_all = references.len() * n_robots;
    let mut detections = vec![false; n_all];
    let mut commands = vec![Command::STOP; n_all];
    for step in 0..n_steps {
        worlds.sense(&mut detections);
        draw(&mut commands, &mut random);
        let digests: Vec<u64> = references.iter().map(World::digest).collect();
        assert_eq!(worlds.digests(), digests, "before step {step} on {unit:?}");
        for (index, world) in references.iter_mut().enumerate() {
            let robots = index * n_robots..(index + 1) * n_robots;
            assert_eq!(world.sense(), &detections[robots.clone()], "step {step} on {unit:?}");
            world.advance(&commands[robots]);
        }
        worlds.advance(&commands);
    }
    let poses = references.iter().flat_map(World::poses);
    assert!(worlds.poses().into_iter().eq(poses));
}

/// Robots with every feature that the lanes have.
fn conditions() -> impl Strategy<Value = Conditions> {
    let noise = prop_oneof![Just(0.0), 0.0..0.1];
    let cone = (0.1..1.2, 0.2..2.0)
        .prop_map(|(half_angle_rad, range_m)| Region::Cone { half_angle_rad, range_m });
    let walls = prop_oneof![Just(Walls::None), Just(Walls::Stop), Just(Walls::Clamp)];
    let robots = 1_usize..12;
    let others = (any::<bool>(), 0_u32..4, prop_oneof![Just(0.0), 0.05..0.5]);
    (robots, noise.clone(), noise, cone, walls, others).prop_map(
        |(robots, step_sd, heading_sd, region, walls, (rotates, latency_steps, yaw_lag_s))| {
            let mut conditions = flockbots(0.15, 0.75, &HARSHER);
            conditions.robots = robots;
            conditions.arena.walls = walls;
            conditions.arena.side_m = 2.5;
            let robot = &mut conditions.robot;
            robot.region = region;
            robot.speed_gain = GainDistribution { step_sd, ..robot.speed_gain };
            robot.turn_gain = GainDistribution { step_sd, ..robot.turn_gain };
            robot.heading_noise_sd_rad = heading_sd;
            robot.gust_sd_m_s = heading_sd / 10.0;
            robot.rotates_while_blocked = rotates;
            robot.latency_steps = latency_steps;
            robot.yaw_lag_s = yaw_lag_s;
            conditions
        },
    )
}

#[test]
fn worlds_pass_through_the_states_of_the_reference_under_any_commands() {
    let plain = flockbots(0.15, 0.75, &HARSHER);
    for unit in VectorUnit::available() {
        // A part that is full, and one that is not.
        hold(&plain, &[unit], 19, 400);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn worlds_of_any_robots_pass_through_the_states_of_the_reference(conditions in conditions()) {
        for unit in VectorUnit::available() {
            hold(&conditions, &[unit], 5, 80);
        }
    }
}

#[test]
fn robots_that_push_and_machines_without_a_unit_have_a_world_each() {
    let mut pushing = flockbots(0.15, 0.75, &HARSHER);
    pushing.robot.contact = ContactModel::Push;

    hold(&pushing, &VectorUnit::available(), 3, 100);
    hold(&flockbots(0.15, 0.75, &HARSHER), &[], 3, 100);
}

#[test]
fn sensing_again_changes_nothing() {
    let conditions = flockbots(0.15, 0.75, &HARSHER);
    let mut worlds = Worlds::new(&conditions, 1, 0..7, MOST).unwrap();
    let (mut once, mut again) = (vec![false; 63], vec![false; 63]);

    worlds.sense(&mut once);
    worlds.sense(&mut again);

    assert_eq!(once, again);
}

#[test]
#[should_panic(expected = "no command is beyond")]
fn a_command_beyond_what_the_worlds_were_made_for_is_a_mistake() {
    let conditions = flockbots(0.15, 0.75, &HARSHER);
    let mut worlds = Worlds::new(&conditions, 1, 0..1, MOST).unwrap();
    worlds.sense(&mut [false; 9]);

    worlds.advance(&[Command { speed_m_s: 0.31, turn_rate_rad_s: 0.0 }; 9]);
}
