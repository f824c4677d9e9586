//! Who publishes what only one node may, and was not there when the run began.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use super::AbortCause;
use crate::preflight::{Endpoint, Expected, Graph, Publishers};
use crate::timing::NODE_TIMEOUT;

/// The publishers that were there when all that the run needs was found.
#[derive(Clone, Debug, Default)]
pub(super) struct UnexpectedPublishers {
    known: BTreeSet<[u8; 16]>,
    /// Topics, and the nodes that published them: one of these that starts again is expected.
    nodes: BTreeSet<(String, String)>,
    /// By publisher: since when it is found to be none of these.
    since: BTreeMap<[u8; 16], Duration>,
}

impl UnexpectedPublishers {
    /// No publisher is unexpected yet.
    pub(super) fn none_of(graph: &Graph) -> Self {
        let node = |end: &Endpoint| Some((end.topic.clone(), end.node.clone()?));
        Self {
            known: graph.publishers.iter().map(|end| end.guid).collect(),
            nodes: graph.publishers.iter().filter_map(node).collect(),
            since: BTreeMap::new(),
        }
    }

    /// The first second publisher of a topic that has one.
    ///
    /// A node may be discovered after its publishers: one without a name gets a second to announce
    /// it.
    pub(super) fn find(
        &mut self,
        expected: &Expected,
        graph: &Graph,
        now: Duration,
    ) -> Option<AbortCause> {
        // Hundreds of robots have thousands of publishers, and the runner has leases to send.
        let mut by_topic: BTreeMap<&str, Vec<&Endpoint>> = BTreeMap::new();
        for end in &graph.publishers {
            by_topic.entry(&end.topic).or_default().push(end);
        }
        let is_here: BTreeSet<_> = graph.publishers.iter().map(|end| end.guid).collect();
        self.since.retain(|guid, _| is_here.contains(guid));
        let only_one = expected.topics.iter().filter(|topic| topic.publishers != Publishers::Any);
        for name in only_one.map(|topic| &topic.name).chain(&expected.steering) {
            let Some(here) = by_topic.get(name.as_str()).filter(|here| here.len() >= 2) else {
                continue;
            };
            for end in here.iter().filter(|end| !self.known.contains(&end.guid)) {
                let since = *self.since.entry(end.guid).or_insert(now);
                match &end.node {
                    Some(node) if self.nodes.contains(&(name.clone(), node.clone())) => {}
                    Some(node) => {
                        let (topic, node) = (name.clone(), node.clone());
                        return Some(AbortCause::SecondPublisher { topic, node });
                    }
                    None if now.saturating_sub(since) >= NODE_TIMEOUT => {
                        return Some(AbortCause::UnnamedPublisher { topic: name.clone() });
                    }
                    None => {}
                }
            }
        }
        None
    }
}
