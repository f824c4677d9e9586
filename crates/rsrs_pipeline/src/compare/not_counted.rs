//! Runs that do not count in a comparison, and why.

use std::path::PathBuf;

use rsrs_core::quantity::Cell;
use rsrs_fleet::record::{EndingKind, LostRobot};
use serde::Serialize;

/// Why a run does not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NotCountedCause {
    /// The run was void.
    Void,
    /// It was stopped before its end.
    Aborted,
    /// It could not be started, or not be recorded.
    Failed,
    /// It went on without a robot that was lost.
    RobotLost,
    /// Its end is not recorded, or its recording is not whole.
    Incomplete,
    /// Another run was made in its place.
    MadeAgain,
    /// Its poses cannot be those of the commanded robots, or a robot did not move.
    Implausible,
    /// The judge cannot label it, or the person whose labels count has not.
    NotLabelled,
}

impl NotCountedCause {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Void,
        Self::Aborted,
        Self::Failed,
        Self::RobotLost,
        Self::Incomplete,
        Self::MadeAgain,
        Self::Implausible,
        Self::NotLabelled,
    ];

    /// The cause that an ending is by itself; `None` for a run that was completed.
    pub fn of_ending(kind: EndingKind) -> Option<Self> {
        match kind {
            EndingKind::Completed => None,
            EndingKind::Void => Some(Self::Void),
            EndingKind::Aborted => Some(Self::Aborted),
            EndingKind::Failed => Some(Self::Failed),
        }
    }

    /// Whether the run was made, and what it showed is lost.
    pub fn is_lost_evidence(self) -> bool {
        matches!(self, Self::Incomplete | Self::NotLabelled)
    }
}

/// A run that does not count, with the index of its cell in the diagram.
#[derive(Clone, Debug)]
pub struct LeftOutRun {
    /// The index.
    pub cell: usize,
    /// Which run it is of those whose number was fixed.
    pub number: Option<u64>,
    /// The run.
    pub not_counted: NotCounted,
}

/// One run that does not count.
#[derive(Clone, Debug, Serialize)]
pub struct NotCounted {
    /// Its bag.
    pub bag: PathBuf,
    /// Its cell.
    pub cell: Cell,
    /// Why it does not count.
    pub cause: NotCountedCause,
    /// How it ended: `completed`, `void`, `aborted`, `failed`, or `unknown`.
    pub ending: &'static str,
    /// The cause in full, as it was recorded or found.
    pub reason: String,
    /// Robots that did not take part to the end.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lost_robots: Vec<LostRobot>,
    /// Whether it was left out for a cause after its start, so that the cause may be what the swarm did.
    pub after_start: bool,
}
