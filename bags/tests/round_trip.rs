//! What is written is read back, from whole bags and from broken ones.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use mcap::WriteOptions;
use proptest::prelude::*;
use rsrs_bags::{Bag, BagError, BagMessage, BagOptions, BagWriter, LossKind, Sample, recover};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::{self, Qos};
use rsrs_msgs::{cdr, schema};

use crate::recording::damage::{messages, temporary};
use crate::recording::{PERIOD_NS, Recording, foreign};

/// A bag of two robots and so many steps.
fn small_bag(folder: &Path, n_steps: u64) -> PathBuf {
    let path = folder.join("run");
    let mut recording = Recording::new(&path, &["robot_1", "robot_2"]);
    recording.writer.attach("experiment.yaml", "application/yaml", b"seed: 42\n").expect("room");
    for step in 0..n_steps {
        recording.step(step);
    }
    recording.writer.finish().expect("room");
    path
}

fn log_times(path: &Path) -> Vec<u64> {
    messages(path).iter().map(|message| message.log_time_ns).collect()
}

#[test]
fn messages_come_back_with_their_times_types_and_bytes() {
    let folder = temporary();
    let path = folder.path().join("run");
    let mut writer = BagWriter::create(&path, BagOptions::default()).unwrap();
    let topic = topics::DETECTION;
    let channel = writer.add_topic("/robot_1/detection", topic.type_name, topic.qos).unwrap();
    let data = cdr::encode(&Bool { data: true });
    let sample = Sample { log_time_ns: 7, publish_time_ns: 5, sequence: 3, data: &data };
    writer.write(channel, sample).unwrap();

    let summary = writer.finish().unwrap();

    let expected = BagMessage {
        topic: "/robot_1/detection".into(),
        type_name: "std_msgs/msg/Bool".into(),
        log_time_ns: 7,
        publish_time_ns: 5,
        sequence: 3,
        bytes: data,
    };
    assert_eq!(messages(&path), [expected]);
    assert_eq!((summary.n_messages, summary.bounds_ns), (1, Some((7, 7))));
}

#[test]
fn messages_are_in_the_order_of_log_time_whatever_the_order_of_recording() {
    let folder = temporary();
    let path = folder.path().join("run");
    let mut writer = BagWriter::create(&path, BagOptions::default()).unwrap();
    let channel = writer.add_topic("/a", "std_msgs/msg/Bool", Qos::reliable(1)).unwrap();
    let times_ns = [9, 1, 5_000_000_000, 3, 4_000_000_000];
    for log_time_ns in times_ns {
        let data = cdr::encode(&Bool { data: false });
        let sample = Sample { log_time_ns, publish_time_ns: 0, sequence: 0, data: &data };
        writer.write(channel, sample).unwrap();
    }
    writer.finish().unwrap();

    assert_eq!(log_times(&path), [1, 3, 9, 4_000_000_000, 5_000_000_000]);
}

#[test]
fn attachments_metadata_and_custom_data_come_back() {
    let folder = temporary();
    let path = folder.path().join("run");
    let custom_data = BTreeMap::from([("cell".to_owned(), "0.15, 0.75".to_owned())]);
    let options = BagOptions { custom_data: custom_data.clone() };
    let mut writer = BagWriter::create(&path, options).unwrap();
    let pairs = BTreeMap::from([("seed".to_owned(), "42".to_owned())]);
    writer.attach("experiment.yaml", "application/yaml", b"a: 1\n").unwrap();
    writer.metadata("rsrs.experiment", pairs.clone()).unwrap();
    writer.finish().unwrap();

    let bag = Bag::open(&path).unwrap();

    let attachment = bag.attachment("experiment.yaml").unwrap();
    assert_eq!((&*attachment.media_type, &*attachment.data), ("application/yaml", &b"a: 1\n"[..]));
    assert_eq!(bag.metadata("rsrs.experiment"), Some(&pairs));
    assert_eq!(bag.custom_data(), &custom_data);
    assert!(bag.metadata("rosbag2").unwrap().contains_key("serialized_metadata"));
}

