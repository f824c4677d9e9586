//! Keys of other members, out of the memory of a program that has received them.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::os::unix::fs::FileExt;

/// With which a member signs or encrypts (DDS Security 1.1, 9.5.2.1.1).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StolenKey {
    pub kind: [u8; 4],
    pub salt: [u8; 32],
    pub id: [u8; 4],
    pub key: [u8; 32],
}

/// All keys that this process has received: of each participant, by the first 12 bytes of its GUID, and of
/// each publisher, by its GUID.
#[derive(Debug, Default)]
pub struct StolenKeys {
    pub of_participants: BTreeMap<[u8; 12], StolenKey>,
    pub of_writers: BTreeMap<[u8; 16], StolenKey>,
}

/// What messages that carry keys are called in them.
const OF_PARTICIPANT: &[u8] = b"dds.sec.participant_crypto_tokens\0";
const OF_WRITER: &[u8] = b"dds.sec.datawriter_crypto_tokens\0";
/// Such a message begins so many bytes before its name, with the GUID of the participant, and has that of
/// the publisher right before the length of its name (7.4.3.4).
const START: usize = 100;
const WRITER: usize = 20;
/// The key comes within so many bytes of the name.
const KEY_WITHIN: usize = 300;

/// Looks through the memory of this process.
pub fn in_own_memory() -> StolenKeys {
    let mut maps = String::new();
    File::open("/proc/self/maps")
        .and_then(|mut file| file.read_to_string(&mut maps))
        .expect("Linux");
    let memory = File::open("/proc/self/mem").expect("a process reads its own memory");
    let mut found = StolenKeys::default();
    for line in maps.lines().filter(|line| line.contains(" rw-p ")) {
        let (range, _) = line.split_once(' ').expect("a line of maps");
        let (start, end) = range.split_once('-').expect("a range");
        let address = |text| u64::from_str_radix(text, 16).expect("an address");
        let length = usize::try_from(address(end) - address(start)).expect("it is in memory");
        let mut bytes = vec![0; length];
        // Some of what is mapped is not there.
        if memory.read_exact_at(&mut bytes, address(start)).is_ok() {
            found.add(&bytes);
        }
    }
    found
}

impl StolenKeys {
    fn add(&mut self, memory: &[u8]) {
        for at in places_of(b"dds.sec.", memory) {
            if at < START {
                continue;
            }
            let rest = &memory[at..];
            let within = &rest[..rest.len().min(KEY_WITHIN)];
            if rest.starts_with(OF_PARTICIPANT) {
                let Some(key) = key_in(within) else { continue };
                let guid: &[u8; 12] = memory[at - START..].first_chunk().expect("it is before");
                self.of_participants.insert(*guid, key);
            } else if rest.starts_with(OF_WRITER) {
                let Some(key) = key_in(within) else { continue };
                let guid: &[u8; 16] = memory[at - WRITER..].first_chunk().expect("it is before");
                self.of_writers.insert(*guid, key);
            }
        }
    }
}

/// Where a text begins.
fn places_of<'a>(text: &'a [u8], memory: &'a [u8]) -> impl Iterator<Item = usize> + 'a {
    memory.windows(text.len()).enumerate().filter(move |(_, bytes)| *bytes == text).map(|it| it.0)
}

/// The first key of 256 bits: its kind, salt, identity, and the key itself.
fn key_in(bytes: &[u8]) -> Option<StolenKey> {
    const LENGTH: [u8; 4] = [0, 0, 0, 32];
    bytes.windows(80).find_map(|bytes| {
        let is_key = bytes[..3] == [0; 3]
            && matches!(bytes[3], 3 | 4)
            && bytes[4..8] == LENGTH
            && bytes[44..48] == LENGTH;
        is_key.then(|| StolenKey {
            kind: *bytes[..4].first_chunk().expect("80 bytes"),
            salt: *bytes[8..].first_chunk().expect("80 bytes"),
            id: *bytes[40..].first_chunk().expect("80 bytes"),
            key: *bytes[48..].first_chunk().expect("80 bytes"),
        })
    })
}
