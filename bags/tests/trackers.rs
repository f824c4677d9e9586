//! Poses of all robots in one message.

use std::collections::BTreeMap;
use std::fs;

use rsrs_bags::definitions::Definitions;
use rsrs_bags::trajectory::{Finding, RecordedTracker, TrajectoryOptions};
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::tracker::{Tracker, TrackerFrame};
use rsrs_msgs::RosMessage;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::{
    Pose, PoseArray, PoseStamped, Transform, TransformStamped, Vector3,
};
use rsrs_msgs::motion_capture_tracking_interfaces::{NamedPose, NamedPoseArray};
use rsrs_msgs::std_msgs::Header;
use rsrs_msgs::tf2_msgs::TFMessage;

use crate::recording::PERIOD_NS;
use crate::recording::damage::temporary;
use crate::recording::outcome::Foreign;

fn stamped(step: u64) -> Header {
    Header { stamp: Time::from_nanos(step * PERIOD_NS), frame_id: "world".into() }
}

/// Both robots are commanded the same.
fn commands(foreign: &mut Foreign, step: u64) {
    for robot in ["r1", "r2"] {
        foreign.command(robot, step * PERIOD_NS, 0.1);
    }
}

fn at(x: f64, y: f64) -> Pose {
    let mut pose = Pose::default();
    (pose.position.x, pose.position.y) = (x, y);
    pose
}

fn named(name: &str, pose: Pose) -> NamedPose {
    NamedPose { name: name.to_owned(), pose }
}

#[test]
fn a_tracker_that_names_its_bodies_gives_the_poses_of_the_robots_among_them() {
    let mut foreign = Foreign::new();
    for step in 0..40 {
        let mut poses = vec![
            named("r2", at(step as f64 * 0.01, 2.0)),
            named("wand", at(9.0, 9.0)),
            named("r1", at(step as f64 * 0.01, 1.0)),
        ];
        if step == 20 {
            poses[0].pose.position.x = f64::NAN;
        }
        foreign.put("/poses", step * PERIOD_NS, &NamedPoseArray { header: stamped(step), poses });
        commands(&mut foreign, step);
    }

    let read = foreign.read().unwrap();

    assert_eq!(
        (read.poses, &read.robots[..]),
        (PoseSource::NamedPoses, &["r1", "r2"].map(String::from)[..])
    );
    assert!(read.findings.contains(&Finding::Ignored { name: "wand".into() }));
    assert_eq!(read.trajectory.n_samples(), 40);
    let last = read.trajectory.poses_at(39);
    assert!((last[0].y_m - 1.0).abs() < 1e-12 && (last[1].y_m - 2.0).abs() < 1e-12);
}

#[test]
fn a_named_pose_of_another_make_is_refused_rather_than_guessed() {
    let mut foreign = Foreign::new();
    let folder = temporary();
    let package = folder.path().join("motion_capture_tracking_interfaces/msg");
    fs::create_dir_all(&package).expect("room");
    let other = "uint32 id\nstring name\ngeometry_msgs/Pose pose\n";
    fs::write(package.join("NamedPose.msg"), other).expect("room");
    let array = "std_msgs/Header header\nNamedPose[] poses # of rigid bodies\n";
    fs::write(package.join("NamedPoseArray.msg"), array).expect("room");
    let definitions = Definitions::new(vec![folder.path().to_owned()]);
    foreign.define("/poses", &definitions.find(NamedPoseArray::TYPE_NAME).expect("it is there"));
    foreign.command("r1", 0, 0.1);

    let error = foreign.read().unwrap_err();

    assert_eq!(
        error.to_string(),
        "the poses on /poses have the fields uint32 id, string name, geometry_msgs/Pose pose, \
         expected string name, geometry_msgs/Pose pose"
    );
}

#[test]
fn poses_without_names_are_those_of_the_robots_in_their_order() {
    let recorded = |n_poses: usize| {
        let mut foreign = Foreign::new();
        for step in 0..40 {
            let poses = (0..n_poses).map(|n| at(step as f64 * 0.01, n as f64)).collect();
            foreign.put("/poses", step * PERIOD_NS, &PoseArray { header: stamped(step), poses });
            foreign.command("r10", step * PERIOD_NS, 0.1);
            foreign.command("r2", step * PERIOD_NS, 0.1);
        }
        foreign.read()
    };

    let read = recorded(2).unwrap();
    let error = recorded(3).unwrap_err();

    assert_eq!(read.robots, ["r2", "r10"]);
    let y_m: Vec<f64> = read.trajectory.poses_at(5).iter().map(|pose| pose.y_m).collect();
    assert_eq!(y_m, [0.0, 1.0]);
    assert_eq!(error.to_string(), "/poses has 3 poses without names for 2 robots");
}

