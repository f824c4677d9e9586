//! Poses of all robots in one message, as trackers send them.

use rsrs_core::robot::pose_source::PoseSource;
use rsrs_msgs::RosMessage;
use rsrs_msgs::geometry_msgs::Pose;
use rsrs_msgs::std_msgs::Header;
use serde::{Deserialize, Serialize};

use super::TrajectoryError;
use super::pose::{self, RawPose};
use crate::{Bag, TopicInfo};

/// The last part of the name that trackers give to such a topic.
const USUAL_NAME: &str = "/poses";

/// Poses that their sender identifies by number only.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct PoseArray {
    pub(super) header: Header,
    pub(super) poses: Vec<Pose>,
}

impl RosMessage for PoseArray {
    const TYPE_NAME: &'static str = "geometry_msgs/msg/PoseArray";
}

/// Poses with the names of the bodies that have them.
///
/// # Source
///
/// The package `motion_capture_tracking_interfaces`, which Crazyswarm2 uses.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct NamedPoseArray {
    pub(super) header: Header,
    pub(super) poses: Vec<NamedPose>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct NamedPose {
    pub(super) name: String,
    pub(super) pose: Pose,
}

impl RosMessage for NamedPoseArray {
    const TYPE_NAME: &'static str = "motion_capture_tracking_interfaces/msg/NamedPoseArray";
}

impl NamedPoseArray {
    /// The poses in it, without those that the tracker lost, which are NaN.
    pub fn into_raw(self) -> Vec<RawPose> {
        let Self { header, poses } = self;
        let raw = poses.into_iter().map(|named| (named.name, named.pose));
        let seen = raw.filter(is_seen);
        seen.map(|(name, pose)| pose::of_message(name, &header, pose)).collect()
    }
}

impl PoseArray {
    /// The poses in it, named by their numbers, without those that the tracker lost.
    pub fn into_raw(self) -> Vec<RawPose> {
        let Self { header, poses } = self;
        let raw = poses.into_iter().enumerate().map(|(number, pose)| (number.to_string(), pose));
        let seen = raw.filter(is_seen);
        seen.map(|(name, pose)| pose::of_message(name, &header, pose)).collect()
    }

    /// How many bodies the tracker has.
    pub fn n_bodies(&self) -> usize {
        self.poses.len()
    }
}

fn is_seen((_, pose): &(String, Pose)) -> bool {
    let Pose { position, orientation } = pose;
    let numbers = [position.x, position.y, orientation.z, orientation.w];
    numbers.iter().all(|number| number.is_finite())
}

/// The type of the message that this source reads, if it is one message for all robots.
pub fn type_name(source: PoseSource) -> Option<&'static str> {
    match source {
        PoseSource::NamedPoses => Some(NamedPoseArray::TYPE_NAME),
        PoseSource::PoseArray => Some(PoseArray::TYPE_NAME),
        PoseSource::Odom | PoseSource::Pose | PoseSource::Tf => None,
    }
}

/// The one topic with the poses of all robots: `/poses` if there is a choice.
pub fn topic(topics: &[TopicInfo], source: PoseSource) -> Option<&TopicInfo> {
    let type_name = type_name(source)?;
    let mut of_type = topics.iter().filter(|topic| topic.type_name == type_name);
    let first = of_type.clone().next();
    of_type.find(|topic| topic.name.ends_with(USUAL_NAME)).or(first)
}

/// Refuses named poses with unknown fields.
///
/// # Errors
///
/// [`TrajectoryError::Layout`].
pub fn check_layout(bag: &Bag, topic: &TopicInfo) -> Result<(), TrajectoryError> {
    if topic.type_name != NamedPoseArray::TYPE_NAME {
        return Ok(());
    }
    let text = String::from_utf8_lossy(bag.schema(&topic.type_name).unwrap_or_default());
    let words = |line: &str| -> Vec<String> {
        let code = line.split('#').next().unwrap_or_default();
        code.split_whitespace().map(str::to_owned).collect()
    };
    let fields: Vec<Vec<String>> = text
        .lines()
        .skip_while(|line| !line.starts_with("MSG:") || !line.ends_with("/NamedPose"))
        .skip(1)
        .take_while(|line| !line.starts_with("===="))
        .map(words)
        .filter(|words| !words.is_empty())
        .collect();
    let expected = [["string", "name"], ["geometry_msgs/Pose", "pose"]];
    if fields == expected {
        return Ok(());
    }
    let found = fields.iter().map(|words| words.join(" ")).collect();
    Err(TrajectoryError::Layout { topic: topic.name.clone(), found })
}
