//! What can be saved of bags in every state of disrepair, and that what was lost is reported.

use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;

use mcap::WriteOptions;
use mcap::records::MessageHeader;
use rsrs_bags::{
    Bag, BagError, BagOptions, BagWriter, Compression, LossKind, Packing, Sample, recover,
    recover_into,
};
use rsrs_msgs::cdr;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::Qos;

use crate::recording;
use crate::recording::Recording;
use crate::recording::damage::{
    bag_of, chunks, file_of, messages, records, recover_bytes, temporary,
};

#[test]
fn a_whole_bag_is_copied_and_nothing_is_lost() {
    let folder = temporary();
    let path = bag_of(folder.path(), Compression::Zstd, 40);

    let recovered = recover(&path).unwrap();

    assert_eq!(recovered.folder, folder.path().join("run_recovered"));
    assert!(recovered.is_complete(), "{recovered:?}");
    assert_eq!((recovered.n_attachments, recovered.n_metadata), (1, 1));
    assert_eq!(messages(&recovered.folder), messages(&path));
    let (old, new) = (Bag::open(&path).unwrap(), Bag::open(&recovered.folder).unwrap());
    assert_eq!(new.topics(), old.topics());
    assert_eq!(new.attachment("experiment.json"), old.attachment("experiment.json"));
    assert_eq!(new.metadata("lab.note"), old.metadata("lab.note"));
}

#[test]
fn a_chunk_that_fails_its_checksum_is_lost_and_counted_and_all_others_are_saved() {
    let folder = temporary();
    for compression in [Compression::None, Compression::Zstd, Compression::Lz4] {
        let path = bag_of(&folder.path().join(format!("{compression:?}")), compression, 40);
        let mut bytes = fs::read(file_of(&path)).unwrap();
        let (start, end) = chunks(&bytes)[2];
        bytes[end - 20] ^= 0x10;

        let (recovered, saved) = recover_bytes(folder.path(), &bytes).unwrap();

        let whole = messages(&path);
        let n_lost = whole.len() - saved.len();
        assert!((1..=60).contains(&n_lost), "{compression:?}: {n_lost}");
        assert!(saved.iter().all(|message| whole.contains(message)));
        assert_eq!(recovered.losses.len(), 1, "{:?}", recovered.losses);
        let loss = &recovered.losses[0];
        assert_eq!((loss.kind, loss.at_byte), (LossKind::Chunk, start as u64));
        assert_eq!((loss.n_bytes, loss.n_messages), ((end - start) as u64, Some(n_lost as u64)));
        assert!(recovered.lost.is_exact);
        assert_eq!(recovered.lost.total(), n_lost as u64);
        let lost_times = loss.bounds_ns.unwrap();
        assert!(
            saved
                .iter()
                .all(|message| { !(lost_times.0..=lost_times.1).contains(&message.log_time_ns) })
        );
    }
}

#[test]
fn an_index_whose_first_byte_changed_is_not_taken_for_a_message() {
    const MESSAGE: u8 = 5;
    const MESSAGE_INDEX: u8 = 7;
    let folder = temporary();
    let path = bag_of(folder.path(), Compression::Zstd, 20);
    let whole = messages(&path);
    let bytes = fs::read(file_of(&path)).unwrap();
    let indexes = records(&bytes).into_iter().filter(|record| record.1 == MESSAGE_INDEX);
    for (start, _, _) in indexes {
        let mut damaged = bytes.clone();
        damaged[start] = MESSAGE;

        let (recovered, saved) = recover_bytes(folder.path(), &damaged).unwrap();

        assert!(saved == whole, "the index at byte {start}");
        assert_eq!((recovered.losses[0].at_byte, recovered.lost.total()), (start as u64, 0));
    }
}

#[test]
fn recording_goes_on_behind_garbage() {
    let folder = temporary();
    let path = bag_of(folder.path(), Compression::Zstd, 60);
    let whole = messages(&path);
    let mut bytes = fs::read(file_of(&path)).unwrap();
    let (start, end) = chunks(&bytes)[3];
    bytes[start..end].fill(0xaa);

    let (recovered, saved) = recover_bytes(folder.path(), &bytes).unwrap();

    let loss = &recovered.losses[0];
    assert_eq!((loss.kind, loss.at_byte), (LossKind::Garbage, start as u64));
    assert_eq!(loss.n_bytes, (end - start) as u64);
    assert_eq!(loss.n_messages, Some((whole.len() - saved.len()) as u64));
    assert_eq!(saved.last(), whole.last());
    assert_eq!(saved.first(), whole.first());
}

