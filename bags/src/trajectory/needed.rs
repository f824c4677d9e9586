//! What of a run must be known well.

use std::fmt;

use rsrs_core::judge::phase::{MAX_GAP_S, WINDOW_S};

/// What of a run must be known well; what else there is may have gaps, which are named.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Needed {
    /// Its end, which the judge looks at.
    #[default]
    JudgedEnd,
    /// All of it: a trial, in which every second is measured.
    AllOfIt,
}

impl Needed {
    /// The time at the end of a run that must be known, in nanoseconds.
    pub(super) fn window_ns(self) -> u64 {
        match self {
            Self::JudgedEnd => nanoseconds(WINDOW_S),
            Self::AllOfIt => u64::MAX,
        }
    }

    /// Over so long a time without a pose a robot's motion is interpolated there, in nanoseconds: in a
    /// trial robots may turn by half a turn per second.
    ///
    /// # Arguments
    ///
    /// * `recorded_ns` — the median distance of poses.
    pub(super) fn most_gap_ns(self, recorded_ns: u64) -> u64 {
        let most_s = match self {
            Self::JudgedEnd => MAX_GAP_S,
            Self::AllOfIt => 1.0,
        };
        nanoseconds(most_s).max(recorded_ns * 3 / 2)
    }
}

/// Where something is that must not be there.
impl fmt::Display for Needed {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::JudgedEnd => write!(formatter, " within the last {WINDOW_S} s, which are judged"),
            Self::AllOfIt => Ok(()),
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a minute in nanoseconds fits, and none is negative"
)]
fn nanoseconds(time_s: f64) -> u64 {
    (time_s * 1e9) as u64
}
