//! Whole bags as every release of rosbag2 that has MCAP lays them out, from Galactic to Lyrical.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs::{self, File};
use std::io::BufWriter;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;

use mcap::WriteOptions;
use mcap::records::{MessageHeader, Metadata};
use rsrs_bags::{Bag, OfferedQos, recover_into};
use rsrs_testing::python;

const TYPE: &str = "std_msgs/msg/String";
/// Of that type, as its definition in the distributions gives it.
const HASH: &str = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18";
const TOPIC: &str = "/chatter";
const N_MESSAGES: u64 = 60;

/// Between two messages, in nanoseconds.
const STEP_NS: u64 = 100_000_000;

/// When the first message came, in nanoseconds.
const START_NS: u64 = 1_700_000_000_000_000_000;

/// What a recorder was set to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    None,
    File,
    Message,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Layout {
    /// One file of chunks.
    Whole,
    /// A file for each third of the messages.
    Split,
    /// One file without chunks and index: the preset `fastwrite`.
    Unindexed,
}

/// A bag of one release.
#[derive(Clone, Copy, Debug)]
struct Kind {
    /// Of its `metadata.yaml`.
    version: u32,
    mode: Mode,
    layout: Layout,
}

impl Kind {
    fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for version in 4..=9 {
            for mode in [Mode::None, Mode::File, Mode::Message] {
                for layout in [Layout::Whole, Layout::Split, Layout::Unindexed] {
                    all.push(Self { version, mode, layout });
                }
            }
        }
        all
    }

    fn name(self) -> String {
        format!("{:?}_{:?}_{}", self.layout, self.mode, self.version).to_lowercase()
    }

    /// Records the bag.
    fn record(self, folder: &Path) -> PathBuf {
        let bag = folder.join(self.name());
        fs::create_dir(&bag).expect("it is new");
        let n_files = match self.layout {
            Layout::Split => 3,
            Layout::Whole | Layout::Unindexed => 1,
        };
        let n_in_file = N_MESSAGES / n_files;
        let parts = (0..n_files).map(|number| number * n_in_file..(number + 1) * n_in_file);
        let files: Vec<(String, Range<u64>)> = parts
            .enumerate()
            .map(|(number, messages)| (format!("{}_{number}.mcap", self.name()), messages))
            .collect();
        let mut listed = Vec::new();
        for (name, messages) in files {
            let path = bag.join(&name);
            self.file(&path, messages.clone());
            if self.mode == Mode::File {
                // rosbag2 leaves the compressed file alone behind, and lists it.
                let packed = zstd::bulk::compress(&fs::read(&path).expect("it was written"), 1);
                fs::write(bag.join(format!("{name}.zstd")), packed.expect("it packs"))
                    .expect("room");
                fs::remove_file(&path).expect("it is there");
                listed.push((format!("{name}.zstd"), messages));
            } else {
                listed.push((name, messages));
            }
        }
        fs::write(bag.join("metadata.yaml"), self.contents(&listed)).expect("room");
        bag
    }

    fn file(self, path: &Path, messages: Range<u64>) {
        let file = BufWriter::new(File::create_new(path).expect("it is new"));
        let options = WriteOptions::new()
            .profile("ros2")
            .library("libmcap 1.1.0")
            .compression(None)
            .use_chunks(self.layout != Layout::Unindexed)
            .chunk_size(Some(400));
        let mut writer = options.create(file).expect("room");
        let schema = writer.add_schema(TYPE, "ros2msg", b"string data\n").expect("room");
        let mut described =
            BTreeMap::from([("offered_qos_profiles".to_owned(), self.quality().to_owned())]);
        if self.version >= 7 {
            described.insert("topic_type_hash".to_owned(), HASH.to_owned());
        }
        let channel_id = writer.add_channel(schema, TOPIC, "cdr", &described).expect("room");
        for number in messages {
            let (log_time, data) = message(number);
            let data = match self.mode {
                Mode::Message => zstd::bulk::compress(&data, 1).expect("it packs"),
                Mode::None | Mode::File => data,
            };
            let header =
                MessageHeader { channel_id, sequence: 0, log_time, publish_time: log_time };
            writer.write_to_known_channel(&header, &data).expect("room");
        }
        if self.version >= 7 {
            let metadata =
                BTreeMap::from([("ROS_DISTRO".to_owned(), self.distribution().to_owned())]);
            let record = Metadata { name: "rosbag2".to_owned(), metadata };
            writer.write_metadata(&record).expect("room");
        }
        writer.finish().expect("room");
    }

    /// The quality of service, as the release puts it into text.
    fn quality(self) -> &'static str {
        if self.version < 9 {
            "- history: 1\n  depth: 7\n  reliability: 2\n  durability: 1\n  deadline:\n    sec: \
             9223372036\n    nsec: 854775807\n  lifespan:\n    sec: 9223372036\n    nsec: \
             854775807\n  liveliness: 1\n  liveliness_lease_duration:\n    sec: 9223372036\n    \
             nsec: 854775807\n  avoid_ros_namespace_conventions: false"
        } else {
            "- history: keep_last\n  depth: 7\n  reliability: best_effort\n  durability: \
             transient_local\n  deadline:\n    sec: 9223372036\n    nsec: 854775807\n  lifespan:\n    \
             sec: 9223372036\n    nsec: 854775807\n  liveliness: automatic\n  \
             liveliness_lease_duration:\n    sec: 9223372036\n    nsec: 854775807\n  \
             avoid_ros_namespace_conventions: false"
        }
    }

    fn distribution(self) -> &'static str {
        match self.version {
            ..=7 => "iron",
            8 => "rolling",
            _ => "jazzy",
        }
    }

    /// `metadata.yaml`, with the fields of its version in their order.
    fn contents(self, files: &[(String, Range<u64>)]) -> String {
        let mut text = format!(
            "rosbag2_bagfile_information:\n  version: {}\n  storage_identifier: mcap\n",
            self.version
        );
        let mut paths = "  relative_file_paths:\n".to_owned();
        for (name, _) in files {
            writeln!(paths, "    - {name}").expect("a string takes any text");
        }
        if self.version == 4 {
            text.push_str(&paths);
        }
        text.push_str(&span("  ", &(0..N_MESSAGES)));
        let quality = if self.version < 9 {
            format!("\"{}\"\n", self.quality().replace('\n', "\\n"))
        } else {
            format!("\n          {}\n", self.quality().replace('\n', "\n          "))
        };
        write!(
            text,
            "  message_count: {N_MESSAGES}\n  topics_with_message_count:\n    - topic_metadata:\n        \
             name: {TOPIC}\n        type: {TYPE}\n        serialization_format: cdr\n        \
             offered_qos_profiles: {quality}"
        )
        .expect("a string takes any text");
        if self.version >= 7 {
            writeln!(text, "        type_description_hash: {HASH}").expect("it takes any text");
        }
        let (format, mode) = match self.mode {
            Mode::None => ("\"\"", "\"\""),
            Mode::File => ("zstd", "FILE"),
            Mode::Message => ("zstd", "MESSAGE"),
        };
        write!(
            text,
            "      message_count: {N_MESSAGES}\n  compression_format: {format}\n  compression_mode: \
             {mode}\n"
        )
        .expect("a string takes any text");
        if self.version >= 5 {
            text.push_str(&paths);
            text.push_str("  files:\n");
            for (name, messages) in files {
                let n_messages = messages.end - messages.start;
                let span = span("      ", messages);
                writeln!(text, "    - path: {name}\n{span}      message_count: {n_messages}")
                    .expect("a string takes any text");
            }
        }
        if self.version >= 6 {
            text.push_str("  custom_data: {lab: another}\n");
        }
        if self.version >= 8 {
            writeln!(text, "  ros_distro: {}", self.distribution()).expect("it takes any text");
        }
        text
    }
}

