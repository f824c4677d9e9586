//! Whom the plausibility check accuses: nobody who is as he should be, and whoever is not.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use rsrs_core::conditions::{Arena, Conditions, GainDistribution, Placement, Walls};
use rsrs_core::judge::plausibility::{
    FloorAxis, Implausibility, Implausible, Known, NOTED_S, STOOD_S, Unseen, implausible,
};
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::{Command, ControllerParameters};
use rsrs_core::robot::unicycle::Pose;
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use rsrs_testing::conditions::flockbot_conditions;
use rsrs_testing::draw::Draw;
use rsrs_testing::environment::is_long;

const DURATION_S: f64 = 120.0;

/// How a tracker sees a run.
#[derive(Clone, Copy, Debug)]
struct Seen {
    position_sd_m: f64,
    heading_sd_rad: f64,
    /// By how much poses are later than commands, in seconds.
    late_s: f64,
    /// Time between two samples, in seconds.
    period_s: f64,
    /// Share of poses that are missing, and interpolated.
    missed: f64,
}

const EXACT: Seen =
    Seen { position_sd_m: 0.0, heading_sd_rad: 0.0, late_s: 0.0, period_s: 0.13, missed: 0.0 };

/// The whole number below one that is not negative.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "casts from floats saturate, and times and numbers of robots are not negative"
)]
fn whole(number: f64) -> usize {
    number as usize
}

/// Which of so many is the turn of a run.
fn which(index: u64, n: u64) -> usize {
    usize::try_from(index % n).expect("small")
}

fn pose_at(run: &Trajectory, robot: usize, time_s: f64) -> Pose {
    let steps = (time_s / run.period_s).clamp(0.0, (run.n_samples() - 1) as f64);
    let before = whole(steps);
    let share = steps - before as f64;
    let from = run.poses_at(before)[robot];
    let to = run.poses_at((before + 1).min(run.n_samples() - 1))[robot];
    let turn_rad = libm::remainder(to.heading_rad - from.heading_rad, TAU);
    Pose {
        x_m: from.x_m + (to.x_m - from.x_m) * share,
        y_m: from.y_m + (to.y_m - from.y_m) * share,
        heading_rad: from.heading_rad + turn_rad * share,
    }
}

/// A run as a tracker sees it.
fn seen(run: &Trajectory, by: Seen, seed: u64) -> Trajectory {
    let mut draw = Draw::new(seed);
    let mut found = Trajectory::new(by.period_s, run.n_robots);
    let n_samples = whole(run.duration_s() / by.period_s);
    for sample in 0..n_samples {
        let time_s = sample as f64 * by.period_s;
        let step = whole(time_s / run.period_s).min(run.n_samples() - 1);
        for robot in 0..run.n_robots {
            let mut pose = pose_at(run, robot, time_s - by.late_s);
            pose.x_m += draw.normal(0.0, by.position_sd_m);
            pose.y_m += draw.normal(0.0, by.position_sd_m);
            pose.heading_rad += draw.normal(0.0, by.heading_sd_rad);
            let missed = draw.uniform() < by.missed && sample > 0;
            let before = found.poses.len().wrapping_sub(run.n_robots);
            found.poses.push(if missed { found.poses[before] } else { pose });
            found.commands.push(run.commands_at(step)[robot]);
        }
    }
    found
}

fn known(conditions: &Conditions) -> Known<'static> {
    Known {
        bodies: conditions.bodies(),
        walls_m: conditions.arena.walls_m(),
        left_out: &[],
        unseen: &[],
    }
}

/// The last half minute before a time, as it is looked at while robots move.
fn last(run: &Trajectory, until_s: f64) -> Trajectory {
    let end = whole(until_s / run.period_s).min(run.n_samples());
    let start = end.saturating_sub(whole(30.0 / run.period_s));
    let n = run.n_robots;
    Trajectory {
        poses: run.poses[start * n..end * n].to_vec(),
        commands: run.commands[start * n..end * n].to_vec(),
        ..Trajectory::new(run.period_s, n)
    }
}

fn while_it_goes_on(run: &Trajectory, conditions: &Conditions, every_s: f64) -> Vec<Implausible> {
    let mut found = implausible(run, &known(conditions), NOTED_S);
    let mut until_s = 5.0;
    while until_s < run.duration_s() {
        found.extend(implausible(&last(run, until_s), &known(conditions), NOTED_S));
        until_s += every_s;
    }
    found
}

