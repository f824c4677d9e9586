//! One `.mcap` file: what is in it, by its own table of contents or by reading it through.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::PathBuf;

use mcap::records;
use mcap::{Channel, McapError, McapResult};

use super::checksums::{Checksums, Fault, Part};
use super::scan::Scan;
use super::source::{Source, check_header, open};
use super::table::Table;
use super::{Attachment, Damage, TopicInfo};
use crate::{BagError, qos};

/// An `.mcap` file and what was learned of it on opening.
#[derive(Debug)]
pub struct BagFile {
    pub path: PathBuf,
    /// On disk.
    pub n_bytes: u64,
    /// The program that wrote it.
    pub library: String,
    /// The file's own table of contents, if it is there and lists all messages.
    pub table: Option<Table>,
    pub topics: Vec<TopicInfo>,
    /// The definitions of types, by type.
    pub schemas: BTreeMap<String, Vec<u8>>,
    pub attachments: Vec<Attachment>,
    pub metadata: Vec<records::Metadata>,
    /// First and last log time, in nanoseconds.
    pub bounds_ns: Option<(u64, u64)>,
    /// How its chunks are compressed.
    pub compressions: BTreeSet<String>,
    /// Whether rosbag2 compressed it as a whole.
    pub is_compressed: bool,
    /// Where its data are not as they were written.
    pub damage: Option<Damage>,
    /// What is wrong with its summary section, if its data are whole.
    pub summary_fault: Option<String>,
}

impl BagFile {
    /// Learns what is in a file.
    pub fn open(path: PathBuf) -> Result<Self, BagError> {
        let mut source = Source::open(&path)?;
        let library = check_header(&mut source, &path)?;
        let io = |source| BagError::Io { action: "read", path: path.clone(), source };
        let whole = Source::open(&path)?;
        let options = whole.options().map_err(io)?;
        let checksums = Checksums::of(whole, options).map_err(io)?;
        let mut file = open(&path)?;
        let mut opened = Self {
            n_bytes: file.metadata().map_err(io)?.len(),
            path,
            library,
            table: None,
            topics: Vec::new(),
            schemas: BTreeMap::new(),
            attachments: Vec::new(),
            metadata: Vec::new(),
            bounds_ns: None,
            compressions: BTreeSet::new(),
            is_compressed: source.is_compressed(),
            damage: None,
            summary_fault: None,
        };
        // A summary section that does not read is as good as none.
        let is_readable = !opened.is_compressed && !checksums.summary.is_damaged();
        let table = if is_readable { Table::read(&mut file) } else { None };
        let is_sound = checksums.data == Part::Sound && checksums.summary == Part::Sound;
        let usable = table.as_ref().filter(|_| is_sound).and_then(|table| usable(&mut file, table));
        match (table, usable) {
            (Some(table), Some(outside)) => opened.by_table(table, outside),
            (table, _) => opened.by_reading(table, checksums)?,
        }
        Ok(opened)
    }

    fn by_table(&mut self, table: Table, (attachments, metadata): Outside) {
        let stats = table.stats.as_ref();
        let counts = stats.map(|stats| &stats.channel_message_counts);
        for (id, channel) in &table.channels {
            let n_messages = counts.and_then(|counts| counts.get(id)).copied();
            self.add_channel(channel, n_messages.unwrap_or(0));
        }
        self.bounds_ns = stats
            .filter(|stats| stats.message_count > 0)
            .map(|stats| (stats.message_start_time, stats.message_end_time));
        self.compressions = table.compressions.iter().cloned().collect();
        self.attachments = attachments;
        self.metadata = metadata;
        self.table = Some(table);
    }

