//! What one run over ROS 2 came to.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rsrs_core::robot::other_profile::ProfilesDiffer;
use rsrs_fleet::record::{EndingKind, ExperimentRecord, LostRobot, OwnProfile, PausedRobot};
use serde::Serialize;

use crate::attempt::Attempt;
use crate::recorded_run::gaps::Gap;

/// What a run came to.
#[derive(Clone, Debug, Serialize)]
pub struct RunSummary {
    /// Names the run.
    pub run_id: String,
    /// The bag; `None` if none was opened. One without `metadata.yaml` was not closed.
    pub bag: Option<PathBuf>,
    /// How the run ended.
    pub ending: EndingKind,
    /// Why, if it was not completed.
    pub reason: String,
    /// Whether the robots were allowed to move.
    pub has_started: bool,
    /// Robots that were lost on the way, and when.
    pub lost_robots: Vec<LostRobot>,
    /// When robots stood because leases did not reach them, and went on.
    pub paused_robots: Vec<PausedRobot>,
    /// Messages in the bag.
    pub n_messages: u64,
    /// Messages missing in the bag between two that are in it, on topics that are to lose none.
    pub n_lost: u64,
    /// What did not get into the bag, by topic.
    pub gaps: Vec<Gap>,
    /// That the sweep of its cell is of robots with another profile; not there if it is not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other_profile: Option<ProfilesDiffer>,
    /// Robots with a profile of their own, and in what it differs from the fleet's.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub own_profiles: BTreeMap<String, OwnProfile>,
    /// Robots that did not report that they stand.
    pub not_standing: Vec<String>,
    /// How long the robots were to move, in seconds.
    pub duration_s: f64,
    /// Wall-clock time until all that the run needs was found, in seconds; with the simulator, which
    /// is started for the run, its start is part of it.
    pub preflight_s: Option<f64>,
    /// Wall-clock time in which all parameters were set and read back, in seconds.
    pub parameters_s: Option<f64>,
    /// Simulated seconds for each wall-clock second; `None` in real time.
    pub real_time_factor: Option<f64>,
}

impl RunSummary {
    /// A run that was completed, of which nothing is known but its record.
    pub fn new(record: &ExperimentRecord) -> Self {
        Self {
            run_id: record.run_id.clone(),
            bag: None,
            ending: EndingKind::Completed,
            reason: String::new(),
            has_started: true,
            lost_robots: Vec::new(),
            paused_robots: Vec::new(),
            n_messages: 0,
            n_lost: 0,
            gaps: Vec::new(),
            other_profile: None,
            own_profiles: record.own_profiles.clone(),
            not_standing: Vec::new(),
            duration_s: record.duration_s,
            preflight_s: None,
            parameters_s: None,
            real_time_factor: None,
        }
    }

    /// What is to be kept of it, if it gave no result.
    pub fn attempt(&self, record: &ExperimentRecord) -> Attempt {
        Attempt {
            run_id: self.run_id.clone(),
            robots: record.robots.clone(),
            ending: self.ending.key().to_owned(),
            reason: self.reason.clone(),
            has_started: self.has_started,
            lost_robots: self.lost_robots.clone(),
            bag: None,
        }
    }

    /// Whether it counts, lost nothing that it should have, and every robot is confirmed to stand.
    pub fn is_whole(&self, record: &ExperimentRecord) -> bool {
        let is_completed = self.ending == EndingKind::Completed;
        let counts = is_completed && record.counts_without(&self.lost_robots);
        // What a best-effort topic loses on its way is listed, and was to be expected.
        let has_overflowed = self.gaps.iter().any(|gap| gap.n_overflowed > 0);
        let has_lost = self.n_lost > 0 || has_overflowed;
        // Whatever comes next, such as a program that places the robots, would be among moving ones.
        counts && !has_lost && self.not_standing.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use rsrs_fleet::experiment::RobotLost;
    use rsrs_testing::conditions::flockbot_conditions;
    use rsrs_testing::record::fleet_record;

    use super::*;

    fn record(robot_lost: RobotLost) -> ExperimentRecord {
        ExperimentRecord { robot_lost, ..fleet_record("0", flockbot_conditions()) }
    }

    fn completed() -> RunSummary {
        RunSummary::new(&record(RobotLost::Abort))
    }

    #[test]
    fn a_robot_that_is_not_confirmed_to_stand_or_a_run_that_does_not_count_is_no_success() {
        let lost = |after_s: f64| {
            let (robot, reason) = ("robot_1".to_owned(), "silent".to_owned());
            vec![LostRobot { robot, after_s, reason }]
        };
        let moving = RunSummary { not_standing: vec!["robot_1".to_owned()], ..completed() };
        let void = RunSummary { ending: EndingKind::Void, ..completed() };
        let without = |after_s| RunSummary { lost_robots: lost(after_s), ..completed() };
        for (summary, rule, is_whole) in [
            (completed(), RobotLost::Abort, true),
            (moving, RobotLost::Abort, false),
            (void, RobotLost::Abort, false),
            (without(250.0), RobotLost::Note, false),
            (without(250.0), RobotLost::AbortUntilJudged, true),
        ] {
            assert_eq!(summary.is_whole(&record(rule)), is_whole, "{summary:?}");
        }
    }
}
