//! Robots that are not like the others of their fleet: one with a profile of its own, one in a namespace.

use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use crate::command::{code, done, json, rsrs as typed, stderr, stdout};
use crate::fleet::{experiment, start_run};
use crate::prepared_sweeps::chosen;
use crate::processes::{Process, assert_completed, in_own_network, rsrs, run_in_lockstep};
use crate::recorded::{assert_digests_of_replicate, messages, record_of};
use crate::simulated_bags::Run;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_fleet::parameters::{Value, gate};
use rsrs_fleet::record::ExperimentRecord;
use rsrs_msgs::geometry_msgs::{Twist, TwistStamped};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::sensor_msgs::Range;
use rsrs_msgs::topics::{self, Qos};
use rsrs_ros::session::{Publisher, Received, Session, Subscription};
use rsrs_testing::network::session;

/// The fleet: the second has a profile of its own, and is in a namespace.
const ROBOTS: [&str; 3] = ["robot_1", "lab/robot_2", "robot_3"];
const OTHER: &str = ROBOTS[1];
/// What is different of it: it is slower, and its sensor reaches less far.
const CHANGES: [(&str, &str); 2] =
    [("limits_m_s: [0.02, 0.30]", "limits_m_s: [0.02, 0.25]"), ("range_m: 0.75", "range_m: 0.6")];
/// What is printed of that.
const DIFFERS: &str = "lab/robot_2: own profile: actuation.speed.limits_m_s [0.02, 0.25] (fleet \
                       [0.02, 0.3]), sensing.cone.range_m 0.6 (fleet 0.75)";

/// Writes the files of an experiment with this fleet, and returns the path of the experiment file.
fn files(folder: &Path, driver: &str, time: &str, duration_s: u64) -> PathBuf {
    let time = format!("time: {time}");
    let changes = [("robots: 9", "robots: 3"), ("time: lockstep", time.as_str())];
    let file = experiment(folder, duration_s, &changes);
    let flockbot = folder.join("profiles/flockbot.yaml");
    let mut own = std::fs::read_to_string(flockbot).expect("it was copied");
    for (from, to) in CHANGES {
        assert!(own.contains(from), "{from}");
        own = own.replace(from, to);
    }
    std::fs::write(folder.join("profiles/own.yaml"), own).expect("the folder is writable");
    let fleet = format!(
        "fileversion: 1\nall: {{profile: ../profiles/flockbot.yaml, driver: {{kind: {driver}}}}}\n\
         robots:\n  robot_1: {{enabled: true}}\n  \
         lab/robot_2: {{enabled: true, profile: ../profiles/own.yaml}}\n  robot_3: {{enabled: true}}\n"
    );
    std::fs::write(folder.join("fleets/nine_virtual.yaml"), fleet).expect("the folder is writable");
    file
}

/// What is in the bag of a run with these robots.
fn check_record(bag: &Path) -> ExperimentRecord {
    let (bag, record) = record_of(bag);
    assert_eq!(record.robots, ROBOTS);
    assert_eq!(record.own_profiles.keys().collect::<Vec<_>>(), [OTHER]);
    let attached = bag.attachment("profile.lab.robot_2.yaml").expect("its profile is attached");
    let text = String::from_utf8_lossy(&attached.data).into_owned();
    let own = RobotProfile::parse("own.yaml", &text).expect("it is one");
    assert_eq!(own.digest(), record.own_profiles[OTHER].digest);
    assert_ne!(own.digest(), record.provenance.profile_digest, "which is the fleet's");
    assert_eq!(record.conditions.own_robots.keys().collect::<Vec<_>>(), [&1]);
    record
}

#[test]
fn the_simulator_moves_each_robot_by_its_own_profile_and_in_its_own_namespace() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = files(folder.path(), "virtual", "lockstep", 62);
    let bag = folder.path().join("bag");
    let printed = run_in_lockstep(&file, &[], &bag);

    assert!(printed.contains(DIFFERS), "{printed}");
    let record = check_record(&bag);
    let (opened, _) = record_of(&bag);
    assert_digests_of_replicate(&opened, &record);
    let commands: Vec<TwistStamped> = messages(&opened, OTHER, "cmd_vel");
    assert!(commands.len() > 400, "{}", commands.len());

    let label = typed(folder.path(), &["label", "bag"]);
    assert!(stdout(&label).contains(DIFFERS), "{}{}", stdout(&label), stderr(&label));
    let info = typed(folder.path(), &["bag", "info", "bag"]);
    assert!(stdout(&info).contains(DIFFERS), "{}", stdout(&info));
    done(folder.path(), &["draw", "bag", "-o", "bag.svg"]);
}

