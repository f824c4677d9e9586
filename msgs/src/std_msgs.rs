//! Package `std_msgs`: a flag and the usual header.

use serde::{Deserialize, Serialize};

use crate::builtin_interfaces::Time;
use crate::message::ros_messages;

/// A flag; on `detection`, whether the robot sees another one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bool {
    /// The flag.
    pub data: bool,
}

/// When and in which frame a message was made.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// When, by the sender's clock, or by `/clock` in simulated time.
    pub stamp: Time,
    /// The coordinate frame, such as `robot_3/odom`.
    pub frame_id: String,
}

ros_messages! {
    Bool => "std_msgs/msg/Bool",
    Header => "std_msgs/msg/Header",
}
