//! Programs that share nothing with ours read our bags, and use our robots' parameters and topics.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{ChildStdout, Command};

use crate::fleet::{ROBOTS, experiment, node, signal};
use crate::processes::{Process, confined_rsrs, in_own_network, rsrs};
use rsrs_fleet::record::{ATTACHMENT, ExperimentRecord};
use rsrs_testing::python::{BAGS, JAZZY, must_run, python_with};
use serde::Deserialize;
use serde_json::{Value, json};

/// Simulated time between two steps.
const PERIOD_NS: u64 = 130_000_000;
const RUN_S: u64 = 20;
/// Whole periods in the run.
const N_STEPS: u64 = RUN_S * 1_000_000_000 / PERIOD_NS;

/// What the readers of others find in a bag.
#[derive(Deserialize)]
struct Report {
    /// By `rosbags`, with the types that it contains.
    rosbags: BTreeMap<String, Topic>,
    /// By `rosbags`, with no types but those that the bag describes.
    schemas_alone: BTreeMap<String, Topic>,
    /// By `mcap-ros2-support`.
    mcap: BTreeMap<String, Topic>,
    /// Messages by topic, as `metadata.yaml` lists them.
    listed: BTreeMap<String, u64>,
    attachments: BTreeMap<String, String>,
}

/// All messages of one topic, decoded.
#[derive(Deserialize, PartialEq)]
struct Topic {
    type_name: String,
    log_times_ns: Vec<u64>,
    /// Their own stamps; `None` where the type has none.
    stamps_ns: Vec<Option<u64>>,
    /// Fingerprint of everything in them.
    values: String,
}

impl Topic {
    fn n_messages(&self) -> u64 {
        self.log_times_ns.len() as u64
    }
}

/// Records a run and lets others read its bag: what our program reports of the run, and what the others
/// find.
fn recorded_and_read() -> (Value, Report) {
    let python = python_with(&BAGS);
    let folder = tempfile::tempdir().expect("there is room for a temporary folder");
    let bag = folder.path().join("bag");
    let mut run = confined_rsrs();
    run.arg("run").arg(experiment(folder.path(), RUN_S, &[]));
    let summary = must_run(run.arg("--output").arg(&bag).args(["--format", "json"]));

    let script = script("bag.py");
    let report = must_run(Command::new(python).arg(script).arg(bag));

    let summary = serde_json::from_str(&summary).expect("the program answers in JSON");
    (summary, serde_json::from_str(&report).expect("the script answers in JSON"))
}

fn script(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/interop").join(name)
}

/// Topics that two readers do not read alike.
fn read_differently<'a>(
    one: &'a BTreeMap<String, Topic>,
    other: &'a BTreeMap<String, Topic>,
) -> Vec<&'a String> {
    let mut topics: Vec<_> = one.keys().chain(other.keys()).collect();
    topics.sort();
    topics.dedup();
    topics.retain(|topic| one.get(*topic) != other.get(*topic));
    topics
}

#[test]
fn rosbags_and_mcap_decode_every_message_of_a_run_at_its_simulated_time() {
    let (summary, report) = recorded_and_read();

    assert_eq!(summary["ending"], json!("completed"));
    assert_eq!(read_differently(&report.rosbags, &report.mcap), [""; 0]);
    assert_eq!(read_differently(&report.rosbags, &report.schemas_alone), [""; 0]);
    let topics = &report.rosbags;
    let counts: BTreeMap<String, u64> =
        topics.iter().map(|(name, topic)| (name.clone(), topic.n_messages())).collect();
    assert_eq!(counts, report.listed);
    assert_eq!(json!(counts.values().sum::<u64>()), summary["n_messages"]);

    let times: Vec<u64> = (1..=N_STEPS).map(|step| step * PERIOD_NS).collect();
    let stamps: Vec<Option<u64>> = times.iter().copied().map(Some).collect();
    for robot in ROBOTS {
        let of_robot = |topic: &str| &topics[&format!("/{robot}/{topic}")];
        for topic in ["detection", "cmd_vel", "odom"] {
            assert!(of_robot(topic).log_times_ns == times, "{robot}: {topic}");
        }
        // A command names which detection it answers.
        assert!(of_robot("cmd_vel").stamps_ns == stamps, "{robot}: stamps of commands");
        assert!(of_robot("odom").stamps_ns == stamps, "{robot}: stamps of poses");
        for topic in ["status", "controller/status"] {
            assert_eq!(of_robot(topic).type_name, "rsrs_msgs/msg/RobotStatus");
        }
    }
    assert!(topics["/clock"].log_times_ns == times);
    assert!(topics["/clock"].stamps_ns == stamps);
    assert!(topics["/swarm/world_digest"].log_times_ns == times);
    assert_eq!(topics["/swarm/lease"].type_name, "rsrs_msgs/msg/RunLease");
    assert_eq!(topics["/rosout"].type_name, "rcl_interfaces/msg/Log");
    let changes = topics.get("/parameter_events").map_or(0, Topic::n_messages);
    let n_configured = ROBOTS.len() as u64 + 1;
    assert!(changes >= n_configured, "{changes} changes, each node has at least one");

    let record = ExperimentRecord::from_json(&report.attachments[ATTACHMENT]);
    let record = record.expect("the bag holds the experiment");
    assert_eq!(json!(record.run_id), summary["run_id"]);
    assert_eq!(record.robots, ROBOTS);
    assert_eq!(record.conditions.steps(record.duration_s), N_STEPS);
}

/// A stock ROS 2 node that looks at one robot.
struct Visitor {
    process: Process,
    lines: BufReader<ChildStdout>,
}

