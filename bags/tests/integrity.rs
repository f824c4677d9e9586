//! Bags with other bytes than were written are distinguished from whole ones, whoever wrote them.

use std::fs;
use std::path::Path;

use mcap::WriteOptions;
use rsrs_bags::{Bag, BagMessage, Compression, recover_into};

use crate::recording::damage::{bag_of, file_of, messages, records, temporary};
use crate::recording::foreign;

/// What a bag with these bytes gives: `None` if it is reported as damaged, or as no bag.
fn read(folder: &Path, bytes: &[u8]) -> Option<Vec<BagMessage>> {
    let path = folder.join("changed.mcap");
    fs::write(&path, bytes).expect("room");
    let bag = Bag::open(&path).ok()?;
    if !bag.damage().is_empty() {
        return None;
    }
    Some(bag.messages().collect::<Result<_, _>>().expect("it was reported as whole"))
}

#[test]
fn a_flipped_bit_anywhere_is_found_or_changes_no_message() {
    let folder = temporary();
    for compression in [Compression::None, Compression::Zstd, Compression::Lz4] {
        let place = folder.path().join(format!("{compression:?}"));
        fs::create_dir(&place).expect("room");
        let bag = bag_of(&place, compression, 8);
        let whole = messages(&bag);
        let bytes = fs::read(file_of(&bag)).expect("it was just written");
        let mut n_found = 0;

        // Each byte of one file or another: they begin alike.
        for at in (compression as usize..bytes.len()).step_by(5) {
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << (at % 8);
            match read(&place, &flipped) {
                None => n_found += 1,
                Some(read) => assert_eq!(read, whole, "{compression:?}, byte {at}"),
            }
        }

        // Everything but the summary section.
        assert!(n_found > bytes.len() / 15, "{n_found} of {} found", bytes.len());
    }
}

fn options() -> WriteOptions {
    WriteOptions::new().profile("ros2")
}

#[test]
fn files_whose_writers_left_out_checksums_or_chunks_are_whole() {
    let folder = temporary();
    let plain = || {
        let none = options().compression(None).calculate_chunk_crcs(false);
        none.calculate_data_section_crc(false).calculate_summary_section_crc(false)
    };
    for (way, options) in [
        plain(),
        plain().use_chunks(false),
        plain().calculate_chunk_crcs(true),
        plain().use_chunks(false).calculate_data_section_crc(true),
        plain().compression(Some(mcap::Compression::Zstd)),
        plain().emit_summary_records(false).emit_summary_offsets(false),
    ]
    .into_iter()
    .enumerate()
    {
        let read = read(folder.path(), &foreign(options, 0..50));

        assert_eq!(read.map(|read| read.len()), Some(50), "way {way}");
    }
}

#[test]
fn a_changed_chunk_is_found_by_its_own_checksum_and_named_by_its_place() {
    let folder = temporary();
    let options = options().compression(None).calculate_data_section_crc(false);
    let mut bytes = foreign(options, 0..50);
    // The last byte of the last message.
    let message = [0, 1, 0, 0, 1];
    let at = bytes.windows(5).rposition(|bytes| bytes == message).expect("it has messages") + 4;
    bytes[at] ^= 1;
    let path = folder.path().join("changed.mcap");
    fs::write(&path, &bytes).expect("room");

    let damage = Bag::open(&path).expect("it has a header").damage();

    assert_eq!(damage.len(), 1);
    assert!(damage[0].reason.starts_with("Chunk CRC failed"), "{damage:?}");
    assert!(!damage[0].is_end && damage[0].at_byte > 0 && damage[0].at_byte < at as u64);
}

#[test]
fn a_message_that_is_no_message_any_more_is_missed_without_any_checksum() {
    let folder = temporary();
    let options = options().use_chunks(false).calculate_data_section_crc(false);
    let mut bytes = foreign(options.calculate_summary_section_crc(false), 0..50);
    let head = [&[5][..], &27_u64.to_le_bytes()].concat();
    let at = bytes.windows(head.len()).position(|bytes| bytes == head).expect("it has messages");
    // An unknown kind of record is passed over.
    bytes[at] = 0x85;

    assert_eq!(read(folder.path(), &bytes), None);
}

#[test]
fn a_message_behind_the_chunks_is_read_though_no_index_leads_to_it() {
    const STATISTICS: u8 = 0x0b;
    let folder = temporary();
    let options = options().compression(None).calculate_data_section_crc(false);
    let options = options.calculate_summary_section_crc(false).emit_summary_offsets(false);
    let mut bytes = foreign(options, 0..50);
    let found = records(&bytes).into_iter().find(|record| record.1 == STATISTICS);
    let (statistics, ..) = found.expect("it counts its messages");
    // Of all channels, and of the first one.
    for count in [9, 9 + 8 + 2 + 4 * 4 + 2 * 8 + 4 + 2] {
        bytes[statistics + count] += 1;
    }
    let head = [&[5][..], &27_u64.to_le_bytes()].concat();
    let at = bytes.windows(head.len()).position(|bytes| bytes == head).expect("it has messages");
    let message = bytes[at..at + head.len() + 27].to_vec();
    let (start, _, _) = records(&bytes).into_iter().find(|record| record.1 == 15).expect("it ends");
    // The footer: where the summary section starts.
    let footer = bytes.len() - 8 - 20;
    let summary_at = u64::from_le_bytes(bytes[footer..footer + 8].try_into().expect("eight"));
    let moved = summary_at + message.len() as u64;
    bytes[footer..footer + 8].copy_from_slice(&moved.to_le_bytes());
    bytes.splice(start..start, message);

    let read = read(folder.path(), &bytes);

    assert_eq!(read.map(|read| read.len()), Some(51));
}

#[test]
fn a_recovered_bag_states_how_much_it_lacks() {
    let folder = temporary();
    let bag = bag_of(folder.path(), Compression::None, 40);
    let whole = folder.path().join("whole");
    recover_into(&bag, &whole, None).expect("it is a bag");
    let path = file_of(&bag);
    let bytes = fs::read(&path).expect("it was just written");
    fs::write(&path, &bytes[..bytes.len() / 2]).expect("room");
    let cut = folder.path().join("cut");
    let recovered = recover_into(&bag, &cut, None).expect("it is a bag");

    let of_whole = Bag::open(&whole).expect("it is a bag").recovery().expect("it was recovered");
    let of_cut = Bag::open(&cut).expect("it is a bag").recovery().expect("it was recovered");

    assert!(of_whole.is_complete && of_whole.n_messages_lost == 0);
    assert!(!of_cut.is_complete);
    assert_eq!(of_cut.n_messages_lost, recovered.lost.total());
    assert_eq!(of_cut.is_exact, recovered.lost.is_exact);
    assert_eq!(of_cut.losses.len(), recovered.losses.len());
}
