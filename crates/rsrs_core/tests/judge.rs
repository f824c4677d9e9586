//! The judge on made-up trajectories, whose phase is known by construction.

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::order::Parameter;
use rsrs_core::judge::phase::{self, JudgeError, Phase, Verdict};
use rsrs_core::judge::trajectory::{Bodies, Trajectory};
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::profile::Sees;
use rsrs_core::robot::region::Region;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::WorldFile;

const PERIOD_S: f64 = 0.13;
const SPEED_M_S: f64 = 0.15;
pub const FLOCKBOT: Bodies = Bodies {
    radius_m: Some(0.075),
    reach_m: Some(0.75),
    arena_m: None,
    world: WorldFile::NOTHING,
    classes: Vec::new(),
};
const UNKNOWN_REACH: Bodies = Bodies {
    radius_m: Some(0.075),
    reach_m: None,
    arena_m: None,
    world: WorldFile::NOTHING,
    classes: Vec::new(),
};

/// A run of nine robots whose poses are a function of robot and time.
pub fn run(duration_s: f64, pose: impl Fn(usize, f64) -> Pose) -> Trajectory {
    let mut trajectory = Trajectory::new(PERIOD_S, 9);
    let times_s = (0..).map(|sample| f64::from(sample) * PERIOD_S);
    for time_s in times_s.take_while(|time_s| *time_s < duration_s - PERIOD_S / 2.0) {
        trajectory.poses.extend((0..9).map(|robot| pose(robot, time_s)));
        let command = Command { speed_m_s: SPEED_M_S, turn_rate_rad_s: 0.75 };
        trajectory.commands.extend([command; 9]);
    }
    trajectory
}

/// A robot on a circle around `centre_x_m`, at a bearing, facing along it counterclockwise.
pub fn on_circle(centre_x_m: f64, radius_m: f64, bearing_rad: f64) -> Pose {
    let (sine, cosine) = libm::sincos(bearing_rad);
    Pose {
        x_m: centre_x_m + radius_m * cosine,
        y_m: radius_m * sine,
        heading_rad: bearing_rad + std::f64::consts::FRAC_PI_2,
    }
}

pub fn spacing_rad(robot: usize, n_robots: usize) -> f64 {
    std::f64::consts::TAU * robot as f64 / n_robots as f64
}

fn ring(radius_m: f64, speed_m_s: f64) -> impl Fn(usize, f64) -> Pose {
    move |robot, time_s| {
        on_circle(0.0, radius_m, spacing_rad(robot, 9) + speed_m_s / radius_m * time_s)
    }
}

fn label(trajectory: &Trajectory, bodies: &Bodies) -> Verdict {
    phase::label(trajectory, bodies).expect("the trajectory is long enough and finite")
}

fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "found {found}, expected {expected}");
}

#[test]
fn a_perfect_ring_is_stable_milling() {
    let verdict = label(&run(70.0, ring(0.7, SPEED_M_S)), &FLOCKBOT);

    let evidence = verdict.evidence;
    assert_eq!(verdict.phase, Phase::STABLE_MILLING);
    assert_near(evidence.rotation, 1.0, 1e-9);
    assert_near(evidence.orbit, 1.0, 1e-9);
    assert_near(evidence.circliness, 1.0, 1e-9);
    assert_near(evidence.mean_radius_m, 0.7, 1e-9);
    assert_near(evidence.circliness_ceiling, 1.0 - 0.75 * PERIOD_S / 2.0, 1e-12);
    assert_eq!((evidence.lost, evidence.blocked, evidence.stuck), (Some(0.0), 0.0, 0.0));
    assert_eq!(evidence.contact_onsets_per_s, Some(0.0));
}

#[test]
fn a_ring_that_turns_clockwise_mills_as_well() {
    let mirrored = |robot, time_s| {
        let pose = ring(0.7, SPEED_M_S)(robot, time_s);
        Pose { x_m: pose.x_m, y_m: -pose.y_m, heading_rad: -pose.heading_rad }
    };

    assert_eq!(label(&run(70.0, mirrored), &FLOCKBOT).phase, Phase::STABLE_MILLING);
}

