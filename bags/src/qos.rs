//! Quality of service in the words of rosbag2.

use rsrs_msgs::topics::{Durability, Qos, Reliability};

/// Writes a quality of service as the YAML that rosbag2 keeps with a channel.
///
/// With numbers instead of words, because Humble and Iron read only those and later versions read
/// both. History is "keep last", liveliness automatic, deadlines and lifespans infinite.
///
/// # Source
///
/// `rosbag2_storage/src/rosbag2_storage/qos.cpp`, up to metadata version 8.
pub fn offered_qos_profiles(qos: Qos) -> String {
    let reliability = match qos.reliability {
        Reliability::Reliable => 1,
        Reliability::BestEffort => 2,
    };
    let durability = match qos.durability {
        Durability::TransientLocal => 1,
        Durability::Volatile => 2,
    };
    let depth = qos.depth;
    format!(
        "\
- history: 1
  depth: {depth}
  reliability: {reliability}
  durability: {durability}
  deadline:
    sec: 9223372036
    nsec: 854775807
  lifespan:
    sec: 9223372036
    nsec: 854775807
  liveliness: 1
  liveliness_lease_duration:
    sec: 9223372036
    nsec: 854775807
  avoid_ros_namespace_conventions: false
"
    )
}