/// From when on, and for how long.
fn span(indent: &str, messages: &Range<u64>) -> String {
    let duration_ns = (messages.end - messages.start - 1) * STEP_NS;
    let start_ns = START_NS + messages.start * STEP_NS;
    let start = format!("{indent}starting_time:\n{indent}  nanoseconds_since_epoch: {start_ns}\n");
    let duration = format!("{indent}duration:\n{indent}  nanoseconds: {duration_ns}\n");
    // The bag has its duration in front, its files behind.
    if indent.len() == 2 { duration + &start } else { start + &duration }
}

/// When a message came, in nanoseconds, and its bytes.
fn message(number: u64) -> (u64, Vec<u8>) {
    let text =
        format!("message {number} ").repeat(usize::try_from(number % 10).expect("small") + 1);
    let length = u32::try_from(text.len() + 1).expect("it is short");
    let data = [&[0, 1, 0, 0], &length.to_le_bytes()[..], text.as_bytes(), &[0]].concat();
    (START_NS + number * STEP_NS, data)
}

fn recorded() -> Vec<(u64, Vec<u8>)> {
    (0..N_MESSAGES).map(message).collect()
}

fn read(path: &Path) -> Vec<(u64, Vec<u8>)> {
    let bag = Bag::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let messages = bag.messages().map(|message| {
        let message = message.unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        assert_eq!((&*message.topic, &*message.type_name), (TOPIC, TYPE));
        (message.log_time_ns, message.bytes)
    });
    messages.collect()
}

