//! What is learned of a file by reading it through.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read};

use mcap::read::ChannelAccumulator;
use mcap::records::{self, Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult};

use super::Attachment;
use super::checksums::{Fault, HEAD_BYTES, feed};
use super::table::{ChunkPlace, Table};
use crate::recover::frame::{self, ChunkHead};
use crate::unpack::Unpacker;

/// What is learned by reading a file through.
#[derive(Default)]
pub struct Scan {
    /// The channels by their numbers.
    pub channels: ChannelAccumulator<'static>,
    /// Messages by channel.
    pub counts: BTreeMap<u16, u64>,
    /// In order.
    pub attachments: Vec<Attachment>,
    /// In order.
    pub metadata: Vec<records::Metadata>,
    /// First and last log time, in nanoseconds.
    pub bounds_ns: Option<(u64, u64)>,
    /// How its chunks are compressed.
    pub compressions: BTreeSet<String>,
    /// Where the contents of its chunks are: place, and length in the file and unpacked.
    chunks: BTreeSet<(u64, u64, u64)>,
}

/// What unpacks the chunks of a file.
struct Unpacking {
    unpacker: Unpacker,
    content: Vec<u8>,
    /// A chunk that claims to be longer is not believed, in bytes.
    limit: usize,
}

impl Scan {
    /// Reads to the end of the data, or to the first thing that is not as it was written.
    ///
    /// # Returns
    ///
    /// That thing, if there is one.
    ///
    /// # Errors
    ///
    /// What the system says, where it cannot read the file.
    pub fn run(
        &mut self,
        mut source: impl Read,
        options: LinearReaderOptions,
    ) -> io::Result<Option<Fault>> {
        let limit = options.record_length_limit.unwrap_or(usize::MAX);
        let mut reader = LinearReader::new_with_options(options.with_emit_chunks(true));
        let mut unpacking = Unpacking { unpacker: Unpacker::new(), content: Vec::new(), limit };
        let mut at_byte = mcap::MAGIC.len() as u64;
        while let Some(event) = reader.next_event() {
            let taken = match event {
                Ok(LinearReadEvent::ReadRequest(n_bytes)) => {
                    match feed(&mut reader, &mut source, n_bytes)? {
                        Ok(()) => continue,
                        Err(error) => Err(error),
                    }
                }
                // What follows repeats what was said before.
                Ok(LinearReadEvent::Record { opcode: op::DATA_END, .. }) => return Ok(None),
                Ok(LinearReadEvent::Record { data, opcode: op::CHUNK }) => {
                    self.take_chunk(at_byte + HEAD_BYTES, data, &mut unpacking).map(|()| data.len())
                }
                Ok(LinearReadEvent::Record { data, opcode }) => {
                    self.take(opcode, data).map(|()| data.len())
                }
                Err(error) => Err(error),
            };
            match taken {
                Ok(n_bytes) => at_byte += HEAD_BYTES + n_bytes as u64,
                Err(error) => return Ok(Some(Fault::new(at_byte, &error))),
            }
        }
        Ok(None)
    }

    /// Whether a summary section counts and finds what is there.
    pub fn agrees_with(&self, table: &Table) -> bool {
        let place =
            |place: &ChunkPlace| (place.content_at, place.packed_bytes, place.content_bytes);
        let places: BTreeSet<_> = table.chunks.iter().map(place).collect();
        places == self.chunks && self.counts_are_of(table)
    }

    /// Whether a summary section counts what is there.
    pub fn counts_are_of(&self, table: &Table) -> bool {
        table.stats.as_ref().is_none_or(|stats| {
            let counted = &stats.channel_message_counts;
            let is_counted = |(id, n): (&u16, &u64)| counted.get(id).copied().unwrap_or(0) == *n;
            stats.message_count == self.counts.values().sum::<u64>()
                && (counted.is_empty() || self.counts.iter().all(is_counted))
        })
    }

    fn take_chunk(
        &mut self,
        body_at: u64,
        body: &[u8],
        unpacking: &mut Unpacking,
    ) -> McapResult<()> {
        let Unpacking { unpacker, content, limit } = unpacking;
        let no_head =
            || McapError::DecompressionError("the head of the chunk makes no sense".into());
        let head = ChunkHead::parse(body).ok_or_else(no_head)?;
        let (n_head, n_packed) = (head.n_head_bytes as u64, head.compressed_size);
        let end = n_head.checked_add(n_packed).filter(|end| *end <= body.len() as u64);
        let end = end.ok_or(McapError::BadChunkLength {
            header: n_head.saturating_add(n_packed),
            available: body.len() as u64,
        })?;
        let within = |at: u64| usize::try_from(at).expect("it is within a record in memory");
        let packed = &body[head.n_head_bytes..within(end)];
        let size = usize::try_from(head.uncompressed_size).ok().filter(|size| *size <= *limit);
        let size = size.ok_or(McapError::ChunkTooLarge(head.uncompressed_size))?;
        unpacker
            .unpack((&head.compression, packed), size, content)
            .map_err(McapError::DecompressionError)?;
        let (saved, calculated) = (head.crc, crc32fast::hash(content));
        if saved != 0 && saved != calculated {
            return Err(McapError::BadChunkCrc { saved, calculated });
        }
        self.chunks.insert((body_at + n_head, n_packed, head.uncompressed_size));
        self.compressions.insert(head.compression);
        let mut rest = &content[..];
        while !rest.is_empty() {
            let (opcode, length) = frame::head(rest).ok_or(McapError::UnexpectedEoc)?;
            let length = usize::try_from(length).map_err(|_too_long| McapError::UnexpectedEoc)?;
            let record = rest[frame::HEAD_BYTES..].split_at_checked(length);
            let (record, behind) = record.ok_or(McapError::UnexpectedEoc)?;
            self.take(opcode, record)?;
            rest = behind;
        }
        Ok(())
    }

    fn take(&mut self, opcode: u8, body: &[u8]) -> McapResult<()> {
        if frame::is_known(opcode) && !frame::is_readable(opcode, body) {
            return Err(McapError::DecompressionError(format!(
                "a record of kind {opcode:#04x} lacks some of its fields"
            )));
        }
        match mcap::parse_record(opcode, body)? {
            Record::Schema { header, data } => self.channels.add_schema_from_slice(header, &data),
            Record::Channel(channel) => {
                self.counts.entry(channel.id).or_default();
                self.channels.add_channel(channel)
            }
            Record::Message { header, .. } => {
                let count = self.counts.get_mut(&header.channel_id);
                let unknown = McapError::UnknownChannel(header.sequence, header.channel_id);
                *count.ok_or(unknown)? += 1;
                let time_ns = header.log_time;
                let (first_ns, last_ns) = self.bounds_ns.unwrap_or((time_ns, time_ns));
                self.bounds_ns = Some((first_ns.min(time_ns), last_ns.max(time_ns)));
                Ok(())
            }
            Record::Attachment { header, data, .. } => {
                let records::AttachmentHeader { name, media_type, .. } = header;
                self.attachments.push(Attachment { name, media_type, data: data.into_owned() });
                Ok(())
            }
            Record::Metadata(record) => {
                self.metadata.push(record);
                Ok(())
            }
            _ => Ok(()),
        }
    }
}
