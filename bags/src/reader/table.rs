//! A file's own table of contents: what is in the file, and where.
//!
//! A bag of hours has a hundred thousand chunks, each of which names every channel in it. So of a
//! chunk only what reading needs is kept, and equal lists of channels are kept once.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::sync::Arc;

use mcap::read::ChannelAccumulator;
use mcap::records::{AttachmentIndex, MetadataIndex, Record, Statistics, op};
use mcap::{Channel, McapError, McapResult, Schema};

/// Opcode and length in front of each record.
const HEAD_BYTES: usize = 9;

/// The footer: start of the summary, start of its offsets, checksum.
const FOOTER_BYTES: usize = 8 + 8 + 4;

/// What stands in front of a chunk's content, but for the name of its compression: head of the
/// record, first and last time, size, checksum, length of that name, compressed size.
const CHUNK_HEAD_BYTES: u64 = HEAD_BYTES as u64 + 8 + 8 + 8 + 4 + 4 + 8;

/// What is read ahead.
const BUFFER_BYTES: usize = 256 << 10;

/// What a file says of itself behind its data.
#[derive(Clone, Debug, Default)]
pub struct Table {
    /// What there is in numbers.
    pub stats: Option<Statistics>,
    /// The channels by their numbers.
    pub channels: BTreeMap<u16, Arc<Channel<'static>>>,
    /// The types by their numbers.
    pub schemas: BTreeMap<u16, Schema<'static>>,
    /// In order.
    pub attachment_indexes: Vec<AttachmentIndex>,
    /// In order.
    pub metadata_indexes: Vec<MetadataIndex>,
    /// In order.
    pub chunks: Vec<ChunkPlace>,
    /// How chunks are compressed, as often as it is named by one.
    pub compressions: Vec<String>,
    /// The lists of channels that chunks have; an empty one says nothing of what is in a chunk.
    pub channel_lists: Vec<Vec<u16>>,
}

/// Where a chunk is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ChunkPlace {
    /// First log time in it, in nanoseconds.
    pub first_ns: u64,
    /// Where its content starts in the file.
    pub content_at: u64,
    /// Bytes of its content as the file has it.
    pub packed_bytes: u64,
    /// Bytes of its content before compression.
    pub content_bytes: u64,
    /// Which of [`Table::compressions`].
    pub compression: u16,
    /// Which of [`Table::channel_lists`].
    pub channels: u32,
}

impl Table {
    /// Reads the table of contents; `None` if the file has none, or one that does not read.
    pub fn read(file: &mut File) -> Option<Self> {
        read(file).ok().flatten()
    }

    /// The same, with every channel to be looked for in every chunk.
    pub fn without_channel_lists(mut self) -> Self {
        self.channel_lists.iter_mut().for_each(Vec::clear);
        self
    }

    /// The same without the places of chunks.
    pub fn without_chunks(self) -> Self {
        Self { chunks: Vec::new(), channel_lists: Vec::new(), ..self }
    }
}

fn read(file: &mut File) -> McapResult<Option<Table>> {
    let n_bytes = file.seek(SeekFrom::End(0))?;
    let tail_bytes = HEAD_BYTES + FOOTER_BYTES + mcap::MAGIC.len();
    let Some(footer_at) = n_bytes.checked_sub(tail_bytes as u64) else { return Ok(None) };
    file.seek(SeekFrom::Start(footer_at))?;
    let mut tail = vec![0; tail_bytes];
    file.read_exact(&mut tail)?;
    let (footer, magic) = tail.split_at(HEAD_BYTES + FOOTER_BYTES);
    if magic != mcap::MAGIC || footer[0] != op::FOOTER {
        return Err(McapError::BadFooter);
    }
    let mut fields = Fields(&footer[HEAD_BYTES..]);
    let summary_at = fields.u64()?;
    if summary_at == 0 || summary_at > footer_at {
        return Ok(None);
    }
    file.seek(SeekFrom::Start(summary_at))?;
    let mut source = BufReader::with_capacity(BUFFER_BYTES, file);
    let mut reading = Reading::default();
    let mut left = footer_at - summary_at;
    let mut body = Vec::new();
    while left > 0 {
        let mut head = [0; HEAD_BYTES];
        source.read_exact(&mut head)?;
        let (opcode, length) = (head[0], Fields(&head[1..]).u64()?);
        left = left
            .checked_sub(HEAD_BYTES as u64)
            .and_then(|left| left.checked_sub(length))
            .ok_or(McapError::BadIndex)?;
        body.resize(usize::try_from(length).map_err(|_too_long| McapError::BadIndex)?, 0);
        source.read_exact(&mut body)?;
        reading.take(opcode, &body)?;
    }
    Ok(Some(reading.table))
}

