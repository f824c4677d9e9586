//! Velocity commands, which are of one of two types.

use rsrs_core::robot::controller::Command;
use rsrs_fleet::wire;
use rsrs_msgs::RosMessage;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::{Twist, TwistStamped};
use rsrs_msgs::topics::Topic;

use crate::session::{
    NodeHandle, PublishError, Publisher, Received, Session, SessionError, Subscription,
};

/// Publishes the velocity commands of one robot.
pub enum CmdVelPublisher {
    /// With the time at which they were sent.
    Stamped(Publisher<TwistStamped>),
    /// Without.
    Unstamped(Publisher<Twist>),
}

impl CmdVelPublisher {
    /// Publishes on the topic of a robot, as messages of its type.
    pub fn new(
        session: &Session,
        node: &NodeHandle,
        robot: &str,
        topic: Topic,
    ) -> Result<Self, SessionError> {
        let name = topic.for_robot(robot);
        if topic.type_name == Twist::TYPE_NAME {
            session.publish_on(node, &name, topic.qos).map(Self::Unstamped)
        } else {
            session.publish_on(node, &name, topic.qos).map(Self::Stamped)
        }
    }

    /// Publishes a command.
    pub async fn publish(&self, command: Command, stamp: Time) -> Result<(), PublishError> {
        match self {
            Self::Stamped(publisher) => {
                publisher.publish(wire::twist_stamped(command, stamp)).await
            }
            Self::Unstamped(publisher) => publisher.publish(wire::twist(command)).await,
        }
    }
}

/// Receives velocity commands on the topic of a robot, as messages of its type; hands each on with its
/// stamp in nanoseconds, if it has one.
pub fn subscribe(
    session: &Session,
    node: &NodeHandle,
    robot: &str,
    topic: Topic,
    deliver: impl Fn(Twist, Option<u64>) + Send + 'static,
) -> Result<Subscription, SessionError> {
    let name = topic.for_robot(robot);
    if topic.type_name == Twist::TYPE_NAME {
        session.subscribe(node, &name, topic.qos, move |sample: Received<Twist>| {
            deliver(sample.message, None);
        })
    } else {
        session.subscribe(node, &name, topic.qos, move |sample: Received<TwistStamped>| {
            let TwistStamped { header, twist } = sample.message;
            deliver(twist, header.stamp.to_nanos());
        })
    }
}
