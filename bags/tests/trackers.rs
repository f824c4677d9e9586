//! Poses of all robots in one message.

use std::fs;

use rsrs_bags::definitions::{Definition, Definitions};
use rsrs_bags::trajectory::Finding;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_msgs::RosMessage;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::Pose;
use rsrs_msgs::std_msgs::Header;
use serde::{Deserialize, Serialize};

use crate::recording::PERIOD_NS;
use crate::recording::damage::temporary;
use crate::recording::outcome::Foreign;

/// As `motion_capture_tracking_interfaces` has it.
#[derive(Clone, Serialize, Deserialize)]
struct Named {
    header: Header,
    poses: Vec<(String, Pose)>,
}

impl RosMessage for Named {
    const TYPE_NAME: &'static str = "motion_capture_tracking_interfaces/msg/NamedPoseArray";
}

/// As `geometry_msgs/msg/PoseArray` has it.
#[derive(Clone, Serialize, Deserialize)]
struct Unnamed {
    header: Header,
    poses: Vec<Pose>,
}

impl RosMessage for Unnamed {
    const TYPE_NAME: &'static str = "geometry_msgs/msg/PoseArray";
}

fn stamped(step: u64) -> Header {
    Header { stamp: Time::from_nanos(step * PERIOD_NS), frame_id: "world".into() }
}

fn at(x: f64, y: f64) -> Pose {
    let mut pose = Pose::default();
    (pose.position.x, pose.position.y) = (x, y);
    pose
}

/// A definition with the types in it, from folders of files like the stock ones.
fn tracker_definition(type_name: &str, named_pose: &str) -> Definition {
    let folder = temporary();
    let write = |file: &str, text: &str| {
        let path = folder.path().join(file);
        fs::create_dir_all(path.parent().expect("it is in a folder")).expect("room");
        fs::write(path, text).expect("room");
    };
    let package = "motion_capture_tracking_interfaces/msg";
    write(&format!("{package}/NamedPose.msg"), named_pose);
    write(
        &format!("{package}/NamedPoseArray.msg"),
        "std_msgs/Header header\nNamedPose[] poses # of rigid bodies\n",
    );
    write("geometry_msgs/msg/PoseArray.msg", "std_msgs/Header header\nPose[] poses\n");
    Definitions::new(vec![folder.path().to_owned()]).find(type_name).expect("it is there")
}

#[test]
fn a_tracker_that_names_its_bodies_gives_the_poses_of_the_robots_among_them() {
    let mut foreign = Foreign::new();
    let definition = tracker_definition(Named::TYPE_NAME, "string name\ngeometry_msgs/Pose pose\n");
    foreign.define("/poses", &definition);
    for step in 0..40 {
        let mut poses = vec![
            ("r2".to_owned(), at(step as f64 * 0.01, 2.0)),
            ("wand".to_owned(), at(9.0, 9.0)),
            ("r1".to_owned(), at(step as f64 * 0.01, 1.0)),
        ];
        if step == 20 {
            poses[0].1.position.x = f64::NAN;
        }
        foreign.put("/poses", step * PERIOD_NS, &Named { header: stamped(step), poses });
        foreign.command("r1", step * PERIOD_NS, 0.1);
        foreign.command("r2", step * PERIOD_NS, 0.1);
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
    let other = "uint32 id\nstring name\ngeometry_msgs/Pose pose\n";
    foreign.define("/poses", &tracker_definition(Named::TYPE_NAME, other));
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
        foreign.define("/poses", &tracker_definition(Unnamed::TYPE_NAME, ""));
        for step in 0..40 {
            let poses = (0..n_poses).map(|n| at(step as f64 * 0.01, n as f64)).collect();
            foreign.put("/poses", step * PERIOD_NS, &Unnamed { header: stamped(step), poses });
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
