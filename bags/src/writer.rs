//! Records a run into a rosbag2 folder.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufWriter, ErrorKind};
use std::path::{Path, PathBuf};

use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use rsrs_msgs::schema;
use rsrs_msgs::topics::Qos;

use crate::BagError;
use crate::metadata::{Information, TopicMetadata, TopicWithCount};
use crate::qos::offered_qos_profiles;

/// After so much recorded time everything so far is handed to the system.
const FLUSH_PERIOD_NS: u64 = 1_000_000_000;

/// The record that rosbag2 keeps its own metadata in.
const ROSBAG2_RECORD: &str = "rosbag2";

/// What a bag holds besides messages.
#[derive(Clone, Debug, Default)]
pub struct BagOptions {
    /// Pairs for `metadata.yaml`, which `ros2 bag info` shows and `ros2 bag convert` keeps.
    pub custom_data: BTreeMap<String, String>,
}

/// A topic of one [`BagWriter`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ChannelId(usize);

/// One message as it goes into a bag.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// When it was received, in nanoseconds; in lockstep, the simulated time.
    pub log_time_ns: u64,
    /// When it was sent, in nanoseconds.
    pub publish_time_ns: u64,
    /// The sender's count; 0 if unknown, as rosbag2 writes it.
    pub sequence: u32,
    /// CDR with its 4 bytes of encapsulation.
    pub data: &'a [u8],
}

/// What was recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BagSummary {
    /// The folder.
    pub folder: PathBuf,
    /// The `.mcap` file in it.
    pub file: PathBuf,
    /// Messages on all topics.
    pub n_messages: u64,
    /// Messages by topic.
    pub n_messages_of_topic: BTreeMap<String, u64>,
    /// First and last log time, in nanoseconds; `None` without messages.
    pub bounds_ns: Option<(u64, u64)>,
}

/// A bag that is being recorded.
///
/// Everything but the last second of recorded time survives `kill -9`. A writer that is dropped
/// without [`BagWriter::finish`] leaves an `.mcap` file without `metadata.yaml`, by which a reader
/// sees that the run did not end as planned.
pub struct BagWriter {
    folder: PathBuf,
    file: PathBuf,
    file_name: String,
    writer: Writer<BufWriter<File>>,
    topics: Vec<Topic>,
    bounds_ns: Option<(u64, u64)>,
    next_flush_ns: Option<u64>,
    options: BagOptions,
}

/// A topic with its place in the file.
struct Topic {
    channel_id: u16,
    information: TopicWithCount,
}

