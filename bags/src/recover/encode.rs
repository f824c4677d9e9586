//! Records of MCAP as bytes.
//!
//! # Source
//!
//! The MCAP specification, version 0: little-endian, lengths of 4 bytes in front of texts, pairs and
//! lists, of 8 bytes in front of data that may be large.

use std::collections::BTreeMap;

use mcap::records::{AttachmentHeader, op};

use super::frame::HEAD_BYTES;
use super::parts::{Definitions, Schema, Span};
use crate::writer::ChannelDescription;

/// A record that is being put together; its length is filled in at the end.
pub struct RecordBytes(Vec<u8>);

impl RecordBytes {
    /// Starts a record.
    pub fn new(opcode: u8) -> Self {
        let mut bytes = vec![0; HEAD_BYTES];
        bytes[0] = opcode;
        Self(bytes)
    }

    /// Adds bytes as they are.
    pub fn raw(mut self, bytes: &[u8]) -> Self {
        self.0.extend_from_slice(bytes);
        self
    }

    pub fn u16(self, number: u16) -> Self {
        self.raw(&number.to_le_bytes())
    }

    pub fn u32(self, number: u32) -> Self {
        self.raw(&number.to_le_bytes())
    }

    pub fn u64(self, number: u64) -> Self {
        self.raw(&number.to_le_bytes())
    }

    /// Adds bytes behind their length.
    pub fn sized(self, bytes: &[u8]) -> Self {
        self.u32(short(bytes.len())).raw(bytes)
    }

    /// Adds pairs of texts, behind the length of them all.
    pub fn pairs(self, pairs: &BTreeMap<String, String>) -> Self {
        let length = pairs.iter().map(|(key, value)| 8 + key.len() + value.len()).sum::<usize>();
        let start = self.u32(short(length));
        pairs.iter().fold(start, |record, (key, value)| {
            record.sized(key.as_bytes()).sized(value.as_bytes())
        })
    }

    /// Adds numbers by channel, behind the length of them all.
    pub fn by_channel<'a>(
        self,
        numbers: impl ExactSizeIterator<Item = (&'a u16, &'a u64)>,
    ) -> Self {
        let start = self.u32(short(numbers.len() * 10));
        numbers.fold(start, |record, (channel_id, number)| record.u16(*channel_id).u64(*number))
    }

    /// Adds first and last time, in nanoseconds; zeros if there is nothing between them.
    pub fn span(self, bounds_ns: Option<(u64, u64)>) -> Self {
        let (first_ns, last_ns) = bounds_ns.unwrap_or_default();
        self.u64(first_ns).u64(last_ns)
    }

    /// Adds the checksum of all fields so far.
    pub fn checksum(self) -> Self {
        let crc = crc32fast::hash(&self.0[HEAD_BYTES..]);
        self.u32(crc)
    }

    /// The record, behind which `n_following` more bytes of its body are to come.
    pub fn finish_before(mut self, n_following: usize) -> Vec<u8> {
        let length = (self.0.len() - HEAD_BYTES + n_following) as u64;
        self.0[1..HEAD_BYTES].copy_from_slice(&length.to_le_bytes());
        self.0
    }

    pub fn finish(self) -> Vec<u8> {
        self.finish_before(0)
    }
}

/// The definition of a type.
pub fn schema(id: u16, Schema { name, encoding, data }: &Schema) -> Vec<u8> {
    let record = RecordBytes::new(op::SCHEMA).u16(id).sized(name.as_bytes());
    record.sized(encoding.as_bytes()).sized(data).finish()
}

/// The definition of a channel.
pub fn channel(id: u16, schema_id: u16, channel: &ChannelDescription) -> Vec<u8> {
    let record = RecordBytes::new(op::CHANNEL).u16(id).u16(schema_id);
    let record = record.sized(channel.topic.as_bytes()).sized(channel.message_encoding.as_bytes());
    record.pairs(&channel.metadata).finish()
}

/// All definitions of a file, types first, each kind as one group.
pub fn definitions(definitions: &Definitions) -> [(u8, Vec<u8>); 2] {
    let Definitions { schemas, channels } = definitions;
    let of_types = schemas.iter().flat_map(|(id, known)| schema(*id, known));
    let of_channels =
        channels.iter().flat_map(|(id, (schema_id, known))| channel(*id, *schema_id, known));
    [(op::SCHEMA, of_types.collect()), (op::CHANNEL, of_channels.collect())]
}

/// An attachment.
pub fn attachment(header: &AttachmentHeader, data: &[u8]) -> Vec<u8> {
    let record = RecordBytes::new(op::ATTACHMENT).u64(header.log_time).u64(header.create_time);
    let record = record.sized(header.name.as_bytes()).sized(header.media_type.as_bytes());
    record.u64(data.len() as u64).raw(data).checksum().finish()
}

/// Where an attachment is.
pub fn attachment_index(span: Span, header: &AttachmentHeader, n_bytes: u64) -> Vec<u8> {
    let record = RecordBytes::new(op::ATTACHMENT_INDEX).u64(span.at).u64(span.n_bytes);
    let record = record.u64(header.log_time).u64(header.create_time).u64(n_bytes);
    record.sized(header.name.as_bytes()).sized(header.media_type.as_bytes()).finish()
}

/// Pairs of texts under a name.
pub fn metadata(name: &str, pairs: &BTreeMap<String, String>) -> Vec<u8> {
    RecordBytes::new(op::METADATA).sized(name.as_bytes()).pairs(pairs).finish()
}

/// Where pairs of texts are.
pub fn metadata_index(span: Span, name: &str) -> Vec<u8> {
    let record = RecordBytes::new(op::METADATA_INDEX).u64(span.at).u64(span.n_bytes);
    record.sized(name.as_bytes()).finish()
}

/// Where the messages of one channel are in a chunk: log time in nanoseconds, and offset.
pub fn message_index(channel_id: u16, entries: &[(u64, u64)]) -> Vec<u8> {
    let mut start = RecordBytes::new(op::MESSAGE_INDEX);
    start.0.reserve_exact(2 + 4 + entries.len() * 16);
    let start = start.u16(channel_id).u32(short(entries.len() * 16));
    let all =
        |record: RecordBytes, (time_ns, offset): &(u64, u64)| record.u64(*time_ns).u64(*offset);
    entries.iter().fold(start, all).finish()
}

/// A length that must fit into 4 bytes: no chunk and no text of a bag is that long.
fn short(length: usize) -> u32 {
    u32::try_from(length).expect("records were read from a file that had the same 4 bytes for it")
}
