//! ROS 2 messages: wire types, CDR, schema texts, and the table of topics.
//!
//! The same folder is the ROS 2 interface package `rsrs_msgs` (`package.xml`, `msg/*.msg`); the
//! Rust side stands on its own and needs no ROS installation.
//! Field names, types and order are those of ROS 2 Jazzy; a message that differed in one of them
//! would decode to nonsense without an error, so all of them are checked byte for byte against an
//! independent implementation (`tests/messages/oracle.rs`).
//!
//! * [`topics`] — every topic's name, type and quality of service, publishers and subscribers, once.
//! * [`node_names`] — what the nodes of a fleet are called, and [`node_kind`] which kinds there are.
//! * [`cdr`] — messages to bytes and back.
//! * [`schema`] — the `ros2msg` text and the RIHS01 hash of a type, as bags want them.
//! * one module per ROS package, such as [`geometry_msgs`], with plain structs;
//!   our own four messages are in [`rsrs`].

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
