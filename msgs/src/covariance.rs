//! A fixed array of 36 numbers on the wire: no length in front, unlike a sequence.
//!
//! serde implements arrays only up to 32 elements, so the two covariance fields name this module in
//! `#[serde(with = "…")]`.

use std::fmt;

use serde::de::{Error, SeqAccess, Visitor};
use serde::ser::SerializeTuple;
use serde::{Deserializer, Serializer};

/// Six by six, row by row.
const LENGTH: usize = 36;

/// Writes the elements one after the other.
pub fn serialize<S: Serializer>(
    covariance: &[f64; LENGTH],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut tuple = serializer.serialize_tuple(LENGTH)?;
    for element in covariance {
        tuple.serialize_element(element)?;
    }
    tuple.end()
}

/// Reads exactly 36 elements.
pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; LENGTH], D::Error> {
    deserializer.deserialize_tuple(LENGTH, CovarianceVisitor)
}

struct CovarianceVisitor;

impl<'de> Visitor<'de> for CovarianceVisitor {
    type Value = [f64; LENGTH];

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        write!(formatter, "{LENGTH} numbers")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Self::Value, A::Error> {
        let mut covariance = [0.0; LENGTH];
        for (index, slot) in covariance.iter_mut().enumerate() {
            *slot = elements.next_element()?.ok_or_else(|| Error::invalid_length(index, &self))?;
        }
        Ok(covariance)
    }
}
