//! Cells: one value on each swept axis.

use std::fmt;
use std::str::FromStr;

use serde::de::{self, Deserialize, Deserializer, MapAccess, Visitor};
use serde::{Serialize, Serializer};

use super::{Axis, OtherUnit, UnknownAxis};

/// One point of a sweep: a value on each of some axes, in the order they were given.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cell {
    values: Vec<(Axis, f64)>,
}

/// Why a text is not a cell.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CellError {
    /// A part is not `axis=value`.
    #[error("`{0}` is not of the form axis=value")]
    NotAnAssignment(String),
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
    #[error("{0} is given twice")]
    Twice(Axis),
}

impl Cell {
    /// A cell from its values, one finite number for each axis.
    pub fn new(values: impl IntoIterator<Item = (Axis, f64)>) -> Result<Self, CellError> {
        let mut cell = Self::default();
        for (axis, value) in values {
            if cell.get(axis).is_some() {
                return Err(CellError::Twice(axis));
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

    /// How many robots it has, if it has a value for that.
    pub fn robots(&self) -> Option<usize> {
        self.get(Axis::Robots).map(|robots| robots as usize)
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
            let (key, value) =
                part.split_once('=').ok_or_else(|| CellError::NotAnAssignment(part.to_owned()))?;
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
        serializer.collect_map(self.values.iter().map(|(axis, value)| (axis.key(), value)))
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

#[cfg(test)]
mod tests {
    use super::*;

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
