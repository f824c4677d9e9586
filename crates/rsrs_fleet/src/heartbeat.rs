//! When a node publishes its status: on every change, and ten times a second.

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

    /// The number of the status to publish now, if one is due.
    ///
    /// # Arguments
    ///
    /// * `state` — what others must receive at once when it changes.
    pub fn due(&mut self, state: S, now: Duration) -> Option<u64> {
        let is_due = self.last.as_ref().is_none_or(|(published, at)| {
            *published != state || now.saturating_sub(*at) >= HEARTBEAT_PERIOD
        });
        if !is_due {
            return None;
        }
        self.counter += 1;
        self.last = Some((state, now));
        Some(self.counter)
    }

    /// Makes a status due, whatever was published.
    pub fn hurry(&mut self) {
        self.last = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_published_at_once_and_all_else_ten_times_a_second() {
        let mut beat = Heartbeat::from(7);
        let mut due = |state, at_ms| beat.due(state, Duration::from_millis(at_ms));

        assert_eq!(due('a', 0), Some(8));
        assert_eq!(due('a', 99), None);
        assert_eq!(due('b', 99), Some(9));
        assert_eq!(due('b', 198), None);
        assert_eq!(due('b', 199), Some(10));
    }

    #[test]
    fn what_is_hurried_is_published_again() {
        let mut beat = Heartbeat::from(0);
        beat.due((), Duration::ZERO);

        beat.hurry();

        assert_eq!(beat.due((), Duration::ZERO), Some(2));
    }
}
