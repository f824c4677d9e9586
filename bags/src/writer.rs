//! Records a run into a rosbag2 folder.

mod channel;
mod packing;
mod part;
mod sync;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use rsrs_msgs::topics::Qos;

use crate::BagError;
use crate::definitions::Definition;
use crate::metadata::{self, FileInformation, Information, TopicWithCount};
pub(crate) use channel::ChannelDescription;
pub use packing::{Compression, Packing};
use part::Part;

/// The record in a bag that was full: the limit, and how many messages came after it was reached.
const LIMIT: &str = "rsrs.limit";

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
    /// The first `.mcap` file in it.
    pub file: PathBuf,
    /// All `.mcap` files in it, in order.
    pub files: Vec<PathBuf>,
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
    name: String,
    packing: Packing,
    custom_data: BTreeMap<String, String>,
    topics: Vec<Topic>,
    closed: Vec<FileInformation>,
    paths: Vec<PathBuf>,
    bounds_ns: Option<(u64, u64)>,
    part: Part,
    /// Log time of the last message before which everything was flushed.
    flushed_ns: Option<u64>,
    /// Bytes of the files that are closed.
    closed_bytes: u64,
    /// Messages that came after the bag was full.
    n_refused: u64,
}

/// A topic with its place in the current file.
struct Topic {
    description: ChannelDescription,
    channel_id: u16,
    n_messages: u64,
}

impl BagWriter {
    /// Starts a bag of one file, as [`Packing::default`] has it, in a `folder` that must not exist
    /// and whose name becomes that of the file in it.
    pub fn create(folder: &Path, options: BagOptions) -> Result<Self, BagError> {
        Self::create_packed(folder, options, Packing::default())
    }

    /// Starts a bag that is compressed and split as asked for, in a `folder` that must not exist.
    ///
    /// Files are named after the folder as rosbag2 does it, `run_0.mcap`, `run_1.mcap`, and each
    /// has all topics.
    pub fn create_packed(
        folder: &Path,
        options: BagOptions,
        packing: Packing,
    ) -> Result<Self, BagError> {
        let name = new_folder(folder)?;
        let part = Part::create(folder, format!("{name}_0.mcap"), &packing)?;
        let mut writer = Self {
            folder: folder.to_owned(),
            name,
            packing,
            custom_data: options.custom_data,
            topics: Vec::new(),
            closed: Vec::new(),
            paths: vec![part.path().to_owned()],
            bounds_ns: None,
            part,
            flushed_ns: None,
            closed_bytes: 0,
            n_refused: 0,
        };
        writer.describe(Vec::new())?;
        Ok(writer)
    }

    /// Adds a topic, such as `/robot_3/detection`, with the definition of its type, such as
    /// `std_msgs/msg/Bool`, and what its publisher offers.
    pub fn add_topic(
        &mut self,
        name: &str,
        type_name: &str,
        qos: Qos,
    ) -> Result<ChannelId, BagError> {
        self.refuse_duplicate(name)?;
        let Some(definition) = Definition::of_known_type(type_name) else {
            let (topic, type_name) = (name.to_owned(), type_name.to_owned());
            return Err(BagError::UnknownType { topic, type_name });
        };
        self.add_channel(ChannelDescription::new(name, qos, &definition))
    }

    /// Adds a topic whose type is defined elsewhere, such as in the user's workspace, where
    /// [`crate::definitions::Definitions::find`] found it.
    pub fn add_topic_with_schema(
        &mut self,
        name: &str,
        qos: Qos,
        definition: &Definition,
    ) -> Result<ChannelId, BagError> {
        self.refuse_duplicate(name)?;
        self.add_channel(ChannelDescription::new(name, qos, definition))
    }

    fn refuse_duplicate(&self, name: &str) -> Result<(), BagError> {
        if self.topics.iter().any(|topic| topic.description.topic == name) {
            return Err(BagError::DuplicateTopic { topic: name.to_owned() });
        }
        Ok(())
    }

