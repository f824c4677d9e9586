//! Between which values a number can mean anything.

use std::fmt;

use crate::robot::profile::{MAX_HALF_ANGLE_RAD, MOST_FRICTION, PERIOD_BOUNDS_S};

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
    /// A coefficient of friction.
    pub const FRICTION: Self = Self { least: 0.0, most: MOST_FRICTION };
    /// Half of a cone's opening angle, in radians; 0 is a line of sight.
    pub const HALF_ANGLE: Self = Self { least: 0.0, most: MAX_HALF_ANGLE_RAD };
    /// What may be nothing: speeds, deviations, delays.
    pub const AMOUNT: Self = Self { least: 0.0, most: 1e3 };
    /// What may point to either side: speeds and turning rates.
    pub const SIGNED: Self = Self { least: -1e3, most: 1e3 };
    /// What has an extent: lengths in metres, and times over which something fades, in seconds.
    pub const SIZE: Self = Self { least: 1e-6, most: 1e6 };
    /// A coordinate of a place, in metres; a heading of a start table, in radians, is held to the same.
    pub const COORDINATE: Self = Self { least: -1e6, most: 1e6 };
    /// A control period, in seconds.
    pub const PERIOD: Self = Self { least: PERIOD_BOUNDS_S[0], most: PERIOD_BOUNDS_S[1] };
    /// A bearing, in radians: half around to either side.
    pub const BEARING: Self = Self { least: -3.15, most: 3.15 };

    /// Whether a number lies within; what is not a number does not.
    pub fn contains(self, found: f64) -> bool {
        (self.least..=self.most).contains(&found)
    }
}

impl fmt::Display for Bounds {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "from {} to {}", self.least, self.most)
    }
}

/// Most robots in one world; beyond it, memory and not the method would end the run.
const MAX_ROBOTS: usize = 1_000_000;