#[test]
fn a_clean_ring_that_drives_forward_and_backward_is_stable_milling() {
    // Forward for most of the time, and backward every fifth period.
    let mut trajectory = run(70.0, ring(0.7, SPEED_M_S));
    for (row, command) in trajectory.commands.iter_mut().enumerate() {
        let is_back = (row / 9) % 5 == 4;
        command.speed_m_s = if is_back { -SPEED_M_S } else { 1.5 * SPEED_M_S };
    }

    let verdict = label(&trajectory, &FLOCKBOT);

    assert_eq!(verdict.phase, Phase::STABLE_MILLING);
    assert_near(verdict.evidence.orbit, 1.0, 0.01);
    assert_near(verdict.evidence.blocked, 0.0, 0.0);
}

#[test]
fn a_mill_that_tears_apart_inside_the_window_is_not_stable() {
    // Two robots of nine wander across the ring; for 12 s it is one stray moment, for 25 s it is not.
    let torn = |from_s: f64, to_s: f64| {
        let moving = ring(0.7, SPEED_M_S);
        let pose = move |robot: usize, time_s: f64| {
            let pose = moving(robot, time_s);
            let is_away = robot < 2 && (from_s..to_s).contains(&time_s);
            let share = if is_away { 0.4 } else { 1.0 };
            Pose { x_m: share * pose.x_m, y_m: share * pose.y_m, ..pose }
        };
        label(&run(60.0, pose), &FLOCKBOT)
    };

    let moment = torn(12.0, 18.0);
    let longer = torn(12.0, 36.0);

    assert_eq!(moment.phase, Phase::STABLE_MILLING);
    assert_eq!(longer.phase, Phase::SEMI_STABLE_MILLING);
    // The whole window alone does not show it.
    assert!(Behaviour::MILLING.rules().is_wanted(&longer.evidence), "{:?}", longer.evidence);
}

#[test]
fn a_jammed_ring_is_colliding_however_round_it_is() {
    let verdict = label(&run(70.0, ring(0.3, 0.0)), &FLOCKBOT);

    assert_eq!(verdict.phase, Phase::COLLIDING_UNSTABLE);
    assert_near(verdict.evidence.circliness, 1.0, 1e-9);
    assert_near(verdict.evidence.blocked, 1.0, 0.0);
    assert_near(verdict.evidence.stuck, 1.0, 0.0);
}

#[test]
fn two_of_nine_stuck_robots_are_a_collision() {
    let moving = ring(0.7, SPEED_M_S);
    let pose = move |robot, time_s| moving(robot, if robot < 2 { 0.0 } else { time_s });

    let verdict = label(&run(70.0, pose), &FLOCKBOT);

    assert_eq!(verdict.phase, Phase::COLLIDING_UNSTABLE);
    assert_near(verdict.evidence.stuck, 2.0 / 9.0, 1e-12);
}

/// Robots that drive away from the centre for ever.
fn dispersing(robot: usize, time_s: f64) -> Pose {
    let bearing_rad = spacing_rad(robot, 9);
    let place = on_circle(0.0, 0.5 + SPEED_M_S * time_s, bearing_rad);
    Pose { heading_rad: bearing_rad, ..place }
}

#[test]
fn robots_that_lose_each_other_disperse() {
    let verdict = label(&run(120.0, dispersing), &FLOCKBOT);

    assert_eq!(verdict.phase, Phase::DISPERSION);
    assert_eq!(verdict.evidence.lost, Some(1.0));
}

#[test]
fn nobody_is_lost_across_a_gap_that_bodies_are_seen_across() {
    let cone = Region::Cone { half_angle_rad: 0.2, range_m: 0.75 };
    // Neighbours on the ring are 0.76 m apart.
    let radius_m = 0.38 / libm::sin(std::f64::consts::PI / 9.0);
    let trajectory = run(70.0, ring(radius_m, SPEED_M_S));

    let seen = |sees| Bodies {
        radius_m: Some(0.075),
        reach_m: Some(cone.reach_m(sees, 0.075)),
        ..Bodies::UNKNOWN
    };
    let body = label(&trajectory, &seen(Sees::Body));
    let centre = label(&trajectory, &seen(Sees::Centre));

    assert_eq!((body.phase, body.evidence.lost), (Phase::STABLE_MILLING, Some(0.0)));
    assert_eq!((centre.phase, centre.evidence.lost), (Phase::DISPERSION, Some(1.0)));
}

