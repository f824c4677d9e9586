//! Who publishes and subscribes what: the discovery database, in the words of ROS 2.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::time::Instant;

use rsrs_msgs::topics::Qos;
use rustdds::DomainParticipant;

use super::POLL;
use super::qos;

/// Bytes of a GUID that name the participant; the first two name the vendor.
pub(super) type Prefix = [u8; 12];

/// The participant in the identity of one of its endpoints.
pub(super) fn prefix(guid: [u8; 16]) -> Prefix {
    *guid.first_chunk().expect("a GUID is longer than its prefix")
}

/// Which end of a topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum EndpointKind {
    /// It subscribes.
    Reader,
    /// It publishes.
    Writer,
}

impl fmt::Display for EndpointKind {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Reader => "subscriber",
            Self::Writer => "publisher",
        })
    }
}

/// A publisher or subscriber in the network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Endpoint {
    /// The topic, absolute, such as `/robot_3/detection`.
    pub topic: String,
    /// The full name of its type, such as `std_msgs/msg/Bool`.
    pub type_name: String,
    /// Which end.
    pub kind: EndpointKind,
    /// Its quality of service; discovery does not carry the depth, which is therefore 0.
    pub qos: Qos,
    /// Its identity in DDS; the same as [`Received::writer`](super::Received::writer).
    pub guid: [u8; 16],
    /// Full name of its node, if it was announced.
    pub node: Option<String>,
}

/// All publishers and subscribers of topics; those of services are left out. `owners` has the node of
/// each endpoint, as participants announce it.
pub(super) fn all(
    participant: &DomainParticipant,
    owners: &BTreeMap<[u8; 16], String>,
) -> Vec<Endpoint> {
    let readers = participant.discovered_readers().into_iter().map(|reader| {
        let data = reader.subscription_topic_data;
        let names = (data.topic_name().clone(), data.type_name().clone());
        (EndpointKind::Reader, names, data.qos(), data.key().to_bytes())
    });
    let writers = participant.discovered_writers().into_iter().map(|writer| {
        let data = writer.publication_topic_data;
        let names = (data.topic_name.clone(), data.type_name.clone());
        (EndpointKind::Writer, names, data.qos(), data.key.to_bytes())
    });
    let mut found: Vec<Endpoint> = readers
        .chain(writers)
        .filter_map(|(kind, (topic, type_name), policies, guid)| {
            Some(Endpoint {
                topic: ros_topic(&topic)?.to_owned(),
                type_name: ros_type(&type_name),
                kind,
                qos: qos::discovered(&policies),
                guid,
                node: owners.get(&guid).cloned(),
            })
        })
        .collect();
    found.sort_by(|a, b| (&a.topic, a.kind, a.guid).cmp(&(&b.topic, b.kind, b.guid)));
    found
}

/// How many readers or writers a topic has.
pub(super) fn count(participant: &DomainParticipant, kind: EndpointKind, topic: &str) -> usize {
    let is_it = |name: &str| ros_topic(name) == Some(topic);
    match kind {
        EndpointKind::Reader => participant
            .discovered_readers()
            .iter()
            .filter(|reader| is_it(reader.subscription_topic_data.topic_name()))
            .count(),
        EndpointKind::Writer => participant
            .discovered_writers()
            .iter()
            .filter(|writer| is_it(&writer.publication_topic_data.topic_name))
            .count(),
    }
}

/// Participants that have at least one endpoint; those that have gone have none.
pub(super) fn participants(participant: &DomainParticipant) -> BTreeSet<Prefix> {
    let writers = participant.discovered_writers().into_iter();
    writers.map(|writer| prefix(writer.publication_topic_data.key.to_bytes())).collect()
}

/// Who is on which DDS topic, as of a moment ago: the discovery database copies all of itself for
/// every question, which hundreds of waiting requests cannot afford.
#[derive(Debug, Default)]
pub(super) struct Index {
    asked: Option<Instant>,
    vendors: BTreeMap<String, [u8; 2]>,
    readers: BTreeSet<String>,
}

impl Index {
    /// Asks the discovery database again, if that is some time ago.
    pub(super) fn refresh(&mut self, participant: &DomainParticipant) -> &Self {
        if self.asked.is_some_and(|at| at.elapsed() < POLL) {
            return self;
        }
        let vendor = |guid: [u8; 16]| [guid[0], guid[1]];
        let writers = participant.discovered_writers().into_iter().map(|writer| {
            let data = writer.publication_topic_data;
            (data.topic_name, vendor(data.key.to_bytes()))
        });
        let readers = participant.discovered_readers().into_iter();
        self.vendors = writers.collect();
        self.readers =
            readers.map(|reader| reader.subscription_topic_data.topic_name().clone()).collect();
        self.asked = Some(Instant::now());
        self
    }

    /// The vendor of a writer on a DDS topic.
    pub(super) fn vendor_of_writer(&self, dds_topic: &str) -> Option<[u8; 2]> {
        self.vendors.get(dds_topic).copied()
    }

    /// Whether a DDS topic has a reader.
    pub(super) fn has_reader(&self, dds_topic: &str) -> bool {
        self.readers.contains(dds_topic)
    }
}

/// `rt/a/b` is topic `/a/b`; other prefixes are services.
fn ros_topic(dds_topic: &str) -> Option<&str> {
    dds_topic.strip_prefix("rt").filter(|rest| rest.starts_with('/'))
}

/// `std_msgs::msg::dds_::Bool_` is type `std_msgs/msg/Bool`; other types stay as they are.
fn ros_type(dds_type: &str) -> String {
    match dds_type.split_once("::dds_::") {
        Some((package, name)) => {
            let name = name.strip_suffix('_').unwrap_or(name);
            format!("{}/{name}", package.replace("::", "/"))
        }
        None => dds_type.to_owned(),
    }
}

/// The type of a topic in DDS, the other way round.
pub(super) fn dds_type(ros_type: &str) -> Option<String> {
    let mut parts = ros_type.split('/');
    let (package, kind, name) = (parts.next()?, parts.next()?, parts.next()?);
    let is_complete = parts.next().is_none() && !package.is_empty() && !name.is_empty();
    is_complete.then(|| format!("{package}::{kind}::dds_::{name}_"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_topics_are_distinguished_from_those_of_services() {
        assert_eq!(ros_topic("rt/robot_3/detection"), Some("/robot_3/detection"));
        assert_eq!(ros_topic("rq/robot_3/controller/get_parametersRequest"), None);
        assert_eq!(ros_topic("rtfm"), None);
        assert_eq!(ros_topic("ros_discovery_info"), None);
    }

    #[test]
    fn names_of_types_go_both_ways() {
        let dds = "geometry_msgs::msg::dds_::TwistStamped_";

        assert_eq!(ros_type(dds), "geometry_msgs/msg/TwistStamped");
        assert_eq!(dds_type("geometry_msgs/msg/TwistStamped").as_deref(), Some(dds));
        assert_eq!(ros_type("HelloWorld"), "HelloWorld");
        assert_eq!(dds_type("geometry_msgs/TwistStamped"), None);
    }
}
