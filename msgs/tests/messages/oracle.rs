//! Holds every message against `rosbags`, an independent implementation of ROS 2's formats.
//!
//! Rust writes made-up messages as JSON and as CDR and the script answers with what `rosbags` makes
//! of the same values; the stock definitions that it compares with are its own, and those of the
//! parameter services come from a package of ROS 2 Jazzy.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use rsrs_msgs::rsrs::{EStopLock, EStopLocks, Recorded, RobotStatus, RunLease, WorldDigest};
use rsrs_msgs::{RosMessage, motion_capture_tracking_interfaces, schema};
use rsrs_testing::python;
use serde::{Deserialize, Serialize};

use crate::all_types::all_types;

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

/// Makes up messages of all types, and checks on the way that they survive decoding.
fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for message_type in all_types() {
        for seed in 0..N_SAMPLES {
            let (values, bytes) = (message_type.sample)(seed);
            let again = (message_type.recode)(&bytes).expect("what was encoded decodes");

            assert_eq!(again, bytes, "{} {values}", message_type.name);
            cases.push(Case { type_name: message_type.name, values, cdr_hex: hex(&bytes) });
        }
    }
    cases
}

fn ask(question: &Question) -> RosbagsReport {
    let python = python::python_with(&python::BAGS);
    let folder = tempfile::tempdir().expect("there is room for a temporary folder");
    let file = folder.path().join("question.json");
    std::fs::write(&file, serde_json::to_string(question).expect("a question is plain data"))
        .expect("the temporary folder is writable");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/messages/oracle.py");
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
    let own_types = [
        RunLease::TYPE_NAME,
        RobotStatus::TYPE_NAME,
        WorldDigest::TYPE_NAME,
        Recorded::TYPE_NAME,
        EStopLock::TYPE_NAME,
        EStopLocks::TYPE_NAME,
    ];
    let own_definitions = own_types
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
    let question = Question { own_definitions, schemas, cases: cases(), package };

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
