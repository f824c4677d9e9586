//! Saves what can be saved of a bag that was cut, damaged or never closed.
//!
//! The damaged bag is left as it is; a new one is written beside it, compressed as the old one. What
//! the reader reads goes into it, and where the reader ends, the next record is looked for. Nothing is
//! made up: of a chunk that fails its checksum no message is taken.

mod loss;
mod recovery;
mod scan;
mod search;
mod sink;

use std::collections::BTreeMap;
use std::error::Error;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use mcap::Summary;
use serde::Serialize;
use tempfile::NamedTempFile;

pub use loss::{Loss, LossKind, LostMessages};
pub use recovery::Recovery;

use crate::metadata::Contents;
use crate::reader::{Source, files_of, open, read_summary, unpacked_limit};
use crate::{BagError, BagSummary, Compression};
use scan::RecoveryFindings;
use sink::Sink;

/// What was saved, and what was not.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Recovered {
    /// The new bag.
    pub folder: PathBuf,
    /// Messages in it.
    pub n_messages: u64,
    /// Messages in it, by topic.
    pub n_messages_of_topic: BTreeMap<String, u64>,
    /// First and last log time in it, in nanoseconds; `None` without messages.
    pub bounds_ns: Option<(u64, u64)>,
    /// Attachments in it.
    pub n_attachments: u64,
    /// Metadata records in it, without those that every bag has.
    pub n_metadata: u64,
    /// What could not be saved, in the order of the files; empty for a bag that was whole.
    pub losses: Vec<Loss>,
    /// Messages that could not be saved.
    pub lost: LostMessages,
}

impl Recovered {
    /// Bytes of the old bag of which nothing was saved.
    pub fn n_bytes_lost(&self) -> u64 {
        self.losses.iter().map(|loss| loss.n_bytes).sum()
    }

    /// Whether everything that was recorded is in the new bag.
    pub fn is_complete(&self) -> bool {
        loss::is_complete(&self.losses, &self.lost)
    }
}

/// Saves a bag into a new one beside it, `run` into `run_recovered`.
pub fn recover(path: &Path) -> Result<Recovered, BagError> {
    recover_into(path, &recovered_name(path)?, None)
}

/// Where [`recover`] puts the new bag.
pub fn recovered_name(path: &Path) -> Result<PathBuf, BagError> {
    let name = path.file_name().and_then(|name| name.to_str());
    let name = name.ok_or_else(|| BagError::NoName { path: path.to_owned() })?;
    let stem = name.split(".mcap").next().unwrap_or(name);
    Ok(path.with_file_name(format!("{stem}_recovered")))
}

/// Saves a bag, a folder as rosbag2 makes it or one `.mcap` file, into a new one in a `folder` that
/// must not exist.
///
/// Messages, attachments and metadata records go into one file, in the order in which they were
/// recorded. Whole files and messages that rosbag2 compressed are unpacked: a whole file to at most
/// `unpack_limit` bytes, by default 64 times its size, and 64 MiB in any case.
///
/// # Errors
///
/// [`BagError::Exists`], [`BagError::TooLarge`] beyond that limit, [`BagError::NothingSaved`], and
/// others for what is no bag, cannot be read, or cannot be written.
pub fn recover_into(
    path: &Path,
    folder: &Path,
    unpack_limit: Option<u64>,
) -> Result<Recovered, BagError> {
    if folder.exists() {
        return Err(BagError::Exists { path: folder.to_owned() });
    }
    let (paths, contents) = match files_of(path) {
        // A damaged table of contents is not needed.
        Err(BagError::Metadata { .. }) => (crate::reader::mcap_files_in(path)?, None),
        found => found?,
    };
    let mut sink = Sink::new(folder.to_owned());
    if let Some(contents) = &contents {
        sink.add_custom_data(contents.custom_data.clone().unwrap_or_default());
        // Messages that were compressed one by one are unpacked.
        let is_by_message = contents.compresses_messages();
        sink.compression = is_by_message.then_some(Compression::Zstd);
    }
    let mut losses = Vec::new();
    let mut lost = LostMessages { is_exact: true, ..LostMessages::default() };
    let mut is_closed = true;
    for file in &paths {
        match salvage(file, folder, unpack_limit, &mut sink) {
            Ok((found, lost_of_file)) => {
                losses.extend(found.losses);
                lost.add(lost_of_file);
                is_closed &= found.is_closed;
            }
            Err(error) if paths.len() == 1 || is_of_writing(&error) => return Err(error),
            Err(error) => {
                losses.push(whole_file(file, &error));
                lost.is_exact = false;
            }
        }
    }
    if !lost.is_exact {
        lost = by_table_of_contents(contents.as_ref(), &sink.n_messages_of_topic()).unwrap_or(lost);
    }
    if losses.is_empty() && is_closed {
        // Nothing was recorded, and nothing is lost of it.
        sink.keep_empty()?;
    }
    sink.describe(&losses, &lost)?;
    let (n_attachments, n_metadata) = (sink.n_attachments, sink.n_metadata);
    let Some(summary) = sink.finish()? else {
        return Err(BagError::NothingSaved { path: path.to_owned() });
    };
    let BagSummary { folder, n_messages, n_messages_of_topic, bounds_ns, .. } = summary;
    Ok(Recovered {
        folder,
        n_messages,
        n_messages_of_topic,
        bounds_ns,
        n_attachments,
        n_metadata,
        losses,
        lost,
    })
}

