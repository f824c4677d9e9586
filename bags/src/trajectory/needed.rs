//! What of a run must be known well.

use std::fmt;

use rsrs_core::judge::window::{MAX_GAP_S, Window};

/// What of a run must be known well; what else there is may have gaps, which are named.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Needed {
    /// What the judge looks at: mostly its end.
    Judged(Window),
    /// All of it: a trial, in which every second is measured.
    AllOfIt,
}

impl Default for Needed {
    fn default() -> Self {
        Self::Judged(Window::default())
    }
}

impl Needed {
    /// The time at the end of a run that must be known, in nanoseconds.
    pub(super) fn window_ns(self) -> u64 {
        match self {
            Self::Judged(window) => nanoseconds(window.reaches_back_s()),
            Self::AllOfIt => u64::MAX,
        }
    }

    /// Over so long a time without a pose a robot's motion is interpolated there, in nanoseconds,
    /// but over 1.5 times the median distance of poses (`recorded_ns`) in any case: in a trial
    /// robots may turn by half a turn per second.
    pub(super) fn most_gap_ns(self, recorded_ns: u64) -> u64 {
        let most_s = match self {
            Self::Judged(_) => MAX_GAP_S,
            Self::AllOfIt => 1.0,
        };
        nanoseconds(most_s).max(recorded_ns * 3 / 2)
    }
}

/// Where something is that must not be there.
impl fmt::Display for Needed {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Judged(window) => write!(formatter, " within {}", window.in_words()),
            Self::AllOfIt => Ok(()),
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "what is longer is all of a run, and none is negative"
)]
fn nanoseconds(time_s: f64) -> u64 {
    (time_s * 1e9) as u64
}
