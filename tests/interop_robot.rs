//! A robot that is sixty lines of rclpy takes part in an experiment beside ours.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::command::repository;
use crate::fleet::{ROBOTS, experiment, node, start_run};
use crate::processes::{Process, assert_completed, fail_unless_moved, in_own_network, rsrs};
use crate::recorded::messages;
use rsrs_bags::Bag;
use rsrs_fleet::record::{ENDING, Ending, EndingKind};
use rsrs_msgs::geometry_msgs::{Point, PoseStamped, TwistStamped};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::std_msgs::Bool;
use rsrs_testing::python::{JAZZY, python_with};

const RUN_S: u64 = 8;
const SPEED_M_S: f64 = 0.15;

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

/// The example of a base driver, with other lines in it.
fn base(folder: &Path, changes: &[(&str, &str)]) -> PathBuf {
    let example = repository().join("docs/examples/rclpy_robot.py");
    let mut text = std::fs::read_to_string(example).expect("it is shipped");
    for (from, to) in changes {
        assert!(text.contains(from), "the example has no line with {from}");
        text = text.replace(from, to);
    }
    let path = folder.join("base.py");
    std::fs::write(&path, text).expect("writable");
    path
}

/// The base driver, and our node that lets commands through to it.
fn rclpy_robot(python: &Path, folder: &Path, script: &Path, cmd_vel_type: &str) -> [Process; 2] {
    let mut base = Command::new(python);
    for variable in ["ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY"] {
        base.env_remove(variable);
    }
    base.arg(script).arg("--ros-args");
    base.args(["-r", "__ns:=/robot_1", "-p", "others:=[robot_2, robot_3]", "-p", "x:=0.8"]);
    base.env("ROS_DOMAIN_ID", "42").env("ROS_LOG_DIR", folder.join("logs")).stdout(Stdio::null());
    let mut gate = rsrs();
    gate.args(["node", "robot", "--interface", "127.0.0.1", "--robots", ROBOTS[0]]);
    gate.args([
        "--driver",
        "ros",
        "--ros-args",
        "-p",
        &format!("ros.cmd_vel_type:={cmd_vel_type}"),
    ]);
    gate.stdout(Stdio::null());
    [base, gate].map(|mut command| Process(command.spawn().expect("the program is there")))
}

fn distance_m(from: &Point, to: &Point) -> f64 {
    libm::hypot(to.x - from.x, to.y - from.y)
}

/// The interpreter with what the example needs.
pub fn python() -> PathBuf {
    python_with(&JAZZY)
}

/// Runs two of our robots beside one in rclpy, the example with some changes, whose base driver is sent
/// messages of `cmd_vel_type`: how the run ended, what it printed, and its bag.
fn run_beside(
    python: &Path,
    folder: &Path,
    (changes, cmd_vel_type): (&[(&str, &str)], &str),
) -> (Option<i32>, String, PathBuf) {
    let experiment = mixed_experiment(folder);
    let bag = folder.join("bag");
    let _ours = [node("sim", &ROBOTS[1..3]), node("controller", &ROBOTS[1..3])];
    let _theirs = rclpy_robot(python, folder, &base(folder, changes), cmd_vel_type);
    run_on_fleet(&experiment, bag)
}

/// Runs an experiment on the fleet that is there; its exit code, what it wrote, and the bag.
pub fn run_on_fleet(experiment: &Path, bag: PathBuf) -> (Option<i32>, String, PathBuf) {
    let (status, printed) = start_run(experiment, &bag).wait();
    (status.code(), printed, bag)
}

#[test]
fn a_robot_in_sixty_lines_of_rclpy_takes_part_beside_ours_and_is_recorded() {
    // Outside the network namespace, where the package index can be reached.
    let python = python();
    in_own_network(async || takes_part(&python, (&[], "twist")));
}

#[test]
fn a_robot_that_publishes_as_sensors_do_and_takes_stamped_commands_takes_part() {
    let python = python();
    let changes = [
        ("Range, \"hardware/range\", 10)", "Range, \"hardware/range\", qos_profile_sensor_data)"),
        ("Odometry, \"odom\", 10)", "Odometry, \"odom\", qos_profile_sensor_data)"),
        ("self.see(n, m), 10)", "self.see(n, m), qos_profile_sensor_data)"),
        ("import Twist\n", "import TwistStamped\n"),
        ("subscription(Twist,", "subscription(TwistStamped,"),
        ("def obey(self, twist):\n", "def obey(self, stamped):\n        twist = stamped.twist\n"),
        ("import Node\n", "import Node\nfrom rclpy.qos import qos_profile_sensor_data\n"),
    ];
    in_own_network(async || takes_part(&python, (&changes, "twist_stamped")));
}

