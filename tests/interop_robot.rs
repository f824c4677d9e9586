//! A robot that is sixty lines of rclpy takes part in an experiment beside ours.

#[expect(dead_code, reason = "these tests end no process by a signal")]
mod fleet;
#[expect(dead_code, reason = "these tests do not look for what a program leaves behind")]
mod processes;
mod recorded;
#[path = "../nodes/ros/tests/support/mod.rs"]
#[expect(dead_code, reason = "these tests open no session of their own")]
mod support;
#[path = "../msgs/tests/venv/mod.rs"]
mod venv;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use fleet::{ROBOTS, experiment, node};
use processes::{Process, rsrs};
use recorded::messages;
use rsrs_bags::Bag;
use rsrs_fleet::record::{ENDING, Ending, EndingKind};
use rsrs_msgs::geometry_msgs::{Point, TwistStamped};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::std_msgs::Bool;
use support::in_own_network;
use venv::python_with;

/// Far longer than anything here takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(90);
const RUN_S: u64 = 8;
const SPEED_M_S: f64 = 0.15;

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The fleet of the run: the first robot has the base driver in rclpy, the simulator moves the others.
fn mixed_experiment(folder: &Path) -> PathBuf {
    let changes = [
        ("robots: 9", "robots: 3"),
        ("time: lockstep", "time: real_time"),
        (
            "robot_1: {enabled: true, type: flockbot}",
            "robot_1: {enabled: true, type: flockbot, driver: {kind: ros}}",
        ),
    ];
    experiment(folder, RUN_S, &changes)
}

/// The base driver, and our node that lets commands through to it.
fn rclpy_robot(python: &Path, logs: &Path) -> [Process; 2] {
    let mut base = Command::new(python);
    for variable in ["ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY"] {
        base.env_remove(variable);
    }
    base.arg(repository().join("docs/examples/rclpy_robot.py")).arg("--ros-args");
    base.args(["-r", "__ns:=/robot_1", "-p", "others:=[robot_2, robot_3]", "-p", "x:=0.8"]);
    base.env("ROS_DOMAIN_ID", "42").env("ROS_LOG_DIR", logs).stdout(Stdio::null());
    let mut gate = rsrs();
    gate.args(["node", "robot", "--interface", "127.0.0.1", "--robots", ROBOTS[0]]);
    gate.args(["--driver", "ros"]).stdout(Stdio::null());
    [base, gate].map(|mut command| Process(command.spawn().expect("the program is there")))
}

fn distance_m(from: &Point, to: &Point) -> f64 {
    libm::hypot(to.x - from.x, to.y - from.y)
}

#[test]
fn a_robot_in_sixty_lines_of_rclpy_takes_part_beside_ours_and_is_recorded() {
    let packages = [
        "ros-jazzy-rclpy[fastrtps]==7.1.6",
        "ros-jazzy-std-msgs==5.3.6",
        "ros-jazzy-geometry-msgs==5.3.6",
        "ros-jazzy-nav-msgs==5.3.6",
        "ros-jazzy-sensor-msgs==5.3.6",
    ];
    // Outside the network namespace, where the package index can be reached.
    let python = python_with("rclpy-robot", &packages, &[]);
    let name = "a_robot_in_sixty_lines_of_rclpy_takes_part_beside_ours_and_is_recorded";
    in_own_network(name, async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let experiment = mixed_experiment(folder.path());
        let bag = folder.path().join("bag");
        let _ours = [node("sim", &ROBOTS[1..3]), node("controller", &ROBOTS[1..3])];
        let _theirs = rclpy_robot(&python, folder.path());
        let mut command = rsrs();
        command.args(["run", "--backend", "fleet", "--interface", "127.0.0.1"]);
        let mut run = Process::start(command.arg(experiment).arg("-o").arg(&bag));

        let (status, said) = run.wait(PATIENCE);

        assert!(status.success(), "{said}");
        let bag = Bag::open(&bag).expect("the run was recorded");
        let ending = bag.metadata(ENDING).and_then(Ending::from_pairs);
        assert_eq!(ending.map(|ending| ending.kind), Some(EndingKind::Completed), "{said}");
        for robot in &ROBOTS[..3] {
            check_robot(&bag, robot);
        }
    });
}

/// It sensed, was commanded as it sensed, and went where it was told.
fn check_robot(bag: &Bag, robot: &str) {
    let detections = messages::<Bool>(bag, (robot, "detection"));
    let commands = messages::<TwistStamped>(bag, (robot, "cmd_vel"));
    let poses = messages::<Odometry>(bag, (robot, "odom"));

    // One in 130 ms, 7.7 in a second; of odometry, at least as many.
    let at_least = usize::try_from(RUN_S * 6).expect("the run is short");
    for (topic, n_messages) in
        [("detection", detections.len()), ("cmd_vel", commands.len()), ("odom", poses.len())]
    {
        assert!(n_messages >= at_least, "{robot}: {n_messages} of {topic}");
    }
    let n_moving = commands.iter().filter(|command| command.twist.linear.x > 0.0).count();
    assert!(n_moving >= at_least, "{robot}: {n_moving} commands to move");
    let path_m: f64 = poses
        .windows(2)
        .map(|pair| distance_m(&pair[0].pose.pose.position, &pair[1].pose.pose.position))
        .sum();
    let expected_m = SPEED_M_S * RUN_S as f64;
    assert!((0.6..1.1).contains(&(path_m / expected_m)), "{robot} went {path_m:.2} m");
}
