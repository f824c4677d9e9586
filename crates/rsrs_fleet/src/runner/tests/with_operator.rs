//! What a run does when a person stands beside the robots.

use rsrs_core::robot::unicycle::Pose;

use super::*;
use crate::placement::{StartArea, WantedStart};

fn floor() -> Bench {
    Bench::with(|options| {
        options.length = RunLength::RealTime { duration: Duration::from_secs(4) };
        options.expected.simulator = false;
        options.countdown = Duration::from_secs(3);
        options.start =
            Some(WantedStart { area: StartArea::Disc { radius_m: 0.8 }, clearance_m: 0.165 });
    })
}

fn armed(bench: &mut Bench) {
    for _ in 0..40 {
        if bench.notes.iter().any(|text| text.contains("move in")) {
            return;
        }
        bench.beat();
    }
    panic!("no countdown after 4 s: {:?}", bench.notes);
}

#[test]
fn the_robots_move_when_the_countdown_is_over_and_not_before() {
    let mut bench = floor();
    armed(&mut bench);
    let start_ms = bench.now_ms;

    while bench.state() == Some(LeaseState::Armed) {
        bench.beat();
    }

    assert_eq!(bench.state(), Some(LeaseState::Running));
    assert_eq!(bench.now_ms - start_ms, 3_000);
    let counted: Vec<_> = bench.notes.iter().filter(|text| text.contains("move in")).collect();
    assert_eq!(
        counted,
        ["the robots move in 3 s", "the robots move in 2 s", "the robots move in 1 s"]
    );
}

#[test]
fn robots_that_are_about_to_move_do_not_move_in_0_s() {
    let mut bench = Bench::with(|options| {
        options.countdown = Duration::from_micros(1_000_500);
    });
    armed(&mut bench);

    while bench.state() == Some(LeaseState::Armed) {
        bench.beat();
    }

    let counted: Vec<_> = bench.notes.iter().filter(|text| text.contains("move in")).collect();
    assert_eq!(counted, ["the robots move in 2 s", "the robots move in 1 s"]);
}

#[test]
fn an_interrupted_countdown_moves_no_robot() {
    let mut bench = floor();
    armed(&mut bench);

    bench.give(Event::Interrupt { reason: "interrupted".to_owned() });

    assert_eq!(bench.state(), Some(LeaseState::Stopped));
    assert_eq!(bench.end().0, Outcome::Aborted { reason: "interrupted".to_owned() });
    assert!(!bench.notes.contains(&"running".to_owned()));
}

#[test]
fn a_lapse_in_the_countdown_starts_the_countdown_again() {
    let mut bench = floor();
    armed(&mut bench);
    while !bench.notes.contains(&"the robots move in 1 s".to_owned()) {
        bench.beat();
    }

    bench.stop_cause = StopCause::Lease;
    bench.stopped.insert("robot_2");
    bench.beat();
    bench.beat();
    assert_eq!((&bench.finish, bench.state()), (&None, Some(LeaseState::Armed)));
    bench.stopped.remove("robot_2");
    let again_ms = bench.now_ms;
    while bench.state() == Some(LeaseState::Armed) {
        bench.beat();
    }

    assert_eq!(bench.state(), Some(LeaseState::Running));
    assert!(bench.now_ms - again_ms >= 3_000, "{}", bench.now_ms - again_ms);
    let again = "the countdown starts again when all are armed";
    assert!(bench.notes.iter().any(|text| text.ends_with(again)), "{:?}", bench.notes);
}

#[test]
fn a_network_on_which_no_countdown_ends_fails_the_run_after_a_minute() {
    let mut bench = floor();
    armed(&mut bench);
    let start_ms = bench.now_ms;
    bench.stop_cause = StopCause::Lease;

    for beat in 0..900 {
        if bench.finish.is_some() {
            break;
        }
        if beat % 15 < 2 {
            bench.stopped.insert("robot_2");
        } else {
            bench.stopped.remove("robot_2");
        }
        bench.beat();
    }

    assert!(bench.problems()[0].starts_with("robot_2: did not arm: stopped"));
    assert!((60_000..75_000).contains(&(bench.now_ms - start_ms)), "{}", bench.now_ms - start_ms);
}