#[test]
fn a_robot_that_keeps_what_it_publishes_takes_part_and_one_that_asks_for_that_is_named() {
    let python = python();
    let kept = "QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)";
    let import = "import Node\nfrom rclpy.qos import DurabilityPolicy, QoSProfile\n";
    let odom = format!("Odometry, \"odom\", {kept})");
    let range = format!("Range, \"hardware/range\", {kept})");
    let publishes = [
        ("import Node\n", import),
        ("Odometry, \"odom\", 10)", odom.as_str()),
        ("Range, \"hardware/range\", 10)", range.as_str()),
    ];
    let obeys = format!("self.obey, {kept})");
    let asks = [("import Node\n", import), ("self.obey, 1)", obeys.as_str())];
    in_own_network(async || {
        takes_part(&python, (&publishes, "twist"));

        let folder = tempfile::tempdir().expect("a temporary folder");
        let (code, printed, _) = run_beside(&python, folder.path(), (&asks, "twist"));

        assert_eq!(code, Some(1), "{printed}");
        let named = "/robot_1/hardware/cmd_vel: /robot_1/base subscribes transient local, and \
                     /robot_1/robot publishes volatile: set the durability of the subscription to \
                     volatile";
        assert!(printed.contains(named), "{printed}");
    });
}

fn takes_part(python: &Path, how: (&[(&str, &str)], &str)) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (code, printed, bag) = run_beside(python, folder.path(), how);

    assert_completed(code, &printed);
    let bag = Bag::open(&bag).expect("the run was recorded");
    let ending = bag.metadata(ENDING).and_then(Ending::from_pairs);
    assert_eq!(ending.map(|ending| ending.kind), Some(EndingKind::Completed), "{printed}");
    for robot in &ROBOTS[..3] {
        check_robot(&bag, robot);
    }
}

