//! The e-stop's three topics: the state of each source, releases, and what is locked.

use crate::session::{
    NodeHandle, PublishError, Publisher, Received, Session, SessionError, Subscription,
};
use rsrs_fleet::e_stop::{Locks, Message, Source};
use rsrs_fleet::wire;
use rsrs_msgs::rsrs::EStopLocks;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics;

/// Receives from all three topics until it is dropped.
#[derive(Debug)]
pub struct EStopSubscriptions {
    _all: [Subscription; 3],
}

impl EStopSubscriptions {
    /// Subscribes, and hands every message to `deliver`, except one with an unknown cause, which is
    /// logged.
    pub fn new(
        session: &Session,
        node: &NodeHandle,
        deliver: impl Fn(Message) + Clone + Send + 'static,
    ) -> Result<Self, SessionError> {
        let (state, release, locks) =
            (topics::E_STOP, topics::E_STOP_RELEASE, topics::E_STOP_LOCKS);
        let (to_state, to_release, to_locks) = (deliver.clone(), deliver.clone(), deliver);
        let all = [
            session.subscribe(node, state.name, state.qos, move |sample: Received<Bool>| {
                let source = Source(sample.writer);
                to_state(Message::State { source, engaged: sample.message.data });
            })?,
            session.subscribe(node, release.name, release.qos, move |sample: Received<_>| {
                if let Some(locks) = understood(release.name, sample.message) {
                    to_release(Message::Release(locks.0.into_keys().collect()));
                }
            })?,
            session.subscribe(node, locks.name, locks.qos, move |sample: Received<_>| {
                let reporter = Source(sample.writer);
                if let Some(locks) = understood(locks.name, sample.message) {
                    to_locks(Message::Locks { reporter, locks });
                }
            })?,
        ];
        Ok(Self { _all: all })
    }
}

/// Understands locks; what is none is logged.
fn understood(topic: &str, message: EStopLocks) -> Option<Locks> {
    let refused = |error: &_| log::warn!("refused a message on {topic}: {error}");
    wire::locks(message).inspect_err(refused).ok()
}

/// Publishes what is locked on the robots of this process, whenever that changes.
pub struct LocksPublisher {
    publisher: Publisher<EStopLocks>,
    given: Locks,
}

impl LocksPublisher {
    /// Nothing is locked, and nothing was received.
    pub fn new(session: &Session, node: &NodeHandle) -> Result<Self, SessionError> {
        let topic = topics::E_STOP_LOCKS;
        let publisher = session.publish_on(node, topic.name, topic.qos)?;
        Ok(Self { publisher, given: Locks::default() })
    }

    /// Publishes what is locked now, if it is something else than before.
    pub async fn publish(&mut self, locks: Locks) -> Result<(), PublishError> {
        if locks == self.given {
            return Ok(());
        }
        self.publisher.publish(wire::locks_message(&locks)).await?;
        self.given = locks;
        Ok(())
    }
}
