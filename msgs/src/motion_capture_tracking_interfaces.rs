//! Package `motion_capture_tracking_interfaces`: what trackers publish of all bodies at once.
//!
//! # Source
//!
//! Crazyswarm2 and the package `motion_capture_tracking`, which speaks to Vicon, `OptiTrack`,
//! Qualisys and others, publish it on `/poses`.

use serde::{Deserialize, Serialize};

use crate::geometry_msgs::Pose;
use crate::message::ros_messages;
use crate::std_msgs::Header;

/// Poses of several bodies by their names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NamedPoseArray {
    /// When and in which frame.
    pub header: Header,
    /// Those that are seen.
    pub poses: Vec<NamedPose>,
}

/// The pose of a body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct NamedPose {
    /// What the tracker calls it.
    pub name: String,
    /// Where it is.
    pub pose: Pose,
}

ros_messages! {
    NamedPose => "motion_capture_tracking_interfaces/msg/NamedPose",
    NamedPoseArray => "motion_capture_tracking_interfaces/msg/NamedPoseArray",
}
