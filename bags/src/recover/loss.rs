//! What could not be saved.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Serialize;

/// What kind of thing was lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LossKind {
    /// A chunk that fails its checksum or does not decompress.
    Chunk,
    /// The end of a chunk; its beginning was saved as far as possible.
    EndOfChunk,
    /// Bytes that are no records; recording goes on behind them.
    Garbage,
    /// An attachment or a metadata record that fails its checksum.
    Record,
    /// Messages of a channel whose definition is lost.
    Messages,
    /// The end of the file, with whatever the recorder had not yet written.
    EndOfFile,
    /// The file's own table of contents, and nothing that was recorded.
    TableOfContents,
    /// The file fails its checksum, at an unknown place: what was saved may be wrong.
    Unlocated,
    /// A whole file.
    File,
}

/// Something that could not be saved.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Loss {
    /// The file.
    pub path: PathBuf,
    /// Where it starts in the file, unpacked if rosbag2 compressed it as a whole.
    pub at_byte: u64,
    /// How long it is.
    pub n_bytes: u64,
    /// What it was.
    pub kind: LossKind,
    /// What is wrong with it.
    pub reason: String,
    /// Messages in it, if the index behind it has them.
    pub n_messages: Option<u64>,
    /// First and last log time in it, in nanoseconds, if the file has it.
    pub bounds_ns: Option<(u64, u64)>,
}

impl Loss {
    /// Whether recording may have gone on behind it.
    pub fn is_of_the_end(&self) -> bool {
        matches!(self.kind, LossKind::EndOfFile | LossKind::EndOfChunk | LossKind::File)
    }
}

/// Whether everything that was recorded was saved.
pub fn is_complete(losses: &[Loss], lost: &LostMessages) -> bool {
    let is_recorded = |loss: &Loss| loss.kind != LossKind::TableOfContents;
    lost.is_exact && lost.total() == 0 && !losses.iter().any(is_recorded)
}

/// Messages that could not be saved.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LostMessages {
    /// By topic, as far as the file shows.
    pub of_topic: BTreeMap<String, u64>,
    /// Whether that is all of them; else there may be more.
    pub is_exact: bool,
}

impl LostMessages {
    /// All that are known of.
    pub fn total(&self) -> u64 {
        self.of_topic.values().sum()
    }

    /// What is missing of what was counted while recording.
    pub(super) fn against(expected: &BTreeMap<String, u64>, saved: &BTreeMap<String, u64>) -> Self {
        let missing = expected.iter().filter_map(|(topic, n_expected)| {
            let n_saved = saved.get(topic).copied().unwrap_or(0);
            let n_missing = n_expected.saturating_sub(n_saved);
            (n_missing > 0).then(|| (topic.clone(), n_missing))
        });
        Self { of_topic: missing.collect(), is_exact: true }
    }

    /// Adds those of another file.
    pub(super) fn add(&mut self, other: Self) {
        for (topic, n_messages) in other.of_topic {
            *self.of_topic.entry(topic).or_default() += n_messages;
        }
        self.is_exact &= other.is_exact;
    }
}