/// Robots as different as laboratories have them.
fn drawn(index: u64) -> (Conditions, Seen) {
    let mut draw = Draw::new(1000 + index);
    let mut between = |low: f64, high: f64| low + (high - low) * draw.uniform();
    let mut conditions = flockbot_conditions();
    conditions.robots = whole(between(1.0, 16.0));
    let (speed_m_s, turn_rate_rad_s) = (between(0.03, 0.4), between(0.15, 2.0));
    let controller = match index % 6 {
        // Backward where nothing is seen.
        0 => ControllerParameters::new(
            Command { speed_m_s, turn_rate_rad_s },
            Command { speed_m_s: -0.7 * speed_m_s, turn_rate_rad_s: -0.5 * turn_rate_rad_s },
        ),
        // Turning on the spot only.
        1 => ControllerParameters::new(
            Command { speed_m_s: 0.0, turn_rate_rad_s },
            Command { speed_m_s: 0.0, turn_rate_rad_s: -0.5 * turn_rate_rad_s },
        ),
        // Slow where something is seen.
        2 => ControllerParameters::new(
            Command { speed_m_s: 0.2 * speed_m_s, turn_rate_rad_s },
            Command { speed_m_s, turn_rate_rad_s: -0.3 * turn_rate_rad_s },
        ),
        _ => ControllerParameters::mirrored(speed_m_s, turn_rate_rad_s),
    };
    conditions.controller = controller.into();
    let crowding = between(1.3, 4.0);
    let radius_m = crowding * 0.1 * (conditions.robots as f64).sqrt() + 0.05;
    conditions.placement = Placement::DiscFacingOut { radius_m };
    let walls = [Walls::None, Walls::Clamp, Walls::Stop][which(index, 3)];
    conditions.arena = Arena { side_m: between(2.5, 10.0) * radius_m + 0.4, walls };
    let gain = |mean, robot_sd| GainDistribution { mean, robot_sd, step_sd: 0.05 };
    conditions.robot.speed_gain = gain(between(0.7, 1.4), between(0.0, 0.15));
    conditions.robot.turn_gain = gain(between(0.7, 1.4), between(0.0, 0.15));
    conditions.robot.turn_bias_sd_rad_s = between(0.0, 0.1) * turn_rate_rad_s;
    conditions.robot.gust_sd_m_s =
        if index.is_multiple_of(4) { between(0.0, 0.5 * speed_m_s) } else { 0.0 };
    conditions.robot.yaw_lag_s = if index.is_multiple_of(5) { between(0.0, 0.5) } else { 0.0 };
    conditions.robot.heading_noise_sd_rad = between(0.0, 0.02);
    conditions.robot.rotates_while_blocked = index.is_multiple_of(2);
    let contacts = [ContactModel::Stop, ContactModel::Push, ContactModel::None];
    conditions.robot.contact = contacts[which(index / 6, 3)];
    conditions.robot.latency_steps = u32::try_from(whole(between(0.0, 4.0))).expect("small");
    conditions.robot.true_positive = between(0.3, 1.0);
    let late_s = if index.is_multiple_of(7) { between(-1.0, 1.0) } else { between(0.0, 0.2) };
    let seen = Seen {
        position_sd_m: between(0.0, 0.01),
        heading_sd_rad: between(0.0, 0.1),
        late_s,
        period_s: [0.13, 0.1, 1.0 / 7.7][which(index, 3)],
        missed: between(0.0, 0.05),
    };
    (conditions, seen)
}

#[test]
fn nobody_is_accused_of_whom_nothing_is_wrong() {
    let (n_runs, every_s) = if is_long() { (1000, 1.0) } else { (60, 5.0) };
    let mut accused = Vec::new();
    for index in 0..n_runs {
        let (conditions, by) = drawn(index);
        let seed = Seed { seed: 7, replicate: index };
        let Ok(run) = run_episode(&conditions, seed, DURATION_S) else { continue };
        let found = while_it_goes_on(&seen(&run, by, index), &conditions, every_s);
        if !found.is_empty() {
            accused.push((index, conditions.controller, by, found));
        }
    }

    assert!(accused.is_empty(), "{} of {n_runs}: {accused:#?}", accused.len());
}

/// Nine Flockbots that mill.
fn mill() -> Conditions {
    let mut conditions = flockbot_conditions();
    conditions.placement = Placement::DiscFacingOut { radius_m: 0.6 };
    conditions
}

/// Three mills, as they are and as a tracker of 5 mm, 0.03 rad and 0.1 s sees them, with other poses.
fn mills(change: impl Fn(&mut Trajectory)) -> Vec<Trajectory> {
    let tracked = Seen { position_sd_m: 0.005, heading_sd_rad: 0.03, late_s: 0.1, ..EXACT };
    let runs = [EXACT, tracked].map(|by| {
        (0..3).map(move |replicate| {
            let run = run_episode(&mill(), Seed { seed: 3, replicate }, DURATION_S)
                .expect("the robots fit into their disc");
            seen(&run, by, replicate)
        })
    });
    let mut runs: Vec<Trajectory> = runs.into_iter().flatten().collect();
    runs.iter_mut().for_each(change);
    runs
}

