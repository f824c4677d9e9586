//! One `.mcap` file: what is in it, by its own table of contents or by reading it through.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::PathBuf;

use mcap::records;
use mcap::{Channel, McapError, McapResult};

use super::scan::{Scan, compressions};
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
    pub damage: Option<Damage>,
}

impl BagFile {
    /// Learns what is in a file.
    pub fn open(path: PathBuf) -> Result<Self, BagError> {
        let mut source = Source::open(&path)?;
        let library = check_header(&mut source, &path)?;
        let mut file = open(&path)?;
        let io = |source| BagError::Io { action: "read", path: path.clone(), source };
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
        };
        // A table of contents that does not read is as good as none: reading the file through finds
        // out what is wrong with it.
        let table = if opened.is_compressed { None } else { usable_table(&mut file) };
        match table {
            Some(found) => opened.by_table(found),
            None => opened.by_reading()?,
        }
        Ok(opened)
    }

    fn by_table(&mut self, UsableTable { table, attachments, metadata }: UsableTable) {
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

    fn by_reading(&mut self) -> Result<(), BagError> {
        let source = Source::open(&self.path)?;
        let options = source.options().map_err(|source| BagError::Io {
            action: "read",
            path: self.path.clone(),
            source,
        })?;
        let mut scan = Scan::default();
        self.damage = scan.run(source, options).err().map(|error| Damage {
            path: self.path.clone(),
            n_messages: scan.counts.values().sum(),
            last_log_time_ns: scan.bounds_ns.map(|(_, last_ns)| last_ns),
            reason: error.to_string(),
        });
        for (id, count) in &scan.counts {
            if let Some(channel) = scan.channels.get(*id) {
                self.add_channel(&channel, *count);
            }
        }
        self.bounds_ns = scan.bounds_ns;
        if !self.is_compressed {
            self.compressions = compressions(open(&self.path)?);
        }
        self.attachments = scan.attachments;
        self.metadata = scan.metadata;
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

/// A table of contents that leads to everything, with what is not in chunks.
struct UsableTable {
    table: Table,
    attachments: Vec<Attachment>,
    metadata: Vec<records::Metadata>,
}

/// The file's table of contents; `None` if there is none, or one that leads astray.
fn usable_table(file: &mut File) -> Option<UsableTable> {
    let table = Table::read(file).filter(lists_all_messages)?;
    let (attachments, metadata) = outside_chunks(file, &table).ok()?;
    Some(UsableTable { table, attachments, metadata })
}

fn outside_chunks(
    file: &mut File,
    table: &Table,
) -> McapResult<(Vec<Attachment>, Vec<records::Metadata>)> {
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
        let channels_agree = stats.channel_count as usize == table.channels.len();
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
