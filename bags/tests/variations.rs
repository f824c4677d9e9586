//! Every way in which the MCAP specification lets a writer lay out an intact file, through what `bag
//! info` and `bag recover` stand on.
//!
//! The combinations are those of the conformance suite of foxglove/mcap (chunks or none; index, summary
//! and repeated records each there or not; more bytes behind the fields of records), generated here.

use std::fs;
use std::path::Path;

use rsrs_bags::{Bag, BagMessage, recover_into};

use crate::recording::damage::temporary;

const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;

/// What a writer may leave out, or put in.
#[derive(Clone, Copy, Debug)]
struct Way(u16);

impl Way {
    const N: u16 = 1 << 10;

    fn has(self, bit: u16) -> bool {
        self.0 & (1 << bit) != 0
    }

    fn chunks(self) -> bool {
        self.has(0)
    }

    fn message_index(self) -> bool {
        self.has(1)
    }

    fn chunk_index(self) -> bool {
        self.has(2)
    }

    fn statistics(self) -> bool {
        self.has(3)
    }

    fn repeated_schemas(self) -> bool {
        self.has(4)
    }

    fn repeated_channels(self) -> bool {
        self.has(5)
    }

    fn attachment_index(self) -> bool {
        self.has(6)
    }

    fn metadata_index(self) -> bool {
        self.has(7)
    }

    fn summary_offsets(self) -> bool {
        self.has(8)
    }

    fn padding(self) -> bool {
        self.has(9)
    }

    /// All that make sense: without chunks there is nothing to index.
    fn all() -> impl Iterator<Item = Self> {
        let makes_sense = |way: &Self| way.chunks() || !(way.message_index() || way.chunk_index());
        (0..Self::N).map(Self).filter(makes_sense)
    }
}

/// What is in a file.
#[derive(Clone, Copy, Debug)]
struct Content {
    n_messages: u64,
    n_besides: usize,
}

fn text(text: &str) -> Vec<u8> {
    let length = u32::try_from(text.len()).expect("it is short");
    [&length.to_le_bytes()[..], text.as_bytes()].concat()
}

fn pairs(pairs: &[(&str, &str)]) -> Vec<u8> {
    let all: Vec<u8> =
        pairs.iter().flat_map(|(key, value)| [text(key), text(value)].concat()).collect();
    list(&all)
}

/// Bytes behind their length in 4.
fn list(bytes: &[u8]) -> Vec<u8> {
    let length = u32::try_from(bytes.len()).expect("it is short");
    [&length.to_le_bytes()[..], bytes].concat()
}