fn posed(change: impl Fn(Pose) -> Pose) -> impl Fn(&mut Trajectory) {
    move |run| run.poses.iter_mut().for_each(|pose| *pose = change(*pose))
}

/// Asserts that a fault of all poses is found after so many seconds at most, and in the whole run of
/// this many robots at least, with nothing else.
fn is_found(
    runs: &[Trajectory],
    (within_s, n_robots): (f64, usize),
    is_it: fn(&Implausibility) -> bool,
) {
    for run in runs {
        let mut until_s = 5.0;
        let is_in = |found: &[Implausible]| found.iter().any(|found| is_it(&found.cause));
        while !is_in(&implausible(&last(run, until_s), &known(&mill()), NOTED_S)) {
            until_s += 1.0;
            assert!(until_s <= within_s, "not within {within_s} s");
        }

        let whole = implausible(run, &known(&mill()), STOOD_S);

        let found: Vec<usize> = whole.iter().flat_map(|found| found.robots.clone()).collect();
        assert!(whole.iter().all(|found| is_it(&found.cause)), "{whole:?}");
        assert!(found.len() >= n_robots, "{whole:?}");
    }
}

#[test]
fn millimetres_are_named_after_5_seconds() {
    let runs = mills(posed(|pose| Pose { x_m: 1000.0 * pose.x_m, y_m: 1000.0 * pose.y_m, ..pose }));

    is_found(&runs, (5.0, 9), |cause| {
        matches!(cause, Implausibility::Scale { factor: 700.0..1400.0 })
    });
    let found = implausible(&runs[0], &known(&mill()), STOOD_S);
    let names: Vec<String> = (1..=9).map(|robot| format!("robot_{robot}")).collect();
    let words = found[0].in_words(&names);
    assert!(words.starts_with("all 9 robots: poses move 9"), "{words}");
    assert!(words.ends_with("0 times too far: millimetres?"), "{words}");
}

#[test]
fn an_axis_that_points_up_is_named() {
    let runs = mills(posed(|pose| {
        let heading_rad = if libm::cos(pose.heading_rad) < 0.0 { PI } else { 0.0 };
        Pose { y_m: 0.08, heading_rad, ..pose }
    }));

    is_found(&runs, (6.0, 8), |cause| matches!(cause, Implausibility::Line { axis: FloorAxis::X }));
}

#[test]
fn degrees_in_place_of_radians_are_named() {
    let runs = mills(posed(|pose| {
        let heading_rad = libm::remainder(pose.heading_rad.to_degrees(), TAU);
        Pose { heading_rad, ..pose }
    }));
    // Noise of 0.03 rad becomes one of all angles: only what is not noise shows how fast it turns.
    let (exact, tracked) = runs.split_at(3);

    is_found(exact, (8.0, 9), |cause| {
        matches!(cause, Implausibility::Degrees { factor: 57.0..58.0 })
    });
    is_found(tracked, (12.0, 9), |cause| {
        matches!(cause, Implausibility::HeadingUnrelated | Implausibility::Degrees { .. })
    });
}

#[test]
fn headings_that_stand_or_turn_too_little_are_named() {
    let standing = mills(posed(|pose| Pose { heading_rad: 0.3, ..pose }));
    let too_little =
        mills(posed(|pose| Pose { heading_rad: pose.heading_rad.to_radians(), ..pose }));

    is_found(&standing, (20.0, 8), |cause| matches!(cause, Implausibility::HeadingStands));
    is_found(&too_little, (20.0, 8), |cause| {
        matches!(
            cause,
            Implausibility::HeadingStands | Implausibility::Degrees { factor: 0.008..0.035 }
        )
    });
}

#[test]
fn mirrored_poses_are_named_and_so_are_places_or_headings_alone() {
    let both = mills(posed(|pose| Pose { y_m: -pose.y_m, heading_rad: -pose.heading_rad, ..pose }));
    let places = mills(posed(|pose| Pose { y_m: -pose.y_m, ..pose }));
    let headings = mills(posed(|pose| Pose { heading_rad: -pose.heading_rad, ..pose }));

    is_found(&both, (24.0, 6), |cause| matches!(cause, Implausibility::Mirrored));
    for one in [places, headings] {
        is_found(&one, (24.0, 8), |cause| matches!(cause, Implausibility::HeadingMirrored));
    }
}

#[test]
fn bodies_that_are_fixed_askew_are_named_with_the_angle() {
    let runs = mills(posed(|pose| Pose { heading_rad: pose.heading_rad + FRAC_PI_2, ..pose }));

    is_found(&runs, (30.0, 6), |cause| {
        matches!(cause, Implausibility::Askew { by_deg: -95.0..-85.0 })
    });
}

