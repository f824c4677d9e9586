//! The batch kernel against the reference world, and its judge against the judge: bit by bit.

use proptest::prelude::*;
use rsrs_core::conditions::{Arena, Conditions, GainDistribution, Placement, Sides, Walls};
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::phase::Verdict;
use rsrs_core::robot::controller::{Command, ControllerParameters};
use rsrs_core::robot::profile::Sees;
use rsrs_core::robot::region::Region;
use rsrs_core::robot::unicycle::Pose;
use rsrs_sim::batch::{Batch, VectorUnit};
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::{episode_digests, run_episode};

use crate::support::{HARSHER, PERFECT, flockbots, judged_by_reference};

fn batch(unit: VectorUnit) -> Batch {
    Batch::on(unit).expect("an available unit")
}

/// What the reference world passes through.
fn reference(conditions: &Conditions, seed: Seed, n_steps: u64) -> Vec<u64> {
    // Half a period more, so that no rounding takes a step away.
    let duration_s = (n_steps as f64 + 0.5) * conditions.period_s;
    episode_digests(conditions, seed, duration_s).expect("the robots fit")
}

/// Replicates of the batch that do not pass through the states of the reference.
fn strays(conditions: &Conditions, seed: u64, n_steps: u64) -> Vec<(VectorUnit, u64)> {
    let mut strays = Vec::new();
    for unit in VectorUnit::available() {
        let mut batch = batch(unit);
        let n_replicates = batch.lanes() as u64 + 2;
        let digests =
            batch.digests(conditions, seed, 0..n_replicates, n_steps).expect("the robots fit");
        for (replicate, digests) in (0..).zip(digests) {
            if digests != reference(conditions, Seed { seed, replicate }, n_steps) {
                strays.push((unit, replicate));
            }
        }
    }
    strays
}

/// Every number to the bit, as `==` would take plus zero for minus zero.
fn bits(judged: &Verdict) -> String {
    format!("{judged:?}")
}

/// Asserts that every unit judges 18 replicates as the reference does, and gives these verdicts.
fn judged_alike(conditions: &Conditions, duration_s: f64) -> Vec<Verdict> {
    let seeds = (0..18).map(|replicate| Seed { seed: 5, replicate });
    let expected: Vec<Verdict> =
        seeds.map(|seed| judged_by_reference(conditions, seed, duration_s)).collect();
    for unit in VectorUnit::available() {
        let judged = batch(unit).judge(conditions, 5, 0..18, duration_s).expect("fit and long");
        for (replicate, (judged, expected)) in judged.iter().zip(&expected).enumerate() {
            assert_eq!(bits(judged), bits(expected), "{unit:?} {replicate} {conditions:?}");
        }
        assert_eq!(judged.len(), expected.len());
    }
    expected
}

#[test]
fn every_machine_has_a_unit_and_this_ones_are_tested() {
    let units = VectorUnit::available();

    assert!(units.contains(&VectorUnit::Portable), "{units:?}");
    #[cfg(target_arch = "x86_64")]
    assert_eq!(units.contains(&VectorUnit::Avx2), is_x86_feature_detected!("avx2"));
}

#[test]
fn all_units_pass_through_the_states_of_the_reference() {
    let conditions = flockbots(0.15, 0.75, &HARSHER);

    assert_eq!(strays(&conditions, 1, 2307), []);
}

#[test]
fn the_comparison_finds_a_difference_of_one_bit() {
    let conditions = flockbots(0.15, 0.75, &HARSHER);
    let mut other = conditions.clone();
    other.robot.true_positive += 1.0 / 16_777_216.0;

    let digests = |conditions: &Conditions| {
        batch(VectorUnit::Portable).digests(conditions, 1, 0..1, 1).expect("the robots fit")
    };

    assert_ne!(digests(&conditions), digests(&other));
}

#[test]
fn crowds_and_jams_pass_through_the_states_of_the_reference() {
    for (robots, radius_m) in [(1, 0.1), (2, 0.2), (30, 0.8), (128, 2.0)] {
        let mut conditions = flockbots(0.25, 0.25, &HARSHER);
        conditions.robots = robots;
        conditions.placement = Placement::DiscFacingOut { radius_m };
        conditions.robot.region = Region::Cone { half_angle_rad: 1.4, range_m: 0.5 };

        assert_eq!(strays(&conditions, 3, 300), [], "{robots} robots");
    }
}

