//! Crashes of every kind: files cut at every byte, and files with other bytes than were written.
//!
//! `RSRS_LONG_TESTS=1` damages ten thousand copies of each kind of bag.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use proptest::prelude::*;
use rsrs_bags::{Bag, BagMessage, BagOptions, BagWriter, Compression, Packing, Sample};
use rsrs_msgs::cdr;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::Qos;
use rsrs_testing::environment::or_if_long;

use crate::recording::damage::{
    bag_of, file_of, messages, n_flushed, records, recover_bytes, temporary,
};

const ALL: [Compression; 3] = [Compression::None, Compression::Zstd, Compression::Lz4];

/// Copies that are damaged of each kind of bag, for every change; with all kinds 1,200.
const N_COPIES: u64 = 400;

/// A bag of two topics and 2.5 s, as its messages and its bytes: small enough to be cut everywhere.
fn small_bag(folder: &Path, compression: Compression) -> (Vec<BagMessage>, Vec<u8>) {
    let path = folder.join(format!("{compression:?}/run"));
    let packing = Packing { compression, ..Packing::default() };
    let mut writer =
        BagWriter::create_packed(&path, BagOptions::default(), packing).expect("it is new");
    let mut add = |name| writer.add_topic(name, "std_msgs/msg/Bool", Qos::reliable(1));
    let topics = [add("/a/detection").expect("new"), add("/b/detection").expect("new")];
    for message in 0..50_u32 {
        let topic = topics[message as usize % 2];
        let data = cdr::encode(&Bool { data: message.is_multiple_of(3) });
        let log_time_ns = u64::from(message) * 50_000_000;
        let sample = Sample { log_time_ns, publish_time_ns: 7, sequence: message, data: &data };
        writer.write(topic, sample).expect("room");
    }
    writer.finish().expect("room");
    (messages(&path), fs::read(file_of(&path)).expect("it was just written"))
}

/// Messages whose last byte is within the beginning of a file whose chunks are not compressed.
fn n_complete(bytes: &[u8], n_bytes: usize) -> usize {
    const CHUNK: u8 = 6;
    const MESSAGE: u8 = 5;
    // Record head, times, size, checksum, empty name of a compression, size.
    const CHUNK_HEAD: usize = 9 + 8 + 8 + 8 + 4 + 4 + 8;
    let mut n_messages = 0;
    for (start, _, chunk_end) in records(bytes).into_iter().filter(|record| record.1 == CHUNK) {
        let mut at = start + CHUNK_HEAD;
        while at < chunk_end {
            let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("eight bytes"));
            let end = at + 9 + usize::try_from(length).expect("it is in memory");
            n_messages += usize::from(bytes[at] == MESSAGE && end <= n_bytes);
            at = end;
        }
    }
    n_messages
}

#[test]
fn a_clock_that_is_set_back_keeps_nothing_from_the_disk_for_long() {
    let folder = temporary();
    let path = folder.path().join("run");
    let mut writer = BagWriter::create(&path, BagOptions::default()).expect("it is new");
    let topic = writer.add_topic("/a/detection", "std_msgs/msg/Bool", Qos::reliable(1));
    let topic = topic.expect("new");
    let data = cdr::encode(&Bool { data: true });

    for step in 0..100_u32 {
        let hours = if step < 50 { 2 } else { 1 };
        let log_time_ns = hours * 3_600_000_000_000 + u64::from(step) * 100_000_000;
        let sample = Sample { log_time_ns, publish_time_ns: 7, sequence: step, data: &data };
        writer.write(topic, sample).expect("room");
    }
    let n_safe = Bag::open(&path).expect("it can be read as far as it is").n_messages();

    assert!(n_safe >= 89, "{n_safe} of 100 would survive");
}

#[test]
fn a_bag_cut_at_any_byte_keeps_all_that_was_flushed() {
    let folder = temporary();
    for compression in ALL {
        let (whole, bytes) = small_bag(folder.path(), compression);
        // Chunks of lz4 and zstd are read by the same code.
        let stride = if compression == Compression::Lz4 { 5 } else { 1 };

        for n_bytes in (0..bytes.len()).step_by(stride) {
            let expected = match compression {
                Compression::None => n_complete(&bytes, n_bytes),
                _ => n_flushed(&bytes, n_bytes),
            };
            match recover_bytes(folder.path(), &bytes[..n_bytes]) {
                Ok((recovered, saved)) => {
                    assert!(saved.len() >= expected, "{compression:?}, {n_bytes}: {}", saved.len());
                    assert_eq!(saved, whole[..saved.len()], "{compression:?}, {n_bytes} bytes");
                    assert!(!recovered.losses.is_empty(), "{compression:?}, {n_bytes} bytes");
                    assert!(!recovered.is_complete() || saved == whole, "{n_bytes} bytes");
                }
                Err(error) => assert_eq!(expected, 0, "{compression:?}, {n_bytes}: {error}"),
            }
        }
    }
}