impl BagWriter {
    /// Starts a bag.
    ///
    /// # Arguments
    ///
    /// * `folder` — where; it must not exist, and its name becomes that of the file in it.
    ///
    /// # Errors
    ///
    /// [`BagError::Exists`], [`BagError::NoName`], [`BagError::Io`] and [`BagError::Write`].
    pub fn create(folder: &Path, options: BagOptions) -> Result<Self, BagError> {
        let name = folder.file_name().and_then(|name| name.to_str());
        let name = name.ok_or_else(|| BagError::NoName { path: folder.to_owned() })?;
        let io = |action, path: &Path| {
            let path = path.to_owned();
            move |source| BagError::Io { action, path, source }
        };
        if let Some(parent) = folder.parent() {
            fs::create_dir_all(parent).map_err(io("create", parent))?;
        }
        fs::create_dir(folder).map_err(|source| match source.kind() {
            ErrorKind::AlreadyExists => BagError::Exists { path: folder.to_owned() },
            _ => io("create", folder)(source),
        })?;

        let file_name = format!("{name}_0.mcap");
        let path = folder.join(&file_name);
        let file = File::create_new(&path).map_err(io("create", &path))?;
        let writer = WriteOptions::new()
            .profile("ros2")
            .library(concat!("rsrs ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            // Chunks of a second are small; threads of their own would cost more than they save.
            .compression_threads(0)
            .create(BufWriter::new(file))
            .map_err(|source| BagError::Write { path: path.clone(), source })?;
        Ok(Self {
            folder: folder.to_owned(),
            file: path,
            file_name,
            writer,
            topics: Vec::new(),
            bounds_ns: None,
            next_flush_ns: None,
            options,
        })
    }

    /// Adds a topic, with the definition of its type.
    ///
    /// # Arguments
    ///
    /// * `name` — its full name, such as `/robot_3/detection`.
    /// * `type_name` — such as `std_msgs/msg/Bool`.
    /// * `qos` — what its publisher offers.
    ///
    /// # Errors
    ///
    /// [`BagError::UnknownType`], [`BagError::DuplicateTopic`] and [`BagError::Write`].
    pub fn add_topic(
        &mut self,
        name: &str,
        type_name: &str,
        qos: Qos,
    ) -> Result<ChannelId, BagError> {
        if self.topics.iter().any(|topic| topic.information.topic_metadata.name == name) {
            return Err(BagError::DuplicateTopic { topic: name.to_owned() });
        }
        let (Some(text), Some(hash)) =
            (schema::schema_text(type_name), schema::type_hash(type_name))
        else {
            let (topic, type_name) = (name.to_owned(), type_name.to_owned());
            return Err(BagError::UnknownType { topic, type_name });
        };
        let qos = offered_qos_profiles(qos);
        let channel_metadata = BTreeMap::from([
            ("offered_qos_profiles".to_owned(), qos.clone()),
            ("topic_type_hash".to_owned(), hash.to_owned()),
        ]);
        let added =
            self.writer.add_schema(type_name, "ros2msg", text.as_bytes()).and_then(|schema_id| {
                self.writer.add_channel(schema_id, name, "cdr", &channel_metadata)
            });
        let channel_id = added.map_err(|source| self.write_error(source))?;

        let topic_metadata = TopicMetadata {
            name: name.to_owned(),
            r#type: type_name.to_owned(),
            serialization_format: "cdr",
            offered_qos_profiles: qos,
            type_description_hash: hash.to_owned(),
        };
        let information = TopicWithCount { topic_metadata, message_count: 0 };
        self.topics.push(Topic { channel_id, information });
        Ok(ChannelId(self.topics.len() - 1))
    }

    /// Records one message.
    ///
    /// # Errors
    ///
    /// [`BagError::Write`], for instance when the disk is full.
    ///
    /// # Panics
    ///
    /// If `channel` belongs to another bag with more topics.
    pub fn write(&mut self, channel: ChannelId, sample: Sample) -> Result<(), BagError> {
        let time_ns = sample.log_time_ns;
        match self.next_flush_ns {
            Some(due_ns) if time_ns >= due_ns => {
                self.flush()?;
                self.next_flush_ns = Some(time_ns.saturating_add(FLUSH_PERIOD_NS));
            }
            Some(_) => {}
            None => self.next_flush_ns = Some(time_ns.saturating_add(FLUSH_PERIOD_NS)),
        }

        let topic = &mut self.topics[channel.0];
        let header = MessageHeader {
            channel_id: topic.channel_id,
            sequence: sample.sequence,
            log_time: time_ns,
            publish_time: sample.publish_time_ns,
        };
        let written = self.writer.write_to_known_channel(&header, sample.data);
        written.map_err(|source| BagError::Write { path: self.file.clone(), source })?;
        topic.information.message_count += 1;
        let (first_ns, last_ns) = self.bounds_ns.unwrap_or((time_ns, time_ns));
        self.bounds_ns = Some((first_ns.min(time_ns), last_ns.max(time_ns)));
        Ok(())
    }

    /// Puts a file into the bag, which other tools list and carry along.
    ///
    /// It is safe on return: what says how the run was made must not die with it.
    ///
    /// # Errors
    ///
    /// [`BagError::Write`].
    pub fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<(), BagError> {
        let time_ns = self.bounds_ns.map_or(0, |(_, last_ns)| last_ns);
        let attachment = mcap::Attachment {
            log_time: time_ns,
            create_time: time_ns,
            name: name.to_owned(),
            media_type: media_type.to_owned(),
            data: Cow::Borrowed(data),
        };
        self.writer.attach(&attachment).map_err(|source| self.write_error(source))?;
        self.flush()
    }

    /// Puts pairs of strings into the bag, under a name of their own.
    ///
    /// It is safe on return, as with [`BagWriter::attach`].
    ///
    /// # Errors
    ///
    /// [`BagError::Write`].
    pub fn metadata(
        &mut self,
        name: &str,
        pairs: BTreeMap<String, String>,
    ) -> Result<(), BagError> {
        let record = mcap::records::Metadata { name: name.to_owned(), metadata: pairs };
        self.writer.write_metadata(&record).map_err(|source| self.write_error(source))?;
        self.flush()
    }

    /// Hands everything so far to the system; a crash of this program cannot take it any more.
    ///
    /// [`BagWriter::write`] does it once per second of recorded time.
    ///
    /// # Errors
    ///
    /// [`BagError::Write`].
    pub fn flush(&mut self) -> Result<(), BagError> {
        self.writer.flush().map_err(|source| self.write_error(source))
    }

    /// Closes the bag and writes its table of contents.
    ///
    /// # Errors
    ///
    /// [`BagError::Write`] and [`BagError::Io`].
    pub fn finish(mut self) -> Result<BagSummary, BagError> {
        let topics: Vec<TopicWithCount> =
            self.topics.iter().map(|topic| topic.information.clone()).collect();
        let n_messages_of_topic: BTreeMap<String, u64> = topics
            .iter()
            .map(|topic| (topic.topic_metadata.name.clone(), topic.message_count))
            .collect();
        let custom_data = std::mem::take(&mut self.options.custom_data);
        let information = Information::new(&self.file_name, self.bounds_ns, topics, custom_data);

        let own_record =
            BTreeMap::from([("serialized_metadata".to_owned(), information.to_yaml())]);
        self.metadata(ROSBAG2_RECORD, own_record)?;
        self.writer.finish().map_err(|source| self.write_error(source))?;
        let Self { writer, folder, file, bounds_ns, .. } = self;
        let synced = writer
            .into_inner()
            .into_inner()
            .map_err(std::io::IntoInnerError::into_error)
            .and_then(|file| file.sync_all());
        synced.map_err(|source| BagError::Io { action: "close", path: file.clone(), source })?;
        information.write_into(&folder)?;
        let n_messages = n_messages_of_topic.values().sum();
        Ok(BagSummary { folder, file, n_messages, n_messages_of_topic, bounds_ns })
    }

    fn write_error(&self, source: mcap::McapError) -> BagError {
        BagError::Write { path: self.file.clone(), source }
    }
}