fn u64s(numbers: &[u64]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// A file that is being written.
struct File {
    way: Way,
    bytes: Vec<u8>,
}

impl File {
    fn record(&self, opcode: u8, fields: &[Vec<u8>]) -> Vec<u8> {
        let mut body = fields.concat();
        // A message ends with its data, and a footer is looked for at the end.
        if self.way.padding() && ![0x02, 0x05].contains(&opcode) {
            body.extend([0x01, 0xff, 0xff]);
        }
        [vec![opcode], u64s(&[body.len() as u64]), body].concat()
    }

    /// Writes a record, and returns where it starts and how long it is.
    fn put(&mut self, opcode: u8, fields: &[Vec<u8>]) -> (u64, u64) {
        let record = self.record(opcode, fields);
        let start = self.bytes.len() as u64;
        self.bytes.extend(&record);
        (start, record.len() as u64)
    }

    fn definitions(&self, kinds: &[u8]) -> Vec<Vec<u8>> {
        let one = 1_u16.to_le_bytes().to_vec();
        let schema = [one.clone(), text("std_msgs/msg/Bool"), text("ros2msg"), list(b"bool data")];
        let channel = [one.clone(), one, text("/detection"), text("cdr"), pairs(&[("a", "b")])];
        kinds
            .iter()
            .map(|kind| self.record(*kind, if *kind == SCHEMA { &schema } else { &channel }))
            .collect()
    }

    fn message(&self, number: u64) -> Vec<u8> {
        let sequence = u32::try_from(number).expect("there are few").to_le_bytes();
        let head = [&1_u16.to_le_bytes()[..], &sequence, &u64s(&[number, number])].concat();
        self.record(0x05, &[head, vec![0, 1, 0, 0, 1]])
    }
}

/// A whole file.
fn file(way: Way, content: Content) -> Vec<u8> {
    let mut file = File { way, bytes: mcap::MAGIC.to_vec() };
    file.put(0x01, &[text(""), text("somebody")]);
    let n_messages = content.n_messages;
    let definitions = file.definitions(&[SCHEMA, CHANNEL]).concat();
    let messages: Vec<Vec<u8>> = (0..n_messages).map(|number| file.message(number)).collect();
    let mut chunk_index = Vec::new();
    if n_messages == 0 {
    } else if way.chunks() {
        let records = [&definitions[..], &messages.concat()].concat();
        let size = records.len() as u64;
        let bounds = u64s(&[0, n_messages - 1, size]);
        let crc = crc32fast::hash(&records).to_le_bytes().to_vec();
        let (start, length) = file.put(0x06, &[bounds, crc, text(""), u64s(&[size]), records]);
        let index_at = file.bytes.len() as u64;
        if way.message_index() {
            let mut offset = definitions.len() as u64;
            let mut entries = Vec::new();
            for (number, message) in messages.iter().enumerate() {
                entries.extend(u64s(&[number as u64, offset]));
                offset += message.len() as u64;
            }
            file.put(0x07, &[1_u16.to_le_bytes().to_vec(), list(&entries)]);
        }
        let index_length = file.bytes.len() as u64 - index_at;
        let offsets = if way.message_index() {
            list(&[&1_u16.to_le_bytes()[..], &u64s(&[index_at])].concat())
        } else {
            list(&[])
        };
        let place = u64s(&[0, n_messages - 1, start, length]);
        let sizes = u64s(&[size, size]);
        chunk_index = vec![place, offsets, u64s(&[index_length]), text(""), sizes];
    } else {
        file.bytes.extend([definitions, messages.concat()].concat());
    }
    let mut besides = Vec::new();
    for number in 0..content.n_besides {
        let name = format!("notes_{number}");
        let fields = [u64s(&[1, 2]), text(&name), text("text/plain"), u64s(&[2]), b"hi".to_vec()];
        let crc = crc32fast::hash(&fields.concat()).to_le_bytes().to_vec();
        let attached = file.put(0x09, &[&fields[..], &[crc]].concat());
        let noted = file.put(0x0c, &[text(&name), pairs(&[("key", "value")])]);
        besides.push((name, attached, noted));
    }
    file.put(0x0f, &[vec![0; 4]]);
    summary(&mut file, content, &chunk_index, &besides);
    file.bytes
}

type Besides = (String, (u64, u64), (u64, u64));

fn summary(file: &mut File, content: Content, chunk: &[Vec<u8>], besides: &[Besides]) {
    let (way, n_messages) = (file.way, content.n_messages);
    let summary_at = file.bytes.len() as u64;
    let mut groups: Vec<(u8, Vec<Vec<u8>>)> = Vec::new();
    if n_messages > 0 && way.repeated_schemas() {
        groups.push((SCHEMA, file.definitions(&[SCHEMA])));
    }
    if n_messages > 0 && way.repeated_channels() {
        groups.push((CHANNEL, file.definitions(&[CHANNEL])));
    }
    if way.statistics() {
        let has_channel = u32::from(n_messages > 0);
        let n_besides = u32::try_from(content.n_besides).expect("there are few");
        let n_chunks = u32::from(way.chunks() && n_messages > 0);
        let counts = [has_channel, n_besides, n_besides, n_chunks];
        let of_channel = [&1_u16.to_le_bytes()[..], &u64s(&[n_messages])].concat();
        let fields = [
            u64s(&[n_messages]),
            u16::try_from(has_channel).expect("it is one").to_le_bytes().to_vec(),
            counts.iter().flat_map(|count| count.to_le_bytes()).collect(),
            u64s(&[0, n_messages.saturating_sub(1)]),
            list(if n_messages > 0 { &of_channel } else { &[] }),
        ];
        groups.push((0x0b, vec![file.record(0x0b, &fields)]));
    }
    if way.chunk_index() && !chunk.is_empty() {
        groups.push((0x08, vec![file.record(0x08, chunk)]));
    }
    if way.attachment_index() && !besides.is_empty() {
        let record = |(name, (start, length), _): &Besides| {
            let fields = [u64s(&[*start, *length, 1, 2, 2]), text(name), text("text/plain")];
            file.record(0x0a, &fields)
        };
        groups.push((0x0a, besides.iter().map(record).collect()));
    }
    if way.metadata_index() && !besides.is_empty() {
        let record = |(name, _, (start, length)): &Besides| {
            file.record(0x0d, &[u64s(&[*start, *length]), text(name)])
        };
        groups.push((0x0d, besides.iter().map(record).collect()));
    }
    let mut offsets = Vec::new();
    for (kind, records) in &groups {
        let start = file.bytes.len() as u64;
        file.bytes.extend(records.concat());
        let length = file.bytes.len() as u64 - start;
        offsets.push(file.record(0x0e, &[vec![*kind], u64s(&[start, length])]));
    }
    let offsets_at = file.bytes.len() as u64;
    let has_offsets = way.summary_offsets() && !groups.is_empty();
    if has_offsets {
        file.bytes.extend(offsets.concat());
    }
    let at = |is_there: bool, at: u64| if is_there { at } else { 0 };
    let starts = u64s(&[at(!groups.is_empty(), summary_at), at(has_offsets, offsets_at)]);
    file.put(0x02, &[starts, vec![0; 4]]);
    file.bytes.extend(mcap::MAGIC);
}

/// What a bag gives: its messages, attachments and metadata records, and whether it is whole.
fn read(path: &Path) -> (Vec<BagMessage>, usize, usize, bool) {
    let bag = Bag::open(path).expect("it is a bag");
    let messages = bag.messages().collect::<Result<_, _>>().expect("it is whole");
    let info = bag.info();
    let n_metadata = info.metadata.iter().filter(|name| name.starts_with("notes")).count();
    let is_whole = bag.damage().is_empty() && bag.summary_faults().is_empty();
    (messages, info.attachments.len(), n_metadata, is_whole)
}

#[test]
fn intact_files_of_every_layout_have_all_that_is_in_them_and_are_recovered_without_loss() {
    let folder = temporary();
    let path = folder.path().join("layout.mcap");
    for n_messages in [0, 1, 10] {
        for n_besides in [0, 1] {
            let content = Content { n_messages, n_besides };
            // With everything in it, every combination; the others see each feature often enough.
            let is_all = n_messages == 10 && n_besides == 1;
            for way in Way::all().step_by(if is_all { 1 } else { 7 }) {
                fs::write(&path, file(way, content)).expect("room");

                let found = read(&path);

                let counts = (found.0.len() as u64, found.1, found.2, found.3);
                let expected = (n_messages, n_besides, n_besides, true);
                assert_eq!(counts, expected, "{content:?}, {way:?}");
                let into = folder.path().join("saved");
                let recovered = recover_into(&path, &into, None).expect("it is whole");
                assert!(recovered.is_complete(), "{content:?}, {way:?}: {:?}", recovered.losses);
                let saved = read(&into);
                assert_eq!((saved.0, saved.1, saved.2), (found.0, found.1, found.2), "{way:?}");
                fs::remove_dir_all(&into).expect("it is ours");
            }
        }
    }
}