/// Bases of all three: they stand, see nothing, and take what the gates let through.
async fn live(session: &Session) {
    let node = session.node("/", "bases").expect("the name is allowed");
    let command = topics::HARDWARE_CMD_VEL_UNSTAMPED;
    let _wheels: Vec<Subscription> = ROBOTS
        .iter()
        .map(|robot| {
            let name = command.for_robot(robot);
            let taken = |_: Received<Twist>| {};
            session.subscribe(&node, &name, command.qos, taken).expect("it is allowed")
        })
        .collect();
    let hardware: Vec<(Publisher<Range>, Publisher<Odometry>)> = ROBOTS
        .iter()
        .map(|robot| {
            let (range, pose) = (topics::HARDWARE_RANGE.for_robot(robot), topics::ODOM);
            let range = session.publish_on(&node, &range, Qos::best_effort(10));
            let pose = session.publish_on(&node, &pose.for_robot(robot), pose.qos);
            (range.expect("it is allowed"), pose.expect("it is allowed"))
        })
        .collect();
    let mut beat = tokio::time::interval(Duration::from_millis(100));
    loop {
        beat.tick().await;
        for (place, (range, pose)) in hardware.iter().enumerate() {
            let nothing = Range { range: 2.0, max_range: 2.0, ..Range::default() };
            range.publish(nothing).await.expect("a healthy network");
            let mut odometry = Odometry::default();
            odometry.pose.pose.position.x = place as f64;
            odometry.pose.pose.orientation.w = 1.0;
            pose.publish(odometry).await.expect("a healthy network");
        }
    }
}

/// A robot's node, which takes its name from the namespace.
fn gate_of(fleet: &Path, robot: &str) -> Process {
    let mut command = rsrs();
    command.args(["node", "robot", "--interface", "127.0.0.1", "--config"]);
    command.arg(fleet).args(["--ros-args", "-r", &format!("__ns:=/{robot}")]);
    Process(command.stdout(Stdio::null()).spawn().expect("the program was built for this test"))
}

/// Robots that answer a stop of everybody who is there.
async fn stopped() -> String {
    let stopping = tokio::task::spawn_blocking(|| {
        let mut command = rsrs();
        command.args(["stop", "--format", "json", "--interface", "127.0.0.1"]);
        command.output().expect("the program was built")
    });
    let output = stopping.await.expect("waiting does not panic");
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

async fn play(folder: &Path) {
    let file = files(folder, "ros", "real_time", 4);
    let fleet = folder.join("fleets/nine_virtual.yaml");
    let _sound = [ROBOTS[0], ROBOTS[2]].map(|robot| gate_of(&fleet, robot));
    // Its file is from before somebody gave it a profile of its own.
    let before = folder.join("fleets/before.yaml");
    let text = std::fs::read_to_string(&fleet).expect("it was written");
    std::fs::write(&before, text.replace("own.yaml", "flockbot.yaml")).expect("writable");
    let stale = gate_of(&before, OTHER);

    let refused = start_run(&file, &folder.join("refused")).ended().await.1;

    let stale_limit = "lab/robot_2: `speed_max` is 0.3 m/s, expected 0.25 m/s by the fleet file";
    assert!(refused.contains(stale_limit), "{refused}");
    assert!(!refused.contains("robot_1: `speed_max`"), "{refused}");
    assert!(refused.contains(DIFFERS), "{refused}");
    drop(stale);

    let _mended = gate_of(&fleet, OTHER);
    let bag = folder.join("bag");
    let (code, printed) = start_run(&file, &bag).ended().await;

    let acknowledged = stopped().await;
    assert!(acknowledged.contains(OTHER), "{acknowledged}");
    assert!(printed.contains(DIFFERS), "{printed}");
    assert!(!printed.contains("expected 0.25 m/s by"), "{printed}");
    assert_completed(code, &printed);
    let record = check_record(&bag);
    let [one, own, _] = ROBOTS.map(|robot| &record.gates[robot]);
    assert_eq!(one[gate::SPEED_MAX], Value::Double(0.3));
    assert_eq!(own[gate::SPEED_MAX], Value::Double(0.25));
    assert_eq!(own[gate::DETECTION_THRESHOLD], Value::Double(0.6));
    let digest = record.own_profiles[OTHER].digest.clone();
    assert_eq!(own[gate::PROFILE_DIGEST], Value::Text(digest));
    let (opened, _) = record_of(&bag);
    let commands: Vec<TwistStamped> = messages(&opened, OTHER, "cmd_vel");
    assert!(!commands.is_empty(), "{printed}");
}

#[test]
fn a_fleet_has_a_robot_in_a_namespace_whose_gate_is_held_against_its_own_profile() {
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let session = session();
        tokio::select! {
            () = live(&session) => {}
            () = play(folder.path()) => {}
        }
        session.close().await;
    });
}

