//! Parameters as drivers and robots declare them.

use rsrs_ros::parameters::{Descriptor, ParameterKind, ParameterValue};

/// A text that is one of a few words, for good.
pub fn choice(
    name: &str,
    description: &str,
    words: &str,
    value: &str,
) -> (Descriptor, ParameterValue) {
    let descriptor = Descriptor::new(name, ParameterKind::String, description);
    (descriptor.limited_to(words).read_only(), ParameterValue::String(value.to_owned()))
}
