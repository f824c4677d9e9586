#![doc = include_str!("../README.md")]
//! # Modules
//!
//! * [`topics`] — every topic's name, type and quality of service, publishers and subscribers, once.
//! * [`node_names`] — what the nodes of a fleet are called, and [`node_kind`] which kinds there are.
//! * [`cdr`] — messages to bytes and back.
//! * [`schema`] — the `ros2msg` text and the RIHS01 hash of a type, as bags want them.
//! * one module per ROS package, such as [`geometry_msgs`], with plain structs;
//!   our own messages are in [`rsrs`].

pub mod builtin_interfaces;
pub mod cdr;
pub mod diagnostic_msgs;
pub mod geometry_msgs;
mod message;
pub mod motion_capture_tracking_interfaces;
pub mod nav_msgs;
pub mod node_kind;
pub mod node_names;
pub mod rcl_interfaces;
pub mod rosgraph_msgs;
pub mod rsrs;
pub mod schema;
pub mod sensor_msgs;
pub mod simulation_interfaces;
pub mod std_msgs;
pub mod tf2_msgs;
pub mod topics;
pub mod visualization_msgs;

pub use message::RosMessage;
