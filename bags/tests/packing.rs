//! Bags that are split or compressed in other ways, and topics of types that are not ours.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use rsrs_bags::definitions::Definitions;
use rsrs_bags::{Bag, BagError, BagOptions, BagWriter, Compression, Packing, Sample};
use rsrs_msgs::topics::Qos;
use rsrs_testing::python;

use crate::recording::damage::{messages, temporary};
use crate::recording::{PERIOD_NS, Recording};

fn recorded(path: &Path, packing: Packing, n_steps: u64) -> Vec<String> {
    let custom_data = BTreeMap::from([("run_id".to_owned(), "7".to_owned())]);
    let writer = BagWriter::create_packed(path, BagOptions { custom_data }, packing).expect("new");
    let mut recording = Recording::with(writer, &["robot_1", "robot_2"]);
    recording.writer.attach("experiment.json", "application/json", b"{}").expect("room");
    (0..n_steps).for_each(|step| recording.step(step));
    let summary = recording.writer.finish().expect("room");
    let names =
        summary.files.iter().map(|file| file.file_name().expect("a file").to_string_lossy());
    names.map(String::from).collect()
}

/// What `rosbags` counts in a bag, by topic.
fn counted_by_rosbags(path: &Path) -> BTreeMap<String, u64> {
    let python = python::python_with(&python::BAGS);
    let script = "
import json, sys
from collections import Counter
from pathlib import Path
from rosbags.highlevel import AnyReader
counts = Counter()
with AnyReader([Path(sys.argv[1])]) as reader:
    for connection, _, data in reader.messages():
        reader.deserialize(data, connection.msgtype)
        counts[connection.topic] += 1
print(json.dumps(counts))
";
    let printed = python::must_run(Command::new(python).args(["-c", script]).arg(path));
    serde_json::from_str(&printed).expect("the script answers in JSON")
}

/// The hash that `rosbags` gives a type by its definition in a bag.
fn hash_by_rosbags(path: &Path, type_name: &str) -> String {
    let python = python::python_with(&python::BAGS);
    let script = "
import sys
from pathlib import Path
from rosbags.highlevel import AnyReader
with AnyReader([Path(sys.argv[1])]) as reader:
    print(reader.typestore.hash_rihs01(sys.argv[2]))
";
    let mut command = Command::new(python);
    let printed = python::must_run(command.args(["-c", script]).arg(path).arg(type_name));
    printed.trim().to_owned()
}

#[test]
fn a_bag_is_split_by_time_as_rosbag2_splits_it() {
    let folder = temporary();
    let path = folder.path().join("run");
    let packing = Packing { max_file_duration_ns: Some(20 * PERIOD_NS), ..Packing::default() };

    let names = recorded(&path, packing, 50);

    assert_eq!(names, ["run_0.mcap", "run_1.mcap", "run_2.mcap"]);
    let info = Bag::open(&path).unwrap().info();
    let n_messages: Vec<u64> = info.files.iter().map(|file| file.n_messages).collect();
    assert_eq!(n_messages, [120, 120, 60]);
    assert!(info.has_experiment);
    assert_eq!(info.files[1].bounds_ns, Some((20 * PERIOD_NS, 39 * PERIOD_NS)));
    let whole = folder.path().join("whole");
    recorded(&whole, Packing::default(), 50);
    assert_eq!(messages(&path), messages(&whole));
    let counted = counted_by_rosbags(&path);
    assert_eq!(counted["/robot_2/odom"], 50);
    assert_eq!(counted.values().sum::<u64>(), 300);
    // One part alone states what it belongs to, and has all topics.
    let part = Bag::open(&path.join("run_1.mcap")).unwrap();
    assert_eq!(part.custom_data()["run_id"], "7");
    assert_eq!(part.topics().len(), 7);
}

#[test]
fn a_bag_is_split_by_size_within_a_chunk() {
    let folder = temporary();
    let path = folder.path().join("run");
    let packing = Packing {
        compression: Compression::None,
        max_file_bytes: Some(100_000),
        ..Packing::default()
    };

    let names = recorded(&path, packing, 200);

    assert!(names.len() > 2, "{names:?}");
    for file in &Bag::open(&path).unwrap().info().files {
        // A second of this bag takes about 14 kB, and the index behind the data some more.
        assert!(file.n_bytes < 140_000, "{} bytes", file.n_bytes);
    }
    assert_eq!(messages(&path).len(), 1200);
}