#[test]
fn an_array_without_names_whose_length_changes_is_refused() {
    let mut foreign = Foreign::new();
    for step in 0..40 {
        let n_poses = if step == 20 { 1 } else { 2 };
        let poses = (0..n_poses).map(|n| at(step as f64 * 0.01, f64::from(n))).collect();
        foreign.put("/poses", step * PERIOD_NS, &PoseArray { header: stamped(step), poses });
        commands(&mut foreign, step);
    }

    let error = foreign.read().unwrap_err().to_string();

    assert!(error.starts_with("a message on /poses at 2."), "{error}");
    assert!(error.contains("it has 1 poses, expected 2"), "{error}");
}

/// A tracker of two robots, as a record describes it.
fn described(source: PoseSource, tracker: Tracker) -> TrajectoryOptions {
    let robots = ["r1", "r2"].map(String::from).to_vec();
    TrajectoryOptions {
        poses: Some(source),
        tracker: Some(RecordedTracker { tracker, robots, radius_m: 0.1 }),
        ..TrajectoryOptions::default()
    }
}

/// In millimetres with y up; the floor's y is against the tracker's z.
fn y_up_millimetres() -> TrackerFrame {
    let axes = ["x", "-z", "y"].map(str::to_owned);
    TrackerFrame {
        axes: axes.try_into().expect("they are right-handed"),
        scale: 0.001,
        offset_m: [-1.0, 2.0],
        ..TrackerFrame::default()
    }
}

/// As such a tracker sees a robot that is on the floor there.
fn seen_from_y_up(x_m: f64, y_m: f64, heading_rad: f64) -> Pose {
    let mut pose = Pose::default();
    (pose.position.x, pose.position.y, pose.position.z) =
        ((x_m + 1.0) * 1000.0, 55.0, -(y_m - 2.0) * 1000.0);
    (pose.orientation.y, pose.orientation.w) = libm::sincos(heading_rad / 2.0);
    pose
}

#[test]
fn a_frame_with_y_up_in_millimetres_is_laid_on_the_floor_for_arrays_topics_and_transforms() {
    for source in [PoseSource::PoseArray, PoseSource::Pose, PoseSource::Tf] {
        let mut foreign = Foreign::new();
        for step in 0..40 {
            let x_m = step as f64 * 0.01;
            let [one, other] = [(0.0, 0.5), (0.7, -0.5)]
                .map(|(y_m, heading_rad)| seen_from_y_up(x_m, y_m, heading_rad));
            match source {
                PoseSource::PoseArray => {
                    let poses = vec![other, seen_from_y_up(9.0, 9.0, 0.0), one];
                    let header = stamped(step);
                    foreign.put("/mocap", step * PERIOD_NS, &PoseArray { header, poses });
                }
                PoseSource::Pose => {
                    for (topic, pose) in [("/vrpn/Body1/pose", one), ("/vrpn/r2/pose", other)] {
                        let message = PoseStamped { header: stamped(step), pose };
                        foreign.put(topic, step * PERIOD_NS, &message);
                    }
                }
                _ => {
                    let edge = |child: &str, pose: Pose| TransformStamped {
                        header: stamped(step),
                        child_frame_id: child.into(),
                        transform: Transform {
                            translation: Vector3 {
                                x: pose.position.x,
                                y: pose.position.y,
                                z: pose.position.z,
                            },
                            rotation: pose.orientation,
                        },
                    };
                    // What a robot estimates by itself does not count.
                    let own = TransformStamped {
                        header: Header { frame_id: "r2/odom".into(), ..stamped(step) },
                        ..edge("r2/elsewhere", Pose::default())
                    };
                    let transforms = vec![edge("Body1", one), edge("r2/base_link", other), own];
                    foreign.put("/tf", step * PERIOD_NS, &TFMessage { transforms });
                }
            }
            commands(&mut foreign, step);
        }
        let mut tracker = Tracker {
            bodies: BTreeMap::from([("r1".to_owned(), "Body1".to_owned())]),
            frame: y_up_millimetres(),
            ..Tracker::default()
        };
        match source {
            PoseSource::PoseArray => {
                tracker.topics = vec!["/mocap".to_owned()];
                tracker.names = ["r2", "box", "Body1"].map(str::to_owned).to_vec();
            }
            PoseSource::Pose => tracker.topics = vec!["/vrpn/{body}/pose".to_owned()],
            _ => tracker.parent = Some("world".to_owned()),
        }

        let read = foreign.read_with(&described(source, tracker)).unwrap();

        assert_eq!((read.poses, &read.robots[..]), (source, &["r1", "r2"].map(String::from)[..]));
        let last = read.trajectory.poses_at(39);
        for (pose, (y_m, heading_rad)) in last.iter().zip([(0.0, 0.5), (0.7, -0.5)]) {
            assert!((pose.x_m - 0.39).abs() < 1e-9, "{source}: {pose:?}");
            assert!((pose.y_m - y_m).abs() < 1e-9, "{source}: {pose:?}");
            assert!((pose.heading_rad - heading_rad).abs() < 1e-9, "{source}: {pose:?}");
        }
    }
}