#[test]
fn whole_bags_of_every_version_read_with_and_without_their_table_of_contents() {
    let folder = tempfile::tempdir().unwrap();
    for kind in Kind::all() {
        let path = kind.record(folder.path());

        let bag = Bag::open(&path).unwrap();
        let info = bag.info();
        let with = read(&path);
        fs::remove_file(path.join("metadata.yaml")).unwrap();
        let without = read(&path);

        assert_eq!(with, recorded(), "{kind:?}");
        assert_eq!(without, recorded(), "{kind:?}");
        assert_eq!(info.metadata_version, Some(kind.version));
        assert_eq!(info.ros_distro.is_some(), kind.version >= 8, "{kind:?}");
        assert_eq!(info.custom_data.contains_key("lab"), kind.version >= 6, "{kind:?}");
        let offered = OfferedQos {
            history: "keep_last",
            depth: 7,
            reliability: "best_effort",
            durability: "transient_local",
        };
        assert_eq!(info.topics[0].offered_qos, [offered], "{kind:?}");
        assert_eq!(info.topics[0].n_messages, N_MESSAGES, "{kind:?}");
        assert_eq!(info.compression.files, kind.mode == Mode::File, "{kind:?}");
        assert_eq!(info.compression.messages, kind.mode == Mode::Message, "{kind:?}");
        assert_eq!(info.files.len(), if kind.layout == Layout::Split { 3 } else { 1 }, "{kind:?}");
    }
}

#[test]
fn bags_of_every_version_are_recovered_without_loss() {
    let folder = tempfile::tempdir().unwrap();
    for kind in Kind::all() {
        let path = kind.record(folder.path());
        let saved = folder.path().join(format!("{}_saved", kind.name()));

        let recovered = recover_into(&path, &saved, None).unwrap();

        assert!(recovered.is_complete(), "{kind:?}: {recovered:?}");
        assert_eq!(read(&saved), recorded(), "{kind:?}");
        let info = Bag::open(&saved).unwrap().info();
        assert!(!info.compression.files && !info.compression.messages, "{kind:?}");
        assert_eq!(info.custom_data.contains_key("lab"), kind.version >= 6, "{kind:?}");
    }
}

#[test]
fn bags_of_every_version_are_those_that_another_reader_reads() {
    let folder = tempfile::tempdir().unwrap();
    for kind in Kind::all() {
        kind.record(folder.path());
    }
    let python = python::python_with(&python::BAGS);
    let script = "
import json, sys
from pathlib import Path
from rosbags.rosbag2 import Reader
bags = {}
for path in sorted(Path(sys.argv[1]).iterdir()):
    with Reader(path) as reader:
        bags[path.name] = [[time, list(data)] for _, time, data in reader.messages()]
print(json.dumps(bags))
";

    let printed = python::must_run(Command::new(python).args(["-c", script]).arg(folder.path()));

    let bags: BTreeMap<String, Vec<(u64, Vec<u8>)>> = serde_json::from_str(&printed).unwrap();
    assert_eq!(bags.len(), Kind::all().len());
    for (name, messages) in bags {
        assert_eq!(messages, recorded(), "{name}");
    }
}
