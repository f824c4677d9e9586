//! Package `std_msgs`: a flag, a text, a colour and the usual header.

use serde::{Deserialize, Serialize};

use crate::builtin_interfaces::Time;
use crate::message::ros_messages;

/// A flag; on `detection`, whether the robot sees another one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bool {
    /// The flag.
    pub data: bool,
}

/// A text; on `/swarm/experiment`, the record of the run as JSON.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct String {
    /// The text.
    pub data: std::string::String,
}

/// When and in which frame a message was made.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// When, by the sender's clock, or by `/clock` in simulated time.
    pub stamp: Time,
    /// The coordinate frame, such as `robot_3/odom`.
    pub frame_id: std::string::String,
}

/// A colour; each part from 0 to 1, dimensionless.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ColorRGBA {
    /// Red.
    pub r: f32,
    /// Green.
    pub g: f32,
    /// Blue.
    pub b: f32,
    /// Opacity: 0 cannot be seen.
    pub a: f32,
}

ros_messages! {
    ColorRGBA => "std_msgs/msg/ColorRGBA",
    Bool => "std_msgs/msg/Bool",
    Header => "std_msgs/msg/Header",
    String => "std_msgs/msg/String",
}
