//! Poses of all robots in one message, as trackers send them.

use rsrs_core::robot::pose_source::PoseSource;
use rsrs_msgs::RosMessage;
use rsrs_msgs::geometry_msgs::PoseArray;
use rsrs_msgs::motion_capture_tracking_interfaces::NamedPoseArray;

use super::TrajectoryError;
use super::pose::{self, RawPose};
use crate::{Bag, TopicInfo};

/// The last part of the name that trackers give to such a topic.
const USUAL_NAME: &str = "/poses";

/// The poses in a message, without those that the tracker lost, under the name that belongs to the
/// number of each.
pub fn in_order(array: PoseArray, name_of: impl Fn(usize) -> String) -> Vec<RawPose> {
    let PoseArray { header, poses } = array;
    let raw = poses.into_iter().enumerate();
    let raw = raw.map(|(number, pose)| pose::of_message(name_of(number), &header, pose));
    raw.filter(RawPose::is_seen).collect()
}

/// The poses in a message, without those that the tracker lost, which are NaN.
pub fn named(array: NamedPoseArray) -> Vec<RawPose> {
    let NamedPoseArray { header, poses } = array;
    let raw = poses.into_iter().map(|named| pose::of_message(named.name, &header, named.pose));
    raw.filter(RawPose::is_seen).collect()
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
