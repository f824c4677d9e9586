//! Through a file from front to back, whatever state it is in.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::Path;

use mcap::records::{MessageIndex, Record, op};
use mcap::{McapError, McapResult};

use super::loss::{Loss, LossKind};
use super::search::DamagedFile;
use super::sink::Sink;
use crate::reader::unpacked_limit;
use crate::records::{self, HEAD_BYTES, MAX_CHUNK_HEAD_BYTES, Unpacker, parse, reason};
use crate::{BagError, Compression};

/// Zeros at the end of a file in such number are not data: the system had promised the space and
/// lost power before it kept the promise.
const MIN_ZERO_TAIL: u64 = 64;

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

/// Saves what is in a file: all that the reader reads, and where the reader ends, what stands behind.
pub fn scan(path: &Path, file: File, sink: &mut Sink) -> Result<RecoveryFindings, BagError> {
    let mut scan = Scan {
        file: DamagedFile::new(path, file)?,
        sink,
        found: RecoveryFindings::default(),
        at: 0,
        in_data: true,
        has_chunks: false,
        recent: BTreeMap::new(),
        hasher: Some(crc32fast::Hasher::new()),
        unpacker: Unpacker::new(),
    };
    while scan.at < scan.file.n_bytes && !scan.found.is_closed {
        scan.step()?;
    }
    scan.end();
    Ok(scan.found)
}

struct Scan<'a> {
    file: DamagedFile,
    sink: &'a mut Sink,
    found: RecoveryFindings,
    at: u64,
    /// Whether the data has not ended yet; the summary section stands behind it.
    in_data: bool,
    has_chunks: bool,
    /// Messages saved and not yet named by the index behind their chunk, by channel.
    recent: BTreeMap<u16, u64>,
    /// Over everything so far, until the first damage.
    hasher: Option<crc32fast::Hasher>,
    unpacker: Unpacker,
}

