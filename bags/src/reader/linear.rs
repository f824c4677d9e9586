//! The records of a file from front to back.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::Path;

use mcap::read::ChannelAccumulator;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult};

use super::source::{Source, read_some};
use crate::BagError;
use crate::records::{self, HEAD_BYTES, Unpacker};

/// How far a file is looked into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// At records outside of chunks, and at chunks as a whole.
    Chunks,
    /// At records within chunks, too.
    Messages,
}

/// The records of a file from front to back, held against the checksums of the data, of the summary
/// section, and of each chunk that is looked into.
///
/// `mcap`'s reader gives chunks as a whole: where it unpacks them by itself it gives messages before
/// it has compared the checksum of their chunk, and takes the length of a record beyond the end of a
/// chunk without compression.
pub struct Linear {
    source: Source,
    reader: LinearReader,
    depth: Depth,
    /// A chunk that claims to be longer is not believed, in bytes.
    limit: usize,
    /// Where the current record starts in the file, or its chunk.
    pub at_byte: u64,
    next_byte: u64,
    /// The content of the current chunk, or a record that is in none.
    bytes: Vec<u8>,
    opcode: u8,
    body: Range<usize>,
    /// The room for the next chunk's content.
    content: Vec<u8>,
    unpacker: Unpacker,
    is_past_data: bool,
    pub channels: ChannelAccumulator<'static>,
    pub chunks: BTreeSet<ChunkLocation>,
    pub compressions: BTreeSet<String>,
    /// Whether a message was in no chunk.
    pub has_loose_messages: bool,
}

/// Where the content of a chunk is, and its lengths in the file and unpacked.
pub type ChunkLocation = (u64, u64, u64);

impl Linear {
    /// Opens a file at its start.
    pub fn open(path: &Path, depth: Depth) -> Result<Self, BagError> {
        let source = Source::open(path)?;
        let limit = source.record_limit().map_err(BagError::io("read", path))?;
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_record_length_limit(limit);
        Ok(Self {
            source,
            reader: LinearReader::new_with_options(options),
            depth,
            limit,
            at_byte: 0,
            next_byte: mcap::MAGIC.len() as u64,
            bytes: Vec::new(),
            opcode: 0,
            body: 0..0,
            content: Vec::new(),
            unpacker: Unpacker::new(),
            is_past_data: false,
            channels: ChannelAccumulator::default(),
            chunks: BTreeSet::new(),
            compressions: BTreeSet::new(),
            has_loose_messages: false,
        })
    }

    /// The next record; of the summary section only the footer, and indexes of messages not at all.
    ///
    /// # Errors
    ///
    /// What is not as it was written: there is nothing to be read behind it.
    pub fn next(&mut self) -> McapResult<Option<Record<'_>>> {
        if !self.advance()? {
            return Ok(None);
        }
        let record = records::parse(self.opcode, &self.bytes[self.body.clone()])?;
        match &record {
            Record::Schema { header, data } => {
                self.channels.add_schema_from_slice(header.clone(), data)?;
            }
            Record::Channel(channel) => self.channels.add_channel(channel.clone())?,
            Record::Message { .. } => self.has_loose_messages |= self.body.start == 0,
            Record::DataEnd(_) => self.is_past_data = true,
            _ => {}
        }
        Ok(Some(record))
    }

    /// Goes to the next record, if there is one.
    fn advance(&mut self) -> McapResult<bool> {
        loop {
            while self.body.end < self.bytes.len() {
                let rest = &self.bytes[self.body.end..];
                let (opcode, body) = records::first(rest).ok_or(McapError::UnexpectedEoc)?;
                let start = self.body.end + HEAD_BYTES;
                (self.opcode, self.body) = (opcode, start..start + body.len());
                if records::may_be_in_chunks(opcode) {
                    return Ok(true);
                }
            }
            if !self.load()? {
                return Ok(false);
            }
            match self.opcode {
                opcode if self.is_past_data && opcode != op::FOOTER => {}
                op::MESSAGE_INDEX => {}
                op::CHUNK => {
                    self.take_chunk()?;
                    if self.depth == Depth::Chunks {
                        return Ok(true);
                    }
                }
                _ => return Ok(true),
            }
        }
    }

    /// Reads the next record that is in no chunk.
    fn load(&mut self) -> McapResult<bool> {
        self.at_byte = self.next_byte;
        while let Some(event) = self.reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(n_bytes) => {
                    let n_read = read_some(&mut self.source, self.reader.insert(n_bytes))?;
                    self.reader.notify_read(n_read);
                }
                LinearReadEvent::Record { data, opcode } => {
                    self.bytes.clear();
                    self.bytes.extend_from_slice(data);
                    self.next_byte += (HEAD_BYTES + data.len()) as u64;
                    (self.opcode, self.body) = (opcode, 0..data.len());
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// Notes where the chunk is that was read, and if its records are asked for puts its content in
    /// its place.
    fn take_chunk(&mut self) -> McapResult<()> {
        let parsed = records::parse(op::CHUNK, &self.bytes)?;
        let Record::Chunk { header, data } = parsed else { return Err(McapError::BadIndex) };
        let header_bytes = 8 + 8 + 8 + 4 + 4 + header.compression.len() + 8;
        let content_at = self.at_byte + (HEAD_BYTES + header_bytes) as u64;
        self.chunks.insert((content_at, data.len() as u64, header.uncompressed_size));
        if self.depth == Depth::Messages {
            self.unpacker.unpack_chunk(&header, &data, self.limit, &mut self.content)?;
            std::mem::swap(&mut self.bytes, &mut self.content);
            self.body = 0..0;
        }
        self.compressions.insert(header.compression);
        Ok(())
    }
}
