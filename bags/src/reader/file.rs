//! One `.mcap` file: what is in it, by its own table of contents or by reading it through.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use mcap::read::ChannelAccumulator;
use mcap::records::{self, Record};
use mcap::sans_io::{
    LinearReadEvent, LinearReader, LinearReaderOptions, SummaryReadEvent, SummaryReader,
};
use mcap::{Channel, McapError, McapResult, Summary};

use super::{Attachment, Damage, TopicInfo};
use crate::BagError;

/// Records of this size and less are read in any file; larger ones only if the file is larger.
const MIN_RECORD_LIMIT: usize = 64 << 20;

/// Opcode and length stand in front of each record.
const RECORD_HEAD: usize = 9;

/// A profile and a library name take far less than this.
const MAX_HEADER: u64 = 1 << 20;

/// An `.mcap` file and what was learned of it on opening.
#[derive(Debug)]
pub struct BagFile {
    pub path: PathBuf,
    /// The file's own table of contents, if it is there and lists all messages.
    pub summary: Option<Summary>,
    pub topics: Vec<TopicInfo>,
    pub attachments: Vec<Attachment>,
    pub metadata: Vec<records::Metadata>,
    pub damage: Option<Damage>,
}

impl BagFile {
    /// Learns what is in a file.
    pub fn open(path: PathBuf) -> Result<Self, BagError> {
        let mut file = open(&path)?;
        check_header(&mut file, &path)?;
        // A table of contents that does not read is as good as none: reading the file through finds
        // out what is wrong with it.
        match read_summary(&mut file) {
            Ok(Some(summary)) if lists_all_messages(&summary) => {
                Self::by_summary(path.clone(), &mut file, summary)
                    .or_else(|_unusable: McapError| Self::by_reading(path, file))
            }
            Ok(_) | Err(_) => Self::by_reading(path, file),
        }
    }

    fn by_summary(path: PathBuf, file: &mut File, summary: Summary) -> McapResult<Self> {
        let n_bytes = file.metadata()?.len();
        let mut attachments = Vec::new();
        for index in &summary.attachment_indexes {
            let bytes = region(file, (index.offset, index.length), n_bytes)?;
            let at_start = records::AttachmentIndex { offset: 0, ..index.clone() };
            attachments.push(mcap::read::attachment(&bytes, &at_start)?.into());
        }
        let mut metadata = Vec::new();
        for index in &summary.metadata_indexes {
            let bytes = region(file, (index.offset, index.length), n_bytes)?;
            let at_start = records::MetadataIndex { offset: 0, ..index.clone() };
            metadata.push(mcap::read::metadata(&bytes, &at_start)?);
        }
        let counts = summary.stats.as_ref().map(|stats| &stats.channel_message_counts);
        let channels: BTreeMap<_, _> = summary.channels.iter().collect();
        let topics = channels
            .into_iter()
            .map(|(id, channel)| {
                TopicInfo::new(channel, counts.and_then(|counts| counts.get(id)).copied())
            })
            .collect();
        Ok(Self { path, summary: Some(summary), topics, attachments, metadata, damage: None })
    }

    fn by_reading(path: PathBuf, mut file: File) -> Result<Self, BagError> {
        let io = |source| BagError::Io { action: "read", path: path.clone(), source };
        let options = linear_options(&file).map_err(io)?;
        file.seek(SeekFrom::Start(0)).map_err(io)?;
        let mut scan = Scan::default();
        let damage = scan.run(BufReader::new(file), options).err().map(|error| Damage {
            path: path.clone(),
            n_messages: scan.counts.values().sum(),
            last_log_time_ns: scan.last_log_time_ns,
            reason: error.to_string(),
        });
        let topics = scan
            .counts
            .iter()
            .filter_map(|(id, count)| {
                scan.channels.get(*id).map(|channel| TopicInfo::new(&channel, Some(*count)))
            })
            .collect();
        let Scan { attachments, metadata, .. } = scan;
        Ok(Self { path, summary: None, topics, attachments, metadata, damage })
    }
}

impl TopicInfo {
    fn new(channel: &Channel, n_messages: Option<u64>) -> Self {
        let described = |key: &str| channel.metadata.get(key).cloned().unwrap_or_default();
        Self {
            name: channel.topic.clone(),
            type_name: channel
                .schema
                .as_ref()
                .map(|schema| schema.name.clone())
                .unwrap_or_default(),
            encoding: channel.message_encoding.clone(),
            offered_qos_profiles: described("offered_qos_profiles"),
            type_hash: described("topic_type_hash"),
            n_messages: n_messages.unwrap_or(0),
        }
    }
}

impl From<mcap::Attachment<'_>> for Attachment {
    fn from(attachment: mcap::Attachment) -> Self {
        let mcap::Attachment { name, media_type, data, .. } = attachment;
        Self { name, media_type, data: data.into_owned() }
    }
}

/// What is learned by reading a file through.
#[derive(Default)]
struct Scan {
    channels: ChannelAccumulator<'static>,
    counts: BTreeMap<u16, u64>,
    attachments: Vec<Attachment>,
    metadata: Vec<records::Metadata>,
    last_log_time_ns: Option<u64>,
}

