//! Messages out of a chunk, whole or not.

use std::io::{Cursor, Read};

use mcap::records::{MessageHeader, Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult};

use super::frame::{self, ChunkHead, HEAD_BYTES};

/// A chunk of this size is believed, and a larger one only if the file has an amount of bytes for
/// it that compression could explain: a damaged length must not take all memory.
const MIN_CONTENT_LIMIT: usize = 64 << 20;

/// Compression seldom does better than this.
const MAX_COMPRESSION: usize = 256;

/// A chunk as the file has it.
pub struct Chunk<'a> {
    /// What it says of itself.
    pub head: ChunkHead,
    /// Its head and as much of its content as there is.
    pub body: &'a [u8],
    /// Whether its end is missing.
    pub is_cut: bool,
    /// Where messages start within the content, by the index behind the chunk.
    pub offsets: Vec<u64>,
}

impl Chunk<'_> {
    /// Its content as the file has it.
    pub fn content(&self) -> &[u8] {
        let from = self.head.n_head_bytes.min(self.body.len());
        let n_bytes = usize::try_from(self.head.compressed_size).unwrap_or(usize::MAX);
        &self.body[from..from.saturating_add(n_bytes).min(self.body.len())]
    }

    /// The longest content that is believed, in bytes.
    pub fn content_limit(&self) -> usize {
        self.body.len().saturating_mul(MAX_COMPRESSION).max(MIN_CONTENT_LIMIT)
    }

    /// Hands over all records in it, in order.
    ///
    /// A chunk whose checksum fails gives none, because nobody knows which of its messages are
    /// wrong. Of a chunk whose end is missing the beginning is taken, as far as it can be
    /// decompressed. Where a chunk without checksum and compression is broken, the index behind it
    /// leads to the messages after the break.
    ///
    /// # Errors
    ///
    /// What is wrong with the chunk, or the error of `take`; all records before were handed over.
    pub fn records(&self, take: &mut impl FnMut(Record) -> McapResult<()>) -> McapResult<()> {
        let content = self.content();
        if !self.head.compression.is_empty() {
            return self.decompress(take);
        }
        if !self.is_cut && self.head.crc != 0 {
            let calculated = crc32fast::hash(content);
            let saved = self.head.crc;
            if saved != calculated {
                return Err(McapError::BadChunkCrc { saved, calculated });
            }
        }
        self.walk(content, take)?;
        if self.is_cut { Err(McapError::UnexpectedEof) } else { Ok(()) }
    }

    fn decompress(&self, take: &mut impl FnMut(Record) -> McapResult<()>) -> McapResult<()> {
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_record_length_limit(self.content_limit())
            .with_prevalidate_chunk_crcs(!self.is_cut && self.head.crc != 0);
        let length = (self.head.n_head_bytes as u64).saturating_add(self.head.compressed_size);
        let mut head = vec![op::CHUNK];
        head.extend(length.to_le_bytes());
        let whole = self.head.n_head_bytes.saturating_add(self.content().len());
        let mut source = Cursor::new(head).chain(&self.body[..whole.min(self.body.len())]);
        let mut reader = LinearReader::new_with_options(options);
        while let Some(event) = reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(n_bytes) => {
                    let n_read = source.read(reader.insert(n_bytes))?;
                    reader.notify_read(n_read);
                }
                LinearReadEvent::Record { data, opcode } => {
                    if frame::is_readable(opcode, data) {
                        take(mcap::parse_record(opcode, data)?)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// Goes through content that is not compressed.
    fn walk(
        &self,
        content: &[u8],
        take: &mut impl FnMut(Record) -> McapResult<()>,
    ) -> McapResult<()> {
        let mut at = 0;
        let mut broken = None;
        while at < content.len() {
            if let Some((record, end)) = record_at(content, at) {
                take(record)?;
                at = end;
                continue;
            }
            broken.get_or_insert(McapError::UnexpectedEoc);
            let next = self.offsets.iter().filter_map(|offset| usize::try_from(*offset).ok());
            match next.filter(|offset| *offset > at && *offset < content.len()).min() {
                Some(offset) => at = offset,
                None => break,
            }
        }
        broken.map_or(Ok(()), Err)
    }
}

/// The sound record at a place, and where it ends.
fn record_at(content: &[u8], at: usize) -> Option<(Record<'_>, usize)> {
    let (opcode, length) = frame::head(&content[at..])?;
    let start = at + HEAD_BYTES;
    let end = start.checked_add(usize::try_from(length).ok()?)?;
    let body = content.get(start..end)?;
    if !frame::may_be_in_chunks(opcode)
        || !frame::is_readable(opcode, body)
        || is_half_written(&content[..end], end, content)
    {
        return None;
    }
    Some((mcap::parse_record(opcode, body).ok()?, end))
}

/// Whether a record runs into zeros that go on to the end: its last bytes were never written.
fn is_half_written(until: &[u8], end: usize, content: &[u8]) -> bool {
    let rest = &content[end..];
    until.last() == Some(&0) && !rest.is_empty() && rest.iter().all(|byte| *byte == 0)
}

/// Time and place of the messages of one channel, as the index behind a chunk has them.
pub fn index_entries(body: &[u8]) -> Option<(u16, Vec<(u64, u64)>)> {
    match mcap::parse_record(op::MESSAGE_INDEX, body) {
        Ok(Record::MessageIndex(index)) => {
            let entries = index.records.iter().map(|entry| (entry.log_time, entry.offset));
            Some((index.channel_id, entries.collect()))
        }
        _ => None,
    }
}

/// The channel and how many messages the index behind a chunk names; its length was judged.
pub fn index_length(body: &[u8]) -> Option<(u16, u64)> {
    let (channel_id, rest) = body.split_first_chunk()?;
    let length = rest.first_chunk()?;
    Some((u16::from_le_bytes(*channel_id), u64::from(u32::from_le_bytes(*length)) / 16))
}

/// A message that stands outside of chunks.
pub fn loose_message(body: &[u8]) -> Option<(MessageHeader, &[u8])> {
    match mcap::parse_record(op::MESSAGE, body) {
        Ok(Record::Message { header, .. }) => Some((header, &body[frame::MESSAGE_HEAD_BYTES..])),
        _ => None,
    }
}
