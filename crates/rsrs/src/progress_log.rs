//! Progress as lines, where there is no terminal for a bar: when there is one, and what it contains.

use std::time::{Duration, Instant};

/// The least time between two lines, and before the first.
const MIN_INTERVAL: Duration = Duration::from_secs(30);
/// The most time between two lines, however slowly the work goes on.
const MAX_INTERVAL: Duration = Duration::from_secs(300);
/// The share of the work after which there is a line, if it is not too early for one.
const SHARE: f64 = 0.1;

/// Lines on the progress of long work, rate-limited, with an estimate of the time left.
#[derive(Clone, Copy, Debug)]
pub struct ProgressLog {
    /// When this stage of the work began, and how much was done before.
    stage_start: (Instant, f64),
    /// When the last line was printed, and how much was done; before the first, as above.
    last: (Instant, f64),
    has_line: bool,
}

impl ProgressLog {
    /// Work that begins, of which a share was done before.
    pub fn begin(now: Instant, share: f64) -> Self {
        Self { stage_start: (now, share), last: (now, share), has_line: false }
    }

    /// Restarts the time estimate for the next stage; the rate limit stays.
    pub fn restart_estimate(&mut self, now: Instant, share: f64) {
        self.stage_start = (now, share);
        self.last.1 = share;
    }

    /// How far the work has come (its share that is done, from 0 to 1), if it is time to report it:
    /// after 30 s, and then with each tenth that is done, at most every 30 s and at least every
    /// 5 min.
    pub fn line_if_due(&mut self, now: Instant, share: f64) -> Option<String> {
        let (before, share_before) = self.last;
        let waited = now.duration_since(before);
        let is_due = waited >= MAX_INTERVAL || share - share_before >= SHARE || !self.has_line;
        if waited < MIN_INTERVAL || !is_due {
            return None;
        }
        (self.last, self.has_line) = ((now, share), true);
        let (start, share_at_start) = self.stage_start;
        let done = share - share_at_start;
        let percent = 100.0 * share;
        if done <= 0.0 {
            return Some(format!("{percent:.0} %"));
        }
        let left_s = now.duration_since(start).as_secs_f64() * (1.0 - share) / done;
        Some(format!("{percent:.0} %, about {} left", duration(left_s)))
    }
}

/// A duration as a person writes it: `40 s`, `12 min`, `3.5 h`.
pub fn duration(time_s: f64) -> String {
    match time_s {
        ..90.0 => format!("{time_s:.0} s"),
        90.0..5400.0 => format!("{:.0} min", time_s / 60.0),
        _ => format!("{:.1} h", time_s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lines of work that is looked at at these times, with so much done.
    fn lines(looks: &[(u64, f64)]) -> Vec<String> {
        let start = Instant::now();
        let mut log = ProgressLog::begin(start, looks[0].1);
        looks
            .iter()
            .filter_map(|(time_s, share)| {
                let line = log.line_if_due(start + Duration::from_secs(*time_s), *share)?;
                Some(format!("{time_s} s: {line}"))
            })
            .collect()
    }

    #[test]
    fn a_line_comes_after_thirty_seconds_and_then_with_each_tenth_or_every_five_minutes() {
        let short = [(0, 0.0), (1, 0.3), (29, 1.0)];
        let usual = [(0, 0.0), (31, 0.05), (70, 0.1), (100, 0.16), (110, 0.3), (131, 0.4)];
        let slow: Vec<(u64, f64)> =
            (0..=60_u32).map(|at| (u64::from(at) * 10, f64::from(at) * 1e-5)).collect();
        // What was done before does not count towards the time left.
        let continued = [(0, 0.5), (60, 0.6)];
        for (looks, expected) in [
            (&short[..], &[][..]),
            (
                &usual,
                &[
                    "31 s: 5 %, about 10 min left",
                    "100 s: 16 %, about 9 min left",
                    "131 s: 40 %, about 3 min left",
                ],
            ),
            (&slow, &["30 s: 0 %, about 277.8 h left", "330 s: 0 %, about 277.7 h left"]),
            (&continued, &["60 s: 60 %, about 4 min left"]),
        ] {
            assert_eq!(lines(looks), expected, "{looks:?}");
        }
    }

    #[test]
    fn work_in_many_short_rounds_has_lines_too() {
        let start = Instant::now();
        let mut log = ProgressLog::begin(start, 0.0);
        let mut lines = Vec::new();
        for round in 0..8_u64 {
            let at = |time_s: u64| start + Duration::from_secs(10 * round + time_s);
            log.restart_estimate(at(0), 0.0);
            lines.extend(
                log.line_if_due(at(5), 0.5).map(|line| format!("{}: {line}", 10 * round + 5)),
            );
        }

        assert_eq!(lines, ["35: 50 %, about 5 s left", "65: 50 %, about 5 s left"]);
    }
}
