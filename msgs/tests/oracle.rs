//! Holds every message against `rosbags`, an independent implementation of ROS 2's formats.
//!
//! Rust writes made-up messages as JSON and as CDR and the script answers with what `rosbags` makes
//! of the same values; the stock definitions that it compares with are its own, and those of the
//! parameter services come from a package of ROS 2 Jazzy.

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_possible_wrap,
    reason = "made-up numbers are bits of a draw, and which bits does not matter"
)]
mod sampler;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use rsrs_msgs::rcl_interfaces::{
    DescribeParametersRequest, DescribeParametersResponse, FloatingPointRange,
    GetParameterTypesRequest, GetParameterTypesResponse, GetParametersRequest,
    GetParametersResponse, IntegerRange, ListParametersRequest, ListParametersResponse,
    ListParametersResult, Log, Parameter, ParameterDescriptor, ParameterEvent, ParameterValue,
    SetParametersAtomicallyRequest, SetParametersAtomicallyResponse, SetParametersRequest,
    SetParametersResponse, SetParametersResult,
};
use rsrs_msgs::rsrs::{Recorded, RobotStatus, RunLease, WorldDigest};
use rsrs_msgs::{
    RosMessage, builtin_interfaces, cdr, diagnostic_msgs, geometry_msgs,
    motion_capture_tracking_interfaces, nav_msgs, rosgraph_msgs, schema, sensor_msgs,
    simulation_interfaces as simulation, std_msgs, tf2_msgs, visualization_msgs,
};
use rsrs_testing::python;
use serde::{Deserialize, Serialize};

/// Enough for every sequence to be empty once and every string to have every length.
const N_SAMPLES: u64 = 24;

/// A message as values and as bytes.
#[derive(Serialize)]
struct Case {
    type_name: &'static str,
    /// As JSON text, because the order of the fields counts.
    values: String,
    cdr_hex: String,
}

/// What the script receives from Rust.
#[derive(Serialize)]
struct Question {
    /// Definitions of our own types, by name.
    own_definitions: BTreeMap<&'static str, String>,
    /// Schema texts by type.
    schemas: BTreeMap<&'static str, String>,
    cases: Vec<Case>,
    /// Folder of a package whose definitions are ours to bring.
    package: PathBuf,
}

/// What `rosbags` makes of it.
#[derive(Deserialize)]
struct RosbagsReport {
    /// Bytes of each case.
    cdr_hex: Vec<String>,
    /// RIHS01 of each type with a schema.
    hashes: BTreeMap<String, String>,
    /// Constants and fields of every type in each schema text, as parsed from it.
    parsed: BTreeMap<String, serde_json::Value>,
    /// The same, as it should be.
    expected: BTreeMap<String, serde_json::Value>,
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").expect("writing to a string succeeds");
        text
    })
}

/// Makes up messages of one type, and checks on the way that they survive encoding.
fn cases<M: RosMessage>(cases: &mut Vec<Case>) {
    for seed in 0..N_SAMPLES {
        let message: M = sampler::sample(seed);
        let bytes = cdr::encode(&message);
        let decoded: M = cdr::decode(&bytes).expect("what was encoded decodes");

        let values = json(&message);
        assert_eq!(json(&decoded), values, "{}", M::TYPE_NAME);
        cases.push(Case { type_name: M::TYPE_NAME, values, cdr_hex: hex(&bytes) });
    }
}

fn json<M: RosMessage>(message: &M) -> String {
    serde_json::to_string(message).expect("messages have JSON values only")
}

macro_rules! cases_of {
    ($($message:ty),+ $(,)?) => {{
        let mut all = Vec::new();
        $(cases::<$message>(&mut all);)+
        all
    }};
}

fn all_cases() -> Vec<Case> {
    use diagnostic_msgs::{DiagnosticArray, DiagnosticStatus, KeyValue};
    use geometry_msgs::{
        Point, Pose, PoseArray, PoseStamped, PoseWithCovariance, Quaternion, Transform,
        TransformStamped, Twist, TwistStamped, TwistWithCovariance, Vector3,
    };
    cases_of![
        builtin_interfaces::Time,
        builtin_interfaces::Duration,
        std_msgs::Bool,
        std_msgs::ColorRGBA,
        std_msgs::Header,
        std_msgs::Text,
        Vector3,
        Twist,
        TwistStamped,
        Point,
        Quaternion,
        Pose,
        PoseArray,
        PoseStamped,
        PoseWithCovariance,
        TwistWithCovariance,
        Transform,
        TransformStamped,
        motion_capture_tracking_interfaces::NamedPose,
        motion_capture_tracking_interfaces::NamedPoseArray,
        nav_msgs::Odometry,
        rosgraph_msgs::Clock,
        sensor_msgs::CompressedImage,
        sensor_msgs::LaserScan,
        sensor_msgs::Range,
        tf2_msgs::TFMessage,
        visualization_msgs::Marker,
        visualization_msgs::MarkerArray,
        visualization_msgs::MeshFile,
        visualization_msgs::UVCoordinate,
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
        DescribeParametersRequest,
        GetParameterTypesRequest,
        GetParameterTypesResponse,
        GetParametersRequest,
        GetParametersResponse,
        ListParametersRequest,
        ListParametersResponse,
        SetParametersAtomicallyRequest,
        SetParametersAtomicallyResponse,
        SetParametersRequest,
        SetParametersResponse,
        DescribeParametersResponse,
    ]
}

