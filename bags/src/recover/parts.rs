//! What a file is made of, before it is bytes.

use std::collections::BTreeMap;

use crate::writer::ChannelDescription;

/// Times and places of messages within a chunk, by channel.
pub type Entries = BTreeMap<u16, Vec<(u64, u64)>>;

/// The definition of a type, as a file has it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Schema {
    /// Such as `std_msgs/msg/Bool`; empty for a channel that never had one.
    pub name: String,
    /// `ros2msg` or `ros2idl`.
    pub encoding: String,
    /// Its text.
    pub data: Vec<u8>,
}

/// All types and channels of a file, by the numbers that it has for them.
#[derive(Default)]
pub struct Definitions {
    pub schemas: BTreeMap<u16, Schema>,
    /// With the number of the type.
    pub channels: BTreeMap<u16, (u16, ChannelDescription)>,
}

/// Where a record is in the file.
#[derive(Clone, Copy)]
pub struct Span {
    pub at: u64,
    pub n_bytes: u64,
}
