//! What messages mean to an observation, whether they are received or recorded.

use std::time::Duration;

use anyhow::Context;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_fleet::e_stop::{Message, Source};
use rsrs_fleet::observation::Event;
use rsrs_fleet::record::{Ending, ExperimentRecord};
use rsrs_fleet::wire;
use rsrs_msgs::cdr::decode;
use rsrs_msgs::geometry_msgs::{PoseStamped, Twist, TwistStamped};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rosgraph_msgs::Clock;
use rsrs_msgs::rsrs::{RobotStatus, RunLease};
use rsrs_msgs::std_msgs::{self, Bool};
use rsrs_msgs::topics::{self, Topic};

/// Topics of each robot that are watched.
const OF_ROBOTS: [Topic; 6] = [
    topics::DETECTION,
    topics::CMD_VEL,
    topics::CMD_VEL_UNSTAMPED,
    topics::ODOM,
    topics::POSE,
    topics::STATUS,
];
/// Topics of the swarm that are watched.
pub(super) const OF_SWARM: [Topic; 7] = [
    topics::LEASE,
    topics::E_STOP,
    topics::E_STOP_LOCKS,
    topics::EXPERIMENT,
    topics::ENDING,
    topics::DIAGNOSTICS,
    topics::CLOCK,
];

/// A topic that is watched.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct WatchedTopic {
    /// Its place in the table of topics.
    pub topic: Topic,
    /// Whose it is, a robot's or an object's; empty for one of the swarm.
    pub owner: String,
    /// Which further reading of the robot it has; empty for another topic.
    pub reading: String,
}

impl WatchedTopic {
    /// The topic of this name and type, if it is watched.
    pub fn new(name: &str, type_name: &str) -> Option<Self> {
        let is_it = |topic: &&Topic| topic.name == name && topic.type_name == type_name;
        if let Some(topic) = OF_SWARM.iter().find(is_it) {
            return Some(Self::of_owner(*topic, ""));
        }
        if let Some(object) = topics::object_of(name) {
            let is_pose = type_name == topics::OBJECT_POSE.type_name;
            return is_pose.then(|| Self::of_owner(topics::OBJECT_POSE, object));
        }
        if let Some((robot, reading)) = topics::further_reading(name) {
            let topic = topics::FURTHER_DETECTION;
            let is_reading = type_name == topic.type_name && topics::is_namespace(reading);
            let reading = reading.to_owned();
            return is_reading.then(|| Self { reading, ..Self::of_owner(topic, robot) });
        }
        let of_type = OF_ROBOTS.iter().filter(|topic| topic.type_name == type_name);
        let mut found = of_type.filter_map(|topic| Some((topic, topic.robot_of(name)?)));
        let (topic, robot) = found.next()?;
        Some(Self::of_owner(*topic, robot))
    }

    /// A topic that is no further reading; its owner is empty for one of the swarm.
    pub fn of_owner(topic: Topic, owner: &str) -> Self {
        Self { topic, owner: owner.to_owned(), reading: String::new() }
    }

    /// Its full name.
    pub fn name(&self) -> String {
        if self.is_of_object() {
            topics::object_pose(&self.owner)
        } else if self.is_further() {
            topics::further_detection(&self.owner, &self.reading)
        } else {
            self.topic.for_robot(&self.owner)
        }
    }

    /// Whether it tells where an object is.
    pub fn is_of_object(&self) -> bool {
        self.topic == topics::OBJECT_POSE
    }

    /// Whether it has a further reading.
    pub fn is_further(&self) -> bool {
        self.topic == topics::FURTHER_DETECTION
    }

    /// Whether only robots of this protocol, or such as take part in it, have this topic.
    pub fn shows_a_robot(&self) -> bool {
        self.topic == topics::STATUS || self.topic == topics::DETECTION
    }

    /// Understands a message of this writer on it; the error states what is wrong with the message.
    pub fn understand(&self, writer: Source, bytes: &[u8]) -> anyhow::Result<Event> {
        let robot = || self.owner.clone();
        let topic = self.topic;
        Ok(if topic == topics::DETECTION {
            Event::Detection { robot: robot(), detected: decode::<Bool>(bytes)?.data }
        } else if topic == topics::FURTHER_DETECTION {
            let (reading, is_true) = (self.reading.clone(), decode::<Bool>(bytes)?.data);
            Event::Reading { robot: robot(), reading, is_true }
        } else if topic == topics::CMD_VEL {
            let command = wire::command(&decode::<TwistStamped>(bytes)?.twist)?;
            Event::Command { robot: robot(), command }
        } else if topic == topics::CMD_VEL_UNSTAMPED {
            let command = wire::command(&decode::<Twist>(bytes)?)?;
            Event::Command { robot: robot(), command }
        } else if topic == topics::ODOM {
            let pose = wire::pose(&decode::<Odometry>(bytes)?.pose.pose)?;
            Event::Pose { robot: robot(), source: PoseSource::Odom, pose }
        } else if topic == topics::POSE {
            let pose = wire::pose(&decode::<PoseStamped>(bytes)?.pose)?;
            Event::Pose { robot: robot(), source: PoseSource::Pose, pose }
        } else if topic == topics::OBJECT_POSE {
            let place = wire::pose(&decode::<PoseStamped>(bytes)?.pose)?;
            Event::Object { object: self.owner.clone(), place_m: [place.x_m, place.y_m] }
        } else if topic == topics::STATUS {
            let status = wire::status(decode::<RobotStatus>(bytes)?)?;
            Event::Status { robot: robot(), status }
        } else {
            self.understand_of_swarm(writer, bytes)?
        })
    }

