//! Package `sensor_msgs`: readings of distance sensors.

use serde::{Deserialize, Serialize};

use crate::message::ros_messages;
use crate::std_msgs::Header;

/// One reading of a distance sensor with a cone.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// When, and the frame of the sensor; its x axis is the axis of the cone.
    pub header: Header,
    /// [`Range::ULTRASOUND`] or [`Range::INFRARED`].
    pub radiation_type: u8,
    /// Opening angle of the cone, in radians; the whole angle, not half of it.
    pub field_of_view: f32,
    /// Readings below this are not to be used, in metres.
    pub min_range: f32,
    /// Readings above this are not to be used, in metres.
    pub max_range: f32,
    /// The reading, in metres; infinite if nothing is in range.
    pub range: f32,
    /// Variance of the reading, in m²; 0 if unknown.
    pub variance: f32,
}

impl Range {
    /// The sensor sends sound.
    pub const ULTRASOUND: u8 = 0;
    /// The sensor sends infrared light.
    pub const INFRARED: u8 = 1;
}

/// One sweep of a laser scanner in a plane.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LaserScan {
    /// When the first ray was measured, and the frame of the scanner.
    pub header: Header,
    /// Direction of the first ray, in radians counterclockwise from the x axis.
    pub angle_min: f32,
    /// Direction of the last ray, in radians.
    pub angle_max: f32,
    /// From one ray to the next, in radians; may be negative.
    pub angle_increment: f32,
    /// From one ray to the next, in seconds.
    pub time_increment: f32,
    /// From one scan to the next, in seconds.
    pub scan_time: f32,
    /// Readings below this are not to be used, in metres.
    pub range_min: f32,
    /// Readings above this are not to be used, in metres.
    pub range_max: f32,
    /// The readings, in metres; shape `[n_rays]`.
    pub ranges: Vec<f32>,
    /// How much light came back, in the device's unit; shape `[n_rays]`, or empty.
    pub intensities: Vec<f32>,
}

/// A picture in a file's format.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CompressedImage {
    /// When, and the frame of the camera.
    pub header: Header,
    /// Such as `png` or `jpeg`.
    pub format: String,
    /// The file.
    pub data: Vec<u8>,
}

ros_messages! {
    CompressedImage => "sensor_msgs/msg/CompressedImage",
    LaserScan => "sensor_msgs/msg/LaserScan",
    Range => "sensor_msgs/msg/Range",
}
