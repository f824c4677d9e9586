//! What makes a struct a ROS 2 message.

use serde::Serialize;
use serde::de::DeserializeOwned;

/// A struct with the fields of a ROS 2 message, in the message's order.
pub trait RosMessage: Serialize + DeserializeOwned + Clone + Send + Sync + 'static {
    /// The full name of the type, such as `geometry_msgs/msg/TwistStamped`.
    const TYPE_NAME: &'static str;
}

/// Names the ROS type of each struct.
macro_rules! ros_messages {
    ($($message:ty => $type_name:expr,)+) => {
        $(impl $crate::RosMessage for $message {
            const TYPE_NAME: &'static str = $type_name;
        })+
    };
}
pub(crate) use ros_messages;
