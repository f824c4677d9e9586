//! Fuzzing of bags: their records are mutated, and lengths, places and checksums made right again.

use std::fs;
use std::path::Path;

use mcap::records::op;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rsrs_bags::trajectory::{RecordedTracker, TrajectoryOptions, read_trajectory};
use rsrs_bags::{Bag, BagOptions, BagWriter, Compression, Packing, recover_into};
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::tracker::Tracker;
use rsrs_msgs::RosMessage;
use rsrs_msgs::geometry_msgs::{Point, PoseArray, Transform, TransformStamped, Vector3};
use rsrs_msgs::motion_capture_tracking_interfaces::{NamedPose, NamedPoseArray};
use rsrs_msgs::rsrs::LeaseState;
use rsrs_msgs::tf2_msgs::TFMessage;
use rsrs_msgs::topics::POSE;
use rsrs_testing::fuzz::{self, Harness};

use crate::recording::damage::{bag_of, file_of, temporary};
use crate::recording::{PERIOD_NS, Recording, odometry};

const ROBOTS: [&str; 2] = ["robot_1", "robot_2"];

/// In front of a message's data: its channel, its number and two times.
const MESSAGE_HEAD: usize = 2 + 4 + 8 + 8;
/// In front of the records of a chunk that is not compressed: two times, size, checksum, the empty name of a
/// compression, and size.
const CHUNK_HEAD: usize = 8 + 8 + 8 + 4 + 4 + 8;

/// A record; if it is a chunk that is not compressed, with the records in it.
#[derive(Clone)]
struct Record {
    opcode: u8,
    content: Vec<u8>,
    within: Vec<Record>,
}

/// The records of a file behind its magic, or of a chunk, as far as they are sound.
fn parse(mut bytes: &[u8]) -> Vec<Record> {
    let mut records = Vec::new();
    while let Some((&[opcode, ref length @ ..], rest)) = bytes.split_first_chunk::<9>() {
        let length = usize::try_from(u64::from_le_bytes(*length)).unwrap_or(usize::MAX);
        let Some((content, behind)) = rest.split_at_checked(length) else { break };
        let is_plain_chunk = opcode == op::CHUNK && content.get(28..32) == Some(&[0; 4]);
        let n_bytes = if is_plain_chunk { CHUNK_HEAD.min(length) } else { length };
        let (content, within) = content.split_at(n_bytes);
        records.push(Record { opcode, content: content.to_vec(), within: parse(within) });
        bytes = behind;
    }
    records
}

/// The bytes of records, whose lengths are right.
fn serialize(records: &[Record]) -> Vec<u8> {
    let bytes_of = |record: &Record| {
        let within = serialize(&record.within);
        let length = (record.content.len() + within.len()) as u64;
        [&[record.opcode][..], &length.to_le_bytes(), &record.content, &within].concat()
    };
    records.iter().map(bytes_of).collect::<Vec<_>>().concat()
}

/// Overwrites bytes, as far as there are any.
fn put(content: &mut [u8], at: usize, bytes: &[u8]) {
    content.iter_mut().skip(at).zip(bytes).for_each(|(old, new)| *old = *new);
}

