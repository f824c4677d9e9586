//! How the ending of a run is recorded.

use super::grouped::grouped;
use super::outcome::Outcome;
use crate::record::{Ending, EndingKind, LostRobot, PausedRobot};

impl Ending {
    /// The ending that an outcome is, with the robots that were lost on the way, and those that
    /// stood and went on.
    pub fn new(outcome: &Outcome, lost: &[LostRobot], paused: &[PausedRobot]) -> Self {
        let (kind, reason) = match outcome {
            Outcome::Completed => (EndingKind::Completed, String::new()),
            Outcome::Void { reason } => (EndingKind::Void, reason.clone()),
            Outcome::Aborted { reason } => (EndingKind::Aborted, reason.clone()),
            Outcome::Failed { problems } => (EndingKind::Failed, grouped(problems).join("; ")),
        };
        Self { kind, reason, lost: lost.to_vec(), paused: paused.to_vec() }
    }
}
