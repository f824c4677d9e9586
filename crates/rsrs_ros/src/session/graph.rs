//! Which node an endpoint belongs to, as participants announce it.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;

use rsrs_msgs::topics::Qos;
use rsrs_msgs::{RosMessage, cdr};
use serde::{Deserialize, Serialize};

use super::endpoint::{Prefix, prefix};
use super::lock;

/// The DDS topic on which participants announce their nodes; it has no ROS name.
pub(super) const TOPIC: &str = "ros_discovery_info";
/// Its type in DDS.
pub(super) const DDS_TYPE: &str = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_";
/// As in ROS 2, but deep: each participant's last word counts, and all may come at once.
pub(super) const QOS: Qos = Qos::latched(1000);

/// `rmw_dds_common/msg/ParticipantEntitiesInfo` of ROS 2 Iron and later: GIDs of 16 bytes.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct ParticipantEntitiesInfo {
    gid: [u8; 16],
    nodes: Vec<NodeEntitiesInfo>,
}

#[derive(Clone, Debug, Serialize, Deserialize)]
struct NodeEntitiesInfo {
    namespace: String,
    name: String,
    readers: Vec<[u8; 16]>,
    writers: Vec<[u8; 16]>,
}

impl RosMessage for ParticipantEntitiesInfo {
    const TYPE_NAME: &'static str = "rmw_dds_common/msg/ParticipantEntitiesInfo";
}

impl NodeEntitiesInfo {
    fn full_name(&self) -> String {
        format!("{}/{}", self.namespace.trim_end_matches('/'), self.name)
    }
}

/// Participants whose words are kept, at most: each may have as many kilobytes as it likes.
const MOST_PARTICIPANTS: usize = 2_000;

/// The last word of each participant.
#[derive(Debug, Default)]
pub(super) struct Graph {
    updates: Mutex<BTreeMap<Prefix, GraphUpdate>>,
}

/// A participant announces all of its nodes again with every endpoint that it makes: one with
/// hundreds of nodes publishes thousands of messages of many kilobytes each, of which the last one
/// counts. They are therefore decoded on request.
#[derive(Debug)]
enum GraphUpdate {
    /// As bytes with encapsulation.
    Received(Vec<u8>),
    Understood(Vec<NodeEntitiesInfo>),
}

impl GraphUpdate {
    /// The nodes that it names; none if it cannot be understood.
    ///
    /// A participant of ROS 2 Humble writes longer GIDs, is not understood and has no names here;
    /// its data flows all the same.
    fn nodes(&mut self) -> &[NodeEntitiesInfo] {
        if let Self::Received(sample) = self {
            let info = cdr::decode::<ParticipantEntitiesInfo>(sample);
            let not_understood = |error| {
                log::debug!("names of nodes are not understood: {error}");
                Vec::new()
            };
            *self = Self::Understood(info.map_or_else(not_understood, |info| info.nodes));
        }
        match self {
            Self::Understood(nodes) => nodes,
            Self::Received(_) => unreachable!("it has just been understood"),
        }
    }
}

impl Graph {
    /// Takes the word of a participant, as bytes with encapsulation. The `writer` is who published
    /// it: what it names as its own GID is anybody's.
    ///
    /// When there is no room, participants that are not there any more are forgotten.
    pub(super) fn update(
        &self,
        writer: Prefix,
        sample: Vec<u8>,
        participants: impl FnOnce() -> BTreeSet<Prefix>,
    ) {
        let mut updates = lock(&self.updates);
        if updates.len() >= MOST_PARTICIPANTS && !updates.contains_key(&writer) {
            let participants = participants();
            updates.retain(|participant, _| participants.contains(participant));
        }
        if updates.len() < MOST_PARTICIPANTS || updates.contains_key(&writer) {
            updates.insert(writer, GraphUpdate::Received(sample));
        }
    }