    /// Adds a topic as it was described; the same one twice is one.
    pub(crate) fn add_channel(
        &mut self,
        description: ChannelDescription,
    ) -> Result<ChannelId, BagError> {
        let known = self.topics.iter().position(|topic| topic.description == description);
        if let Some(known) = known {
            return Ok(ChannelId(known));
        }
        let channel_id = self.part.add_channel(&description)?;
        self.topics.push(Topic { description, channel_id, n_messages: 0 });
        Ok(ChannelId(self.topics.len() - 1))
    }

    /// Records one message.
    ///
    /// # Errors
    ///
    /// [`BagError::Full`] if the bag has the size that [`Packing::max_bag_bytes`] allows; it can
    /// still be closed, and then reports how many messages were refused. [`BagError::Write`], for
    /// instance when the disk is full.
    ///
    /// # Panics
    ///
    /// If `channel` belongs to another bag with more topics.
    pub fn write(&mut self, channel: ChannelId, sample: Sample) -> Result<(), BagError> {
        let time_ns = sample.log_time_ns;
        self.refuse_beyond_limit()?;
        if self.part.is_full(&self.packing, time_ns) {
            self.split()?;
        }
        self.flush_if_due(time_ns)?;
        let topic = &mut self.topics[channel.0];
        self.part.write(topic.channel_id, &sample)?;
        topic.n_messages += 1;
        let (first_ns, last_ns) = self.bounds_ns.unwrap_or((time_ns, time_ns));
        self.bounds_ns = Some((first_ns.min(time_ns), last_ns.max(time_ns)));
        Ok(())
    }

    fn refuse_beyond_limit(&mut self) -> Result<(), BagError> {
        let Some(max_bytes) = self.packing.max_bag_bytes else { return Ok(()) };
        if self.closed_bytes + self.part.n_bytes() < max_bytes {
            return Ok(());
        }
        self.n_refused += 1;
        Err(BagError::Full { path: self.folder.clone(), max_bytes })
    }

    fn flush_if_due(&mut self, time_ns: u64) -> Result<(), BagError> {
        let Some(period_ns) = self.packing.flush_period_ns else { return Ok(()) };
        // A clock that is set back must not keep anything from the disk until it has caught up.
        if self.flushed_ns.is_some_and(|flushed_ns| time_ns.abs_diff(flushed_ns) < period_ns) {
            return Ok(());
        }
        if self.flushed_ns.is_some() {
            self.flush()?;
        }
        self.flushed_ns = Some(time_ns);
        Ok(())
    }

    /// Closes the current file and goes on in the next one.
    fn split(&mut self) -> Result<(), BagError> {
        let file_name = format!("{}_{}.mcap", self.name, self.closed.len() + 1);
        self.describe(self.topics_with_counts())?;
        let next = Part::create(&self.folder, file_name, &self.packing)?;
        let full = std::mem::replace(&mut self.part, next);
        self.closed.push(full.information());
        self.closed_bytes += full.n_bytes();
        self.paths.push(self.part.path().to_owned());
        full.finish()?;
        self.describe(Vec::new())?;
        for topic in &mut self.topics {
            topic.channel_id = self.part.add_channel(&topic.description)?;
        }
        Ok(())
    }

    /// Puts a file into the bag, which other tools list and carry along.
    ///
    /// It is safe on return: the record of how the run was made must not be lost with it.
    pub fn attach(&mut self, name: &str, media_type: &str, data: &[u8]) -> Result<(), BagError> {
        let time_ns = self.bounds_ns.map_or(0, |(_, last_ns)| last_ns);
        self.copy_attachment(&mcap::Attachment {
            log_time: time_ns,
            create_time: time_ns,
            name: name.to_owned(),
            media_type: media_type.to_owned(),
            data: Cow::Borrowed(data),
        })
    }

    /// Puts a file into the bag that another one had.
    pub(crate) fn copy_attachment(
        &mut self,
        attachment: &mcap::Attachment,
    ) -> Result<(), BagError> {
        self.part.attach(attachment)?;
        self.flush()
    }

    /// Puts pairs of strings into the bag, under a name of their own.
    ///
    /// It is safe on return, as with [`BagWriter::attach`].
    pub fn metadata(
        &mut self,
        name: &str,
        pairs: BTreeMap<String, String>,
    ) -> Result<(), BagError> {
        self.part.metadata(name, pairs)?;
        self.flush()
    }

