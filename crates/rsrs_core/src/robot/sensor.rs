//! Sensors: where each detects a neighbour, what else it tells, and what all of a robot report together.

pub mod file;
mod flaw;
mod readings;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::bounds::Bounds;
use crate::numerals::is_zero;
use crate::plane::{left_of, sides};

pub use flaw::{SensorFlaw, SensorProblem};
pub use readings::{FurtherReadings, MOST_READINGS, ReadingNames, Readings};

/// The reading that every robot has: a topic of this name, and a robot decides once for each message on it.
pub const DETECTION: &str = "detection";

/// Most corners of a sensing polygon.
pub const MAX_CORNERS: usize = 8;

/// What a robot detects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sensing {
    /// Whether a neighbour is seen when its body touches the region (`body`), or when its centre lies in it
    /// (`centre`).
    pub sees: Sees,
    /// A conical region; give this or `polygon_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cone: Option<Cone>,
    /// A convex polygon in the robot's frame (x forward, y left), counterclockwise, at most 8
    /// corners, in metres; shape `[n_corners][2]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub polygon_m: Option<Vec<[f64; 2]>>,
    /// Probability of a detection when a neighbour is in the region.
    pub true_positive: f64,
    /// Probability of a detection when none is.
    pub false_positive: f64,
    /// Steps by which a detection arrives late.
    pub latency_steps: u32,
    /// What only a list of sensors says.
    #[serde(skip)]
    pub details: SensorDetails,
}

impl Sensing {
    /// The probability of each of its readings where its kind is nearest.
    pub fn true_positives(&self) -> impl Iterator<Item = f64> {
        let others = self.details.or.iter().map(|reading| reading.true_positive);
        std::iter::once(self.true_positive).chain(others)
    }

    /// The probability of each of its readings where nothing is.
    pub fn false_positives(&self) -> impl Iterator<Item = f64> {
        let others = self.details.or.iter().map(|reading| reading.false_positive);
        std::iter::once(self.false_positive).chain(others)
    }
}

/// What of a neighbour must lie in the region to be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sees {
    /// Its body: the disc touches the region.
    Body,
    /// Its centre: `eq:output` to the letter, and what a fitted polygon means.
    Centre,
}

/// A cone in front of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cone {
    /// Half of the opening angle, in radians; 0 is a line of sight, which sees the bodies that it meets.
    pub half_angle_rad: f64,
    /// How far it reaches, in metres.
    pub range_m: f64,
}

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

/// Whether a cone can open so far, in radians; if not, what it may.
pub(crate) fn half_angle(angle_rad: f64, sees: Sees) -> Result<(), Cow<'static, str>> {
    let Bounds { least, most } = Bounds::HALF_ANGLE;
    if !Bounds::HALF_ANGLE.contains(angle_rad) {
        return Err(format!("from {least}, a line of sight, to {most} rad").into());
    }
    if angle_rad <= least && sees == Sees::Centre {
        return Err("above 0: no centre lies on a line of sight, which needs `sees: body`".into());
    }
    Ok(())
}

/// Whether corners form a convex polygon, counterclockwise, of a size that the simulator takes.
///
/// Every corner must lie to the left of every side that it is no end of: that is where the world looks
/// for a neighbour.
pub(crate) fn is_convex(corners: &[[f64; 2]]) -> bool {
    let n = corners.len();
    let others = |side: usize| (2..n).map(move |further| corners[(side + further) % n]);
    (3..=MAX_CORNERS).contains(&n)
        && corners.iter().flatten().all(|number| number.is_finite())
        && (sides(corners).enumerate())
            .all(|(number, side)| others(number).all(|corner| left_of(side, corner) > 0.0))
}