impl Scan {
    /// Reads to the end, or to the error that comes before it.
    fn run(&mut self, mut source: impl Read, options: LinearReaderOptions) -> McapResult<()> {
        let mut reader = LinearReader::new_with_options(options);
        while let Some(event) = reader.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(n_bytes) => {
                    let n_read = read_some(&mut source, reader.insert(n_bytes))?;
                    reader.notify_read(n_read);
                }
                LinearReadEvent::Record { data, opcode } => {
                    self.take(mcap::parse_record(opcode, data)?)?;
                }
            }
        }
        Ok(())
    }

    fn take(&mut self, record: Record) -> McapResult<()> {
        match record {
            Record::Schema { header, data } => self.channels.add_schema_from_slice(header, &data),
            Record::Channel(channel) => {
                self.counts.entry(channel.id).or_default();
                self.channels.add_channel(channel)
            }
            Record::Message { header, .. } => {
                let count = self.counts.get_mut(&header.channel_id);
                let unknown = McapError::UnknownChannel(header.sequence, header.channel_id);
                *count.ok_or(unknown)? += 1;
                self.last_log_time_ns = self.last_log_time_ns.max(Some(header.log_time));
                Ok(())
            }
            Record::Attachment { header, data, .. } => {
                let records::AttachmentHeader { name, media_type, .. } = header;
                self.attachments.push(Attachment { name, media_type, data: data.into_owned() });
                Ok(())
            }
            Record::Metadata(record) => {
                self.metadata.push(record);
                Ok(())
            }
            _ => Ok(()),
        }
    }
}

/// How a file is read from front to back.
pub fn linear_options(file: &File) -> std::io::Result<LinearReaderOptions> {
    Ok(LinearReaderOptions::default()
        .with_validate_chunk_crcs(true)
        .with_record_length_limit(record_limit(file)?))
}

/// The longest record that a sound file of this size could hold.
pub fn record_limit(file: &File) -> std::io::Result<usize> {
    let n_bytes = usize::try_from(file.metadata()?.len()).unwrap_or(usize::MAX);
    Ok(n_bytes.max(MIN_RECORD_LIMIT))
}

/// Opens a file to be read.
pub fn open(path: &Path) -> Result<File, BagError> {
    File::open(path).map_err(|source| BagError::Io {
        action: "open",
        path: path.to_owned(),
        source,
    })
}

/// Reads some bytes; zero only at the end.
pub fn read_some(source: &mut impl Read, buffer: &mut [u8]) -> std::io::Result<usize> {
    loop {
        match source.read(buffer) {
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            outcome => return outcome,
        }
    }
}

/// Refuses what is not an MCAP file of ROS 2.
fn check_header(file: &mut File, path: &Path) -> Result<(), BagError> {
    let path = path.to_owned();
    let mut head = Vec::new();
    let head_length = mcap::MAGIC.len() + RECORD_HEAD;
    if let Err(source) = file.take(head_length as u64).read_to_end(&mut head) {
        return Err(BagError::Io { action: "read", path, source });
    }
    if head.is_empty() {
        return Err(BagError::Empty { path });
    }
    let Some(record_head) = head.strip_prefix(mcap::MAGIC) else {
        return Err(BagError::NotMcap { path });
    };
    let incomplete = |source| BagError::Incomplete {
        path: path.clone(),
        n_messages: 0,
        last_log_time_ns: None,
        source,
    };
    let Some((&opcode, length)) = record_head.split_first() else {
        return Err(incomplete(McapError::UnexpectedEof));
    };
    let Ok(length) = length.try_into().map(u64::from_le_bytes) else {
        return Err(incomplete(McapError::UnexpectedEof));
    };
    let mut body = Vec::new();
    if let Err(source) = file.take(length.min(MAX_HEADER)).read_to_end(&mut body) {
        return Err(BagError::Io { action: "read", path, source });
    }
    if body.len() as u64 != length {
        return Err(incomplete(McapError::UnexpectedEof));
    }
    match mcap::parse_record(opcode, &body).map_err(incomplete)? {
        Record::Header(header) if header.profile == "ros2" => Ok(()),
        Record::Header(header) => Err(BagError::Profile { path, found: header.profile }),
        _ => Err(BagError::NotMcap { path }),
    }
}

fn read_summary(file: &mut File) -> McapResult<Option<Summary>> {
    file.seek(SeekFrom::Start(0))?;
    let mut reader = SummaryReader::new();
    while let Some(event) = reader.next_event() {
        match event? {
            SummaryReadEvent::ReadRequest(n_bytes) => {
                let n_read = read_some(file, reader.insert(n_bytes))?;
                reader.notify_read(n_read);
            }
            SummaryReadEvent::SeekRequest(to) => reader.notify_seeked(file.seek(to)?),
        }
    }
    Ok(reader.finish())
}

/// Whether the index leads to every message: a file without chunks has a summary and no index.
fn lists_all_messages(summary: &Summary) -> bool {
    summary.stats.as_ref().is_some_and(|stats| {
        let chunks_agree = stats.chunk_count as usize == summary.chunk_indexes.len();
        let indexes_agree = stats.attachment_count as usize == summary.attachment_indexes.len()
            && stats.metadata_count as usize == summary.metadata_indexes.len();
        let channels_agree = stats.channel_count as usize == summary.channels.len();
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