#[test]
fn topics_have_type_hash_quality_of_service_and_count() {
    let folder = temporary();
    let bag = Bag::open(&small_bag(folder.path(), 10)).unwrap();

    let topics = bag.topics();

    let odom = topics.iter().find(|topic| topic.name == "/robot_2/odom").unwrap();
    assert_eq!(odom.type_name, "nav_msgs/msg/Odometry");
    assert_eq!(odom.encoding, "cdr");
    assert_eq!(Some(odom.type_hash.as_str()), schema::type_hash("nav_msgs/msg/Odometry"));
    assert!(odom.offered_qos_profiles.contains("depth: 200\n  reliability: 1\n  durability: 2"));
    assert_eq!(odom.n_messages, 10);
    assert_eq!(bag.n_messages(), 60);
}

#[test]
fn a_folder_that_exists_is_refused_and_left_alone() {
    let folder = temporary();

    let error = BagWriter::create(folder.path(), BagOptions::default()).err().unwrap();

    assert!(matches!(error, BagError::Exists { .. }), "{error}");
    assert_eq!(folder.path().read_dir().unwrap().count(), 0);
}

#[test]
fn a_topic_is_added_once_and_only_with_a_known_type() {
    let folder = temporary();
    let mut writer = BagWriter::create(&folder.path().join("run"), BagOptions::default()).unwrap();
    writer.add_topic("/a", "std_msgs/msg/Bool", Qos::reliable(1)).unwrap();

    let twice = writer.add_topic("/a", "std_msgs/msg/Bool", Qos::reliable(1)).unwrap_err();
    let unknown = writer.add_topic("/b", "lab_msgs/msg/Secret", Qos::reliable(1)).unwrap_err();

    assert!(matches!(twice, BagError::DuplicateTopic { .. }), "{twice}");
    let text = "topic /b has type lab_msgs/msg/Secret, of which no definition is known";
    assert_eq!(unknown.to_string(), text);
}

#[test]
fn a_killed_recorder_loses_less_than_a_second() {
    let folder = temporary();
    let path = folder.path().join("run");
    let custom_data = BTreeMap::from([("run_id".to_owned(), "7".to_owned())]);
    let options = BagOptions { custom_data: custom_data.clone() };
    let writer = BagWriter::create(&path, options).unwrap();
    let mut recording = Recording::with(writer, &["robot_1"]);
    recording.writer.attach("experiment.yaml", "application/yaml", b"seed: 42\n").unwrap();
    let n_steps = 100;
    for step in 0..n_steps {
        recording.step(step);
    }
    // What a kill does: nothing more is written, not even what the process still holds.
    std::mem::forget(recording);

    let bag = Bag::open(&path).unwrap();

    let mut messages = bag.messages();
    let read: Vec<BagMessage> = messages.by_ref().map_while(Result::ok).collect();
    let last_ns = read.last().unwrap().log_time_ns;
    assert!((n_steps - 1) * PERIOD_NS - last_ns < 1_000_000_000, "read up to {last_ns} ns");
    let damage = &bag.damage()[0];
    assert_eq!(damage.n_messages, read.len() as u64);
    assert_eq!(damage.last_log_time_ns, Some(last_ns));
    assert_eq!(bag.attachment("experiment.yaml").unwrap().data, b"seed: 42\n");
    assert!(!path.join("metadata.yaml").exists());
    let recovered = recover(&path).unwrap();
    assert_eq!(recovered.bounds_ns.unwrap().1, last_ns);
    let loss = &recovered.losses[0];
    assert_eq!((loss.kind, loss.n_bytes), (LossKind::EndOfFile, 0));
    assert!(!recovered.lost.is_exact);
    assert_eq!(Bag::open(&recovered.folder).unwrap().custom_data(), &custom_data);
}

