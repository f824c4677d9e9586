//! A chunk out of single messages, for what cannot be copied as it is.

use std::io;

use mcap::records::{MessageHeader, op};

use super::encode::RecordBytes;
use super::frame::MESSAGE_HEAD_BYTES;
use super::parts::Entries;

/// A chunk with this much in it is written.
const FULL_BYTES: usize = 1 << 20;

/// As fast as zstd goes: the copy must keep pace with the original.
const ZSTD_LEVEL: i32 = 1;

/// A chunk that is being filled.
#[derive(Default)]
pub struct NewChunk {
    /// Its records.
    pub content: Vec<u8>,
    /// Its messages.
    pub entries: Entries,
    /// Whether it will be compressed.
    pub is_compressed: bool,
}

impl NewChunk {
    /// Adds a message.
    pub fn add(&mut self, header: &MessageHeader, data: &[u8]) {
        let offset = self.content.len() as u64;
        self.entries.entry(header.channel_id).or_default().push((header.log_time, offset));
        let record = RecordBytes::new(op::MESSAGE).u16(header.channel_id).u32(header.sequence);
        let head = record.u64(header.log_time).u64(header.publish_time).finish_before(data.len());
        debug_assert_eq!(head.len(), super::frame::HEAD_BYTES + MESSAGE_HEAD_BYTES);
        self.content.extend_from_slice(&head);
        self.content.extend_from_slice(data);
    }

    /// Whether it is time to write it.
    pub fn is_full(&self) -> bool {
        self.content.len() >= FULL_BYTES
    }

    /// Whether there is nothing in it.
    pub fn is_empty(&self) -> bool {
        self.content.is_empty()
    }

    /// Its content as it goes into the file; `None` if that is the content itself.
    pub fn pack(&self) -> io::Result<Option<Vec<u8>>> {
        if !self.is_compressed {
            return Ok(None);
        }
        zstd::bulk::compress(&self.content, ZSTD_LEVEL).map(Some)
    }

    /// The next chunk, in the memory of this one.
    pub fn emptied(mut self) -> Self {
        self.content.clear();
        self.entries.values_mut().for_each(Vec::clear);
        self
    }
}
