//! Opens bags: ours, any laboratory's, whole or cut short.

mod file;
mod linear;
mod messages;
mod scan;
mod source;
mod summary;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

pub use messages::{BagMessage, Messages};

use crate::BagError;
use crate::metadata::{self, Contents};
pub(crate) use file::BagFile;
pub(crate) use messages::plain;
pub(crate) use source::{Source, ZSTD_MAGIC, open, read_some, unpacked_limit};
pub(crate) use summary::read as read_summary;

/// A bag that was opened; its messages are still on disk.
#[derive(Debug)]
pub struct Bag {
    path: PathBuf,
    files: Vec<BagFile>,
    contents: Option<Contents>,
    custom_data: BTreeMap<String, String>,
}

/// A topic in a bag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TopicInfo {
    /// Its full name.
    pub name: String,
    /// Its type, such as `std_msgs/msg/Bool`; empty if the bag holds no definition of it.
    pub type_name: String,
    /// How its messages are encoded: `cdr` unless another program than ROS wrote them.
    pub encoding: String,
    /// What its publishers offered, as rosbag2's YAML; empty if it is not in the bag.
    pub offered_qos_profiles: String,
    /// RIHS01 of the type; empty if it is not in the bag.
    pub type_hash: String,
    /// Messages on it, as far as they can be read.
    pub n_messages: u64,
}

/// A file inside a bag.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Attachment {
    /// Its name.
    pub name: String,
    /// What it is, such as `application/yaml`.
    pub media_type: String,
    /// Its content.
    pub data: Vec<u8>,
}

/// Where a bag is not as it was written: it breaks off, or bytes of it have changed.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Damage {
    /// In which file.
    pub path: PathBuf,
    /// Messages of that file that can be read before it.
    pub n_messages: u64,
    /// The latest log time among them, in nanoseconds.
    pub last_log_time_ns: Option<u64>,
    /// The record, by its place in the file, unpacked if rosbag2 compressed it as a whole.
    pub at_byte: u64,
    /// Whether the file ends there, as that of a recorder that was killed; else something in it is
    /// not what was written.
    pub is_end: bool,
    /// What the reader met there.
    pub reason: String,
}

impl Bag {
    /// Opens a bag: a folder as rosbag2 makes it, with or without `metadata.yaml`, or one `.mcap`
    /// file.
    ///
    /// Every file is read through once, against the checksums in it: over the data as a whole, and
    /// where that was left out, over each chunk. What a writer left without any checksum must at
    /// least be records to the last byte, and as many as the file counts. [`Bag::damage`] lists
    /// where that fails.
    ///
    /// # Errors
    ///
    /// [`BagError::Incomplete`] if a file breaks off before its first record ends,
    /// [`BagError::Empty`], [`BagError::NoFiles`], and others for what is no bag or cannot be read.
    ///
    /// # Examples
    ///
    /// ```
    /// use rsrs_bags::{Bag, BagOptions, BagWriter, Sample};
    /// use rsrs_msgs::{cdr, std_msgs::Bool, topics::DETECTION};
    ///
    /// # let place = tempfile::tempdir()?;
    /// # let folder = place.path().join("run_1");
    /// let mut writer = BagWriter::create(&folder, BagOptions::default())?;
    /// let topic = DETECTION.for_robot("robot_1");
    /// let detection = writer.add_topic(&topic, DETECTION.type_name, DETECTION.qos)?;
    /// let data = cdr::encode(&Bool { data: true });
    /// let sample = Sample { log_time_ns: 5, publish_time_ns: 5, sequence: 0, data: &data };
    /// writer.write(detection, sample)?;
    /// writer.finish()?;
    ///
    /// let bag = Bag::open(&folder)?;
    /// let message = bag.messages().next().expect("one was recorded")?;
    /// assert_eq!(&*message.topic, "/robot_1/detection");
    /// assert!(cdr::decode::<Bool>(&message.bytes)?.data);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn open(path: &Path) -> Result<Self, BagError> {
        let (paths, contents) = files_of(path)?;
        let files = paths.into_iter().map(BagFile::open).collect::<Result<Vec<_>, _>>()?;
        let custom_data = contents
            .as_ref()
            .and_then(|contents| contents.custom_data.clone())
            .or_else(|| recorded_custom_data(&files))
            .unwrap_or_default();
        Ok(Self { path: path.to_owned(), files, contents, custom_data })
    }

    pub(crate) fn files(&self) -> &[BagFile] {
        &self.files
    }

    /// The table of contents beside the files, if there is one.
    pub(crate) fn contents(&self) -> Option<&Contents> {
        self.contents.as_ref()
    }

    /// The path it was opened by.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its topics, sorted by name; a topic that two channels share is there twice if they differ in
    /// type or encoding.
    pub fn topics(&self) -> Vec<TopicInfo> {
        let mut topics: Vec<TopicInfo> = Vec::new();
        for topic in self.files.iter().flat_map(|file| &file.topics) {
            let same = topics.iter_mut().find(|known| {
                (&known.name, &known.type_name, &known.encoding)
                    == (&topic.name, &topic.type_name, &topic.encoding)
            });
            match same {
                // A file may claim any number.
                Some(known) => {
                    known.n_messages = known.n_messages.saturating_add(topic.n_messages);
                }
                None => topics.push(topic.clone()),
            }
        }
        topics.sort_by(|a, b| (&a.name, &a.type_name).cmp(&(&b.name, &b.type_name)));
        topics
    }

    /// Where it is not as it was written; empty for a whole bag.
    pub fn damage(&self) -> Vec<Damage> {
        self.files.iter().filter_map(|file| file.damage.clone()).collect()
    }

    /// What is wrong with the summary sections of files whose data are whole: nothing is missing, and
    /// reading from the middle is slow.
    pub fn summary_faults(&self) -> Vec<String> {
        let faults = self.files.iter().filter_map(|file| {
            Some(format!("{}: {}", file.path.display(), file.summary_fault.as_ref()?))
        });
        faults.collect()
    }

    /// Messages that can be read, on all topics.
    pub fn n_messages(&self) -> u64 {
        let topics = self.files.iter().flat_map(|file| &file.topics);
        topics.fold(0, |sum, topic| sum.saturating_add(topic.n_messages))
    }

    /// All messages, file by file, in order of log time where the file has an index and in the
    /// order of recording elsewhere.
    ///
    /// At the end of a file that breaks off comes one [`BagError::Incomplete`], after all that can
    /// be read.
    pub fn messages(&self) -> Messages<'_> {
        Messages::new(&self.files, None)
    }

    /// The messages on some topics (by their full names), in the same order; topics that are not in
    /// the bag are ignored.
    pub fn messages_on<S: Into<String>>(
        &self,
        topics: impl IntoIterator<Item = S>,
    ) -> Messages<'_> {
        Messages::new(&self.files, Some(topics.into_iter().map(Into::into).collect()))
    }

    /// Its attachments, in order.
    pub fn attachments(&self) -> impl Iterator<Item = &Attachment> {
        self.files.iter().flat_map(|file| &file.attachments)
    }

    /// The last attachment of this name.
    pub fn attachment(&self, name: &str) -> Option<&Attachment> {
        self.attachments().filter(|attachment| attachment.name == name).last()
    }

    /// The pairs of the last metadata record of this name.
    pub fn metadata(&self, name: &str) -> Option<&BTreeMap<String, String>> {
        let mut records = self.files.iter().flat_map(|file| &file.metadata);
        records.rfind(|record| record.name == name).map(|record| &record.metadata)
    }

    /// The definition of a type, as the bag has it: its `.msg` text and that of the types in it.
    pub fn schema(&self, type_name: &str) -> Option<&[u8]> {
        self.files.iter().find_map(|file| file.schemas.get(type_name)).map(Vec::as_slice)
    }

    /// The pairs that the recorder was given, out of `metadata.yaml` or else out of the file.
    pub fn custom_data(&self) -> &BTreeMap<String, String> {
        &self.custom_data
    }
}

