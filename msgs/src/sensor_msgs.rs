//! Package `sensor_msgs`: one range reading.

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

ros_messages! {
    Range => "sensor_msgs/msg/Range",
}
