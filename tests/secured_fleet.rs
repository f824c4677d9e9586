//! A secured fleet: robots in processes of their own with played microcontrollers, a tracker and a
//! runner, each with its enclave of a keystore.
//!
//! `RSRS_SECURED_RUNS` sets how often nine robots are started anew for a run, and `RSRS_SECURED_S`
//! for how long each run lasts.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use rsrs_keystore::create::{KeystoreRequest, create};
use rsrs_ros::interfaces::LOOPBACK;
use rsrs_ros::security::{Enclave, Member, SecurityRequest, Strategy};
use rsrs_ros::session::{Session, SessionOptions};
use rsrs_testing::environment::number;
use rsrs_testing::network::{TIMEOUT, eventually};
use serde_json::Value;
use tempfile::TempDir;

use crate::fleet::{ROBOTS, experiment, track};
use crate::micro::{Micro, Socket};
use crate::processes::{Process, in_own_network, rsrs, secure, secure_all};
use crate::terminal::Window;

/// The domain of all processes of these tests.
const DOMAIN: u16 = 42;
/// Robots that join at once lose handshakes.
const APART: Duration = Duration::from_secs(1);

/// A keystore of the shipped fleet.
fn keystore(folder: &Path) {
    let made = create(&KeystoreRequest {
        folder,
        robots: &ROBOTS.map(str::to_owned),
        domain_id: Some(DOMAIN),
        now: SystemTime::now().duration_since(UNIX_EPOCH).expect("it is after 1970"),
        validity: Some(Duration::from_secs(24 * 3600)),
        readmitted: &[],
    });
    made.expect("the folder is writable");
}

/// The enclave of a member of the fleet.
fn enclave(keystore: &Path, name: &str) -> Option<Enclave> {
    let request = SecurityRequest {
        keystore: keystore.to_owned(),
        strategy: Strategy::Enforce,
        enclave: Some(name.to_owned()),
    };
    let now = SystemTime::now().duration_since(UNIX_EPOCH).expect("it is after 1970");
    request.enclave(Member::Runner, DOMAIN, now).expect("the enclave is well")
}

/// Secures every program that this test starts from now on: their keystore, and the enclave of a tracker
/// in it.
pub fn secure_this_test() -> (TempDir, Option<Enclave>) {
    let keys = tempfile::tempdir().expect("a temporary folder");
    keystore(keys.path());
    secure_all(keys.path());
    let tracker = enclave(keys.path(), "/tracker");
    (keys, tracker)
}

/// The program in a secured fleet.
fn secured(keystore: &Path) -> Command {
    let mut command = rsrs();
    secure(&mut command, keystore);
    command
}

fn start_robot(keystore: &Path, name: &str, socket: &Socket) -> Process {
    let mut command = secured(keystore);
    command.args(["node", "robot", "--interface", "127.0.0.1", "--robots", name]);
    command.args(["--driver", "serial", "--port"]).arg(socket.path());
    command.stdout(Stdio::null());
    Process(command.spawn().expect("the program was built for this test"))
}

#[test]
fn nine_secured_robots_and_a_runner_record_an_experiment_without_loss() {
    in_own_network(async || {
        for _ in 0..number("RSRS_SECURED_RUNS").unwrap_or(1) {
            record_an_experiment().await;
        }
    });
}

