//! One `.mcap` file: what is in it, by its summary section or by reading it through.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use mcap::records;
use mcap::{Channel, McapError, Summary};

use super::linear::Depth;
use super::scan::{Fault, Part, Scan};
use super::source::{Source, check_magic, open};
use super::summary;
use super::{Attachment, Damage, TopicInfo};
use crate::{BagError, qos};

/// An `.mcap` file and what was learned of it on opening.
#[derive(Debug)]
pub struct BagFile {
    pub path: PathBuf,
    pub n_bytes: u64,
    pub library: String,
    /// Its summary section, if that is there and leads to all messages.
    pub summary: Option<Summary>,
    pub topics: Vec<TopicInfo>,
    /// The definitions of types, by type.
    pub schemas: BTreeMap<String, Vec<u8>>,
    pub attachments: Vec<Attachment>,
    pub metadata: Vec<records::Metadata>,
    /// First and last log time, in nanoseconds.
    pub bounds_ns: Option<(u64, u64)>,
    pub compressions: BTreeSet<String>,
    /// Whether rosbag2 compressed it as a whole.
    pub is_compressed: bool,
    /// Where its data are not as they were written.
    pub damage: Option<Damage>,
    /// What is wrong with its summary section, if its data are whole.
    pub summary_fault: Option<String>,
}

impl BagFile {
    /// Finds what is in a file.
    ///
    /// Where checksums vouch for the whole file, chunks are counted by its summary section and not
    /// looked into. What has no checksum must show by itself that it is whole, to the last record.
    pub fn open(path: PathBuf) -> Result<Self, BagError> {
        let mut source = Source::open(&path)?;
        check_magic(&mut source, &path)?;
        let mut file = open(&path)?;
        let n_bytes = file.metadata().map_err(BagError::io("read", &path))?.len();
        let is_compressed = source.is_compressed();
        let summary = if is_compressed { None } else { summary::read(&mut file) };
        let scan = Scan::new(&path, Depth::Chunks)?;
        let library = library(&path, &scan)?;
        let is_indexed = summary.as_ref().is_some_and(|summary| scan.is_indexed_by(summary));
        let mut opened = Self {
            path,
            n_bytes,
            library,
            summary: None,
            topics: Vec::new(),
            schemas: BTreeMap::new(),
            attachments: Vec::new(),
            metadata: Vec::new(),
            bounds_ns: None,
            compressions: BTreeSet::new(),
            is_compressed,
            damage: None,
            summary_fault: None,
        };
        match summary {
            Some(summary) if is_indexed && scan.is_sound() => opened.by_summary(summary, scan),
            summary => {
                let scan = Scan::new(&opened.path, Depth::Messages)?;
                opened.by_reading(summary, scan);
            }
        }
        Ok(opened)
    }

    fn by_summary(&mut self, summary: Summary, scan: Scan) {
        let stats = summary.stats.as_ref();
        let counts = stats.map(|stats| &stats.channel_message_counts);
        for (id, channel) in summary.channels.iter().collect::<BTreeMap<_, _>>() {
            let n_messages = counts.and_then(|counts| counts.get(id)).copied();
            self.add_channel(channel, n_messages.unwrap_or(0));
        }
        self.bounds_ns = stats
            .filter(|stats| stats.message_count > 0)
            .map(|stats| (stats.message_start_time, stats.message_end_time));
        self.take(scan);
        self.summary = Some(summary);
    }

    fn by_reading(&mut self, summary: Option<Summary>, scan: Scan) {
        let is_counted = summary.as_ref().is_none_or(|summary| scan.counts_are_of(summary));
        let fault = match &scan.data {
            Part::Damaged(fault) => Some(fault.clone()),
            Part::WithoutChecksum if !is_counted => Some(Fault {
                at_byte: self.n_bytes,
                reason: "its messages are not as many as its summary section counts".to_owned(),
                is_end: false,
            }),
            Part::Sound | Part::WithoutChecksum => None,
        };
        let is_whole = fault.is_none();
        self.damage = fault.map(|fault| Damage {
            path: self.path.clone(),
            n_messages: scan.found.counts.values().sum(),
            last_log_time_ns: scan.found.bounds_ns.map(|(_, last_ns)| last_ns),
            at_byte: fault.at_byte,
            is_end: fault.is_end,
            reason: fault.reason,
        });
        if let (true, Part::Damaged(fault)) = (is_whole, &scan.summary) {
            self.summary_fault = Some(fault.reason.clone());
        }
        for (id, count) in &scan.found.counts {
            if let Some(channel) = scan.channels.get(*id) {
                self.add_channel(&channel, *count);
            }
        }
        self.bounds_ns = scan.found.bounds_ns;
        self.summary = summary
            .filter(|summary| is_whole && is_counted && scan.is_indexed_by(summary))
            .map(without_channels_of_chunks);
        self.take(scan);
    }

    fn take(&mut self, scan: Scan) {
        self.compressions = scan.compressions;
        self.attachments = scan.found.attachments;
        self.metadata = scan.found.metadata;
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

/// The program that wrote a file of ROS 2.
fn library(path: &Path, scan: &Scan) -> Result<String, BagError> {
    let path = path.to_owned();
    match &scan.found.header {
        // Some writers leave it out.
        Some(header) if ["ros2", ""].contains(&&*header.profile) => Ok(header.library.clone()),
        Some(header) => Err(BagError::Profile { path, found: header.profile.clone() }),
        None => {
            let source = McapError::UnexpectedEof;
            Err(BagError::Incomplete { path, n_messages: 0, last_log_time_ns: None, source })
        }
    }
}

/// A summary whose index does not list the channels of a chunk: where no checksum covers it,
/// only the content of the chunk does.
fn without_channels_of_chunks(mut summary: Summary) -> Summary {
    for index in &mut summary.chunk_indexes {
        index.message_index_offsets.clear();
    }
    summary
}
