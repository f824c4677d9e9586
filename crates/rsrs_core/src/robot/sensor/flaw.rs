//! What is wrong with a sensor of a list.

use std::borrow::Cow;

use super::{DETECTION, MAX_CORNERS, MOST_READINGS};
use crate::document::did_you_mean;
use crate::help::Help;

/// What is wrong with a list of sensors, and with which of them.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("sensor {} of the list: {problem}", sensor + 1)]
pub struct SensorFlaw {
    /// Which, from 0.
    pub sensor: usize,
    /// What.
    pub problem: SensorProblem,
}

/// What is wrong with a sensor.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SensorProblem {
    /// There is none.
    #[error("`sensors` is an empty list")]
    Nothing,
    /// A number outside what it can mean.
    #[error("`{key}` is {found}, expected {expected}")]
    OutOfRange {
        /// The key.
        key: &'static str,
        /// The number.
        found: f64,
        /// What it may be.
        expected: Cow<'static, str>,
    },
    /// A key without which it is no sensor.
    #[error("missing key `{0}`")]
    Missing(&'static str),
    /// A key that its readings have.
    #[error("`{0}` stands beside `one_of`, whose readings have it")]
    BesideOneOf(&'static str),
    /// Both a cone and a polygon, or neither.
    #[error("a sensor needs exactly one of `cone` and `polygon_m`")]
    Region,
    /// The polygon is no region.
    #[error(
        "`polygon_m` has {0} corners, expected 3 to {MAX_CORNERS}, convex and counterclockwise"
    )]
    Polygon(usize),
    /// A name that cannot be one.
    #[error(
        "`{0}` is no name of a reading: expected small letters, digits and `_`, a letter first"
    )]
    Name(String),
    /// The first reading has another name than that of every robot.
    #[error("the first reading is `{0}`, expected `{DETECTION}`")]
    First(String),
    /// A name of two readings.
    #[error("`{0}` is the name of two readings")]
    Twice(String),
    /// More readings than there can be.
    #[error("the readings of all sensors are {0}, expected at most {MOST_READINGS}")]
    Readings(usize),
    /// One reading alone is none of several.
    #[error("`one_of` has {0} readings, expected 2 or more")]
    OneOf(usize),
    /// Two readings of one kind.
    #[error("`{first}` and `{second}` both detect `{kind}`")]
    Kinds {
        /// A reading.
        first: String,
        /// Another one.
        second: String,
        /// What both are of.
        kind: &'static str,
    },
    /// A reading is taken for none of the sensor.
    #[error("`{found}` is no other reading of this sensor{}", did_you_mean(nearest.as_deref()))]
    TakenFor {
        /// The name.
        found: String,
        /// The other reading closest in spelling.
        nearest: Option<String>,
    },
    /// More than always.
    #[error("where {place} is, something is reported with probability {found}, expected at most 1")]
    Row {
        /// What is there.
        place: &'static str,
        /// The sum of a row of the confusion table.
        found: f64,
    },
}

impl Help for SensorProblem {
    fn help(&self) -> Option<String> {
        Some(match self {
            Self::Nothing => format!(
                "give a sensor: `- {{name: {DETECTION}, cone: {{half_angle_rad: 0.2, range_m: 0.5}}, …}}`"
            ),
            Self::OutOfRange { .. } => return None,
            Self::Missing("name") => format!(
                "give `name: {DETECTION}` for the first sensor and another one for each further, or `one_of` \
                 for several kinds of things in one region"
            ),
            Self::Missing(key) => format!("give `{key}:`"),
            Self::BesideOneOf(key) => format!("leave it out, or move `{key}` into its reading"),
            Self::Region => {
                "give `cone: {half_angle_rad: …, range_m: …}` or `polygon_m: [[x, y], …]`".to_owned()
            }
            Self::Polygon { .. } => {
                "list the corners around, left turn after left turn".to_owned()
            }
            Self::Name(found) => format!("write it as `{}`", plain(found)),
            Self::First(found) => format!(
                "call `{found}` `{DETECTION}`, or put the sensor with it first: a robot decides once for each \
                 message on this topic"
            ),
            Self::Twice { .. } => "give one of them another name: each is a topic".to_owned(),
            Self::Readings { .. } => {
                "leave some out: a controller needs a row for each of their cases".to_owned()
            }
            Self::OneOf { .. } => {
                "give a reading for each kind, or write the one without `one_of`".to_owned()
            }
            Self::Kinds { .. } => "leave one of them out".to_owned(),
            Self::TakenFor { .. } => {
                "name what else the sensor reports where this kind is: a reading of the same `one_of`".to_owned()
            }
            Self::Row { .. } => {
                "lower `true_positive`, `taken_for` or `false_positive`: a sensor reports one thing at a time"
                    .to_owned()
            }
        })
    }
}

impl Help for SensorFlaw {
    fn help(&self) -> Option<String> {
        self.problem.help()
    }
}

/// A text as a name.
fn plain(text: &str) -> String {
    let small = text.to_lowercase();
    let letters: String =
        small.chars().map(|it| if it.is_ascii_alphanumeric() { it } else { '_' }).collect();
    let letters = letters.trim_start_matches(|it: char| !it.is_ascii_lowercase());
    if letters.is_empty() { "ahead".to_owned() } else { letters.to_owned() }
}
