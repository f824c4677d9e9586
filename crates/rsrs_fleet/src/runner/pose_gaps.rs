//! Gaps of poses for which a run will not be labelled.

use std::collections::BTreeSet;
use std::time::Duration;

use rsrs_core::judge::window::{MAX_GAP_S, Window};

/// The robots whose gaps were noted; one gap suffices.
#[derive(Clone, Debug, Default)]
pub(super) struct PoseGaps(BTreeSet<String>);

impl PoseGaps {
    /// What is to be noted now: robots of which no pose has come for longer than the judge bridges,
    /// in the time that is judged. Gaps before that time do no harm.
    pub(super) fn news<'a>(
        &mut self,
        silences: impl Iterator<Item = (&'a str, Duration)>,
        left: Duration,
        judged: Window,
    ) -> Vec<String> {
        if left.as_secs_f64() > judged.reaches_back_s() {
            return Vec::new();
        }
        let is_gap = |silence: Duration| silence > Duration::from_secs_f64(MAX_GAP_S);
        let gaps = silences.filter(|(_, silence)| is_gap(*silence)).map(|(robot, _)| robot);
        gaps.filter(|robot| self.0.insert((*robot).to_owned()))
            .map(|robot| {
                format!(
                    "{robot}: no pose for more than {MAX_GAP_S} s within {}: this run will not be labelled",
                    judged.in_words()
                )
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_gaps_that_reach_into_the_judged_time_are_noted_and_each_robot_once() {
        let mut gaps = PoseGaps::default();
        let mut news = |silence_s: f64, left_s: f64| {
            let silences = [("robot_1", 0.1), ("robot_2", silence_s)];
            let silences = silences.map(|(robot, s)| (robot, Duration::from_secs_f64(s)));
            gaps.news(silences.into_iter(), Duration::from_secs_f64(left_s), Window::default())
        };

        assert_eq!(news(4.0, 61.0), [""; 0], "it may come back in time");
        assert_eq!(news(2.0, 59.0), [""; 0], "that is bridged");
        assert_eq!(
            news(2.1, 60.0),
            [
                "robot_2: no pose for more than 2 s within the last 60 s, which are judged: this run will not \
                 be labelled"
            ]
        );
        assert_eq!(news(2.2, 59.9), [""; 0]);
    }
}
