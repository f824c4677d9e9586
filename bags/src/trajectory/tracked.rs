//! Poses out of the messages of a tracker that is described: in a bag, and while a run goes on.

use std::collections::{BTreeSet, HashMap};

use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::tracker::Tracker;
use rsrs_msgs::cdr;
use rsrs_msgs::geometry_msgs::{PoseArray, PoseStamped};
use rsrs_msgs::motion_capture_tracking_interfaces::NamedPoseArray;
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::topics::{self, Topic};

use super::arrays;
use super::error::{TrajectoryError, UnreadablePoses};
use super::pose::{self, RawPose};
use super::sources::described;
use super::transforms::Tree;
use crate::TopicInfo;

/// Names of other bodies that are kept, to be shown to a person who has misspelt one.
const MOST_OTHERS: usize = 100;

/// A topic with poses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TrackedTopic {
    /// Its full name.
    pub name: String,
    /// Its type, and how it is subscribed.
    pub topic: Topic,
    /// The robot whose poses it has; `None` if it has those of all.
    pub robot: Option<String>,
    /// Which of the tracker's machines publishes it.
    pub machine: usize,
}

/// Reads the poses of robots out of a tracker's messages.
#[derive(Clone)]
pub struct PoseReader {
    source: PoseSource,
    tracker: Tracker,
    topics: Vec<TrackedTopic>,
    /// By name and type: its place among the topics.
    places: HashMap<String, usize>,
    /// What the tracker calls each robot; for transforms the frames of its body.
    robots: HashMap<String, String>,
    tree: Tree,
    others: BTreeSet<String>,
}

impl PoseReader {
    /// A reader of the poses of these robots that has received nothing.
    pub fn new(source: PoseSource, tracker: &Tracker, robots: &[String]) -> Self {
        let topics = topics_of(source, tracker, robots);
        let places = topics.iter().enumerate();
        Self {
            source,
            tracker: tracker.clone(),
            places: places.map(|(index, topic)| (topic.name.clone(), index)).collect(),
            topics,
            robots: robots.iter().flat_map(|robot| bodies_of(source, tracker, robot)).collect(),
            tree: Tree::default(),
            others: BTreeSet::new(),
        }
    }

    /// The topics with poses.
    pub fn topics(&self) -> &[TrackedTopic] {
        &self.topics
    }

    /// The place of a topic among them; `None` if it is none of them, or of another type.
    pub fn index_of(&self, name: &str, type_name: &str) -> Option<usize> {
        let index = *self.places.get(name)?;
        (self.topics[index].topic.type_name == type_name).then_some(index)
    }

    /// The robots whose poses are wanted, some of them more than once.
    pub fn robots(&self) -> impl Iterator<Item = &String> {
        self.robots.values()
    }

    /// What the tracker sees besides the robots, by name: some of it, in alphabetical order.
    pub fn others(&self) -> impl Iterator<Item = &str> {
        self.others.iter().map(String::as_str)
    }

    /// The transforms that were received.
    pub(super) fn tree(&self) -> &Tree {
        &self.tree
    }