    /// Full names of the nodes of these participants.
    pub(super) fn node_names(&self, participants: &BTreeSet<Prefix>) -> BTreeSet<String> {
        lock(&self.updates)
            .iter_mut()
            .filter(|(participant, _)| participants.contains(*participant))
            .flat_map(|(_, word)| word.nodes().iter().map(NodeEntitiesInfo::full_name))
            .collect()
    }

    /// Full name of the node that has each endpoint; a participant names its own endpoints alone.
    pub(super) fn owners(&self) -> BTreeMap<[u8; 16], String> {
        let mut owners = BTreeMap::new();
        for (participant, word) in lock(&self.updates).iter_mut() {
            for node in word.nodes() {
                let name = node.full_name();
                let endpoints = node.readers.iter().chain(&node.writers);
                let own = endpoints.filter(|guid| prefix(**guid) == *participant);
                owners.extend(own.map(|guid| (*guid, name.clone())));
            }
        }
        owners
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn info(participant: u8, names: &[(&str, &str)]) -> Vec<u8> {
        let nodes = names.iter().map(|(namespace, name)| NodeEntitiesInfo {
            namespace: (*namespace).into(),
            name: (*name).into(),
            readers: vec![[participant; 16]],
            writers: Vec::new(),
        });
        cdr::encode(&ParticipantEntitiesInfo { gid: [participant; 16], nodes: nodes.collect() })
    }

    #[test]
    fn the_last_word_of_a_participant_counts() {
        let graph = Graph::default();

        graph.update([1; 12], info(1, &[("/", "a"), ("/robot_1", "b")]), BTreeSet::new);
        graph.update([1; 12], info(1, &[("/robot_1", "b")]), BTreeSet::new);
        graph.update([2; 12], info(2, &[("/", "c")]), BTreeSet::new);

        let both = BTreeSet::from([[1; 12], [2; 12]]);
        assert_eq!(graph.node_names(&both), BTreeSet::from(["/robot_1/b".into(), "/c".into()]));
        assert_eq!(graph.owners()[&[1; 16]], "/robot_1/b");
        let gone = BTreeSet::from([[3; 12]]);
        assert_eq!(graph.node_names(&gone), BTreeSet::new());
    }

    #[test]
    fn nobody_names_the_endpoints_of_another() {
        let graph = Graph::default();

        graph.update([1; 12], info(1, &[("/", "runner")]), BTreeSet::new);
        // In the name of the first, and of its endpoints.
        graph.update([2; 12], info(1, &[("/", "thief")]), BTreeSet::new);

        assert_eq!(graph.owners(), BTreeMap::from([([1; 16], "/runner".to_owned())]));
    }

    #[test]
    fn whoever_has_gone_makes_room_and_strangers_beyond_it_are_not_kept() {
        let graph = Graph::default();
        let writer = |number: usize| {
            let mut prefix = [0; 12];
            prefix[..8].copy_from_slice(&number.to_le_bytes());
            prefix
        };
        let is_kept = |number: usize| lock(&graph.updates).contains_key(&writer(number));
        // Whatever they say who they are.
        let word = || info(7, &[]);

        let all = || (0..MOST_PARTICIPANTS).map(writer);
        for number in 0..=MOST_PARTICIPANTS {
            graph.update(writer(number), word(), || all().collect());
        }
        assert!(!is_kept(MOST_PARTICIPANTS) && is_kept(0));
        graph.update(writer(MOST_PARTICIPANTS), word(), || all().skip(1).collect());

        assert!(is_kept(MOST_PARTICIPANTS) && !is_kept(0));
    }

    #[test]
    fn bytes_that_are_no_graph_change_nothing() {
        let graph = Graph::default();

        graph.update([7; 12], vec![0, 1, 0, 0, 7], BTreeSet::new);
        graph.update([7; 12], [&[0, 1, 0, 0][..], &[7; 17]].concat(), BTreeSet::new);

        assert!(graph.owners().is_empty());
    }
}
