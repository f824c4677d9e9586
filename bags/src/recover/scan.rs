//! Through a file from front to back, whatever state it is in.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use mcap::McapError;
use mcap::records::{MessageHeader, MessageIndex, Record};

use super::loss::{Loss, LossKind};
use super::search::{self, Layout, Search, zero_tail};
use super::sink::Sink;
use crate::BagError;
use crate::reader::{Depth, Linear};
use crate::records::{may_start, reason};

/// Why a message that reads well cannot be saved.
const UNKNOWN: &str = "messages of a channel whose definition is lost, or that do not unpack";

/// Why bytes cannot be.
const NO_RECORD: &str = "no record that makes sense";

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

/// Saves what is in a file, of which `plain` is the one that is not compressed as a whole: all that a
/// reader reads, and where a reader ends, what stands behind it.
pub fn scan(path: &Path, plain: &Path, sink: &mut Sink) -> Result<RecoveryFindings, BagError> {
    let file = Linear::open(plain, Depth::Indexes)?;
    // Nobody compresses a file twice.
    let found = file.file().ok_or_else(|| BagError::NotMcap { path: path.to_owned() })?;
    let io = BagError::io("read", path);
    let (n_bytes, zeros_from) =
        (found.metadata().map_err(&io)?.len(), zero_tail(found).map_err(&io)?);
    let mut scan = Scan {
        path,
        n_bytes,
        file,
        sink,
        found: RecoveryFindings::default(),
        recent: BTreeMap::new(),
        zeros_from,
        is_last: false,
    };
    while scan.step()? {}
    scan.end();
    Ok(scan.found)
}

struct Scan<'a> {
    path: &'a Path,
    file: Linear,
    n_bytes: u64,
    sink: &'a mut Sink,
    found: RecoveryFindings,
    /// Messages saved and not yet named by the index behind their chunk, by channel.
    recent: BTreeMap<u16, u64>,
    /// Where nothing but a long run of zeros follows up to the end; the end if there is none.
    zeros_from: u64,
    /// Whether nothing follows the current chunk.
    is_last: bool,
}

