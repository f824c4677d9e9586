//! Why a profile and settings do not make conditions.

use super::check::Impossible;
use super::controller_table::TableFlaw;
use super::limits::BeyondLimits;
use crate::document::did_you_mean;
use crate::help::Help;
use crate::quantity::Axis;
use crate::robot::harsher::NotHarsher;
use crate::robot::profile::ProfileError;

/// Why a profile and settings do not make conditions.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConditionsError {
    /// The robot is impossible.
    #[error(transparent)]
    Robot(#[from] ProfileError),
    /// The numbers together make no world.
    #[error(transparent)]
    Impossible(#[from] Impossible),
    /// A setting without which there is no experiment.
    #[error("no value for {0}")]
    Missing(Axis),
    /// A value outside what the axis can mean.
    #[error("{axis} is {found}, expected {expected}")]
    OutOfRange {
        /// The axis.
        axis: Axis,
        /// The value found.
        found: f64,
        /// What it may be.
        expected: String,
    },
    /// An axis that this robot does not have.
    #[error("{axis} does not apply to a robot {which}")]
    NotOfThisRobot {
        /// The axis.
        axis: Axis,
        /// What robots are that do not have it: `whose sensor is a cone`.
        which: &'static str,
    },
    /// A speed or turning rate beside a table that has them.
    #[error("{axis} is that of a controller without a table")]
    BesideTable {
        /// The axis.
        axis: Axis,
        /// The table's own numbers, as axes.
        numbers: Vec<String>,
    },
    /// A number that the controller's table does not have.
    #[error("{axis} is no number of the controller's table{}", did_you_mean(nearest.as_deref()))]
    NoSuchNumber {
        /// The axis.
        axis: Axis,
        /// The number closest in spelling, as an axis.
        nearest: Option<String>,
        /// All numbers of the table, as axes.
        numbers: Vec<String>,
    },
    /// A number of a table where there is none.
    #[error("{0} is a number of a controller's table, and none is named")]
    NoTable(Axis),
    /// A side of a square beside a world whose arena is none.
    #[error("`arena_m` is {side_m} m, and the world has an arena of its own, {arena}")]
    ArenaTwice {
        /// In metres.
        side_m: f64,
        /// The world's, in words.
        arena: String,
    },
    /// A table that these robots cannot follow.
    #[error(transparent)]
    Table(#[from] TableFlaw),
    /// A robot among others whose controller is told other things.
    #[error("its sensors report {found}, and those of the first robots {expected}")]
    OtherReadings {
        /// Names of its readings, in words.
        found: String,
        /// Those of the first robots.
        expected: String,
    },
    /// A robot among others for which the table is another controller.
    #[error(
        "its wheels make other commands of the controller's table than those of the first robots"
    )]
    OtherWheels,
    /// A robot whose body is not as large as those that it is judged and drawn with.
    #[error("the radius of its body is {found_m} m, and that of the other robots {expected_m} m")]
    OtherRadius {
        /// In metres.
        found_m: f64,
        /// Of the first robots, in metres.
        expected_m: f64,
    },
    /// A robot that was measured at another control period than it would have here.
    #[error("its control period is {found_s} s, and that of the other robots {expected_s} s")]
    OtherPeriod {
        /// In seconds.
        found_s: f64,
        /// Of the first robots, in seconds.
        expected_s: f64,
    },
    /// A command that its profile forbids.
    #[error(transparent)]
    Limits(#[from] BeyondLimits),
    /// Factors that would make a better robot of it.
    #[error(transparent)]
    NotHarsher(#[from] NotHarsher),
    /// A class of robots that are not for this swarm.
    #[error("class {class}, by its own profile{}: {source}", at(path.as_deref()))]
    OfClass {
        /// The class.
        class: String,
        /// Path of its profile as the world names it; `None` of a world that holds it.
        path: Option<String>,
        /// Why.
        source: Box<ConditionsError>,
    },
    /// A class whose profile was not read.
    #[error("the profile of class {class}, {path}, was not read")]
    ProfileNotRead {
        /// The class.
        class: String,
        /// As the world names it.
        path: String,
    },
}

/// The path of a file, behind what it holds.
fn at(path: Option<&str>) -> String {
    path.map_or_else(String::new, |path| format!(" {path}"))
}

impl Help for ConditionsError {
    fn help(&self) -> Option<String> {
        let help = match self {
            Self::BesideTable { numbers, .. } | Self::NoSuchNumber { numbers, .. } => {
                return Some(match numbers.as_slice() {
                    [] => "its table has no `numbers`".to_owned(),
                    numbers => format!("the numbers of its table are: {}", numbers.join(", ")),
                });
            }
            Self::NoTable { .. } => "name its file: `controller: controllers/FILE.yaml`",
            Self::ArenaTwice { .. } => "leave `arena_m` out, or `arena` out of the world",
            Self::Table(flaw) => return flaw.help(),
            Self::Impossible(impossible) => return impossible.help(),
            Self::OtherReadings { .. } => "give its sensors the same names, in the same order",
            Self::OtherRadius { .. } => {
                "classes may differ in much, but contact and clusters are judged by one radius"
            }
            Self::OtherPeriod { .. } => "measure them at one control period, which their swarm has",
            Self::Limits(beyond) => return beyond.help(),
            Self::OfClass { source, .. } => return source.help(),
            _ => return None,
        };
        Some(help.to_owned())
    }
}