#[test]
fn a_profile_of_ones_own_that_is_missing_or_does_not_allow_the_cell_is_refused_by_the_robots_name()
{
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = files(folder.path(), "virtual", "lockstep", 5);
    let own = folder.path().join("profiles/own.yaml");
    let text = std::fs::read_to_string(&own).expect("it was written");
    let run = |text: Option<&str>| {
        match text {
            Some(text) => std::fs::write(&own, text).expect("writable"),
            None => std::fs::remove_file(&own).expect("it is there"),
        }
        let path = file.to_str().expect("the path is text");
        let output = typed(folder.path(), &["run", path, "-o", "bag"]);
        assert_eq!(code(&output), 1, "{}", stdout(&output));
        assert!(!folder.path().join("bag").exists());
        stderr(&output)
    };

    let slow = run(Some(&text.replace("[0.02, 0.25]", "[0.02, 0.10]")));
    assert!(slow.contains("lab/robot_2 has a profile of its own"), "{slow}");
    let limits = "speed_m_s is 0.15, beyond the robots' limits: expected 0.02 to 0.1 m/s";
    assert!(slow.contains(limits) && slow.contains("own.yaml"), "{slow}");
    let wrong = run(Some(&text.replace("range_m: 0.6", "range_m: -0.6")));
    assert!(wrong.contains("the profile of lab/robot_2") && wrong.contains("range_m"), "{wrong}");
    let missing = run(None);
    assert!(missing.contains("the profile of lab/robot_2"), "{missing}");
    assert!(missing.contains("cannot read") && missing.contains("own.yaml"), "{missing}");
}

#[test]
fn a_comparison_counts_runs_with_robots_of_their_own_profile_and_names_them() {
    let place = chosen();
    let alike = Run::new(1).record(place.path(), "alike");
    let (_, record) = record_of(&alike);
    let mut record: serde_json::Value =
        serde_json::from_str(&record.to_json()).expect("a record is JSON");
    record["run_id"] = "own".into();
    let own = serde_json::json!({"digest": "3f", "differs": ["sensing.latency_steps 2 (fleet 0)"]});
    record["own_profiles"] = serde_json::json!({ "robot_3": own });
    Run::new(2).record_with(place.path(), "own", &record.to_string());

    let text = typed(place.path(), &["compare", "out", "--bags", "alike", "own"]);
    let printed = stdout(&text);
    let arguments = ["compare", "out", "--bags", "alike", "own", "--format", "json"];
    let compared = json(&typed(place.path(), &arguments));

    let note = "in 1 of 2 runs robots had a profile of their own, and the sweep is of the fleet's: \
                robot_3 (own profile: sensing.latency_steps 2 (fleet 0))";
    assert!(printed.contains(note), "{printed}{}", stderr(&text));
    assert_eq!(compared["bags"].as_array().map(Vec::len), Some(2), "{compared:#}");
    assert!(compared["bags"][0]["own_profiles"].is_null(), "{compared:#}");
    assert_eq!(compared["bags"][1]["own_profiles"]["robot_3"]["digest"], "3f", "{compared:#}");
}
