//! Which interval may be believed when.

use serde::{Deserialize, Serialize};

use crate::statistics::interval::Interval;
use crate::statistics::sequence;

/// How an interval came about, and therefore when it may be believed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum IntervalKind {
    /// Clopper and Pearson's: for a number of runs that was fixed before the first.
    #[default]
    ClopperPearson,
    /// A confidence sequence's: for any number of runs, also one that the runs decided.
    AnytimeValid,
}

impl IntervalKind {
    /// The word in files: `clopper_pearson`, `anytime_valid`.
    pub fn key(self) -> &'static str {
        match self {
            Self::ClopperPearson => "clopper_pearson",
            Self::AnytimeValid => "anytime_valid",
        }
    }

    /// The 95 % interval of this kind for `hits` of `n` runs.
    ///
    /// # Panics
    ///
    /// If there are more hits than runs.
    pub fn interval(self, hits: u64, n: u64) -> Interval {
        match self {
            Self::ClopperPearson => Interval::clopper_pearson(hits, n),
            Self::AnytimeValid => sequence::interval(hits, n, sequence::ERROR),
        }
    }
}
