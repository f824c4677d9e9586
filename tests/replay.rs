//! Bags back on the network and into the controller.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Duration;

use crate::command::code;
use crate::processes::{Process, in_own_network, rsrs};
use rsrs_bags::{Bag, BagOptions, BagWriter, Sample};
use rsrs_core::conditions::{Conditions, Settings};
use rsrs_core::quantity::Axis;
use rsrs_fleet::experiment::Time;
use rsrs_fleet::record::{ATTACHMENT, Backend, ExperimentRecord};
use rsrs_msgs::geometry_msgs::TwistStamped;
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::RobotStatus;
use rsrs_msgs::topics;
use rsrs_msgs::{RosMessage, cdr};
use rsrs_ros::session::EndpointKind;
use rsrs_testing::network::{TIMEOUT, eventually, session};
use rsrs_testing::record::fleet_record;
use serde_json::Value;
use tokio::sync::mpsc::unbounded_channel;

use rsrs_testing::conditions::flockbot;

/// A simulated run of two robots as a bag.
fn bag(folder: &Path, name: &str, duration_s: f64) -> PathBuf {
    let profile = flockbot();
    let values = vec![
        (Axis::Speed, 0.15),
        (Axis::TurnRate, 0.75),
        (Axis::Robots, 2.0),
        (Axis::PlacementRadius, 0.6),
    ];
    let settings = Settings { values, ..Settings::default() };
    let conditions = Conditions::resolve(&profile, &settings).expect("the cell is possible");
    let record = ExperimentRecord {
        run_id: name.to_owned(),
        duration_s,
        seed: 3,
        backend: Backend::Simulator,
        time: Time::Lockstep,
        ..fleet_record(&profile.digest(), conditions)
    };
    let path = folder.join(name);
    rsrs_pipeline::episode::write(&path, &record).expect("the disk has room");
    path
}

/// The same bag with other commands: a command that `change` does not give is left out.
fn changed(
    from: &Path,
    name: &str,
    change: impl Fn(u64, TwistStamped) -> Option<TwistStamped>,
) -> PathBuf {
    let original = Bag::open(from).expect("it is a bag");
    let path = from.with_file_name(name);
    let mut writer = BagWriter::create(&path, BagOptions::default()).expect("it is new");
    let record = original.attachment(ATTACHMENT).expect("it has a record");
    writer.attach(ATTACHMENT, &record.media_type, &record.data).expect("the disk has room");
    let qos = topics::CMD_VEL.qos;
    let channels: Vec<_> = original
        .topics()
        .into_iter()
        .map(|topic| {
            let channel = writer.add_topic(&topic.name, &topic.type_name, qos).expect("it is new");
            (topic.name, channel)
        })
        .collect();
    for message in original.messages() {
        let mut message = message.expect("the bag is whole");
        if message.type_name.as_ref() == TwistStamped::TYPE_NAME {
            let command = cdr::decode(&message.bytes).expect("it is one");
            let Some(command) = change(message.log_time_ns, command) else { continue };
            message.bytes = cdr::encode(&command);
        }
        let time_ns = message.log_time_ns;
        let sample = Sample {
            log_time_ns: time_ns,
            publish_time_ns: time_ns,
            sequence: 0,
            data: &message.bytes,
        };
        let channel = channels.iter().find(|(name, _)| **name == *message.topic);
        let (_, channel) = channel.expect("every topic was added");
        writer.write(*channel, sample).expect("the disk has room");
    }
    writer.finish().expect("the disk has room");
    path
}

fn into_controller(bag: &Path, more: &[&str]) -> (i32, Value) {
    let output = rsrs()
        .arg("replay")
        .arg(bag)
        .args(["--into", "controller", "--format", "json"])
        .args(more)
        .output()
        .expect("the binary was built for this test");
    let errors = String::from_utf8_lossy(&output.stderr);
    let result =
        serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {errors}"));
    (code(&output), result)
}

fn into_judge(bag: &Path, more: &[&str]) -> Output {
    let mut command = rsrs();
    command.arg("replay").arg(bag).args(["--into", "judge"]).args(more);
    command.output().expect("the binary was built for this test")
}

#[test]
fn the_controller_of_today_commands_what_was_recorded() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let run = bag(place.path(), "run", 26.0);

    let (code, result) = into_controller(&run, &[]);

    assert_eq!(code, 0, "{result}");
    assert_eq!(result["n_steps"], 400);
    let wrong = ["n_different", "n_unanswered", "n_unasked"];
    assert_eq!(wrong.map(|key| result[key].as_u64()), [Some(0); 3]);
}

