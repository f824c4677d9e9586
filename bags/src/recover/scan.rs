//! Through a file from front to back, whatever state it is in.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use mcap::McapError;
use mcap::records::{Record, op};

use super::bytes::Bytes;
use super::chunk::{Chunk, index_entries, index_length, loose_message};
use super::frame::{self, ChunkHead, HEAD_BYTES};
use super::loss::{Loss, LossKind};
use super::search::{self, Layout};
use super::sink::{Fate, Sink};
use crate::BagError;

/// A record outside of chunks is believed to be longer than this only if another one follows.
const MAX_LONE_RECORD: u64 = 16 << 20;

/// What was found in a file.
pub struct Found {
    /// What could not be saved.
    pub losses: Vec<Loss>,
    /// Messages that the indexes behind lost chunks name, by topic.
    pub missing: BTreeMap<String, u64>,
    /// Whether anything in the file was an MCAP record.
    pub has_records: bool,
    /// The profile in its header.
    pub profile: Option<String>,
    /// Whether the file ends as it should.
    pub is_closed: bool,
}

/// What starts at a place in a file.
enum Frame {
    /// The end or start mark of a file.
    Magic,
    Record {
        opcode: u8,
        body: Vec<u8>,
    },
    /// A chunk that goes on beyond the end.
    CutChunk(Vec<u8>),
    Broken,
}

/// Saves what is in a file.
///
/// # Errors
///
/// [`BagError::Io`] if it cannot be read, and those of writing the new bag.
pub fn scan(path: &Path, bytes: &mut Bytes, sink: &mut Sink) -> Result<Found, BagError> {
    let found = Found {
        losses: Vec::new(),
        missing: BTreeMap::new(),
        has_records: false,
        profile: None,
        is_closed: false,
    };
    let hasher = Some(crc32fast::Hasher::new());
    let layout = if sink.expects_chunks() { Layout::Chunks } else { Layout::Loose };
    let recent = BTreeMap::new();
    let mut scan = Scan { path, bytes, sink, found, at: 0, in_data: true, recent, hasher, layout };
    while scan.at < scan.bytes.len() && !scan.found.is_closed {
        scan.step()?;
    }
    scan.end();
    Ok(scan.found)
}

struct Scan<'a> {
    path: &'a Path,
    bytes: &'a mut Bytes,
    sink: &'a mut Sink,
    found: Found,
    at: u64,
    /// Whether the data has not ended yet; the table of contents stands behind it.
    in_data: bool,
    /// Messages saved from the last chunk and not yet named by the index behind it, by channel.
    recent: BTreeMap<u16, u64>,
    /// Over everything so far, until the first damage.
    hasher: Option<crc32fast::Hasher>,
    /// Where messages are to be expected behind damage.
    layout: Layout,
}

