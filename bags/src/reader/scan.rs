//! What is found in a file by reading it through.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::Path;

use mcap::read::ChannelAccumulator;
use mcap::records::{self, ChunkIndex, Record};
use mcap::{McapError, McapResult, Summary};

use super::Attachment;
use super::linear::{ChunkLocation, Depth, Linear};
use crate::BagError;
use crate::records::reason;

/// The result of a checksum over a part of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// There is a checksum, and the bytes agree with it.
    Sound,
    /// Its writer has left the checksum out: MCAP has a zero for that.
    WithoutChecksum,
    /// It ends early, or is not what was written.
    Damaged(Fault),
}

/// Where a file is not as it was written, and how that shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The record, by its place in the file.
    pub at_byte: u64,
    pub reason: String,
    /// Whether the file ends there, as that of a recorder that was killed.
    pub is_end: bool,
}

impl Fault {
    fn new(at_byte: u64, error: &McapError) -> Self {
        let is_end = match error {
            McapError::UnexpectedEof => true,
            McapError::Io(error) => error.kind() == io::ErrorKind::UnexpectedEof,
            _ => false,
        };
        Self { at_byte, reason: reason(error), is_end }
    }
}

/// What is found in a file by reading it through.
pub struct Scan {
    /// Everything that was recorded.
    pub data: Part,
    /// The summary section behind it.
    pub summary: Part,
    pub channels: ChannelAccumulator<'static>,
    pub compressions: BTreeSet<String>,
    chunks: BTreeSet<ChunkLocation>,
    has_loose_messages: bool,
    pub found: ScannedRecords,
}

/// What is found in records, one after the other.
#[derive(Default)]
pub struct ScannedRecords {
    pub header: Option<records::Header>,
    pub counts: BTreeMap<u16, u64>,
    pub attachments: Vec<Attachment>,
    pub metadata: Vec<records::Metadata>,
    /// First and last log time, in nanoseconds.
    pub bounds_ns: Option<(u64, u64)>,
    data: Option<Part>,
    summary: Option<Part>,
}

impl Scan {
    /// Reads a file to its end, or to the first thing that is not as it was written.
    pub fn new(path: &Path, depth: Depth) -> Result<Self, BagError> {
        let mut file = Linear::open(path, depth)?;
        let mut found = ScannedRecords::default();
        let fault = loop {
            let taken = file.next().and_then(|record| match record {
                None => Ok(false),
                Some(record) => found.take(record).map(|()| true),
            });
            match taken {
                Ok(true) => {}
                Ok(false) => break None,
                Err(McapError::Io(source)) if source.raw_os_error().is_some() => {
                    return Err(BagError::io("read", path)(source));
                }
                Err(error) => break Some(Fault::new(file.at_byte, &error)),
            }
        };
        let is_read = fault.is_none();
        let fault = fault.unwrap_or_else(|| {
            let reason = "the record that ends its data is missing".to_owned();
            Fault { at_byte: file.at_byte, reason, is_end: false }
        });
        let (data, summary) = (found.data.take(), found.summary.take());
        Ok(Self {
            data: data.unwrap_or_else(|| Part::Damaged(fault.clone())),
            summary: summary.filter(|_| is_read).unwrap_or(Part::Damaged(fault)),
            channels: file.channels,
            compressions: file.compressions,
            chunks: file.chunks,
            has_loose_messages: file.has_loose_messages,
            found,
        })
    }

    /// Whether checksums vouch for all of it.
    pub fn is_sound(&self) -> bool {
        self.data == Part::Sound && self.summary == Part::Sound
    }

    /// Whether the index in a summary section leads to every message.
    pub fn is_indexed_by(&self, summary: &Summary) -> bool {
        let place = |index: &ChunkIndex| {
            let content_at = index.compressed_data_offset().ok()?;
            Some((content_at, index.compressed_size, index.uncompressed_size))
        };
        let places: Option<BTreeSet<ChunkLocation>> =
            summary.chunk_indexes.iter().map(place).collect();
        let in_chunks = places.is_some_and(|places| places == self.chunks);
        // Some writers count channels with messages alone.
        let has_channels = summary
            .stats
            .as_ref()
            .is_some_and(|stats| stats.channel_count as usize <= summary.channels.len());
        in_chunks && has_channels && !self.has_loose_messages
    }

    /// Whether a summary section counts what is there.
    pub fn counts_are_of(&self, summary: &Summary) -> bool {
        summary.stats.as_ref().is_none_or(|stats| {
            let (counted, counts) = (&stats.channel_message_counts, &self.found.counts);
            let is_counted = |(id, n): (&u16, &u64)| counted.get(id).copied().unwrap_or(0) == *n;
            stats.message_count == counts.values().sum::<u64>()
                && (counted.is_empty() || counts.iter().all(is_counted))
        })
    }
}

impl ScannedRecords {
    fn take(&mut self, record: Record) -> McapResult<()> {
        let part = |checksum: u32| if checksum == 0 { Part::WithoutChecksum } else { Part::Sound };
        match record {
            Record::Header(header) => self.header = Some(header),
            Record::Channel(channel) => {
                self.counts.entry(channel.id).or_default();
            }
            Record::Message { header, .. } => {
                let count = self.counts.get_mut(&header.channel_id);
                let unknown = McapError::UnknownChannel(header.sequence, header.channel_id);
                *count.ok_or(unknown)? += 1;
                let time_ns = header.log_time;
                let (first_ns, last_ns) = self.bounds_ns.unwrap_or((time_ns, time_ns));
                self.bounds_ns = Some((first_ns.min(time_ns), last_ns.max(time_ns)));
            }
            Record::Attachment { header, data, .. } => {
                let records::AttachmentHeader { name, media_type, .. } = header;
                self.attachments.push(Attachment { name, media_type, data: data.into_owned() });
            }
            Record::Metadata(record) => self.metadata.push(record),
            Record::DataEnd(end) => self.data = Some(part(end.data_section_crc)),
            Record::Footer(end) => self.summary = Some(part(end.summary_crc)),
            _ => {}
        }
        Ok(())
    }
}
