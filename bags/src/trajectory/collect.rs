//! One pass over a bag: everything that bears on the trajectory.

use std::collections::{BTreeMap, BTreeSet};

use rsrs_msgs::geometry_msgs::{PoseStamped, Twist, TwistStamped};
use rsrs_msgs::rsrs::RunLease;
use rsrs_msgs::{RosMessage, cdr, topics};

use super::command::CommandSample;
use super::pose::{self, PoseSample, RawPose};
use super::{PoseSource, TrajectoryError, TrajectoryOptions};
use crate::{Bag, BagError, BagMessage, TopicInfo};

/// What was recorded of one robot.
#[derive(Debug)]
pub struct RecordedRobot {
    /// Its name.
    pub name: String,
    /// In the order of the bag.
    pub poses: Vec<PoseSample>,
    /// In the order of the bag.
    pub commands: Vec<CommandSample>,
}

/// A change of the run lease.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeaseSample {
    /// When it was recorded, in nanoseconds.
    pub log_ns: u64,
    /// Whether it let the robots move.
    pub running: bool,
}

/// What one pass over the bag found.
#[derive(Debug)]
pub struct Collected {
    /// All robots that have poses; `robot_2` before `robot_10`.
    pub robots: Vec<RecordedRobot>,
    /// The lease, in the order of the bag; `None` if there is no such topic.
    pub lease: Option<Vec<LeaseSample>>,
    /// Where the poses came from.
    pub poses: PoseSource,
    /// Whether the bag ends before the run did, perhaps.
    pub breaks_off: bool,
}

/// Poses and commands by robot, as they are found.
#[derive(Default)]
struct Found {
    poses: BTreeMap<String, Vec<PoseSample>>,
    commands: BTreeMap<String, Vec<CommandSample>>,
    lease: Vec<LeaseSample>,
    /// The frame of all transforms.
    frame: Option<String>,
}

/// Reads the bag once.
pub fn collect(bag: &Bag, options: &TrajectoryOptions) -> Result<Collected, TrajectoryError> {
    let topics = bag.topics();
    let source = choose(&topics, options.poses)?;
    let wanted = wanted_topics(&topics, source)?;

    let mut found = Found::default();
    for message in bag.messages_on(wanted.iter().map(|topic| topic.name.as_str())) {
        match message {
            Ok(message) => found.take(source, &message)?,
            // The bag says where it breaks off; what came before is as good as ever.
            Err(BagError::Incomplete { .. }) => {}
            Err(error) => return Err(error.into()),
        }
    }

    if found.poses.is_empty() {
        return Err(TrajectoryError::NoPoses { asked: options.poses, topics: described(&topics) });
    }
    let has_lease = topics.iter().any(|topic| topic.name == topics::LEASE.name);
    let mut robots = Vec::new();
    for (name, mut poses) in found.poses {
        pose::fill_missing_stamps(&mut poses);
        let Some(commands) = found.commands.remove(&name) else {
            let expected = topics::CMD_VEL.for_robot(&name);
            let topics = described(&topics);
            return Err(TrajectoryError::NoCommands { robot: name, expected, topics });
        };
        robots.push(RecordedRobot { name, poses, commands });
    }
    robots.sort_by_cached_key(|robot| natural_key(&robot.name));
    Ok(Collected {
        robots,
        lease: has_lease.then_some(found.lease),
        poses: source,
        breaks_off: !bag.damage().is_empty(),
    })
}

/// The source that was asked for, or the first that is there.
fn choose(topics: &[TopicInfo], asked: Option<PoseSource>) -> Result<PoseSource, TrajectoryError> {
    let is_there = |source: &PoseSource| topics.iter().any(|topic| has_poses(topic, *source));
    let candidates = asked.map_or(PoseSource::ALL.to_vec(), |source| vec![source]);
    candidates
        .into_iter()
        .find(is_there)
        .ok_or_else(|| TrajectoryError::NoPoses { asked, topics: described(topics) })
}

fn has_poses(topic: &TopicInfo, source: PoseSource) -> bool {
    match source {
        PoseSource::Odom | PoseSource::Pose => pose::robot_of_topic(topic, source).is_some(),
        PoseSource::Tf => is_same(topic, topics::TF),
    }
}

fn is_same(topic: &TopicInfo, known: topics::Topic) -> bool {
    topic.name == known.name && topic.type_name == known.type_name
}

