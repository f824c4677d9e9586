//! Messages out of the files of a bag, one after the other.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::sync::Arc;

use mcap::records::{MessageHeader, Record};
use mcap::sans_io::{IndexedReadEvent, IndexedReader, IndexedReaderOptions};
use mcap::{Channel, McapError, McapResult, Summary};

use super::file::BagFile;
use super::linear::{Depth, Linear};
use super::source::{ZSTD_MAGIC, open, record_limit, unpacked_limit};
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
            if self.current.is_none() {
                match OpenFile::new(self.files.next()?, self.topics.as_ref()) {
                    Ok(file) => self.current = Some(file),
                    Err(error) => return Some(Err(error)),
                }
            }
            match self.current.as_mut()?.next(self.topics.as_ref()) {
                Ok(Some(message)) => return Some(Ok(message)),
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
    route: Route<'a>,
    /// Topics and types by channel.
    names: Vec<Option<Names>>,
    n_messages: u64,
    last_log_time_ns: Option<u64>,
}

/// The topic of a channel, its type, and whether its messages are asked for.
type Names = (Arc<str>, Arc<str>, bool);

/// The ways through a file.
enum Route<'a> {
    /// By its index, in order of log time.
    Indexed { reader: Box<IndexedReader>, source: File, packed: Vec<u8>, summary: &'a Summary },
    /// From front to back.
    Linear(Box<Linear>),
    /// It has nothing that is asked for.
    Nothing,
}

impl<'a> OpenFile<'a> {
    fn new(file: &'a BagFile, topics: Option<&BTreeSet<String>>) -> Result<Self, BagError> {
        let route = match &file.summary {
            None => Route::Linear(Box::new(Linear::open(&file.path, Depth::Messages)?)),
            Some(summary) => Route::by_index(file, summary, topics)?,
        };
        Ok(Self { file, route, names: Vec::new(), n_messages: 0, last_log_time_ns: None })
    }

    fn next(&mut self, topics: Option<&BTreeSet<String>>) -> Result<Option<BagMessage>, BagError> {
        loop {
            let read = self.read(topics).map_err(|source| BagError::Incomplete {
                path: self.file.path.clone(),
                n_messages: self.n_messages,
                last_log_time_ns: self.last_log_time_ns,
                source,
            })?;
            let Some((message, is_wanted)) = read else { return Ok(None) };
            self.n_messages += 1;
            self.last_log_time_ns = self.last_log_time_ns.max(Some(message.log_time_ns));
            if is_wanted {
                return Ok(Some(message));
            }
        }
    }

    fn read(
        &mut self,
        topics: Option<&BTreeSet<String>>,
    ) -> McapResult<Option<(BagMessage, bool)>> {
        let Some((header, data)) = self.route.next()? else { return Ok(None) };
        let place = usize::from(header.channel_id);
        if self.names.len() <= place {
            self.names.resize(place + 1, None);
        }
        let names = &mut self.names[place];
        if names.is_none() {
            let channel = self.route.channel(header.channel_id);
            let unknown = McapError::UnknownChannel(header.sequence, header.channel_id);
            let channel = channel.ok_or(unknown)?;
            let type_name = channel.schema.as_ref().map_or("", |schema| schema.name.as_str());
            let is_wanted = topics.is_none_or(|topics| topics.contains(&channel.topic));
            *names = Some((channel.topic.as_str().into(), type_name.into(), is_wanted));
        }
        let (topic, type_name, is_wanted) = names.as_ref().expect("it was just filled");
        let message = BagMessage {
            topic: topic.clone(),
            type_name: type_name.clone(),
            log_time_ns: header.log_time,
            publish_time_ns: header.publish_time,
            sequence: header.sequence,
            bytes: plain(data)?,
        };
        Ok(Some((message, *is_wanted)))
    }
}

impl<'a> Route<'a> {
    fn by_index(
        file: &BagFile,
        summary: &'a Summary,
        topics: Option<&BTreeSet<String>>,
    ) -> Result<Self, BagError> {
        let source = open(&file.path)?;
        let limit = record_limit(&source).map_err(BagError::io("read", &file.path))?;
        let mut options = IndexedReaderOptions::new().with_record_length_limit(limit);
        if let Some(topics) = topics {
            let mut channels = summary.channels.values();
            if !channels.any(|channel| topics.contains(&channel.topic)) {
                return Ok(Self::Nothing);
            }
            options = options.include_topics(topics);
        }
        let reader = IndexedReader::new_with_options(summary, options);
        let reader = reader.map_err(|source| BagError::Incomplete {
            path: file.path.clone(),
            n_messages: 0,
            last_log_time_ns: None,
            source,
        })?;
        Ok(Self::Indexed { reader: Box::new(reader), source, packed: Vec::new(), summary })
    }

    /// The next message and its data.
    fn next(&mut self) -> McapResult<Option<(MessageHeader, Vec<u8>)>> {
        match self {
            Self::Nothing => {}
            Self::Linear(file) => {
                while let Some(record) = file.next()? {
                    match record {
                        Record::Message { header, data } => {
                            return Ok(Some((header, data.into_owned())));
                        }
                        // What follows a whole file's last message need not read.
                        Record::DataEnd(_) => break,
                        _ => {}
                    }
                }
            }
            Self::Indexed { reader, source, packed, .. } => {
                while let Some(event) = reader.next_event() {
                    match event? {
                        IndexedReadEvent::ReadChunkRequest { offset, length } => {
                            source.seek(SeekFrom::Start(offset))?;
                            packed.resize(length, 0);
                            source.read_exact(packed)?;
                            reader.insert_chunk_record_data(offset, packed)?;
                        }
                        IndexedReadEvent::Message { header, data } => {
                            return Ok(Some((header, data.to_vec())));
                        }
                    }
                }
            }
        }
        Ok(None)
    }

    fn channel(&self, id: u16) -> Option<Arc<Channel<'static>>> {
        match self {
            Self::Nothing => None,
            Self::Linear(file) => file.channels.get(id),
            Self::Indexed { summary, .. } => summary.channels.get(&id).cloned(),
        }
    }
}

/// A message without the compression that rosbag2 may have put around it.
///
/// Metadata records whether it did, but a recorder that was killed left none; CDR starts with a zero,
/// so that the two cannot be confused.
///
/// # Errors
///
/// [`McapError::DecompressionError`], also of a message that would take far more room than its
/// bytes explain.
pub fn plain(bytes: Vec<u8>) -> McapResult<Vec<u8>> {
    if !bytes.starts_with(&ZSTD_MAGIC) {
        return Ok(bytes);
    }
    let limit = unpacked_limit(bytes.len());
    let mut unpacked = Vec::new();
    zstd::stream::read::Decoder::new(&*bytes)
        .and_then(|decoder| decoder.take(limit as u64 + 1).read_to_end(&mut unpacked))
        .map_err(|error| McapError::DecompressionError(error.to_string()))?;
    if unpacked.len() > limit {
        let refused = format!("a message of {} bytes holds more than {limit} bytes", bytes.len());
        return Err(McapError::DecompressionError(refused));
    }
    Ok(unpacked)
}
