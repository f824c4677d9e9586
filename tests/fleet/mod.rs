//! The shipped fleet: its robots, its experiment, and its nodes as processes.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use rsrs_msgs::geometry_msgs::PoseStamped;
use rsrs_msgs::topics;
use rsrs_ros::clock::wall_time;
use rsrs_ros::session::{Publisher, Session};

use crate::command::{shipped, text_in};
use crate::processes::{Process, rsrs};

/// Names of the robots of the shipped fleet.
pub const ROBOTS: [&str; 9] = [
    "robot_1", "robot_2", "robot_3", "robot_4", "robot_5", "robot_6", "robot_7", "robot_8",
    "robot_9",
];

/// Copies the shipped files, with another duration of the experiment and other changes, and returns the
/// path of the experiment file.
pub fn experiment(folder: &Path, duration_s: u64, changes: &[(&str, &str)]) -> PathBuf {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../launch_configs");
    for file in
        ["profiles/flockbot.yaml", "fleets/nine_virtual.yaml", "experiments/flockbot_milling.yaml"]
    {
        let text = text_in(&shipped, file);
        let mut text = text.replace("duration_s: 300", &format!("duration_s: {duration_s}"));
        for (from, to) in changes {
            text = text.replace(from, to);
        }
        let path = folder.join(file);
        std::fs::create_dir_all(path.parent().expect("it has a folder")).expect("writable");
        std::fs::write(path, text).expect("writable");
    }
    folder.join("experiments/flockbot_milling.yaml")
}

/// Changes a file; each change has to be one.
pub fn rewrite(path: &Path, changes: &[(&str, &str)]) {
    let mut text = std::fs::read_to_string(path).expect("it was written");
    for (from, to) in changes {
        assert!(text.contains(from), "no {from} in {text}");
        text = text.replace(from, to);
    }
    std::fs::write(path, text).expect("writable");
}

/// Makes the robots of an [`experiment`] ones that are without a gate, in real time, with other changes of its file.
pub fn without_gates(folder: &Path, changes: &[(&str, &str)]) {
    let in_real_time = [("time: lockstep", "time: real_time")];
    let file = folder.join("experiments/flockbot_milling.yaml");
    rewrite(&file, &[&in_real_time, changes].concat());
    let foreign = ("type: flockbot}", "type: flockbot, lease: controller}");
    rewrite(&folder.join("fleets/nine_virtual.yaml"), &[foreign]);
}

/// The sensor in the profile of the shipped fleet's robots, for changes that put others in its place.
pub fn usual_sensing() -> String {
    let text = std::fs::read_to_string(shipped("profiles/flockbot.yaml")).expect("it is shipped");
    let sensing = text.find("sensing:").expect("it has a sensor");
    let end = text.find("computation:").expect("it has a period");
    text[sensing..end].to_owned()
}

/// Starts a node in the network of this process.
pub fn node(node: &str, robots: &[&str]) -> Process {
    let mut command = rsrs();
    command.args(["node", node, "--interface", "127.0.0.1", "--robots", &robots.join(",")]);
    command.stdout(Stdio::null());
    Process(command.spawn().expect("the program was built for this test"))
}

/// Starts a run of the fleet that is there.
pub fn start_run(experiment: &Path, bag: &Path) -> Process {
    let mut command = rsrs();
    command.args(["run", "--backend", "fleet", "--interface", "127.0.0.1"]);
    Process::start(command.arg(experiment).arg("-o").arg(bag))
}

/// Sends a process a signal, by its name.
pub fn signal(process: &Process, name: &str) {
    let pid = process.0.id().to_string();
    let status = Command::new("kill").args(["-s", name, &pid]).status();
    assert!(status.expect("every system has `kill`").success());
}

/// A tracker that sees every robot where it was set down, for as long as it is polled.
pub async fn track(session: &Session, robots: &[&str]) {
    let node = session.node("/", "tracker").expect("the name is allowed");
    let publish = |robot: &&str| {
        let topic = topics::POSE.for_robot(robot);
        session.publish_on(&node, &topic, topics::POSE.qos).expect("the topic is allowed")
    };
    let tracker: Vec<Publisher<PoseStamped>> = robots.iter().map(publish).collect();
    let mut period = tokio::time::interval(Duration::from_millis(100));
    loop {
        period.tick().await;
        for (robot, publisher) in tracker.iter().enumerate() {
            let mut pose = PoseStamped::default();
            pose.header.stamp = wall_time();
            "map".clone_into(&mut pose.header.frame_id);
            pose.pose.position.x = robot as f64;
            pose.pose.orientation.w = 1.0;
            publisher.publish(pose).await.expect("a healthy network");
        }
    }
}
