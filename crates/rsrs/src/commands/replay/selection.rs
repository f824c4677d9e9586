//! Which topics of a bag are published, and how.

use rsrs_bags::{Bag, OfferedQos};
use rsrs_core::document::nearest;
use rsrs_msgs::RosMessage;
use rsrs_msgs::geometry_msgs::{Twist, TwistStamped};
use rsrs_msgs::rsrs::{Recorded, RobotStatus, RunLease};
use rsrs_msgs::topics::{self, Durability, Qos, Reliability};

use crate::failure::with_help;

/// One topic to publish.
#[derive(Clone, Debug)]
pub struct Selected {
    /// Its full name.
    pub name: String,
    /// Its type.
    pub type_name: String,
    /// The quality of service that was recorded.
    pub qos: Qos,
}

/// What is published of a bag, and what is not.
#[derive(Clone, Debug)]
pub struct Selection {
    /// The topics to publish.
    pub topics: Vec<Selected>,
    /// Topics that are left out, because they move robots or permit it.
    pub guarded: Vec<String>,
    /// Topics that cannot be published, because the bag does not hold them as ROS 2 sends them.
    pub foreign: Vec<String>,
}

/// Types of messages that move a robot, permit it to move, or stand for a robot that is alive.
const GUARDED: [&str; 5] = [
    Twist::TYPE_NAME,
    TwistStamped::TYPE_NAME,
    RunLease::TYPE_NAME,
    RobotStatus::TYPE_NAME,
    Recorded::TYPE_NAME,
];

/// Depth where the recording does not say one.
const DEPTH: u32 = 100;

/// Chooses topics of a bag.
///
/// # Arguments
///
/// * `wanted` — full names; none takes all that are not guarded.
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
        let is_guarded =
            GUARDED.contains(&topic.type_name.as_str()) || topic.name == topics::E_STOP.name;
        if topic.type_name.is_empty() || topic.encoding != "cdr" {
            selection.foreign.push(topic.name.clone());
        } else if is_guarded && !is_named {
            selection.guarded.push(topic.name.clone());
        } else {
            let qos = summary.offered_qos.first().map_or(Qos::reliable(DEPTH), quality);
            let (name, type_name) = (topic.name.clone(), topic.type_name.clone());
            selection.topics.push(Selected { name, type_name, qos });
        }
    }
    if selection.topics.is_empty() {
        return Err(with_help(
            format!("{}: nothing is left to publish", bag.path().display()),
            "name topics that move robots, or permit it, with `--topics` if you mean them",
        ));
    }
    Ok(selection)
}

/// The recorded quality of service; what the recorder could not tell is as ROS 2 has it by default.
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
