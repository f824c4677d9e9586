//! How a tracker publishes where robots are, and how its poses become poses on the floor.
//!
//! Bags hold what the tracker has published; a description of the tracker goes into the record of the
//! run, so that who runs it and who judges it later read the same poses.

mod frame;
mod hand_over;

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

pub use frame::{Axes, InvalidAxes, InvalidFrame, TrackerFrame};
pub use hand_over::{HANDOVER_NS, HandOver, Taken};

/// Stands in the name of a topic for what the tracker calls the robot.
pub const BODY: &str = "{body}";

/// How a tracker publishes where robots are.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tracker {
    /// Topics with poses, one for each machine; the usual one if there is none here.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub topics: Vec<String>,
    /// What the poses of a message without names are of, in their order; not all have to be robots.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub names: Vec<String>,
    /// By robot: what the tracker calls it, where that is not its name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub bodies: BTreeMap<String, String>,
    /// The frame up to which transforms are followed; the uppermost if there is none here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parent: Option<String>,
    /// Where the tracker's frame lies on the floor.
    #[serde(skip_serializing_if = "TrackerFrame::is_the_floors")]
    pub frame: TrackerFrame,
}

/// How many messages of a tracker a topic is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carries {
    /// Poses of one robot: there is such a topic for each.
    OneRobot,
    /// Poses of all bodies.
    AllBodies,
    /// Transforms, which have topics of their own.
    Transforms,
}

/// What a tracker's description has that does not fit the way in which it publishes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum InvalidTracker {
    /// A topic of all robots where each has its own.
    #[error(
        "`topics` has `{0}`, expected a name below each robot's, such as `pose`, or one with `{BODY}` \
         in it"
    )]
    NotOfARobot(String),
    /// A topic of one robot where there is one of all.
    #[error("`topics` has `{0}`, expected a name from the root without `{BODY}`, such as `/poses`")]
    NotOfAll(String),
    /// A name that no topic may have.
    #[error("`topics` has `{0}`, which ROS 2 does not allow")]
    NoTopic(String),
    /// A topic twice.
    #[error("`topics` has `{0}` twice")]
    TwiceATopic(String),
    /// Topics for transforms.
    #[error("`topics` is given, and transforms come on /tf and /tf_static")]
    TopicsOfTransforms,
    /// Nothing tells bodies apart.
    #[error(
        "`names` is missing: a PoseArray has no names, and only their order there tells robots apart"
    )]
    NoNames,
    /// Names where messages have them.
    #[error("`names` is given, and only the poses of `pose: pose_array` lack them")]
    NeedlessNames,
    /// A name twice.
    #[error("`names` has `{0}` twice")]
    TwiceAName(String),
    /// A parent where there are no transforms.
    #[error("`parent` is given, and only `pose: tf` has frames to follow")]
    NeedlessParent,
    /// A frame that is none.
    #[error(transparent)]
    Frame(#[from] InvalidFrame),
}

impl Tracker {
    /// What the tracker calls a robot.
    pub fn body_of<'a>(&'a self, robot: &'a str) -> &'a str {
        self.bodies.get(robot).map_or(robot, String::as_str)
    }

    /// The robot that the tracker calls so, if it is one of these.
    pub fn robot_of<'a>(&self, body: &str, robots: &'a [String]) -> Option<&'a String> {
        robots.iter().find(|robot| self.body_of(robot) == body)
    }

    /// The topics with the poses of a robot, one for each machine, where each robot has its own.
    /// Where none is given it is `usual`, below the robot's name.
    pub fn topics_of(&self, robot: &str, usual: &str) -> Vec<String> {
        let full = |topic: &str| {
            if topic.starts_with('/') {
                topic.replace(BODY, self.body_of(robot))
            } else {
                format!("/{robot}/{topic}")
            }
        };
        if self.topics.is_empty() {
            return vec![full(usual)];
        }
        self.topics.iter().map(|topic| full(topic)).collect()
    }

    /// The topics with the poses of all bodies, one for each machine; `usual` where none is given.
    pub fn topics_of_all(&self, usual: &str) -> Vec<String> {
        if self.topics.is_empty() { vec![usual.to_owned()] } else { self.topics.clone() }
    }

    /// Looks whether all of it fits the way in which the tracker publishes, and where the names of
    /// bodies stand.
    pub fn check(&self, carries: Carries, names: Names) -> Result<(), InvalidTracker> {
        self.frame.check()?;
        let mut seen = BTreeSet::new();
        for topic in &self.topics {
            let named = || topic.clone();
            match carries {
                Carries::Transforms => return Err(InvalidTracker::TopicsOfTransforms),
                Carries::OneRobot if topic.starts_with('/') && !topic.contains(BODY) => {
                    return Err(InvalidTracker::NotOfARobot(named()));
                }
                Carries::AllBodies if !topic.starts_with('/') || topic.contains(BODY) => {
                    return Err(InvalidTracker::NotOfAll(named()));
                }
                Carries::OneRobot | Carries::AllBodies => {}
            }
            if !is_topic(&topic.replace(BODY, "body")) {
                return Err(InvalidTracker::NoTopic(named()));
            }
            if !seen.insert(topic) {
                return Err(InvalidTracker::TwiceATopic(named()));
            }
        }
        match names {
            Names::InTheFile if self.names.is_empty() => return Err(InvalidTracker::NoNames),
            Names::InTheMessage if !self.names.is_empty() => {
                return Err(InvalidTracker::NeedlessNames);
            }
            Names::InTheFile | Names::InTheMessage => {}
        }
        let mut seen = BTreeSet::new();
        if let Some(name) = self.names.iter().find(|name| !seen.insert(*name)) {
            return Err(InvalidTracker::TwiceAName(name.clone()));
        }
        match self.parent {
            Some(_) if carries != Carries::Transforms => Err(InvalidTracker::NeedlessParent),
            _ => Ok(()),
        }
    }
}

