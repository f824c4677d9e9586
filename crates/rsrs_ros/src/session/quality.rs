//! Best-effort publishers on topics that are subscribed reliably.
//!
//! In DDS a reliable subscriber does not match a best-effort publisher, which is what ROS 2's own
//! quality of service for sensors makes of one. To subscribe best effort would match both, and lose
//! samples of reliable publishers, for which lockstep would wait for ever. So a topic is subscribed
//! reliably, and once more best effort as soon as it has a best-effort publisher.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, Weak};
use std::time::Duration;

use futures::{Stream, StreamExt};
use rsrs_msgs::topics::{Qos, Reliability};
use rustdds::{DomainParticipant, Subscriber};
use tokio::sync::oneshot;

use super::endpoint_creation::EndpointCreation;
use super::raw::{self, DdsNames, RawReader};
use super::subscription::{Failure, ReceivedRaw};
use super::{lock, qos};

/// How often to look for such publishers.
const POLL_PERIOD: Duration = Duration::from_millis(500);

/// Identities of best-effort publishers of one topic.
type Writers = Arc<Mutex<BTreeSet<[u8; 16]>>>;

/// What a new reader is made with.
pub(super) struct ReaderMaker {
    pub(super) participant: DomainParticipant,
    pub(super) subscriber: Subscriber,
    pub(super) endpoint_creation: Arc<EndpointCreation>,
}

/// All reliable subscriptions of a session.
#[derive(Default)]
pub(super) struct Watch(Mutex<Vec<Watched>>);

struct Watched {
    names: DdsNames,
    depth: u32,
    /// Gone with the subscription.
    best_effort: Weak<Mutex<BTreeSet<[u8; 16]>>>,
    /// Takes the second reader, once.
    second: Option<oneshot::Sender<RawReader>>,
}

impl Watch {
    /// Watches a topic that is subscribed reliably, for what its best-effort publishers send and
    /// nothing of others.
    pub(super) fn samples(
        &self,
        names: DdsNames,
        quality: Qos,
    ) -> impl Stream<Item = Result<ReceivedRaw, Failure>> + use<> {
        let best_effort = Writers::default();
        let (second, reader) = oneshot::channel();
        let watched = Watched {
            names,
            depth: quality.depth,
            best_effort: Arc::downgrade(&best_effort),
            second: Some(second),
        };
        lock(&self.0).push(watched);
        futures::stream::once(reader)
            // The session closes, and there was no best-effort publisher.
            .filter_map(async |reader| reader.ok())
            .flat_map(raw::stream)
            .filter(move |sample| {
                let is_ours = match sample {
                    Ok(received) => lock(&best_effort).contains(&received.writer),
                    Err(_) => true,
                };
                std::future::ready(is_ours)
            })
    }

    /// Makes the second readers as they are needed; never ends.
    pub(super) async fn run(self: Arc<Self>, maker: ReaderMaker) {
        loop {
            tokio::time::sleep(POLL_PERIOD).await;
            self.look(&maker);
        }
    }

    fn look(&self, maker: &ReaderMaker) {
        let mut found: BTreeMap<String, BTreeSet<[u8; 16]>> = BTreeMap::new();
        for writer in maker.participant.discovered_writers() {
            let data = writer.publication_topic_data;
            if qos::discovered(&data.qos()).reliability == Reliability::BestEffort {
                let writer = data.key.to_bytes();
                found.entry(data.topic_name).or_default().insert(writer);
            }
        }
        lock(&self.0).retain_mut(|watched| {
            let Some(best_effort) = watched.best_effort.upgrade() else { return false };
            let writers = found.get(watched.names.topic()).cloned().unwrap_or_default();
            let is_needed = !writers.is_empty();
            *lock(&best_effort) = writers;
            if is_needed && let Some(second) = watched.second.take() {
                watched.second = watched.subscribe(maker, second);
            }
            true
        });
    }
}

impl Watched {
    /// Makes the second reader; gives the sender back if that has to be tried again.
    fn subscribe(
        &self,
        maker: &ReaderMaker,
        second: oneshot::Sender<RawReader>,
    ) -> Option<oneshot::Sender<RawReader>> {
        let ReaderMaker { participant, subscriber, endpoint_creation } = maker;
        let policies = qos::policies(Qos::best_effort(self.depth));
        let made = endpoint_creation
            .make(1, || raw::reader(participant, subscriber, &self.names, &policies));
        match made {
            Ok(reader) => {
                log::info!("{} is published best effort, and is subscribed so too", self.names);
                // The subscription has just been dropped.
                drop(second.send(reader));
                None
            }
            Err(error) => {
                log::warn!(
                    "{} is published best effort and not subscribed yet: {error}",
                    self.names
                );
                Some(second)
            }
        }
    }
}
