//! Sound chunks, copied as they are.
//!
//! Unpacking a chunk and looking at each of its records takes a fraction of the time of packing it
//! anew. A chunk is copied only if nothing at all is wrong with it and the new file has the same
//! numbers for its channels; every other chunk goes the long way, message by message.

use mcap::records::{Record, op};

use super::chunk::Chunk;
use super::frame::{self, HEAD_BYTES, MESSAGE_HEAD_BYTES};
use super::parts::{Entries, Schema};
use crate::reader::ZSTD_MAGIC;
use crate::unpack::Unpacker;

/// The largest window that zstd's readers take if nobody tells them otherwise, as a power of two:
/// `ZSTD_WINDOWLOG_LIMIT_DEFAULT`.
const MOST_WINDOW_LOG: u32 = 27;

/// What is needed again for each chunk.
pub struct Copier {
    unpacker: Unpacker,
    content: Vec<u8>,
    /// Times and places of the messages of the chunk, by channel.
    pub entries: Entries,
}

/// What a chunk was found to hold.
pub struct Content {
    /// Bytes before compression.
    pub n_bytes: u64,
    /// Checksum of them.
    pub crc: u32,
    /// Definitions in it, in order.
    pub definitions: Vec<Record<'static>>,
}

impl Copier {
    pub fn new() -> Self {
        Self { unpacker: Unpacker::new(), content: Vec::new(), entries: Entries::new() }
    }

    /// Unpacks a chunk and goes through it.
    ///
    /// # Returns
    ///
    /// What is in it, with its messages in [`Copier::entries`]; `None` if anything is wrong with it,
    /// or if its messages are compressed.
    pub fn read(&mut self, chunk: &Chunk) -> Option<Content> {
        if chunk.is_cut {
            return None;
        }
        let packed = chunk.content();
        let size = usize::try_from(chunk.head.uncompressed_size).ok()?;
        if size > chunk.content_limit() {
            return None;
        }
        let mut buffer = std::mem::take(&mut self.content);
        let compression = chunk.head.compression.as_str();
        let content = if compression.is_empty() {
            packed
        } else {
            if compression == "zstd" && !is_streamable(packed, size) {
                return None;
            }
            self.unpacker.unpack((compression, packed), size, &mut buffer).ok()?;
            &buffer
        };
        let crc = crc32fast::hash(content);
        let is_sound = content.len() == size && (chunk.head.crc == 0 || chunk.head.crc == crc);
        let found = if is_sound { self.walk(content) } else { None };
        let n_bytes = content.len() as u64;
        self.content = buffer;
        Some(Content { n_bytes, crc, definitions: found? })
    }

    /// Notes all messages; gives the definitions.
    fn walk(&mut self, content: &[u8]) -> Option<Vec<Record<'static>>> {
        self.entries.values_mut().for_each(Vec::clear);
        let mut definitions = Vec::new();
        let mut at = 0;
        while at < content.len() {
            let (opcode, length) = frame::head(&content[at..])?;
            let start = at + HEAD_BYTES;
            let end = start.checked_add(usize::try_from(length).ok()?)?;
            let body = content.get(start..end)?;
            match opcode {
                op::MESSAGE => self.note(at, body)?,
                op::SCHEMA | op::CHANNEL if frame::is_readable(opcode, body) => {
                    definitions.push(mcap::parse_record(opcode, body).ok()?.into_owned());
                }
                _ => return None,
            }
            at = end;
        }
        Some(definitions)
    }

    fn note(&mut self, at: usize, body: &[u8]) -> Option<()> {
        let channel_id = u16::from_le_bytes(*body.first_chunk()?);
        let time_ns = u64::from_le_bytes(*body.get(6..)?.first_chunk()?);
        let data = body.get(MESSAGE_HEAD_BYTES..)?;
        if data.starts_with(&ZSTD_MAGIC) {
            return None;
        }
        self.entries.entry(channel_id).or_default().push((time_ns, at as u64));
        Some(())
    }
}

/// Whether readers can unpack a frame of zstd piece by piece, in the room that they give it. We unpack
/// it as a whole, which takes a damaged frame that asks for more.
fn is_streamable(packed: &[u8], size: usize) -> bool {
    // After the magic number: what the head has, and unless all is one segment, the window's size.
    let [_, _, _, _, descriptor, window, ..] = packed else { return false };
    let is_one_segment = descriptor & 0x20 != 0;
    let window_log = u32::from(window >> 3) + 10;
    let is_whole_power = window.is_multiple_of(8);
    if is_one_segment {
        size <= 1 << MOST_WINDOW_LOG
    } else {
        window_log < MOST_WINDOW_LOG || (window_log == MOST_WINDOW_LOG && is_whole_power)
    }
}

/// A definition of a type as a record of its own.
pub fn schema_of(record: &Record) -> Option<(u16, Schema)> {
    let Record::Schema { header, data } = record else { return None };
    let (name, encoding) = (header.name.clone(), header.encoding.clone());
    Some((header.id, Schema { name, encoding, data: data.to_vec() }))
}
