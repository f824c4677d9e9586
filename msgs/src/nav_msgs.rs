//! Package `nav_msgs`: odometry.

use serde::{Deserialize, Serialize};

use crate::geometry_msgs::{PoseWithCovariance, TwistWithCovariance};
use crate::message::ros_messages;
use crate::std_msgs::Header;

/// Pose and velocity of a robot; ground truth when the simulator sends it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Odometry {
    /// When, and the frame of the pose.
    pub header: Header,
    /// The frame of the velocity: the robot's own.
    pub child_frame_id: String,
    /// Where the robot is, in the frame of the header.
    pub pose: PoseWithCovariance,
    /// How it moves, in its own frame.
    pub twist: TwistWithCovariance,
}

ros_messages! {
    Odometry => "nav_msgs/msg/Odometry",
}
