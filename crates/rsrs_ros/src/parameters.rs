//! Parameters, as every ROS 2 tool expects them: six services per node, and a client for them.
//!
//! One participant answers for any number of nodes ([`ParameterServer`]). Two ways of calling a
//! service are in use and neither understands the other ([`Mapping`]); each request is answered in
//! the way in which it was asked.

mod client;
mod server;
mod service;
mod store;

pub use crate::parameter_value::{Descriptor, ParameterKind, ParameterValue};
pub use crate::services::Mapping;
pub use client::{ClientOptions, ParameterClient, ParameterClientError};
pub use server::{NodeParameters, ParameterServer, ParameterServerError};
pub use store::{Arming, Refusal, Store};