impl Scan<'_> {
    /// Saves one record, or goes on behind what is none; `false` at the end.
    fn step(&mut self) -> Result<bool, BagError> {
        let was_past_data = self.file.is_past_data;
        let read = self.file.next().map(|record| record.map(Record::into_owned));
        if self.is_last && self.file.chunk.is_none() {
            return Ok(false);
        }
        let record = match read {
            Ok(Some(record)) => record,
            Ok(None) => {
                self.found.is_closed = true;
                return Ok(false);
            }
            Err(error) => return self.go_on(error),
        };
        if self.file.chunk.is_none() && !self.is_credible(&record)? {
            self.file.is_past_data = was_past_data;
            return self.search();
        }
        self.found.has_records = true;
        self.take(record)?;
        Ok(true)
    }

    /// Whether what was read outside of chunks is a record that belongs there, and of the right length.
    fn is_credible(&mut self, record: &Record) -> Result<bool, BagError> {
        let file = self.file.file().expect("it was looked at first");
        let is_followed =
            may_start(file, self.file.next_byte).map_err(BagError::io("read", self.path))?;
        Ok(match record {
            Record::Message { data, .. } => {
                // Among chunks it may be something else: an index, or behind damage a part of a chunk
                // whose head is lost, and with it the checksum over the message.
                let is_stray = self.layout() == Layout::Chunks
                    && (!self.found.losses.is_empty() || !search::is_like_cdr(data));
                let end = self.file.next_byte;
                let is_half_written = self.zeros_from < end && end < self.n_bytes;
                // Records within it show that its length is wrong.
                let is_broken = || Ok(is_half_written || self.next_record()? < end);
                !is_stray && (is_followed || !is_broken()?)
            }
            Record::Header(_)
            | Record::Schema { .. }
            | Record::Channel(_)
            | Record::MessageIndex(_)
            | Record::Attachment { .. }
            | Record::Metadata(_)
            | Record::DataEnd(_) => is_followed || self.file.is_filled(),
            Record::Footer(_) => self.file.is_past_data,
            // Of the summary section, or of no kind that there is.
            _ => false,
        })
    }

    fn take(&mut self, record: Record<'static>) -> Result<(), BagError> {
        match record {
            Record::Message { header, data } => {
                if self.sink.message(&header, data)? {
                    *self.recent.entry(header.channel_id).or_default() += 1;
                } else {
                    self.lose_message(&header);
                }
            }
            Record::Channel(channel) => {
                if let Some(channel) = self.file.channels.get(channel.id) {
                    self.sink.define(&channel)?;
                }
            }
            Record::MessageIndex(index) => self.index(&index),
            Record::Header(header) => self.found.profile = Some(header.profile),
            Record::Attachment { header, data, .. } => self.sink.attach(header, data)?,
            Record::Metadata(record) => self.sink.metadata(record)?,
            _ => {}
        }
        Ok(())
    }

    /// Goes on behind what is not as it was written; `false` at the end.
    fn go_on(&mut self, error: McapError) -> Result<bool, BagError> {
        let (from, to) = (self.file.at_byte, self.file.next_byte);
        match error {
            McapError::Io(source) if source.raw_os_error().is_some() => {
                return Err(BagError::io("read", self.path)(source));
            }
            // Of two definitions with one number the first one counts.
            McapError::ConflictingChannels(_)
            | McapError::ConflictingSchemas(_)
            | McapError::UnknownSchema(..)
            | McapError::InvalidSchemaId => return Ok(true),
            McapError::BadDataCrc { .. } => {
                let reason = "the checksum over all data fails, those of its parts do not";
                self.lose(from..from, LossKind::Unlocated, reason);
                // The same record again, without its checksum.
                self.go_to(from)?;
            }
            McapError::BadSummaryCrc { .. } => {
                self.lose(from..from, LossKind::TableOfContents, &reason(&error));
                self.go_to(from)?;
            }
            McapError::BadAttachmentCrc { .. } => {
                self.lose(from..to, LossKind::Record, &reason(&error));
                self.go_to(to)?;
            }
            // The chunk is all there, and what is in it is wrong.
            error if self.file.chunk.is_some() && to > from => {
                self.found.has_records = true;
                return self.leave_chunk(&error);
            }
            _ => return self.search(),
        }
        Ok(true)
    }

    fn go_to(&mut self, place: u64) -> Result<(), BagError> {
        self.file.go_to(place).map_err(BagError::io("read", self.path))
    }

    /// Leaves a chunk that is not as it was written, and all that is not yet read of it.
    fn leave_chunk(&mut self, error: &McapError) -> Result<bool, BagError> {
        let (from, to) = (self.file.at_byte, self.file.next_byte);
        // Zeros to the end of the file: the system lost power before it wrote the rest.
        if self.zeros_from < to && self.zeros_from < self.n_bytes && self.is_beginning()? {
            return Ok(true);
        }
        self.lose_chunk(from..to, LossKind::Chunk, &reason(error));
        self.go_to(to)?;
        Ok(true)
    }

    /// Goes on at the next record behind bytes that are none; `false` if there is none.
    fn search(&mut self) -> Result<bool, BagError> {
        let from = self.file.at_byte;
        if from >= self.n_bytes {
            return Ok(false);
        }
        if self.is_beginning()? {
            return Ok(true);
        }
        let next = self.next_record()?;
        let kind = match (self.file.is_past_data, next == self.n_bytes) {
            (true, _) => LossKind::TableOfContents,
            (false, true) => LossKind::EndOfFile,
            (false, false) => LossKind::Garbage,
        };
        self.lose(from..next, kind, NO_RECORD);
        self.go_to(next)?;
        Ok(next < self.n_bytes)
    }

    /// Whether a chunk starts here whose end is missing; its beginning is read then, and nothing
    /// follows it.
    fn is_beginning(&mut self) -> Result<bool, BagError> {
        let from = self.file.at_byte;
        let taken = self.file.take_beginning(self.zeros_from.max(from));
        if !taken.map_err(BagError::io("read", self.path))? {
            return Ok(false);
        }
        self.found.has_records = true;
        self.is_last = true;
        let reason = reason(&McapError::UnexpectedEof);
        self.lose_chunk(from..self.n_bytes, LossKind::EndOfChunk, &reason);
        Ok(true)
    }

    /// Where the next record is behind the start of the current one; the end if there is none.
    fn next_record(&self) -> Result<u64, BagError> {
        let search = Search {
            file: self.file.file().expect("it was looked at first"),
            n_bytes: self.n_bytes,
            layout: self.layout(),
            sink: self.sink,
        };
        search.next_record(self.file.at_byte + 1).map_err(BagError::io("read", self.path))
    }

    /// Where messages are to be expected behind damage.
    fn layout(&self) -> Layout {
        match self.sink.n_chunks() {
            _ if !self.file.chunks.is_empty() => Layout::Chunks,
            Some(0) => Layout::Loose,
            // What defines a topic stands where its messages do.
            None if self.sink.has_channels() => Layout::Loose,
            _ => Layout::Chunks,
        }
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

    /// Notes if the end is missing.
    fn end(&mut self) {
        let is_noted = self.found.losses.last().is_some_and(|loss| {
            loss.at_byte + loss.n_bytes == self.n_bytes && loss.kind != LossKind::Messages
        });
        if !self.found.is_closed && !is_noted {
            let is_data = !self.file.is_past_data;
            let kind = if is_data { LossKind::EndOfFile } else { LossKind::TableOfContents };
            self.lose(self.n_bytes..self.n_bytes, kind, "the file was never closed");
        }
    }

    /// Notes that bytes are lost.
    fn lose(&mut self, bytes: Range<u64>, kind: LossKind, reason: &str) {
        self.found.losses.push(Loss {
            path: self.path.to_owned(),
            at_byte: bytes.start,
            n_bytes: bytes.end - bytes.start,
            kind,
            reason: reason.to_owned(),
            n_messages: None,
            bounds_ns: None,
        });
    }

    /// Notes that the current chunk is lost, or its end.
    fn lose_chunk(&mut self, bytes: Range<u64>, kind: LossKind, reason: &str) {
        self.lose(bytes, kind, reason);
        let header = self.file.chunk.as_ref().map(|head| &head.header);
        let bounds_ns = header.map(|head| (head.message_start_time, head.message_end_time));
        self.last_loss().bounds_ns = bounds_ns.filter(|(first, last)| first <= last);
    }

    /// Notes a message that reads well and cannot be saved, with others of its chunk.
    fn lose_message(&mut self, header: &MessageHeader) {
        let (from, to) = (self.file.at_byte, self.file.next_byte);
        let is_noted = self
            .found
            .losses
            .last()
            .is_some_and(|loss| (loss.at_byte, loss.kind) == (from, LossKind::Messages));
        if !is_noted {
            self.lose(from..to, LossKind::Messages, UNKNOWN);
            self.last_loss().n_messages = Some(0);
        }
        let time_ns = header.log_time;
        let loss = self.last_loss();
        *loss.n_messages.get_or_insert(0) += 1;
        let (first_ns, last_ns) = loss.bounds_ns.unwrap_or((time_ns, time_ns));
        loss.bounds_ns = Some((first_ns.min(time_ns), last_ns.max(time_ns)));
    }

    fn last_loss(&mut self) -> &mut Loss {
        self.found.losses.last_mut().expect("one was just noted")
    }
}
