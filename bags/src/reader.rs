//! Opens bags: ours, any laboratory's, whole or cut short.

mod file;
mod messages;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

pub use messages::{BagMessage, Messages};

use crate::{BagError, metadata};
use file::BagFile;

/// A bag that was opened; its messages are still on disk.
#[derive(Debug)]
pub struct Bag {
    path: PathBuf,
    files: Vec<BagFile>,
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
    /// What its publishers offered, as rosbag2's YAML; empty if the bag does not say.
    pub offered_qos_profiles: String,
    /// RIHS01 of the type; empty if the bag does not say.
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

/// Where a bag breaks off.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// In which file.
    pub path: PathBuf,
    /// Messages of that file before the break.
    pub n_messages: u64,
    /// The latest log time among them, in nanoseconds.
    pub last_log_time_ns: Option<u64>,
    /// What the reader met there.
    pub reason: String,
}

impl Bag {
    /// Opens a bag.
    ///
    /// A file without its end is read through once here, so that [`Bag::topics`] and
    /// [`Bag::damage`] know what can be had.
    ///
    /// # Arguments
    ///
    /// * `path` — a folder as rosbag2 makes it, with or without `metadata.yaml`, or one `.mcap`
    ///   file.
    ///
    /// # Errors
    ///
    /// [`BagError::Io`], [`BagError::NoFiles`], [`BagError::Metadata`], [`BagError::Empty`],
    /// [`BagError::NotMcap`], [`BagError::Profile`], and [`BagError::Incomplete`] if a file breaks
    /// off before its first record ends.
    pub fn open(path: &Path) -> Result<Self, BagError> {
        let is_folder = path
            .metadata()
            .map_err(|source| BagError::Io { action: "open", path: path.to_owned(), source })?
            .is_dir();
        let contents = if is_folder { metadata::read(path)? } else { None };
        let (paths, custom_data) = match contents {
            Some(contents) => {
                let files = contents.relative_file_paths.iter().map(|file| path.join(file));
                (files.collect(), contents.custom_data.unwrap_or_default())
            }
            None if is_folder => (mcap_files_in(path)?, BTreeMap::new()),
            None => (vec![path.to_owned()], BTreeMap::new()),
        };
        if paths.is_empty() {
            return Err(BagError::NoFiles { path: path.to_owned() });
        }
        let files = paths.into_iter().map(BagFile::open).collect::<Result<_, _>>()?;
        Ok(Self { path: path.to_owned(), files, custom_data })
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
                Some(known) => known.n_messages += topic.n_messages,
                None => topics.push(topic.clone()),
            }
        }
        topics.sort_by(|a, b| (&a.name, &a.type_name).cmp(&(&b.name, &b.type_name)));
        topics
    }

    /// Where it breaks off; empty for a whole bag.
    pub fn damage(&self) -> Vec<Damage> {
        self.files.iter().filter_map(|file| file.damage.clone()).collect()
    }

    /// Messages that can be read, on all topics.
    pub fn n_messages(&self) -> u64 {
        self.files.iter().flat_map(|file| &file.topics).map(|topic| topic.n_messages).sum()
    }

    /// All messages, file by file, in order of log time where the file has an index and in the
    /// order of recording elsewhere.
    ///
    /// At the end of a file that breaks off comes one [`BagError::Incomplete`], after all that can
    /// be read.
    pub fn messages(&self) -> Messages<'_> {
        Messages::new(&self.files, None)
    }

    /// The messages on some topics, in the same order.
    ///
    /// # Arguments
    ///
    /// * `topics` — full names; those that are not in the bag are ignored.
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

    /// The pairs that the recorder was given, out of `metadata.yaml`.
    pub fn custom_data(&self) -> &BTreeMap<String, String> {
        &self.custom_data
    }
}

/// The `.mcap` files of a folder without table of contents, `run_2.mcap` before `run_10.mcap`.
fn mcap_files_in(folder: &Path) -> Result<Vec<PathBuf>, BagError> {
    let io = |source| BagError::Io { action: "list", path: folder.to_owned(), source };
    let mut files = Vec::new();
    for entry in folder.read_dir().map_err(io)? {
        let path = entry.map_err(io)?.path();
        if path.extension().is_some_and(|extension| extension == "mcap") {
            files.push(path);
        }
    }
    files.sort_by_cached_key(|path| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let (name, number) = stem.rsplit_once('_').unwrap_or((&stem, ""));
        (name.to_owned(), number.parse::<u64>().ok(), stem)
    });
    Ok(files)
}
