//! The frames of the world and of its robots.

use rsrs_msgs::geometry_msgs::Quaternion;

/// The frame in which all poses are.
pub const FRAME: &str = "map";

/// The frame of a robot's body.
pub fn base_link(robot: &str) -> String {
    format!("{robot}/base_link")
}

/// A heading as a quaternion.
pub fn rotation(heading_rad: f64) -> Quaternion {
    let (sine, cosine) = libm::sincos(heading_rad / 2.0);
    Quaternion { x: 0.0, y: 0.0, z: sine, w: cosine }
}