/// A table that is being read.
#[derive(Default)]
struct Reading {
    table: Table,
    accumulator: ChannelAccumulator<'static>,
    lists: HashMap<Vec<u16>, u32>,
}

impl Reading {
    fn take(&mut self, opcode: u8, body: &[u8]) -> McapResult<()> {
        if opcode == op::CHUNK_INDEX {
            let place = self.place(Fields(body))?;
            self.table.chunks.push(place);
            return Ok(());
        }
        match mcap::parse_record(opcode, body)?.into_owned() {
            Record::AttachmentIndex(index) => self.table.attachment_indexes.push(index),
            Record::MetadataIndex(index) => self.table.metadata_indexes.push(index),
            Record::Statistics(stats) => self.table.stats = Some(stats),
            Record::Schema { header, data } => {
                self.accumulator.add_schema(header.clone(), data.clone())?;
                let (id, name, encoding) = (header.id, header.name, header.encoding);
                self.table.schemas.insert(id, Schema { id, name, encoding, data });
            }
            Record::Channel(channel) => {
                let id = channel.id;
                self.accumulator.add_channel(channel)?;
                let known = self.accumulator.get(id);
                self.table.channels.extend(known.map(|channel| (id, channel)));
            }
            // What starts in the data is no table of contents.
            Record::Chunk { .. } | Record::Message { .. } => return Err(McapError::BadIndex),
            _ => {}
        }
        Ok(())
    }

    fn place(&mut self, mut fields: Fields) -> McapResult<ChunkPlace> {
        let first_ns = fields.u64()?;
        let _last_ns = fields.u64()?;
        let chunk_at = fields.u64()?;
        let _length = fields.u64()?;
        let channels = fields.channels()?;
        let _index_length = fields.u64()?;
        let compression = fields.text()?;
        let content_at = chunk_at.checked_add(CHUNK_HEAD_BYTES + compression.len() as u64);
        let content_at = content_at.ok_or(McapError::BadChunkStartOffset(chunk_at))?;
        Ok(ChunkPlace {
            first_ns,
            content_at,
            compression: self.compression(compression)?,
            packed_bytes: fields.u64()?,
            content_bytes: fields.u64()?,
            channels: self.list(channels)?,
        })
    }

    fn compression(&mut self, name: &str) -> McapResult<u16> {
        let known = &mut self.table.compressions;
        let number = known.iter().position(|known| known == name).unwrap_or_else(|| {
            known.push(name.to_owned());
            known.len() - 1
        });
        u16::try_from(number).map_err(|_too_many| McapError::BadIndex)
    }

    fn list(&mut self, channels: Vec<u16>) -> McapResult<u32> {
        if let Some(number) = self.lists.get(&channels) {
            return Ok(*number);
        }
        let number = u32::try_from(self.table.channel_lists.len())
            .map_err(|_too_many| McapError::BadIndex)?;
        self.table.channel_lists.push(channels.clone());
        self.lists.insert(channels, number);
        Ok(number)
    }
}

/// Fields that are taken from the front.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn take(&mut self, n_bytes: usize) -> io::Result<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(n_bytes).ok_or(io::ErrorKind::UnexpectedEof)?;
        self.0 = rest;
        Ok(taken)
    }

    fn u32(&mut self) -> io::Result<u32> {
        let bytes = self.take(4)?.first_chunk().expect("so many were taken");
        Ok(u32::from_le_bytes(*bytes))
    }

    fn u64(&mut self) -> io::Result<u64> {
        let bytes = self.take(8)?.first_chunk().expect("so many were taken");
        Ok(u64::from_le_bytes(*bytes))
    }

    /// Bytes behind their length.
    fn sized(&mut self) -> io::Result<&'a [u8]> {
        let length = self.u32()?;
        self.take(usize::try_from(length).map_err(|_too_long| io::ErrorKind::UnexpectedEof)?)
    }

    fn text(&mut self) -> io::Result<&'a str> {
        std::str::from_utf8(self.sized()?).map_err(|_no_text| io::ErrorKind::InvalidData.into())
    }

    /// Numbers of channels, each with the place of its index, which nobody asks for.
    fn channels(&mut self) -> io::Result<Vec<u16>> {
        let entries = self.sized()?;
        if !entries.len().is_multiple_of(10) {
            return Err(io::ErrorKind::InvalidData.into());
        }
        let id = |entry: &[u8]| u16::from_le_bytes([entry[0], entry[1]]);
        let mut channels: Vec<u16> = entries.chunks_exact(10).map(id).collect();
        channels.sort_unstable();
        Ok(channels)
    }
}
