//! Gated commands to another driver's wheels, on `hardware/cmd_vel`.

use std::time::Duration;

use anyhow::bail;
use rsrs_core::robot::controller::Command;
use rsrs_fleet::wire;
use rsrs_msgs::geometry_msgs::{Twist, TwistStamped};
use rsrs_msgs::topics;
use rsrs_ros::clock::wall_time;
use rsrs_ros::session::{Publisher, SessionError};

use super::DriverContext;

/// A command that a subscriber does not take within this time is late.
const LATE: Duration = Duration::from_millis(100);

/// Publishes commands that the gate let through.
pub enum CmdVelPublisher {
    /// With the time at which they were sent.
    Stamped(Publisher<TwistStamped>),
    /// Without.
    Unstamped(Publisher<Twist>),
}

impl CmdVelPublisher {
    /// Publishes with stamps.
    pub fn stamped(place: DriverContext<'_>) -> Result<Self, SessionError> {
        let topic = topics::HARDWARE_CMD_VEL;
        let name = topic.for_robot(place.robot);
        place.session.publish_on(place.node, &name, topic.qos).map(Self::Stamped)
    }

    /// Publishes without stamps.
    pub fn unstamped(place: DriverContext<'_>) -> Result<Self, SessionError> {
        let topic = topics::HARDWARE_CMD_VEL_UNSTAMPED;
        let name = topic.for_robot(place.robot);
        place.session.publish_on(place.node, &name, topic.qos).map(Self::Unstamped)
    }

    /// Publishes a command.
    pub async fn drive(&self, command: Command) -> anyhow::Result<()> {
        let sent = tokio::time::timeout(LATE, async {
            match self {
                Self::Stamped(publisher) => {
                    publisher.publish(wire::twist_stamped(command, wall_time())).await
                }
                Self::Unstamped(publisher) => publisher.publish(wire::twist(command)).await,
            }
        });
        match sent.await {
            Ok(sent) => Ok(sent?),
            Err(_late) => bail!("no command was taken for {} ms", LATE.as_millis()),
        }
    }
}