/// The pairs in the last of rosbag2's own records, for a bag without `metadata.yaml`.
fn recorded_custom_data(files: &[BagFile]) -> Option<BTreeMap<String, String>> {
    let mut records = files.iter().flat_map(|file| &file.metadata);
    let record = records.rfind(|record| record.name == metadata::RECORD)?;
    metadata::read_record(&record.metadata)?.custom_data
}

/// The files of a bag, in order, and its table of contents.
pub(crate) fn files_of(path: &Path) -> Result<(Vec<PathBuf>, Option<Contents>), BagError> {
    let is_folder = path.metadata().map_err(BagError::io("open", path))?.is_dir();
    let contents = if is_folder { metadata::read(path)? } else { None };
    let paths = match &contents {
        Some(contents) => listed_files(path, contents)?,
        None if is_folder => mcap_files_in(path)?,
        None => vec![path.to_owned()],
    };
    if paths.is_empty() {
        return Err(BagError::NoFiles { path: path.to_owned() });
    }
    Ok((paths, contents))
}

/// The files that the table of contents lists.
fn listed_files(folder: &Path, contents: &Contents) -> Result<Vec<PathBuf>, BagError> {
    if contents.storage_identifier == "sqlite3" {
        return Err(BagError::Sqlite { path: folder.to_owned() });
    }
    // Their names alone count: no bag names a file outside of its folder.
    let name = |path: &String| Path::new(path).file_name().unwrap_or_default().to_owned();
    Ok(contents.relative_file_paths.iter().map(|path| present(folder.join(name(path)))).collect())
}

/// A listed file, or the same one with or without the compression around it: rosbag2 unpacks files
/// beside themselves to play them.
fn present(path: PathBuf) -> PathBuf {
    if path.exists() {
        return path;
    }
    let packed = PathBuf::from(format!("{}.zstd", path.display()));
    let unpacked = path.with_extension("");
    let is_packed = path.extension().is_some_and(|extension| extension == "zstd");
    match (is_packed, packed.exists(), unpacked.exists()) {
        (true, _, true) => unpacked,
        (false, true, _) => packed,
        _ => path,
    }
}

/// The `.mcap` files of a folder without table of contents, `run_2.mcap` before `run_10.mcap`.
pub(crate) fn mcap_files_in(folder: &Path) -> Result<Vec<PathBuf>, BagError> {
    let io = BagError::io("list", folder);
    let mut files = Vec::new();
    let mut is_sqlite = false;
    for entry in folder.read_dir().map_err(&io)? {
        let path = entry.map_err(&io)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        is_sqlite |= name.ends_with(".db3") || name.ends_with(".db3.zstd");
        let is_double = || path.with_extension("").exists();
        if name.ends_with(".mcap") || (name.ends_with(".mcap.zstd") && !is_double()) {
            files.push(path);
        }
    }
    if files.is_empty() && is_sqlite {
        return Err(BagError::Sqlite { path: folder.to_owned() });
    }
    files.sort_by_cached_key(|path| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let stem = name.split(".mcap").next().unwrap_or_default().to_owned();
        let (name, number) = stem.rsplit_once('_').unwrap_or((&stem, ""));
        (name.to_owned(), number.parse::<u64>().ok(), stem)
    });
    Ok(files)
}
