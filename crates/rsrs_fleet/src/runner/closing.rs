//! How far the bag is, after the last sample of a run.

use std::time::Duration;

use crate::timing::RECORDER_TIMEOUT;

/// When the operator reads for the first time what is left, and how often then.
const NOTE_PERIOD: Duration = Duration::from_secs(2);

/// How far the bag is.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Closing {
    /// What was done, and since when no more was; `None` before the first word.
    done: Option<(u64, Duration)>,
    left_bytes: u64,
    noted: Option<Duration>,
    /// Whether somebody wanted the run to end, or the bag to be given up.
    is_interrupted: bool,
}

impl Closing {
    /// Somebody wants the run to end; returns whether it is not for the first time.
    pub(super) fn interrupt(&mut self) -> bool {
        std::mem::replace(&mut self.is_interrupted, true)
    }

    /// Takes a word of the recorder, and returns a note for the operator if one is due.
    pub(super) fn receive(&mut self, done: u64, left_bytes: u64, now: Duration) -> Option<String> {
        self.left_bytes = left_bytes;
        if self.done.is_none_or(|(before, _)| before != done) {
            self.done = Some((done, now));
        }
        let last = *self.noted.get_or_insert(now);
        if now.saturating_sub(last) < NOTE_PERIOD {
            return None;
        }
        self.noted = Some(now);
        Some(format!("closing the bag, {} left", self.left()))
    }

    /// Why a bag that began to be closed at `since` is given up, if nothing was written for too long.
    pub(super) fn is_stuck(&self, since: Duration, now: Duration) -> Option<String> {
        let last = self.done.map_or(since, |(_, at)| at.max(since));
        (now.saturating_sub(last) >= RECORDER_TIMEOUT).then(|| {
            format!(
                "nothing was written for {} s, {} left",
                RECORDER_TIMEOUT.as_secs(),
                self.left()
            )
        })
    }

    /// What is still to be written, in words.
    pub(super) fn left(&self) -> String {
        format!("{} MB", self.left_bytes.div_ceil(1_000_000))
    }
}
