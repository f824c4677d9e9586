//! YAML of any shape, and the values that parameters can have.

use std::fmt;

use serde::de::{Deserialize, Deserializer, Error, MapAccess, SeqAccess, Visitor};

use crate::parameter_value::ParameterValue;

/// YAML of any shape.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Yaml {
    Null,
    Bool(bool),
    Integer(i64),
    Double(f64),
    String(String),
    Sequence(Vec<Yaml>),
    Mapping(Vec<(String, Yaml)>),
}

impl Yaml {
    /// The value of a parameter; text otherwise, as in ROS 2.
    ///
    /// # Errors
    ///
    /// What is wrong with it, to follow "value of parameter x".
    pub(super) fn into_value(self) -> Result<ParameterValue, String> {
        match self {
            Self::Bool(value) => Ok(ParameterValue::Bool(value)),
            Self::Integer(value) => Ok(ParameterValue::Integer(value)),
            Self::Double(value) => Ok(ParameterValue::Double(value)),
            Self::String(value) => Ok(ParameterValue::String(value)),
            Self::Sequence(values) => array(values),
            Self::Null => Err("is missing".to_owned()),
            Self::Mapping(_) => Err("is a mapping, expected a number, text or list".to_owned()),
        }
    }
}

/// An array, whose elements are all of the type of the first.
fn array(values: Vec<Yaml>) -> Result<ParameterValue, String> {
    let mixed = || "is a list of several types, expected numbers or texts".to_owned();
    let mut values = values.into_iter();
    let mut array = match values.next().ok_or("is an empty list, which has no type")? {
        Yaml::Bool(first) => ParameterValue::BoolArray(vec![first]),
        Yaml::Integer(first) => ParameterValue::IntegerArray(vec![first]),
        Yaml::Double(first) => ParameterValue::DoubleArray(vec![first]),
        Yaml::String(first) => ParameterValue::StringArray(vec![first]),
        Yaml::Null | Yaml::Sequence(_) | Yaml::Mapping(_) => return Err(mixed()),
    };
    for value in values {
        match (&mut array, value) {
            (ParameterValue::BoolArray(array), Yaml::Bool(value)) => array.push(value),
            (ParameterValue::IntegerArray(array), Yaml::Integer(value)) => array.push(value),
            (ParameterValue::DoubleArray(array), Yaml::Double(value)) => array.push(value),
            (ParameterValue::StringArray(array), Yaml::String(value)) => array.push(value),
            _ => return Err(mixed()),
        }
    }
    Ok(array)
}

impl<'de> Deserialize<'de> for Yaml {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(YamlVisitor)
    }
}

struct YamlVisitor;

impl<'de> Visitor<'de> for YamlVisitor {
    type Value = Yaml;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("YAML")
    }

    fn visit_unit<E: Error>(self) -> Result<Yaml, E> {
        Ok(Yaml::Null)
    }

    fn visit_none<E: Error>(self) -> Result<Yaml, E> {
        Ok(Yaml::Null)
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Yaml, D::Error> {
        Yaml::deserialize(deserializer)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Yaml, E> {
        Ok(Yaml::Bool(value))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Yaml, E> {
        Ok(Yaml::Integer(value))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Yaml, E> {
        let too_large = |_| E::custom(format!("{value} does not fit the 64-bit integers of ROS 2"));
        i64::try_from(value).map(Yaml::Integer).map_err(too_large)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Yaml, E> {
        Ok(Yaml::Double(value))
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<Yaml, E> {
        Ok(Yaml::String(value.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<Yaml, A::Error> {
        let mut elements = Vec::new();
        while let Some(element) = sequence.next_element()? {
            elements.push(element);
        }
        Ok(Yaml::Sequence(elements))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut mapping: A) -> Result<Yaml, A::Error> {
        let mut entries = Vec::new();
        while let Some(entry) = mapping.next_entry()? {
            entries.push(entry);
        }
        Ok(Yaml::Mapping(entries))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Result<ParameterValue, String> {
        serde_saphyr::from_str::<Yaml>(text).unwrap().into_value()
    }

    #[test]
    fn scalars_have_the_types_that_ros_gives_them() {
        let cases = [
            ("1", ParameterValue::Integer(1)),
            ("-7", ParameterValue::Integer(-7)),
            ("1.0", ParameterValue::Double(1.0)),
            ("1e3", ParameterValue::Double(1000.0)),
            ("true", ParameterValue::Bool(true)),
            ("milling", ParameterValue::String("milling".into())),
            ("\"1\"", ParameterValue::String("1".into())),
            ("'true'", ParameterValue::String("true".into())),
            ("/robot_3", ParameterValue::String("/robot_3".into())),
        ];
        for (text, expected) in cases {
            assert_eq!(value(text), Ok(expected), "{text}");
        }
    }

    #[test]
    fn lists_of_one_type_are_arrays() {
        let cases = [
            ("[1, 2]", ParameterValue::IntegerArray(vec![1, 2])),
            ("[1.0, 2.5]", ParameterValue::DoubleArray(vec![1.0, 2.5])),
            ("[true, false]", ParameterValue::BoolArray(vec![true, false])),
            ("[a, b]", ParameterValue::StringArray(vec!["a".into(), "b".into()])),
        ];
        for (text, expected) in cases {
            assert_eq!(value(text), Ok(expected), "{text}");
        }
    }

    #[test]
    fn what_no_parameter_can_be_is_refused() {
        for text in ["[1, 2.0]", "[]", "{a: 1}", "~", "[[1], [2]]", "[1, a]"] {
            assert!(value(text).is_err(), "{text}");
        }
        assert!(serde_saphyr::from_str::<Yaml>("9223372036854775808").is_err());
    }
}
