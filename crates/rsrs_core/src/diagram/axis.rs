//! Axes of a sweep, and their values.

mod cell;
mod unit;

use std::fmt;
use std::str::FromStr;

use serde::de::{self, Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use serde::{Serialize, Serializer};

use crate::document::nearest;
use crate::robot::harsher::tidy;

pub use cell::{Cell, CellError};
pub use unit::OtherUnit;

/// A quantity that a sweep can vary.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Axis {
    /// Forward speed `v`, in metres per second.
    Speed,
    /// Turning rate `ω`, in radians per second.
    TurnRate,
    /// Forward speed where nothing is detected, in metres per second; without a value `v`.
    UndetectedSpeed,
    /// Turning rate where nothing is detected, in radians per second; without a value `-ω`.
    UndetectedTurnRate,
    /// Number of robots `N`.
    Robots,
    /// Radius of the disc in which robots start, in metres.
    PlacementRadius,
    /// Side of the square arena, in metres.
    Arena,
    /// Range of the sensor, in metres: a polygon keeps its shape, and its farthest corner is there.
    Range,
    /// Half of the sensor's opening angle, in radians: a polygon is stretched across its own axis, and
    /// its range stays.
    HalfAngle,
    /// Size of a sensing polygon, relative to the profile's; dimensionless.
    PolygonScale,
    /// Probability of detecting a neighbour in the region.
    TruePositive,
    /// Probability of a detection without one.
    FalsePositive,
    /// Standard deviation of both gains between robots, absolute; dimensionless.
    Heterogeneity,
    /// Steps by which a detection arrives late.
    LatencySteps,
    /// Standard deviation of the velocity disturbance, in metres per second.
    Gust,
    /// Time constant of the turning rate, in seconds.
    YawLag,
    /// Control period `Δt`, in seconds.
    Period,
    /// By how much the sensing region is turned about the robot, in radians; left is positive.
    SensorBearing,
    /// Mean gain of the speed, `θᵃ₁`, at every command; dimensionless.
    SpeedGain,
    /// Mean gain of the turning rate, `θᵃ₂`, at every command; dimensionless.
    TurnGain,
    /// Standard deviation of both gains from step to step; dimensionless.
    GainNoise,
    /// Standard deviation between robots of a turning rate that was not commanded, in radians per second.
    TurnBias,
    /// Standard deviation of the heading's random change per step, in radians.
    HeadingNoise,
}

impl Axis {
    /// All axes, those that an operator can set first.
    pub const ALL: [Self; 23] = [
        Self::Speed,
        Self::TurnRate,
        Self::UndetectedSpeed,
        Self::UndetectedTurnRate,
        Self::Robots,
        Self::PlacementRadius,
        Self::Arena,
        Self::Range,
        Self::HalfAngle,
        Self::PolygonScale,
        Self::TruePositive,
        Self::FalsePositive,
        Self::Heterogeneity,
        Self::LatencySteps,
        Self::Gust,
        Self::YawLag,
        Self::Period,
        Self::SensorBearing,
        Self::SpeedGain,
        Self::TurnGain,
        Self::GainNoise,
        Self::TurnBias,
        Self::HeadingNoise,
    ];

