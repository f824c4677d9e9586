//! How long the runner looks before it gives up.

use std::time::Duration;

use super::grouped::grouped;
use super::outcome::Failure;
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
    /// When it was last said that this machine has fallen behind.
    said: Option<Duration>,
}

/// How often that is said again.
const SAID_AGAIN: Duration = Duration::from_secs(10);

impl Search {
    /// Takes what is wrong now, and returns notes for the operator, if this machine has fallen
    /// behind: with everything else that is wrong.
    pub(super) fn look(&mut self, problems: &[Problem], now: Duration) -> Vec<String> {
        let behind = problems.iter().find(|problem| matches!(problem, Problem::TooSlow { .. }));
        self.is_behind = behind.is_some();
        // How many robots are missing is not known meanwhile.
        if let Some(problem) = behind {
            self.since = now;
            if self.said.is_some_and(|said| now.saturating_sub(said) < SAID_AGAIN) {
                return Vec::new();
            }
            self.said = Some(now);
            let others = problems.iter().filter(|other| !matches!(other, Problem::TooSlow { .. }));
            let failures = others.cloned().map(Failure::from).collect::<Vec<_>>();
            let others =
                grouped(&failures).into_iter().map(|other| format!("so far also: {other}"));
            return [format!("waiting: {problem}")].into_iter().chain(others).collect();
        }
        if self.least.is_none_or(|least| problems.len() < least) {
            (self.least, self.since) = (Some(problems.len()), now);
        }
        Vec::new()
    }

    /// Lets time in which nobody looked count for nothing.
    pub(super) fn forgive(&mut self, passed: Duration) {
        self.since += passed;
    }

    /// Whether nothing new is to be expected of a search that began at `start`.
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
    fn a_machine_that_is_too_slow_has_a_minute_to_catch_up_and_is_named_with_all_else_that_is_wrong()
     {
        let mut search = Search::default();

        let notes = search.look(&[SLOW], at(1));
        search.look(&missing(1), at(30));
        let with_others = search.look(&[SLOW, Problem::SimulatorMissing], at(39));
        assert_eq!(search.look(&[SLOW], at(40)), Vec::<String>::new(), "it was said just now");
        assert!(!search.is_over(at(1), at(39), Transport::Plain));
        search.look(&[SLOW], at(61));

        assert!(search.is_over(at(1), at(61), Transport::Plain));
        assert!(notes[0].starts_with("waiting: this machine is too slow"), "{notes:?}");
        assert!(with_others[1].starts_with("so far also: "), "{with_others:?}");
    }
}
