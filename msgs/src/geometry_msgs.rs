//! Package `geometry_msgs`: positions, headings, velocities.
//!
//! Metres and radians, right-handed, z up, positive turn counterclockwise (REP 103).

use serde::{Deserialize, Serialize};

use crate::message::ros_messages;
use crate::std_msgs::Header;

/// A direction with a length: metres per second or radians per second in a [`Twist`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    /// Forward (robot frame) or east (map frame).
    pub x: f64,
    /// To the left, or north.
    pub y: f64,
    /// Up.
    pub z: f64,
}

/// A velocity; a ground robot uses `linear.x` and `angular.z` only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// In metres per second.
    pub linear: Vector3,
    /// In radians per second about each axis.
    pub angular: Vector3,
}

/// An acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Accel {
    /// In metres per second squared.
    pub linear: Vector3,
    /// In radians per second squared about each axis.
    pub angular: Vector3,
}

/// A velocity with the time it is meant for.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TwistStamped {
    /// When and in which frame.
    pub header: Header,
    /// The velocity.
    pub twist: Twist,
}

/// A position, in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// In metres.
    pub x: f64,
    /// In metres.
    pub y: f64,
    /// In metres.
    pub z: f64,
}

/// An orientation as a unit quaternion; the default is no rotation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// Dimensionless, as the others.
    pub x: f64,
    /// See `x`.
    pub y: f64,
    /// Sine of half the heading, for a robot on the ground.
    pub z: f64,
    /// Cosine of half the heading, for a robot on the ground.
    pub w: f64,
}

impl Default for Quaternion {
    /// No rotation, the default of the ROS definition too; all zeros would be no orientation.
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

/// How far the length of a quaternion may be from 1: one that is further off was never set, or is not
/// a rotation.
const LENGTH_TOLERANCE: f64 = 0.01;

/// A quaternion that is not a rotation, such as the zeros of a tracker that gives positions only.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("no orientation: a quaternion of length {length:.3}, expected 1")]
pub struct NoOrientation {
    /// The length found.
    pub length: f64,
}

impl Quaternion {
    /// The heading of a robot on the ground: the turn around the vertical axis, counterclockwise from x,
    /// in radians (REP 103).
    ///
    /// # Errors
    ///
    /// [`NoOrientation`] if its length is not 1, within 0.01.
    pub fn heading_rad(self) -> Result<f64, NoOrientation> {
        let Self { x, y, z, w } = self;
        let length = (x * x + y * y + z * z + w * w).sqrt();
        if (length - 1.0).abs() <= LENGTH_TOLERANCE {
            Ok(libm::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))
        } else {
            Err(NoOrientation { length })
        }
    }
}

/// A position with an orientation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// In metres.
    pub position: Point,
    /// As a unit quaternion.
    pub orientation: Quaternion,
}

/// A pose with its time and frame, as trackers publish it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseStamped {
    /// When and in which frame.
    pub header: Header,
    /// The pose.
    pub pose: Pose,
}

/// Poses of several bodies, which only their order tells apart.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseArray {
    /// When and in which frame.
    pub header: Header,
    /// The poses, in an order that the publisher keeps.
    pub poses: Vec<Pose>,
}

/// A pose with its uncertainty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseWithCovariance {
    /// The pose.
    pub pose: Pose,
    /// Row by row over (x, y, z, rotation about x, y, z), in m², m·rad and rad²; shape `[6, 6]`.
    pub covariance: [[f64; 6]; 6],
}

/// A velocity with its uncertainty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TwistWithCovariance {
    /// The velocity.
    pub twist: Twist,
    /// Row by row over (x, y, z, rotation about x, y, z), in the squares of the units of the
    /// velocity; shape `[6, 6]`.
    pub covariance: [[f64; 6]; 6],
}

/// The step from one frame to another.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Transform {
    /// In metres.
    pub translation: Vector3,
    /// As a unit quaternion.
    pub rotation: Quaternion,
}

/// The pose of the frame `child_frame_id` in the frame of the header.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TransformStamped {
    /// When, and the parent frame.
    pub header: Header,
    /// The frame whose pose this is, such as `robot_3/base_link`.
    pub child_frame_id: String,
    /// The pose.
    pub transform: Transform,
}

ros_messages! {
    Accel => "geometry_msgs/msg/Accel",
    Vector3 => "geometry_msgs/msg/Vector3",
    Twist => "geometry_msgs/msg/Twist",
    TwistStamped => "geometry_msgs/msg/TwistStamped",
    Point => "geometry_msgs/msg/Point",
    Quaternion => "geometry_msgs/msg/Quaternion",
    Pose => "geometry_msgs/msg/Pose",
    PoseStamped => "geometry_msgs/msg/PoseStamped",
    PoseArray => "geometry_msgs/msg/PoseArray",
    PoseWithCovariance => "geometry_msgs/msg/PoseWithCovariance",
    TwistWithCovariance => "geometry_msgs/msg/TwistWithCovariance",
    Transform => "geometry_msgs/msg/Transform",
    TransformStamped => "geometry_msgs/msg/TransformStamped",
}
