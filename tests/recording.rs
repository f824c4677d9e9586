//! Topics that an experiment names: any type, defined in a workspace, in the bag as it was sent.

use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::processes::{Process, in_own_network, rsrs};
use rsrs_bags::Bag;
use rsrs_core::robot::other_profile::OtherProfile;
use rsrs_experiment_runner::plan::{Plan, Request};
use rsrs_experiment_runner::{RunReport, run};
use rsrs_fleet::placement::PlaceCheck;
use rsrs_fleet::record::{Backend, EndingKind};
use rsrs_msgs::topics::{Durability, Qos, Reliability};
use rsrs_ros::interfaces::LOOPBACK;
use rsrs_ros::session::{RawPublisher, Session, SessionOptions};
use rsrs_testing::network::{in_own_network_with, session};

const ROBOTS: &str = "robot_1,robot_2,robot_3";
const BATTERY: &str = "lab_msgs/msg/Battery";
/// CDR of a `Battery` of 3.5 V whose cell is `ABC`: whole words, which DDS does not fill up.
const SENT: [u8; 20] = [0, 1, 0, 0, 0, 0, 96, 64, 7, 0, 0, 0, 4, 0, 0, 0, b'A', b'B', b'C', 0];
/// CDR of that cell.
const CELL: [u8; 16] = [0, 1, 0, 0, 7, 0, 0, 0, 4, 0, 0, 0, b'A', b'B', b'C', 0];

/// A laboratory's folder: robots, an experiment, and a workspace with messages of its own.
fn place(record: &str) -> tempfile::TempDir {
    let place = tempfile::tempdir().expect("a temporary folder");
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../launch_configs");
    for file in ["profiles/flockbot.yaml", "fleets/nine_virtual.yaml"] {
        let text = std::fs::read(shipped.join(file)).expect("it is shipped");
        write(place.path(), file, &text);
    }
    let messages = "workspace/src/lab_msgs/msg";
    let battery = b"float32 voltage_v\nlab_msgs/Cell cell\n";
    write(place.path(), &format!("{messages}/Battery.msg"), battery);
    write(place.path(), &format!("{messages}/Cell.msg"), b"uint32 number\nstring name\n");
    let experiment = format!(
        "fleet: fleets/nine_virtual.yaml\n\
         cell: {{speed_m_s: 0.15, turn_rate_rad_s: 0.75, robots: 3}}\n\
         placement: {{kind: disc_facing_out, radius_m: 0.6}}\n\
         duration_s: 26\nseed: 1\n\
         record: {record}\n"
    );
    write(place.path(), "experiment.yaml", experiment.as_bytes());
    place
}

fn write(folder: &Path, name: &str, bytes: &[u8]) {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().expect("it is in a folder")).expect("it is writable");
    std::fs::write(path, bytes).expect("it is writable");
}

fn start(node: &str) -> Process {
    let mut command = rsrs();
    command.args(["node", node, "--interface", "127.0.0.1", "--robots", ROBOTS, "--ros-args"]);
    Process::start(&mut command)
}

fn publish(session: &Session, topic: &str, type_name: &str, qos: Qos) -> RawPublisher {
    session.publish_raw(topic, type_name, qos).expect("the topic is allowed")
}

async fn record_run(place: &Path) -> (RunReport, PathBuf) {
    let bag = place.join("bag");
    let plan = Plan::read(&Request {
        experiment: place.join("experiment.yaml"),
        cell: None,
        from: None,
        backend: Backend::Simulator,
        bag: Some(bag.clone()),
        seed: None,
        place_check: PlaceCheck::Off,
        other_profile: OtherProfile::Refused,
    })
    .expect("the experiment is one");
    let network = SessionOptions { domain_id: 42, interfaces: vec![LOOPBACK], enclave: None };
    let report = run(&plan, &network, &mut |_| {}, std::future::pending()).await;
    (report.expect("the network is there"), bag)
}

#[test]
fn any_topic_is_recorded_as_it_was_sent_with_its_definition_and_quality_of_service() {
    in_own_network(recorded);
}