#[test]
fn a_bag_that_is_full_refuses_messages_by_name_and_counts_them() {
    let folder = temporary();
    let path = folder.path().join("run");
    let packing = Packing {
        max_bag_bytes: Some(30_000),
        max_file_bytes: Some(20_000),
        compression: Compression::None,
        ..Packing::default()
    };
    let mut writer = BagWriter::create_packed(&path, BagOptions::default(), packing).unwrap();
    let topic = writer.add_topic("/a", "std_msgs/msg/Bool", Qos::reliable(1)).unwrap();
    let mut n_refused = 0;
    for step in 0..2_000 {
        let log_time_ns = step * 50_000_000;
        let sample =
            Sample { log_time_ns, publish_time_ns: 0, sequence: 0, data: &[0, 1, 0, 0, 1] };
        match writer.write(topic, sample) {
            Ok(()) => assert_eq!(n_refused, 0, "a full bag stays full"),
            Err(BagError::Full { max_bytes: 30_000, .. }) => n_refused += 1,
            Err(error) => panic!("{error}"),
        }
    }

    let summary = writer.finish().unwrap();

    assert!(n_refused > 0);
    assert_eq!(summary.n_messages + n_refused, 2_000);
    assert!(summary.files.len() > 1, "{:?}", summary.files);
    let bag = Bag::open(&path).unwrap();
    assert_eq!(bag.n_messages(), summary.n_messages);
    let limit = bag.metadata("rsrs.limit").unwrap();
    assert_eq!(
        (limit["max_bag_bytes"].as_str(), limit["n_refused"].parse()),
        ("30000", Ok(n_refused))
    );
    let n_bytes: u64 = summary.files.iter().map(|file| file.metadata().unwrap().len()).sum();
    assert!((30_000..60_000).contains(&n_bytes), "{n_bytes} bytes");
}

#[test]
fn every_compression_is_read_by_others_and_named() {
    let folder = temporary();
    let named = [
        (Compression::None, vec![]),
        (Compression::Zstd, vec!["zstd"]),
        (Compression::Lz4, vec!["lz4"]),
    ];
    for (compression, expected) in named {
        let path = folder.path().join(format!("{compression:?}"));
        recorded(&path, Packing { compression, ..Packing::default() }, 30);

        let info = Bag::open(&path).unwrap().info();

        assert_eq!(info.compression.chunks, expected);
        assert_eq!(counted_by_rosbags(&path).values().sum::<u64>(), 180);
    }
}

#[test]
fn a_bag_that_was_killed_when_it_had_just_begun_is_a_bag() {
    let folder = temporary();
    let path = folder.path().join("run");
    let custom_data = BTreeMap::from([("run_id".to_owned(), "7".to_owned())]);
    let options = BagOptions { custom_data: custom_data.clone() };
    std::mem::forget(BagWriter::create(&path, options).unwrap());

    let bag = Bag::open(&path).unwrap();

    assert_eq!(bag.custom_data(), &custom_data);
    assert_eq!((bag.n_messages(), bag.damage().len()), (0, 1));
    assert_eq!(bag.info().duration_s.to_bits(), 0.0_f64.to_bits());
}

/// A workspace with a package of messages, as colcon and ament lay it out.
fn workspace(folder: &Path) {
    let files = [
        (
            "src/robots/lab_msgs/msg/Battery.msg",
            "# The battery.\nstd_msgs/Header header\nCell[] cells\n",
        ),
        ("src/robots/lab_msgs/msg/Cell.msg", "float32 voltage_v # each\nuint8 OK=0\nuint8 state\n"),
        (
            "install/more_msgs/share/more_msgs/msg/Pair.msg",
            "lab_msgs/Cell a\ngeometry_msgs/Point b\n",
        ),
    ];
    for (file, text) in files {
        let path = folder.join(file);
        fs::create_dir_all(path.parent().expect("it is in a folder")).expect("room");
        fs::write(path, text).expect("room");
    }
}

#[test]
fn others_decode_a_topic_of_the_users_own_type() {
    let folder = temporary();
    workspace(folder.path());
    let definitions = Definitions::new(vec![folder.path().to_owned()]);
    let battery = definitions.find("lab_msgs/msg/Battery").unwrap();
    let path = folder.path().join("run");
    let mut writer = BagWriter::create(&path, BagOptions::default()).unwrap();
    let channel = writer.add_topic_with_schema("/r1/battery", Qos::reliable(3), &battery).unwrap();
    // Stamp, empty frame, one cell of 3.7 V in state 2.
    let mut data = vec![0, 1, 0, 0];
    data.extend([7_u32, 8, 1].map(u32::to_le_bytes).concat());
    data.extend([0, 0, 0, 0]);
    data.extend(1_u32.to_le_bytes());
    data.extend(3.7_f32.to_le_bytes());
    data.push(2);
    let sample = Sample { log_time_ns: 5, publish_time_ns: 5, sequence: 0, data: &data };
    writer.write(channel, sample).unwrap();
    writer.finish().unwrap();

    let pair = definitions.find("more_msgs/msg/Pair").unwrap();
    let parts = pair.text.lines().filter_map(|line| line.strip_prefix("MSG: "));
    assert_eq!(parts.collect::<Vec<_>>(), ["geometry_msgs/Point", "lab_msgs/Cell"]);
    assert_eq!(counted_by_rosbags(&path), BTreeMap::from([("/r1/battery".to_owned(), 1)]));
    let bag = Bag::open(&path).unwrap();
    assert_eq!(bag.schema("lab_msgs/msg/Battery"), Some(battery.text.as_bytes()));
    assert_eq!(bag.topics()[0].type_hash, hash_by_rosbags(&path, "lab_msgs/msg/Battery"));
}