#[test]
fn a_robot_whose_hardware_fails_in_the_countdown_ends_the_run() {
    let mut bench = floor();
    armed(&mut bench);

    bench.stop_cause = StopCause::Latched;
    bench.stopped.insert("robot_2");
    bench.beat();
    bench.beat();

    let problem = &bench.problems()[0];
    assert!(problem.starts_with("robot_2: did not arm: stopped"), "{problem}");
    assert!(problem.contains(" (armed for run of another, waiting for the start), "), "{problem}");
}

#[test]
fn a_robot_that_falls_silent_in_the_countdown_ends_the_run() {
    let mut bench = floor();
    armed(&mut bench);

    bench.silent.insert("robot_2");

    assert_eq!(
        bench.problems(),
        ["robot_2: did not arm: silent", "robot_2 (controller): did not arm: silent"]
    );
    assert!(!bench.notes.contains(&"running".to_owned()));
}

#[test]
fn a_robot_that_falls_silent_just_before_the_start_ends_the_run_as_soon_as_any_other() {
    let mut bench = floor();
    armed(&mut bench);
    while !bench.notes.contains(&"the robots move in 1 s".to_owned()) {
        bench.beat();
    }
    bench.beat();

    bench.silent.insert("robot_2");
    let silent_ms = bench.now_ms;
    while bench.state() != Some(LeaseState::Stopped) {
        bench.beat();
    }

    assert!(bench.notes.contains(&"running".to_owned()), "robot_1 has moved");
    assert!(bench.now_ms - silent_ms <= 1_700, "{} ms", bench.now_ms - silent_ms);
    let reason = "lost robot_2: silent for more than 1 s".to_owned();
    assert_eq!(bench.end().0, Outcome::Aborted { reason });
}

#[test]
fn a_robot_that_has_received_the_e_stop_reports_it_to_the_runner() {
    for robot_lost in [RobotLost::Abort, RobotLost::Note] {
        let mut bench = Bench::real_time(robot_lost);
        bench.run();

        bench.stop_cause = StopCause::EStop;
        bench.stopped.insert("robot_1");

        assert_eq!(bench.end().0, Outcome::Aborted { reason: "e-stop".to_owned() });
    }
}

fn pose(robot: &str, frame: &str, x_m: f64) -> Event {
    Event::Pose {
        robot: robot.to_owned(),
        frame: frame.to_owned(),
        pose: Pose { x_m, y_m: 0.0, heading_rad: 0.0 },
    }
}

/// Poses of the robots in turn: their frame, and their place along x in metres.
type Poses = &'static [(&'static str, f64)];

const ONE: Poses = &[("map", 0.5)];
const AT_THEIR_PLACES: Poses = &[("map", 0.5), ("map", 0.7)];
const ONE_OUTSIDE: Poses = &[("map", 0.5), ("map", 1.5)];
const IN_FRAMES_OF_THEIR_OWN: Poses = &[("robot_1/odom", 0.0), ("robot_2/odom", 0.0)];

fn give_poses(bench: &mut Bench, poses: &[(&str, f64)]) {
    for (robot, (frame, x_m)) in NAMES.into_iter().zip(poses) {
        bench.give(pose(robot, frame, *x_m));
    }
}

#[test]
fn poses_that_come_seldom_are_waited_for_and_their_rate_is_reported() {
    let mut bench = floor();

    for beat in 0..40 {
        if beat % 6 == 5 {
            bench.give(pose("robot_1", "map", 0.5));
            bench.give(pose("robot_2", "map", 0.7));
        }
        bench.beat();
    }

    for expected in [
        "all 2 robots stand where they should start",
        "poses of robot_1 come at 1.7 Hz, expected 10 Hz or more",
        "poses of robot_2 come at 1.7 Hz, expected 10 Hz or more",
    ] {
        assert!(bench.notes.iter().any(|text| text == expected), "{:?}", bench.notes);
    }
}

#[test]
fn the_operator_is_shown_where_the_robots_stand() {
    for (poses, expected) in [
        (&[][..], "start poses not checked: no pose was received"),
        (ONE, "robot_2: no pose received"),
        (AT_THEIR_PLACES, "all 2 robots stand where they should start"),
        (ONE_OUTSIDE, "robot_2: 1.50 m from the centre, expected at most 0.800 m"),
        (
            IN_FRAMES_OF_THEIR_OWN,
            "start poses not checked: they are in different frames, `robot_1/odom`, `robot_2/odom`",
        ),
    ] {
        let mut bench = floor();
        give_poses(&mut bench, poses);
        armed(&mut bench);

        assert!(bench.notes.iter().any(|text| text == expected), "{:?}", bench.notes);
    }
}

