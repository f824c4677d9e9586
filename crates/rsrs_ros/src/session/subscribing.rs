//! Subscriptions: of messages and of bytes, each of one reader or of several.

use std::sync::Arc;

use futures::{Stream, StreamExt};
use rsrs_msgs::RosMessage;
use rsrs_msgs::topics::{Qos, Reliability};

use super::local::{LocalDelivery, Samples};
use super::node::{message_type, ros_name};
use super::quality::ReaderMaker;
use super::subscription::Failure;
use super::wire::Wire;
use super::{
    NodeHandle, Received, ReceivedRaw, Session, SessionError, Subscription, profile, qos, raw,
    subscription,
};

impl Session {
    /// Subscribes to an absolute topic, such as `/robot_3/detection`; every sample is handed to
    /// `deliver` in a task of its own, which must not block because all tasks may share one thread.
    /// Where `qos` is reliable, samples of best-effort publishers are delivered as well.
    ///
    /// Samples that do not decode are counted and logged, because another program sent them.
    pub fn subscribe<M: RosMessage>(
        &self,
        node: &NodeHandle,
        topic: &str,
        qos: Qos,
        deliver: impl FnMut(Received<M>) + Send + 'static,
    ) -> Result<Subscription, SessionError> {
        let topic = &self.remapped(node, topic);
        if let Some(local) = &self.local {
            let samples = self.shared(local, topic, M::TYPE_NAME, qos)?;
            let samples = samples.map(|sample| sample.and_then(raw::decode));
            return Ok(self.tasks.deliver(topic, samples, deliver));
        }
        let profile = profile(qos);
        let reader = self.with_node(node, 1, |node| {
            let dds_topic = node.create_topic(&ros_name(topic)?, message_type::<M>(), &profile);
            let dds_topic = dds_topic.map_err(|error| SessionError::endpoint(topic, &error))?;
            node.create_subscription::<Wire<M>>(&dds_topic, Some(profile.clone()))
                .map_err(|error| SessionError::endpoint(topic, &error))
        })?;
        let samples = subscription::typed(reader);
        if qos.reliability == Reliability::BestEffort {
            return Ok(self.tasks.deliver(topic, samples, deliver));
        }
        let best_effort = self.best_effort(topic, M::TYPE_NAME, qos)?;
        let best_effort = best_effort.map(|sample| sample.and_then(raw::decode));
        Ok(self.tasks.deliver(topic, futures::stream::select(samples, best_effort), deliver))
    }

    /// Subscribes to bytes of any type, such as `std_msgs/msg/Bool`, on an absolute topic; they
    /// keep their 4 bytes of encapsulation, as in a bag.
    pub fn subscribe_raw(
        &self,
        topic: &str,
        type_name: &str,
        qos: Qos,
        deliver: impl FnMut(ReceivedRaw) + Send + 'static,
    ) -> Result<Subscription, SessionError> {
        if let Some(local) = &self.local {
            let samples = self.shared(local, topic, type_name, qos)?;
            return Ok(self.tasks.deliver(topic, samples, deliver));
        }
        let names = raw::DdsNames::of_topic(topic, type_name)?;
        let policies = qos::policies(qos);
        let reader = self
            .endpoint_creation
            .make(1, || raw::reader(&self.participant, &self.subscriber, &names, &policies))?;
        let samples = raw::stream(reader);
        if qos.reliability == Reliability::BestEffort {
            return Ok(self.tasks.deliver(topic, samples, deliver));
        }
        let best_effort = self.best_effort(topic, type_name, qos)?;
        Ok(self.tasks.deliver(topic, futures::stream::select(samples, best_effort), deliver))
    }

    /// What comes on a topic of a secured session, by its one reader or from within.
    fn shared(
        &self,
        local: &LocalDelivery,
        topic: &str,
        type_name: &str,
        qos: Qos,
    ) -> Result<Samples, SessionError> {
        let (names, policies) = (raw::DdsNames::of_topic(topic, type_name)?, qos::policies(qos));
        local.subscribe(names.topic(), |hub| {
            let make = || raw::reader(&self.participant, &self.subscriber, &names, &policies);
            let samples = raw::stream(self.endpoint_creation.make(1, make)?);
            let deliver = move |sample| hub.deliver(&sample);
            self.tasks.deliver(topic, samples, deliver).until_close();
            Ok(())
        })
    }

    /// What is sent best effort on a topic that is subscribed reliably.
    fn best_effort(
        &self,
        topic: &str,
        type_name: &str,
        qos: Qos,
    ) -> Result<impl Stream<Item = Result<ReceivedRaw, Failure>> + use<>, SessionError> {
        self.watches.call_once(|| {
            let watch = Arc::clone(&self.watch);
            let maker = ReaderMaker {
                participant: self.participant.clone(),
                subscriber: self.subscriber.clone(),
                endpoint_creation: Arc::clone(&self.endpoint_creation),
            };
            let watching = watch.run(maker);
            self.tasks.run(watching).until_close();
        });
        Ok(self.watch.samples(raw::DdsNames::of_topic(topic, type_name)?, qos))
    }
}