#[test]
fn a_reach_that_is_not_known_chooses_no_phase_and_is_asked_for() {
    let mill = run(70.0, ring(0.7, SPEED_M_S));
    let refused = phase::label(&mill, &UNKNOWN_REACH).expect_err("the reach decides");

    // Neighbours in a ring of nine are `2 r sin(20°)` apart.
    let apart_m = 1.4 * libm::sin(std::f64::consts::PI / 9.0);
    let JudgeError::UnknownReach { phases } = &refused else { panic!("{refused}") };
    assert_eq!(
        phases.iter().map(|(_, phase)| *phase).collect::<Vec<_>>(),
        [Phase::DISPERSION, Phase::STABLE_MILLING]
    );
    assert!((phases[1].0 - apart_m).abs() < 2e-3, "{phases:?}, expected {apart_m}");
    assert_eq!(
        refused.to_string(),
        "the robots' reach is not known, and decides: dispersion below 0.48 m, stable milling from \
         0.48 m on"
    );
    for (reach_m, expected) in [(0.47, Phase::DISPERSION), (0.49, Phase::STABLE_MILLING)] {
        let bodies = Bodies { reach_m: Some(reach_m), ..UNKNOWN_REACH };
        assert_eq!(label(&mill, &bodies).phase, expected);
    }
}

#[test]
fn a_robot_by_itself_has_lost_the_others_at_any_reach_and_nobody_cannot_be_judged() {
    let no_robots = Trajectory::new(PERIOD_S, 0);
    let mut alone = Trajectory::new(PERIOD_S, 1);
    let nine = run(70.0, ring(0.7, SPEED_M_S));
    alone.poses = nine.poses.chunks(9).map(|poses| poses[0]).collect();
    alone.commands = nine.commands.chunks(9).map(|commands| commands[0]).collect();

    for bodies in [FLOCKBOT, UNKNOWN_REACH] {
        let verdict = label(&alone, &bodies);
        assert_eq!((verdict.phase, verdict.evidence.lost), (Phase::DISPERSION, Some(1.0)));
    }
    assert_eq!(phase::label(&no_robots, &FLOCKBOT), Err(JudgeError::NoRobots));
}

#[test]
fn two_mills_side_by_side_are_unformed() {
    let split = |robot: usize, time_s: f64| {
        let centre_x_m = if robot.is_multiple_of(2) { -1.0 } else { 1.0 };
        on_circle(centre_x_m, 0.3, spacing_rad(robot / 2, 5) + SPEED_M_S / 0.3 * time_s)
    };

    let verdict = label(&run(120.0, split), &FLOCKBOT);

    assert_eq!(verdict.phase, Phase::UNFORMED);
    assert!(verdict.evidence.rotation < 0.6, "{:?}", verdict.evidence);
}

/// A ring in which every third robot runs closer to the centre.
fn fat_ring(robot: usize, time_s: f64) -> Pose {
    let radius_m = if robot.is_multiple_of(3) { 0.45 } else { 0.75 };
    on_circle(0.0, radius_m, spacing_rad(robot, 9) + SPEED_M_S / 0.65 * time_s)
}

#[test]
fn a_ring_of_two_radii_is_semi_stable() {
    let verdict = label(&run(120.0, fat_ring), &FLOCKBOT);

    assert_eq!(verdict.phase, Phase::SEMI_STABLE_MILLING);
    assert_near(verdict.evidence.fatness, 1.0 - (0.45_f64 / 0.75).powi(2), 1e-9);
}

#[test]
fn the_line_between_stable_and_semi_stable_moves_with_its_threshold() {
    let trajectory = run(120.0, fat_ring);
    let lenient = Behaviour::MILLING.rules().with_wanted_bound(Parameter::CIRCLINESS, 0.35);

    let verdict = phase::label_with(&trajectory, &FLOCKBOT, &lenient).expect("as above");

    assert_eq!(verdict.phase, Phase::STABLE_MILLING);
}

