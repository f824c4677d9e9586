//! What a sensor tells besides whether a neighbour is in its region, and what all sensors of a robot report together.

pub mod file;
mod flaw;
mod readings;

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::numerals::is_zero;
use crate::robot::profile::{RobotProfile, Sensing};

pub use flaw::{SensorFlaw, SensorProblem};
pub use readings::{FurtherReadings, MOST_READINGS, ReadingNames, Readings};

/// The reading that every robot has: a topic of this name, and a robot decides once for each message on it.
pub const DETECTION: &str = "detection";

/// A kind of thing that sensors detect.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Detects {
    /// Another robot, of whatever class.
    #[default]
    Robot,
    /// Another robot of its own class.
    Kin,
    /// A robot of another class.
    Other,
    /// A wall of the arena: wherever the region reaches it.
    Wall,
    /// An object of the world.
    Object,
    /// A goal of the world.
    Goal,
}

impl Detects {
    /// All kinds.
    pub const ALL: [Self; 6] =
        [Self::Robot, Self::Kin, Self::Other, Self::Wall, Self::Object, Self::Goal];

    /// Its name in files.
    pub fn key(self) -> &'static str {
        match self {
            Self::Robot => "robot",
            Self::Kin => "kin",
            Self::Other => "other",
            Self::Wall => "wall",
            Self::Object => "object",
            Self::Goal => "goal",
        }
    }

    /// One of its kind, in words: `a wall`.
    pub fn one(self) -> &'static str {
        match self {
            Self::Robot => "a robot",
            Self::Kin => "a robot of its own class",
            Self::Other => "a robot of another class",
            Self::Wall => "a wall",
            Self::Object => "an object",
            Self::Goal => "a goal",
        }
    }

    /// All of its kind, in words: `walls`.
    pub fn all(self) -> &'static str {
        match self {
            Self::Robot => "robots",
            Self::Kin => "robots of its own class",
            Self::Other => "robots of other classes",
            Self::Wall => "walls",
            Self::Object => "objects",
            Self::Goal => "goals",
        }
    }

    /// Whether it is some robots or all of them.
    pub fn is_robot(self) -> bool {
        matches!(self, Self::Robot | Self::Kin | Self::Other)
    }

    /// What is of this kind and of another one as well: the narrower one of both.
    pub fn shared_with(self, other: Self) -> Option<Self> {
        match (self, other) {
            (Self::Robot, narrower) | (narrower, Self::Robot) if narrower.is_robot() => {
                Some(narrower)
            }
            _ => (self == other).then_some(self),
        }
    }

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
    fn is_usual(&self) -> bool {
        *self == Self::default()
    }
}

impl fmt::Display for Detects {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.key())
    }
}

/// One kind of thing that a sensor tells from others, with what it reports of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Reading {
    /// Name of the reading: what rows of a controller's table call it, and its topic, `detection/NAME`. That of the
    /// first sensor is `detection`.
    pub name: String,
    /// What it is of; each kind once.
    pub detects: Detects,
    /// Probability that it is reported where its kind is nearest.
    pub true_positive: f64,
    /// Probability that it is reported where nothing is.
    pub false_positive: f64,
    /// The other readings of the sensor that are reported instead where its kind is nearest, and how likely each is:
    /// the rest of its row of the confusion table (default: none).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub taken_for: BTreeMap<String, f64>,
}

/// What a sensor tells beyond whether a neighbour is in a region that points ahead. That of a plain one is the default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorDetails {
    /// What its first reading is of.
    #[serde(default, skip_serializing_if = "Detects::is_usual")]
    pub detects: Detects,
    /// By how much its region is turned about the robot, in radians; left is positive.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub bearing_rad: f64,
    /// What hides things behind it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hidden_by: Vec<Detects>,
    /// As [`Reading::taken_for`], of the first reading.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub taken_for: BTreeMap<String, f64>,
    /// Further kinds in the same region, of which the nearest thing counts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub or: Vec<Reading>,
}

impl SensorDetails {
    /// Whether it detects neighbours ahead and nothing else, and nothing hides them.
    pub fn is_plain(&self) -> bool {
        *self == Self::default()
    }

    /// The names of all readings of a sensor whose first one has this name.
    pub fn names(&self, first: &str) -> Vec<String> {
        let others = self.or.iter().map(|reading| reading.name.clone());
        std::iter::once(first.to_owned()).chain(others).collect()
    }

    /// How many readings it has.
    pub fn n_readings(&self) -> usize {
        1 + self.or.len()
    }

    /// What its readings are of, the first one first.
    pub fn kinds(&self) -> impl Iterator<Item = Detects> + '_ {
        std::iter::once(self.detects).chain(self.or.iter().map(|reading| reading.detects))
    }
}

/// A sensor besides the first.
#[derive(Clone, Debug, PartialEq)]
pub struct FurtherSensor {
    /// Name of its first reading.
    pub name: String,
    /// What it detects.
    pub sensing: Sensing,
}

impl RobotProfile {
    /// Whether its one sensor detects neighbours ahead, and nothing else.
    pub fn has_one_plain_sensor(&self) -> bool {
        self.further_sensors.is_empty() && self.sensing.details.is_plain()
    }

    /// Its sensors with the names of their first readings, the first sensor first.
    pub fn sensors(&self) -> impl Iterator<Item = (&str, &Sensing)> {
        let further = self.further_sensors.iter();
        std::iter::once((DETECTION, &self.sensing))
            .chain(further.map(|sensor| (sensor.name.as_str(), &sensor.sensing)))
    }

    /// The same, to be changed.
    pub fn sensings_mut(&mut self) -> impl Iterator<Item = &mut Sensing> {
        let further = self.further_sensors.iter_mut().map(|sensor| &mut sensor.sensing);
        std::iter::once(&mut self.sensing).chain(further)
    }

    /// What it reports, by name.
    pub fn reading_names(&self) -> ReadingNames {
        ReadingNames::new(self.sensors().map(|(name, sensing)| sensing.details.names(name)))
    }
}