    /// Adds pairs for `metadata.yaml` to those of [`BagOptions::custom_data`]; later ones win.
    pub fn add_custom_data(&mut self, pairs: impl IntoIterator<Item = (String, String)>) {
        self.custom_data.extend(pairs);
    }

    /// Hands everything so far to the system; a crash of this program cannot take it any more.
    ///
    /// [`BagWriter::write`] does it once per second of recorded time.
    pub fn flush(&mut self) -> Result<(), BagError> {
        self.part.flush()
    }

    /// Closes the bag and writes its table of contents; it is on the disk on return.
    pub fn finish(self) -> Result<BagSummary, BagError> {
        self.finish_watched(|_| true)
    }

    /// As [`BagWriter::finish`]. A slow disk takes minutes for what the system has kept for it: `goes_on` is
    /// called now and then with the bytes that may not be on the disk yet. Once it returns `false`, the
    /// rest is left to the system; the bag is whole, unless the power fails.
    pub fn finish_watched(
        mut self,
        mut goes_on: impl FnMut(u64) -> bool,
    ) -> Result<BagSummary, BagError> {
        let topics = self.topics_with_counts();
        let n_messages_of_topic = self.n_messages_of_topic();
        if let (Some(max_bytes), 1..) = (self.packing.max_bag_bytes, self.n_refused) {
            let pairs = [("max_bag_bytes", max_bytes), ("n_refused", self.n_refused)];
            let in_text = pairs.map(|(key, number)| (key.to_owned(), number.to_string()));
            self.metadata(LIMIT, BTreeMap::from(in_text))?;
        }
        let information = self.describe(topics)?;
        self.part.finish()?;
        let n_bytes = |path: &PathBuf| fs::metadata(path).map_or(0, |metadata| metadata.len());
        let mut after: u64 = self.paths.iter().map(n_bytes).sum();
        for path in &self.paths {
            after = after.saturating_sub(n_bytes(path));
            sync::onto_disk(path, |of_file| goes_on(of_file + after))
                .map_err(BagError::io("close", path))?;
        }
        information.write_into(&self.folder)?;
        Ok(BagSummary {
            folder: self.folder,
            file: self.paths[0].clone(),
            files: self.paths,
            n_messages: n_messages_of_topic.values().sum(),
            n_messages_of_topic,
            bounds_ns: self.bounds_ns,
        })
    }

    /// Messages so far, by topic.
    pub(crate) fn n_messages_of_topic(&self) -> BTreeMap<String, u64> {
        let mut of_topic = BTreeMap::new();
        for topic in &self.topics {
            *of_topic.entry(topic.description.topic.clone()).or_default() += topic.n_messages;
        }
        of_topic
    }

    fn topics_with_counts(&self) -> Vec<TopicWithCount> {
        self.topics.iter().map(|topic| topic.description.with_count(topic.n_messages)).collect()
    }

    /// Writes rosbag2's metadata of the bag into the current file.
    ///
    /// On opening, too, as rosbag2 does it: a file that breaks off still has its metadata.
    fn describe(&mut self, topics: Vec<TopicWithCount>) -> Result<Information, BagError> {
        let mut files = self.closed.clone();
        files.push(self.part.information());
        let information = Information::new(files, topics, self.custom_data.clone());
        self.metadata(metadata::RECORD, information.to_record())?;
        Ok(information)
    }
}

/// Makes the folder of a bag, and gives its name.
fn new_folder(folder: &Path) -> Result<String, BagError> {
    let name = folder.file_name().and_then(|name| name.to_str());
    let name = name.ok_or_else(|| BagError::NoName { path: folder.to_owned() })?;
    if let Some(parent) = folder.parent() {
        fs::create_dir_all(parent).map_err(BagError::io("create", parent))?;
    }
    fs::create_dir(folder).map_err(|source| match source.kind() {
        ErrorKind::AlreadyExists => BagError::Exists { path: folder.to_owned() },
        _ => BagError::io("create", folder)(source),
    })?;
    Ok(name.to_owned())
}
