//! Every topic's name, type and quality of service, who publishes and who subscribes it: the one table.
//!
//! The permissions of keystores follow from it, and tests hold the page of the interface to it.
//! Matching in DDS goes by name and quality of service, and not every library compares types, so
//! no other file spells a topic.

use crate::RosMessage;
use crate::node_kind::NodeKind::{
    self, BaseDriver, Controller, Robot, Runner, SensorDriver, Simulator, Stop, Tracker, Viewer,
};
use crate::{
    diagnostic_msgs, geometry_msgs, motion_capture_tracking_interfaces, nav_msgs, rcl_interfaces,
    rosgraph_msgs, rsrs, sensor_msgs, std_msgs, tf2_msgs, visualization_msgs,
};

/// Whether a lost sample is sent again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reliability {
    /// It is.
    Reliable,
    /// It is not: the next one is better than an old one.
    BestEffort,
}

/// Whether a late subscriber gets what was sent before it came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Durability {
    /// It does not.
    Volatile,
    /// It gets the last `depth` samples.
    TransientLocal,
}

/// Quality of service; the history is always "keep last".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Qos {
    /// Whether a lost sample is sent again.
    pub reliability: Reliability,
    /// Whether a late subscriber gets old samples.
    pub durability: Durability,
    /// Samples kept per endpoint; an unread sample is overwritten after so many, reliable or not.
    pub depth: u32,
}

impl Qos {
    /// Reliable and volatile, with this depth.
    pub const fn reliable(depth: u32) -> Self {
        Self { reliability: Reliability::Reliable, durability: Durability::Volatile, depth }
    }

    /// Reliable, and the last so many are kept for those who come later (transient local).
    pub const fn latched(depth: u32) -> Self {
        Self { durability: Durability::TransientLocal, ..Self::reliable(depth) }
    }

    /// Best effort and volatile, with this depth.
    pub const fn best_effort(depth: u32) -> Self {
        Self { reliability: Reliability::BestEffort, durability: Durability::Volatile, depth }
    }
}

/// A topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Relative to the robot's namespace (`detection`), or absolute (`/swarm/lease`).
    pub name: &'static str,
    /// The full name of its type, such as `std_msgs/msg/Bool`.
    pub type_name: &'static str,
    /// Its quality of service.
    pub qos: Qos,
    /// Who publishes it; in a secured fleet, nobody else may.
    pub publishers: &'static [NodeKind],
    /// Who needs it; others may look at it or record it.
    pub subscribers: &'static [NodeKind],
}

impl Topic {
    const fn published_by(self, publishers: &'static [NodeKind]) -> Self {
        Self { publishers, ..self }
    }

    const fn subscribed_by(self, subscribers: &'static [NodeKind]) -> Self {
        Self { subscribers, ..self }
    }

    /// The full name of this topic for one robot; absolute names belong to all robots and stay.
    ///
    /// # Example
    ///
    /// ```
    /// use rsrs_msgs::topics;
    ///
    /// assert_eq!(topics::DETECTION.for_robot("robot_3"), "/robot_3/detection");
    /// assert_eq!(topics::LEASE.for_robot("robot_3"), "/swarm/lease");
    /// ```
    pub fn for_robot(&self, robot: &str) -> String {
        if self.is_absolute() { self.name.to_owned() } else { format!("/{robot}/{}", self.name) }
    }

    /// The robot whose topic has this name, with its namespace; `None` if it is no robot's, or another
    /// topic's.
    ///
    /// # Example
    ///
    /// ```
    /// use rsrs_msgs::topics;
    ///
    /// assert_eq!(topics::STATUS.robot_of("/lab/robot_3/status"), Some("lab/robot_3"));
    /// assert_eq!(topics::STATUS.robot_of("/robot_3/controller/status"), None);
    /// assert_eq!(topics::STATUS.robot_of("/robot_3/detection/status"), None, "a reading of that name");
    /// ```
    pub fn robot_of<'a>(&self, name: &'a str) -> Option<&'a str> {
        let is_of_all = |topic: &Topic| topic.is_absolute() && topic.name == name;
        let is_longer = |topic: &Topic| {
            topic.name.len() > self.name.len() && before(name, topic.name).is_some()
        };
        let is_another = |topic: &Topic| is_of_all(topic) || is_longer(topic);
        if object_of(name).is_some() {
            return None;
        }
        if let Some((robot, _)) = further_reading(name) {
            return (self.name == FURTHER_DETECTION.name).then_some(robot);
        }
        before(name, self.name).filter(|_| !self.is_absolute() && !ALL.iter().any(is_another))
    }

    /// Whether there is one such topic for the whole swarm.
    pub fn is_absolute(&self) -> bool {
        self.name.starts_with('/')
    }
}

