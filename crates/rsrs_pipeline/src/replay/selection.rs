//! Which topics of a bag are published, and how.

use rsrs_bags::{Bag, OfferedQos};
use rsrs_core::document::nearest;
use rsrs_msgs::RosMessage;
use rsrs_msgs::geometry_msgs::{Twist, TwistStamped};
use rsrs_msgs::rsrs::{Recorded, RobotStatus, RunLease};
use rsrs_msgs::topics::{self, Durability, Qos, Reliability};

use crate::error::with_help;

/// One topic to publish.
#[derive(Clone, Debug)]
pub struct Selected {
    /// Its full name.
    pub name: String,
    /// Its type.
    pub type_name: String,
    /// The quality of service that was recorded.
    pub qos: Qos,
    /// Whether it was asked for by name.
    pub is_named: bool,
}

/// What is published of a bag, and what is not.
#[derive(Clone, Debug)]
pub struct Selection {
    /// The topics to publish.
    pub topics: Vec<Selected>,
    /// Topics that are left out, because robots are steered by them.
    pub guarded: Vec<String>,
    /// Topics that cannot be published, because the bag does not hold them as ROS 2 sends them.
    pub foreign: Vec<String>,
}

/// Types of messages that steer a robot, permit it to move, or stand for a robot that is alive.
const GUARDED: [&str; 5] = [
    Twist::TYPE_NAME,
    TwistStamped::TYPE_NAME,
    RunLease::TYPE_NAME,
    RobotStatus::TYPE_NAME,
    Recorded::TYPE_NAME,
];

/// Whether robots are steered by a topic: a controller answers every detection with a command, a base
/// driver every command, and the simulator of a mixed fleet follows poses. What a runner publishes
/// about its run is taken for that of a run that goes on.
fn steers(name: &str, type_name: &str) -> bool {
    let names = [topics::DETECTION, topics::VIRTUAL_DETECTION, topics::POSE];
    let of_swarm = [
        topics::E_STOP,
        topics::E_STOP_RELEASE,
        topics::E_STOP_LOCKS,
        topics::EXPERIMENT,
        topics::ENDING,
    ];
    GUARDED.contains(&type_name)
        || of_swarm.iter().any(|topic| name == topic.name)
        || name.contains("/hardware/")
        || topics::further_reading(name).is_some()
        || names.iter().any(|topic| name.rsplit('/').next() == Some(topic.name))
}

/// Depth where the recording has none.
const DEPTH: u32 = 100;

/// Chooses topics of a bag by their full names; without any, all that are not guarded.
///
/// # Errors
///
/// If a wanted topic is not in the bag, or cannot be published, or nothing is left.
pub fn select(bag: &Bag, wanted: &[String]) -> anyhow::Result<Selection> {
    let infos = bag.topics();
    let names = || infos.iter().map(|topic| topic.name.as_str());
    for name in wanted {
        if !names().any(|known| known == name) {
            let meant = nearest(name, names()).unwrap_or("one of those in `rsrs bag info`");
            return Err(with_help(
                format!("{}: has no topic {name}", bag.path().display()),
                format!("did you mean {meant}?"),
            ));
        }
    }
    let summaries = bag.info().topics;
    let mut selection = Selection { topics: Vec::new(), guarded: Vec::new(), foreign: Vec::new() };
    for (topic, summary) in infos.iter().zip(&summaries) {
        let is_named = wanted.contains(&topic.name);
        if !(is_named || wanted.is_empty()) {
            continue;
        }
        let is_guarded = steers(&topic.name, &topic.type_name);
        if topic.type_name.is_empty() || topic.encoding != "cdr" {
            selection.foreign.push(topic.name.clone());
        } else if is_guarded && !is_named {
            selection.guarded.push(topic.name.clone());
        } else {
            let qos = summary.offered_qos.first().map_or(Qos::reliable(DEPTH), quality);
            let (name, type_name) = (topic.name.clone(), topic.type_name.clone());
            selection.topics.push(Selected { name, type_name, qos, is_named });
        }
    }
    if selection.topics.is_empty() {
        return Err(with_help(
            format!("{}: nothing is left to publish", bag.path().display()),
            "name topics by which robots are steered with `--topics` if you mean them",
        ));
    }
    Ok(selection)
}

/// The recorded quality of service; what the recorder could not determine is as ROS 2 has it by
/// default.
fn quality(offered: &OfferedQos) -> Qos {
    let depth = u32::try_from(offered.depth).unwrap_or(u32::MAX);
    Qos {
        reliability: match offered.reliability {
            "best_effort" => Reliability::BestEffort,
            _ => Reliability::Reliable,
        },
        durability: match offered.durability {
            "transient_local" => Durability::TransientLocal,
            _ => Durability::Volatile,
        },
        depth: if offered.history == "keep_all" || depth == 0 { DEPTH } else { depth },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whatever_steers_a_robot_is_guarded_and_what_shows_it_is_not() {
        let bool_type = topics::DETECTION.type_name;
        for (name, type_name) in [
            ("/robot_1/detection", bool_type),
            ("/robot_1/virtual_detection", bool_type),
            ("/robot_1/detection/wall", bool_type),
            ("/robot_1/hardware/range", topics::HARDWARE_RANGE.type_name),
            ("/robot_1/hardware/cmd_vel", Twist::TYPE_NAME),
            ("/robot_1/pose", topics::POSE.type_name),
            ("/base/velocity", TwistStamped::TYPE_NAME),
            ("/swarm/lease", RunLease::TYPE_NAME),
            ("/swarm/e_stop", bool_type),
            (topics::E_STOP_RELEASE.name, topics::E_STOP_RELEASE.type_name),
            (topics::E_STOP_LOCKS.name, topics::E_STOP_LOCKS.type_name),
            (topics::EXPERIMENT.name, topics::EXPERIMENT.type_name),
            (topics::ENDING.name, topics::ENDING.type_name),
        ] {
            assert!(steers(name, type_name), "{name}");
        }
        for (name, type_name) in [
            ("/robot_1/odom", topics::ODOM.type_name),
            ("/robot_1/range", topics::RANGE.type_name),
            ("/tf", topics::TF.type_name),
            ("/camera/pose_image", "sensor_msgs/msg/Image"),
        ] {
            assert!(!steers(name, type_name), "{name}");
        }
    }
}
