//! The records of a file from front to back.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Seek, SeekFrom};
use std::ops::Range;
use std::path::Path;

use mcap::read::ChannelAccumulator;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult};

use super::source::{Source, read_some, unpacked_limit};
use crate::BagError;
use crate::records::{
    self, ChunkHead, HEAD_BYTES, MAX_CHUNK_HEAD_BYTES, Unpacker, may_start, read_at,
};

/// A record outside of chunks is believed to be longer than this only if another one follows.
const MAX_LONE_RECORD: u64 = 16 << 20;

/// How far a file is looked into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// At records outside of chunks, and at chunks as a whole.
    Chunks,
    /// At records within chunks, too.
    Messages,
    /// Also at the indexes behind chunks, and at chunks behind the record that ends the data: it may
    /// be another one that is damaged. Lengths are held against the file before anything is read.
    Indexes,
}

/// What shows that the current chunk is as it was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Trust {
    /// Its checksum.
    Checksum,
    /// Nothing: its writer left the checksum out.
    None,
    /// Nothing, and only the beginning of it is there.
    Beginning,
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
    /// A record that claims to be longer is not believed, in bytes.
    limit: usize,
    /// Where the current record starts in the file, or its chunk.
    pub at_byte: u64,
    /// Where the next one does; the same place if the current one could not be read.
    pub next_byte: u64,
    /// The head of the current chunk.
    pub chunk: Option<ChunkHead>,
    trust: Trust,
    /// The content of the current chunk, or a record that is in none.
    bytes: Vec<u8>,
    opcode: u8,
    body: Range<usize>,
    /// The room for the next chunk's content.
    content: Vec<u8>,
    unpacker: Unpacker,
    pub is_past_data: bool,
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
        let options = options(limit)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true);
        Ok(Self {
            source,
            reader: LinearReader::new_with_options(options),
            depth,
            limit,
            at_byte: 0,
            next_byte: mcap::MAGIC.len() as u64,
            chunk: None,
            trust: Trust::None,
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

    /// The next record; of the summary section only the footer, and indexes of messages only where they
    /// are asked for.
    ///
    /// # Errors
    ///
    /// What is not as it was written: a reader ends there. Behind a chunk whose content is damaged
    /// the next record can be read, and [`Linear::go_to`] goes on behind anything else.
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
            Record::Message { .. } => self.has_loose_messages |= self.chunk.is_none(),
            Record::DataEnd(_) => self.is_past_data = true,
            _ => {}
        }
        Ok(Some(record))
    }

    /// Goes on at a place in a file that is not compressed as a whole; only the checksums of chunks are
    /// compared from there on.
    pub fn go_to(&mut self, place: u64) -> io::Result<()> {
        self.bytes.clear();
        self.body = 0..0;
        self.next_byte = place;
        self.reader =
            LinearReader::new_with_options(options(self.limit).with_skip_start_magic(true));
        match &mut self.source {
            Source::Plain(source) => source.seek(SeekFrom::Start(place)).map(drop),
            Source::Zstd(_) => Err(io::ErrorKind::NotSeekable.into()),
        }
    }

    /// Takes what can be unpacked of the chunk that starts at the current place and goes on beyond the
    /// `end` of what was written; `false` if none does.
    pub fn take_beginning(&mut self, end: u64) -> io::Result<bool> {
        let Some(file) = self.file() else { return Ok(false) };
        let n_bytes = usize::try_from(end - self.at_byte).unwrap_or(usize::MAX);
        let mut packed = vec![0; n_bytes.min(HEAD_BYTES + MAX_CHUNK_HEAD_BYTES)];
        read_at(file, &mut packed, self.at_byte)?;
        let chunk = records::head(&packed).filter(|(opcode, _)| *opcode == op::CHUNK);
        let found = chunk.and_then(|(_, length)| {
            let head = ChunkHead::parse(&packed[HEAD_BYTES..])?;
            let is_chunk = head.fills(length) || head.is_placeholder(length);
            let is_cut = length > (n_bytes - HEAD_BYTES) as u64;
            (is_chunk && is_cut && head.is_supported()).then_some(head)
        });
        let Some(head) = found else { return Ok(false) };
        packed.resize(n_bytes, 0);
        read_at(file, &mut packed, self.at_byte)?;
        let packed = &packed[HEAD_BYTES + head.n_bytes..];
        let size = usize::try_from(head.header.uncompressed_size).unwrap_or(usize::MAX);
        let size = size.min(unpacked_limit(packed.len()));
        let compression = &head.header.compression;
        let _cut: McapResult<()> =
            self.unpacker.unpack((compression, packed), size, &mut self.bytes);
        (self.body, self.next_byte) = (0..0, end);
        (self.chunk, self.trust) = (Some(head), Trust::Beginning);
        Ok(true)
    }

    /// The file, if it is not compressed as a whole.
    pub fn file(&self) -> Option<&File> {
        match &self.source {
            Source::Plain(source) => Some(source.get_ref()),
            Source::Zstd(_) => None,
        }
    }

    /// Whether the current record, which is in no chunk, has its fields and nothing behind them.
    pub fn is_filled(&self) -> bool {
        records::is_filled(self.opcode, &self.bytes[self.body.clone()])
    }

    /// Goes to the next record, if there is one.
    fn advance(&mut self) -> McapResult<bool> {
        loop {
            while self.body.end < self.bytes.len() {
                let Some((opcode, body)) = self.first() else {
                    self.body.end = self.bytes.len();
                    if self.trust == Trust::Beginning {
                        break;
                    }
                    return Err(McapError::UnexpectedEoc);
                };
                (self.opcode, self.body) = (opcode, body);
                if records::may_be_in_chunks(opcode) {
                    return Ok(true);
                }
            }
            if !self.load()? {
                return Ok(false);
            }
            match self.opcode {
                op::CHUNK if !self.is_past_data || self.depth == Depth::Indexes => {
                    self.is_past_data = false;
                    self.take_chunk()?;
                    if self.depth == Depth::Chunks {
                        return Ok(true);
                    }
                }
                opcode if self.is_past_data && opcode != op::FOOTER => {}
                op::MESSAGE_INDEX if self.depth != Depth::Indexes => {}
                _ => return Ok(true),
            }
        }
    }

    /// The next record in the current chunk; `None` if it is not all there.
    fn first(&self) -> Option<(u8, Range<usize>)> {
        let rest = &self.bytes[self.body.end..];
        let (opcode, body) = records::first(rest)?;
        let behind = &rest[HEAD_BYTES + body.len()..];
        // What runs into zeros that go on to the end was never written, up to its own last bytes.
        let is_half_written = self.trust != Trust::Checksum
            && body.last().is_none_or(|byte| *byte == 0)
            && !behind.is_empty()
            && behind.iter().all(|byte| *byte == 0);
        let start = self.body.end + HEAD_BYTES;
        (!is_half_written).then_some((opcode, start..start + body.len()))
    }

    /// Reads the next record that is in no chunk.
    fn load(&mut self) -> McapResult<bool> {
        self.at_byte = self.next_byte;
        (self.chunk, self.trust) = (None, Trust::None);
        self.bytes.clear();
        self.body = 0..0;
        if self.depth == Depth::Indexes {
            self.check_length()?;
        }
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

    /// Holds the length of the record to come against its content and the file: room is made for it, and
    /// one that is wrong takes other records for a part of it.
    fn check_length(&self) -> McapResult<()> {
        let Some(file) = self.file() else { return Ok(()) };
        let mut start = [0; HEAD_BYTES + MAX_CHUNK_HEAD_BYTES];
        let n_read = read_at(file, &mut start, self.at_byte)?;
        let start = &start[..n_read];
        let Some((opcode, length)) = records::head(start) else { return Ok(()) };
        let available = file.metadata()?.len().saturating_sub(self.at_byte + HEAD_BYTES as u64);
        if start.starts_with(mcap::MAGIC) {
            return Ok(());
        }
        if length > available {
            return Err(McapError::UnexpectedEof);
        }
        let end = self.at_byte + HEAD_BYTES as u64 + length;
        match opcode {
            op::CHUNK => ChunkHead::of_record(&start[HEAD_BYTES..], length).map(drop),
            _ if length > MAX_LONE_RECORD && !may_start(file, end)? => {
                Err(McapError::RecordTooLarge { opcode, len: length })
            }
            _ => Ok(()),
        }
    }

    /// Notes where the chunk is that was read, and if its records are asked for puts its content in
    /// its place.
    fn take_chunk(&mut self) -> McapResult<()> {
        let parsed = records::parse(op::CHUNK, &self.bytes)?;
        let Record::Chunk { header, data } = parsed else { return Err(McapError::BadIndex) };
        let n_bytes = 8 + 8 + 8 + 4 + 4 + header.compression.len() + 8;
        let content_at = self.at_byte + (HEAD_BYTES + n_bytes) as u64;
        self.chunks.insert((content_at, data.len() as u64, header.uncompressed_size));
        let ChunkHead { header, .. } = self.chunk.insert(ChunkHead { header, n_bytes });
        if self.depth != Depth::Chunks {
            let size = usize::try_from(header.uncompressed_size).ok();
            let size = size.filter(|size| *size <= unpacked_limit(data.len()));
            let size = size.ok_or(McapError::ChunkTooLarge(header.uncompressed_size))?;
            self.unpacker.unpack((&header.compression, &data), size, &mut self.content)?;
            let (saved, calculated) = (header.uncompressed_crc, crc32fast::hash(&self.content));
            if saved != 0 && saved != calculated {
                return Err(McapError::BadChunkCrc { saved, calculated });
            }
            if saved != 0 {
                self.trust = Trust::Checksum;
            }
            std::mem::swap(&mut self.bytes, &mut self.content);
            self.body = 0..0;
        }
        self.compressions.insert(header.compression.clone());
        Ok(())
    }
}

/// How `mcap` reads: checksums are compared only from the start on.
fn options(limit: usize) -> LinearReaderOptions {
    LinearReaderOptions::default().with_emit_chunks(true).with_record_length_limit(limit)
}