/// Whether ROS takes a name, such as that of a robot, as a namespace; any program in the network may
/// publish under names that it does not take.
pub fn is_namespace(name: &str) -> bool {
    name.split('/').all(|part| is_token(part) && !part.contains("__"))
}

/// Whether ROS takes a part of a name: letters, digits and underscores, no digit in front.
pub fn is_token(part: &str) -> bool {
    part.chars().all(|sign| sign.is_ascii_alphanumeric() || sign == '_')
        && part.starts_with(|first: char| !first.is_ascii_digit())
}

/// What stands before the last parts of a name, without the slashes around it.
fn before<'a>(name: &'a str, last: &str) -> Option<&'a str> {
    let robot = name.strip_prefix('/')?.strip_suffix(last)?.strip_suffix('/')?;
    (!robot.is_empty()).then_some(robot)
}

/// Names a topic whose messages are of type `M`, of nobody yet.
const fn topic<M: RosMessage>(name: &'static str, qos: Qos) -> Topic {
    Topic { name, type_name: M::TYPE_NAME, qos, publishers: &[], subscribers: &[] }
}

/// Deeper than the most samples of a topic that lockstep leaves unread: the simulator is at most
/// `rsrs_fleet::simulator::RECORDER_WINDOW` steps ahead of the last one that the recorder has confirmed,
/// and the recorder confirms each. A test of `rsrs_sim_node` compares the two.
const LOCKSTEP_DEPTH: u32 = 200;

/// Name of the attachment of a bag that has the text of [`EXPERIMENT`].
pub const EXPERIMENT_ATTACHMENT: &str = "experiment.json";

/// Whether the robot sees another one; one sample per control period.
pub const DETECTION: Topic = topic::<std_msgs::Bool>("detection", Qos::reliable(LOCKSTEP_DEPTH))
    .published_by(&[Robot, Simulator])
    .subscribed_by(&[Controller]);
/// A further reading of a robot with several sensors, beside [`DETECTION`]: on [`further_detection`]. In lockstep it is
/// kept for who subscribes once it is told what the robot reports; elsewhere it is subscribed as [`DETECTION`] is.
pub const FURTHER_DETECTION: Topic =
    topic::<std_msgs::Bool>("detection/*", Qos::latched(LOCKSTEP_DEPTH))
        .published_by(&[Robot, Simulator])
        .subscribed_by(&[Controller]);
/// The name of a robot's [`FURTHER_DETECTION`] of one reading.
///
/// # Example
///
/// ```
/// use rsrs_msgs::topics;
///
/// assert_eq!(topics::further_detection("robot_3", "wall"), "/robot_3/detection/wall");
/// assert_eq!(topics::further_reading("/robot_3/detection/wall"), Some(("robot_3", "wall")));
/// assert_eq!(topics::further_reading("/robot_3/detection"), None);
/// ```
pub fn further_detection(robot: &str, reading: &str) -> String {
    format!("{}/{reading}", DETECTION.for_robot(robot))
}

/// The robot and the reading whose topic has this name, if it is a [`FURTHER_DETECTION`].
pub fn further_reading(name: &str) -> Option<(&str, &str)> {
    let (before_reading, reading) = name.rsplit_once('/')?;
    before(before_reading, DETECTION.name).map(|robot| (robot, reading))
}

/// The command that answers a detection; in lockstep, stamped with the detection's `/clock`.
pub const CMD_VEL: Topic =
    topic::<geometry_msgs::TwistStamped>("cmd_vel", Qos::reliable(LOCKSTEP_DEPTH))
        .published_by(&[Controller])
        .subscribed_by(&[Robot, Simulator]);
/// The command for drivers that take no stamp; the same name, and never both.
pub const CMD_VEL_UNSTAMPED: Topic =
    topic::<geometry_msgs::Twist>("cmd_vel", Qos::reliable(LOCKSTEP_DEPTH))
        .published_by(&[Controller])
        .subscribed_by(&[Robot, Simulator]);
/// Where the robot is: ground truth from the simulator, its own estimate from a robot.
pub const ODOM: Topic = topic::<nav_msgs::Odometry>("odom", Qos::reliable(LOCKSTEP_DEPTH))
    .published_by(&[BaseDriver, Simulator])
    .subscribed_by(&[Runner, Simulator]);
