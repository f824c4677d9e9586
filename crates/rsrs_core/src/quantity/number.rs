//! Named numbers of a controller's table: quantities whose rows come from a file.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fmt;
use std::hash::{Hash, Hasher};
use std::sync::{Mutex, PoisonError};

use super::{Axis, Bounds, DEGREES_S, Kind, MM_S, Row};
use crate::document::is_name;

/// A named number, as an axis: `controller.turn_rad_s` is `$turn_rad_s` in the rows of a table.
///
/// Its name ends with its unit. Which names a table has, and between which bounds, is known where the table is.
#[derive(Clone, Copy)]
pub struct Number(&'static Row);

/// What a number measures, by the end of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberUnit {
    /// Turning rates: `_rad_s`.
    RadiansPerSecond,
    /// Speeds of the robot or of a wheel: `_m_s`.
    MetresPerSecond,
    /// Times: `_s`.
    Seconds,
    /// Probabilities: no unit.
    None,
}

impl NumberUnit {
    const ALL: [Self; 4] =
        [Self::RadiansPerSecond, Self::MetresPerSecond, Self::Seconds, Self::None];

    /// The unit of a number of this name.
    pub fn new(name: &str) -> Self {
        let is_it = |unit: &Self| name.ends_with(unit.suffix());
        Self::ALL.into_iter().find(is_it).expect("every name ends with nothing")
    }

    /// How names of such numbers end.
    pub fn suffix(self) -> &'static str {
        self.row().0
    }

    /// Between which values such a number can mean anything.
    pub fn bounds(self) -> Bounds {
        self.row().2
    }

    /// The end of names, the unit, the bounds of values, and a unit that is taken for this one.
    fn row(self) -> (&'static str, &'static str, Bounds, Option<(f64, &'static str)>) {
        match self {
            Self::RadiansPerSecond => ("_rad_s", "rad/s", Bounds::SIGNED, DEGREES_S),
            Self::MetresPerSecond => ("_m_s", "m/s", Bounds::SIGNED, MM_S),
            Self::Seconds => ("_s", "s", Bounds::AMOUNT, None),
            Self::None => ("", "", Bounds::PROBABILITY, None),
        }
    }
}

/// `m/s`, and what a probability is called.
impl fmt::Display for NumberUnit {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(if *self == Self::None { "a probability" } else { self.row().1 })
    }
}

/// In front of the name in files and on the command line.
pub const PREFIX: &str = "controller.";

/// Most characters of a name.
const MOST_CHARACTERS: usize = 48;

/// The row of each name, made when it is first read.
static ROWS: Mutex<BTreeMap<&'static str, &'static Row>> = Mutex::new(BTreeMap::new());

impl Number {
    /// The number of this name; `None` if that is none: small letters, digits and `_`, a letter first.
    pub fn new(name: &str) -> Option<Self> {
        if !is_name(name) || name.len() > MOST_CHARACTERS {
            return None;
        }
        let mut rows = ROWS.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(row) = rows.get(name) {
            return Some(Self(row));
        }
        let key: &'static str = format!("{PREFIX}{name}").leak();
        let (suffix, unit, bounds, other_unit) = NumberUnit::new(name).row();
        let words = name[..name.len() - suffix.len()].replace('_', " ");
        let row: &'static Row = Box::leak(Box::new(Row {
            axis: Axis::Speed,
            key,
            name: words.leak(),
            unit,
            bounds,
            other_unit,
            kind: Kind::Number,
        }));
        rows.insert(&key[PREFIX.len()..], row);
        Some(Self(row))
    }

    /// The number of an axis' key; `None` if that is another axis'.
    pub(super) fn from_key(key: &str) -> Option<Self> {
        Self::new(key.strip_prefix(PREFIX)?)
    }

    /// Its name in the table: `turn_rad_s`.
    pub fn name(self) -> &'static str {
        &self.0.key[PREFIX.len()..]
    }

    pub(super) fn row(self) -> &'static Row {
        self.0
    }
}

impl fmt::Debug for Number {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "Number({})", self.name())
    }
}

impl PartialEq for Number {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Eq for Number {}

impl PartialOrd for Number {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Number {
    fn cmp(&self, other: &Self) -> Ordering {
        self.name().cmp(other.name())
    }
}

impl Hash for Number {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.name().hash(state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Cell;

    #[test]
    fn a_number_of_a_table_is_an_axis_with_the_unit_that_its_name_ends_with() {
        let axis: Axis = "controller.fast_turn_rad_s".parse().unwrap();

        assert_eq!(axis, Axis::Number(Number::new("fast_turn_rad_s").unwrap()));
        assert_eq!((axis.key(), axis.unit()), ("controller.fast_turn_rad_s", "rad/s"));
        assert_eq!(axis.label(), "fast turn (rad/s)");
        assert_eq!("controller.pass_s".parse::<Axis>().unwrap().label(), "pass (s)");
        assert!(!axis.is_capability());
        let cell: Cell = "controller.leave=0.1,controller.wait_s=3".parse().unwrap();
        assert_eq!(cell.to_string(), "controller.leave=0.1,controller.wait_s=3");
        let error = "fast_turn_rad_s=1".parse::<Cell>().unwrap_err().to_string();
        assert!(error.ends_with("did you mean `controller.fast_turn_rad_s`?"), "{error}");
        let error = "controller.slow_m_s=150".parse::<Cell>().unwrap_err().to_string();
        assert_eq!(error, "controller.slow_m_s is 150: this looks like mm/s, expected m/s");
    }

    #[test]
    fn what_is_no_name_is_no_number() {
        for name in ["", "Turn_rad_s", "2_m_s", "turn-rad", "$turn", &"x".repeat(49)] {
            assert_eq!(Number::new(name), None, "{name}");
        }
    }
}