/// Saves one file; gives what was found in it, and which messages are lost of it.
fn salvage(
    path: &Path,
    folder: &Path,
    unpack_limit: Option<u64>,
    sink: &mut Sink,
) -> Result<(RecoveryFindings, LostMessages), BagError> {
    let io = BagError::io("read", path);
    let source = Source::open(path)?;
    let unpacked = match source {
        Source::Plain(_) => None,
        Source::Zstd(decoder) => {
            let n_packed = path.metadata().map_err(&io)?.len();
            let believed = unpacked_limit(usize::try_from(n_packed).unwrap_or(usize::MAX)) as u64;
            let limit_bytes = unpack_limit.unwrap_or(believed);
            let too_large = || BagError::TooLarge { path: path.to_owned(), n_packed, limit_bytes };
            Some(unpack(decoder, folder, limit_bytes)?.ok_or_else(too_large)?)
        }
    };
    let mut file = open(unpacked.as_ref().map_or(path, |unpacked| unpacked.path()))?;
    if file.metadata().map_err(&io)?.len() == 0 {
        return Err(BagError::Empty { path: path.to_owned() });
    }
    // A damaged summary section is as good as none.
    let summary = read_summary(&mut file);
    let expected = summary.as_ref().and_then(counted);
    sink.next_file(summary);
    let mut found = scan::scan(path, file, sink)?;
    if let Some(found) = found.profile.take_if(|profile| profile == "ros1") {
        return Err(BagError::Profile { path: path.to_owned(), found });
    }
    if !found.has_records {
        return Err(BagError::NotMcap { path: path.to_owned() });
    }
    let lost = if let Some(expected) = expected {
        LostMessages::against(&sink.by_topic(&expected), &sink.saved())
    } else {
        let is_known = |loss: &Loss| loss.n_messages.is_some();
        let is_exact = found.is_closed && found.losses.iter().all(is_known);
        LostMessages { of_topic: std::mem::take(&mut found.missing), is_exact }
    };
    Ok((found, lost))
}

/// Messages by channel, as the recorder counted them; `None` if its counts disagree.
fn counted(summary: &Summary) -> Option<BTreeMap<u16, u64>> {
    let stats = summary.stats.as_ref()?;
    let counts = &stats.channel_message_counts;
    let total = counts.values().try_fold(0_u64, |sum, count| sum.checked_add(*count));
    let is_known = counts.keys().all(|id| summary.channels.contains_key(id));
    (total == Some(stats.message_count) && is_known).then(|| counts.clone())
}

/// What is missing of the messages that `metadata.yaml` names.
fn by_table_of_contents(
    contents: Option<&Contents>,
    saved: &BTreeMap<String, u64>,
) -> Option<LostMessages> {
    let topics = &contents?.topics_with_message_count;
    let expected = topics
        .iter()
        .map(|topic| (topic.topic_metadata.name.clone(), topic.message_count))
        .collect::<BTreeMap<_, _>>();
    let lost = LostMessages::against(&expected, saved);
    (!expected.is_empty()).then_some(lost)
}

fn whole_file(path: &Path, error: &BagError) -> Loss {
    Loss {
        path: path.to_owned(),
        at_byte: 0,
        n_bytes: path.metadata().map_or(0, |metadata| metadata.len()),
        kind: LossKind::File,
        reason: with_cause(error),
        n_messages: None,
        bounds_ns: None,
    }
}

/// An error and its cause in the system.
fn with_cause(error: &BagError) -> String {
    match error.source() {
        Some(cause) => format!("{error}: {cause}"),
        None => error.to_string(),
    }
}

/// Whether the new bag, and not the old one, is at fault.
fn is_of_writing(error: &BagError) -> bool {
    matches!(error, BagError::Write { .. } | BagError::Exists { .. })
        || matches!(error, BagError::Io { action, .. } if *action != "read" && *action != "open")
}

/// What unpacking leaves of a disk to everybody else, in bytes.
const KEPT_FREE_BYTES: u64 = 256 << 20;

/// A file that rosbag2 compressed as a whole, unpacked as far as it goes, and gone when dropped;
/// `None` if it does not end within so many bytes.
fn unpack(
    mut packed: impl Read,
    folder: &Path,
    limit_bytes: u64,
) -> Result<Option<NamedTempFile>, BagError> {
    // Of a name of its own, as somebody may have put a link to another file where it would be.
    let beside = folder.parent().filter(|parent| !parent.as_os_str().is_empty());
    let beside = beside.unwrap_or(Path::new("."));
    let io = BagError::io("unpack into", beside);
    let mut file = NamedTempFile::new_in(beside).map_err(&io)?;
    let mut buffer = vec![0; 1 << 20];
    let mut n_written = 0;
    // Where unpacking fails, the file breaks off: the scan reports it.
    while let Ok(n_bytes) = crate::reader::read_some(&mut packed, &mut buffer) {
        if n_bytes == 0 {
            break;
        }
        n_written += n_bytes as u64;
        if n_written > limit_bytes {
            return Ok(None);
        }
        let free = rustix::fs::statvfs(file.path()).map_err(|error| io(error.into()))?;
        if free.f_bavail.saturating_mul(free.f_frsize) < KEPT_FREE_BYTES {
            return Err(io(std::io::ErrorKind::StorageFull.into()));
        }
        file.write_all(&buffer[..n_bytes]).map_err(&io)?;
    }
    Ok(Some(file))
}