    /// The poses of robots in a message, along the floor's axes and in the tracker's units:
    /// [`on_floor`](rsrs_core::tracker::TrackerFrame::on_floor) puts them on the floor. The `topic`
    /// is given by its place among the topics. Of a message that does not read, no pose counts.
    pub fn take(&mut self, topic: usize, bytes: &[u8]) -> Result<Vec<RawPose>, UnreadablePoses> {
        let robot = || self.topics[topic].robot.clone().unwrap_or_default();
        let raw = match self.source {
            PoseSource::Odom => {
                let Odometry { header, pose, .. } = cdr::decode(bytes)?;
                vec![pose::of_message(robot(), &header, pose.pose)]
            }
            PoseSource::Pose => {
                let PoseStamped { header, pose } = cdr::decode(bytes)?;
                vec![pose::of_message(robot(), &header, pose)]
            }
            PoseSource::NamedPoses => {
                let array: NamedPoseArray = cdr::decode(bytes)?;
                let mut seen = BTreeSet::new();
                if let Some(twice) = array.poses.iter().find(|pose| !seen.insert(&pose.name)) {
                    return Err(UnreadablePoses::Twice { name: twice.name.clone() });
                }
                self.of_robots(arrays::named(array))
            }
            PoseSource::PoseArray => {
                let array: PoseArray = cdr::decode(bytes)?;
                let (found, expected) = (array.poses.len(), self.tracker.names.len());
                if found != expected {
                    return Err(UnreadablePoses::Length { found, expected });
                }
                let named = arrays::in_order(array, |number| self.tracker.names[number].clone());
                self.of_robots(named)
            }
            PoseSource::Tf => {
                let robots = &self.robots;
                let robot_of = |frame: &str| robots.get(frame).cloned();
                self.tree.take(cdr::decode(bytes)?, &robot_of, self.tracker.parent.as_deref())
            }
        };
        Ok(raw.into_iter().map(|raw| raw.upright(&self.tracker.frame)).collect())
    }

    /// Those of bodies that are robots, by the names of these.
    fn of_robots(&mut self, bodies: Vec<RawPose>) -> Vec<RawPose> {
        let mut of_robots = Vec::with_capacity(bodies.len());
        for mut raw in bodies {
            if let Some(robot) = self.robots.get(&raw.robot) {
                raw.robot.clone_from(robot);
                of_robots.push(raw);
            } else if self.others.len() < MOST_OTHERS && !self.others.contains(&raw.robot) {
                self.others.insert(raw.robot);
            }
        }
        of_robots
    }

    /// Refuses a bag that has none of the topics.
    pub(super) fn check(&self, topics: &[TopicInfo]) -> Result<(), TrajectoryError> {
        let is_there = |topic: &TopicInfo| self.index_of(&topic.name, &topic.type_name).is_some();
        if topics.iter().any(is_there) {
            return Ok(());
        }
        let expected = |topic: &TrackedTopic| format!("{} ({})", topic.name, topic.topic.type_name);
        Err(TrajectoryError::NoTracker {
            expected: self.topics.iter().map(expected).collect(),
            topics: described(topics),
        })
    }
}

/// The topics on which such a tracker publishes.
fn topics_of(source: PoseSource, tracker: &Tracker, robots: &[String]) -> Vec<TrackedTopic> {
    let of_robots = |topic: Topic| {
        let of_robot = |robot: &String| {
            let names = tracker.topics_of(robot, topic.name).into_iter().enumerate();
            let tracked = names.map(|(machine, name)| TrackedTopic {
                name,
                topic,
                robot: Some(robot.clone()),
                machine,
            });
            tracked.collect::<Vec<_>>()
        };
        robots.iter().flat_map(of_robot).collect()
    };
    let of_all = |topic: Topic| {
        let names = tracker.topics_of_all(topic.name).into_iter().enumerate();
        names.map(|(machine, name)| TrackedTopic { name, topic, robot: None, machine }).collect()
    };
    match source {
        PoseSource::Odom => of_robots(topics::ODOM),
        PoseSource::Pose => of_robots(topics::POSE),
        PoseSource::NamedPoses => of_all(topics::NAMED_POSES),
        PoseSource::PoseArray => of_all(topics::POSE_ARRAY),
        PoseSource::Tf => [topics::TF, topics::TF_STATIC]
            .map(|topic| TrackedTopic {
                name: topic.name.to_owned(),
                topic,
                robot: None,
                machine: 0,
            })
            .to_vec(),
    }
}

/// What a robot is called in messages, with its name.
fn bodies_of(source: PoseSource, tracker: &Tracker, robot: &str) -> Vec<(String, String)> {
    let named = |body: String| (body, robot.to_owned());
    if source == PoseSource::Tf && !tracker.bodies.contains_key(robot) {
        return pose::frames_of_robot(robot).map(named).to_vec();
    }
    vec![named(tracker.body_of(robot).trim_start_matches('/').to_owned())]
}
