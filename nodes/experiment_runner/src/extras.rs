//! Topics that an experiment names to be recorded: their types show when they have a publisher.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rsrs_bags::definitions::{Definition, Definitions};
use rsrs_core::help::Help;
use rsrs_msgs::topics::{self, Durability, Qos, Reliability};
use rsrs_ros::session::{Endpoint, EndpointKind, Session, SessionError, Subscription};

use crate::plan::Recording;
use crate::recorded_topics::{LEAST_DEPTH, Queue, RecordedTopic, Role};

/// Topics that are looked for, and those that are received.
pub struct Extras {
    /// Those that are not received yet, each with the reason.
    waiting: BTreeMap<String, String>,
    definitions: Definitions,
    /// Types that were looked for; folders are not searched again for them.
    known: BTreeMap<String, Result<Option<Arc<Definition>>, String>>,
    queue: Queue,
    /// In the order of their indices in the recorded topics, of which they are the last ones.
    /// They end with this.
    subscriptions: Vec<Subscription>,
}

impl Extras {
    /// Topics that were not looked for yet. What is received in every run is left out.
    pub fn new(recording: &Recording, recorded_topics: &[RecordedTopic], queue: Queue) -> Self {
        let own = [topics::EXPERIMENT.name, topics::ENDING.name];
        let is_new = |name: &&String| {
            !recorded_topics.iter().any(|recorded_topic| recorded_topic.name == **name)
                && !own.contains(&name.as_str())
        };
        let waiting = recording.topics.iter().filter(is_new);
        Self {
            waiting: waiting.map(|name| (name.clone(), NOBODY.to_owned())).collect(),
            definitions: recording.definitions.clone(),
            known: BTreeMap::new(),
            queue,
            subscriptions: Vec::new(),
        }
    }

    /// Topics that cannot be recorded now, and why.
    pub fn unrecordable(&self) -> BTreeMap<String, String> {
        self.waiting.clone()
    }

    /// Subscribes every topic that has a publisher by now, and whose type is defined.
    pub fn look(
        &mut self,
        session: &Session,
        recorded_topics: &mut Vec<RecordedTopic>,
    ) -> Result<(), SessionError> {
        if self.waiting.is_empty() {
            return Ok(());
        }
        let mut writers = session.endpoints();
        writers.retain(|end| end.kind == EndpointKind::Writer);
        for name in self.waiting.keys().cloned().collect::<Vec<_>>() {
            let of_topic: Vec<&Endpoint> = writers.iter().filter(|end| end.topic == name).collect();
            match self.recorded_topic(&name, &of_topic) {
                Ok(recorded_topic) => {
                    self.subscriptions.push(self.queue.listen(
                        session,
                        recorded_topics.len(),
                        &recorded_topic,
                    )?);
                    recorded_topics.push(recorded_topic);
                    self.waiting.remove(&name);
                }
                Err(reason) => {
                    self.waiting.insert(name, reason);
                }
            }
        }
        Ok(())
    }

    /// What is to be received of a topic, or why it is not.
    fn recorded_topic(
        &mut self,
        name: &str,
        writers: &[&Endpoint],
    ) -> Result<RecordedTopic, String> {
        let types: BTreeSet<&str> = writers.iter().map(|end| end.type_name.as_str()).collect();
        let type_name = match types.iter().copied().collect::<Vec<_>>()[..] {
            [] => return Err(NOBODY.to_owned()),
            [one] => one,
            _ => {
                let types: Vec<&str> = types.into_iter().collect();
                return Err(format!("published as {}, expected one type", types.join(" and ")));
            }
        };
        let definition = self.definition(type_name)?;
        let qos = offered(writers);
        // What was sent before the bag is open comes at once, and only then.
        let role = match qos.durability {
            Durability::TransientLocal => Role::Preparation,
            Durability::Volatile => Role::Other,
        };
        let mut recorded_topic = RecordedTopic::described(name.to_owned(), type_name, qos, role);
        recorded_topic.definition = definition;
        Ok(recorded_topic)
    }

    /// The definition of a type; `None` for those that are compiled in.
    fn definition(&mut self, type_name: &str) -> Result<Option<Arc<Definition>>, String> {
        if let Some(known) = self.known.get(type_name) {
            return known.clone();
        }
        let found = if Definition::of_known_type(type_name).is_some() {
            Ok(None)
        } else {
            self.definitions.find(type_name).map(|found| Some(Arc::new(found))).map_err(|error| {
                let error = error.text_with_help();
                format!("its type {type_name} is not defined: {error}, in `record.definitions`")
            })
        };
        self.known.insert(type_name.to_owned(), found.clone());
        found
    }
}

const NOBODY: &str = "it is to be recorded, and it has no publisher";

/// What all publishers of a topic offer. Discovery does not carry their depth.
fn offered(writers: &[&Endpoint]) -> Qos {
    let all = |has: fn(&Qos) -> bool| writers.iter().all(|end| has(&end.qos));
    let is_reliable = all(|qos| qos.reliability == Reliability::Reliable);
    let is_kept = all(|qos| qos.durability == Durability::TransientLocal);
    Qos {
        reliability: if is_reliable { Reliability::Reliable } else { Reliability::BestEffort },
        durability: if is_kept { Durability::TransientLocal } else { Durability::Volatile },
        depth: LEAST_DEPTH,
    }
}
