//! Whether bytes are a record of MCAP, strictly: damaged bytes must not pass for one.
//!
//! # Source
//!
//! The MCAP specification, version 0. Every length that a record states twice is compared.

use std::collections::BTreeMap;
use std::io::Cursor;

use binrw::BinRead;
use mcap::McapError;
use mcap::records::{ChunkHeader, Record, op};

use crate::reader::ZSTD_MAGIC;
use crate::records::{behind_texts, parse};

/// What must be read of a chunk to get its header: start, end, size, checksum, the name of its
/// compression behind a length, compressed size.
pub const MAX_CHUNK_HEAD_BYTES: usize = 8 + 8 + 8 + 4 + 4 + MAX_COMPRESSION_NAME + 8;

/// The longest name of a compression.
const MAX_COMPRESSION_NAME: usize = 4;

/// The representations of CDR that there are.
const MAX_ENCAPSULATION: u8 = 0x0b;

/// Whether records of this kind exist; private ones are not ours to keep.
pub fn is_known(opcode: u8) -> bool {
    (op::HEADER..=op::DATA_END).contains(&opcode)
}

/// Whether the body of a message is the index of a chunk: the places in a chunk, which are small numbers,
/// are where a message has the time of its publishing and more.
pub fn is_index_of_chunk(body: &[u8]) -> bool {
    let Ok(Record::MessageIndex(index)) = parse(op::MESSAGE_INDEX, body) else { return false };
    let is_place = |offset: u64| u32::try_from(offset).is_ok();
    is_sound(op::MESSAGE_INDEX, body) && index.records.iter().all(|entry| is_place(entry.offset))
}

/// What stands in front of the content of a chunk.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChunkHead {
    pub header: ChunkHeader,
    pub n_bytes: usize,
}

impl ChunkHead {
    /// Reads the head; `None` if it is none.
    pub fn parse(body: &[u8]) -> Option<Self> {
        let start = &body[..body.len().min(MAX_CHUNK_HEAD_BYTES)];
        behind_texts(op::CHUNK, start)?;
        let mut fields = Cursor::new(start);
        let header = ChunkHeader::read_le(&mut fields).ok()?;
        let is_possible = ["", "zstd", "lz4"].contains(&&*header.compression);
        let n_bytes = usize::try_from(fields.position()).ok()?;
        is_possible.then_some(Self { header, n_bytes })
    }

    /// Whether the chunk fills the record: their two lengths agree.
    pub fn fills_record(&self, length: u64) -> bool {
        self.header.compressed_size.checked_add(self.n_bytes as u64) == Some(length)
    }

    /// Whether the record holds the chunk; MCAP allows more bytes behind it.
    pub fn fits_in_record(&self, length: u64) -> bool {
        let end = self.header.compressed_size.checked_add(self.n_bytes as u64);
        end.is_some_and(|end| end <= length)
    }

    /// Whether there is a content: a head out of zeros is none.
    pub fn is_filled(&self) -> bool {
        self.header.compressed_size > 0 && self.header.uncompressed_size > 0
    }

    /// Whether it was never filled in: some recorders write heads last.
    pub fn is_placeholder(&self, length: u64) -> bool {
        length == u64::MAX && self.header.compressed_size == u64::MAX
    }
}

/// Whether a record other than a chunk has all of its fields; MCAP allows more bytes behind them.
///
/// An attachment that fails its checksum has them, too: what follows it can be read, and the scan
/// reports it as a lost record.
pub fn is_readable(opcode: u8, body: &[u8]) -> bool {
    matches!(parse(opcode, body), Ok(_) | Err(McapError::BadAttachmentCrc { .. }))
}

/// Whether a record other than a chunk has its fields and nothing else.
pub fn is_sound(opcode: u8, body: &[u8]) -> bool {
    parse(opcode, body).is_ok_and(|record| length(&record).is_none_or(|n| n == body.len()))
}