fn exchange(run: &mut Trajectory, circle: &[usize]) {
    for sample in 0..run.n_samples() {
        let row = sample * run.n_robots;
        for pair in circle.windows(2) {
            run.poses.swap(row + pair[0], row + pair[1]);
        }
    }
}

#[test]
fn bodies_that_are_swapped_are_named_as_far_as_their_commands_differ() {
    let swapped = mills(|run| exchange(run, &[1, 4]));
    let three = mills(|run| exchange(run, &[0, 3, 6]));

    is_found(&swapped, (60.0, 2), |cause| matches!(cause, Implausibility::Swapped));
    for (runs, expected) in [(swapped, vec![1, 4]), (three, vec![0, 3, 6])] {
        for run in runs {
            let found = implausible(&run, &known(&mill()), STOOD_S);
            assert_eq!(
                found,
                [Implausible { cause: Implausibility::Swapped, robots: expected.clone() }]
            );
        }
    }
    // In a mill that turns like one body all commands are the same, and nothing shows who is who.
    let mut alike = mills(|_| {}).remove(0);
    let n_robots = alike.n_robots;
    for cell in 0..alike.commands.len() {
        alike.commands[cell] = alike.commands[cell - cell % n_robots];
        let (row, start) = (cell % n_robots, alike.poses[cell - cell % n_robots]);
        alike.poses[cell] = Pose { x_m: start.x_m + row as f64, ..start };
    }
    exchange(&mut alike, &[1, 4]);
    assert_eq!(implausible(&alike, &known(&mill()), STOOD_S), []);
}

#[test]
fn a_robot_that_stops_is_named_and_one_that_touches_another_is_not() {
    let stopped = |run: &mut Trajectory| {
        let since = whole(60.0 / run.period_s);
        for sample in since..run.n_samples() {
            run.poses[sample * 9 + 2] = run.poses[since * 9 + 2];
        }
    };
    for run in mills(stopped) {
        let found = implausible(&run, &known(&mill()), STOOD_S);

        let names: Vec<String> = (1..=9).map(|robot| format!("robot_{robot}")).collect();
        let [found] = &found[..] else { panic!("{found:?}") };
        let Implausibility::Stands { time_s, .. } = found.cause else { panic!("{found:?}") };
        assert!((58.0..80.0).contains(&time_s), "{found:?}");
        let words = found.in_words(&names);
        assert!(words.starts_with("robot_3 is commanded 0.15 m/s and has moved 0.0"), "{words}");
    }
    let face_to_face = |run: &mut Trajectory| {
        for sample in 0..run.n_samples() {
            let [x_m, y_m] = [run.poses[2].x_m, run.poses[2].y_m];
            run.poses[sample * 9 + 2] = Pose { x_m, y_m, heading_rad: 0.0 };
            run.poses[sample * 9 + 3] = Pose { x_m: x_m + 0.16, y_m, heading_rad: PI };
        }
    };
    for run in mills(face_to_face) {
        assert_eq!(implausible(&run, &known(&mill()), STOOD_S), []);
    }
}

#[test]
fn who_was_lost_or_is_not_commanded_is_not_asked_to_move() {
    let dead = |run: &mut Trajectory| {
        for sample in 0..run.n_samples() {
            run.poses[sample * 9 + 2] = run.poses[2];
        }
    };
    for mut run in mills(dead) {
        let lost = Known { left_out: &[2], ..known(&mill()) };
        assert_eq!(implausible(&run, &lost, STOOD_S), []);
        assert_eq!(implausible(&run, &known(&mill()), STOOD_S).len(), 1);

        for sample in 0..run.n_samples() {
            run.commands[sample * 9 + 2] = Command::STOP;
        }
        assert_eq!(implausible(&run, &known(&mill()), STOOD_S), []);
    }
}

#[test]
fn what_a_robot_did_while_it_was_not_seen_is_no_evidence() {
    let alone = Conditions { robots: 1, ..mill() };
    let seed = Seed { seed: 3, replicate: 0 };
    let run = run_episode(&alone, seed, DURATION_S).expect("it has room");
    let mut hidden = seen(&run, EXACT, 0);
    let (from, to) = (whole(20.0 / 0.13), whole(50.0 / 0.13));
    hidden.poses[from..to].fill(run.poses[from]);

    let unseen = [Unseen { row: 0, from_s: 20.0, to_s: 50.0 }];
    let gap = Known { unseen: &unseen, ..known(&alone) };

    assert_eq!(implausible(&hidden, &gap, STOOD_S), []);
    assert_eq!(implausible(&hidden, &known(&alone), STOOD_S).len(), 1, "it seems to stand");
}
