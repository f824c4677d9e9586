//! Between which values a number can mean anything.

use std::fmt;

/// The least and the greatest value that a number may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The least.
    pub least: f64,
    /// The greatest.
    pub most: f64,
}

impl Bounds {
    /// Number of robots.
    pub const ROBOTS: Self = Self { least: 0.0, most: MAX_ROBOTS as f64 };
    /// A probability.
    pub const PROBABILITY: Self = Self { least: 0.0, most: 1.0 };
    /// A coefficient of friction between two bodies: rubber on rubber has half of the greatest.
    pub const FRICTION: Self = Self { least: 0.0, most: 2.0 };
    /// Half of a cone's opening angle, in radians: 0 is a line of sight, and the edges of the widest stay in front
    /// of the robot.
    pub const HALF_ANGLE: Self = Self { least: 0.0, most: 1.5 };
    /// What may be nothing: speeds, deviations, delays.
    pub const AMOUNT: Self = Self { least: 0.0, most: 1e3 };
    /// What may point to either side: speeds and turning rates.
    pub const SIGNED: Self = Self { least: -1e3, most: 1e3 };
    /// A robot's mean gain: what it does is so many times what is commanded.
    pub const GAIN: Self = Self { least: 1e-6, most: 1e3 };
    /// What has an extent: lengths in metres, and times over which something fades, in seconds.
    pub const SIZE: Self = Self { least: 1e-6, most: 1e6 };
    /// A coordinate of a place, in metres; a heading of a start table, in radians, is held to the same.
    pub const COORDINATE: Self = Self { least: -1e6, most: 1e6 };
    /// A control period, in seconds: nobody drives by detections that are rarer.
    pub const PERIOD: Self = Self { least: 0.001, most: 2.0 };
    /// A bearing, in radians: half around to either side.
    pub const BEARING: Self = Self { least: -HALF_TURN_RAD, most: HALF_TURN_RAD };
    /// Half of a sector around a robot's heading, in radians: up to all around.
    pub const SECTOR: Self = Self { least: 0.0, most: HALF_TURN_RAD };

    /// Whether a number lies within; what is not a number does not.
    pub fn contains(self, found: f64) -> bool {
        (self.least..=self.most).contains(&found)
    }

    /// What a number within is, for the error about one that is not.
    pub(crate) fn number(self) -> String {
        format!("a number {self}")
    }

    /// What a probability is.
    pub(crate) fn probability(self) -> String {
        format!("a probability {self}")
    }
}

impl fmt::Display for Bounds {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "from {} to {}", self.least, self.most)
    }
}

/// Half a turn, in radians, and what people add who write it with two decimals.
const HALF_TURN_RAD: f64 = 3.15;

/// Most robots in one world; beyond it, memory and not the method would end the run.
const MAX_ROBOTS: usize = 1_000_000;
