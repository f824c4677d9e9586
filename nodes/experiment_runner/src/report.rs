//! How far a run is, what came of it, and how long its parts took.

use std::time::{Duration, Instant};

use rsrs_bags::BagSummary;
use rsrs_fleet::record::Ending;

/// How far a run is, for those who watch.
#[derive(Clone, Debug, PartialEq)]
pub enum Progress {
    /// A note for the operator.
    Note(String),
    /// Steps that are recorded, of all; in real time, seconds that have passed.
    Done {
        /// So many are done.
        done: u64,
        /// So many there are.
        of: u64,
    },
}

/// What came of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct RunReport {
    /// How it ended.
    pub ending: Ending,
    /// Robots that did not report that they stand; an operator should go and look.
    pub not_standing: Vec<String>,
    /// The bag; `None` if none was opened.
    pub bag: Option<BagSummary>,
    /// Whether the robots were allowed to move.
    pub has_started: bool,
    /// Messages missing in the bag between two that are in it, on topics that are to lose none.
    pub n_lost: u64,
    /// Wall-clock time from the start of the runner until all that it needs was found, in seconds;
    /// `None` if it never was.
    pub preflight_s: Option<f64>,
    /// Wall-clock time from then until all parameters were set and read back, in seconds; `None` if
    /// they never were.
    pub parameters_s: Option<f64>,
    /// Wall-clock time from the first recorded step to the last, in seconds; in lockstep alone.
    pub stepping_s: Option<f64>,
}

/// When the parts of a run were done.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Times {
    /// When all was found, since the start of the runner.
    pub(crate) found: Option<Duration>,
    /// When all parameters had been read back, since the start of the runner.
    pub(crate) confirmed: Option<Duration>,
    stepping: Option<(Instant, Instant)>,
}

impl Times {
    /// Takes note of a recorded step.
    pub(crate) fn stepped(&mut self, now: Instant) {
        self.stepping.get_or_insert((now, now)).1 = now;
    }

    pub(crate) fn preflight_s(&self) -> Option<f64> {
        self.found.map(|found| found.as_secs_f64())
    }

    pub(crate) fn parameters_s(&self) -> Option<f64> {
        Some(self.confirmed?.saturating_sub(self.found?).as_secs_f64())
    }

    pub(crate) fn stepping_s(&self) -> Option<f64> {
        let (first, last) = self.stepping?;
        Some(last.saturating_duration_since(first).as_secs_f64())
    }
}