/// Where a tracker sees the robot; best effort also receives trackers that are reliable.
pub const POSE: Topic = topic::<geometry_msgs::PoseStamped>("pose", Qos::best_effort(10))
    .published_by(&[Tracker, Simulator])
    .subscribed_by(&[Runner, Simulator]);
/// Where a tracker sees all bodies, by their names; the usual name, which a fleet file may change.
pub const NAMED_POSES: Topic =
    topic::<motion_capture_tracking_interfaces::NamedPoseArray>("/poses", Qos::best_effort(10))
        .published_by(&[Tracker])
        .subscribed_by(&[Runner]);
/// The same of a tracker that tells bodies apart by their order; the same name, and never both.
pub const POSE_ARRAY: Topic = topic::<geometry_msgs::PoseArray>("/poses", Qos::best_effort(10))
    .published_by(&[Tracker])
    .subscribed_by(&[Runner]);
/// Where an object that robots push is: on [`object_pose`] of each. In lockstep it is kept for who subscribes once it is
/// told what is there; elsewhere it is subscribed as [`POSE`] is.
pub const OBJECT_POSE: Topic =
    topic::<geometry_msgs::PoseStamped>("/objects/*/pose", Qos::latched(LOCKSTEP_DEPTH))
        .published_by(&[Tracker, Simulator])
        .subscribed_by(&[Runner]);
/// The name of the [`OBJECT_POSE`] of one object.
///
/// # Example
///
/// ```
/// use rsrs_msgs::topics;
///
/// assert_eq!(topics::object_pose("object_3"), "/objects/object_3/pose");
/// assert_eq!(topics::object_of("/objects/object_3/pose"), Some("object_3"));
/// assert_eq!(topics::object_of("/robot_3/pose"), None);
/// ```
pub fn object_pose(object: &str) -> String {
    OBJECT_POSE.name.replace('*', object)
}

/// The object whose topic has this name, if it is an [`OBJECT_POSE`].
pub fn object_of(name: &str) -> Option<&str> {
    let (before, behind) = OBJECT_POSE.name.split_once('*')?;
    let object = name.strip_prefix(before)?.strip_suffix(behind)?;
    (!object.is_empty() && !object.contains('/')).then_some(object)
}

/// The raw range reading behind a detection, when the driver has it.
pub const RANGE: Topic = topic::<sensor_msgs::Range>("range", Qos::best_effort(10))
    .published_by(&[Robot])
    .subscribed_by(&[Runner]);
/// What a tracked real robot would see of virtual ones, from the simulator, and what a robot of the simulator
/// senses. The newest counts: behind a link that loses packets a reliable topic would hold it back until
/// the lost ones were sent again.
pub const VIRTUAL_DETECTION: Topic =
    topic::<std_msgs::Bool>("virtual_detection", Qos::best_effort(10))
        .published_by(&[Simulator])
        .subscribed_by(&[Robot, Controller]);
/// What the gate of a robot lets through to a base driver of another package, which has a watchdog of
/// its own: only the newest counts.
pub const HARDWARE_CMD_VEL: Topic =
    topic::<geometry_msgs::TwistStamped>("hardware/cmd_vel", Qos::reliable(1))
        .published_by(&[Robot])
        .subscribed_by(&[BaseDriver, Simulator]);
/// The same for base drivers that take no stamp; the same name, and never both.
pub const HARDWARE_CMD_VEL_UNSTAMPED: Topic =
    topic::<geometry_msgs::Twist>("hardware/cmd_vel", Qos::reliable(1))
        .published_by(&[Robot])
        .subscribed_by(&[BaseDriver, Simulator]);
/// The readings of another driver's distance sensor; best effort also receives reliable publishers.
pub const HARDWARE_RANGE: Topic =
    topic::<sensor_msgs::Range>("hardware/range", Qos::best_effort(10))
        .published_by(&[SensorDriver])
        .subscribed_by(&[Robot]);
/// What another driver's sensor decides itself.
pub const HARDWARE_DETECTION: Topic =
    topic::<std_msgs::Bool>("hardware/detection", Qos::best_effort(10))
        .published_by(&[SensorDriver])
        .subscribed_by(&[Robot]);
/// The readings of another driver's laser scanner.
pub const HARDWARE_SCAN: Topic =
    topic::<sensor_msgs::LaserScan>("hardware/scan", Qos::best_effort(10))
        .published_by(&[SensorDriver])
        .subscribed_by(&[Robot]);