#[test]
fn only_the_last_minute_counts_and_its_start_is_when_the_mill_formed() {
    let late = |robot: usize, time_s: f64| {
        let place = ring(0.7, SPEED_M_S)(robot, time_s);
        // Two good blocks, three bad ones, and good ones to the end.
        let inward_rad =
            if (20.0..50.0).contains(&time_s) { std::f64::consts::FRAC_PI_2 } else { 0.0 };
        Pose { heading_rad: place.heading_rad + inward_rad, ..place }
    };
    let trajectory = run(150.0, late);

    let verdict = label(&trajectory, &FLOCKBOT);
    let converged_s = phase::converged_s(&trajectory, &FLOCKBOT, verdict.phase);

    assert_eq!(verdict.phase, Phase::STABLE_MILLING);
    // Blocks are 76 periods of 0.13 s; the sixth starts at 49.4 s and is good but for 0.6 s.
    assert_near(converged_s.expect("it converged"), 49.4, 0.01);
}

#[test]
fn a_robot_that_bumps_once_has_one_onset() {
    let moving = ring(0.7, SPEED_M_S);
    let pose = move |robot: usize, time_s: f64| {
        // Robot 1 is thrown upon robot 0 from the 40th to the 41st second.
        let offset_rad = if robot == 1 && (40.0..41.0).contains(&time_s) { -0.5 } else { 0.0 };
        let place = moving(robot, time_s);
        on_circle(0.0, 0.7, place.heading_rad - std::f64::consts::FRAC_PI_2 + offset_rad)
    };

    let verdict = label(&run(65.0, pose), &FLOCKBOT);

    // Two robots come into contact once each, in 461 periods, among nine.
    let expected = 2.0 / (9.0 * 461.0 * PERIOD_S);
    assert_near(
        verdict.evidence.contact_onsets_per_s.expect("the radius is known"),
        expected,
        1e-12,
    );
}

#[test]
fn the_contact_of_bodies_of_unknown_size_is_unknown() {
    let bodies = Bodies { radius_m: None, ..FLOCKBOT };

    let verdict = label(&run(70.0, ring(0.7, SPEED_M_S)), &bodies);

    assert_eq!(verdict.evidence.contact_onsets_per_s, None);
}

#[test]
fn a_run_shorter_than_the_window_is_refused() {
    let error = phase::label(&run(59.0, ring(0.7, SPEED_M_S)), &FLOCKBOT).unwrap_err();

    assert_eq!(error.to_string(), "59.0 s recorded, expected at least 60 s");
    // 461 periods are 59.93 s.
    assert!(phase::label(&run(59.93, ring(0.7, SPEED_M_S)), &FLOCKBOT).is_ok());
}

#[test]
fn a_pose_that_is_not_a_number_is_refused() {
    let mut trajectory = run(70.0, ring(0.7, SPEED_M_S));
    trajectory.poses[9 * 100 + 4].y_m = f64::NAN;

    let error = phase::label(&trajectory, &FLOCKBOT).unwrap_err();

    assert_eq!(error, JudgeError::NotFinite { robot: 4, time_s: 13.0 });
}

#[test]
fn poses_that_can_be_nobodys_and_a_period_that_is_none_are_refused() {
    let mill = run(70.0, ring(0.7, SPEED_M_S));
    let mut far = mill.clone();
    far.poses[9 * 100 + 4].x_m = -1e17;
    let at_once = Trajectory { period_s: 0.0, ..mill };

    let error = phase::label(&far, &UNKNOWN_REACH).unwrap_err();

    assert_eq!(error, JudgeError::TooLarge { robot: 4, time_s: 13.0 });
    assert_eq!(
        error.to_string(),
        "robot 4 has a pose or command beyond 1e9, 13.00 s after the start; poses are in metres and radians"
    );
    assert_eq!(phase::label(&at_once, &FLOCKBOT), Err(JudgeError::Period { period_s: 0.0 }));
}