#[test]
fn another_controller_is_noticed_at_its_first_other_command() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let run = bag(place.path(), "run", 26.0);
    let period_ns = 130_000_000;
    let slower = changed(&run, "slower", |time_ns, mut command| {
        if time_ns == 50 * period_ns {
            command.twist.linear.x = 0.14;
        }
        Some(command)
    });
    let silent =
        changed(&run, "silent", |time_ns, command| (time_ns != 50 * period_ns).then_some(command));

    let (set_otherwise, other) = into_controller(&run, &["--speed", "0.15", "--turn-rate", "0.7"]);
    let (of_slower, once) = into_controller(&slower, &[]);
    let (of_silent, never) = into_controller(&silent, &[]);

    assert_eq!((set_otherwise, of_slower, of_silent), (3, 3, 3));
    assert_eq!(other["n_different"], 400);
    assert_eq!((&once["n_different"], &once["n_unanswered"]), (&2.into(), &0.into()));
    let first = &once["robots"][0]["first"];
    assert_eq!((&first["time_s"], &first["recorded"]["speed_m_s"]), (&6.5.into(), &0.14.into()));
    assert_eq!(first["today"]["speed_m_s"], 0.15);
    assert_eq!((&never["n_different"], &never["n_unanswered"]), (&0.into(), &2.into()));
}

#[test]
fn the_judge_of_today_is_held_against_the_recorded_label() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let run = bag(place.path(), "run", 70.0);
    let label = place.path().join("label.json");

    let unlabelled = into_judge(&run, &[]);
    let labelled = rsrs().arg("label").arg(&run).args(["--format", "json"]).output();
    let labelled = labelled.expect("the binary was built for this test").stdout;
    std::fs::write(&label, &labelled).expect("it is writable");
    let same = into_judge(&run, &[]);
    let mut other: Value = serde_json::from_slice(&labelled).expect("labels are JSON");
    let today = other[0]["phase"].as_str().expect("it has a phase").to_owned();
    let phase = if today == "dispersion" { "unformed" } else { "dispersion" };
    other[0]["phase"] = phase.into();
    let elsewhere = place.path().join("old.json");
    std::fs::write(&elsewhere, other.to_string()).expect("it is writable");
    let named = elsewhere.to_str().expect("it is text");
    let differs = into_judge(&run, &["--recorded", named, "--format", "json"]);

    assert_eq!([&unlabelled, &same, &differs].map(code), [1, 0, 3]);
    let printed = String::from_utf8_lossy(&unlabelled.stderr);
    assert!(
        printed.contains("there is no recorded label in") && printed.contains("--recorded"),
        "{printed}"
    );
    let printed = String::from_utf8_lossy(&same.stdout);
    assert!(printed.contains("run: the same label\n"), "{printed}");
    let answer: Value = serde_json::from_slice(&differs.stdout).expect("the answer is JSON");
    assert_eq!(answer["recorded"]["phase"], phase);
    assert_eq!(answer["today"]["phase"], today.as_str());
    assert_eq!(answer["is_same"], false);
    assert_eq!(answer["today"]["evidence"], answer["recorded"]["evidence"]);
}

#[test]
fn without_an_interface_nothing_is_published() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let run = bag(place.path(), "run", 2.0);

    let mut replay = Command::new(env!("CARGO_BIN_EXE_rsrs"));
    let replay = replay.arg("replay").arg(&run).env_remove("RSRS_INTERFACE").output();
    let replay = replay.expect("the binary was built for this test");

    assert_eq!(code(&replay), 2);
    let printed = String::from_utf8_lossy(&replay.stderr);
    assert!(
        printed.starts_with("error: no network interface is chosen; this machine has "),
        "{printed}"
    );
    assert!(printed.contains("help: choose one with `--interface NAME`"), "{printed}");
}

#[test]
fn a_start_behind_the_end_of_the_bag_is_refused() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let run = bag(place.path(), "run", 2.0);

    let replay = rsrs().arg("replay").arg(&run).args(["--start", "500"]).output();

    let replay = replay.expect("the binary was built for this test");
    assert_eq!(code(&replay), 2);
    let printed = String::from_utf8_lossy(&replay.stderr);
    assert!(printed.contains("`--start` is 500 s, and the bag ends after"), "{printed}");
}

#[test]
fn a_topic_that_is_not_in_the_bag_is_named_with_the_nearest() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let run = bag(place.path(), "run", 2.0);

    let replay = rsrs()
        .arg("replay")
        .arg(&run)
        .args(["--interface", "127.0.0.1", "--topics", "/robot_1/odm"])
        .output()
        .expect("the binary was built for this test");

    assert_eq!(code(&replay), 1);
    let printed = String::from_utf8_lossy(&replay.stderr);
    assert!(printed.contains("has no topic /robot_1/odm"), "{printed}");
    assert!(printed.contains("did you mean /robot_1/odom?"), "{printed}");
}