/// The file of records, in which the checksums are right, and where chunks and the summary are.
fn file_with(records: &[Record]) -> Vec<u8> {
    let mut file = mcap::MAGIC.to_vec();
    let mut chunks = Vec::new();
    let (mut summary, mut offsets, mut n_indices) = (0, 0, 0);
    for record in records {
        let start = file.len();
        let mut record = record.clone();
        let content = &mut record.content;
        match record.opcode {
            op::CHUNK => {
                let within = serialize(&record.within);
                if !within.is_empty() {
                    let length = (within.len() as u64).to_le_bytes();
                    put(content, 16, &length);
                    put(content, 24, &crc32fast::hash(&within).to_le_bytes());
                    put(content, 32, &length);
                }
                chunks.push([start, 9 + content.len() + within.len()]);
            }
            op::CHUNK_INDEX => {
                if let Some(place) = chunks.get(n_indices) {
                    put(content, 16, &place.map(|number| (number as u64).to_le_bytes()).concat());
                }
                n_indices += 1;
            }
            op::ATTACHMENT => {
                let end = content.len().saturating_sub(4);
                let checksum = crc32fast::hash(&content[..end]);
                put(content, end, &checksum.to_le_bytes());
            }
            op::DATA_END => put(content, 0, &crc32fast::hash(&file).to_le_bytes()),
            op::SUMMARY_OFFSET if offsets == 0 => offsets = start,
            op::FOOTER => {
                put(content, 0, &[summary, offsets].map(|at| (at as u64).to_le_bytes()).concat());
                let of_footer = serialize(std::slice::from_ref(&record));
                let covered =
                    [&file[summary..], &of_footer[..of_footer.len().min(9 + 16)]].concat();
                put(&mut record.content, 16, &crc32fast::hash(&covered).to_le_bytes());
            }
            _ => {}
        }
        file.extend(serialize(std::slice::from_ref(&record)));
        if record.opcode == op::DATA_END {
            summary = file.len();
        }
    }
    file.extend(mcap::MAGIC);
    file
}

/// Mutates a record, or the order of records.
fn mutate(input: &mut Vec<u8>, other: &[u8], draw: &mut ChaCha8Rng) {
    let parse_file = |bytes: &[u8]| parse(bytes.get(mcap::MAGIC.len()..).unwrap_or_default());
    let (mut records, others) = (parse_file(input), parse_file(other));
    if records.is_empty() || others.is_empty() || draw.random_range(0..20) == 0 {
        return fuzz::bytes(input, other, draw);
    }
    let another = &others[draw.random_range(0..others.len())];
    let at = draw.random_range(0..records.len());
    // Of a chunk mostly what is in it.
    let is_within = !records[at].within.is_empty() && draw.random_range(0..8) > 0;
    let level = if is_within { &mut records[at].within } else { &mut records };
    let at = draw.random_range(0..level.len());
    match draw.random_range(0..8) {
        0 => drop(level.remove(at)),
        1 => level.insert(at, level[at].clone()),
        2 => level.insert(at, another.clone()),
        3 => level[at].opcode = draw.random_range(1..17),
        _ => {
            let Record { opcode, content, .. } = &mut level[at];
            match *opcode {
                op::MESSAGE if content.len() > MESSAGE_HEAD && draw.random() => {
                    fuzz::behind(MESSAGE_HEAD, fuzz::cdr)(content, other, draw);
                }
                op::SCHEMA if draw.random() => fuzz::text(content, other, draw),
                _ => fuzz::bytes(content, &another.content, draw),
            }
        }
    }
    *input = file_with(&records);
}

/// What all that commands do with a bag comes to.
fn outcome_of(path: &Path, folder: &Path) -> String {
    let bag = match Bag::open(path) {
        Ok(bag) => bag,
        Err(error) => return format!("{error:?}"),
    };
    let unread = bag.messages().find_map(Result::err);
    let n_topics = bag.info().topics.len();
    let trajectories = PoseSource::ALL.map(|source| {
        let names = ROBOTS.map(str::to_owned).to_vec();
        let described = RecordedTracker {
            tracker: Tracker {
                topics: vec!["/unnamed_poses".to_owned()],
                names: names.clone(),
                ..Tracker::default()
            },
            robots: names,
            radius_m: 0.05,
        };
        let tracker = (source == PoseSource::PoseArray).then_some(described);
        let options = TrajectoryOptions { poses: Some(source), tracker, ..Default::default() };
        read_trajectory(&bag, &options).map(|read| (read.findings, read.robots.len()))
    });
    let into = folder.join("saved");
    let saved = recover_into(path, &into, None).map(|saved| {
        let again = Bag::open(&into).expect("it was just saved");
        let read = again.messages().collect::<Result<Vec<_>, _>>().expect("it is whole");
        assert_eq!(read.len() as u64, saved.n_messages);
        fs::remove_dir_all(&into).expect("it is ours");
        saved.losses.iter().map(|loss| loss.kind).collect::<Vec<_>>()
    });
    format!("{n_topics} {unread:?} {trajectories:?} {saved:?}")
}