fn diagnosis(error: Option<&str>) -> Event {
    Event::Diagnosed {
        robot: "robot_1".to_owned(),
        part: "link".to_owned(),
        error: error.map(str::to_owned),
    }
}

#[test]
fn an_error_in_the_diagnostics_keeps_a_run_from_starting_until_it_is_gone() {
    let mut bench = floor();
    bench.give(diagnosis(Some("no answer")));
    assert_eq!(bench.problems(), ["robot_1: diagnostics: link: no answer"]);

    let mut bench = floor();
    bench.give(diagnosis(Some("no answer")));
    bench.give(diagnosis(None));
    armed(&mut bench);
}

#[test]
fn an_error_in_the_diagnostics_in_the_countdown_ends_it_before_anything_moves() {
    let mut bench = floor();
    armed(&mut bench);

    bench.give(diagnosis(Some("no answer")));

    assert_eq!(bench.problems(), ["robot_1: diagnostics: link: no answer"]);
    assert!(!bench.notes.contains(&"running".to_owned()));
}

#[test]
fn a_battery_that_falls_below_its_limit_ends_the_countdown_and_is_noted_in_the_run() {
    let low = "robot_2: battery at 6.20 V, expected at least 6.60 V";
    for is_running in [false, true] {
        let mut bench = Bench::with(|options| {
            options.length = RunLength::RealTime { duration: Duration::from_secs(4) };
            options.expected.simulator = false;
            options.expected.battery_min_v = [("robot_2".to_owned(), 6.6)].into();
            options.countdown = Duration::from_secs(3);
        });
        bench.battery_v = 7.4;
        armed(&mut bench);
        if is_running {
            bench.run();
        }

        bench.battery_v = 6.2;

        if is_running {
            assert_eq!(bench.end().0, Outcome::Completed);
            assert_eq!(bench.notes.iter().filter(|text| *text == low).count(), 1);
        } else {
            assert_eq!(bench.problems(), [low]);
            assert!(!bench.notes.contains(&"running".to_owned()));
        }
    }
}

#[test]
fn a_robot_whose_poses_never_came_is_refused_before_any_robot_moves() {
    let mut bench = Bench::with(|options| {
        options.length = RunLength::RealTime { duration: Duration::from_secs(4) };
        options.expected.simulator = false;
        options.countdown = Duration::from_secs(3);
        options.samples = [SampleKind::Pose].into();
    });
    bench.give(pose("robot_1", "map", 0.5));

    let problems = bench.problems();

    assert_eq!(problems.len(), 1, "{problems:?}");
    assert!(problems[0].starts_with("robot_2: no pose received before the start"), "{problems:?}");
    let moves = |text: &String| text == "running" || text.contains("move in");
    assert!(!bench.notes.iter().any(moves), "{:?}", bench.notes);
}

#[test]
fn an_error_in_the_diagnostics_during_a_run_is_reported_once() {
    let mut bench = floor();
    bench.run_from_the_countdown();

    bench.give(diagnosis(Some("no answer")));
    bench.give(diagnosis(Some("no answer")));

    let notes = bench.notes.iter().filter(|text| text.contains("link: no answer")).count();
    assert_eq!(notes, 1);
    assert_eq!(bench.end().0, Outcome::Completed);
}

impl Bench {
    fn run_from_the_countdown(&mut self) {
        armed(self);
        self.run();
    }
}

#[test]
fn robots_that_are_required_to_stand_at_their_places_are_not_armed_elsewhere() {
    let required = || {
        let mut bench = floor();
        bench.runner = Runner::new(RunnerOptions {
            place_check: PlaceCheck::Require,
            ..bench.runner.options.clone()
        });
        bench
    };
    for (poses, expected) in [
        (
            ONE,
            "robot_2: no pose received, so it is unknown whether it stands where it should start",
        ),
        (ONE_OUTSIDE, "robot_2: 1.50 m from the centre, expected at most 0.800 m"),
        (
            IN_FRAMES_OF_THEIR_OWN,
            "start poses are in different frames, `robot_1/odom`, `robot_2/odom`, and cannot be held \
             against their places",
        ),
    ] {
        let mut bench = required();
        give_poses(&mut bench, poses);

        assert_eq!(bench.problems(), [expected]);
        assert_eq!(bench.runner.epoch(), 0, "no robot was armed");
    }
    let mut bench = required();
    give_poses(&mut bench, AT_THEIR_PLACES);
    armed(&mut bench);
}
