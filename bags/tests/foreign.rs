//! Bags that another writer made, with all the options there are.

use std::fs;
use std::path::Path;
use std::process::Command;

use rsrs_bags::{Bag, BagError, BagMessage, Compression, OfferedQos, recover_into};
use rsrs_core::help::Help;
use rsrs_testing::python;

use crate::recording::damage::{bag_of, chunks, file_of};

fn messages(bag: &Bag) -> Vec<BagMessage> {
    bag.messages().collect::<Result<_, _>>().expect("the bag is whole")
}

/// The bags of `foreign.py`, in a folder of this test's own.
fn foreign_bags() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("there is room for a temporary folder");
    let python = python::python_with(&python::BAGS);
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/foreign.py");
    python::must_run(Command::new(python).arg(script).arg(folder.path()));
    folder
}

/// The text in a string message.
fn text(message: &BagMessage) -> &str {
    let length = u32::from_le_bytes(message.bytes[4..8].try_into().expect("four bytes"));
    let end = 8 + usize::try_from(length).expect("it is short") - 1;
    std::str::from_utf8(&message.bytes[8..end]).expect("it is text")
}

fn assert_is_chatter(bag: &Bag, name: &str) {
    let messages = messages(bag);
    assert_eq!(messages.len(), 100, "{name}");
    for (number, message) in messages.iter().enumerate() {
        assert_eq!(message.log_time_ns, 1000 + number as u64, "{name}");
        let expected = format!("message {number} ").repeat(number % 10 + 1);
        assert_eq!(text(message), expected, "{name}");
    }
}

#[test]
fn every_version_and_compression_of_another_writer_is_read() {
    let folder = foreign_bags();
    for version in [8, 9] {
        for mode in ["none", "file", "message", "storage"] {
            let name = format!("{mode}_{version}");
            let path = folder.path().join(&name);

            let bag = Bag::open(&path).unwrap();

            assert_is_chatter(&bag, &name);
            let info = bag.info();
            assert_eq!(info.metadata_version, Some(version), "{name}");
            assert_eq!(info.custom_data["lab"], "another", "{name}");
            let offered = OfferedQos {
                history: "keep_last",
                depth: 7,
                reliability: "best_effort",
                durability: "transient_local",
            };
            assert_eq!(info.topics[0].offered_qos, [offered], "{name}");
            assert_eq!(info.compression.files, mode == "file", "{name}");
            assert_eq!(info.compression.messages, mode == "message", "{name}");
            // Without its table of contents, the same.
            fs::remove_file(path.join("metadata.yaml")).unwrap();
            assert_is_chatter(&Bag::open(&path).unwrap(), &name);
        }
    }
}

#[test]
fn a_compressed_file_that_was_cut_gives_its_beginning() {
    let folder = foreign_bags();
    let path = folder.path().join("file_9/file_9.mcap.zstd");
    let bytes = fs::read(&path).unwrap();
    let cut = folder.path().join("cut.mcap.zstd");
    fs::write(&cut, &bytes[..bytes.len() - 10]).unwrap();

    let outcome = recover_into(&cut, &folder.path().join("saved"), None);

    match outcome {
        Ok(recovered) => assert!(!recovered.losses.is_empty()),
        // All of it is one block, which does not unpack without its end.
        Err(error) => assert!(matches!(error, BagError::Empty { .. }), "{error}"),
    }
    let left: Vec<_> =
        fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(left.iter().all(|path| !path.to_string_lossy().ends_with(".part")), "{left:?}");
}

#[test]
fn bags_in_sqlite_are_refused_with_the_line_that_converts_them() {
    let folder = foreign_bags();
    let path = folder.path().join("sqlite");
    let database = fs::read_dir(&path)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .find(|path| path.extension().is_some_and(|extension| extension == "db3"))
        .unwrap();

    let with_contents = Bag::open(&path).unwrap_err();
    let of_file = Bag::open(&database).unwrap_err();
    fs::remove_file(path.join("metadata.yaml")).unwrap();
    let without_contents = Bag::open(&path).unwrap_err();

    for error in [with_contents, of_file, without_contents] {
        assert!(matches!(error, BagError::Sqlite { .. }), "{error}");
        assert!(error.help().unwrap().contains("ros2 bag convert -i BAG -o convert.yaml"));
    }
}

/// What `rosbags` and `mcap` count in a bag, checksums and table of contents compared on the way.
fn counted_by_others(folder: &Path) -> Vec<u64> {
    let python = python::python_with(&python::BAGS);
    let script = "
import json, sys
from pathlib import Path
from mcap.reader import make_reader, NonSeekingReader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
folder = Path(sys.argv[1])
file = next(folder.glob('*.mcap'))
counts = []
for path in (folder, file):
    with AnyReader([path]) as reader:
        counts.append(sum(1 for c, _, data in reader.messages() if reader.deserialize(data, c.msgtype)))
with file.open('rb') as stream:
    reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
    counts.append(sum(1 for _ in reader.iter_decoded_messages()))
    summary = reader.get_summary()
    counts.append(summary.statistics.message_count)
    counts.append(sum(summary.statistics.channel_message_counts.values()))
    assert len(summary.chunk_indexes) == summary.statistics.chunk_count
    assert [item.name for item in reader.iter_attachments()] == ['experiment.json']
    assert 'rsrs.recovered' in [item.name for item in reader.iter_metadata()]
with file.open('rb') as stream:
    reader = NonSeekingReader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
    counts.append(sum(1 for _ in reader.iter_decoded_messages()))
print(json.dumps(counts))
";
    let printed = python::must_run(Command::new(python).args(["-c", script]).arg(folder));
    serde_json::from_str(&printed).expect("the script answers in JSON")
}

#[test]
fn what_was_recovered_is_a_bag_for_others_too() {
    let folder = tempfile::tempdir().unwrap();
    for compression in [Compression::None, Compression::Zstd, Compression::Lz4] {
        let path = bag_of(&folder.path().join(format!("{compression:?}")), compression, 40);
        let mut bytes = fs::read(file_of(&path)).unwrap();
        // One chunk is lost, the rest of them is copied, the last one goes message by message.
        let of_chunks = chunks(&bytes);
        bytes[of_chunks[2].1 - 20] ^= 0x10;
        bytes.truncate(of_chunks[4].1 - 5);
        let damaged = path.with_extension("damaged.mcap");
        fs::write(&damaged, bytes).unwrap();
        let into = path.with_extension("saved");

        let recovered = recover_into(&damaged, &into, None).unwrap();

        assert!(recovered.n_messages > 50, "{compression:?}");
        let counts = counted_by_others(&into);
        assert!(counts.iter().all(|n| *n == recovered.n_messages), "{compression:?}: {counts:?}");
    }
}
