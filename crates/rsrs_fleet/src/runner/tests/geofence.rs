//! Robots that must not leave a part of the floor.

use rsrs_core::robot::unicycle::Pose;

use super::*;
use crate::geofence::Geofence;

fn fenced(robot_lost: RobotLost) -> Bench {
    Bench::with(|options| {
        options.length = RunLength::RealTime { duration: Duration::from_secs(4) };
        options.robot_lost = robot_lost;
        options.expected.simulator = false;
        options.expected.geofence = Some(Geofence { x_m: [-1.0, 1.0], y_m: [-1.0, 1.0] });
    })
}

fn pose(robot: &str, frame: &str, x_m: f64) -> Event {
    let pose = Pose { x_m, y_m: 0.5, heading_rad: 0.0 };
    Event::Pose { robot: robot.to_owned(), frame: frame.to_owned(), pose }
}

/// A run in which `robot_2` is at these places, ten times a second.
fn at_places(robot_lost: RobotLost, places: &[f64]) -> Bench {
    let mut bench = fenced(robot_lost);
    for name in NAMES {
        bench.give(pose(name, "map", 0.0));
    }
    bench.run();
    for x_m in places {
        bench.give(pose("robot_1", "map", 0.0));
        bench.give(pose("robot_2", "map", *x_m));
        bench.beat();
    }
    bench
}

#[test]
fn a_robot_that_leaves_the_geofence_is_lost_and_one_bad_pose_is_none() {
    for robot_lost in [RobotLost::Note, RobotLost::Abort] {
        let mut left = at_places(robot_lost, &[0.9, 1.1, 1.2, 1.3]);

        let [lost] = left.runner.lost() else { panic!("{:?}", left.notes) };
        assert_eq!(lost.robot, "robot_2");
        assert_eq!(lost.reason, "left the geofence, at (1.30, 0.50) m");
        let named: Vec<_> = left
            .lease
            .iter()
            .flat_map(|lease| lease.robots.iter().map(|echo| echo.robot.as_str()))
            .collect();
        assert_eq!(named.contains(&"robot_2"), robot_lost == RobotLost::Abort, "{named:?}");
        let is_completed = left.end().0 == Outcome::Completed;
        assert_eq!(is_completed, robot_lost == RobotLost::Note);
    }

    let mut jumped = at_places(RobotLost::Abort, &[0.9, 7.0, 0.9, 0.9, 7.0, 7.0, 0.9]);
    assert_eq!(jumped.end().0, Outcome::Completed, "{:?}", jumped.notes);
}

#[test]
fn a_robot_whose_last_pose_is_outside_is_lost_a_second_later() {
    let mut bench = at_places(RobotLost::Note, &[0.9, 1.4]);
    assert_eq!(bench.runner.lost(), []);

    (0..11).for_each(|_| bench.beat());

    let [lost] = bench.runner.lost() else { panic!("{:?}", bench.notes) };
    assert_eq!(lost.reason, "left the geofence, at (1.40, 0.50) m");
}

#[test]
fn no_robot_moves_while_one_is_outside_or_nobody_knows_where_inside_is() {
    let outside = "robot_2: at (1.50, 0.50) m, outside of the fleet file's `geofence`";
    let frames = "the fleet file's `geofence` is in the frame of the poses, and these are in `a`, \
                  `b`: publish them in one frame, as a tracker does, or take the geofence out";
    for (frame, x_m, expected) in [("a", 1.5, outside), ("b", 0.5, frames)] {
        for since in ["", "arming", "the robots move in 1 s"] {
            let mut bench = fenced(RobotLost::Abort);
            bench.runner.options.countdown = Duration::from_secs(3);
            for robot in NAMES {
                bench.give(pose(robot, "a", if robot == "robot_1" { -0.5 } else { 0.5 }));
            }
            while !since.is_empty() && !bench.notes.iter().any(|text| text.starts_with(since)) {
                bench.beat();
            }
            bench.give(pose("robot_2", frame, x_m));

            let problems = bench.problems();

            assert!(problems.iter().any(|text| text == expected), "{since}: {problems:?}");
            assert!(!bench.notes.contains(&"running".to_owned()));
        }
    }
}