#[test]
fn robots_in_a_box_or_where_a_table_puts_them_pass_through_the_states_of_the_reference() {
    let mut in_a_box = flockbots(0.15, 0.75, &HARSHER);
    in_a_box.placement = Placement::BoxFacingOut(Sides { width_m: 2.0, height_m: 0.8 });
    // Five sets, so that neither lanes nor replicates go through them evenly.
    let place = |set: u32, robot: u32| Pose {
        x_m: 0.2 * f64::from(robot) - 0.8,
        y_m: 0.1 * f64::from(set) + 0.03 * f64::from(robot % 3),
        heading_rad: 1.3 * f64::from(robot) - 5.0,
    };
    let sets = (0..5).map(|set| (0..9).map(|robot| place(set, robot)).collect());
    let mut by_a_table = flockbots(0.15, 0.75, &HARSHER);
    by_a_table.placement = Placement::Given { starts: sets.collect() };
    for conditions in [&in_a_box, &by_a_table] {
        conditions.check().expect("the robots fit");

        assert_eq!(strays(conditions, 3, 600), [], "{:?}", conditions.placement);
    }
    let starts = |replicate| {
        let seed = Seed { seed: 3, replicate };
        run_episode(&by_a_table, seed, 1.0).expect("the robots fit").poses[0]
    };
    assert_ne!(starts(0), starts(1));
    let near = |one: Pose, other: Pose| libm::hypot(one.x_m - other.x_m, one.y_m - other.y_m) < 0.1;
    assert!(near(starts(1), place(1, 0)) && near(starts(6), place(1, 0)), "each in its turn");
}

#[test]
fn the_judge_of_the_lanes_is_the_judge() {
    let cells = [(0.15, 0.75), (0.05, 1.5), (0.30, 0.25), (0.25, 2.0), (0.175, 0.25), (0.0, 0.5)];
    for (speed_m_s, turn_rate_rad_s) in cells {
        for imperfection in [&HARSHER, &PERFECT] {
            judged_alike(&flockbots(speed_m_s, turn_rate_rad_s, imperfection), 150.0);
        }
    }
}

#[test]
fn every_behaviour_is_judged_alike_in_lanes_and_by_the_reference() {
    let command = |speed_m_s, turn_rate_rad_s| Command { speed_m_s, turn_rate_rad_s };
    // Gauci's aggregation: backward on a circle until something is seen, then a turn in place.
    let aggregation = (command(0.0, -2.0), command(-0.2, -0.6));
    let dispersal = (command(-0.15, 1.0), command(0.1, 0.2));
    for (behaviour, (detected, undetected)) in [
        (Behaviour::AGGREGATION, aggregation),
        (Behaviour::DISPERSAL, dispersal),
        (Behaviour::MILLING, dispersal),
    ] {
        let mut conditions = flockbots(0.0, 0.0, &HARSHER);
        conditions.controller = ControllerParameters::new(detected, undetected).into();
        conditions.behaviour = behaviour;
        conditions.robot.region = Region::Cone { half_angle_rad: 0.05, range_m: 3.0 };
        for judged in judged_alike(&conditions, 150.0) {
            assert_eq!(judged.phase.behaviour(), behaviour);
        }
    }
}

#[test]
fn what_only_some_behaviours_ask_for_is_the_same_in_lanes_and_by_the_reference() {
    let behaviour = Behaviour::parse(
        "asking.yaml",
        "name: asking\nwords: {noun: asking, swarm: a swarm, verb: [ask, asks, asked]}\n\
         phases: [{key: asking}, {key: silent}]\notherwise: silent\n\
         rules: [{phase: asking, when: {polarisation: {below: 0.3}, spread_m: {at_least: 0.5}, \
         wall_distance_m: {at_least: 0.5}, coverage: {at_least: 0.2}, visited: {at_least: 0.02}}}]",
    )
    .expect("it is a behaviour");
    let mut conditions = flockbots(0.15, 0.75, &HARSHER);
    conditions.behaviour = behaviour;
    conditions.arena = Arena { side_m: 4.0, walls: Walls::Clamp };
    let asked = behaviour.rules().asked();
    for judged in judged_alike(&conditions, 150.0) {
        let is_known = |evidence| asked.iter().all(|it| it.value(evidence).is_some());
        assert!(is_known(&judged.evidence) && judged.blocks.iter().all(is_known), "{judged:?}");
    }
}