#[test]
fn a_bag_cut_at_any_byte_gives_a_beginning_of_itself_or_an_error() {
    let folder = temporary();
    let path = small_bag(folder.path(), 12).join("run_0.mcap");
    let whole = messages(&path);
    let bytes = fs::read(&path).unwrap();
    let cut = folder.path().join("cut.mcap");

    for n_bytes in 0..bytes.len() {
        fs::write(&cut, &bytes[..n_bytes]).unwrap();
        let Ok(bag) = Bag::open(&cut) else { continue };
        let mut outcomes: Vec<_> = bag.messages().collect();
        // Where only the summary section is cut, all is there.
        let is_whole = bag.damage().is_empty();
        if !is_whole {
            let error = outcomes.pop().expect("it says so at the end").unwrap_err();
            let BagError::Incomplete { n_messages, .. } = error else { panic!("{error}") };
            assert_eq!(n_messages, outcomes.len() as u64, "{n_bytes} bytes");
        }
        let read: Vec<BagMessage> = outcomes.into_iter().map(Result::unwrap).collect();

        assert_eq!(read, whole[..read.len()], "{n_bytes} bytes");
        assert_eq!(bag.summary_faults().len(), usize::from(is_whole), "{n_bytes} bytes");
        assert!(!is_whole || read.len() == whole.len(), "{n_bytes} bytes");
    }
}

/// A whole file of twelve steps, made once.
static WHOLE: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let folder = temporary();
    let path = small_bag(folder.path(), 12).join("run_0.mcap");
    fs::read(path).expect("it was just written")
});

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn a_changed_byte_never_panics_nor_invents_messages(
        at in any::<prop::sample::Index>(),
        mask in 1_u8..,
    ) {
        let folder = temporary();
        let path = folder.path().join("changed.mcap");
        let mut bytes = WHOLE.clone();
        let n_whole = 12 * 6;
        let at = at.index(bytes.len());
        bytes[at] ^= mask;
        fs::write(&path, &bytes).expect("room");

        if let Ok(bag) = Bag::open(&path) {
            let n_read = bag.messages().take(2 * n_whole).flatten().count();
            prop_assert!(n_read <= n_whole);
        }
    }
}

#[test]
fn what_is_no_bag_of_ros_2_is_refused_by_name() {
    let folder = temporary();
    let file = |name: &str| folder.path().join(name);
    fs::write(file("empty.mcap"), b"").unwrap();
    fs::write(file("text.mcap"), b"a text that is not a bag").unwrap();
    fs::write(file("ros1.mcap"), foreign(WriteOptions::new().profile("ros1"), [1])).unwrap();
    fs::create_dir(file("nothing")).unwrap();

    let refused = |name| Bag::open(&file(name)).unwrap_err();

    assert!(matches!(refused("empty.mcap"), BagError::Empty { .. }));
    assert!(matches!(refused("text.mcap"), BagError::NotMcap { .. }));
    assert!(
        refused("ros1.mcap").to_string().ends_with("has MCAP profile \"ros1\", expected \"ros2\"")
    );
    assert!(matches!(refused("nothing"), BagError::NoFiles { .. }));
    assert!(matches!(refused("absent"), BagError::Io { .. }));
}

#[test]
fn split_files_follow_the_table_of_contents_or_else_their_numbers() {
    let folder = temporary();
    for (name, time_ns) in [("talk_2", 1), ("talk_10", 2), ("talk_1", 3)] {
        let bytes = foreign(WriteOptions::new().profile("ros2"), [time_ns]);
        fs::write(folder.path().join(format!("{name}.mcap")), bytes).unwrap();
    }
    let by_number = log_times(folder.path());
    let table = "rosbag2_bagfile_information:\n  relative_file_paths:\n    - talk_2.mcap\n    - talk_10.mcap\n    - talk_1.mcap\n  custom_data: ~\n";
    fs::write(folder.path().join("metadata.yaml"), table).unwrap();
    let by_table = log_times(folder.path());

    assert_eq!(by_number, [3, 1, 2]);
    assert_eq!(by_table, [1, 2, 3]);
}

#[test]
fn only_the_topics_that_were_asked_for_come() {
    let folder = temporary();
    let bag = Bag::open(&small_bag(folder.path(), 5)).unwrap();

    let messages: Vec<BagMessage> =
        bag.messages_on(["/robot_1/odom", "/absent"]).map(Result::unwrap).collect();

    assert_eq!(messages.len(), 5);
    assert!(messages.iter().all(|message| &*message.topic == "/robot_1/odom"));
}
