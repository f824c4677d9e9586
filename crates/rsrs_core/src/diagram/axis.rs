//! Axes of a sweep, and cells: one value on each swept axis.

mod unit;

use std::fmt;
use std::str::FromStr;

use serde::de::{self, Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::document::nearest;
use crate::robot::harsher::tidy;

pub use unit::OtherUnit;

/// A quantity that a sweep can vary.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Axis {
    /// Forward speed `v`, in metres per second.
    Speed,
    /// Turning rate `ω`, in radians per second.
    TurnRate,
    /// Number of robots `N`.
    Robots,
    /// Radius of the disc in which robots start, in metres.
    PlacementRadius,
    /// Side of the square arena, in metres.
    Arena,
    /// Range of a cone, in metres.
    Range,
    /// Half of a cone's opening angle, in radians.
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
}

impl Axis {
    /// All axes, those that an operator can set first.
    pub const ALL: [Self; 15] = [
        Self::Speed,
        Self::TurnRate,
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
    ];

    /// The name in files and on the command line: `speed_m_s`.
    pub fn key(self) -> &'static str {
        match self {
            Self::Speed => "speed_m_s",
            Self::TurnRate => "turn_rate_rad_s",
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
        }
    }

    /// The label on a picture's axis: `speed (m/s)`.
    pub fn label(self) -> &'static str {
        match self {
            Self::Speed => "speed (m/s)",
            Self::TurnRate => "turning rate (rad/s)",
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
        }
    }

    /// The unit behind a number: `m/s`; empty for dimensionless axes.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Speed | Self::Gust => "m/s",
            Self::TurnRate => "rad/s",
            Self::PlacementRadius | Self::Arena | Self::Range => "m",
            Self::HalfAngle => "rad",
            Self::YawLag | Self::Period => "s",
            Self::LatencySteps => "steps",
            Self::Robots => "robots",
            Self::PolygonScale | Self::TruePositive | Self::FalsePositive | Self::Heterogeneity => {
                ""
            }
        }
    }

    /// Whether the axis is a property of the robots rather than a setting: it cannot be set on a
    /// real fleet.
    pub fn is_capability(self) -> bool {
        !matches!(
            self,
            Self::Speed | Self::TurnRate | Self::Robots | Self::PlacementRadius | Self::Arena
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

/// One point of a sweep: a value on each of some axes, in the order they were given.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    values: Vec<(Axis, f64)>,
}

/// Why a text is not a cell.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CellError {
    /// A part is not `axis=value`.
    #[error("`{found}` is not of the form axis=value")]
    NotAnAssignment {
        /// The part found.
        found: String,
    },
    /// The name is no axis.
    #[error(transparent)]
    Axis(#[from] UnknownAxis),
    /// The value is not a number.
    #[error("{axis}={found} is not a finite number")]
    NotANumber {
        /// The axis.
        axis: Axis,
        /// The text found.
        found: String,
    },
    /// The value is likely in another unit.
    #[error(transparent)]
    Unit(#[from] OtherUnit),
    /// An axis is given twice.
    #[error("{axis} is given twice")]
    Twice {
        /// The axis.
        axis: Axis,
    },
}

impl Cell {
    /// A cell from its values.
    ///
    /// # Errors
    ///
    /// [`CellError::Twice`] or [`CellError::NotANumber`].
    pub fn new(values: impl IntoIterator<Item = (Axis, f64)>) -> Result<Self, CellError> {
        let mut cell = Self::default();
        for (axis, value) in values {
            if cell.get(axis).is_some() {
                return Err(CellError::Twice { axis });
            }
            if !value.is_finite() {
                return Err(CellError::NotANumber { axis, found: value.to_string() });
            }
            cell.values.push((axis, value));
        }
        Ok(cell)
    }

    /// A cell as a person wrote it: values that look like millimetres or degrees are refused.
    fn written(values: Vec<(Axis, f64)>) -> Result<Self, CellError> {
        let cell = Self::new(values)?;
        for (axis, value) in cell.iter() {
            axis.check_unit(value)?;
        }
        Ok(cell)
    }

    /// The value on one axis.
    pub fn get(&self, axis: Axis) -> Option<f64> {
        self.values.iter().find(|(other, _)| *other == axis).map(|(_, value)| *value)
    }

    /// Axes and values in order.
    pub fn iter(&self) -> impl Iterator<Item = (Axis, f64)> + '_ {
        self.values.iter().copied()
    }

    /// The axes in order.
    pub fn axes(&self) -> Vec<Axis> {
        self.values.iter().map(|(axis, _)| *axis).collect()
    }
}

/// `speed_m_s=0.15,turn_rate_rad_s=0.75`.
impl fmt::Display for Cell {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (position, (axis, value)) in self.values.iter().enumerate() {
            let separator = if position == 0 { "" } else { "," };
            write!(formatter, "{separator}{axis}={value}")?;
        }
        Ok(())
    }
}

impl FromStr for Cell {
    type Err = CellError;

    fn from_str(text: &str) -> Result<Self, CellError> {
        let values = text.split(',').map(|part| {
            let (key, value) = part
                .split_once('=')
                .ok_or_else(|| CellError::NotAnAssignment { found: part.to_owned() })?;
            let axis: Axis = key.trim().parse()?;
            let number = value
                .trim()
                .parse::<f64>()
                .ok()
                .ok_or_else(|| CellError::NotANumber { axis, found: value.to_owned() })?;
            Ok((axis, number))
        });
        Self::written(values.collect::<Result<Vec<_>, CellError>>()?)
    }
}

impl Serialize for Cell {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.values.len()))?;
        for (axis, value) in &self.values {
            map.serialize_entry(axis.key(), value)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Cell {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct CellVisitor;
        impl<'de> Visitor<'de> for CellVisitor {
            type Value = Cell;
            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a map from axes to numbers")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Cell, A::Error> {
                let mut values = Vec::new();
                while let Some(entry) = map.next_entry::<Axis, f64>()? {
                    values.push(entry);
                }
                Cell::written(values).map_err(de::Error::custom)
            }
        }
        deserializer.deserialize_map(CellVisitor)
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

    #[test]
    fn a_cell_reads_back_what_it_prints() {
        let cell: Cell = "speed_m_s=.15,turn_rate_rad_s=0.75,robots=9".parse().unwrap();

        assert_eq!(cell.to_string(), "speed_m_s=0.15,turn_rate_rad_s=0.75,robots=9");
        assert_eq!(cell.to_string().parse(), Ok(cell));
    }

    #[test]
    fn a_misspelt_axis_is_answered_with_the_nearest() {
        let error = "speed=0.15".parse::<Cell>().unwrap_err();

        assert_eq!(error.to_string(), "unknown axis `speed`; did you mean `speed_m_s`?");
    }
}