#[test]
fn without_commands_a_phase_is_given_where_they_decide_nothing() {
    let milling = &Behaviour::MILLING.rules();
    let poses_of = |run: Trajectory| Trajectory::of_poses(PERIOD_S, run.n_robots, run.poses);
    let dispersing = poses_of(run(120.0, dispersing));
    let mill = poses_of(run(70.0, ring(0.7, SPEED_M_S)));
    let judge = phase::label_without_commands;

    assert_eq!(judge(&dispersing, &FLOCKBOT, milling).unwrap().phase, Phase::DISPERSION);
    assert_eq!(
        judge(&mill, &FLOCKBOT, milling).unwrap_err().to_string(),
        "what the robots were commanded is not known, and decides between colliding unstable, stable \
         milling, semi-stable milling and unformed"
    );
    assert_eq!(
        judge(&dispersing, &UNKNOWN_REACH, milling).unwrap_err().to_string(),
        "neither what the robots were commanded nor their reach is known, and they decide between \
         dispersion, colliding unstable and unformed"
    );
    for behaviour in [Behaviour::AGGREGATION, Behaviour::DISPERSAL] {
        let rules = &behaviour.rules();
        for run in [&dispersing, &mill] {
            assert_eq!(judge(run, &FLOCKBOT, rules), phase::label_with(run, &FLOCKBOT, rules));
        }
        let unknown =
            (judge(&mill, &UNKNOWN_REACH, rules), phase::label_with(&mill, &UNKNOWN_REACH, rules));
        assert_eq!(unknown.0, unknown.1);
    }
}

#[test]
fn the_wanted_margin_is_the_least_distance_to_a_bound_and_negative_where_one_is_not_kept() {
    let milling = Behaviour::MILLING.rules();
    let margin = |run: &Trajectory| milling.wanted_margin(&label(run, &FLOCKBOT).evidence);

    // No robot is lost, and of none there is nothing to spare.
    let mill = margin(&run(70.0, ring(0.7, SPEED_M_S)));
    assert!((0.0..1e-300).contains(&mill), "{mill}");
    // All are lost.
    assert_eq!(margin(&run(120.0, dispersing)).to_bits(), (-1.0_f64).to_bits());
}

#[test]
fn order_parameters_serialise_under_the_names_of_the_contract() {
    let verdict = label(&run(70.0, ring(0.7, SPEED_M_S)), &FLOCKBOT);

    let json = serde_json::to_value(verdict.evidence).expect("they are plain data");

    let mut keys: Vec<&str> = json.as_object().expect("a map").keys().map(String::as_str).collect();
    keys.sort_unstable();
    assert_eq!(
        keys.join(" "),
        "blocked circliness circliness_ceiling clustered contact_onsets_per_s fatness lost \
         mean_radius_m orbit rotation stuck tangentness"
    );
    assert_eq!(json["lost"], 0.0);
}

proptest::proptest! {
    #[test]
    fn it_does_not_matter_where_a_mill_is_and_which_way_is_north(
        x_m in -100.0..100.0,
        y_m in -100.0..100.0,
        north_rad in -10.0..10.0,
    ) {
        let moved = |robot, time_s| {
            let pose = fat_ring(robot, time_s);
            let (sine, cosine) = libm::sincos(north_rad);
            Pose {
                x_m: x_m + cosine * pose.x_m - sine * pose.y_m,
                y_m: y_m + sine * pose.x_m + cosine * pose.y_m,
                heading_rad: pose.heading_rad + north_rad,
            }
        };

        let here = label(&run(65.0, fat_ring), &FLOCKBOT);
        let there = label(&run(65.0, moved), &FLOCKBOT);

        assert_eq!(here.phase, there.phase);
        assert_near(there.evidence.rotation, here.evidence.rotation, 1e-9);
        assert_near(there.evidence.orbit, here.evidence.orbit, 1e-9);
        assert_near(there.evidence.circliness, here.evidence.circliness, 1e-9);
        assert_near(there.evidence.blocked, here.evidence.blocked, 1e-12);
    }
}
