//! Values of an axis in a file.

use std::fmt;

use serde::Serialize;
use serde::de::{self, Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};

use crate::robot::harsher::tidy;

/// The values of one axis: spelled out as a list, or evenly spaced `{from, to, steps}`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct AxisValues(pub Vec<f64>);

impl AxisValues {
    /// Evenly spaced values, both ends included.
    pub fn evenly_spaced(from: f64, to: f64, steps: usize) -> Self {
        let intervals = steps.saturating_sub(1).max(1) as f64;
        Self((0..steps).map(|step| tidy(from + (to - from) * step as f64 / intervals)).collect())
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
                let values = std::iter::from_fn(|| list.next_element().transpose());
                values.collect::<Result<_, _>>().map(AxisValues)
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
