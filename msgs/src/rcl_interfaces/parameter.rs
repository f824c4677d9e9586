//! Parameters of a node: values, descriptors, changes.

use serde::{Deserialize, Serialize};

use crate::builtin_interfaces::Time;
use crate::message::ros_messages;

/// The values of the field `type` of [`ParameterValue`] and [`ParameterDescriptor`].
///
/// The ROS message of this name has constants only and is never sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterType;

impl ParameterType {
    /// No value: the parameter does not exist, or is to be deleted.
    pub const NOT_SET: u8 = 0;
    /// `bool_value` holds.
    pub const BOOL: u8 = 1;
    /// `integer_value` holds.
    pub const INTEGER: u8 = 2;
    /// `double_value` holds.
    pub const DOUBLE: u8 = 3;
    /// `string_value` holds.
    pub const STRING: u8 = 4;
    /// `byte_array_value` holds.
    pub const BYTE_ARRAY: u8 = 5;
    /// `bool_array_value` holds.
    pub const BOOL_ARRAY: u8 = 6;
    /// `integer_array_value` holds.
    pub const INTEGER_ARRAY: u8 = 7;
    /// `double_array_value` holds.
    pub const DOUBLE_ARRAY: u8 = 8;
    /// `string_array_value` holds.
    pub const STRING_ARRAY: u8 = 9;
}

/// A value of a parameter: only the field that `type` names counts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ParameterValue {
    /// A constant of [`ParameterType`].
    pub r#type: u8,
    /// Holds for [`ParameterType::BOOL`].
    pub bool_value: bool,
    /// Holds for [`ParameterType::INTEGER`].
    pub integer_value: i64,
    /// Holds for [`ParameterType::DOUBLE`].
    pub double_value: f64,
    /// Holds for [`ParameterType::STRING`].
    pub string_value: String,
    /// Holds for [`ParameterType::BYTE_ARRAY`].
    pub byte_array_value: Vec<u8>,
    /// Holds for [`ParameterType::BOOL_ARRAY`].
    pub bool_array_value: Vec<bool>,
    /// Holds for [`ParameterType::INTEGER_ARRAY`].
    pub integer_array_value: Vec<i64>,
    /// Holds for [`ParameterType::DOUBLE_ARRAY`].
    pub double_array_value: Vec<f64>,
    /// Holds for [`ParameterType::STRING_ARRAY`].
    pub string_array_value: Vec<String>,
}

/// A parameter by name.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Parameter {
    /// Its name, such as `turn_rate`.
    pub name: String,
    /// Its value.
    pub value: ParameterValue,
}

/// What changed in the parameters of a node, on `/parameter_events`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ParameterEvent {
    /// When.
    pub stamp: Time,
    /// The full name of the node.
    pub node: String,
    /// Declared now.
    pub new_parameters: Vec<Parameter>,
    /// Set now.
    pub changed_parameters: Vec<Parameter>,
    /// Gone now.
    pub deleted_parameters: Vec<Parameter>,
}

/// The limits of a floating-point parameter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FloatingPointRange {
    /// Lowest value, in the unit of the parameter.
    pub from_value: f64,
    /// Highest value, in the unit of the parameter.
    pub to_value: f64,
    /// Distance between values; 0 for any value between the limits.
    pub step: f64,
}

/// The limits of an integer parameter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct IntegerRange {
    /// Lowest value, in the unit of the parameter.
    pub from_value: i64,
    /// Highest value, in the unit of the parameter.
    pub to_value: i64,
    /// Distance between values; 0 for any value between the limits.
    pub step: u64,
}

/// What a parameter means and may be.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ParameterDescriptor {
    /// Its name.
    pub name: String,
    /// A constant of [`ParameterType`].
    pub r#type: u8,
    /// Its meaning, with the unit.
    pub description: String,
    /// Limits that the ranges cannot express, in words.
    pub additional_constraints: String,
    /// Whether it can be set at all.
    pub read_only: bool,
    /// Whether its type may change.
    pub dynamic_typing: bool,
    /// None or one; at most one in the ROS definition.
    pub floating_point_range: Vec<FloatingPointRange>,
    /// None or one; at most one in the ROS definition.
    pub integer_range: Vec<IntegerRange>,
}

/// Whether a parameter was set.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SetParametersResult {
    /// Whether it was.
    pub successful: bool,
    /// Why not; empty if it was.
    pub reason: String,
}

/// The names of a node's parameters.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ListParametersResult {
    /// The full names.
    pub names: Vec<String>,
    /// The prefixes among them, up to a dot.
    pub prefixes: Vec<String>,
}

ros_messages! {
    ParameterValue => "rcl_interfaces/msg/ParameterValue",
    Parameter => "rcl_interfaces/msg/Parameter",
    ParameterEvent => "rcl_interfaces/msg/ParameterEvent",
    FloatingPointRange => "rcl_interfaces/msg/FloatingPointRange",
    IntegerRange => "rcl_interfaces/msg/IntegerRange",
    ParameterDescriptor => "rcl_interfaces/msg/ParameterDescriptor",
    SetParametersResult => "rcl_interfaces/msg/SetParametersResult",
    ListParametersResult => "rcl_interfaces/msg/ListParametersResult",
}