impl Tracker {
    /// Looks whether the topics of a robot that the tracker calls so are allowed.
    pub fn check_body(&self, body: &str) -> Result<(), InvalidTracker> {
        let named = self.topics.iter().filter(|topic| topic.contains(BODY));
        let mut topics = named.map(|topic| topic.replace(BODY, body));
        match topics.find(|topic| !is_topic(topic)) {
            Some(topic) => Err(InvalidTracker::NoTopic(topic)),
            None => Ok(()),
        }
    }
}

/// Where the names of bodies stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Names {
    /// In each message, or in the name of its topic.
    InTheMessage,
    /// In the description of the tracker alone.
    InTheFile,
}

/// Whether ROS 2 allows this as a topic's name, from the root or below a namespace.
fn is_topic(name: &str) -> bool {
    let is_part = |part: &str| {
        !part.is_empty()
            && !part.starts_with(|first: char| first.is_ascii_digit())
            && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
            && !part.contains("__")
    };
    name.strip_prefix('/').unwrap_or(name).split('/').all(is_part)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tracker(topics: &[&str]) -> Tracker {
        let bodies = BTreeMap::from([("robot_1".to_owned(), "RigidBody7".to_owned())]);
        let topics = topics.iter().map(|topic| (*topic).to_owned()).collect();
        Tracker { topics, bodies, ..Tracker::default() }
    }

    #[test]
    fn a_robots_topics_are_below_its_name_or_have_what_the_tracker_calls_it() {
        let usual = tracker(&[]);
        let machines = tracker(&["pose_a", "/vrpn/{body}/pose"]);

        assert_eq!(usual.topics_of("robot_1", "pose"), ["/robot_1/pose"]);
        assert_eq!(usual.topics_of_all("/poses"), ["/poses"]);
        assert_eq!(
            machines.topics_of("robot_1", "pose"),
            ["/robot_1/pose_a", "/vrpn/RigidBody7/pose"]
        );
        assert_eq!(machines.topics_of("robot_2", "pose")[1], "/vrpn/robot_2/pose");
    }

    #[test]
    fn a_robot_is_found_by_what_the_tracker_calls_it_and_by_that_alone() {
        let robots = ["robot_1", "robot_2"].map(str::to_owned);

        let of = |body| tracker(&[]).robot_of(body, &robots).cloned();

        assert_eq!(of("RigidBody7").as_deref(), Some("robot_1"));
        assert_eq!(of("robot_2").as_deref(), Some("robot_2"));
        assert_eq!(of("robot_1"), None, "it is called otherwise");
        assert_eq!(of("wand"), None);
    }

    #[test]
    fn what_does_not_fit_the_way_of_publishing_is_refused() {
        let one = |topics: &[&str]| {
            tracker(topics).check(Carries::OneRobot, Names::InTheMessage).unwrap_err().to_string()
        };
        let all = |tracker: &Tracker, names| {
            tracker.check(Carries::AllBodies, names).unwrap_err().to_string()
        };
        let named = |names: &[&str]| Tracker {
            names: names.iter().map(|name| (*name).to_owned()).collect(),
            ..Tracker::default()
        };

        assert!(one(&["/pose"]).contains("expected a name below each robot's"));
        assert!(one(&["p ose"]).contains("which ROS 2 does not allow"));
        assert!(one(&["a", "a"]).contains("twice"));
        let spaced = tracker(&["/{body}/pose"]).check_body("Rigid Body").unwrap_err();
        assert!(spaced.to_string().contains("`/Rigid Body/pose`, which ROS 2 does not allow"));
        assert!(all(&tracker(&["poses"]), Names::InTheMessage).contains("from the root"));
        assert!(all(&named(&[]), Names::InTheFile).contains("`names` is missing"));
        assert!(all(&named(&["a"]), Names::InTheMessage).contains("`names` is given"));
        assert!(all(&named(&["a", "a"]), Names::InTheFile).contains("`a` twice"));
        let parent = Tracker { parent: Some("map".to_owned()), ..Tracker::default() };
        assert!(all(&parent, Names::InTheMessage).contains("`parent` is given"));
        assert_eq!(parent.check(Carries::Transforms, Names::InTheMessage), Ok(()));
        assert_eq!(
            tracker(&["/poses"]).check(Carries::Transforms, Names::InTheMessage),
            Err(InvalidTracker::TopicsOfTransforms)
        );
    }
}