/// What the fields of a record take, in bytes; `None` for messages, chunks and the summary's records.
/// The data of messages and chunks have no end of their own, and nothing of the summary is saved.
fn length(record: &Record) -> Option<usize> {
    let text = |text: &String| 4 + text.len();
    let pairs = |pairs: &BTreeMap<String, String>| {
        4 + pairs.iter().map(|(key, value)| text(key) + text(value)).sum::<usize>()
    };
    Some(match record {
        Record::Header(header) => text(&header.profile) + text(&header.library),
        Record::Schema { header, data } => {
            2 + text(&header.name) + text(&header.encoding) + 4 + data.len()
        }
        Record::Channel(channel) => {
            let texts = text(&channel.topic) + text(&channel.message_encoding);
            4 + texts + pairs(&channel.metadata)
        }
        Record::MessageIndex(index) => 2 + 4 + 16 * index.records.len(),
        Record::Attachment { header, data, .. } => {
            16 + text(&header.name) + text(&header.media_type) + 8 + data.len() + 4
        }
        Record::Metadata(record) => text(&record.name) + pairs(&record.metadata),
        Record::DataEnd(_) => 4,
        Record::Footer(_) => 20,
        _ => return None,
    })
}

/// Whether the data of a message starts as ROS 2 writes it, or is compressed by rosbag2.
pub fn is_like_cdr(data: &[u8]) -> bool {
    match data {
        [0, kind, _, _, ..] => *kind <= MAX_ENCAPSULATION,
        _ => data.starts_with(&ZSTD_MAGIC),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chunk(compression: &str, compressed_size: u64) -> Vec<u8> {
        let mut body = [5_u64, 9, 100].map(u64::to_le_bytes).concat();
        body.extend(77_u32.to_le_bytes());
        body.extend(u32::try_from(compression.len()).unwrap().to_le_bytes());
        body.extend(compression.as_bytes());
        body.extend(compressed_size.to_le_bytes());
        body
    }

    #[test]
    fn a_chunk_is_recognised_by_its_two_lengths() {
        let head = ChunkHead::parse(&chunk("zstd", 30)).unwrap();

        assert_eq!((head.header.message_start_time, head.header.message_end_time), (5, 9));
        assert_eq!((head.header.uncompressed_crc, head.n_bytes), (77, 44));
        assert!(head.fills_record(74));
        assert!(!head.fills_record(75));
        assert_eq!(ChunkHead::parse(&chunk("gzip", 30)), None);
        assert_eq!(ChunkHead::parse(&chunk("zstd", 30)[..40]), None);
    }

    #[test]
    fn a_record_with_a_byte_too_many_or_too_few_is_not_sound() {
        let mut channel = vec![1, 0, 1, 0];
        for text in ["/a", "cdr", ""] {
            channel.extend(u32::try_from(text.len()).unwrap().to_le_bytes());
            channel.extend(text.as_bytes());
        }

        assert!(is_sound(op::CHANNEL, &channel));
        assert!(!is_sound(op::CHANNEL, &channel[1..]));
        assert!(!is_sound(op::CHANNEL, &[channel, vec![0]].concat()));
        assert!(!is_sound(op::MESSAGE_INDEX, &[1, 0, 15, 0, 0, 0]));
        assert!(is_sound(op::DATA_END, &[0; 4]));
    }

    #[test]
    fn a_message_as_long_as_an_index_is_none_for_it_has_a_time() {
        let bytes_of_entries = 48_u32;
        let begin = [&[1, 0], &bytes_of_entries.to_le_bytes()[..], &[0x18; 8]].concat();
        let behind = |field: u64| [&begin[..], &field.to_le_bytes(), &[0; 32]].concat();
        let published_ns = 1_700_000_000_000_000_000;

        assert!(is_index_of_chunk(&behind(4_096)));
        assert!(is_sound(op::MESSAGE_INDEX, &behind(published_ns)));
        assert!(!is_index_of_chunk(&behind(published_ns)));
    }
}
