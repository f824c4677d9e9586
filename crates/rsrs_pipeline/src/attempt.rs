//! Runs that gave no result: which of them are made again, how often, and what stays of each.
//!
//! A cause that was known before the result may be repeated. After the start of the movement even a cause
//! that looks like one, such as a robot that the tracker lost, may be what the swarm did; so whatever is
//! repeated stays on the record, and whoever counts results can count it for the worst.

use std::fmt;
use std::path::{Path, PathBuf};

use anyhow::Context;
use rsrs_fleet::experiment::{RobotLost, judged_from_s};
use rsrs_fleet::record::{EndingKind, ExperimentRecord, LostRobot};
use serde::{Deserialize, Serialize};

use crate::error::in_one_line;
use crate::recorded_run;

/// Tries of a run in the simulator, with the first: a machine that is too busy is so for a while.
pub const SIMULATED_TRIES: u32 = 3;

/// Stands before the reason for which a run that was completed is no result.
pub const NOT_JUDGED: &str = "not judged: ";

/// What stands in the place of an ending where the recording has none.
pub const BROKEN_OFF: &str = "broken_off";

/// A run that gave no result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Attempt {
    /// Names the run; empty where its recording broke off before it was in it.
    pub run_id: String,
    /// Its robots.
    pub robots: Vec<String>,
    /// How it ended: `completed` where it could not be judged, `void`, `aborted`, `failed`, or
    /// `broken_off` where the program was killed.
    pub ending: String,
    /// Why it is no result.
    pub reason: String,
    /// Whether its robots were allowed to move: only then may the cause be what the swarm did.
    pub has_started: bool,
    /// Robots that were lost on the way, and when.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lost_robots: Vec<LostRobot>,
    /// Name of the folder in which its recording is kept, beside that of the bag that counts; `None` if
    /// nothing was recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bag: Option<String>,
}

impl Attempt {
    /// What is to be kept of a run of which there is a recording; where that is damaged, what it still has.
    pub fn of_recording(folder: &Path) -> Self {
        let name = folder.file_name().map(|name| name.to_string_lossy().into_owned());
        let mut attempt = Self {
            run_id: String::new(),
            robots: Vec::new(),
            ending: BROKEN_OFF.to_owned(),
            reason: "the recording broke off".to_owned(),
            has_started: false,
            lost_robots: Vec::new(),
            bag: name,
        };
        let bag = match recorded_run::open_damaged(folder) {
            Ok(bag) => bag,
            Err(error) => {
                attempt.reason = in_one_line(&error);
                return attempt;
            }
        };
        attempt.has_started = recorded_run::has_started(&bag);
        if let Ok(Some(record)) = recorded_run::record_in(&bag) {
            (attempt.run_id, attempt.robots) = (record.run_id, record.robots);
        }
        if let Ok(Some(ending)) = recorded_run::ending_in(&bag) {
            ending.kind.key().clone_into(&mut attempt.ending);
            attempt.reason = match ending.kind {
                EndingKind::Completed => "it was not judged".to_owned(),
                _ => ending.reason,
            };
            attempt.lost_robots = ending.lost;
        }
        attempt
    }

    /// Whether the same run is made again, with the same seed, without anybody's decision: after
    /// `n_tries` runs, this one included, of at most `most_tries`.
    ///
    /// A run that failed before its robots moved, that is void or could not be judged has shown
    /// nothing of its result. Nor has one that ended because a robot was lost before the time began
    /// that is judged. What a person has stopped, and what failed later, is a person's to look at.
    pub fn is_made_again(&self, record: &ExperimentRecord, n_tries: u32, most_tries: u32) -> bool {
        let may_be = match EndingKind::from_key(&self.ending) {
            Some(EndingKind::Completed | EndingKind::Void) => true,
            Some(EndingKind::Failed) => !self.has_started,
            Some(EndingKind::Aborted) => self.lost_a_robot_early(record),
            None => false,
        };
        may_be && n_tries < most_tries
    }

    /// Whether the rule of the experiment ended it because of a robot, before its result began to show.
    fn lost_a_robot_early(&self, record: &ExperimentRecord) -> bool {
        let judged_from_s = judged_from_s(record.duration_s, record.conditions.behaviour.window());
        let is_rule = record.robot_lost != RobotLost::Note;
        let is_early = |lost: &LostRobot| lost.after_s < judged_from_s;
        is_rule && !self.lost_robots.is_empty() && self.lost_robots.iter().all(is_early)
    }
}

impl fmt::Display for Attempt {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {}", self.ending.replace('_', " "), self.reason)
    }
}