    /// The name in files and on the command line: `speed_m_s`.
    pub fn key(self) -> &'static str {
        match self {
            Self::Speed => "speed_m_s",
            Self::TurnRate => "turn_rate_rad_s",
            Self::UndetectedSpeed => "undetected_speed_m_s",
            Self::UndetectedTurnRate => "undetected_turn_rate_rad_s",
            Self::Robots => "robots",
            Self::PlacementRadius => "placement_radius_m",
            Self::Arena => "arena_m",
            Self::Range => "range_m",
            Self::HalfAngle => "half_angle_rad",
            Self::PolygonScale => "polygon_scale",
            Self::TruePositive => "true_positive",
            Self::FalsePositive => "false_positive",
            Self::Heterogeneity => "heterogeneity",
            Self::LatencySteps => "latency_steps",
            Self::Gust => "gust_m_s",
            Self::YawLag => "yaw_lag_s",
            Self::Period => "period_s",
            Self::SensorBearing => "sensor_bearing_rad",
            Self::SpeedGain => "speed_gain",
            Self::TurnGain => "turn_gain",
            Self::GainNoise => "gain_noise",
            Self::TurnBias => "turn_bias_rad_s",
            Self::HeadingNoise => "heading_noise_rad",
        }
    }

    /// The label on a picture's axis: `speed (m/s)`.
    pub fn label(self) -> &'static str {
        match self {
            Self::Speed => "speed (m/s)",
            Self::TurnRate => "turning rate (rad/s)",
            Self::UndetectedSpeed => "speed, nothing detected (m/s)",
            Self::UndetectedTurnRate => "turning rate, nothing detected (rad/s)",
            Self::Robots => "number of robots",
            Self::PlacementRadius => "placement radius (m)",
            Self::Arena => "side of the arena (m)",
            Self::Range => "sensing range (m)",
            Self::HalfAngle => "sensing half-angle (rad)",
            Self::PolygonScale => "scale of the sensing polygon",
            Self::TruePositive => "true-positive probability",
            Self::FalsePositive => "false-positive probability",
            Self::Heterogeneity => "standard deviation of the gains",
            Self::LatencySteps => "latency (steps)",
            Self::Gust => "gusts, standard deviation (m/s)",
            Self::YawLag => "yaw lag (s)",
            Self::Period => "control period (s)",
            Self::SensorBearing => "turn of the sensor (rad)",
            Self::SpeedGain => "gain of the speed",
            Self::TurnGain => "gain of the turning rate",
            Self::GainNoise => "gain noise, standard deviation per step",
            Self::TurnBias => "turn bias, standard deviation (rad/s)",
            Self::HeadingNoise => "heading noise, standard deviation per step (rad)",
        }
    }

    /// The unit behind a number: `m/s`; empty for dimensionless axes.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Speed | Self::UndetectedSpeed | Self::Gust => "m/s",
            Self::TurnRate | Self::UndetectedTurnRate | Self::TurnBias => "rad/s",
            Self::PlacementRadius | Self::Arena | Self::Range => "m",
            Self::HalfAngle | Self::SensorBearing | Self::HeadingNoise => "rad",
            Self::YawLag | Self::Period => "s",
            Self::LatencySteps => "steps",
            Self::Robots => "robots",
            Self::PolygonScale
            | Self::TruePositive
            | Self::FalsePositive
            | Self::Heterogeneity
            | Self::SpeedGain
            | Self::TurnGain
            | Self::GainNoise => "",
        }
    }

    /// Whether the axis is a property of the robots rather than a setting: it cannot be set on a
    /// real fleet.
    pub fn is_capability(self) -> bool {
        !matches!(
            self,
            Self::Speed
                | Self::TurnRate
                | Self::UndetectedSpeed
                | Self::UndetectedTurnRate
                | Self::Robots
                | Self::PlacementRadius
                | Self::Arena
        )
    }

    /// Whether only whole numbers make sense.
    pub fn is_count(self) -> bool {
        matches!(self, Self::Robots | Self::LatencySteps)
    }
}

/// A name that is no axis.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown axis `{found}`{}", nearest.map_or_else(String::new, |key| format!("; did you mean `{key}`?")))]
pub struct UnknownAxis {
    /// The name found.
    pub found: String,
    /// The axis closest in spelling.
    pub nearest: Option<&'static str>,
}

impl FromStr for Axis {
    type Err = UnknownAxis;

    fn from_str(key: &str) -> Result<Self, UnknownAxis> {
        Self::ALL.into_iter().find(|axis| axis.key() == key).ok_or_else(|| UnknownAxis {
            found: key.to_owned(),
            nearest: nearest(key, Self::ALL.map(Self::key)),
        })
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.key())
    }
}

impl Serialize for Axis {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.key())
    }
}

impl<'de> Deserialize<'de> for Axis {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let key = String::deserialize(deserializer)?;
        key.parse().map_err(de::Error::custom)
    }
}

/// The values of one axis: spelled out as a list, or evenly spaced `{from, to, steps}`.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisValues(pub Vec<f64>);

impl AxisValues {
    /// Evenly spaced values, both ends included.
    pub fn evenly_spaced(from: f64, to: f64, steps: usize) -> Self {
        let intervals = steps.saturating_sub(1).max(1) as f64;
        Self((0..steps).map(|step| tidy(from + (to - from) * step as f64 / intervals)).collect())
    }
}

impl Serialize for AxisValues {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

/// Limit on the values of one axis; more are a mistake, and would not fit into memory.
const MOST_STEPS: usize = 1_000_000;

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Spaced {
    from: f64,
    to: f64,
    steps: usize,
}

impl<'de> Deserialize<'de> for AxisValues {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct ValuesVisitor;
        impl<'de> Visitor<'de> for ValuesVisitor {
            type Value = AxisValues;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a list of numbers or {from, to, steps}")
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<AxisValues, A::Error> {
                let mut values = Vec::new();
                while let Some(value) = list.next_element()? {
                    values.push(value);
                }
                Ok(AxisValues(values))
            }
            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<AxisValues, A::Error> {
                let spaced = Spaced::deserialize(de::value::MapAccessDeserializer::new(map))?;
                for (key, end) in [("from", spaced.from), ("to", spaced.to)] {
                    if !end.is_finite() {
                        return Err(de::Error::custom(format!(
                            "`{key}` is {end}, expected a finite number"
                        )));
                    }
                }
                if spaced.steps > MOST_STEPS {
                    return Err(de::Error::custom(format!(
                        "`steps` is {}, expected at most {MOST_STEPS}",
                        spaced.steps
                    )));
                }
                Ok(AxisValues::evenly_spaced(spaced.from, spaced.to, spaced.steps))
            }
        }
        deserializer.deserialize_any(ValuesVisitor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn evenly_spaced_values_are_the_numbers_a_person_would_write() {
        let values = AxisValues::evenly_spaced(0.05, 0.30, 11);

        assert_eq!(values.0[4].to_bits(), 0.15_f64.to_bits());
        assert_eq!(values.0.len(), 11);
    }
}