async fn recorded() {
    let place = place(
        "{topics: [/battery, bumper, /floor], definitions: [workspace], split_gib: 0.00002, \
         compression: lz4}",
    );
    let (_simulator, _controllers) = (start("sim"), start("controller"));
    let session = session();
    let battery = publish(&session, "/battery", BATTERY, Qos::best_effort(5));
    let bumpers: Vec<RawPublisher> = ROBOTS
        .split(',')
        .map(|robot| {
            let topic = format!("/{robot}/bumper");
            publish(&session, &topic, "std_msgs/msg/Bool", Qos::reliable(5))
        })
        .collect();
    let kept = Qos {
        reliability: Reliability::Reliable,
        durability: Durability::TransientLocal,
        depth: 1,
    };
    let floor = publish(&session, "/floor", "lab_msgs/msg/Cell", kept);
    floor.publish(&CELL).await.expect("it can be sent");
    let sending = async {
        let mut beat = tokio::time::interval(Duration::from_millis(10));
        loop {
            beat.tick().await;
            battery.publish(&SENT).await.expect("it can be sent");
            for bumper in &bumpers {
                bumper.publish(&[0, 1, 0, 0, 1]).await.expect("it can be sent");
            }
        }
    };

    let (report, path) = tokio::select! {
        recorded = record_run(place.path()) => recorded,
        () = sending => unreachable!("it goes on"),
    };

    assert_eq!(report.ending.kind, EndingKind::Completed, "{}", report.ending.reason);
    let bag = Bag::open(&path).expect("it is a bag");
    let summary = bag.info();
    let topic = |name: &str| {
        let found = summary.topics.iter().find(|topic| topic.name == name);
        found.unwrap_or_else(|| panic!("{name} is not in the bag"))
    };
    assert_eq!(topic("/battery").type_name, BATTERY);
    assert_eq!(topic("/battery").offered_qos[0].reliability, "best_effort");
    assert!(topic("/battery").type_hash.starts_with("RIHS01_"));
    let schema = bag.schema(BATTERY).expect("the bag defines its types");
    let schema = std::str::from_utf8(schema).expect("definitions are text");
    assert!(schema.contains("float32 voltage_v") && schema.contains("uint32 number"), "{schema}");
    let messages: Vec<Vec<u8>> = bag
        .messages_on(["/battery"])
        .map(|message| message.expect("the bag is whole").bytes)
        .collect();
    // In lockstep a run is as short as the machine is fast.
    assert!(messages.len() > 2, "{} messages", messages.len());
    assert!(messages.iter().all(|bytes| bytes == &SENT), "the bytes are those that were sent");
    for robot in ROBOTS.split(',') {
        assert!(topic(&format!("/{robot}/bumper")).n_messages > 2);
    }
    // Sent before the run, kept by its publisher.
    assert_eq!(topic("/floor").n_messages, 1);
    assert_eq!(topic("/floor").offered_qos[0].durability, "transient_local");
    assert!(summary.files.len() > 2, "{} files", summary.files.len());
    session.close().await;
}

#[test]
fn types_of_installed_packages_are_found_where_ros_2_lists_them() {
    let prefix = tempfile::tempdir().expect("a temporary folder");
    let messages = prefix.path().join("share/lab_msgs/msg");
    write(&messages, "Battery.msg", b"float32 voltage_v\nlab_msgs/Cell cell\n");
    write(&messages, "Cell.msg", b"uint32 number\nstring name\n");
    let prefixes = std::env::join_paths([Path::new("/gone"), prefix.path()]).expect("no colons");

    in_own_network_with(
        "recording::types_of_installed_packages_are_found_where_ros_2_lists_them",
        &[("AMENT_PREFIX_PATH", prefixes)],
        described_by_a_prefix,
    );
}

async fn described_by_a_prefix() {
    let place = place("{topics: [/battery]}");
    let (_simulator, _controllers) = (start("sim"), start("controller"));
    let session = session();
    let battery = publish(&session, "/battery", BATTERY, Qos::best_effort(5));
    let sending = async {
        let mut beat = tokio::time::interval(Duration::from_millis(10));
        loop {
            beat.tick().await;
            battery.publish(&SENT).await.expect("it can be sent");
        }
    };

    let (report, path) = tokio::select! {
        recorded = record_run(place.path()) => recorded,
        () = sending => unreachable!("it goes on"),
    };

    assert_eq!(report.ending.kind, EndingKind::Completed, "{}", report.ending.reason);
    let bag = Bag::open(&path).expect("it is a bag");
    let schema = bag.schema(BATTERY).expect("the bag defines its types");
    let schema = std::str::from_utf8(schema).expect("definitions are text");
    assert!(schema.contains("float32 voltage_v") && schema.contains("uint32 number"), "{schema}");
    let messages = bag.messages_on(["/battery"]).map(|message| message.expect("whole").bytes);
    let n_as_sent = messages.filter(|bytes| *bytes == SENT).count();
    assert!(n_as_sent > 2, "{n_as_sent} messages as they were sent");
    session.close().await;
}

#[test]
fn what_cannot_be_described_is_refused_by_name_before_anything_moves() {
    in_own_network(async || {
        let place = place("{topics: [/battery, /nobody]}");
        let (_simulator, _controllers) = (start("sim"), start("controller"));
        let session = session();
        let _battery = publish(&session, "/battery", BATTERY, Qos::best_effort(5));

        let (report, bag) = record_run(place.path()).await;

        assert_eq!(report.ending.kind, EndingKind::Failed);
        let reason = report.ending.reason;
        let described = "/battery: its type lab_msgs/msg/Battery is not defined: no file \
                     lab_msgs/msg/Battery.msg in no folder at all";
        assert!(reason.contains(described), "{reason}");
        assert!(
            reason.contains("/nobody: it is to be recorded, and it has no publisher"),
            "{reason}"
        );
        assert!(!bag.exists(), "nothing was recorded");
        session.close().await;
    });
}