async fn record_an_experiment() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let keys = folder.path().join("keystore");
    keystore(&keys);
    let duration_s = number("RSRS_SECURED_S").unwrap_or(20);
    let changes = [
        ("time: lockstep", "time: real_time"),
        ("pose: odom", "pose: pose"),
        ("driver: {kind: virtual}", "driver: {kind: serial, port: /dev/null, baud: 115200}"),
    ];
    let experiment = experiment(folder.path(), duration_s, &changes);
    let options = SessionOptions {
        domain_id: DOMAIN,
        interfaces: vec![LOOPBACK],
        enclave: enclave(&keys, "/tracker"),
    };
    let tracker = Session::open(&options).expect("the enclave is well");
    let sockets = ROBOTS.map(|_| Socket::new());
    let micros = sockets.each_ref().map(|socket| Micro::plug_in(&socket.path()));
    let mut robots = Vec::new();
    for (name, socket) in ROBOTS.iter().zip(&sockets) {
        tokio::time::sleep(APART).await;
        robots.push(start_robot(&keys, name, socket));
    }
    let mut command = secured(&keys);
    command.args(["run", "--backend", "fleet", "--interface", "127.0.0.1", "--format", "json"]);
    command.arg(&experiment).arg("-o").arg(folder.path().join("bag"));
    let output = tokio::select! {
        () = track(&tracker, &ROBOTS) => unreachable!("a tracker does not end"),
        output = async {
            tokio::time::sleep(APART).await;
            let run = tokio::process::Command::from(command).kill_on_drop(true).output();
            tokio::time::timeout(TIMEOUT, run).await.expect("the run ends in time")
        } => output.expect("the program was built for this test"),
    };
    tracker.close().await;
    drop((robots, micros));

    let errors = String::from_utf8_lossy(&output.stderr);
    let printed = String::from_utf8_lossy(&output.stdout);
    let summary: Value = serde_json::from_str(&printed)
        .unwrap_or_else(|error| panic!("no summary ({error}): {printed}\n{errors}"));
    assert_eq!(summary["ending"], "completed", "{printed}\n{errors}");
    assert_eq!(
        (&summary["n_lost"], &summary["lost_robots"]),
        (&0.into(), &Value::Array(vec![])),
        "{printed}"
    );
    assert!(output.status.success(), "{printed}\n{errors}");
}

/// Two robots that have joined, each with its microcontroller; they end when they are dropped.
async fn two_robots(keystore: &Path) -> Vec<(Process, Micro, Socket)> {
    let mut robots = Vec::new();
    for name in &ROBOTS[..2] {
        let socket = Socket::new();
        let micro = Micro::plug_in(&socket.path());
        robots.push((start_robot(keystore, name, &socket), micro, socket));
        tokio::time::sleep(APART).await;
    }
    robots
}

#[test]
fn a_secured_fleet_is_stopped_with_the_key_and_does_not_see_who_has_none() {
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        keystore(folder.path());
        let robots = two_robots(folder.path()).await;
        let stop = |mut command: Command| {
            command.args(["stop", "--interface", "127.0.0.1", "--format", "json"]);
            let output = command.output().expect("the program was built for this test");
            let printed = String::from_utf8_lossy(&output.stdout).into_owned();
            (output.status.code(), serde_json::from_str::<Value>(&printed).expect("a summary"))
        };

        let (code_without, without) = stop(rsrs());
        let (code_with, with) = stop(secured(folder.path()));

        drop(robots);
        assert_eq!((code_without, &without["robots"]), (Some(3), &Value::Array(vec![])));
        assert_eq!((code_with, &with["acknowledged"]), (Some(0), &true.into()), "{with}");
        assert_eq!(with["robots"].as_array().map(Vec::len), Some(2), "{with}");
    });
}

#[test]
fn a_secured_fleet_is_watched_with_a_key_and_stopped_with_another() {
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        keystore(folder.path());
        let robots = two_robots(folder.path()).await;
        let mut watch = secured(folder.path());
        watch.args(["watch", "--interface", "127.0.0.1"]);
        let mut window = Window::open(&watch, (100, 30));

        window.wait_until("both robots", |text| text.matches(" idle ").count() == 2);
        // Who stops is a member before anybody is stopped.
        let options = SessionOptions {
            domain_id: DOMAIN,
            interfaces: vec![LOOPBACK],
            enclave: enclave(folder.path(), "/runner"),
        };
        let session = Session::open(&options).expect("the enclave is well");
        let stands_ready = || session.node_names().contains(&"/rsrs_stop".to_owned());
        eventually("the stop has joined", stands_ready).await;
        session.close().await;
        window.press("s");
        window.wait_for("2 of 2 robots stand");
        window.wait_for("E-STOP holds 2 of 2");
        window.press("q");

        assert_eq!(window.ended().code(), Some(0), "{}", window.text());
        drop(robots);
    });
}

#[test]
fn a_robot_that_is_to_be_secured_and_lacks_a_file_does_not_start() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    keystore(folder.path());
    let key = folder.path().join("enclaves/robot_1/key.pem");
    std::fs::remove_file(&key).expect("it was there");
    let mut command = secured(folder.path());
    command.args(["node", "robot", "--interface", "127.0.0.1", "--robots", "robot_1"]);

    let output = rsrs_ros::confine::start_in_own_network(command.args([
        "--driver",
        "serial",
        "--port",
        "/dev/null",
    ]))
    .output()
    .expect("the program was built for this test");

    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(errors.contains(&format!("{} is missing", key.display())), "{errors}");
}