    /// Reads through everything, as what has no checksum must show by itself that it is whole.
    fn by_reading(&mut self, table: Option<Table>, checksums: Checksums) -> Result<(), BagError> {
        let io = |source| BagError::Io { action: "read", path: self.path.clone(), source };
        let source = Source::open(&self.path)?;
        let options = source.options().map_err(io)?;
        let mut scan = Scan::default();
        let found = scan.run(source, options).map_err(io)?;
        let miscounted = table.as_ref().filter(|table| !scan.counts_are_of(table));
        let fault = match (found, checksums.data) {
            (Some(fault), _) | (None, Part::Damaged(fault)) => Some(fault),
            (None, Part::WithoutChecksum) if miscounted.is_some() => Some(Fault {
                at_byte: self.n_bytes,
                reason: "its messages are not as many as its summary section counts".to_owned(),
                is_end: false,
            }),
            (None, Part::Sound | Part::WithoutChecksum) => None,
        };
        let table = table.filter(|table| {
            fault.is_none() && lists_all_messages(table) && scan.agrees_with(table)
        });
        self.damage = fault.map(|fault| Damage {
            path: self.path.clone(),
            n_messages: scan.counts.values().sum(),
            last_log_time_ns: scan.bounds_ns.map(|(_, last_ns)| last_ns),
            at_byte: fault.at_byte,
            is_end: fault.is_end,
            reason: fault.reason,
        });
        self.summary_fault = match checksums.summary {
            Part::Damaged(fault) if self.damage.is_none() => Some(fault.reason),
            _ => None,
        };
        for (id, count) in &scan.counts {
            if let Some(channel) = scan.channels.get(*id) {
                self.add_channel(&channel, *count);
            }
        }
        self.bounds_ns = scan.bounds_ns;
        self.compressions = scan.compressions;
        self.attachments = scan.attachments;
        self.metadata = scan.metadata;
        // Which channels a chunk has is told by its content alone where no checksum vouches for the
        // index.
        self.table = table.map(Table::without_channel_lists);
        Ok(())
    }

    fn add_channel(&mut self, channel: &Channel, n_messages: u64) {
        self.topics.push(TopicInfo::new(channel, n_messages));
        if let Some(schema) = &channel.schema {
            self.schemas.entry(schema.name.clone()).or_insert_with(|| schema.data.to_vec());
        }
    }
}

impl TopicInfo {
    fn new(channel: &Channel, n_messages: u64) -> Self {
        let described = |key: &str| channel.metadata.get(key).cloned().unwrap_or_default();
        let type_name = channel.schema.as_ref().map(|schema| schema.name.clone());
        Self {
            name: channel.topic.clone(),
            type_name: type_name.unwrap_or_default(),
            encoding: channel.message_encoding.clone(),
            offered_qos_profiles: described(qos::KEY),
            type_hash: described(qos::HASH_KEY),
            n_messages,
        }
    }
}

impl From<mcap::Attachment<'_>> for Attachment {
    fn from(attachment: mcap::Attachment) -> Self {
        let mcap::Attachment { name, media_type, data, .. } = attachment;
        Self { name, media_type, data: data.into_owned() }
    }
}

/// What is not in chunks.
type Outside = (Vec<Attachment>, Vec<records::Metadata>);

/// What is not in chunks, if the table of contents leads to everything.
fn usable(file: &mut File, table: &Table) -> Option<Outside> {
    if !lists_all_messages(table) {
        return None;
    }
    outside_chunks(file, table).ok()
}

fn outside_chunks(file: &mut File, table: &Table) -> McapResult<Outside> {
    let n_bytes = file.metadata()?.len();
    let mut attachments = Vec::new();
    for index in &table.attachment_indexes {
        let bytes = region(file, (index.offset, index.length), n_bytes)?;
        let at_start = records::AttachmentIndex { offset: 0, ..index.clone() };
        attachments.push(mcap::read::attachment(&bytes, &at_start)?.into());
    }
    let mut metadata = Vec::new();
    for index in &table.metadata_indexes {
        let bytes = region(file, (index.offset, index.length), n_bytes)?;
        let at_start = records::MetadataIndex { offset: 0, ..index.clone() };
        metadata.push(mcap::read::metadata(&bytes, &at_start)?);
    }
    Ok((attachments, metadata))
}

/// Whether the index leads to every message: a file without chunks has a summary and no index.
fn lists_all_messages(table: &Table) -> bool {
    table.stats.as_ref().is_some_and(|stats| {
        let chunks_agree = stats.chunk_count as usize == table.chunks.len();
        let indexes_agree = stats.attachment_count as usize == table.attachment_indexes.len()
            && stats.metadata_count as usize == table.metadata_indexes.len();
        // Some writers count channels with messages alone.
        let channels_agree = stats.channel_count as usize <= table.channels.len();
        let has_chunks = stats.chunk_count > 0 || stats.message_count == 0;
        chunks_agree && indexes_agree && channels_agree && has_chunks
    })
}

/// Reads a part of a file that an index points to.
fn region(file: &mut File, (offset, length): (u64, u64), n_bytes: u64) -> McapResult<Vec<u8>> {
    if offset.checked_add(length).is_none_or(|end| end > n_bytes) {
        return Err(McapError::BadIndex);
    }
    file.seek(SeekFrom::Start(offset))?;
    let mut bytes = Vec::new();
    file.take(length).read_to_end(&mut bytes)?;
    Ok(bytes)
}
