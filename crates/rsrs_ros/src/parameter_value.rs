//! Values of parameters and what they may be.

use std::fmt;

use rsrs_msgs::rcl_interfaces::{self as wire, ParameterType};

/// The type of a parameter's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum ParameterKind {
    /// A truth value.
    Bool = ParameterType::BOOL,
    /// A signed integer of 64 bits.
    Integer = ParameterType::INTEGER,
    /// A floating-point number of 64 bits.
    Double = ParameterType::DOUBLE,
    /// A text.
    String = ParameterType::STRING,
    /// Bytes.
    ByteArray = ParameterType::BYTE_ARRAY,
    /// Truth values.
    BoolArray = ParameterType::BOOL_ARRAY,
    /// Integers.
    IntegerArray = ParameterType::INTEGER_ARRAY,
    /// Floating-point numbers.
    DoubleArray = ParameterType::DOUBLE_ARRAY,
    /// Texts.
    StringArray = ParameterType::STRING_ARRAY,
}

impl fmt::Display for ParameterKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The words of ROS 2's own error messages.
        formatter.write_str(match self {
            Self::Bool => "bool",
            Self::Integer => "integer",
            Self::Double => "double",
            Self::String => "string",
            Self::ByteArray => "byte_array",
            Self::BoolArray => "bool_array",
            Self::IntegerArray => "integer_array",
            Self::DoubleArray => "double_array",
            Self::StringArray => "string_array",
        })
    }
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterValue {
    /// A truth value.
    Bool(bool),
    /// A signed integer of 64 bits.
    Integer(i64),
    /// A floating-point number of 64 bits.
    Double(f64),
    /// A text.
    String(String),
    /// Bytes.
    ByteArray(Vec<u8>),
    /// Truth values.
    BoolArray(Vec<bool>),
    /// Integers.
    IntegerArray(Vec<i64>),
    /// Floating-point numbers.
    DoubleArray(Vec<f64>),
    /// Texts.
    StringArray(Vec<String>),
}

impl ParameterValue {
    /// Its type.
    pub fn kind(&self) -> ParameterKind {
        match self {
            Self::Bool(_) => ParameterKind::Bool,
            Self::Integer(_) => ParameterKind::Integer,
            Self::Double(_) => ParameterKind::Double,
            Self::String(_) => ParameterKind::String,
            Self::ByteArray(_) => ParameterKind::ByteArray,
            Self::BoolArray(_) => ParameterKind::BoolArray,
            Self::IntegerArray(_) => ParameterKind::IntegerArray,
            Self::DoubleArray(_) => ParameterKind::DoubleArray,
            Self::StringArray(_) => ParameterKind::StringArray,
        }
    }

    /// The message that carries it.
    pub fn to_wire(&self) -> wire::ParameterValue {
        let mut value =
            wire::ParameterValue { r#type: self.kind() as u8, ..wire::ParameterValue::default() };
        match self {
            Self::Bool(v) => value.bool_value = *v,
            Self::Integer(v) => value.integer_value = *v,
            Self::Double(v) => value.double_value = *v,
            Self::String(v) => value.string_value.clone_from(v),
            Self::ByteArray(v) => value.byte_array_value.clone_from(v),
            Self::BoolArray(v) => value.bool_array_value.clone_from(v),
            Self::IntegerArray(v) => value.integer_array_value.clone_from(v),
            Self::DoubleArray(v) => value.double_array_value.clone_from(v),
            Self::StringArray(v) => value.string_array_value.clone_from(v),
        }
        value
    }

    /// What a message carries; `None` if it is "not set", or a type that ROS 2 does not have.
    pub fn from_wire(value: wire::ParameterValue) -> Option<Self> {
        Some(match value.r#type {
            ParameterType::BOOL => Self::Bool(value.bool_value),
            ParameterType::INTEGER => Self::Integer(value.integer_value),
            ParameterType::DOUBLE => Self::Double(value.double_value),
            ParameterType::STRING => Self::String(value.string_value),
            ParameterType::BYTE_ARRAY => Self::ByteArray(value.byte_array_value),
            ParameterType::BOOL_ARRAY => Self::BoolArray(value.bool_array_value),
            ParameterType::INTEGER_ARRAY => Self::IntegerArray(value.integer_array_value),
            ParameterType::DOUBLE_ARRAY => Self::DoubleArray(value.double_array_value),
            ParameterType::STRING_ARRAY => Self::StringArray(value.string_array_value),
            _ => return None,
        })
    }

    /// Whether a number in it is NaN, which no parameter may be: it would compare unequal to itself
    /// when it is read back.
    pub(super) fn has_nan(&self) -> bool {
        match self {
            Self::Double(value) => value.is_nan(),
            Self::DoubleArray(values) => values.iter().any(|value| value.is_nan()),
            _ => false,
        }
    }

    /// Its numbers, for a check against a range.
    pub(super) fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Integer(value) => vec![*value as f64],
            Self::Double(value) => vec![*value],
            Self::IntegerArray(values) => values.iter().map(|value| *value as f64).collect(),
            Self::DoubleArray(values) => values.clone(),
            _ => Vec::new(),
        }
    }
}

