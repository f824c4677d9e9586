//! A log line, on `/rosout`.

use serde::{Deserialize, Serialize};

use crate::builtin_interfaces::Time;
use crate::message::ros_messages;

/// A log line.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Log {
    /// When.
    pub stamp: Time,
    /// One of the constants of this type.
    pub level: u8,
    /// Which logger, usually the node's name.
    pub name: String,
    /// The line.
    pub msg: String,
    /// Source file; may be empty.
    pub file: String,
    /// Function; may be empty.
    pub function: String,
    /// Line in the source file.
    pub line: u32,
}

impl Log {
    /// For developers.
    pub const DEBUG: u8 = 10;
    /// For the curious.
    pub const INFO: u8 = 20;
    /// May go wrong.
    pub const WARN: u8 = 30;
    /// Went wrong.
    pub const ERROR: u8 = 40;
    /// The end.
    pub const FATAL: u8 = 50;
}

ros_messages! {
    Log => "rcl_interfaces/msg/Log",
}
