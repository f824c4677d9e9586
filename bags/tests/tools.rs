//! Holds our bags against two independent readers of ROS 2 bags, `rosbags` and
//! `mcap-ros2-support`.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use rsrs_bags::{BagOptions, BagWriter, Sample};
use rsrs_msgs::builtin_interfaces::{Duration, Time};
use rsrs_msgs::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue};
use rsrs_msgs::geometry_msgs::{
    Point, Pose, PoseArray, PoseStamped, PoseWithCovariance, Quaternion, Transform,
    TransformStamped, Twist, TwistStamped, TwistWithCovariance, Vector3,
};
use rsrs_msgs::motion_capture_tracking_interfaces::{NamedPose, NamedPoseArray};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rcl_interfaces::{
    FloatingPointRange, IntegerRange, ListParametersResult, Log, Parameter, ParameterDescriptor,
    ParameterEvent, ParameterValue, SetParametersResult,
};
use rsrs_msgs::rosgraph_msgs::Clock;
use rsrs_msgs::rsrs::{EStopLock, EStopLocks, Recorded, RobotStatus, RunLease, WorldDigest};
use rsrs_msgs::sensor_msgs::{CompressedImage, LaserScan, Range};
use rsrs_msgs::std_msgs::{self, Bool, ColorRGBA, Header};
use rsrs_msgs::tf2_msgs::TFMessage;
use rsrs_msgs::topics::{Durability, Qos, Reliability};
use rsrs_msgs::visualization_msgs::{Marker, MarkerArray, MeshFile, UVCoordinate};
use rsrs_msgs::{RosMessage, cdr, schema};
use rsrs_testing::python;
use serde::Deserialize;

/// What a tool found in a bag.
#[derive(Debug, Deserialize, PartialEq)]
struct Seen {
    /// Messages that were decoded, by topic.
    decoded: BTreeMap<String, u64>,
    /// Types, by topic.
    types: BTreeMap<String, String>,
}

/// What both tools, and the summary section, contain.
#[derive(Debug, Deserialize)]
struct Report {
    rosbags_folder: Seen,
    rosbags_file: Seen,
    mcap: Seen,
    /// History, depth, reliability, durability of each topic.
    qos: BTreeMap<String, (String, u32, String, String)>,
    hashes: BTreeMap<String, String>,
    message_count: u64,
    duration_ns: u64,
    start_ns: u64,
    custom_data: BTreeMap<String, String>,
    attachments: BTreeMap<String, String>,
    metadata: Vec<String>,
}

fn inspect(bag: &Path) -> Report {
    let python = python::python_with(&python::BAGS);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/tools.py");
    let printed = python::must_run(Command::new(python).arg(script).arg(bag));
    serde_json::from_str(&printed).expect("the script answers in JSON")
}

/// One topic per type, three default messages on each.
fn one_of_each(writer: &mut BagWriter) {
    macro_rules! put {
        ($($message:ty),+ $(,)?) => { $(put_three(writer, &<$message>::default());)+ };
    }
    put!(
        Time,
        Duration,
        Bool,
        Header,
        Vector3,
        Twist,
        TwistStamped,
        Point,
        Quaternion,
        Pose,
        PoseStamped,
        PoseArray,
        NamedPose,
        NamedPoseArray,
        PoseWithCovariance,
        TwistWithCovariance,
        Transform,
        TransformStamped,
        Odometry,
        Clock,
        ColorRGBA,
        std_msgs::String,
        CompressedImage,
        Marker,
        MarkerArray,
        MeshFile,
        UVCoordinate,
        LaserScan,
        Range,
        TFMessage,
        DiagnosticArray,
        DiagnosticStatus,
        KeyValue,
        Log,
        Parameter,
        ParameterEvent,
        ParameterValue,
        ParameterDescriptor,
        FloatingPointRange,
        IntegerRange,
        SetParametersResult,
        ListParametersResult,
        RunLease,
        RobotStatus,
        WorldDigest,
        Recorded,
        EStopLock,
        EStopLocks,
    );
}

fn topic_of(type_name: &str) -> String {
    format!("/one/{}", type_name.replace('/', "_").to_lowercase())
}

fn put_three<M: RosMessage>(writer: &mut BagWriter, message: &M) {
    let qos = Qos {
        reliability: Reliability::BestEffort,
        durability: Durability::TransientLocal,
        depth: 17,
    };
    let channel = writer.add_topic(&topic_of(M::TYPE_NAME), M::TYPE_NAME, qos).expect("it is new");
    let data = cdr::encode(message);
    for second in 1..=3 {
        let log_time_ns = second * 1_000_000_000;
        let sample = Sample { log_time_ns, publish_time_ns: 0, sequence: 0, data: &data };
        writer.write(channel, sample).expect("the disk has room");
    }
}

#[test]
fn other_tools_decode_every_message_of_every_type() {
    let folder = tempfile::tempdir().expect("there is room for a temporary folder");
    let path = folder.path().join("run");
    let custom_data = BTreeMap::from([("note".to_owned(), "a: \"b\"\n# c".to_owned())]);
    let options = BagOptions { custom_data: custom_data.clone() };
    let mut writer = BagWriter::create(&path, options).expect("it is new");
    one_of_each(&mut writer);
    writer.attach("experiment.yaml", "application/yaml", b"seed: 42\n").expect("room");
    writer.metadata("rsrs.experiment", custom_data.clone()).expect("room");
    let summary = writer.finish().expect("room");

    let report = inspect(&path);

    let types: BTreeMap<String, String> =
        schema::type_names().map(|name| (topic_of(name), name.to_owned())).collect();
    let decoded = types.keys().map(|topic| (topic.clone(), 3)).collect();
    let expected = Seen { decoded, types: types.clone() };
    assert_eq!(report.rosbags_folder, expected);
    assert_eq!(report.rosbags_file, expected);
    assert_eq!(report.mcap, expected);
    assert_eq!(report.message_count, summary.n_messages);
    assert_eq!((report.start_ns, report.duration_ns), (1_000_000_000, 2_000_000_001));
    for (topic, type_name) in &types {
        let qos = &report.qos[topic];
        let qos = (qos.0.as_str(), qos.1, qos.2.as_str(), qos.3.as_str());
        assert_eq!(qos, ("KEEP_LAST", 17, "BEST_EFFORT", "TRANSIENT_LOCAL"), "{topic}");
        assert_eq!(Some(report.hashes[topic].as_str()), schema::type_hash(type_name), "{topic}");
    }
    assert_eq!(report.custom_data, custom_data);
    assert_eq!(report.attachments["experiment.yaml"], "seed: 42\n");
    assert_eq!(report.metadata, ["rosbag2", "rsrs.experiment", "rosbag2"]);
}
