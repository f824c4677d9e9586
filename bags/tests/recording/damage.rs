//! Bags that a test spoils, and what is saved of them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use rsrs_bags::{
    Bag, BagError, BagMessage, BagOptions, BagWriter, Compression, Packing, Recovered, recover_into,
};

use super::Recording;

/// A folder of a test's own, in memory where there is such a place: each bag that is closed waits for
/// the disk.
pub fn temporary() -> tempfile::TempDir {
    let in_memory = Path::new("/dev/shm");
    let made =
        if in_memory.is_dir() { tempfile::tempdir_in(in_memory) } else { tempfile::tempdir() };
    made.expect("there is room for a temporary folder")
}

/// All messages of a bag that is whole.
pub fn messages(path: &Path) -> Vec<BagMessage> {
    let bag = Bag::open(path).expect("it opens");
    bag.messages().collect::<Result<_, _>>().expect("the bag is whole")
}

/// A bag with an attachment and a metadata record, flushed after each second.
pub fn bag_of(folder: &Path, compression: Compression, n_steps: u64) -> PathBuf {
    let path = folder.join("run");
    let packing = Packing { compression, ..Packing::default() };
    let writer = BagWriter::create_packed(&path, BagOptions::default(), packing).expect("new");
    let mut recording = Recording::with(writer, &["robot_1", "robot_2"]);
    recording.writer.attach("experiment.json", "application/json", b"{}").expect("room");
    let pairs = BTreeMap::from([("seed".to_owned(), "42".to_owned())]);
    recording.writer.metadata("lab.note", pairs).expect("room");
    (0..n_steps).for_each(|step| recording.step(step));
    recording.writer.finish().expect("room");
    path
}

/// The only file of a bag.
pub fn file_of(bag: &Path) -> PathBuf {
    bag.join("run_0.mcap")
}

/// Writes these bytes as a file and recovers it.
pub fn recover_bytes(
    folder: &Path,
    bytes: &[u8],
) -> Result<(Recovered, Vec<BagMessage>), BagError> {
    let path = folder.join("damaged.mcap");
    let into = folder.join("saved");
    fs::write(&path, bytes).expect("room");
    if into.exists() {
        fs::remove_dir_all(&into).expect("it is ours");
    }
    let recovered = recover_into(&path, &into, None)?;
    let saved = messages(&into);
    assert_eq!(recovered.n_messages, saved.len() as u64);
    Ok((recovered, saved))
}

/// Where records start in a sound file, with their opcodes.
pub fn records(bytes: &[u8]) -> Vec<(usize, u8, usize)> {
    let mut at = mcap::MAGIC.len();
    let mut found = Vec::new();
    while at + 9 <= bytes.len() && !bytes[at..].starts_with(mcap::MAGIC) {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().expect("eight bytes"));
        let end = at + 9 + usize::try_from(length).expect("it is in memory");
        found.push((at, bytes[at], end));
        at = end;
    }
    found
}

const CHUNK: u8 = 6;

/// Where chunks start and end in a sound file.
pub fn chunks(bytes: &[u8]) -> Vec<(usize, usize)> {
    let of_chunks = records(bytes).into_iter().filter(|record| record.1 == CHUNK);
    of_chunks.map(|(start, _, end)| (start, end)).collect()
}

/// Messages that the beginning of a file holds in whole chunks.
pub fn n_flushed(bytes: &[u8], n_bytes: usize) -> usize {
    const MESSAGE_INDEX: u8 = 7;
    let mut n_messages = 0;
    let mut complete = false;
    for (start, opcode, end) in records(bytes) {
        match opcode {
            CHUNK => complete = end <= n_bytes,
            MESSAGE_INDEX if complete => n_messages += (end - start - 9 - 6) / 16,
            _ => {}
        }
    }
    n_messages
}