fn has_commands(topic: &TopicInfo) -> bool {
    let command_types = [TwistStamped::TYPE_NAME, Twist::TYPE_NAME];
    command_types.contains(&topic.type_name.as_str())
        && pose::robot_before(&topic.name, topics::CMD_VEL.name).is_some()
}

/// The topics with poses, commands and the lease; each must have one type.
fn wanted_topics(
    topics: &[TopicInfo],
    source: PoseSource,
) -> Result<Vec<&TopicInfo>, TrajectoryError> {
    let wanted: Vec<&TopicInfo> = topics
        .iter()
        .filter(|topic| {
            has_poses(topic, source) || has_commands(topic) || is_same(topic, topics::LEASE)
        })
        .collect();
    for topic in &wanted {
        let types: BTreeSet<&str> = topics
            .iter()
            .filter(|other| other.name == topic.name)
            .map(|other| other.type_name.as_str())
            .collect();
        if types.len() > 1 {
            let types = types.into_iter().map(str::to_owned).collect();
            return Err(TrajectoryError::TwoTypes { topic: topic.name.clone(), types });
        }
    }
    Ok(wanted)
}

impl Found {
    fn take(&mut self, source: PoseSource, message: &BagMessage) -> Result<(), TrajectoryError> {
        let topic = &*message.topic;
        let log_ns = message.log_time_ns;
        if topic == topics::LEASE.name {
            let running = decode::<RunLease>(message)?.state == RunLease::RUNNING;
            self.lease.push(LeaseSample { log_ns, running });
        } else if let Some(robot) = pose::robot_before(topic, topics::CMD_VEL.name) {
            let command = if &*message.type_name == Twist::TYPE_NAME {
                CommandSample::of_unstamped(&robot, decode::<Twist>(message)?, log_ns)?
            } else {
                CommandSample::of_stamped(&robot, &decode::<TwistStamped>(message)?, log_ns)?
            };
            self.commands.entry(robot).or_default().push(command);
        } else {
            for raw in raw_poses(source, message)? {
                self.take_pose(source, raw, log_ns)?;
            }
        }
        Ok(())
    }

    fn take_pose(
        &mut self,
        source: PoseSource,
        raw: RawPose,
        log_ns: u64,
    ) -> Result<(), TrajectoryError> {
        // Topics of one robot each are taken at their word; transforms say what they refer to.
        if source == PoseSource::Tf {
            let expected = self.frame.get_or_insert_with(|| raw.frame.clone());
            if *expected != raw.frame {
                let (robot, found) = (raw.robot, raw.frame);
                return Err(TrajectoryError::Frames { robot, found, expected: expected.clone() });
            }
        }
        let poses = self.poses.entry(raw.robot.clone()).or_default();
        poses.push(raw.sample(log_ns)?);
        Ok(())
    }
}

fn raw_poses(source: PoseSource, message: &BagMessage) -> Result<Vec<RawPose>, TrajectoryError> {
    let robot = |relative| {
        pose::robot_before(&message.topic, relative).expect("only such topics were asked for")
    };
    Ok(match source {
        PoseSource::Odom => vec![pose::of_odometry(&robot(topics::ODOM.name), decode(message)?)],
        PoseSource::Pose => {
            let decoded = decode::<PoseStamped>(message)?;
            vec![pose::of_pose_stamped(&robot(topics::POSE.name), decoded)]
        }
        PoseSource::Tf => pose::of_transforms(decode(message)?),
    })
}

fn decode<M: RosMessage>(message: &BagMessage) -> Result<M, TrajectoryError> {
    cdr::decode(&message.bytes).map_err(|source| TrajectoryError::Message {
        topic: message.topic.to_string(),
        time_s: message.log_time_ns as f64 / 1e9,
        source,
    })
}

/// Topics as a person would look for them.
fn described(topics: &[TopicInfo]) -> Vec<String> {
    topics.iter().map(|topic| format!("{} ({})", topic.name, topic.type_name)).collect()
}

/// Orders names by the number at their end, where there is one.
fn natural_key(name: &str) -> (String, Option<u64>) {
    let stem = name.trim_end_matches(|character: char| character.is_ascii_digit());
    (stem.to_owned(), name[stem.len()..].parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_are_in_the_order_in_which_people_count() {
        let mut names = ["robot_10", "robot_2", "robot", "rabbit_3"];

        names.sort_by_key(|name| natural_key(name));

        assert_eq!(names, ["rabbit_3", "robot", "robot_2", "robot_10"]);
    }
}
