//! Messages out of the files of a bag, one after the other.

use std::collections::BTreeSet;
use std::sync::Arc;

use mcap::records::MessageHeader;
use mcap::{McapError, McapResult};

use super::file::BagFile;
use super::indexed::Indexed;
use super::source::{self, ZSTD_MAGIC, open, record_limit};
use super::table::Table;
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
    known: Vec<(Arc<str>, Arc<str>)>,
}

impl<'a> Messages<'a> {
    pub(super) fn new(files: &'a [BagFile], topics: Option<BTreeSet<String>>) -> Self {
        Self { files: files.iter(), topics, current: None, known: Vec::new() }
    }

    /// Goes to the next message; `None` at the end.
    fn advance(&mut self) -> Option<Result<(), BagError>> {
        loop {
            let Some(current) = &mut self.current else {
                match OpenFile::new(self.files.next()?, self.topics.as_ref()) {
                    Ok(file) => self.current = Some(file),
                    Err(error) => return Some(Err(error)),
                }
                continue;
            };
            match current.advance(&mut self.known) {
                Ok(true) => {
                    let topic = &self.known[current.number].0;
                    if self.topics.as_ref().is_none_or(|topics| topics.contains(&**topic)) {
                        return Some(Ok(()));
                    }
                }
                Ok(false) => self.current = None,
                Err(error) => {
                    self.current = None;
                    return Some(Err(error));
                }
            }
        }
    }

    /// The message that was gone to.
    fn message(&self) -> BagMessage {
        let current = self.current.as_ref().expect("a message was gone to");
        let (topic, type_name) = &self.known[current.number];
        let (header, bytes) = current.message();
        BagMessage {
            topic: topic.clone(),
            type_name: type_name.clone(),
            log_time_ns: header.log_time,
            publish_time_ns: header.publish_time,
            sequence: header.sequence,
            bytes: bytes.to_vec(),
        }
    }
}

impl Iterator for Messages<'_> {
    type Item = Result<BagMessage, BagError>;

    fn next(&mut self) -> Option<Self::Item> {
        match self.advance()? {
            Ok(()) => Some(Ok(self.message())),
            Err(error) => Some(Err(error)),
        }
    }
}

/// A file that is being read.
struct OpenFile<'a> {
    file: &'a BagFile,
    source: Source,
    /// Numbers of topics and types by channel.
    numbers: Vec<Option<usize>>,
    /// That of the message that was gone to.
    number: usize,
    /// That message, if it was compressed by itself.
    unpacked: Option<Vec<u8>>,
    n_messages: u64,
    /// How many there are; `None` for a file that is damaged.
    n_expected: Option<u64>,
    last_log_time_ns: Option<u64>,
}

/// The two ways through a file.
enum Source {
    /// By its table of contents, in order of log time.
    Indexed(Box<Indexed>),
    /// From front to back.
    Linear {
        reader: Box<mcap::io::MessageReader<source::Source>>,
        received: (MessageHeader, Vec<u8>),
    },
}

impl<'a> OpenFile<'a> {
    fn new(file: &'a BagFile, topics: Option<&BTreeSet<String>>) -> Result<Self, BagError> {
        let io = |source| BagError::Io { action: "read", path: file.path.clone(), source };
        let source = match &file.table {
            None => {
                let source = source::Source::open(&file.path)?;
                let options = source.options().map_err(io)?;
                let reader = mcap::io::MessageReader::new_with_options(source, options);
                let none =
                    MessageHeader { channel_id: 0, sequence: 0, log_time: 0, publish_time: 0 };
                let received = (none, Vec::new());
                Source::Linear { reader: Box::new(reader), received }
            }
            Some(table) => {
                let source = open(&file.path)?;
                let limit = record_limit(&source).map_err(io)?;
                let wanted = topics.map(|topics| channels_of(table, topics));
                let indexed = Indexed::new(source, table, wanted.as_deref(), limit);
                let indexed = indexed.map_err(|source| {
                    let path = file.path.clone();
                    BagError::Incomplete { path, n_messages: 0, last_log_time_ns: None, source }
                })?;
                Source::Indexed(Box::new(indexed))
            }
        };
        let n_all = file.topics.iter().map(|topic| topic.n_messages).sum();
        Ok(Self {
            file,
            source,
            numbers: Vec::new(),
            number: 0,
            unpacked: None,
            n_messages: 0,
            n_expected: file.damage.is_none().then_some(n_all),
            last_log_time_ns: None,
        })
    }

