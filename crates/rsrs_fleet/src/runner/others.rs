//! Other runners that want robots of this run, and which of two gives way.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::time::Duration;

use crate::timing::NODE_TIMEOUT;

/// Runs that are remembered; a sender may name any number.
const MOST_RUNS: usize = 100;

/// Runs of others to which this one gives way.
#[derive(Clone, Debug, Default)]
pub(super) struct Others {
    /// By run: when it was received last.
    received: BTreeMap<String, Duration>,
}

impl Others {
    pub(super) fn receive(&mut self, run_id: String, now: Duration) {
        self.received.retain(|_, at| is_recent(*at, now));
        if self.received.len() < MOST_RUNS {
            self.received.insert(run_id, now);
        }
    }

    /// Those that are received now.
    pub(super) fn recent(&self, now: Duration) -> impl Iterator<Item = &String> {
        let recent = self.received.iter().filter(move |(_, at)| is_recent(**at, now));
        recent.map(|(run_id, _)| run_id)
    }
}

fn is_recent(at: Duration, now: Duration) -> bool {
    now.saturating_sub(at) <= NODE_TIMEOUT
}

/// What decides between two runs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Claim<'a> {
    pub run_id: &'a str,
    /// 0 before it arms.
    pub epoch: u64,
}

impl Claim<'_> {
    /// Whether this run gives way to the other, which wants the same robots.
    ///
    /// Who has armed goes before who prepares, and of two that have armed none goes on but one with a
    /// higher epoch. Of two that prepare the one that was started later gives way.
    pub(super) fn gives_way_to(self, other: Claim<'_>) -> bool {
        match (self.epoch, other.epoch) {
            (0, 0) => beginnings(other.run_id, self.run_id) == Ordering::Less,
            (own, others) => others > 0 && others >= own,
        }
    }
}

/// How the beginnings of two runs compare: by the times in their names, and by the names themselves
/// where these are equal, or there are none.
fn beginnings(run_id: &str, than: &str) -> Ordering {
    (time_of(run_id), run_id).cmp(&(time_of(than), than))
}

/// Date and time at which a run was named: `20261122T102030_045Z` of `milling_20261122T102030_045Z_ab12`.
fn time_of(run_id: &str) -> Option<(&str, &str)> {
    let mut parts = run_id.rsplit('_').skip(1);
    let (fraction, time) = (parts.next()?, parts.next()?);
    let digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit() || byte == b'T');
    let is_time = time.len() == 15 && digits(time);
    (is_time && fraction.strip_suffix('Z').is_some_and(digits)).then_some((time, fraction))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claim(run_id: &str, epoch: u64) -> Claim<'_> {
        Claim { run_id, epoch }
    }

    #[test]
    fn of_two_that_prepare_the_later_one_gives_way_whatever_their_experiments_are_called() {
        let early = claim("milling_20261122T102030_045Z_00000000000000ab", 0);
        let late = claim("a_v2_20261122T102030_046Z_0000000000000001", 0);
        let at_once = claim("milling_20261122T102030_045Z_00000000000000ac", 0);

        for later in [late, at_once] {
            assert!(later.gives_way_to(early) && !early.gives_way_to(later), "{later:?}");
        }
        assert!(claim("run 1", 0).gives_way_to(claim("run 0", 0)));
        assert!(!claim("run 0", 0).gives_way_to(claim("run 1", 0)));
    }

    #[test]
    fn who_prepares_gives_way_to_who_has_armed_and_nobody_who_has_armed_to_one_that_prepares() {
        assert!(claim("run 0", 0).gives_way_to(claim("run 1", 4)));
        assert!(!claim("run 1", 4).gives_way_to(claim("run 0", 0)));
    }

    #[test]
    fn of_two_that_have_armed_one_at_most_goes_on() {
        assert!(claim("run 0", 4).gives_way_to(claim("run 1", 4)));
        assert!(claim("run 1", 4).gives_way_to(claim("run 0", 4)));
        assert!(!claim("run 1", 5).gives_way_to(claim("run 0", 4)));
    }

    #[test]
    fn a_sender_of_any_number_of_runs_fills_no_memory() {
        let mut others = Others::default();
        for run in 0..1_000 {
            others.receive(format!("run {run}"), Duration::ZERO);
        }
        assert_eq!(others.recent(Duration::ZERO).count(), MOST_RUNS);

        others.receive("run".to_owned(), Duration::from_secs(2));

        assert_eq!(others.recent(Duration::from_secs(2)).collect::<Vec<_>>(), ["run"]);
    }
}
