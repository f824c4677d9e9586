//! Messages out of the files of a bag, one after the other.

use std::collections::{BTreeSet, HashMap};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::sync::Arc;

use mcap::records::MessageHeader;
use mcap::sans_io::{IndexedReadEvent, IndexedReader, IndexedReaderOptions};
use mcap::{McapError, McapResult};

use super::file::BagFile;
use super::source::{self, ZSTD_MAGIC, open, record_limit};
use crate::BagError;

/// A message out of a bag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BagMessage {
    /// The full name of its topic.
    pub topic: Arc<str>,
    /// Its type, such as `std_msgs/msg/Bool`.
    pub type_name: Arc<str>,
    /// When it was received, in nanoseconds.
    pub log_time_ns: u64,
    /// When it was sent, in nanoseconds.
    pub publish_time_ns: u64,
    /// The sender's count, if the recorder kept it.
    pub sequence: u32,
    /// As recorded: CDR with its encapsulation, for [`rsrs_msgs::cdr::decode`].
    pub bytes: Vec<u8>,
}

/// The messages of a bag; see [`super::Bag::messages`].
pub struct Messages<'a> {
    files: std::slice::Iter<'a, BagFile>,
    topics: Option<BTreeSet<String>>,
    current: Option<OpenFile<'a>>,
}

impl<'a> Messages<'a> {
    pub(super) fn new(files: &'a [BagFile], topics: Option<BTreeSet<String>>) -> Self {
        Self { files: files.iter(), topics, current: None }
    }
}

impl Iterator for Messages<'_> {
    type Item = Result<BagMessage, BagError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let Some(current) = &mut self.current else {
                match OpenFile::new(self.files.next()?, self.topics.as_ref()) {
                    Ok(file) => self.current = Some(file),
                    Err(error) => return Some(Err(error)),
                }
                continue;
            };
            match current.next_message() {
                Ok(Some(message)) => {
                    if self.topics.as_ref().is_none_or(|topics| topics.contains(&*message.topic)) {
                        return Some(Ok(message));
                    }
                }
                Ok(None) => self.current = None,
                Err(error) => {
                    self.current = None;
                    return Some(Err(error));
                }
            }
        }
    }
}

/// A file that is being read.
struct OpenFile<'a> {
    file: &'a BagFile,
    source: Source,
    names: Names,
    n_messages: u64,
    last_log_time_ns: Option<u64>,
}

/// The two ways through a file.
enum Source {
    /// By its index, in order of log time.
    Indexed { reader: Box<IndexedReader>, file: File },
    /// From front to back.
    Linear(Box<mcap::io::MessageReader<source::Source>>),
}

/// Topic and type of each channel, shared by its messages.
type Names = HashMap<u16, (Arc<str>, Arc<str>)>;

impl<'a> OpenFile<'a> {
    fn new(file: &'a BagFile, topics: Option<&BTreeSet<String>>) -> Result<Self, BagError> {
        let io = |source| BagError::Io { action: "read", path: file.path.clone(), source };
        let mut opened = match &file.summary {
            None => {
                let source = source::Source::open(&file.path)?;
                let options = source.options().map_err(io)?;
                let reader = mcap::io::MessageReader::new_with_options(source, options);
                Self::at_start(file, Source::Linear(Box::new(reader)))
            }
            Some(summary) => {
                let source = open(&file.path)?;
                let mut options = IndexedReaderOptions::new()
                    .with_record_length_limit(record_limit(&source).map_err(io)?);
                if let Some(topics) = topics {
                    options = options.include_topics(topics.iter().map(String::as_str));
                }
                let reader =
                    IndexedReader::new_with_options(summary, options).map_err(|source| {
                        let path = file.path.clone();
                        BagError::Incomplete { path, n_messages: 0, last_log_time_ns: None, source }
                    })?;
                Self::at_start(file, Source::Indexed { reader: Box::new(reader), file: source })
            }
        };
        let channels = file.summary.iter().flat_map(|summary| &summary.channels);
        opened.names = channels.map(|(id, channel)| (*id, channel_names(channel))).collect();
        Ok(opened)
    }

    fn at_start(file: &'a BagFile, source: Source) -> Self {
        Self { file, source, names: Names::new(), n_messages: 0, last_log_time_ns: None }
    }

    fn next_message(&mut self) -> Result<Option<BagMessage>, BagError> {
        let message = match &mut self.source {
            Source::Indexed { reader, file } => next_indexed(reader, file, &self.names),
            Source::Linear(reader) => next_linear(reader, &mut self.names),
        };
        match message {
            Ok(Some(message)) => {
                self.n_messages += 1;
                self.last_log_time_ns = self.last_log_time_ns.max(Some(message.log_time_ns));
                Ok(Some(message))
            }
            Ok(None) => Ok(None),
            Err(source) => Err(BagError::Incomplete {
                path: self.file.path.clone(),
                n_messages: self.n_messages,
                last_log_time_ns: self.last_log_time_ns,
                source,
            }),
        }
    }
}

fn next_indexed(
    reader: &mut IndexedReader,
    file: &mut File,
    names: &Names,
) -> McapResult<Option<BagMessage>> {
    let mut chunk = Vec::new();
    loop {
        let offset = match reader.next_event().transpose()? {
            None => return Ok(None),
            Some(IndexedReadEvent::Message { header, data }) => {
                let unknown = McapError::UnknownChannel(header.sequence, header.channel_id);
                let names = names.get(&header.channel_id).ok_or(unknown)?;
                return message(names, header, data.to_vec()).map(Some);
            }
            Some(IndexedReadEvent::ReadChunkRequest { offset, length }) => {
                file.seek(SeekFrom::Start(offset))?;
                chunk.clear();
                file.take(length as u64).read_to_end(&mut chunk)?;
                offset
            }
        };
        reader.insert_chunk_record_data(offset, &chunk)?;
    }
}

fn next_linear(
    reader: &mut mcap::io::MessageReader<source::Source>,
    names: &mut Names,
) -> McapResult<Option<BagMessage>> {
    let Some(read) = reader.next().transpose()? else {
        return Ok(None);
    };
    let channel = &read.channel;
    let names = names.entry(channel.id).or_insert_with(|| channel_names(channel));
    let header = MessageHeader {
        channel_id: channel.id,
        sequence: read.sequence,
        log_time: read.log_time,
        publish_time: read.publish_time,
    };
    message(names, header, read.data.into_owned()).map(Some)
}

fn channel_names(channel: &mcap::Channel) -> (Arc<str>, Arc<str>) {
    let type_name = channel.schema.as_ref().map_or("", |schema| schema.name.as_str());
    (channel.topic.as_str().into(), type_name.into())
}

fn message(
    names: &(Arc<str>, Arc<str>),
    header: MessageHeader,
    bytes: Vec<u8>,
) -> McapResult<BagMessage> {
    Ok(BagMessage {
        topic: names.0.clone(),
        type_name: names.1.clone(),
        log_time_ns: header.log_time,
        publish_time_ns: header.publish_time,
        sequence: header.sequence,
        bytes: plain(bytes)?,
    })
}

/// A message without the compression that rosbag2 may have put around it.
///
/// Metadata says whether it did, but a recorder that was killed left none; CDR starts with a zero,
/// so that the two cannot be confused.
pub fn plain(bytes: Vec<u8>) -> McapResult<Vec<u8>> {
    if !bytes.starts_with(&ZSTD_MAGIC) {
        return Ok(bytes);
    }
    zstd::stream::decode_all(&*bytes)
        .map_err(|error| McapError::DecompressionError(error.to_string()))
}