/// Ends the name of a folder with a recording that does not count.
const ASIDE: &str = ".unfinished_";

/// Puts a recording that does not count aside, under a name that cannot be taken for the bag, and
/// returns its new path; `None` if there was none.
pub fn keep_aside(bag: &Path) -> anyhow::Result<Option<PathBuf>> {
    if !bag.exists() {
        return Ok(None);
    }
    let mut name = bag.as_os_str().to_owned();
    name.push(ASIDE);
    let numbered = |number: u64| {
        let mut name = name.clone();
        name.push(number.to_string());
        PathBuf::from(name)
    };
    let mut number = 1;
    while numbered(number).exists() {
        number += 1;
    }
    let aside = numbered(number);
    std::fs::rename(bag, &aside)
        .with_context(|| format!("cannot move {} to {}", bag.display(), aside.display()))?;
    Ok(Some(aside))
}

/// The number of a recording that is kept aside, by its name; `None` for anything else.
pub fn number_aside(bag: &str, name: &str) -> Option<u64> {
    name.strip_prefix(bag)?.strip_prefix(ASIDE)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    use rsrs_testing::conditions::flockbot_conditions;
    use rsrs_testing::record::fleet_record;

    fn record(robot_lost: RobotLost) -> ExperimentRecord {
        ExperimentRecord { robot_lost, ..fleet_record("0", flockbot_conditions()) }
    }

    fn attempt(ending: EndingKind, started_for_s: Option<f64>, lost_s: &[f64]) -> Attempt {
        let lost = |after_s: &f64| LostRobot {
            robot: "robot_1".to_owned(),
            after_s: *after_s,
            reason: "silent".to_owned(),
        };
        Attempt {
            run_id: "run".to_owned(),
            robots: vec!["robot_1".to_owned()],
            ending: ending.key().to_owned(),
            reason: String::new(),
            has_started: started_for_s.is_some(),
            lost_robots: lost_s.iter().map(lost).collect(),
            bag: None,
        }
    }

    #[test]
    fn what_is_made_again_has_a_cause_that_was_known_before_the_result() {
        use EndingKind::{Aborted, Completed, Failed, Void};

        for (attempt, rule, expected) in [
            (attempt(Void, Some(20.0), &[]), RobotLost::Abort, true),
            // Not judged, or it were none.
            (attempt(Completed, Some(300.0), &[]), RobotLost::Abort, true),
            (attempt(Failed, None, &[]), RobotLost::Abort, true),
            (attempt(Failed, Some(5.0), &[]), RobotLost::Abort, false),
            // Somebody has stopped it.
            (attempt(Aborted, None, &[]), RobotLost::Abort, false),
            (attempt(Aborted, Some(20.0), &[]), RobotLost::Abort, false),
            (attempt(Aborted, Some(20.0), &[20.0]), RobotLost::Note, false),
            (attempt(Aborted, Some(239.0), &[239.0]), RobotLost::Abort, true),
            (attempt(Aborted, Some(239.0), &[239.0]), RobotLost::AbortUntilJudged, true),
            // It is already judged then.
            (attempt(Aborted, Some(241.0), &[241.0]), RobotLost::Abort, false),
            (attempt(Aborted, Some(280.0), &[241.0]), RobotLost::AbortUntilJudged, false),
        ] {
            let record = record(rule);

            assert_eq!(attempt.is_made_again(&record, 1, 3), expected, "{attempt:?} {rule:?}");
            assert!(!attempt.is_made_again(&record, 3, 3), "three times in all");
        }
    }

    #[test]
    fn recordings_that_are_kept_aside_do_not_replace_each_other() {
        let place = tempfile::tempdir().unwrap();
        let bag = place.path().join("bag");
        let keep = || {
            std::fs::create_dir(&bag).unwrap();
            keep_aside(&bag).unwrap().unwrap().file_name().unwrap().to_owned()
        };

        assert_eq!([keep(), keep()], ["bag.unfinished_1", "bag.unfinished_2"]);
        assert_eq!(keep_aside(&bag).unwrap(), None);
        assert_eq!(number_aside("bag", "bag.unfinished_12"), Some(12));
        assert_eq!(number_aside("bag", "bag.unfinished_x"), None);
    }

    #[test]
    fn a_recording_that_cannot_be_read_is_an_attempt_all_the_same() {
        let place = tempfile::tempdir().unwrap();

        let attempt = Attempt::of_recording(place.path());

        assert_eq!((attempt.ending.as_str(), attempt.has_started), ("broken_off", false));
        assert!(attempt.reason.contains("metadata.yaml") || !attempt.reason.is_empty());
    }
}