impl Scan<'_> {
    fn step(&mut self) -> Result<(), BagError> {
        let from = self.at;
        let start = self.file.read(from, HEAD_BYTES as u64 + MAX_CHUNK_HEAD_BYTES)?;
        if start.starts_with(mcap::MAGIC) {
            self.hash(mcap::MAGIC);
            self.at += mcap::MAGIC.len() as u64;
            self.found.is_closed = !self.in_data;
        } else if let Some(record) = self.record(&start)? {
            self.found.has_records = true;
            self.at += record.len() as u64;
            self.take(from, record[0], &record[HEAD_BYTES..])?;
            self.hash(&record);
        } else {
            // Where no channel is defined yet, what has a part of a chunk's head is one.
            let head = start.get(HEAD_BYTES..).and_then(records::chunk);
            let is_chunk =
                start[0] == op::CHUNK || head.is_some_and(|(head, _)| head.compressed_size > 0);
            self.has_chunks |= is_chunk && !self.sink.has_channels();
            self.at = self.next_record(self.file.n_bytes)?;
            self.hasher = None;
            let kind = match (self.in_data, self.at == self.file.n_bytes) {
                (false, _) => LossKind::TableOfContents,
                (true, true) => LossKind::EndOfFile,
                (true, false) => LossKind::Garbage,
            };
            self.lose(from, kind, "no record that makes sense");
        }
        Ok(())
    }

    /// Reads the record whose head is here; `None` if it makes no sense. Of a chunk that goes on beyond
    /// the end there is what there is.
    fn record(&mut self, start: &[u8]) -> Result<Option<Vec<u8>>, BagError> {
        let Some((opcode, length)) = records::head(start) else { return Ok(None) };
        let behind = self.at + HEAD_BYTES as u64;
        let mut end = behind.saturating_add(length);
        let mut is_sure = false;
        if let (op::CHUNK, Some((head, _))) = (opcode, records::chunk(&start[HEAD_BYTES..])) {
            // It has its length twice, of which one may have changed.
            let end_of_chunk = behind.saturating_add(records::chunk_length(&head));
            is_sure = end == end_of_chunk
                || (!self.file.may_start(end)? && self.file.may_start(end_of_chunk)?);
            if is_sure {
                end = end_of_chunk;
            }
        }
        if !records::is_known(opcode) || (end > self.file.n_bytes && !is_sure) {
            return Ok(None);
        }
        if !is_sure && !self.file.may_start(end)? {
            // Records within it show that its length is wrong, and zeros that it was half written.
            let is_half_written = opcode == op::MESSAGE && self.file.is_zero_from(end - 1)?;
            if is_half_written || self.next_record(end)? < end {
                return Ok(None);
            }
        }
        let record = self.file.read(self.at, end - self.at)?;
        let body = &record[HEAD_BYTES..];
        let is_sound = match opcode {
            op::CHUNK => records::chunk(body).is_some(),
            // Among chunks it may be an index whose first byte has changed, and behind damage a part of
            // a chunk whose head is lost.
            op::MESSAGE => {
                self.is_loose()
                    || (self.hasher.is_some() && !records::is_filled(op::MESSAGE_INDEX, body))
            }
            // What follows an attachment that fails its checksum can be read.
            _ => matches!(parse(opcode, body), Ok(_) | Err(McapError::BadAttachmentCrc { .. })),
        };
        Ok(is_sound.then_some(record))
    }

    /// Where the next record is, beyond doubt; `end` or behind it if there is none before.
    fn next_record(&mut self, end: u64) -> Result<u64, BagError> {
        let loose = self.is_loose().then_some(&*self.sink);
        self.file.next_record(self.at + 1, end, loose)
    }

    /// Whether messages stand outside of chunks, as far as is known.
    fn is_loose(&self) -> bool {
        !self.has_chunks && self.sink.n_chunks().is_none_or(|n_chunks| n_chunks == 0)
    }

    fn take(&mut self, from: u64, opcode: u8, body: &[u8]) -> Result<(), BagError> {
        match (opcode, parse(opcode, body)) {
            (op::CHUNK, _) => self.chunk(from, body)?,
            (_, Ok(Record::DataEnd(end))) => self.data_end(from, end.data_section_crc),
            (_, Ok(Record::MessageIndex(index))) => self.index(&index),
            // Behind the data everything is repeated, and what looks like a message is damaged.
            _ if !self.in_data => {}
            (_, Ok(Record::Header(header))) => self.found.profile = Some(header.profile),
            (_, Ok(Record::Attachment { header, data, .. })) => self.sink.attach(header, data)?,
            (_, Ok(Record::Metadata(record))) => self.sink.metadata(record)?,
            (_, Ok(record)) => {
                if let Some(time_ns) = self.save(record)? {
                    self.lose_messages(from, 1);
                    self.last_loss().bounds_ns = Some((time_ns, time_ns));
                }
            }
            (_, Err(error)) => self.lose(from, LossKind::Record, &reason(&error)),
        }
        Ok(())
    }

    /// Takes what the reader takes of a chunk. Where its end is missing, or no checksum is in it, that
    /// is as much as there is.
    fn chunk(&mut self, from: u64, body: &[u8]) -> Result<(), BagError> {
        self.recent.clear();
        self.has_chunks = true;
        let (head, packed) = records::chunk(body).expect("it was read by it");
        self.sink.compression.get_or_insert(match &*head.compression {
            "" => Compression::None,
            "lz4" => Compression::Lz4,
            _ => Compression::Zstd,
        });
        let size = usize::try_from(head.compressed_size).unwrap_or(usize::MAX);
        let (is_cut, packed) = (size > packed.len(), &packed[..size.min(packed.len())]);
        let mut content = Vec::new();
        let limit = unpacked_limit(packed.len());
        let mut unpacked = self.unpacker.unpack_chunk(&head, packed, limit, &mut content);
        let has_checksum = head.uncompressed_crc != 0;
        let n_written = packed.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
        let n_zeros = (packed.len() - n_written) as u64 + self.file.n_bytes - self.at;
        let has_zeros = n_zeros >= MIN_ZERO_TAIL;
        // Its own last bytes may be zeros, too: then its checksum shows that it is whole.
        let is_half_written = (unpacked.is_err() || !has_checksum)
            && (is_cut || has_zeros)
            && self.file.is_zero_from(self.at)?;
        if is_half_written {
            let written = &packed[..if has_zeros { n_written } else { packed.len() }];
            let size = usize::try_from(head.uncompressed_size).unwrap_or(usize::MAX).min(limit);
            let _cut: McapResult<()> =
                self.unpacker.unpack((&head.compression, written), size, &mut content);
            unpacked = Err(McapError::UnexpectedEof);
            self.at = self.file.n_bytes;
        } else if unpacked.is_err() && has_checksum {
            // It cannot be determined which of its messages are wrong.
            content.clear();
        }
        let saved = self.records_of_chunk(&content)?;
        if let Err(error) = unpacked.and(saved) {
            self.hasher = None;
            let kind = if is_half_written { LossKind::EndOfChunk } else { LossKind::Chunk };
            self.lose(from, kind, &reason(&error));
            let bounds_ns = (head.message_start_time, head.message_end_time);
            self.last_loss().bounds_ns = Some(bounds_ns).filter(|(first, last)| first <= last);
        }
        Ok(())
    }

    /// Puts the records of a chunk into the new bag, up to the first one that is not sound, and says
    /// what is wrong with that one.
    fn records_of_chunk(&mut self, content: &[u8]) -> Result<McapResult<()>, BagError> {
        let (mut rest, mut n_homeless) = (content, 0);
        let outcome = loop {
            if rest.is_empty() {
                break Ok(());
            }
            let first = records::first(rest).filter(|(opcode, body)| {
                let behind = &rest[HEAD_BYTES + body.len()..];
                // It was half written if it runs into zeros that go on to the end.
                let is_half_written = body.last() == Some(&0)
                    && !behind.is_empty()
                    && behind.iter().all(|byte| *byte == 0);
                records::may_be_in_chunks(*opcode) && !is_half_written
            });
            let Some((opcode, body)) = first else { break Err(McapError::UnexpectedEoc) };
            rest = &rest[HEAD_BYTES + body.len()..];
            match parse(opcode, body) {
                Ok(record) => n_homeless += u64::from(self.save(record)?.is_some()),
                Err(error) => break Err(error),
            }
        };
        if n_homeless > 0 {
            self.lose_messages(self.at, n_homeless);
        }
        Ok(outcome)
    }

    /// Saves a message or a definition; gives the log time of a message that cannot be saved.
    fn save(&mut self, record: Record) -> Result<Option<u64>, BagError> {
        let Record::Message { header, data } = record else {
            return self.sink.define(record).map(|()| None);
        };
        if !self.sink.message(&header, data)? {
            return Ok(Some(header.log_time));
        }
        *self.recent.entry(header.channel_id).or_default() += 1;
        Ok(None)
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
            let reason = "the checksum over all data fails, those of its parts do not";
            self.lose(from, LossKind::Unlocated, reason);
            self.last_loss().n_bytes = 0;
        }
    }

    /// Notes if the end is missing.
    fn end(&mut self) {
        let n_bytes = self.file.n_bytes;
        let is_noted = self.found.losses.last().is_some_and(|loss| {
            loss.at_byte + loss.n_bytes == n_bytes && loss.kind != LossKind::Messages
        });
        if !self.found.is_closed && !is_noted {
            let kind = if self.in_data { LossKind::EndOfFile } else { LossKind::TableOfContents };
            self.at = n_bytes;
            self.lose(n_bytes, kind, "the file was never closed");
        }
    }

    /// Notes that something from there to here is lost.
    fn lose(&mut self, from: u64, kind: LossKind, reason: &str) {
        self.found.losses.push(Loss {
            path: self.file.path.clone(),
            at_byte: from,
            n_bytes: self.at - from,
            kind,
            reason: reason.to_owned(),
            n_messages: None,
            bounds_ns: None,
        });
    }

    /// Notes messages that read well and cannot be saved.
    fn lose_messages(&mut self, from: u64, n_messages: u64) {
        self.lose(from, LossKind::Messages, UNKNOWN);
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
