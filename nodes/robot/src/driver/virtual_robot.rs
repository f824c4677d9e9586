//! No hardware: a robot of the simulator, gated as a real one would be.
//!
//! Detections come on `virtual_detection`, gated commands go out on `hardware/cmd_vel`.

use anyhow::Result;
use rsrs_core::robot::controller::Command;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics;
use rsrs_ros::parameters::{Descriptor, ParameterValue};
use rsrs_ros::session::Subscription;
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

use super::cmd_vel_publisher::CmdVelPublisher;
use super::{Driver, DriverContext, Report, Sensed, next_of};

/// The driver.
pub struct VirtualDriver {
    cmd_vel_publisher: CmdVelPublisher,
    reports: UnboundedReceiver<Report>,
    sensor_topic: String,
    subscription: Subscription,
}

impl Driver for VirtualDriver {
    fn parameters() -> Vec<(Descriptor, ParameterValue)> {
        Vec::new()
    }

    fn open(place: DriverContext<'_>) -> Result<Self> {
        let (to_node, reports) = unbounded_channel();
        // A simulator that does not run is a sensor that is silent, which the node notices.
        drop(to_node.send(Report::Up));
        let topic = topics::VIRTUAL_DETECTION;
        let name = topic.for_robot(place.robot);
        let subscription =
            place.session.subscribe(place.node, &name, topic.qos, move |sample| {
                let Bool { data } = sample.message;
                let sensed = Sensed { seen: Some(data), ..Sensed::default() };
                // The receiver is gone only while the node shuts down.
                drop(to_node.send(Report::Sensed(sensed)));
            })?;
        let cmd_vel_publisher = CmdVelPublisher::stamped(place)?;
        Ok(Self { cmd_vel_publisher, reports, sensor_topic: name, subscription })
    }

    async fn report(&mut self) -> Report {
        next_of(&mut self.reports).await
    }

    async fn drive(&mut self, command: Command) -> Result<()> {
        self.cmd_vel_publisher.drive(command).await
    }

    fn sensor(&self) -> String {
        self.sensor_topic.clone()
    }

    fn health(&self) -> Vec<(&'static str, String)> {
        vec![("detections", self.subscription.counts().taken.to_string())]
    }
}
