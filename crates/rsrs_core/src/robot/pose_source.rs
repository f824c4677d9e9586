//! Where the poses of robots come from: the robots themselves, or whoever tracks them.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where poses come from: in a fleet file, in the record of a run, in a bag, and on the command line.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Serialize,
    Deserialize,
    JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum PoseSource {
    /// `nav_msgs/Odometry` on `/<robot>/odom`: ground truth from a simulator; elsewhere the robot's own
    /// estimate, which has an origin of its own.
    #[default]
    Odom,
    /// A tracker's `geometry_msgs/PoseStamped` on `/<robot>/pose`.
    Pose,
    /// A tracker's `motion_capture_tracking_interfaces/NamedPoseArray` of all robots, on `/poses` if
    /// there are several.
    NamedPoses,
    /// A tracker's `geometry_msgs/PoseArray` of all robots, on `/poses` if there are several; robots
    /// have numbers there, and no names.
    PoseArray,
    /// `tf2_msgs/TFMessage` on `/tf` and `/tf_static`: chains of transforms, such as `map` →
    /// `<robot>/odom` → `<robot>/base_link` (or `base_footprint`), from one frame that all robots
    /// share.
    Tf,
}

impl PoseSource {
    /// All of them, as they are preferred where nothing states which one counts: what a tracker
    /// publishes in the name of robots before what they estimate themselves, as each robot's own
    /// estimate has an origin of its own. An array without names comes after those, as it may be of
    /// anything, such as the particles of a filter.
    pub const ALL: [Self; 5] =
        [Self::Pose, Self::NamedPoses, Self::Odom, Self::PoseArray, Self::Tf];

    /// The name in files and on the command line: `named_poses`.
    pub fn key(self) -> &'static str {
        match self {
            Self::Odom => "odom",
            Self::Pose => "pose",
            Self::NamedPoses => "named_poses",
            Self::PoseArray => "pose_array",
            Self::Tf => "tf",
        }
    }

    /// The source with this name.
    pub fn from_key(key: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|source| source.key() == key)
    }

    /// Whether it is of each robot by itself, so that nothing but the names of frames tells whether all
    /// of them are in one frame.
    pub fn is_of_each_robot(self) -> bool {
        matches!(self, Self::Odom | Self::Pose)
    }
}

impl fmt::Display for PoseSource {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(self.key())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_source_is_listed_and_has_one_name_everywhere() {
        for source in PoseSource::ALL {
            assert_eq!(serde_json::to_value(source).unwrap(), source.key());
            assert_eq!(PoseSource::from_key(source.key()), Some(source));
        }
        let schema = serde_json::to_string(&schemars::schema_for!(PoseSource)).unwrap();
        assert_eq!(schema.matches("\"const\"").count(), PoseSource::ALL.len(), "{schema}");
    }
}
