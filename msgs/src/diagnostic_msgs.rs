//! Package `diagnostic_msgs`: the health of parts, for ROS's monitors.

use serde::{Deserialize, Serialize};

use crate::message::ros_messages;
use crate::std_msgs::Header;

/// A named value beside a diagnosis.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeyValue {
    /// What the value is, with its unit.
    pub key: String,
    /// The value, as text.
    pub value: String,
}

/// The health of one part.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiagnosticStatus {
    /// One of the constants of this type.
    pub level: u8,
    /// Which part, such as `robot_3: link`.
    pub name: String,
    /// The diagnosis in words.
    pub message: String,
    /// Serial number or address of the part.
    pub hardware_id: String,
    /// Values that bear on it.
    pub values: Vec<KeyValue>,
}

impl DiagnosticStatus {
    /// All is well.
    pub const OK: u8 = 0;
    /// Look at it.
    pub const WARN: u8 = 1;
    /// It fails.
    pub const ERROR: u8 = 2;
    /// Nothing received for too long.
    pub const STALE: u8 = 3;
}

/// The health of several parts, on `/diagnostics`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiagnosticArray {
    /// When; the frame is not used.
    pub header: Header,
    /// One entry per part.
    pub status: Vec<DiagnosticStatus>,
}

ros_messages! {
    KeyValue => "diagnostic_msgs/msg/KeyValue",
    DiagnosticStatus => "diagnostic_msgs/msg/DiagnosticStatus",
    DiagnosticArray => "diagnostic_msgs/msg/DiagnosticArray",
}