/// What simulators are asked, and what they answer.
fn simulation_cases() -> Vec<Case> {
    cases_of![
        geometry_msgs::Accel,
        simulation::Result,
        simulation::SimulatorFeatures,
        simulation::SimulationState,
        simulation::EntityCategory,
        simulation::TagsFilter,
        simulation::Bounds,
        simulation::EntityFilters,
        simulation::EntityState,
        simulation::GetSimulatorFeaturesRequest,
        simulation::GetSimulatorFeaturesResponse,
        simulation::GetSimulationStateRequest,
        simulation::GetSimulationStateResponse,
        simulation::SetSimulationStateRequest,
        simulation::SetSimulationStateResponse,
        simulation::ResetSimulationRequest,
        simulation::ResetSimulationResponse,
        simulation::StepSimulationRequest,
        simulation::StepSimulationResponse,
        simulation::GetEntitiesRequest,
        simulation::GetEntitiesResponse,
        simulation::GetEntitiesStatesRequest,
        simulation::GetEntitiesStatesResponse,
        simulation::GetEntityStateRequest,
        simulation::GetEntityStateResponse,
        simulation::SetEntityStateRequest,
        simulation::SetEntityStateResponse,
    ]
}

fn ask(question: &Question) -> RosbagsReport {
    let python = python::python_with(&python::BAGS);
    let folder = tempfile::tempdir().expect("there is room for a temporary folder");
    let file = folder.path().join("question.json");
    std::fs::write(&file, serde_json::to_string(question).expect("a question is plain data"))
        .expect("the temporary folder is writable");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/oracle.py");
    let printed = python::must_run(Command::new(python).arg(script).arg(&file));
    serde_json::from_str(&printed).expect("the script answers in JSON")
}

/// Definitions of a package that `rosbags` does not have, as its authors publish them.
fn trackers_definitions() -> [(&'static str, String); 2] {
    use motion_capture_tracking_interfaces::{NamedPose, NamedPoseArray};
    [
        (NamedPose::TYPE_NAME, "string name\ngeometry_msgs/Pose pose\n".to_owned()),
        (NamedPoseArray::TYPE_NAME, "std_msgs/Header header\nNamedPose[] poses\n".to_owned()),
    ]
}

#[test]
fn bytes_hashes_and_definitions_are_those_of_an_independent_implementation() {
    let definitions_folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("msg");
    let own_definitions =
        [RunLease::TYPE_NAME, RobotStatus::TYPE_NAME, WorldDigest::TYPE_NAME, Recorded::TYPE_NAME]
            .into_iter()
            .map(|type_name| {
                let stem = type_name.rsplit('/').next().expect("a type name has parts");
                let text = std::fs::read_to_string(definitions_folder.join(format!("{stem}.msg")));
                (type_name, text.expect("our definitions are in msg/"))
            })
            .chain(trackers_definitions())
            .collect();
    let schemas: BTreeMap<&str, String> = schema::type_names()
        .map(|name| (name, schema::schema_text(name).expect("its name is in the table")))
        .collect();
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("definitions/simulation_interfaces");
    let question = Question {
        own_definitions,
        schemas,
        cases: [all_cases(), simulation_cases()].into_iter().flatten().collect(),
        package,
    };

    let answer = ask(&question);

    assert_eq!(answer.cdr_hex.len(), question.cases.len());
    for (case, expected) in question.cases.iter().zip(&answer.cdr_hex) {
        assert_eq!(&case.cdr_hex, expected, "{} {}", case.type_name, case.values);
    }
    for type_name in question.schemas.keys() {
        assert!(
            question.cases.iter().any(|case| case.type_name == *type_name),
            "{type_name} has a schema and no case"
        );
        assert_eq!(schema::type_hash(type_name), Some(answer.hashes[*type_name].as_str()));
        assert_eq!(answer.parsed[*type_name], answer.expected[*type_name], "{type_name}");
    }
}
