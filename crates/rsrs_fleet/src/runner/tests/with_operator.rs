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
    assert!(bench.now_ms - silent_ms <= 1_200, "{} ms", bench.now_ms - silent_ms);
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
    for (events, expected) in [
        (vec![], "start poses not checked: no pose was received"),
        (vec![pose("robot_1", "map", 0.5)], "robot_2: no pose received"),
        (
            vec![pose("robot_1", "map", 0.5), pose("robot_2", "map", 0.7)],
            "all 2 robots stand where they should start",
        ),
        (
            vec![pose("robot_1", "map", 0.5), pose("robot_2", "map", 1.5)],
            "robot_2: 1.50 m from the centre, expected at most 0.800 m",
        ),
        (
            vec![pose("robot_1", "robot_1/odom", 0.0), pose("robot_2", "robot_2/odom", 0.0)],
            "start poses not checked: they are in different frames, `robot_1/odom`, `robot_2/odom`",
        ),
    ] {
        let mut bench = floor();
        for event in events {
            bench.give(event);
        }

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
