//! Why a bag does not hold the whole of its run.

use std::fmt;
use std::time::Duration;

use rsrs_bags::{Bag, Damage, Recovery};
use rsrs_core::numerals::{count, counted};

/// Recorders hand over what they have every second; a file that did not grow for this long is not
/// recorded any more.
const STILL_GROWING: Duration = Duration::from_secs(5);

/// A recording that breaks off or is damaged.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct BrokenRecording {
    /// Messages before that.
    pub n_messages: u64,
    /// Log time of the last of them, in nanoseconds.
    pub last_log_time_ns: Option<u64>,
    /// Whether it may go on: its end is missing, and the file has just grown.
    pub is_growing: bool,
    /// Where it is damaged; `None` where its end is missing.
    pub damaged: Option<DamagedPlace>,
}

/// Where a file of a recording is damaged.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DamagedPlace {
    /// Name of the file.
    pub file: String,
    /// Place in it.
    pub at_byte: u64,
    /// What does not read there.
    pub reason: String,
}

impl BrokenRecording {
    /// Where the recording of a bag breaks off first; `None` for a whole bag.
    pub fn in_bag(bag: &Bag) -> Option<Self> {
        let damage = bag.damage();
        let first = damage.first()?;
        let Damage { path, n_messages, last_log_time_ns, at_byte, is_end, reason } = first;
        let damaged = (!is_end).then(|| DamagedPlace {
            file: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            at_byte: *at_byte,
            reason: reason.clone(),
        });
        Some(Self {
            n_messages: *n_messages,
            last_log_time_ns: *last_log_time_ns,
            is_growing: is_growing(first),
            damaged,
        })
    }
}

/// Whether a file that breaks off may still be recorded.
fn is_growing(damage: &Damage) -> bool {
    let age = damage.path.metadata().ok().and_then(|it| it.modified().ok()?.elapsed().ok());
    damage.is_end && age.is_some_and(|age| age < STILL_GROWING)
}

impl fmt::Display for BrokenRecording {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = if self.damaged.is_some() { "is damaged" } else { "breaks off" };
        write!(out, "the recording {what} after {}", counted(self.n_messages, "message"))?;
        if let Some(time_ns) = self.last_log_time_ns {
            write!(out, ", at {:.1} s", time_ns as f64 / 1e9)?;
        }
        if self.is_growing {
            out.write_str(" (or goes on: the file has just grown)")?;
        }
        match &self.damaged {
            Some(DamagedPlace { file, at_byte, reason }) => {
                write!(out, ": {file}, byte {}: {reason}", count(*at_byte))
            }
            None => Ok(()),
        }
    }
}

/// A bag that was recovered from a damaged one, and lacks something.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct LossyRecovery(pub Recovery);

impl LossyRecovery {
    /// What a bag lacks; `None` for one that was not recovered, or lacks nothing.
    pub fn in_bag(bag: &Bag) -> Option<Self> {
        bag.recovery().filter(|recovery| !recovery.is_complete).map(Self)
    }
}

impl fmt::Display for LossyRecovery {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("recovered from a damaged bag: ")?;
        match (self.0.is_exact, self.0.n_messages_lost) {
            (true, 0) => out.write_str("no message is missing, but something else"),
            (true, n) => write!(out, "{} missing", counted(n, "message")),
            (false, 0) => out.write_str("how many messages are missing is unknown"),
            (false, n) => write!(out, "at least {} missing", counted(n, "message")),
        }
    }
}