#[test]
fn a_bag_whose_end_was_never_written_by_a_failing_disk_keeps_what_came_before() {
    let folder = temporary();
    for compression in ALL {
        let (whole, bytes) = small_bag(folder.path(), compression);

        for n_bytes in (0..bytes.len() - 64).step_by(11) {
            let mut with_zeros = bytes.clone();
            with_zeros[n_bytes..].fill(0);
            let n_before = n_flushed(&bytes, n_bytes);
            match recover_bytes(folder.path(), &with_zeros) {
                Ok((recovered, saved)) => {
                    assert!(saved.len() >= n_before, "{compression:?}, {n_bytes} bytes");
                    assert_eq!(saved, whole[..saved.len()], "{compression:?}, {n_bytes} bytes");
                    assert!(!recovered.losses.is_empty(), "{compression:?}, {n_bytes} bytes");
                }
                Err(error) => assert_eq!(n_before, 0, "{compression:?}, {n_bytes}: {error}"),
            }
        }
    }
}

/// The next of a row of numbers without pattern (splitmix64).
fn next(state: &mut u64) -> usize {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut mixed = *state;
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    usize::try_from((mixed ^ (mixed >> 31)) >> 1).expect("63 bits")
}

/// Whether all of the first are among the second, in the same order.
fn is_among(saved: &[BagMessage], whole: &[BagMessage]) -> bool {
    let mut rest = whole.iter();
    saved.iter().all(|message| rest.any(|other| other == message))
}

/// A copy with changes at one place or a few, of one byte or a burst, and these places.
fn damaged(bytes: &[u8], copy: u64) -> (Vec<u8>, Vec<usize>) {
    let mut state = copy;
    let mut damaged = bytes.to_vec();
    let places: Vec<usize> =
        (0..=next(&mut state) % 3).map(|_| next(&mut state) % bytes.len()).collect();
    for place in &places {
        let burst = if next(&mut state).is_multiple_of(4) { 16 } else { 1 };
        for byte in damaged.iter_mut().skip(*place).take(burst) {
            *byte ^= u8::try_from(next(&mut state) % 255 + 1).expect("at most 255");
        }
    }
    (damaged, places)
}

#[test]
fn what_the_reader_reads_of_a_damaged_bag_is_saved_of_it() {
    let folder = temporary();
    let path = folder.path().join("read.mcap");
    for compression in ALL {
        let (whole, bytes) = small_bag(folder.path(), compression);
        for copy in 0..or_if_long(N_COPIES, 10_000) / 4 {
            let (damaged, places) = damaged(&bytes, copy);
            fs::write(&path, &damaged).expect("room");
            let Ok(bag) = Bag::open(&path) else { continue };
            // An index whose first byte has changed reads as a message.
            let read: Vec<BagMessage> = bag
                .messages()
                .map_while(Result::ok)
                .filter(|message| whole.contains(message))
                .collect();

            let saved = recover_bytes(folder.path(), &damaged).map(|(_, saved)| saved);

            let saved = saved.unwrap_or_default();
            assert!(is_among(&read, &saved), "{compression:?}, copy {copy}, bytes at {places:?}");
        }
    }
}

#[test]
fn whatever_bytes_change_nothing_is_invented_and_what_came_before_them_is_saved() {
    let folder = temporary();
    let n_copies = or_if_long(N_COPIES, 10_000);
    for compression in ALL {
        let (whole, bytes) = small_bag(folder.path(), compression);
        for copy in 0..n_copies {
            let (damaged, places) = damaged(&bytes, copy);
            let first = places.iter().copied().min().expect("there is at least one");
            let n_before = n_flushed(&bytes, first);

            let what = format!("{compression:?}, copy {copy}, bytes at {places:?}");
            match recover_bytes(folder.path(), &damaged) {
                Ok((recovered, saved)) => {
                    assert!(is_among(&saved, &whole), "{what}");
                    assert!(saved.len() >= n_before, "{what}: {} of {n_before}", saved.len());
                    assert!(!recovered.is_complete() || saved == whole, "{what}: {recovered:?}");
                    assert!(saved == whole || !recovered.losses.is_empty(), "{what}");
                }
                Err(error) => assert_eq!(n_before, 0, "{what}: {error}"),
            }
        }
    }
}

/// A small bag, made once: its messages and its bytes.
static WHOLE: LazyLock<(Vec<BagMessage>, Vec<u8>)> = LazyLock::new(|| {
    let folder = temporary();
    let path = bag_of(folder.path(), Compression::Zstd, 18);
    (messages(&path), fs::read(file_of(&path)).expect("it was just written"))
});

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn a_changed_byte_never_panics_and_costs_at_most_one_chunk(
        at in any::<prop::sample::Index>(),
        mask in 1_u8..,
    ) {
        let folder = temporary();
        let (whole, mut bytes) = (&WHOLE.0, WHOLE.1.clone());
        let at = at.index(bytes.len());
        bytes[at] ^= mask;
        let n_before = n_flushed(&WHOLE.1, at);

        if let Ok((recovered, saved)) = recover_bytes(folder.path(), &bytes) {
            prop_assert!(saved.len() >= n_before.min(whole.len()));
            prop_assert!(saved.iter().all(|message| whole.contains(message)), "byte {}", at);
            prop_assert!(recovered.is_complete() || !recovered.losses.is_empty());
            prop_assert!(!recovered.is_complete() || saved == *whole, "byte {}", at);
            prop_assert_eq!(recovered.lost.total(), (whole.len() - saved.len()) as u64);
        } else {
            prop_assert!(n_before == 0);
        }
    }
}
