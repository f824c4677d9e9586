//! How long the runner looks before it gives up.

use std::time::Duration;

use crate::preflight::Problem;
use crate::timing::{CATCH_UP_TIMEOUT, Transport};

/// The search for what an experiment needs.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Search {
    /// The least that was ever wrong.
    least: Option<usize>,
    /// When it last found more, or could not receive what there is.
    since: Duration,
    is_behind: bool,
    was_behind: bool,
}

impl Search {
    /// Takes what is wrong now.
    ///
    /// # Returns
    ///
    /// Note for the operator, if this machine has fallen behind.
    pub(super) fn look(&mut self, problems: &[Problem], now: Duration) -> Option<String> {
        let behind = problems.iter().find(|problem| matches!(problem, Problem::TooSlow { .. }));
        self.is_behind = behind.is_some();
        // How many robots are missing is not known meanwhile.
        if let Some(problem) = behind {
            self.since = now;
            let is_news = !std::mem::replace(&mut self.was_behind, true);
            return is_news.then(|| format!("waiting: {problem}"));
        }
        if self.least.is_none_or(|least| problems.len() < least) {
            (self.least, self.since) = (Some(problems.len()), now);
        }
        None
    }

    /// Lets time in which nobody looked count for nothing.
    pub(super) fn forgive(&mut self, passed: Duration) {
        self.since += passed;
    }

    /// Whether nothing new is to be expected.
    ///
    /// # Arguments
    ///
    /// * `start` — when the search began.
    pub(super) fn is_over(&self, start: Duration, now: Duration, transport: Transport) -> bool {
        let is_stuck = now.saturating_sub(self.since) >= transport.discovery_timeout();
        is_stuck || (self.is_behind && now.saturating_sub(start) >= CATCH_UP_TIMEOUT)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLOW: Problem = Problem::TooSlow { behind_s: 0.8 };

    fn at(seconds: u64) -> Duration {
        Duration::from_secs(seconds)
    }

    fn missing(n_robots: usize) -> Vec<Problem> {
        vec![Problem::SimulatorMissing; n_robots]
    }

    #[test]
    fn it_is_over_when_nothing_more_was_found_for_a_while() {
        let mut search = Search::default();

        search.look(&missing(3), at(1));
        search.look(&missing(2), at(9));
        search.look(&missing(2), at(18));
        assert!(!search.is_over(at(1), at(18), Transport::Plain));
        search.look(&missing(3), at(19));

        assert!(search.is_over(at(1), at(19), Transport::Plain));
        assert!(!search.is_over(at(1), at(28), Transport::Secured));
        assert!(search.is_over(at(1), at(29), Transport::Secured));
    }

    #[test]
    fn a_machine_that_is_too_slow_has_a_minute_to_catch_up_and_is_reported_once() {
        let mut search = Search::default();

        let notes = search.look(&[SLOW], at(1));
        search.look(&missing(1), at(30));
        assert_eq!(search.look(&[SLOW], at(39)), None);
        assert!(!search.is_over(at(1), at(39), Transport::Plain));
        search.look(&[SLOW], at(61));

        assert!(search.is_over(at(1), at(61), Transport::Plain));
        assert!(notes.is_some_and(|notes| notes.starts_with("waiting: this machine is too slow")));
    }
}