/// The status of the robot.
pub const STATUS: Topic = topic::<rsrs::RobotStatus>("status", Qos::best_effort(1))
    .published_by(&[Robot, Controller, Simulator])
    .subscribed_by(&[Controller, Runner, Stop]);
/// The status of the controller: robot and runner take its parameter digest from here.
pub const CONTROLLER_STATUS: Topic =
    topic::<rsrs::RobotStatus>("controller/status", Qos::best_effort(1))
        .published_by(&[Controller])
        .subscribed_by(&[Robot, Simulator, Runner]);
/// The status of the simulator: armed with a placed world, moving, stopped after its last step,
/// or in fault; the digest names the placed world, and the epoch numbers it.
pub const SIMULATOR_STATUS: Topic =
    topic::<rsrs::RobotStatus>("/simulator/status", Qos::best_effort(1))
        .published_by(&[Simulator])
        .subscribed_by(&[Runner]);
/// The runner's permission to move; an old one is worthless, so it is never sent again. A large fleet
/// takes several at a time, of which none is to push another out.
pub const LEASE: Topic = topic::<rsrs::RunLease>("/swarm/lease", Qos::best_effort(64))
    .published_by(&[Runner])
    .subscribed_by(&[Robot, Controller, Simulator, Runner]);
/// Stops every robot: each publisher by itself locks them, and locks by its silence once it was
/// received in a run.
pub const E_STOP: Topic = topic::<std_msgs::Bool>("/swarm/e_stop", Qos::reliable(10))
    .published_by(&[Stop])
    .subscribed_by(NodeKind::ALL);
/// Ends the locks of the publishers that it names.
pub const E_STOP_RELEASE: Topic =
    topic::<rsrs::EStopLocks>("/swarm/e_stop_release", Qos::reliable(10))
        .published_by(&[Stop])
        .subscribed_by(NodeKind::ALL);
/// Which publishers have locked the robots of a process; transient local, for robots that start again.
pub const E_STOP_LOCKS: Topic = topic::<rsrs::EStopLocks>("/swarm/e_stop_locks", Qos::latched(1))
    .published_by(&[Robot, Controller, Simulator])
    .subscribed_by(&[Robot, Controller, Simulator, Stop]);
/// The record of the run, as the bag's attachment has it: JSON. Latched, and a message because
/// converters of bags keep nothing else.
pub const EXPERIMENT: Topic = topic::<std_msgs::String>("/swarm/experiment", Qos::latched(1))
    .published_by(&[Runner])
    .subscribed_by(&[Viewer]);
/// How the run ended, as the bag's metadata has it: JSON.
pub const ENDING: Topic = topic::<std_msgs::String>("/swarm/ending", Qos::latched(1))
    .published_by(&[Runner])
    .subscribed_by(&[Viewer]);
/// The fingerprint of the simulated world, after each lockstep step.
pub const WORLD_DIGEST: Topic =
    topic::<rsrs::WorldDigest>("/swarm/world_digest", Qos::reliable(LOCKSTEP_DEPTH))
        .published_by(&[Simulator])
        .subscribed_by(&[Runner]);
/// The recorder's acknowledgement in lockstep.
pub const RECORDED: Topic = topic::<rsrs::Recorded>("/swarm/recorded", Qos::reliable(10))
    .published_by(&[Runner])
    .subscribed_by(&[Simulator]);
/// Simulated time, before the detections of each lockstep step.
pub const CLOCK: Topic = topic::<rosgraph_msgs::Clock>("/clock", Qos::reliable(LOCKSTEP_DEPTH))
    .published_by(&[Simulator])
    .subscribed_by(&[Controller, Runner]);
/// The health of parts.
pub const DIAGNOSTICS: Topic =
    topic::<diagnostic_msgs::DiagnosticArray>("/diagnostics", Qos::reliable(10))
        .published_by(&[Robot, Simulator])
        .subscribed_by(&[Runner, Viewer]);
/// The transform tree.
pub const TF: Topic = topic::<tf2_msgs::TFMessage>("/tf", Qos::reliable(100))
    .published_by(&[Tracker, Simulator])
    .subscribed_by(NodeKind::ALL);
/// Transforms that stay as they are.
pub const TF_STATIC: Topic = topic::<tf2_msgs::TFMessage>("/tf_static", Qos::latched(100))
    .published_by(&[Tracker, Simulator])
    .subscribed_by(NodeKind::ALL);