impl Visitor {
    fn start(python: &Path, logs: &Path) -> Self {
        let mut command = Command::new(python);
        for variable in ["ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY"]
        {
            command.env_remove(variable);
        }
        command.arg(script("visitor.py")).env("ROS_DOMAIN_ID", "42").env("ROS_LOG_DIR", logs);
        let mut process = Process::start(&mut command);
        let lines = process.0.stdout.take().expect("it was asked for");
        Self { process, lines: BufReader::new(lines) }
    }

    /// What it saw since it last printed something. The script waits for nothing for ever.
    ///
    /// # Errors
    ///
    /// What it wrote to standard error, if it failed.
    fn seen(&mut self) -> Result<Value, String> {
        let mut line = String::new();
        self.lines.read_line(&mut line).expect("it prints text");
        if line.is_empty() {
            return Err(self.process.wait().1);
        }
        Ok(serde_json::from_str(&line).expect("it prints JSON"))
    }
}

/// Lets a visitor look at robot 3 before, during and after a run in real time.
fn what_a_visitor_sees(python: &Path) -> [Value; 3] {
    let folder = tempfile::tempdir().expect("there is room for a temporary folder");
    let changes =
        [("time: lockstep", "time: real_time"), ("robot_lost: abort", "robot_lost: note")];
    // Longer than the visitor looks: the test ends the run.
    let experiment = experiment(folder.path(), 120, &changes);
    let _simulator = node("sim", &ROBOTS);
    let _controllers = node("controller", &ROBOTS);
    let mut visitor = Visitor::start(python, folder.path());

    let before = visitor.seen().unwrap_or_else(|error| panic!("rclpy: {error}"));
    let mut command = rsrs();
    command.args(["node", "runner", "--interface", "127.0.0.1", "--backend", "sim"]);
    command.arg("--experiment").arg(experiment).arg("--output").arg(folder.path().join("bag"));
    let mut runner = Process::start(&mut command);
    let during = visitor.seen();
    signal(&runner, "INT");
    let (_, printed) = runner.wait();
    let during = during.unwrap_or_else(|error| panic!("rclpy: {error}\nthe runner: {printed}"));
    let after = visitor.seen().unwrap_or_else(|error| panic!("rclpy: {error}"));
    [before, during, after]
}

#[test]
fn rclpy_uses_a_robots_parameters_and_sees_its_commands_follow_its_detections() {
    // Outside the network namespace, where the package index can be reached.
    let python = python_with(&JAZZY);

    in_own_network(async || {
        let [before, during, after] = what_a_visitor_sees(&python);

        check_before(&before);
        let reason = "parameter 'speed' cannot be set while the robot is armed";
        assert_eq!(during["while_armed"], json!([false, reason]));
        assert_eq!(during["values"], json!([0.15, 0.75]), "the cell of the experiment");
        check_pairs(&during["pairs"]);
        let mut nodes = ROBOTS.map(|robot| format!("/{robot}/controller")).to_vec();
        nodes.extend(["/experiment_runner", "/simulator"].map(str::to_owned));
        nodes.sort();
        assert_eq!(during["nodes"], json!(nodes), "every node that is announced");
        assert_eq!(during["silent"], json!([]), "each has parameter services");
        assert_eq!(during["robots"], json!(ROBOTS), "the record is published");
        assert_eq!(after["ending"], "aborted", "so is the ending");
        assert_eq!(after["values"], json!([0.2, 0.75]), "after a run parameters can be set again");
    });
}

fn check_before(before: &Value) {
    let names = [
        "class",
        "cmd_vel_type",
        "constant",
        "lease",
        "mirrored",
        "period",
        "speed",
        "speed_max",
        "stamp_from_clock",
        "table",
        "transition_key",
        "turn_rate",
        "turn_rate_max",
        "undetected_speed",
        "undetected_turn_rate",
    ];
    assert_eq!(before["listed"], json!(names));
    assert_eq!(before["at_first"], json!([0.0, 0.0]), "a robot that nobody configured stands");
    let (description, double) = ("Forward speed v where something is detected, in m/s.", 3);
    assert_eq!(before["described"], json!([description, double, -0.3, 0.3]));
    assert_eq!(before["set"], json!([true, ""]));
    let too_fast = "parameter 'speed' must be between -0.3 and 0.3, found 0.5";
    assert_eq!(before["too_fast"], json!([false, too_fast]));
    let unknown = "parameter 'sped' cannot be set because it was not declared";
    assert_eq!(before["unknown"], json!([false, unknown]));
    assert_eq!(before["at_last"], json!([0.2, 0.0]), "a refused set changes nothing");
}

/// Holds every command against the detection that it answers.
fn check_pairs(pairs: &Value) {
    let pairs: Vec<(u64, bool, f64, f64)> =
        serde_json::from_value(pairs.clone()).expect("step, detection, speed, turning rate");

    let first = pairs.first().map_or(0, |pair| pair.0);
    for (step, (number, detected, speed_m_s, turn_rate_rad_s)) in (first..).zip(&pairs) {
        assert_eq!(*number, step, "rclpy has missed something");
        let expected = if *detected { 0.75 } else { -0.75 };
        assert!(
            (*speed_m_s, *turn_rate_rad_s) == (0.15, expected),
            "step {step}: {speed_m_s} m/s and {turn_rate_rad_s} rad/s, detected: {detected}"
        );
    }
    let n_changes = pairs.windows(2).filter(|pair| pair[0].1 != pair[1].1).count();
    assert!(n_changes > 0, "the turning rate never changed its sign in {} steps", pairs.len());
}