/// It sensed, was commanded as it sensed, and went where it was commanded.
fn check_robot(bag: &Bag, robot: &str) {
    let detections = messages::<Bool>(bag, robot, "detection");
    let commands = messages::<TwistStamped>(bag, robot, "cmd_vel");
    let poses = messages::<Odometry>(bag, robot, "odom");

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

/// A fleet of plain rclpy robots without a gate of ours: what they command, and how each subscribes and
/// publishes.
const KINDS: [(&str, &str, &str); 8] = [
    ("twist", "default", "default"),
    ("twist", "sensor", "sensor"),
    ("twist", "depth_1", "kept"),
    ("twist", "default", "depth_1"),
    ("twist_stamped", "default", "default"),
    ("twist_stamped", "sensor", "sensor"),
    ("twist_stamped", "depth_1", "kept"),
    ("twist_stamped", "default", "depth_1"),
];

/// Runs a fleet of foreign robots, of which the simulator has none: how the run ended, what it printed,
/// and its bag.
///
/// `bases` is what the robots really are, while the fleet file and the controllers are those of [`KINDS`];
/// `pose` is the topic by which the fleet file takes where they are.
fn run_of_bases(
    python: &Path,
    folder: &Path,
    (bases, pose): (&[(&str, &str, &str)], &str),
) -> (Option<i32>, String, PathBuf) {
    let (poses, tracked) = (format!("pose: {pose}"), if pose == "pose" { ":tracked" } else { "" });
    let lines: Vec<(String, String)> = KINDS
        .iter()
        .zip(ROBOTS)
        .map(|((commands, _, _), robot)| {
            let plain = format!("{robot}: {{enabled: true, type: flockbot");
            (format!("{plain}}}"), format!("{plain}, cmd_vel: {commands}, lease: controller}}"))
        })
        .collect();
    let mut changes = vec![
        ("robots: 9", "robots: 8"),
        ("time: lockstep", "time: real_time"),
        ("driver: {kind: virtual}", "driver: {kind: ros}"),
        ("robot_9: {enabled: true", "robot_9: {enabled: false"),
        ("pose: odom", poses.as_str()),
    ];
    changes.extend(lines.iter().map(|(from, to)| (from.as_str(), to.as_str())));
    let experiment = experiment(folder, RUN_S, &changes);
    let bag = folder.join("bag");

    let of_base = |((commands, subscribes, publishes), robot): (&(&str, &str, &str), &str)| {
        format!("{robot}:{commands}:{subscribes}:{publishes}{tracked}")
    };
    let _robots = foreign_robots(python, folder, bases.iter().zip(ROBOTS).map(of_base));
    let _controllers = ["twist", "twist_stamped"].map(|commands| {
        let of_type = KINDS.iter().zip(ROBOTS).filter(|((kind, _, _), _)| *kind == commands);
        let names: Vec<&str> = of_type.map(|(_, robot)| robot).collect();
        controllers_with_leases(&names, commands)
    });
    run_on_fleet(&experiment, bag)
}

/// Robots of `tests/interop/robots.py`, by its arguments.
pub fn foreign_robots(
    python: &Path,
    folder: &Path,
    arguments: impl IntoIterator<Item = String>,
) -> Process {
    let mut robots = Command::new(python);
    for variable in ["ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY"] {
        robots.env_remove(variable);
    }
    robots.arg(repository().join("tests/interop/robots.py")).args(arguments);
    robots.env("ROS_DOMAIN_ID", "42").env("ROS_LOG_DIR", folder.join("logs")).stdout(Stdio::null());
    Process(robots.spawn().expect("the interpreter is there"))
}

/// The controllers of robots without a gate.
pub fn controllers_with_leases(robots: &[&str], commands: &str) -> Process {
    let mut controllers = rsrs();
    controllers.args(["node", "controller", "--interface", "127.0.0.1"]);
    controllers.args(["--robots", &robots.join(","), "--ros-args", "-p", "lease:=controller"]);
    controllers.args(["-p", &format!("cmd_vel_type:={commands}")]).stdout(Stdio::null());
    Process(controllers.spawn().expect("the program was built for this test"))
}

#[test]
fn rclpy_robots_of_every_sensible_quality_take_part_and_those_that_cannot_are_named() {
    let python = python();
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (code, printed, bag) = run_of_bases(&python, folder.path(), (&KINDS, "odom"));
        assert_completed(code, &printed);
        let bag = Bag::open(&bag).expect("the run was recorded");
        let at_least = RUN_S * 6;
        let topics = bag.topics();
        for robot in &ROBOTS[..KINDS.len()] {
            for topic in ["detection", "cmd_vel", "odom"] {
                let name = format!("/{robot}/{topic}");
                let n = topics.iter().find(|it| it.name == name).map_or(0, |it| it.n_messages);
                assert!(n >= at_least, "{n} messages on {name}");
            }
            let poses = messages::<Odometry>(&bag, robot, "odom");
            let ends = [&poses[0], &poses[poses.len() - 1]].map(|it| it.pose.pose.position);
            fail_unless_moved(robot, distance_m(&ends[0], &ends[1]), 0.05);
        }

        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut bases = KINDS;
        bases[0].1 = "kept";
        bases[5].0 = "twist";
        let (code, printed, _) = run_of_bases(&python, folder.path(), (&bases, "odom"));
        assert_eq!(code, Some(1), "{printed}");
        for named in [
            "/robot_1/cmd_vel: /robot_1/base subscribes transient local, and /robot_1/controller \
             publishes volatile: set the durability of the subscription to volatile",
            "/robot_6/cmd_vel: /robot_6/base waits for geometry_msgs/msg/Twist, and \
             geometry_msgs/msg/TwistStamped is sent: set `cmd_vel: twist` in the fleet file, and \
             start the controller with `-p cmd_vel_type:=twist`",
        ] {
            assert!(printed.contains(named), "{printed}");
        }
        assert!(!printed.contains("/robot_2"), "{printed}");
    });
}

#[test]
fn rclpy_robots_with_odometry_and_a_tracker_are_judged_by_the_poses_of_the_fleet_file() {
    let python = python();
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (code, printed, bag) = run_of_bases(&python, folder.path(), (&KINDS, "pose"));
        assert_completed(code, &printed);
        let bag_path = bag.display().to_string();
        let label = |more: &[&str]| {
            let output = rsrs().arg("label").arg(&bag_path).args(more).output();
            String::from_utf8_lossy(&output.expect("the program was built").stderr).into_owned()
        };

        // Such a run is too short for a label, which is looked at after the poses.
        let (by_record, by_odometry) = (label(&[]), label(&["--poses", "odom"]));

        let bag = Bag::open(&bag).expect("the run was recorded");
        for robot in &ROBOTS[..KINDS.len()] {
            assert!(messages::<Odometry>(&bag, robot, "odom").len() > 20, "both are recorded");
            assert!(messages::<PoseStamped>(&bag, robot, "pose").len() > 20, "both are recorded");
        }
        assert!(by_record.contains("expected at least 60"), "{by_record}");
        assert!(by_odometry.contains("start on one spot"), "{by_odometry}");
    });
}
