//! Requests and responses of the six parameter services that every ROS 2 node offers.

use serde::{Deserialize, Serialize};

use super::{
    ListParametersResult, Parameter, ParameterDescriptor, ParameterValue, SetParametersResult,
};
use crate::message::ros_messages;

/// Asks for values.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GetParametersRequest {
    /// Of these parameters.
    pub names: Vec<String>,
}

/// Answers [`GetParametersRequest`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct GetParametersResponse {
    /// One value per name, in the order of the names; not set where there is no such parameter.
    pub values: Vec<ParameterValue>,
}

/// Asks for types.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GetParameterTypesRequest {
    /// Of these parameters.
    pub names: Vec<String>,
}

/// Answers [`GetParameterTypesRequest`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GetParameterTypesResponse {
    /// One constant of [`super::ParameterType`] per name, in the order of the names.
    pub types: Vec<u8>,
}

/// Sets parameters one by one: some may be refused and the others set.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SetParametersRequest {
    /// The new values.
    pub parameters: Vec<Parameter>,
}

/// Answers [`SetParametersRequest`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SetParametersResponse {
    /// One result per parameter, in the order of the request.
    pub results: Vec<SetParametersResult>,
}

/// Sets all parameters or none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SetParametersAtomicallyRequest {
    /// The new values.
    pub parameters: Vec<Parameter>,
}

/// Answers [`SetParametersAtomicallyRequest`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SetParametersAtomicallyResponse {
    /// One result for all of them.
    pub result: SetParametersResult,
}

/// Asks for the names of parameters.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ListParametersRequest {
    /// Only below these prefixes; empty for all.
    pub prefixes: Vec<String>,
    /// Only so many dots deep; [`ListParametersRequest::DEPTH_RECURSIVE`] for any depth.
    pub depth: u64,
}

impl ListParametersRequest {
    /// Any depth.
    pub const DEPTH_RECURSIVE: u64 = 0;
}

/// Answers [`ListParametersRequest`].
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ListParametersResponse {
    /// The names.
    pub result: ListParametersResult,
}

/// Asks what parameters mean.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DescribeParametersRequest {
    /// Which ones.
    pub names: Vec<String>,
}

/// Answers [`DescribeParametersRequest`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DescribeParametersResponse {
    /// One descriptor per name, in the order of the names.
    pub descriptors: Vec<ParameterDescriptor>,
}

ros_messages! {
    GetParametersRequest => "rcl_interfaces/srv/GetParameters_Request",
    GetParametersResponse => "rcl_interfaces/srv/GetParameters_Response",
    GetParameterTypesRequest => "rcl_interfaces/srv/GetParameterTypes_Request",
    GetParameterTypesResponse => "rcl_interfaces/srv/GetParameterTypes_Response",
    SetParametersRequest => "rcl_interfaces/srv/SetParameters_Request",
    SetParametersResponse => "rcl_interfaces/srv/SetParameters_Response",
    SetParametersAtomicallyRequest => "rcl_interfaces/srv/SetParametersAtomically_Request",
    SetParametersAtomicallyResponse => "rcl_interfaces/srv/SetParametersAtomically_Response",
    ListParametersRequest => "rcl_interfaces/srv/ListParameters_Request",
    ListParametersResponse => "rcl_interfaces/srv/ListParameters_Response",
    DescribeParametersRequest => "rcl_interfaces/srv/DescribeParameters_Request",
    DescribeParametersResponse => "rcl_interfaces/srv/DescribeParameters_Response",
}
