//! Package `rosgraph_msgs`: simulated time.

use serde::{Deserialize, Serialize};

use crate::builtin_interfaces::Time;
use crate::message::ros_messages;

/// The simulated time, on `/clock`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Clock {
    /// Time since the start of the simulation.
    pub clock: Time,
}

ros_messages! {
    Clock => "rosgraph_msgs/msg/Clock",
}