    fn understand_of_swarm(&self, writer: Source, bytes: &[u8]) -> anyhow::Result<Event> {
        let topic = self.topic;
        Ok(if topic == topics::LEASE {
            Event::Lease(wire::lease(decode::<RunLease>(bytes)?)?)
        } else if topic == topics::E_STOP {
            let engaged = decode::<Bool>(bytes)?.data;
            Event::EStop(Message::State { source: writer, engaged })
        } else if topic == topics::E_STOP_LOCKS {
            let locks = wire::locks(decode(bytes)?)?;
            Event::EStop(Message::Locks { reporter: writer, locks })
        } else if topic == topics::EXPERIMENT {
            let record = ExperimentRecord::from_json(&decode::<std_msgs::String>(bytes)?.data)?;
            Event::Experiment(Box::new(record))
        } else if topic == topics::ENDING {
            let (ending, run_id) = Ending::from_json(&decode::<std_msgs::String>(bytes)?.data)?;
            Event::Ending { run_id, ending }
        } else if topic == topics::DIAGNOSTICS {
            Event::Diagnoses(wire::diagnoses(decode(bytes)?))
        } else {
            let nanos = decode::<Clock>(bytes)?.clock.to_nanos();
            Event::Clock(Duration::from_nanos(nanos.context("time before 1970")?))
        })
    }
}

#[cfg(test)]
mod tests {
    use rsrs_msgs::cdr;

    use super::*;

    #[test]
    fn topics_are_watched_by_name_and_type() {
        let robot_of = |name, type_name| WatchedTopic::new(name, type_name).map(|it| it.owner);
        let stamped = topics::CMD_VEL.type_name;

        assert_eq!(robot_of("/robot_3/cmd_vel", stamped).as_deref(), Some("robot_3"));
        assert_eq!(robot_of("/a/b/cmd_vel", stamped).as_deref(), Some("a/b"));
        assert_eq!(robot_of("/swarm/lease", topics::LEASE.type_name).as_deref(), Some(""));
        let of_object =
            WatchedTopic::new("/objects/object_2/pose", topics::POSE.type_name).unwrap();
        assert!(of_object.is_of_object());
        assert_eq!(
            (of_object.name().as_str(), of_object.owner.as_str()),
            ("/objects/object_2/pose", "object_2")
        );
        for (name, type_name) in [
            ("/objects/object_2/pose", topics::ODOM.type_name),
            ("/robot_3/cmd_vel", "std_msgs/msg/Bool"),
            ("/robot_3/controller/status", topics::STATUS.type_name),
            ("/simulator/status", topics::STATUS.type_name),
            ("/robot_3/hardware/cmd_vel", stamped),
            ("/cmd_vel", stamped),
        ] {
            assert_eq!(robot_of(name, type_name), None, "{name}");
        }
    }

    #[test]
    fn every_watched_topic_understands_its_own_messages_and_refuses_no_bytes() {
        let robots = OF_ROBOTS.iter().map(|topic| (*topic, "robot_1"));
        let robots = robots
            .chain([(topics::OBJECT_POSE, "object_1"), (topics::FURTHER_DETECTION, "robot_1")]);
        for (topic, robot) in robots.chain(OF_SWARM.iter().map(|topic| (*topic, ""))) {
            let watched = WatchedTopic::of_owner(topic, robot);

            let nothing = watched.understand(Source([1; 16]), &[]);

            assert!(nothing.is_err(), "{}", topic.name);
        }
        let watched = WatchedTopic::of_owner(topics::DETECTION, "robot_1");
        let event = watched.understand(Source([1; 16]), &cdr::encode(&Bool { data: true }));
        let expected = Event::Detection { robot: "robot_1".to_owned(), detected: true };
        assert_eq!(event.unwrap(), expected);
    }

    #[test]
    fn further_readings_are_watched_by_their_names() {
        let bool = topics::FURTHER_DETECTION.type_name;
        let watched = WatchedTopic::new("/robot_3/detection/wall", bool).expect("it is one");

        let event = watched.understand(Source([1; 16]), &cdr::encode(&Bool { data: true }));

        let (robot, reading) = ("robot_3".to_owned(), "wall".to_owned());
        assert_eq!(event.unwrap(), Event::Reading { robot, reading, is_true: true });
        assert_eq!(watched.name(), "/robot_3/detection/wall");
        assert_eq!(WatchedTopic::new("/robot_3/detection/a b", bool), None);
    }
}
