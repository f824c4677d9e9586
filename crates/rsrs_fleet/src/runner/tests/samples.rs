//! Detections that never come, or come no more.

use rsrs_core::robot::unicycle::Pose;

use super::*;

/// A run of robots whose detections are watched.
fn sampled(robot_lost: RobotLost) -> Bench {
    Bench::with(|options| {
        options.length = RunLength::RealTime { duration: Duration::from_secs(8) };
        options.robot_lost = robot_lost;
        options.samples = [SampleKind::Detection].into();
    })
}

fn detection(robot: &str) -> Event {
    Event::Sampled { robot: robot.to_owned(), kind: SampleKind::Detection }
}

#[test]
fn a_run_begins_when_the_pose_of_every_robot_can_be_used() {
    let pose = Pose { x_m: 1.0, y_m: 0.0, heading_rad: 0.0 };
    let (robot, frame) = ("robot_1".to_owned(), "map".to_owned());
    for is_corrected in [false, true] {
        let mut bench = Bench::with(|options| {
            let robots = NAMES.map(str::to_owned).into();
            options.expected.apart = Some(preflight::Apart { robots, radius_m: 0.1 });
        });
        let reason = "no orientation".to_owned();
        bench.give(Event::PoseUnusable { robot: robot.clone(), reason });
        bench.beat();

        if is_corrected {
            bench.give(Event::Pose { robot: robot.clone(), frame: frame.clone(), pose });
            bench.run();
        } else {
            assert_eq!(bench.problems(), ["robot_1: its pose cannot be used: no orientation"]);
        }
    }
}

#[test]
fn no_robot_moves_where_the_first_pose_comes_late_and_cannot_be_used() {
    let mut bench = Bench::with(|options| {
        let robots = NAMES.map(str::to_owned).into();
        options.expected.apart = Some(preflight::Apart { robots, radius_m: 0.1 });
    });
    for _ in 0..40 {
        if bench.opened {
            break;
        }
        bench.beat();
    }

    let reason = "no orientation".to_owned();
    bench.give(Event::PoseUnusable { robot: "robot_2".to_owned(), reason });

    assert_eq!(bench.problems(), ["robot_2: its pose cannot be used: no orientation"]);
    assert!(!bench.notes.iter().any(|note| note == "running"), "{:?}", bench.notes);
}

#[test]
fn a_run_without_a_detection_since_its_start_has_failed() {
    let mut bench = sampled(RobotLost::Note);
    // What was detected before the start moved no robot.
    for name in NAMES {
        bench.give(detection(name));
    }
    bench.run();
    let start_ms = bench.now_ms;

    let mut beats = 0;
    while bench.finish.is_none() {
        bench.give(detection("robot_1"));
        bench.beat();
        beats += 1;
        assert!(beats < 100, "it goes on for ever");
    }

    let problems = bench.problems();
    assert_eq!(problems.len(), 1, "{problems:?}");
    assert!(problems[0].starts_with("robot_2: no detection received since the start"));
    assert!((5_000..5_500).contains(&(bench.now_ms - start_ms)));
}

#[test]
fn a_robot_of_which_one_of_several_sensors_falls_silent_is_lost() {
    let wall = SampleKind::FurtherDetection("wall".to_owned());
    for (robot_lost, silent, what) in [
        (RobotLost::Abort, SampleKind::Detection, "detection"),
        (RobotLost::Note, SampleKind::Detection, "detection"),
        (RobotLost::Note, wall.clone(), "detection/wall"),
    ] {
        let mut bench = sampled(robot_lost);
        bench.runner.options.samples.insert(wall.clone());
        bench.run();
        for beat in 0..300 {
            if bench.finish.is_some() {
                break;
            }
            for (name, kind) in NAMES
                .into_iter()
                .flat_map(|name| [SampleKind::Detection, wall.clone()].map(|kind| (name, kind)))
            {
                if name != "robot_2" || kind != silent || beat < 20 {
                    bench.give(Event::Sampled { robot: name.to_owned(), kind });
                }
            }
            bench.beat();
        }

        let (outcome, _) = bench.end();
        assert_eq!(outcome == Outcome::Completed, robot_lost == RobotLost::Note, "{outcome:?}");
        let [lost] = bench.runner.lost() else { panic!("{:?}", bench.runner.lost()) };
        let expected = format!("robot_2 lost after 5.0 s: no {what} received for more than 3 s");
        assert_eq!(lost.to_string(), expected);
    }
}
