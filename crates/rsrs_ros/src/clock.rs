//! Time: simulated, on `/clock`, wall-clock time, and time since boot.
//!
//! ros2-client follows `/clock` with a type that no ROS 2 program publishes, so this is our own.

use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::rosgraph_msgs::Clock;
use rsrs_msgs::topics;
use tokio::sync::watch;

use crate::session::{
    NodeHandle, PublishError, Publisher, Received, Session, SessionError, Subscription,
};

pub use crate::boot_time::since_boot;
pub use crate::wall_time::wall_time;

/// Publishes the time to the network.
pub struct ClockPublisher {
    publisher: Publisher<Clock>,
}

impl ClockPublisher {
    /// Starts to publish `/clock`.
    pub fn new(session: &Session, node: &NodeHandle) -> Result<Self, SessionError> {
        let publisher = session.publish_on(node, topics::CLOCK.name, topics::CLOCK.qos)?;
        Ok(Self { publisher })
    }

    /// Sets the time, in nanoseconds since the start of the simulation.
    pub async fn publish(&self, time_ns: u64) -> Result<(), PublishError> {
        self.publisher.publish(Clock { clock: Time::from_nanos(time_ns) }).await
    }
}

/// Follows the network's time.
pub struct ClockFollower {
    time_ns: watch::Receiver<Option<u64>>,
    _subscription: Subscription,
}

impl ClockFollower {
    /// Starts to follow `/clock`.
    pub fn new(session: &Session, node: &NodeHandle) -> Result<Self, SessionError> {
        let (sender, time_ns) = watch::channel(None);
        let deliver = move |received: Received<Clock>| {
            // No clock was read before its own start.
            if let Some(now_ns) = received.message.clock.to_nanos() {
                sender.send_replace(Some(now_ns));
            }
        };
        let subscription =
            session.subscribe(node, topics::CLOCK.name, topics::CLOCK.qos, deliver)?;
        Ok(Self { time_ns, _subscription: subscription })
    }

    /// Nanoseconds since the start of the simulation; `None` until the first message on `/clock`.
    pub fn now_ns(&self) -> Option<u64> {
        *self.time_ns.borrow()
    }

    /// Waits until the time is at least `time_ns`, and returns it; `None` if the session is closed.
    pub async fn reached(&mut self, time_ns: u64) -> Option<u64> {
        let now = self.time_ns.wait_for(|now| now.is_some_and(|now_ns| now_ns >= time_ns)).await;
        now.ok().and_then(|now| *now)
    }
}
