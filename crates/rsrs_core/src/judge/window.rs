//! Which time of a run is judged.

use std::fmt;
use std::ops::Range;

use serde::{Deserialize, Serialize};

/// The time at the end of a run that is judged unless a behaviour asks for another, in seconds.
pub const WINDOW_S: f64 = 60.0;

/// The longest time without a pose of a robot that is bridged within [`WINDOW_S`], in seconds: a circle
/// of 0.75 rad/s at 0.15 m/s departs from its chord by 5 cm in this time, less than its robots are wide,
/// and settled labels stay what they are (`tests/judge.rs`, `IsOccluded`).
pub const MAX_GAP_S: f64 = 2.0;

/// Length of the blocks in which convergence is looked for, in seconds.
pub const BLOCK_S: f64 = 10.0;

/// Which time of a run is judged.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Window {
    /// The last so many seconds.
    LastS(f64),
    /// All of it.
    WholeRun,
    /// Any 60 s: the run is in the wanted phase if it was in it had it been ended earlier, at any multiple of
    /// 10 s.
    Ever,
}

/// The last seconds that may be judged: a block at least, and a day at most.
pub const LAST_S: [f64; 2] = [BLOCK_S, 86_400.0];

impl Default for Window {
    fn default() -> Self {
        Self::LastS(WINDOW_S)
    }
}

impl Window {
    /// Whether it is the one that files do not name.
    pub fn is_usual(&self) -> bool {
        *self == Self::default()
    }

    /// How long a run must be to be judged, in seconds.
    pub fn least_s(self) -> f64 {
        match self {
            Self::LastS(last_s) => last_s,
            Self::WholeRun | Self::Ever => WINDOW_S,
        }
    }

    /// How far back from its end a run may decide, in seconds; infinite where all of it does.
    pub fn reaches_back_s(self) -> f64 {
        match self {
            Self::LastS(last_s) => last_s,
            Self::WholeRun | Self::Ever => f64::INFINITY,
        }
    }

    /// What somebody sees who looks on: of what may have been, what there is at last.
    #[must_use]
    pub fn at_the_moment(self) -> Self {
        match self {
            Self::Ever => Self::default(),
            other => other,
        }
    }

    /// What may not have gaps: `the last 60 s, which are judged`.
    pub fn in_words(self) -> String {
        match self {
            Self::LastS(_) => format!("{self}, which are judged"),
            Self::WholeRun | Self::Ever => "the run, all of which is judged".to_owned(),
        }
    }

    /// How many samples a window has in a run of `n_samples`, which are at least as many as
    /// [`Self::least_s`] asks for. The control period is positive.
    pub fn n_samples(self, n_samples: usize, period_s: f64) -> usize {
        match self {
            Self::LastS(last_s) => samples_in(last_s, period_s),
            Self::WholeRun => n_samples,
            Self::Ever => samples_in(WINDOW_S, period_s),
        }
    }

    /// How many samples at the end of a run are needed to judge it; arguments as of [`Self::n_samples`].
    pub fn n_needed(self, n_samples: usize, period_s: f64) -> usize {
        match self {
            Self::Ever => n_samples,
            other => other.n_samples(n_samples, period_s),
        }
    }

    /// The windows to look at, in order, of which the last one ends with the run; arguments as of
    /// [`Self::n_samples`].
    pub fn samples(
        self,
        n_samples: usize,
        period_s: f64,
    ) -> impl Iterator<Item = Range<usize>> + use<> {
        let n_window = self.n_samples(n_samples, period_s);
        let n_block = samples_in(BLOCK_S, period_s);
        let first = if self == Self::Ever { n_window } else { n_samples };
        let earlier = (first..n_samples).step_by(n_block);
        earlier.chain([n_samples]).map(move |end| end - n_window..end)
    }
}

/// `the last 60 s`, `the whole run`, `any 60 s`
impl fmt::Display for Window {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LastS(last_s) => write!(formatter, "the last {last_s} s"),
            Self::WholeRun => formatter.write_str("the whole run"),
            Self::Ever => write!(formatter, "any {WINDOW_S} s"),
        }
    }
}

/// Whole periods in a time, at least one: the samples of a window or a block.
pub fn samples_in(time_s: f64, period_s: f64) -> usize {
    // A whole number of periods may fall short of it by a rounding error.
    ((time_s / period_s + 1e-9).floor() as usize).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_looked_at_as_if_it_had_ended_at_each_of_its_blocks() {
        let windows = |window: Window, n| -> Vec<(usize, usize)> {
            window.samples(n, 1.0).map(|samples| (samples.start, samples.end)).collect()
        };

        assert_eq!(windows(Window::default(), 95), [(35, 95)]);
        assert_eq!(windows(Window::LastS(20.0), 95), [(75, 95)]);
        assert_eq!(windows(Window::WholeRun, 95), [(0, 95)]);
        let ever = [(0, 60), (10, 70), (20, 80), (30, 90), (35, 95)];
        assert_eq!(windows(Window::Ever, 95), ever);
        assert_eq!(windows(Window::Ever, 60), [(0, 60)]);
        assert_eq!(Window::Ever.n_needed(95, 1.0), 95);
    }
}
