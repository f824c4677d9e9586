//! Package `tf2_msgs`: the transform tree.

use serde::{Deserialize, Serialize};

use crate::geometry_msgs::TransformStamped;
use crate::message::ros_messages;

/// Chains of transforms are longer than this only if they lead in a circle.
pub const MAX_CHAIN: usize = 32;

/// Some edges of the transform tree, on `/tf`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TFMessage {
    /// The edges.
    pub transforms: Vec<TransformStamped>,
}

ros_messages! {
    TFMessage => "tf2_msgs/msg/TFMessage",
}