#[test]
fn any_time_of_a_run_is_judged_alike_in_lanes_and_by_the_reference() {
    for (number, window) in
        ["{last_s: 25}", "{last_s: 90}", "whole_run", "ever"].into_iter().enumerate()
    {
        let behaviour = Behaviour::parse(
            "windows.yaml",
            &format!(
                "name: window_{number}\nwords: {{noun: it, swarm: a swarm, verb: [do, does, did]}}\n\
                 phases: [{{key: window_{number}_yes}}, {{key: window_{number}_no}}]\n\
                 otherwise: window_{number}_no\nwindow: {window}\n\
                 rules: [{{phase: window_{number}_yes, when: {{rotation: {{at_least: 0.7}}, \
                 polarisation: {{below: 0.5}}}}}}]"
            ),
        )
        .expect("it is a behaviour");
        for undetected in [None, Some(Command { speed_m_s: 0.1, turn_rate_rad_s: 0.3 })] {
            let mut conditions = flockbots(0.15, 0.75, &HARSHER);
            conditions.behaviour = behaviour;
            if let Some(undetected) = undetected {
                let detected = Command { speed_m_s: 0.15, turn_rate_rad_s: -0.75 };
                conditions.controller = ControllerParameters::new(detected, undetected).into();
            }
            judged_alike(&conditions, 124.0);
        }
    }
}

#[test]
fn robots_are_looked_at_whenever_they_may_meet_or_part() {
    // Few robots, one run alone: nothing else in the vector makes the batch look closely.
    let mut between_walls = flockbots(0.1, 0.5, &HARSHER);
    between_walls.robots = 3;
    between_walls.robot.region = Region::Cone { half_angle_rad: 0.2, range_m: 3.0 };
    between_walls.arena = Arena { side_m: 1.0, walls: Walls::Clamp };
    between_walls.placement = Placement::DiscFacingOut { radius_m: 0.4 };
    let mut in_the_wind = flockbots(0.09, 1.3, &HARSHER);
    in_the_wind.robots = 2;
    in_the_wind.robot.gust_sd_m_s = 0.06;
    in_the_wind.placement = Placement::DiscFacingOut { radius_m: 0.4 };
    let (mut n_per_s, mut n_partly_lost) = (0.0, 0);
    for conditions in [&between_walls, &in_the_wind] {
        for unit in VectorUnit::available() {
            for replicate in 0..48 {
                let runs = replicate..replicate + 1;
                let judged = batch(unit).judge(conditions, 3, runs, 70.0).expect("fit and long");

                let expected = judged_by_reference(conditions, Seed { seed: 3, replicate }, 70.0);
                assert_eq!(bits(&judged[0]), bits(&expected), "{unit:?} {replicate}");
                let evidence = expected.evidence;
                n_per_s += evidence.contact_onsets_per_s.unwrap_or(0.0);
                n_partly_lost += usize::from(evidence.lost.is_some_and(|lost| lost > 0.0));
            }
        }
    }
    assert!(n_per_s > 0.05, "hardly any robots met, so this shows nothing");
    assert!(n_partly_lost > 0, "no robots parted, so this shows nothing");
}

prop_compose! {
    fn gain()(mean in 0.5..1.2, robot_sd in sometimes(0.2), step_sd in sometimes(0.2))
        -> GainDistribution
    {
        GainDistribution { mean, robot_sd, step_sd }
    }
}

/// Zero, or a number up to `most`.
fn sometimes(most: f64) -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), 0.0..most]
}

