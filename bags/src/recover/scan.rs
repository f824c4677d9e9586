//! Through a file from front to back, whatever state it is in.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use mcap::records::{MessageIndex, Record, op};
use mcap::{McapError, McapResult};

use super::bytes::Bytes;
use super::chunk::{self, Room};
use super::loss::{Loss, LossKind};
use super::search::{self, Layout};
use super::sink::Sink;
use super::validity::{self, ChunkHead};
use crate::records::{self, HEAD_BYTES, Unpacker, parse, reason};
use crate::{BagError, Compression};

/// A record outside of chunks is believed to be longer than this only if another one follows.
const MAX_LONE_RECORD: u64 = 16 << 20;

/// Why a message that reads well cannot be saved.
const UNKNOWN: &str = "messages of a channel whose definition is lost, or that do not unpack";

/// What was found in a file.
#[derive(Default)]
pub struct RecoveryFindings {
    pub losses: Vec<Loss>,
    /// Messages that the indexes behind lost chunks name, by topic.
    pub missing: BTreeMap<String, u64>,
    /// Whether anything in the file was an MCAP record.
    pub has_records: bool,
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
pub fn scan(path: &Path, bytes: &mut Bytes, sink: &mut Sink) -> Result<RecoveryFindings, BagError> {
    let mut scan = Scan {
        path,
        layout: if sink.expects_chunks() { Layout::Chunks } else { Layout::Loose },
        bytes,
        sink,
        found: RecoveryFindings::default(),
        at: 0,
        in_data: true,
        recent: BTreeMap::new(),
        hasher: Some(crc32fast::Hasher::new()),
        room: Room { unpacker: Unpacker::new(), content: Vec::new() },
    };
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
    found: RecoveryFindings,
    at: u64,
    /// Whether the data has not ended yet; the summary section stands behind it.
    in_data: bool,
    /// Messages saved from the last chunk and not yet named by the index behind it, by channel.
    recent: BTreeMap<u16, u64>,
    /// Over everything so far, until the first damage.
    hasher: Option<crc32fast::Hasher>,
    /// Where messages are to be expected behind damage.
    layout: Layout,
    room: Room,
}

impl Scan<'_> {
    fn step(&mut self) -> Result<(), BagError> {
        let from = self.at;
        match self.frame().map_err(BagError::io("read", self.path))? {
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
                // Where a record makes sense, its bytes may be those of a chunk's head by chance.
                if self.is_chunk_behind_head().map_err(BagError::io("read", self.path))? {
                    self.layout = Layout::Chunks;
                }
                let next = search::next_record(self.bytes, from + 1, self.sink, self.layout);
                self.at = next.map_err(BagError::io("read", self.path))?;
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

    /// Whether a record is valid. Behind damage nothing may be left over in it; before, the
    /// record before it has led here, and MCAP allows bytes behind the fields of a record.
    fn is_record(&self, opcode: u8, body: &[u8]) -> bool {
        let is_before_damage = self.found.losses.is_empty();
        validity::is_sound(opcode, body)
            || (is_before_damage && validity::is_readable(opcode, body))
    }

    /// The same for a chunk.
    fn is_chunk(&self, head: &ChunkHead, length: u64) -> bool {
        head.fills_record(length) || (self.found.losses.is_empty() && head.fits_in_record(length))
    }

    /// Looks at what starts here, and reads it.
    fn frame(&mut self) -> io::Result<Frame> {
        let start = self.bytes.read(self.at, HEAD_BYTES + validity::MAX_CHUNK_HEAD_BYTES)?;
        if start.starts_with(mcap::MAGIC) {
            return Ok(Frame::Magic);
        }
        let Some((opcode, length)) = records::head(&start) else { return Ok(Frame::Broken) };
        let chunk_head = ChunkHead::parse(&start[HEAD_BYTES..]);
        if opcode == op::CHUNK {
            self.layout = Layout::Chunks;
        }
        let available = self.bytes.len() - self.at - HEAD_BYTES as u64;
        let body_at = self.at + HEAD_BYTES as u64;
        if opcode == op::CHUNK {
            return match chunk_head {
                Some(head) if length <= available && self.is_chunk(&head, length) => {
                    let body = self.bytes.read(body_at, to_usize(length))?;
                    Ok(Frame::Record { opcode, body })
                }
                Some(head) if head.fills_record(length) || head.is_placeholder(length) => {
                    Ok(Frame::CutChunk(self.bytes.read(body_at, to_usize(available))?))
                }
                _ => Ok(Frame::Broken),
            };
        }
        let is_stray =
            opcode == op::MESSAGE && self.hasher.is_none() && self.layout == Layout::Chunks;
        if !validity::is_known(opcode) || length > available || (is_stray && self.in_data) {
            return Ok(Frame::Broken);
        }
        let is_short = opcode != op::MESSAGE && length <= MAX_LONE_RECORD;
        let is_followed = is_short || search::is_plausible(self.bytes, body_at + length)?;
        if !is_followed && length > MAX_LONE_RECORD {
            return Ok(Frame::Broken);
        }
        let body = self.bytes.read(body_at, to_usize(length))?;
        let is_half =
            opcode == op::MESSAGE && !is_followed && self.is_message_broken(body_at + length)?;
        // The index behind a chunk, whose first byte has changed, reads as a message, too.
        let is_index = opcode == op::MESSAGE
            && self.layout == Layout::Chunks
            && validity::is_index_of_chunk(&body);
        if is_half || is_index || !self.is_record(opcode, &body) {
            return Ok(Frame::Broken);
        }
        Ok(Frame::Record { opcode, body })
    }

    /// Whether the head of a record that is here, whatever it says, is followed by that of a chunk.
    fn is_chunk_behind_head(&mut self) -> io::Result<bool> {
        let start = self.bytes.read(self.at, HEAD_BYTES + validity::MAX_CHUNK_HEAD_BYTES)?;
        let head = start.get(HEAD_BYTES..).and_then(ChunkHead::parse);
        Ok(head.is_some_and(|head| head.is_filled()))
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
        match (opcode, parse(opcode, body)) {
            (op::CHUNK, _) => self.chunk(from, body, LossKind::Chunk)?,
            (_, Ok(Record::DataEnd(end))) => self.data_end(from, end.data_section_crc),
            (_, Ok(Record::MessageIndex(index))) => self.index(&index),
            // Behind the data everything is repeated, and what looks like a message is damaged.
            _ if !self.in_data => {}
            (_, Ok(Record::Message { header, data })) => {
                if self.sink.message(&header, &data)? {
                    *self.recent.entry(header.channel_id).or_default() += 1;
                } else {
                    self.lose_messages(from, 1);
                    self.last_loss().bounds_ns = Some((header.log_time, header.log_time));
                }
            }
            (_, Ok(Record::Header(header))) => self.found.profile = Some(header.profile),
            (_, Ok(Record::Attachment { header, data, .. })) => self.sink.attach(header, data)?,
            (_, Ok(Record::Metadata(record))) => self.sink.metadata(record)?,
            (_, Ok(definition)) => self.sink.define(definition)?,
            (_, Err(error)) => {
                self.lose(from, LossKind::Record, reason(&error));
            }
        }
        Ok(())
    }

    fn chunk(&mut self, from: u64, body: &[u8], if_lost: LossKind) -> Result<(), BagError> {
        self.recent.clear();
        let head = ChunkHead::parse(body).expect("the frame was judged by it");
        self.sink.compression.get_or_insert(match &*head.header.compression {
            "" => Compression::None,
            "lz4" => Compression::Lz4,
            _ => Compression::Zstd,
        });
        let mut unpacked = if if_lost == LossKind::EndOfChunk {
            Err(chunk::unpack_beginning(&head, body, &mut self.room))
        } else {
            chunk::unpack(&head, body, &mut self.room)
        };
        // Zeros to the end of the file: the system lost power before it wrote the rest. Its own last
        // bytes may be zeros, too: then its checksum shows that it is whole.
        let zeros_from = self.bytes.zero_tail();
        let is_half_written = zeros_from < self.bytes.len()
            && zeros_from < self.at
            && (unpacked.is_err() || head.header.uncompressed_crc == 0);
        if is_half_written {
            let written = to_usize(zeros_from.saturating_sub(from + HEAD_BYTES as u64));
            let written = &body[..written.max(head.n_bytes).min(body.len())];
            unpacked = Err(chunk::unpack_beginning(&head, written, &mut self.room));
        }
        let content = std::mem::take(&mut self.room.content);
        let saved = self.save(&content)?;
        self.room.content = content;
        if let Err(error) = unpacked.and(saved) {
            self.hasher = None;
            let kind = if is_half_written { LossKind::EndOfChunk } else { if_lost };
            self.lose(from, kind, reason(&error));
            let bounds_ns = (head.header.message_start_time, head.header.message_end_time);
            self.last_loss().bounds_ns = Some(bounds_ns).filter(|(first, last)| first <= last);
        }
        Ok(())
    }

    /// Puts the records of a chunk into the new bag, up to the first one that is not sound, and
    /// says what is wrong with that one.
    fn save(&mut self, content: &[u8]) -> Result<McapResult<()>, BagError> {
        let mut n_homeless = 0;
        let mut rest = content;
        let mut outcome = Ok(());
        while !rest.is_empty() {
            let Some((opcode, body)) = chunk::first_record(rest) else {
                outcome = Err(McapError::UnexpectedEoc);
                break;
            };
            rest = &rest[HEAD_BYTES + body.len()..];
            match parse(opcode, body) {
                Ok(Record::Message { header, data }) => {
                    if self.sink.message(&header, &data)? {
                        *self.recent.entry(header.channel_id).or_default() += 1;
                    } else {
                        n_homeless += 1;
                    }
                }
                Ok(definition) => self.sink.define(definition)?,
                Err(error) => {
                    outcome = Err(error);
                    break;
                }
            }
        }
        if n_homeless > 0 {
            self.lose_messages(self.at, n_homeless);
        }
        Ok(outcome)
    }

    /// The index behind a chunk names all that was in it: what was not saved is lost.
    fn index(&mut self, index: &MessageIndex) {
        let n_saved = self.recent.remove(&index.channel_id).unwrap_or(0);
        let n_missing = (index.records.len() as u64).saturating_sub(n_saved);
        let (Some(loss), true) = (self.found.losses.last_mut(), n_missing > 0) else { return };
        *loss.n_messages.get_or_insert(0) += n_missing;
        if n_saved == 0 && loss.kind != LossKind::Messages {
            let times_ns = index.records.iter().map(|entry| entry.log_time);
            let all_ns = times_ns.chain(loss.bounds_ns.into_iter().flat_map(|(a, b)| [a, b]));
            loss.bounds_ns = all_ns.clone().min().zip(all_ns.max());
        }
        if let Some(topic) = self.sink.topic(index.channel_id) {
            *self.found.missing.entry(topic).or_default() += n_missing;
        }
    }

    fn data_end(&mut self, from: u64, saved: u32) {
        self.in_data = false;
        let calculated = self.hasher.take().map(crc32fast::Hasher::finalize);
        if saved != 0 && calculated.is_some_and(|calculated| calculated != saved) {
            let reason = "the checksum over all data fails, those of its parts do not".to_owned();
            self.lose(from, LossKind::Unlocated, reason);
            self.last_loss().n_bytes = 0;
        }
    }

    /// Notes if the end is missing.
    fn end(&mut self) {
        let is_noted = self.found.losses.last().is_some_and(|loss| {
            loss.at_byte + loss.n_bytes == self.bytes.len() && loss.kind != LossKind::Messages
        });
        if !self.found.is_closed && !is_noted {
            let kind = if self.in_data { LossKind::EndOfFile } else { LossKind::TableOfContents };
            self.at = self.bytes.len();
            self.lose(self.at, kind, "the file was never closed".to_owned());
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

    /// Notes messages that read well and cannot be saved.
    fn lose_messages(&mut self, from: u64, n_messages: u64) {
        self.lose(from, LossKind::Messages, UNKNOWN.to_owned());
        self.last_loss().n_messages = Some(n_messages);
    }

    fn last_loss(&mut self) -> &mut Loss {
        self.found.losses.last_mut().expect("one was just noted")
    }

    fn hash(&mut self, bytes: &[u8]) {
        if let Some(hasher) = &mut self.hasher {
            hasher.update(bytes);
        }
    }
}

/// A length that was held against the size of the file.
fn to_usize(length: u64) -> usize {
    usize::try_from(length).unwrap_or(usize::MAX)
}
