//! When a node publishes its status: on every change, and twenty times a second.

use std::time::Duration;

use crate::timing::HEARTBEAT_PERIOD;

/// The statuses that a node has published, by their numbers.
#[derive(Clone, Debug)]
pub(crate) struct Heartbeat<S> {
    counter: u64,
    /// What was published last, and when.
    last: Option<(S, Duration)>,
}

impl<S> Default for Heartbeat<S> {
    fn default() -> Self {
        Self { counter: 0, last: None }
    }
}

impl<S: PartialEq> Heartbeat<S> {
    /// Nothing was published yet; numbers rise from here.
    pub fn from(counter: u64) -> Self {
        Self { counter, last: None }
    }

    /// The number of the last status.
    pub fn counter(&self) -> u64 {
        self.counter
    }

    /// The number of the status to publish now, if one is due: at once when the state changes.
    pub fn due(&mut self, state: S, now: Duration) -> Option<u64> {
        let at = match &self.last {
            Some((published, at)) if *published == state => next_beat(*at, now)?,
            _ => now,
        };
        self.counter += 1;
        self.last = Some((state, at));
        Some(self.counter)
    }

    /// Makes a status due, whatever was published.
    pub fn hurry(&mut self) {
        self.last = None;
    }
}

/// When the beat that is due now was due; `None` if none is.
///
/// A node looks at the time now and then, and so is a little late each time; its beats are as many as
/// they should be all the same. One that missed a whole beat does not catch up.
pub(crate) fn next_beat(last: Duration, now: Duration) -> Option<Duration> {
    let late = now.saturating_sub(last).checked_sub(HEARTBEAT_PERIOD)?;
    Some(if late < HEARTBEAT_PERIOD { last + HEARTBEAT_PERIOD } else { now })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_published_at_once_and_all_else_twenty_times_a_second() {
        let mut beat = Heartbeat::from(7);
        let mut due = |state, at_ms| beat.due(state, Duration::from_millis(at_ms));

        assert_eq!(due('a', 0), Some(8));
        assert_eq!(due('a', 49), None);
        assert_eq!(due('b', 49), Some(9));
        assert_eq!(due('b', 98), None);
        assert_eq!(due('b', 99), Some(10));
    }

    #[test]
    fn who_looks_late_beats_as_often_and_who_missed_a_beat_does_not_catch_up() {
        let mut beat = Heartbeat::from(0);

        // A look every 20 ms, as all nodes have.
        let n_beats = (0..1000).step_by(20).filter_map(|at| beat.due((), ms(at))).count();
        assert_eq!(n_beats, 20);
        beat.due((), ms(5_000));

        assert_eq!(beat.due((), ms(5_049)), None);
    }

    fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    #[test]
    fn what_is_hurried_is_published_again() {
        let mut beat = Heartbeat::from(0);
        beat.due((), Duration::ZERO);

        beat.hurry();

        assert_eq!(beat.due((), Duration::ZERO), Some(2));
    }
}
