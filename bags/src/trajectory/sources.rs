//! Which topics have poses, and which of them are taken.

use std::collections::BTreeSet;

use rsrs_core::robot::pose_source::PoseSource;
use rsrs_msgs::geometry_msgs::{Twist, TwistStamped};
use rsrs_msgs::{RosMessage, topics};

use super::TrajectoryError;
use super::arrays;
use super::pose;
use crate::TopicInfo;

/// The source that poses are taken from.
#[derive(Debug)]
pub struct Chosen {
    pub source: PoseSource,
    /// Others that have poses of all robots, too, where nothing states which one counts.
    pub others: Vec<PoseSource>,
}

/// The source that was asked for, or else the first that has poses of all robots that are commanded;
/// where there is none such, the first that has any.
pub fn choose(topics: &[TopicInfo], asked: Option<PoseSource>) -> Result<Chosen, TrajectoryError> {
    let has_topic =
        |source: &PoseSource| topics.iter().any(|topic| has_poses(topics, topic, *source));
    let there: Vec<PoseSource> = match asked {
        Some(source) => Vec::from([source]).into_iter().filter(has_topic).collect(),
        None => PoseSource::ALL.into_iter().filter(has_topic).collect(),
    };
    let whole = there.iter().copied().filter(|source| has_all(topics, *source));
    let mut whole: Vec<PoseSource> = whole.collect();
    if !whole.is_empty() {
        let source = whole.remove(0);
        return Ok(Chosen { source, others: whole });
    }
    let recorded = |source: &&PoseSource| {
        topics.iter().any(|topic| topic.n_messages > 0 && has_poses(topics, topic, **source))
    };
    let source = there.iter().find(recorded).or(there.first());
    let source =
        *source.ok_or_else(|| TrajectoryError::NoPoses { asked, topics: described(topics) })?;
    Ok(Chosen { source, others: Vec::new() })
}

/// Whether a topic is one of those with the poses of a source.
pub fn has_poses(topics: &[TopicInfo], topic: &TopicInfo, source: PoseSource) -> bool {
    match source {
        PoseSource::NamedPoses | PoseSource::PoseArray => {
            arrays::topic(topics, source).is_some_and(|chosen| chosen.name == topic.name)
        }
        PoseSource::Odom | PoseSource::Pose => pose::robot_of_topic(topic, source).is_some(),
        PoseSource::Tf => is_same(topic, topics::TF),
    }
}

/// Whether a source has messages of every robot that is commanded, as far as topics show it.
fn has_all(topics: &[TopicInfo], source: PoseSource) -> bool {
    let recorded =
        || topics.iter().filter(|topic| topic.n_messages > 0 && has_poses(topics, topic, source));
    if !source.is_of_each_robot() {
        return recorded().next().is_some();
    }
    let posed: BTreeSet<String> =
        recorded().filter_map(|topic| pose::robot_of_topic(topic, source)).collect();
    let mut commanded =
        topics.iter().filter(|topic| topic.n_messages > 0).filter_map(robot_commanded_by);
    !posed.is_empty() && commanded.all(|robot| posed.contains(&robot))
}

/// The robot whose commands a topic has, if it has some.
pub fn robot_commanded_by(topic: &TopicInfo) -> Option<String> {
    let command_types = [TwistStamped::TYPE_NAME, Twist::TYPE_NAME];
    let is_command = command_types.contains(&topic.type_name.as_str());
    is_command.then(|| pose::robot_of(&topic.name, topics::CMD_VEL)).flatten()
}

/// Whether a topic is a known one, by name and type.
pub fn is_same(topic: &TopicInfo, known: topics::Topic) -> bool {
    topic.name == known.name && topic.type_name == known.type_name
}

/// Topics as a person would look for them.
pub fn described(topics: &[TopicInfo]) -> Vec<String> {
    topics.iter().map(|topic| format!("{} ({})", topic.name, topic.type_name)).collect()
}
