//! Package `rcl_interfaces`: log lines, parameters, and the six parameter services.

mod log;
mod parameter;
mod services;

pub use log::Log;
pub use parameter::{
    FloatingPointRange, IntegerRange, ListParametersResult, Parameter, ParameterDescriptor,
    ParameterEvent, ParameterType, ParameterValue, SetParametersResult,
};
pub use services::{
    DescribeParametersRequest, DescribeParametersResponse, GetParameterTypesRequest,
    GetParameterTypesResponse, GetParametersRequest, GetParametersResponse, ListParametersRequest,
    ListParametersResponse, SetParametersAtomicallyRequest, SetParametersAtomicallyResponse,
    SetParametersRequest, SetParametersResponse,
};
