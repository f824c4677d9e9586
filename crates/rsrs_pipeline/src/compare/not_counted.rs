//! Runs that do not count in a comparison, and why.

use std::fmt;
use std::path::PathBuf;

use rsrs_core::quantity::Cell;
use rsrs_fleet::record::{EndingKind, LostRobot};
use serde::Serialize;

/// Why a run does not count; its words are here and nowhere else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
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

impl Cause {
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

    /// What can be done about it, beside leaving the run out; `None` if that is all.
    pub fn option(self) -> Option<&'static str> {
        match self {
            Self::RobotLost => Some("`--with-lost-robots` counts such runs, too"),
            Self::Implausible => Some("`--with-implausible` counts such runs, too"),
            Self::Void
            | Self::Aborted
            | Self::Failed
            | Self::Incomplete
            | Self::MadeAgain
            | Self::NotLabelled => None,
        }
    }
}

/// The cause in front of its reason.
impl fmt::Display for Cause {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Void => "void",
            Self::Aborted => "aborted",
            Self::Failed => "failed",
            Self::RobotLost => "went on without a robot",
            Self::Incomplete => "not whole",
            Self::MadeAgain => "made again",
            Self::Implausible => "implausible",
            Self::NotLabelled => "not labelled",
        })
    }
}

/// One run that does not count.
#[derive(Clone, Debug, Serialize)]
pub struct NotCounted {
    /// Its bag.
    pub bag: PathBuf,
    /// Its cell.
    pub cell: Cell,
    /// Why it does not count.
    pub cause: Cause,
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