#[test]
fn what_was_recorded_is_published_at_its_pace_without_what_moves_robots() {
    in_own_network(published);
}

async fn published() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let run = bag(place.path(), "run", 13.0);
    let expected: Vec<Vec<u8>> = Bag::open(&run)
        .expect("it is a bag")
        .messages_on(["/robot_1/odom"])
        .map(|message| message.expect("the bag is whole"))
        .filter(|message| message.log_time_ns >= 3_900_000_000)
        .map(|message| message.bytes)
        .collect();
    let session = session();
    let (odom, (clock, to_clock)) = (topics::ODOM, {
        let (to_clock, clock) = unbounded_channel();
        (clock, to_clock)
    });
    let (to_odom, mut received) = unbounded_channel();
    let _odom = session
        .subscribe_raw("/robot_1/odom", odom.type_name, odom.qos, move |sample| {
            to_odom.send(sample.message).expect("the test listens to the end");
        })
        .expect("the topic is allowed");
    let topic = topics::CLOCK;
    let _clock = session
        .subscribe_raw(topic.name, topic.type_name, topic.qos, move |sample| {
            to_clock.send(sample.message).expect("the test listens to the end");
        })
        .expect("the topic is allowed");

    let mut command = rsrs();
    command.arg("replay").arg(&run).args(["--interface", "127.0.0.1", "--rate", "5"]);
    let begun = std::time::Instant::now();
    let mut replay = Process::start(command.args(["--delay", "3", "--start", "3.9"]));
    session.wait_for_writers("/robot_1/odom", 1, TIMEOUT).await.expect("it is published");
    let guarded = session
        .endpoints()
        .into_iter()
        .filter(|end| end.kind == EndpointKind::Writer)
        .filter(|end| ["cmd_vel", "lease", "detection"].iter().any(|part| end.topic.contains(part)))
        .count();
    let ended = || replay.0.try_wait().expect("it is our child").is_some();
    eventually("the replay ends", ended).await;
    let took = begun.elapsed();
    let (status, errors) = replay.wait();
    let received: Vec<Vec<u8>> = std::iter::from_fn(|| received.try_recv().ok()).collect();

    assert!(status.success(), "{errors}");
    assert_eq!(received.len(), expected.len());
    assert!(received == expected, "the messages are those of the bag");
    // Steps of 0.13 s, from the 30th to the 100th.
    assert_eq!(clock.len(), 71, "the bag's own clock");
    assert_eq!(guarded, 0);
    assert!(errors.contains("left out 7 (robots are steered by them"), "{errors}");
    // 9.1 s five times as fast, after 3 s.
    assert!(took > Duration::from_millis(4700), "{took:?}");
    session.close().await;
}

#[test]
fn what_a_live_robot_publishes_is_left_out_unless_it_is_asked_for_by_name() {
    in_own_network(async || {
        let place = tempfile::tempdir().expect("a temporary folder");
        let run = bag(place.path(), "run", 2.0);
        let session = session();
        let robot = session.node("/robot_1", "robot").expect("the name is allowed");
        let odom = session
            .publish_on::<Odometry>(&robot, "/robot_1/odom", topics::ODOM.qos)
            .expect("allowed");
        let status = session
            .publish_on::<RobotStatus>(&robot, "/robot_1/status", topics::STATUS.qos)
            .expect("allowed");
        let replay = |more: &'static [&'static str]| {
            let mut command = rsrs();
            command.arg("replay").arg(&run).args(["--interface", "127.0.0.1", "--format", "json"]);
            command.args(more);
            tokio::task::spawn_blocking(move || command.output().expect("the binary was built"))
        };

        let all = replay(&[]).await.expect("it ends");
        let named = replay(&["--topics", "/robot_1/odom", "/clock"]).await.expect("it ends");

        let summary = |output: &Output| -> Value {
            let errors = String::from_utf8_lossy(&output.stderr);
            assert_eq!(code(output), 0, "{errors}");
            serde_json::from_slice(&output.stdout).expect("the summary is JSON")
        };
        let (all_printed, all) = (String::from_utf8_lossy(&all.stderr).into_owned(), summary(&all));
        let left_out = all["left_out"].as_array().expect("a list");
        for topic in ["/robot_1/odom", "/robot_1/detection", "/clock"] {
            assert!(left_out.contains(&topic.into()), "{all}");
        }
        assert!(!left_out.contains(&"/robot_2/odom".into()), "{all}");
        assert!(
            all_printed.contains("left out /robot_1/odom: /robot_1/robot publishes it now"),
            "{all_printed}"
        );
        assert!(all_printed.contains("the time is not published"), "{all_printed}");
        assert_eq!(summary(&named)["n_topics"], 2);
        drop((robot, odom, status));
        session.close().await;
    });
}
