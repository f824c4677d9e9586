//! Quality of service in the words of rosbag2.

use rsrs_msgs::topics::{Durability, Qos, Reliability};
use serde::{Deserialize, Serialize};

/// The key under which a channel keeps it.
pub const KEY: &str = "offered_qos_profiles";

/// The key under which a channel keeps the hash of its type.
pub const HASH_KEY: &str = "topic_type_hash";

/// What one publisher offered.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct OfferedQos {
    /// `keep_last`, `keep_all`, `unknown` or `system_default`.
    pub history: &'static str,
    /// Messages kept, dimensionless.
    pub depth: u64,
    /// `reliable`, `best_effort`, or what the recorder could not determine.
    pub reliability: &'static str,
    /// `volatile`, `transient_local`, or what the recorder could not determine.
    pub durability: &'static str,
}

/// Names by their numbers, as the middleware interface of ROS 2 counts them.
const HISTORY: [&str; 4] = ["system_default", "keep_last", "keep_all", "unknown"];
const RELIABILITY: [&str; 5] =
    ["system_default", "reliable", "best_effort", "unknown", "best_available"];
const DURABILITY: [&str; 5] =
    ["system_default", "transient_local", "volatile", "unknown", "best_available"];
const LIVELINESS: [&str; 6] = [
    "system_default",
    "automatic",
    "manual_by_node",
    "manual_by_topic",
    "unknown",
    "best_available",
];

/// A profile of any version of rosbag2.
#[derive(Serialize, Deserialize)]
struct Profile {
    history: QosValue,
    depth: u64,
    reliability: QosValue,
    durability: QosValue,
    #[serde(default)]
    deadline: Span,
    #[serde(default)]
    lifespan: Span,
    #[serde(default = "automatic")]
    liveliness: QosValue,
    #[serde(default)]
    liveliness_lease_duration: Span,
    #[serde(default)]
    avoid_ros_namespace_conventions: bool,
}

/// A number up to version 8, a word since.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum QosValue {
    Number(usize),
    Name(String),
}

#[derive(Clone, Copy, Serialize, Deserialize)]
struct Span {
    sec: u64,
    nsec: u64,
}

impl Default for Span {
    /// For ever, in the numbers that rosbag2 uses for it.
    fn default() -> Self {
        Self { sec: 9_223_372_036, nsec: 854_775_807 }
    }
}

fn automatic() -> QosValue {
    QosValue::Number(1)
}

impl QosValue {
    /// Its number among these names; what is not among them is unknown.
    fn number(&self, names: &[&'static str]) -> usize {
        let unknown = names.iter().position(|name| *name == "unknown").unwrap_or(0);
        match self {
            Self::Number(number) if *number < names.len() => *number,
            Self::Number(_) => unknown,
            Self::Name(found) => names.iter().position(|name| name == found).unwrap_or(unknown),
        }
    }
}

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
    in_yaml(&vec![Profile {
        history: QosValue::Number(1),
        depth: qos.depth.into(),
        reliability: QosValue::Number(reliability),
        durability: QosValue::Number(durability),
        deadline: Span::default(),
        lifespan: Span::default(),
        liveliness: automatic(),
        liveliness_lease_duration: Span::default(),
        avoid_ros_namespace_conventions: false,
    }])
}

/// The same quality of service with numbers; what does not read stays as it is.
pub fn in_numbers(yaml: &str) -> String {
    let Some(mut profiles) = profiles(yaml) else { return yaml.to_owned() };
    for profile in &mut profiles {
        for (value, names) in [
            (&mut profile.history, &HISTORY[..]),
            (&mut profile.reliability, &RELIABILITY),
            (&mut profile.durability, &DURABILITY),
            (&mut profile.liveliness, &LIVELINESS),
        ] {
            *value = QosValue::Number(value.number(names));
        }
    }
    in_yaml(&profiles)
}

/// What the publishers of a topic offered; empty if it is not in the bag.
pub fn offered(yaml: &str) -> Vec<OfferedQos> {
    let profiles = profiles(yaml).unwrap_or_default();
    let offered = profiles.iter().map(|profile| OfferedQos {
        history: HISTORY[profile.history.number(&HISTORY)],
        depth: profile.depth,
        reliability: RELIABILITY[profile.reliability.number(&RELIABILITY)],
        durability: DURABILITY[profile.durability.number(&DURABILITY)],
    });
    offered.collect()
}

fn profiles(yaml: &str) -> Option<Vec<Profile>> {
    if yaml.trim().is_empty() { None } else { serde_saphyr::from_str(yaml).ok() }
}

fn in_yaml(profiles: &Vec<Profile>) -> String {
    serde_saphyr::to_string(profiles).expect("words and numbers have a YAML form")
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORDS: &str = "\
- history: keep_last
  depth: 7
  reliability: best_effort
  durability: transient_local
  deadline: {sec: 1, nsec: 2}
  lifespan: {sec: 9223372036, nsec: 854775807}
  liveliness: automatic
  liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}
  avoid_ros_namespace_conventions: false
";

    #[test]
    fn words_and_numbers_mean_the_same() {
        let expected = OfferedQos {
            history: "keep_last",
            depth: 7,
            reliability: "best_effort",
            durability: "transient_local",
        };

        let numbers = in_numbers(WORDS);

        assert!(numbers.contains("reliability: 2\n  durability: 1\n  deadline:\n    sec: 1\n"));
        assert_eq!(offered(WORDS), std::slice::from_ref(&expected));
        assert_eq!(offered(&numbers), [expected]);
    }

    #[test]
    fn what_is_written_reads_back() {
        let qos = Qos::reliable(10);

        let read = offered(&offered_qos_profiles(qos));

        assert_eq!(
            (read[0].reliability, read[0].durability, read[0].depth),
            ("reliable", "volatile", 10)
        );
    }

    #[test]
    fn what_does_not_read_is_neither_changed_nor_made_up() {
        assert_eq!(in_numbers("no: profiles"), "no: profiles");
        assert_eq!(offered("no: profiles"), []);
        assert_eq!(offered(""), []);
    }
}