/// Files of a run and with an attachment.
fn files(folder: &Path) -> Vec<Vec<u8>> {
    let of_a_run = |compression| {
        let path = folder.join(format!("{compression:?}/run"));
        let packing = Packing { compression, ..Packing::default() };
        let writer = BagWriter::create_packed(&path, BagOptions::default(), packing).expect("new");
        let mut recording = Recording::with(writer, &ROBOTS);
        let mut add = |topic, type_name| {
            recording.writer.add_topic(topic, type_name, POSE.qos).expect("it is new")
        };
        let named = add("/poses", NamedPoseArray::TYPE_NAME);
        let unnamed = add("/unnamed_poses", PoseArray::TYPE_NAME);
        let tf = add("/tf", TFMessage::TYPE_NAME);
        recording.lease(0, LeaseState::Running);
        for step in 0..20 {
            recording.step(step);
            let odometry = [0, 1].map(|robot| odometry(robot, step));
            let header = odometry[0].header.clone();
            let poses = odometry.map(|odometry| odometry.pose.pose);
            let named_poses = [0, 1].map(|robot| {
                let name = ROBOTS[robot].to_owned();
                NamedPose { name, pose: poses[robot] }
            });
            let transforms = [0, 1].map(|robot| {
                let Point { x, y, z } = poses[robot].position;
                let (translation, rotation) = (Vector3 { x, y, z }, poses[robot].orientation);
                let child_frame_id = format!("{}/base_link", ROBOTS[robot]);
                let transform = Transform { translation, rotation };
                TransformStamped { header: header.clone(), child_frame_id, transform }
            });
            let time_ns = step * PERIOD_NS;
            recording.put(tf, time_ns, &TFMessage { transforms: transforms.to_vec() });
            let poses = poses.to_vec();
            recording.put(unnamed, time_ns, &PoseArray { header: header.clone(), poses });
            let poses = named_poses.to_vec();
            recording.put(named, time_ns, &NamedPoseArray { header, poses });
        }
        recording.lease(20, LeaseState::Stopped);
        recording.writer.finish().expect("room");
        path
    };
    let bags = [
        of_a_run(Compression::None),
        of_a_run(Compression::Zstd),
        bag_of(folder, Compression::Lz4, 18),
    ];
    bags.iter().map(|bag| fs::read(file_of(bag)).expect("it was just written")).collect()
}

#[test]
fn a_file_that_is_not_mutated_is_the_same_when_its_checksums_are_made_anew() {
    let folder = temporary();
    for file in files(folder.path()) {
        assert!(file_with(&parse(&file[mcap::MAGIC.len()..])) == file);
    }
}

#[test]
fn fuzzed_bags_are_read_and_saved_or_refused() {
    let folder = temporary();
    let path = folder.path().join("fuzzed.mcap");
    let harness = Harness {
        corpus: concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/bags"),
        seeds: files(folder.path()),
        mutation: &mutate,
    };

    let n_outcomes = harness.run(|input| {
        fs::write(&path, input).expect("room");
        outcome_of(&path, folder.path())
    });

    assert!(n_outcomes > 10, "{n_outcomes} outcomes");
}

#[test]
fn fuzzed_tables_of_contents_are_read_or_refused() {
    let folder = temporary();
    let path = bag_of(folder.path(), Compression::None, 3);
    let table = path.join("metadata.yaml");
    let harness = Harness {
        corpus: concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/metadata"),
        seeds: vec![fs::read(&table).expect("a bag has one")],
        mutation: &fuzz::text,
    };

    let n_outcomes = harness.run(|input| {
        fs::write(&table, input).expect("room");
        outcome_of(&path, folder.path())
    });

    assert!(n_outcomes > 5, "{n_outcomes} outcomes");
}
