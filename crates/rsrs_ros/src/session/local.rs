//! Delivery within a secured participant, which the middleware does not do.
//!
//! It exchanges keys once with each endpoint of others, whichever of ours it is matched with, and has
//! no keys for our own endpoints at all: of two readers of a topic in one participant neither receives
//! anything, and no reader receives what its own participant publishes. A robot's gate and controller
//! are two nodes of one participant. So a secured session has one reader of each topic, whose samples
//! all of its subscriptions get, hands them what it publishes itself, and has one writer of each topic.

use std::any::Any;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use futures::StreamExt;
use futures::stream::BoxStream;
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};

use super::SessionError;
use super::lock;
use super::subscription::{Failure, ReceivedRaw, wall_nanoseconds};

/// What comes on a topic.
pub(super) type Samples = BoxStream<'static, Result<ReceivedRaw, Failure>>;

/// The subscriptions of one topic.
#[derive(Debug, Default)]
pub(super) struct Hub(Mutex<Vec<UnboundedSender<ReceivedRaw>>>);

impl Hub {
    /// Hands a sample to every subscription that is still there.
    pub(super) fn deliver(&self, sample: &ReceivedRaw) {
        lock(&self.0).retain(|subscription| subscription.send(sample.clone()).is_ok());
    }

    /// What comes from now on.
    fn samples(&self) -> Samples {
        let (sender, receiver) = unbounded_channel();
        lock(&self.0).push(sender);
        let samples = futures::stream::unfold(receiver, async |mut receiver| {
            Some((Ok(receiver.recv().await?), receiver))
        });
        samples.boxed()
    }
}

/// The subscribed topics of a session, by their names in DDS.
#[derive(Debug, Default)]
pub(super) struct LocalDelivery(Mutex<BTreeMap<String, Arc<Hub>>>);

impl LocalDelivery {
    /// Subscribes to a topic. At the first subscription, `make_reader` makes the one reader of the
    /// topic, which delivers into the hub.
    pub(super) fn subscribe(
        &self,
        dds_topic: &str,
        make_reader: impl FnOnce(Arc<Hub>) -> Result<(), SessionError>,
    ) -> Result<Samples, SessionError> {
        let mut hubs = lock(&self.0);
        if let Some(hub) = hubs.get(dds_topic) {
            return Ok(hub.samples());
        }
        let hub = Arc::new(Hub::default());
        let samples = hub.samples();
        make_reader(Arc::clone(&hub))?;
        hubs.insert(dds_topic.to_owned(), hub);
        Ok(samples)
    }
}

/// The writers of a secured session, by their topics' names in DDS, kept until it is closed. Of two
/// writers of a topic in one participant neither is received, even if the first one is gone.
#[derive(Default)]
pub(super) struct Writers(Mutex<BTreeMap<String, Arc<dyn Any + Send + Sync>>>);

impl Writers {
    /// The writer of a topic; made at the first call for its type.
    pub(super) fn shared<W: Any + Send + Sync>(
        &self,
        dds_topic: &str,
        make: impl FnOnce() -> Result<W, SessionError>,
    ) -> Result<Arc<W>, SessionError> {
        let mut writers = lock(&self.0);
        let known = writers.get(dds_topic).cloned();
        if let Some(writer) = known.and_then(|writer| writer.downcast().ok()) {
            return Ok(writer);
        }
        let writer = Arc::new(make()?);
        let kept: Arc<dyn Any + Send + Sync> = Arc::<W>::clone(&writer);
        writers.insert(dds_topic.to_owned(), kept);
        Ok(writer)
    }
}

/// The way of what one publisher sends to the subscriptions of its own session.
#[derive(Debug)]
pub(super) struct LocalPublisher {
    topics: Arc<LocalDelivery>,
    dds_topic: String,
    writer: [u8; 16],
    /// As the middleware counts.
    n_published: AtomicU64,
}

impl LocalPublisher {
    pub(super) fn new(topics: &Arc<LocalDelivery>, dds_topic: String, writer: [u8; 16]) -> Self {
        Self { topics: Arc::clone(topics), dds_topic, writer, n_published: AtomicU64::new(0) }
    }

    /// Hands on what was published, with its encapsulation; the message is made only if somebody
    /// has subscribed.
    pub(super) fn deliver(&self, message: impl FnOnce() -> Vec<u8>) {
        let sequence = self.n_published.fetch_add(1, Ordering::Relaxed) + 1;
        let hub = lock(&self.topics.0).get(&self.dds_topic).cloned();
        let Some(hub) = hub else { return };
        let now_ns = wall_nanoseconds();
        hub.deliver(&ReceivedRaw {
            message: message(),
            source_time_ns: Some(now_ns),
            received_time_ns: now_ns,
            sequence,
            writer: self.writer,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(flavor = "current_thread")]
    async fn every_subscription_gets_what_the_reader_and_what_the_own_publisher_bring() {
        let topics = Arc::new(LocalDelivery::default());
        let mut reader = None;
        let own = LocalPublisher::new(&topics, "rt/a".to_owned(), [7; 16]);
        own.deliver(|| unreachable!("nobody has subscribed yet"));

        let first = topics.subscribe("rt/a", |hub| {
            reader = Some(hub);
            Ok(())
        });
        let second = topics.subscribe("rt/a", |_| unreachable!("a topic has one reader"));
        own.deliver(|| vec![1]);
        let from_others = ReceivedRaw {
            message: vec![2],
            source_time_ns: None,
            received_time_ns: 0,
            sequence: 1,
            writer: [8; 16],
        };
        reader.unwrap().deliver(&from_others);

        for samples in [first.unwrap(), second.unwrap()] {
            let received: Vec<_> = samples.take(2).map(|it| it.ok().unwrap()).collect().await;
            assert_eq!((&received[0].message, received[0].sequence), (&vec![1], 2));
            assert_eq!(received[0].writer, [7; 16]);
            assert_eq!(received[1], from_others);
        }
    }
}