#[test]
fn bytes_inserted_between_records_cost_nothing() {
    let folder = temporary();
    let path = bag_of(folder.path(), Compression::Zstd, 30);
    let mut bytes = fs::read(file_of(&path)).unwrap();
    let (start, _) = chunks(&bytes)[1];
    bytes.splice(start..start, [0x55; 1000]);

    let (recovered, saved) = recover_bytes(folder.path(), &bytes).unwrap();

    assert_eq!(saved, messages(&path));
    assert_eq!((recovered.losses[0].at_byte, recovered.losses[0].n_bytes), (start as u64, 1000));
}

#[test]
fn definitions_that_went_down_with_the_first_chunk_are_taken_from_the_end_of_the_file() {
    let folder = temporary();
    let path = bag_of(folder.path(), Compression::Zstd, 40);
    let whole = messages(&path);
    let mut bytes = fs::read(file_of(&path)).unwrap();
    let (start, end) = chunks(&bytes)[0];
    bytes[start..end].fill(0xff);
    let without_end = bytes[..bytes.len() - 1].to_vec();

    let (recovered, saved) = recover_bytes(folder.path(), &bytes).unwrap();
    let (homeless, _) = match recover_bytes(folder.path(), &without_end) {
        Ok(saved) => saved,
        Err(error) => panic!("{error}"),
    };

    assert!(saved.len() > whole.len() / 2);
    assert_eq!(recovered.lost.total(), (whole.len() - saved.len()) as u64);
    // Without them messages are counted, and not guessed at.
    assert_eq!(homeless.n_messages, 0);
    assert!(homeless.losses.iter().any(|loss| loss.kind == LossKind::Messages));
}

#[test]
fn the_beginning_of_a_chunk_without_its_end_is_saved() {
    let folder = temporary();
    let path = bag_of(folder.path(), Compression::None, 20);
    let whole = messages(&path);
    let bytes = fs::read(file_of(&path)).unwrap();
    let (start, end) = chunks(&bytes)[1];
    let half = usize::midpoint(start, end);

    let (cut, saved) = recover_bytes(folder.path(), &bytes[..half]).unwrap();
    let zeros = [&bytes[..half], &vec![0; 5000]].concat();
    let (lost_power, saved_of_zeros) = recover_bytes(folder.path(), &zeros).unwrap();

    // The first chunk has definitions only.
    assert!(saved.len() > 10, "{} messages", saved.len());
    assert_eq!(saved, whole[..saved.len()]);
    assert_eq!(cut.losses[0].kind, LossKind::EndOfChunk);
    // Where data ends and zeros begin, the last message may be half zeros, and is not believed.
    assert!(saved.len() - saved_of_zeros.len() <= 1);
    assert_eq!(saved_of_zeros, whole[..saved_of_zeros.len()]);
    assert_eq!(lost_power.losses[0].kind, LossKind::EndOfChunk);
}

#[test]
fn the_beginning_of_a_large_compressed_chunk_is_saved_too() {
    let folder = temporary();
    for compression in [Compression::Zstd, Compression::Lz4] {
        let path = folder.path().join(format!("{compression:?}/run"));
        let packing = Packing { compression, flush_period_ns: None, ..Packing::default() };
        let mut writer = BagWriter::create_packed(&path, BagOptions::default(), packing).unwrap();
        let channel = writer.add_topic("/a", "std_msgs/msg/Bool", Qos::reliable(1)).unwrap();
        for log_time_ns in 0..20_000_u64 {
            let data = cdr::encode(&Bool { data: log_time_ns % 3 == 0 });
            let publish_time_ns = log_time_ns.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let sample = Sample { log_time_ns, publish_time_ns, sequence: 0, data: &data };
            writer.write(channel, sample).unwrap();
        }
        writer.finish().unwrap();
        let whole = messages(&path);
        let bytes = fs::read(file_of(&path)).unwrap();
        let (start, end) = chunks(&bytes)[0];

        let cut = &bytes[..start + (end - start) / 2];
        let (recovered, saved) = recover_bytes(folder.path(), cut).unwrap();

        assert!(saved.len() > whole.len() / 5, "{compression:?}: {}", saved.len());
        assert_eq!(saved, whole[..saved.len()]);
        assert_eq!(recovered.losses[0].kind, LossKind::EndOfChunk);
    }
}

/// A file without chunks, with so many messages.
fn loose(n_messages: u64) -> Vec<u8> {
    recording::foreign(WriteOptions::new().profile("ros2").use_chunks(false), 0..n_messages)
}