/// A cone, or a convex polygon of three to eight corners around a point in front.
fn region() -> impl Strategy<Value = Region> {
    let cone = (0.02..1.5, 0.1..2.0)
        .prop_map(|(half_angle_rad, range_m)| Region::Cone { half_angle_rad, range_m });
    let polygon =
        (3_usize..=8, 0.05..0.8, -0.2..0.6, -0.2..0.2).prop_map(|(n, size_m, x_m, y_m)| {
            let corner = |corner: usize| {
                let (sine, cosine) = libm::sincos(std::f64::consts::TAU * corner as f64 / n as f64);
                [x_m + size_m * cosine, y_m + size_m * sine]
            };
            Region::Polygon { corners_m: (0..n).map(corner).collect() }
        });
    prop_oneof![cone, polygon]
}

/// A mirrored controller, or any two commands, backward ones among them.
fn controller() -> impl Strategy<Value = ControllerParameters> {
    let mirrored = (0.0..0.5, 0.0..2.5)
        .prop_map(|(speed, turn_rate)| ControllerParameters::mirrored(speed, turn_rate));
    let command = || {
        (-0.4..0.4, -2.5..2.5)
            .prop_map(|(speed_m_s, turn_rate_rad_s)| Command { speed_m_s, turn_rate_rad_s })
    };
    let general = (command(), command()).prop_map(|(yes, no)| ControllerParameters::new(yes, no));
    prop_oneof![mirrored, general]
}

prop_compose! {
    fn robot_with_noisy_traits()(
        (speed_gain, turn_gain) in (gain(), gain()),
        (turn_bias, heading_noise, gust, yaw_lag) in
            (sometimes(0.1), sometimes(0.05), sometimes(0.1), sometimes(2.0)),
        (region, sees, rotates, front) in (
            region(),
            prop_oneof![Just(Sees::Body), Just(Sees::Centre)],
            any::<bool>(),
            0.1..3.1,
        ),
        (true_positive, false_positive, latency_steps) in (0.0..=1.0, 0.0..=1.0, 0_u32..5),
        (controller, behaviour, robots, radius, walls, side) in (
            controller(),
            prop::sample::select(Behaviour::BUILT_IN.to_vec()),
            1_usize..16,
            0.5..1.5,
            prop_oneof![Just(Walls::None), Just(Walls::Stop), Just(Walls::Clamp)],
            2.0..6.0,
        ),
    ) -> Conditions {
        let mut conditions = flockbots(0.0, 0.0, &PERFECT);
        (conditions.controller, conditions.behaviour) = (controller.into(), behaviour);
        conditions.robots = robots;
        conditions.placement = Placement::DiscFacingOut { radius_m: radius };
        (conditions.arena.walls, conditions.arena.side_m) = (walls, side);
        let robot = &mut conditions.robot;
        (robot.speed_gain, robot.turn_gain) = (speed_gain, turn_gain);
        robot.turn_bias_sd_rad_s = turn_bias;
        robot.heading_noise_sd_rad = heading_noise;
        robot.gust_sd_m_s = gust;
        robot.yaw_lag_s = yaw_lag;
        (robot.region, robot.sees) = (region, sees);
        robot.rotates_while_blocked = rotates;
        robot.front_half_angle_rad = front;
        (robot.true_positive, robot.false_positive) = (true_positive, false_positive);
        robot.latency_steps = latency_steps;
        conditions
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn any_robots_pass_through_the_states_of_the_reference(
        conditions in robot_with_noisy_traits(),
        seed in 0_u64..1000,
    ) {
        prop_assert_eq!(strays(&conditions, seed, 120), []);
    }

    #[test]
    fn any_run_is_judged_as_the_judge_judges(
        conditions in robot_with_noisy_traits(),
        seed in 0_u64..1000,
        duration_s in 60.0..100.0,
    ) {
        for unit in VectorUnit::available() {
            let judged = batch(unit).judge(&conditions, seed, 0..3, duration_s).expect("fits");

            for (replicate, judged) in (0..).zip(&judged) {
                let expected =
                    judged_by_reference(&conditions, Seed { seed, replicate }, duration_s);
                prop_assert_eq!(bits(judged), bits(&expected), "{:?} {}", unit, replicate);
            }
        }
    }
}
