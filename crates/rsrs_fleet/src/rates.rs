//! Whether what must come in every control period does come, for the operator of a run.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

/// Over how long a rate is taken.
const WINDOW: Duration = Duration::from_secs(2);
/// A topic below this share of its rate is slow; dimensionless.
const SLOW: f64 = 0.5;
/// A slow topic above this share of its rate has recovered; dimensionless.
const RECOVERED: f64 = 0.8;

/// The rates of some topics.
#[derive(Clone, Debug)]
pub struct Rates {
    topics: BTreeMap<String, Watched>,
    since: Duration,
}

#[derive(Clone, Debug)]
struct Watched {
    expected_hz: f64,
    received: VecDeque<Duration>,
    is_slow: bool,
}

impl Rates {
    /// Watches topics from now on, each with how often it has a sample, in seconds; above 0.
    pub fn new(topics: impl IntoIterator<Item = (String, f64)>, now: Duration) -> Self {
        let watched = |period_s: f64| Watched {
            expected_hz: 1.0 / period_s,
            received: VecDeque::new(),
            is_slow: false,
        };
        Self {
            topics: topics.into_iter().map(|(name, period_s)| (name, watched(period_s))).collect(),
            since: now,
        }
    }

    /// A sample came; those of other topics do not count.
    pub fn received(&mut self, topic: &str, now: Duration) {
        if let Some(watched) = self.topics.get_mut(topic) {
            watched.received.push_back(now);
        }
    }

    /// What has changed: one sentence for each topic that has become slow, or has recovered.
    pub fn changes(&mut self, now: Duration) -> Vec<String> {
        let mut changes = Vec::new();
        for (name, watched) in &mut self.topics {
            while watched.received.front().is_some_and(|at| now.saturating_sub(*at) > WINDOW) {
                watched.received.pop_front();
            }
            if now.saturating_sub(self.since) < WINDOW {
                continue;
            }
            let found_hz = watched.received.len() as f64 / WINDOW.as_secs_f64();
            let expected_hz = watched.expected_hz;
            if !watched.is_slow && found_hz < SLOW * expected_hz {
                watched.is_slow = true;
                changes.push(if watched.received.is_empty() {
                    format!("{name}: silent, expected {expected_hz:.1} Hz")
                } else {
                    format!("{name}: {found_hz:.1} Hz, expected {expected_hz:.1} Hz")
                });
            } else if watched.is_slow && found_hz >= RECOVERED * expected_hz {
                watched.is_slow = false;
                changes.push(format!("{name}: back at {found_hz:.1} Hz"));
            }
        }
        changes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_topic_that_falls_silent_and_comes_back_is_reported_once_each() {
        let mut rates = Rates::new([("/robot_1/detection".to_owned(), 0.1)], Duration::ZERO);
        let mut notes = Vec::new();

        for tick in 0..150_u64 {
            let now = Duration::from_millis(100 * tick);
            if !(50..90).contains(&tick) {
                rates.received("/robot_1/detection", now);
            }
            notes.extend(rates.changes(now).into_iter().map(|text| (tick, text)));
        }

        let texts: Vec<_> = notes.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(
            texts,
            ["/robot_1/detection: 4.5 Hz, expected 10.0 Hz", "/robot_1/detection: back at 8.0 Hz"],
            "{notes:?}"
        );
    }
}
