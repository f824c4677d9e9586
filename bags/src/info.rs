//! What is in a bag, at a glance.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rsrs_msgs::topics;
use serde::Serialize;

use crate::metadata::Contents;
use crate::{Bag, Damage, OfferedQos, Recovery, qos};

/// What is in a bag.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BagInfo {
    /// The folder or file that was opened.
    pub path: PathBuf,
    /// Its files, in order.
    pub files: Vec<FileInfo>,
    /// On disk, all files, in bytes.
    pub n_bytes: u64,
    /// First log time, in nanoseconds; `None` without messages.
    pub start_ns: Option<u64>,
    /// Last log time, in nanoseconds; `None` without messages.
    pub end_ns: Option<u64>,
    /// From the first to the last message, in seconds.
    pub duration_s: f64,
    /// Messages on all topics.
    pub n_messages: u64,
    /// Its topics, sorted by name.
    pub topics: Vec<TopicSummary>,
    /// Its attachments, in order.
    pub attachments: Vec<AttachmentInfo>,
    /// Names of its metadata records, in order, each once.
    pub metadata: Vec<String>,
    /// Pairs that the recorder was given.
    pub custom_data: BTreeMap<String, String>,
    /// Version of `metadata.yaml`; `None` if there is no such file, as when a recorder was killed.
    pub metadata_version: Option<u32>,
    /// The distribution of ROS that recorded it, if it is in the bag.
    pub ros_distro: Option<String>,
    /// How the bag is compressed.
    pub compression: CompressionInfo,
    /// Whether the record of one of our experiments is in it.
    pub has_experiment: bool,
    /// Where it is not as it was written; empty for a whole bag.
    pub damage: Vec<Damage>,
    /// What is wrong with summary sections of files whose data are whole.
    pub summary_faults: Vec<String>,
    /// What it lacks, if it was recovered from a damaged bag.
    pub recovery: Option<Recovery>,
}

/// One file of a bag.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FileInfo {
    /// Where it is.
    pub path: PathBuf,
    /// On disk, in bytes.
    pub n_bytes: u64,
    /// Messages in it.
    pub n_messages: u64,
    /// First and last log time, in nanoseconds; `None` without messages.
    pub bounds_ns: Option<(u64, u64)>,
    /// Whether it has an index, which makes playing from the middle fast.
    pub is_indexed: bool,
    /// The program that wrote it.
    pub library: String,
}

/// One topic of a bag.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TopicSummary {
    /// Its full name.
    pub name: String,
    /// Its type, such as `std_msgs/msg/Bool`; empty if the bag holds no definition of it.
    pub type_name: String,
    /// Messages on it.
    pub n_messages: u64,
    /// Messages per second over the whole bag; `None` for a bag of no length.
    pub rate_hz: Option<f64>,
    /// What its publishers offered; empty if it is not in the bag.
    pub offered_qos: Vec<OfferedQos>,
    /// RIHS01 of the type; empty if it is not in the bag.
    pub type_hash: String,
}

/// A file inside a bag.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AttachmentInfo {
    /// Its name.
    pub name: String,
    /// What it is, such as `application/yaml`.
    pub media_type: String,
    /// Its length, in bytes.
    pub n_bytes: usize,
}

/// How a bag is compressed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct CompressionInfo {
    /// Chunks within files: `zstd`, `lz4`, or nothing.
    pub chunks: Vec<String>,
    /// Whether rosbag2 compressed whole files.
    pub files: bool,
    /// Whether rosbag2 compressed single messages, by `metadata.yaml`.
    pub messages: bool,
}

impl Bag {
    /// What is in the bag.
    pub fn info(&self) -> BagInfo {
        let bounds = || self.files().iter().filter_map(|file| file.bounds_ns);
        let start_ns = bounds().map(|(first_ns, _)| first_ns).min();
        let end_ns = bounds().map(|(_, last_ns)| last_ns).max();
        let length_ns =
            end_ns.zip(start_ns).map_or(0, |(end_ns, start_ns)| end_ns.saturating_sub(start_ns));
        let duration_s = length_ns as f64 / 1e9;
        let files: Vec<FileInfo> = self.file_infos();
        let attachments: Vec<AttachmentInfo> = self
            .attachments()
            .map(|attachment| AttachmentInfo {
                name: attachment.name.clone(),
                media_type: attachment.media_type.clone(),
                n_bytes: attachment.data.len(),
            })
            .collect();
        let contents = self.contents();
        BagInfo {
            path: self.path().to_owned(),
            n_bytes: files.iter().map(|file| file.n_bytes).sum(),
            files,
            start_ns,
            end_ns,
            duration_s,
            n_messages: self.n_messages(),
            topics: self.topic_summaries(duration_s),
            has_experiment: self.attachment(topics::EXPERIMENT_ATTACHMENT).is_some()
                || self
                    .topics()
                    .iter()
                    .any(|topic| topic.name == topics::EXPERIMENT.name && topic.n_messages > 0),
            attachments,
            metadata: self.metadata_names(),
            custom_data: self.custom_data().clone(),
            metadata_version: contents.and_then(|contents| contents.version),
            ros_distro: contents.and_then(|contents| contents.ros_distro.clone()),
            compression: self.compression(),
            damage: self.damage(),
            summary_faults: self.summary_faults(),
            recovery: self.recovery(),
        }
    }

    fn file_infos(&self) -> Vec<FileInfo> {
        let files = self.files().iter().map(|file| FileInfo {
            path: file.path.clone(),
            n_bytes: file.n_bytes,
            n_messages: file.topics.iter().map(|topic| topic.n_messages).sum(),
            bounds_ns: file.bounds_ns,
            is_indexed: file.summary.is_some(),
            library: file.library.clone(),
        });
        files.collect()
    }

    fn topic_summaries(&self, duration_s: f64) -> Vec<TopicSummary> {
        let topics = self.topics().into_iter().map(|topic| TopicSummary {
            offered_qos: qos::offered(&topic.offered_qos_profiles),
            rate_hz: (duration_s > 0.0).then(|| topic.n_messages as f64 / duration_s),
            name: topic.name,
            type_name: topic.type_name,
            n_messages: topic.n_messages,
            type_hash: topic.type_hash,
        });
        topics.collect()
    }

    fn metadata_names(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for record in self.files().iter().flat_map(|file| &file.metadata) {
            if !names.contains(&record.name) {
                names.push(record.name.clone());
            }
        }
        names
    }

    fn compression(&self) -> CompressionInfo {
        let mut chunks: Vec<String> = self
            .files()
            .iter()
            .flat_map(|file| &file.compressions)
            .filter(|name| !name.is_empty())
            .cloned()
            .collect();
        chunks.sort();
        chunks.dedup();
        CompressionInfo {
            chunks,
            files: self.files().iter().any(|file| file.is_compressed),
            messages: self.contents().is_some_and(Contents::compresses_messages),
        }
    }
}
