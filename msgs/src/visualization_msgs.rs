//! Package `visualization_msgs`: what viewers such as `RViz` and Foxglove draw into the scene.

use serde::{Deserialize, Serialize};

use crate::builtin_interfaces::Duration;
use crate::geometry_msgs::{Point, Pose, Vector3};
use crate::message::ros_messages;
use crate::sensor_msgs::CompressedImage;
use crate::std_msgs::{ColorRGBA, Header};

/// Some things to draw.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MarkerArray {
    /// They replace those of the same namespace and number.
    pub markers: Vec<Marker>,
}

/// A thing to draw, or many of one kind.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// When, and the frame of the pose.
    pub header: Header,
    /// A group that a person can switch off.
    pub ns: String,
    /// Number in the group.
    pub id: i32,
    /// [`Marker::SPHERE_LIST`] and its kin.
    pub r#type: i32,
    /// [`Marker::ADD`] or [`Marker::DELETEALL`].
    pub action: i32,
    /// Where it is in the frame.
    pub pose: Pose,
    /// Its size, in metres; lines take their width from `x`, texts their height from `z`.
    pub scale: Vector3,
    /// Its colour, where `colors` is empty.
    pub color: ColorRGBA,
    /// How long it is drawn; 0 is for ever.
    pub lifetime: Duration,
    /// Whether it moves with its frame.
    pub frame_locked: bool,
    /// Corners, or the centres of a list.
    pub points: Vec<Point>,
    /// One colour for each of `points`, or none.
    pub colors: Vec<ColorRGBA>,
    /// Not used here.
    pub texture_resource: String,
    /// Not used here.
    pub texture: CompressedImage,
    /// Not used here.
    pub uv_coordinates: Vec<UVCoordinate>,
    /// The text of a text marker.
    pub text: String,
    /// Not used here.
    pub mesh_resource: String,
    /// Not used here.
    pub mesh_file: MeshFile,
    /// Not used here.
    pub mesh_use_embedded_materials: bool,
}

impl Marker {
    /// A line through all points.
    pub const LINE_STRIP: i32 = 4;
    /// A line through each two points.
    pub const LINE_LIST: i32 = 5;
    /// A ball around each point.
    pub const SPHERE_LIST: i32 = 7;
    /// A text that faces the viewer.
    pub const TEXT_VIEW_FACING: i32 = 9;
    /// Draw it.
    pub const ADD: i32 = 0;
    /// Remove everything that was drawn by this topic.
    pub const DELETEALL: i32 = 3;
}

/// A mesh as a file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MeshFile {
    /// Its name, whose extension gives the format.
    pub filename: String,
    /// The file.
    pub data: Vec<u8>,
}

/// A place on a texture; from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct UVCoordinate {
    /// To the right.
    pub u: f32,
    /// Up.
    pub v: f32,
}

ros_messages! {
    Marker => "visualization_msgs/msg/Marker",
    MarkerArray => "visualization_msgs/msg/MarkerArray",
    MeshFile => "visualization_msgs/msg/MeshFile",
    UVCoordinate => "visualization_msgs/msg/UVCoordinate",
}