#[test]
fn a_robot_that_is_handed_from_one_machine_to_another_has_one_trajectory() {
    let mut foreign = Foreign::new();
    for step in 0..60 {
        let x_m = step as f64 * 0.01;
        let by_machine = [("/a/poses", step < 40, 0.0), ("/b/poses", step > 20, 0.004)];
        for (topic, sees, error_m) in by_machine {
            let mut poses = vec![named("r2", at(x_m, 1.0))];
            if sees {
                poses.push(named("r1", at(x_m + error_m, 0.0)));
            }
            let message = NamedPoseArray { header: stamped(step), poses };
            foreign.put(topic, step * PERIOD_NS, &message);
        }
        commands(&mut foreign, step);
    }
    let topics = ["/a/poses", "/b/poses"].map(str::to_owned).to_vec();
    let tracker = Tracker { topics, ..Tracker::default() };

    let read = foreign.read_with(&described(PoseSource::NamedPoses, tracker)).unwrap();

    let x_m = |sample| read.trajectory.poses_at(sample)[0].x_m;
    assert!((x_m(30) - 0.30).abs() < 1e-9, "the first machine is kept while it sees the robot");
    assert!((x_m(50) - 0.504).abs() < 1e-9, "then the other one takes over");
    assert!(!read.findings.iter().any(|it| matches!(it, Finding::Apart { .. })));
}

#[test]
fn machines_that_see_a_robot_in_two_places_are_a_finding() {
    let mut foreign = Foreign::new();
    for step in 0..40 {
        for (topic, error_m) in [("/r1/a", 0.0), ("/r1/b", 0.25), ("/r2/a", 0.0), ("/r2/b", 0.05)] {
            let y_m = if topic.starts_with("/r2") { 1.0 } else { 0.0 };
            let pose = at(step as f64 * 0.01 + error_m, y_m);
            foreign.put(topic, step * PERIOD_NS, &PoseStamped { header: stamped(step), pose });
        }
        commands(&mut foreign, step);
    }
    let tracker = Tracker { topics: ["a", "b"].map(str::to_owned).to_vec(), ..Tracker::default() };

    let read = foreign.read_with(&described(PoseSource::Pose, tracker)).unwrap();

    let apart: Vec<String> = read
        .findings
        .iter()
        .filter(|it| matches!(it, Finding::Apart { .. }))
        .map(ToString::to_string)
        .collect();
    assert_eq!(
        apart,
        [
            "r1: up to 0.25 m apart by /r1/a, which counts, and by /r1/b: calibrate the tracker's machines"
        ]
    );
    assert!((read.trajectory.poses_at(39)[0].x_m - 0.39).abs() < 1e-9);
}

#[test]
fn a_bag_without_the_topics_of_its_tracker_names_what_it_should_have() {
    let mut foreign = Foreign::new();
    foreign.put("/r1/pose", 0, &PoseStamped { header: stamped(0), pose: at(0.0, 0.0) });
    foreign.command("r1", 0, 0.1);

    let tracker = Tracker { topics: vec!["/mocap".to_owned()], ..Tracker::default() };
    let error = foreign.read_with(&described(PoseSource::NamedPoses, tracker)).unwrap_err();

    assert!(
        error.to_string().starts_with(
            "the bag has no poses of its tracker: expected /mocap \
             (motion_capture_tracking_interfaces/msg/NamedPoseArray), among its topics: "
        ),
        "{error}"
    );
}