    fn advance(&mut self, known: &mut Vec<(Arc<str>, Arc<str>)>) -> Result<bool, BagError> {
        let log_time_ns = self.go_on(known).map_err(|source| BagError::Incomplete {
            path: self.file.path.clone(),
            n_messages: self.n_messages,
            last_log_time_ns: self.last_log_time_ns,
            source,
        })?;
        if log_time_ns.is_some() {
            self.n_messages += 1;
            self.last_log_time_ns = self.last_log_time_ns.max(log_time_ns);
        }
        Ok(log_time_ns.is_some())
    }

    /// Goes to the next message and gives its log time, in nanoseconds.
    fn go_on(&mut self, known: &mut Vec<(Arc<str>, Arc<str>)>) -> McapResult<Option<u64>> {
        self.unpacked = None;
        let channel = match &mut self.source {
            Source::Indexed(reader) => {
                if !reader.advance()? {
                    return Ok(None);
                }
                None
            }
            // What follows a whole file's last message need not read.
            Source::Linear { .. } if Some(self.n_messages) == self.n_expected => return Ok(None),
            Source::Linear { reader, received } => {
                let Some(read) = reader.next().transpose()? else { return Ok(None) };
                let header = MessageHeader {
                    channel_id: read.channel.id,
                    sequence: read.sequence,
                    log_time: read.log_time,
                    publish_time: read.publish_time,
                };
                *received = (header, read.data.into_owned());
                Some(read.channel)
            }
        };
        let (header, bytes) = self.message();
        let (id, sequence, log_time_ns) = (header.channel_id, header.sequence, header.log_time);
        let unpacked =
            if bytes.starts_with(&ZSTD_MAGIC) { Some(plain(bytes.to_vec())?) } else { None };
        self.unpacked = unpacked;
        if let Some(Some(number)) = self.numbers.get(usize::from(id)) {
            self.number = *number;
            return Ok(Some(log_time_ns));
        }
        let table = self.file.table.as_ref();
        let channel = channel.or_else(|| table?.channels.get(&id).cloned());
        let channel = channel.ok_or(McapError::UnknownChannel(sequence, id))?;
        let names = channel_names(&channel);
        self.number = known.iter().position(|known| *known == names).unwrap_or_else(|| {
            known.push(names);
            known.len() - 1
        });
        self.numbers.resize(self.numbers.len().max(usize::from(id) + 1), None);
        self.numbers[usize::from(id)] = Some(self.number);
        Ok(Some(log_time_ns))
    }

    /// The message that was gone to.
    fn message(&self) -> (MessageHeader, &[u8]) {
        let (header, bytes) = match &self.source {
            Source::Indexed(reader) => reader.received(),
            Source::Linear { received: (header, bytes), .. } => (*header, &**bytes),
        };
        (header, self.unpacked.as_deref().unwrap_or(bytes))
    }
}

/// The channels of some topics.
fn channels_of(table: &Table, topics: &BTreeSet<String>) -> Vec<u16> {
    let wanted = table.channels.iter().filter(|(_, channel)| topics.contains(&channel.topic));
    wanted.map(|(id, _)| *id).collect()
}

fn channel_names(channel: &mcap::Channel) -> (Arc<str>, Arc<str>) {
    let type_name = channel.schema.as_ref().map_or("", |schema| schema.name.as_str());
    (channel.topic.as_str().into(), type_name.into())
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