impl Scan<'_> {
    fn step(&mut self) -> Result<(), BagError> {
        let from = self.at;
        match self.frame().map_err(|source| self.io(source))? {
            Frame::Magic => {
                self.hash(mcap::MAGIC);
                self.at += mcap::MAGIC.len() as u64;
                self.found.is_closed = !self.in_data;
            }
            Frame::Record { opcode, body } => {
                self.found.has_records = true;
                self.at += (HEAD_BYTES + body.len()) as u64;
                self.record(from, opcode, &body)?;
                self.hash(&[opcode]);
                self.hash(&(body.len() as u64).to_le_bytes());
                self.hash(&body);
            }
            Frame::CutChunk(body) => {
                self.found.has_records = true;
                self.at = self.bytes.len();
                self.chunk(from, &body, LossKind::EndOfChunk)?;
            }
            Frame::Broken => {
                let next = search::next_record(self.bytes, from + 1, self.sink, self.layout);
                self.at = next.map_err(|source| self.io(source))?;
                self.hasher = None;
                let kind = match (self.in_data, self.at == self.bytes.len()) {
                    (false, _) => LossKind::TableOfContents,
                    (true, true) => LossKind::EndOfFile,
                    (true, false) => LossKind::Garbage,
                };
                self.lose(from, kind, "no record that makes sense".to_owned());
            }
        }
        Ok(())
    }

    /// Whether a record is what it says. Behind damage nothing may be left over in it; before, the
    /// record before it has led here, and MCAP allows bytes behind the fields of a record.
    fn is_record(&self, opcode: u8, body: &[u8]) -> bool {
        frame::is_sound(opcode, body)
            || (self.found.losses.is_empty() && frame::is_readable(opcode, body))
    }

    /// The same for a chunk.
    fn is_chunk(&self, head: &ChunkHead, length: u64) -> bool {
        head.fits(length) || (self.found.losses.is_empty() && head.is_within(length))
    }

    /// Looks at what starts here, and reads it.
    fn frame(&mut self) -> io::Result<Frame> {
        let start = self.bytes.read(self.at, HEAD_BYTES + frame::MAX_CHUNK_HEAD_BYTES)?;
        if start.starts_with(mcap::MAGIC) {
            return Ok(Frame::Magic);
        }
        let Some((opcode, length)) = frame::head(&start) else { return Ok(Frame::Broken) };
        let chunk_head = ChunkHead::parse(&start[HEAD_BYTES..]);
        if opcode == op::CHUNK || chunk_head.as_ref().is_some_and(ChunkHead::is_filled) {
            self.layout = Layout::Chunks;
        }
        let available = self.bytes.len() - self.at - HEAD_BYTES as u64;
        let body_at = self.at + HEAD_BYTES as u64;
        let is_expected = frame::is_known(opcode);
        if opcode == op::CHUNK {
            return match chunk_head {
                Some(head) if length <= available && self.is_chunk(&head, length) => {
                    let body = self.bytes.read(body_at, to_usize(length))?;
                    Ok(Frame::Record { opcode, body })
                }
                Some(head) if head.fits(length) || head.is_open(length) => {
                    Ok(Frame::CutChunk(self.bytes.read(body_at, to_usize(available))?))
                }
                _ => Ok(Frame::Broken),
            };
        }
        let is_stray =
            opcode == op::MESSAGE && self.hasher.is_none() && self.layout == Layout::Chunks;
        if !is_expected || length > available || (is_stray && self.in_data) {
            return Ok(Frame::Broken);
        }
        let is_short = opcode != op::MESSAGE && length <= MAX_LONE_RECORD;
        let is_followed = is_short || search::is_plausible(self.bytes, body_at + length)?;
        if !is_followed && length > MAX_LONE_RECORD {
            return Ok(Frame::Broken);
        }
        let body = self.bytes.read(body_at, to_usize(length))?;
        if !self.is_record(opcode, &body) {
            return Ok(Frame::Broken);
        }
        if opcode == op::MESSAGE && !is_followed && self.is_message_broken(body_at + length)? {
            return Ok(Frame::Broken);
        }
        Ok(Frame::Record { opcode, body })
    }

    /// Whether a message that nothing sensible follows has a wrong length, or was half written.
    fn is_message_broken(&mut self, end: u64) -> io::Result<bool> {
        let zeros_from = self.bytes.zero_tail();
        if end > zeros_from && end < self.bytes.len() {
            return Ok(true);
        }
        Ok(search::next_record(self.bytes, self.at + 1, self.sink, self.layout)? < end)
    }

    fn record(&mut self, from: u64, opcode: u8, body: &[u8]) -> Result<(), BagError> {
        match opcode {
            op::CHUNK => return self.chunk(from, body, LossKind::Chunk),
            // There are none behind the data: it is another record, damaged.
            op::MESSAGE if self.in_data => return self.loose(from, body),
            op::MESSAGE_INDEX => {
                self.index(body);
                return Ok(());
            }
            op::DATA_END => {
                self.data_end(from, body);
                return Ok(());
            }
            _ if !self.in_data => return Ok(()),
            _ => {}
        }
        let record = match mcap::parse_record(opcode, body) {
            Ok(record) => record,
            Err(error) => {
                self.lose(from, LossKind::Record, error.to_string());
                return Ok(());
            }
        };
        match record {
            Record::Header(header) => self.found.profile = Some(header.profile),
            Record::Attachment { header, data, .. } => {
                self.sink.attach(&header, &data)?;
            }
            Record::Metadata(record) => self.sink.metadata(&record)?,
            definition => self.sink.define(definition)?,
        }
        Ok(())
    }

    fn chunk(&mut self, from: u64, body: &[u8], if_lost: LossKind) -> Result<(), BagError> {
        self.recent.clear();
        let head = ChunkHead::parse(body).expect("the frame was judged by it");
        let is_cut = if_lost == LossKind::EndOfChunk;
        // Zeros to the end of the file: the system lost power before it wrote the rest.
        let body_at = from + HEAD_BYTES as u64;
        let zeros_from = self.bytes.zero_tail();
        let is_half_written = zeros_from < self.bytes.len() && zeros_from < self.at;
        let written = to_usize(zeros_from.saturating_sub(body_at)).max(head.n_head_bytes);
        let is_compressed = !head.compression.is_empty();
        let offsets = if is_cut || is_compressed || head.crc != 0 {
            Vec::new()
        } else {
            self.offsets_behind(self.at).map_err(|source| self.io(source))?
        };
        let bounds_ns = Some(head.bounds_ns).filter(|(first_ns, last_ns)| first_ns <= last_ns);
        let mut chunk = Chunk { head, body, is_cut, offsets };
        // Its own last bytes may be zeros, too: then its checksum tells that it is whole.
        if (chunk.head.crc != 0 || !is_half_written) && self.copy(&chunk)? {
            return Ok(());
        }
        let is_cut = is_cut || is_half_written;
        if is_half_written {
            (chunk.body, chunk.is_cut) = (&body[..written.min(body.len())], true);
        }
        if let Some(reason) = self.save(&chunk)? {
            let kind = if is_cut { LossKind::EndOfChunk } else { if_lost };
            self.hasher = None;
            self.lose(from, kind, reason);
            self.last_loss().bounds_ns = bounds_ns;
        }
        Ok(())
    }

    /// Puts a chunk into the new bag as it is, if it can.
    fn copy(&mut self, chunk: &Chunk) -> Result<bool, BagError> {
        let Some(copied) = self.sink.copy(chunk)? else { return Ok(false) };
        self.recent = copied;
        Ok(true)
    }

    /// Puts a chunk's records into the new bag.
    ///
    /// # Returns
    ///
    /// What is wrong with the chunk; `None` if nothing is.
    fn save(&mut self, chunk: &Chunk) -> Result<Option<String>, BagError> {
        let (sink, recent) = (&mut *self.sink, &mut self.recent);
        let mut failure = None;
        let mut n_homeless = 0_u64;
        let outcome = chunk.records(&mut |record| {
            let taken = match &record {
                Record::Message { header, data } => sink.message(header, data).map(|fate| {
                    if fate == Fate::Saved {
                        *recent.entry(header.channel_id).or_default() += 1;
                    } else {
                        n_homeless += 1;
                    }
                }),
                _ => sink.define(record),
            };
            taken.map_err(|error| {
                failure = Some(error);
                McapError::AttemptedWriteAfterFailure
            })
        });
        if let Some(error) = failure {
            return Err(error);
        }
        if n_homeless > 0 {
            self.lose(self.at, LossKind::Messages, UNKNOWN.to_owned());
            self.last_loss().n_messages = Some(n_homeless);
        }
        Ok(outcome.err().map(|error| error.to_string()))
    }

    /// A message outside of chunks.
    fn loose(&mut self, from: u64, body: &[u8]) -> Result<(), BagError> {
        let (header, data) = loose_message(body).expect("the frame was judged by its length");
        if self.sink.message(&header, data)? == Fate::Saved {
            *self.recent.entry(header.channel_id).or_default() += 1;
            return Ok(());
        }
        self.lose(from, LossKind::Messages, UNKNOWN.to_owned());
        self.last_loss().n_messages = Some(1);
        self.last_loss().bounds_ns = Some((header.log_time, header.log_time));
        Ok(())
    }

    /// The index behind a chunk names all that was in it: what was not saved is lost.
    fn index(&mut self, body: &[u8]) {
        let Some((channel_id, n_entries)) = index_length(body) else { return };
        let n_saved = self.recent.remove(&channel_id).unwrap_or(0);
        let n_missing = n_entries.saturating_sub(n_saved);
        let (Some(loss), true) = (self.found.losses.last_mut(), n_missing > 0) else { return };
        let Some((_, entries)) = index_entries(body) else { return };
        *loss.n_messages.get_or_insert(0) += n_missing;
        if n_saved == 0 && loss.kind != LossKind::Messages {
            let times_ns = || entries.iter().map(|(time_ns, _)| *time_ns);
            let named = times_ns().min().zip(times_ns().max());
            loss.bounds_ns = match (loss.bounds_ns, named) {
                (Some(known), Some(named)) => Some((known.0.min(named.0), known.1.max(named.1))),
                (known, named) => known.or(named),
            };
        }
        if let Some(topic) = self.sink.topic(channel_id) {
            *self.found.missing.entry(topic).or_default() += n_missing;
        }
    }

    fn data_end(&mut self, from: u64, body: &[u8]) {
        self.in_data = false;
        let saved = body.first_chunk().map_or(0, |crc| u32::from_le_bytes(*crc));
        let calculated = self.hasher.take().map(crc32fast::Hasher::finalize);
        if saved != 0 && calculated.is_some_and(|calculated| calculated != saved) {
            let reason = "the checksum over all data fails, those of its parts do not".to_owned();
            self.lose(from, LossKind::Unlocated, reason);
            self.last_loss().n_bytes = 0;
        }
    }

    /// Says if the end is missing.
    fn end(&mut self) {
        let is_told = self.found.losses.last().is_some_and(|loss| {
            loss.at_byte + loss.n_bytes == self.bytes.len() && loss.kind != LossKind::Messages
        });
        if !self.found.is_closed && !is_told {
            let kind = if self.in_data { LossKind::EndOfFile } else { LossKind::TableOfContents };
            self.at = self.bytes.len();
            self.lose(self.at, kind, "the file was never closed".to_owned());
        }
    }

    /// Places of messages within a chunk, by the indexes that follow it.
    fn offsets_behind(&mut self, mut at: u64) -> io::Result<Vec<u64>> {
        let mut offsets = Vec::new();
        loop {
            let start = self.bytes.read(at, HEAD_BYTES)?;
            let Some((op::MESSAGE_INDEX, length)) = frame::head(&start) else { return Ok(offsets) };
            let body_at = at + HEAD_BYTES as u64;
            if length > self.bytes.len() - body_at {
                return Ok(offsets);
            }
            let body = self.bytes.read(body_at, to_usize(length))?;
            let Some((_, entries)) = index_entries(&body) else { return Ok(offsets) };
            offsets.extend(entries.into_iter().map(|(_, offset)| offset));
            at = body_at + length;
        }
    }

    /// Notes that something from there to here is lost.
    fn lose(&mut self, from: u64, kind: LossKind, reason: String) {
        self.found.losses.push(Loss {
            path: self.path.to_owned(),
            at_byte: from,
            n_bytes: self.at - from,
            kind,
            reason,
            n_messages: None,
            bounds_ns: None,
        });
    }

    fn last_loss(&mut self) -> &mut Loss {
        self.found.losses.last_mut().expect("one was just noted")
    }

    fn hash(&mut self, bytes: &[u8]) {
        if let Some(hasher) = &mut self.hasher {
            hasher.update(bytes);
        }
    }

    fn io(&self, source: io::Error) -> BagError {
        BagError::Io { action: "read", path: self.path.to_owned(), source }
    }
}

/// Why a message that reads well cannot be saved.
const UNKNOWN: &str = "messages of a channel whose definition is lost, or that do not unpack";

/// A length that was held against the size of the file.
fn to_usize(length: u64) -> usize {
    usize::try_from(length).unwrap_or(usize::MAX)
}