#[test]
fn files_without_chunks_are_saved_message_by_message() {
    let folder = temporary();
    let path = folder.path().join("loose.mcap");
    fs::write(&path, loose(50)).unwrap();
    let whole = messages(&path);
    let bytes = fs::read(&path).unwrap();
    let of_messages: Vec<_> = records(&bytes).into_iter().filter(|record| record.1 == 5).collect();
    let mut with_hole = bytes.clone();
    let (start, _, end) = of_messages[20];
    with_hole[start..end].fill(0xee);
    let mut with_length = bytes.clone();
    with_length[of_messages[30].0 + 1] ^= 0x40;

    let (_, saved) = recover_bytes(folder.path(), &with_hole).unwrap();
    let (_, around) = recover_bytes(folder.path(), &with_length).unwrap();
    let (_, cut) = recover_bytes(folder.path(), &bytes[..of_messages[40].2 - 1]).unwrap();

    let without = |index: usize| [&whole[..index], &whole[index + 1..]].concat();
    assert_eq!(saved, without(20));
    assert_eq!(around, without(30));
    assert_eq!(cut, whole[..40]);
}

#[test]
fn a_message_of_a_wrong_length_costs_itself_alone_though_it_begins_as_a_chunk_does() {
    let folder = temporary();
    let mut file = Cursor::new(Vec::new());
    let options = WriteOptions::new().profile("ros2").use_chunks(false);
    let mut writer = options.create(&mut file).unwrap();
    let schema = writer.add_schema("a/msg/B", "ros2msg", b"uint8[14] c").unwrap();
    let channel_id = writer.add_channel(schema, "/a", "cdr", &BTreeMap::new()).unwrap();
    // Where a chunk has the name of its compression are zeros, and numbers where it has its lengths.
    let data = [&[0, 1, 0, 0][..], &[0; 6], &[1; 8]].concat();
    for log_time in 0..50 {
        let header = MessageHeader { channel_id, sequence: 0, log_time, publish_time: 1 << 60 };
        writer.write_to_known_channel(&header, &data).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    let mut bytes = file.into_inner();
    let (start, ..) = records(&bytes).into_iter().filter(|record| record.1 == 5).nth(20).unwrap();
    bytes[start + 1] ^= 0x40;

    let (_, saved) = recover_bytes(folder.path(), &bytes).unwrap();

    let log_times: Vec<u64> = saved.iter().map(|message| message.log_time_ns).collect();
    assert_eq!(log_times, [(0..20).collect(), (21..50).collect::<Vec<_>>()].concat());
}

#[test]
fn silent_changes_outside_of_chunks_are_found_by_the_checksum_over_all() {
    let folder = temporary();
    let path = folder.path().join("loose.mcap");
    fs::write(&path, loose(10)).unwrap();
    let mut bytes = fs::read(&path).unwrap();
    let last = records(&bytes).into_iter().rfind(|record| record.1 == 5).unwrap();
    bytes[last.2 - 1] ^= 1;

    let (recovered, saved) = recover_bytes(folder.path(), &bytes).unwrap();

    assert_eq!(saved.len(), 10);
    assert_eq!(recovered.losses[0].kind, LossKind::Unlocated);
    assert!(!recovered.is_complete());
}

#[test]
fn a_file_that_is_missing_or_spoilt_does_not_take_the_others_with_it() {
    let folder = temporary();
    let path = folder.path().join("run");
    let packing = Packing { max_file_duration_ns: Some(1_000_000_000), ..Packing::default() };
    let writer = BagWriter::create_packed(&path, BagOptions::default(), packing).unwrap();
    let mut recording = Recording::with(writer, &["robot_1"]);
    (0..40).for_each(|step| recording.step(step));
    let summary = recording.writer.finish().unwrap();
    let whole = messages(&path);
    fs::remove_file(&summary.files[1]).unwrap();
    fs::write(&summary.files[3], b"not a bag at all, not even nearly").unwrap();

    let recovered = recover(&path).unwrap();

    let kinds: Vec<LossKind> = recovered.losses.iter().map(|loss| loss.kind).collect();
    assert_eq!(kinds, [LossKind::File, LossKind::File]);
    assert!(recovered.n_messages > 0);
    // The summary section states how many there were.
    assert!(recovered.lost.is_exact);
    assert_eq!(recovered.lost.total() + recovered.n_messages, whole.len() as u64);
}

#[test]
fn what_cannot_be_saved_is_refused_by_name() {
    let folder = temporary();
    let refused = |bytes: &[u8]| recover_bytes(folder.path(), bytes).unwrap_err();

    assert!(matches!(refused(b""), BagError::Empty { .. }));
    assert!(matches!(refused(b"a text that is not a bag"), BagError::NotMcap { .. }));
    assert!(matches!(refused(b"SQLite format 3\0 and more"), BagError::NotMcap { .. }));
    assert!(matches!(refused(mcap::MAGIC), BagError::NotMcap { .. }));
    fs::create_dir(folder.path().join("there")).unwrap();
    let damaged = folder.path().join("damaged.mcap");
    let into = recover_into(&damaged, &folder.path().join("there"), None);
    assert!(matches!(into, Err(BagError::Exists { .. })));
}