impl fmt::Display for ParameterValue {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(v) => write!(formatter, "{v}"),
            Self::Integer(v) => write!(formatter, "{v}"),
            // With a point, so that it is read as a double again.
            Self::Double(v) => write!(formatter, "{v:?}"),
            Self::String(v) => write!(formatter, "{v}"),
            Self::ByteArray(v) => write!(formatter, "{v:?}"),
            Self::BoolArray(v) => write!(formatter, "{v:?}"),
            Self::IntegerArray(v) => write!(formatter, "{v:?}"),
            Self::DoubleArray(v) => write!(formatter, "{v:?}"),
            Self::StringArray(v) => write!(formatter, "{v:?}"),
        }
    }
}

/// What a parameter means and may be.
#[derive(Clone, Debug, PartialEq)]
pub struct Descriptor {
    /// Its name, such as `turn_rate`.
    pub name: String,
    /// Its type, for good.
    pub kind: ParameterKind,
    /// Its meaning, with the unit.
    pub description: String,
    /// Whether it cannot be set at all.
    pub read_only: bool,
    /// Lowest and highest number, in the unit of the parameter; for every element of an array.
    pub range: Option<(f64, f64)>,
    /// Limits that a range cannot express, in words; may be empty.
    pub additional_constraints: String,
}

impl Descriptor {
    /// A parameter that may be set to any value of its type.
    pub fn new(name: &str, kind: ParameterKind, description: &str) -> Self {
        Self {
            name: name.to_owned(),
            kind,
            description: description.to_owned(),
            read_only: false,
            range: None,
            additional_constraints: String::new(),
        }
    }

    /// The same, set at the start and not any more.
    #[must_use]
    pub fn read_only(self) -> Self {
        Self { read_only: true, ..self }
    }

    /// The same, with a lowest and a highest number, in the unit of the parameter.
    #[must_use]
    pub fn within(self, lowest: f64, highest: f64) -> Self {
        Self { range: Some((lowest, highest)), ..self }
    }

    /// The same, with limits that a range cannot express, in words.
    #[must_use]
    pub fn limited_to(self, words: &str) -> Self {
        Self { additional_constraints: words.to_owned(), ..self }
    }

    /// The message that carries it.
    #[expect(clippy::cast_possible_truncation, reason = "limits of an integer are integers")]
    pub fn to_wire(&self) -> wire::ParameterDescriptor {
        let mut descriptor = wire::ParameterDescriptor {
            name: self.name.clone(),
            r#type: self.kind as u8,
            description: self.description.clone(),
            additional_constraints: self.additional_constraints.clone(),
            read_only: self.read_only,
            ..wire::ParameterDescriptor::default()
        };
        if let Some((from, to)) = self.range {
            if matches!(self.kind, ParameterKind::Integer | ParameterKind::IntegerArray) {
                let (from_value, to_value) = (from as i64, to as i64);
                descriptor.integer_range =
                    vec![wire::IntegerRange { from_value, to_value, step: 0 }];
            } else {
                descriptor.floating_point_range =
                    vec![wire::FloatingPointRange { from_value: from, to_value: to, step: 0.0 }];
            }
        }
        descriptor
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one_of_each() -> Vec<ParameterValue> {
        vec![
            ParameterValue::Bool(true),
            ParameterValue::Integer(-7),
            ParameterValue::Double(0.15),
            ParameterValue::String("milling".into()),
            ParameterValue::ByteArray(vec![1, 255]),
            ParameterValue::BoolArray(vec![true, false]),
            ParameterValue::IntegerArray(vec![i64::MIN, 1]),
            ParameterValue::DoubleArray(vec![0.5, -1.0]),
            ParameterValue::StringArray(vec!["a".into(), String::new()]),
        ]
    }

    #[test]
    fn every_type_survives_the_wire() {
        for value in one_of_each() {
            assert_eq!(ParameterValue::from_wire(value.to_wire()), Some(value));
        }
    }

    #[test]
    fn a_value_that_is_not_set_or_of_an_unknown_type_is_none() {
        for r#type in [ParameterType::NOT_SET, 10, 255] {
            let value = wire::ParameterValue { r#type, ..wire::ParameterValue::default() };

            assert_eq!(ParameterValue::from_wire(value), None);
        }
    }

    #[test]
    fn an_integer_has_an_integer_range() {
        let mut descriptor = Descriptor::new("robots", ParameterKind::Integer, "Robots.");
        descriptor.range = Some((1.0, 100.0));

        let wire = descriptor.to_wire();

        assert_eq!((wire.integer_range[0].from_value, wire.integer_range[0].to_value), (1, 100));
        assert!(wire.floating_point_range.is_empty());
    }

    #[test]
    fn a_whole_double_is_shown_with_a_point() {
        assert_eq!(ParameterValue::Double(1.0).to_string(), "1.0");
        assert_eq!(ParameterValue::Integer(1).to_string(), "1");
    }
}