/// What the simulator has to show: bodies, sensors, the ring, objects, goals and the judge's verdict.
pub const MARKERS: Topic =
    topic::<visualization_msgs::MarkerArray>("/swarm/markers", Qos::reliable(10))
        .published_by(&[Simulator])
        .subscribed_by(&[Viewer]);
/// Changes of parameters.
pub const PARAMETER_EVENTS: Topic =
    topic::<rcl_interfaces::ParameterEvent>("/parameter_events", Qos::reliable(1000))
        .published_by(NodeKind::ALL)
        .subscribed_by(NodeKind::ALL);
/// Log lines.
pub const ROSOUT: Topic = topic::<rcl_interfaces::Log>("/rosout", Qos::latched(1000))
    .published_by(NodeKind::ALL)
    .subscribed_by(&[Runner]);

/// All of them.
pub const ALL: &[Topic] = &[
    DETECTION,
    FURTHER_DETECTION,
    CMD_VEL,
    CMD_VEL_UNSTAMPED,
    ODOM,
    POSE,
    NAMED_POSES,
    POSE_ARRAY,
    OBJECT_POSE,
    RANGE,
    VIRTUAL_DETECTION,
    HARDWARE_CMD_VEL,
    HARDWARE_CMD_VEL_UNSTAMPED,
    HARDWARE_RANGE,
    HARDWARE_SCAN,
    HARDWARE_DETECTION,
    STATUS,
    CONTROLLER_STATUS,
    SIMULATOR_STATUS,
    LEASE,
    E_STOP,
    E_STOP_RELEASE,
    E_STOP_LOCKS,
    EXPERIMENT,
    ENDING,
    WORLD_DIGEST,
    RECORDED,
    CLOCK,
    DIAGNOSTICS,
    TF,
    TF_STATIC,
    MARKERS,
    PARAMETER_EVENTS,
    ROSOUT,
];

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn what_cannot_be_a_namespace_is_no_robot() {
        assert!(["robot_3", "R2D2", "_a", "lab/robot_3"].into_iter().all(is_namespace));
        let odd = ["", "no robot", "/a", "a//b", "a/", "3", "a__b", "é", "my-robot", "a\u{1b}[1A"];
        assert!(!odd.into_iter().any(is_namespace));
    }

    #[test]
    fn only_the_two_shapes_of_a_command_and_of_poses_share_a_name() {
        let mut types_of_name: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
        for topic in ALL {
            types_of_name.entry(topic.name).or_default().push(topic.type_name);
        }

        types_of_name.retain(|_, types| types.len() > 1);

        let expected = vec!["geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/Twist"];
        let of_poses = vec![NAMED_POSES.type_name, POSE_ARRAY.type_name];
        let expected =
            [("cmd_vel", expected.clone()), ("hardware/cmd_vel", expected), ("/poses", of_poses)];
        assert_eq!(types_of_name, BTreeMap::from(expected));
    }

    #[test]
    fn each_topic_of_a_robot_is_that_robots_in_any_namespace_and_no_other_topic() {
        for robot in ["robot_3", "lab/robot_3", "a/b/c"] {
            for topic in ALL.iter().filter(|topic| !topic.is_absolute()) {
                let name = topic.for_robot(robot);

                let found = ALL.iter().filter(|other| other.robot_of(&name).is_some());

                assert_eq!(topic.robot_of(&name), Some(robot), "{name}");
                assert!(found.clone().all(|other| other.name == topic.name), "{name}");
            }
        }
        assert_eq!(STATUS.robot_of("/robot_3/controller/status"), None);
        let of_nobody = ["/status", "/simulator/status", "/swarm/lease", "status", "/x/modem_odom"];
        for name in of_nobody {
            assert!(ALL.iter().all(|topic| topic.robot_of(name).is_none()), "{name}");
        }
    }

    #[test]
    fn every_topic_has_publishers_and_subscribers() {
        for topic in ALL {
            assert!(
                !topic.publishers.is_empty() && !topic.subscribers.is_empty(),
                "{}",
                topic.name
            );
        }
    }

    #[test]
    fn every_topic_has_a_schema_so_that_a_bag_can_hold_it() {
        for topic in ALL {
            assert!(crate::schema::schema_text(topic.type_name).is_some(), "{}", topic.name);
            assert!(crate::schema::type_hash(topic.type_name).is_some(), "{}", topic.name);
        }
    }
}
