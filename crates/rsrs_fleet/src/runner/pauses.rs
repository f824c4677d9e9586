//! When a robot stood in a run because its lease had run out, and went on.

use std::time::Duration;

use crate::message::{RobotState, Status, StopCause};

/// The pauses of one robot, by its statuses.
///
/// Each counts from the last status before it in which the robot moved to the first after it, so
/// that it was no longer than that.
#[derive(Clone, Debug, Default)]
pub(super) struct Pauses {
    start: Duration,
    /// When the last status came in which it moved.
    moved: Duration,
    /// Since when it stands, if it does.
    open: Option<Duration>,
    /// Those that are over: when each began and ended.
    over: Vec<(Duration, Duration)>,
    /// How many of these were reported.
    n_reported: usize,
}

impl Pauses {
    /// Of a robot that may move from now on.
    pub fn from(start: Duration) -> Self {
        Self { start, moved: start, ..Self::default() }
    }

    /// Takes a status of the robot's in this run.
    pub fn receive(&mut self, status: &Status, now: Duration) {
        match (status.state, status.stop_cause) {
            (RobotState::Moving, _) => {
                self.over.extend(self.open.take().map(|since| (since, now)));
                self.moved = now;
            }
            (RobotState::Stopped, StopCause::Lease | StopCause::Controller) => {
                self.open.get_or_insert(self.moved);
            }
            _ => {}
        }
    }

    /// It was given up: that it stands now is no pause.
    pub fn give_up(&mut self) {
        self.open = None;
    }

    /// How long the pauses have been in all.
    pub fn total(&self, now: Duration) -> Duration {
        let open = self.open.map(|since| now.saturating_sub(since));
        let over = self.over.iter().map(|(since, until)| until.saturating_sub(*since));
        over.chain(open).sum()
    }

    /// How long a pause was that is over and was not reported; of several, the longest.
    pub fn take_news(&mut self) -> Option<Duration> {
        let news = self.over[self.n_reported..].iter();
        self.n_reported = self.over.len();
        news.map(|(since, until)| until.saturating_sub(*since)).max()
    }

    /// When each began, after the start, and how long it was, in seconds.
    pub fn all(&mut self, now: Duration) -> Vec<(f64, f64)> {
        self.over.extend(self.open.take().map(|since| (since, now)));
        let times = self.over.iter().map(|(since, until)| {
            let after = since.saturating_sub(self.start);
            (after.as_secs_f64(), until.saturating_sub(*since).as_secs_f64())
        });
        times.collect()
    }
}
