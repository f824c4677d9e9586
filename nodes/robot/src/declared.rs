//! Parameters as drivers and robots declare them, and what they are now.

use rsrs_ros::parameters::{Descriptor, ParameterKind, ParameterServer, ParameterValue};

/// A text that is one of a few words, for good.
pub fn choice(
    name: &str,
    description: &str,
    words: &str,
    value: &str,
) -> (Descriptor, ParameterValue) {
    let descriptor = Descriptor {
        read_only: true,
        additional_constraints: words.to_owned(),
        ..Descriptor::new(name, ParameterKind::String, description)
    };
    (descriptor, ParameterValue::String(value.to_owned()))
}

/// The value of a number.
///
/// # Panics
///
/// If it was not declared as one.
pub fn double(server: &ParameterServer, node: &str, name: &str) -> f64 {
    match server.get(node, name) {
        Some(ParameterValue::Double(value)) => value,
        other => unreachable!("{name} was declared as a double, found {other:?}"),
    }
}

/// The value of a whole number.
///
/// # Panics
///
/// If it was not declared as one.
pub fn integer(server: &ParameterServer, node: &str, name: &str) -> i64 {
    match server.get(node, name) {
        Some(ParameterValue::Integer(value)) => value,
        other => unreachable!("{name} was declared as an integer, found {other:?}"),
    }
}

/// The value of a text.
///
/// # Panics
///
/// If it was not declared as one.
pub fn text(server: &ParameterServer, node: &str, name: &str) -> String {
    match server.get(node, name) {
        Some(ParameterValue::String(value)) => value,
        other => unreachable!("{name} was declared as a string, found {other:?}"),
    }
}
