//! No hardware: a robot of the simulator, gated as a real one would be.
//!
//! Detections come on `virtual_detection`, gated commands go out on `hardware/cmd_vel`.

use anyhow::Result;
use rsrs_core::robot::controller::Command;
use rsrs_fleet::fleet_file::CmdVel;
use rsrs_msgs::topics;
use rsrs_ros::parameters::{Descriptor, ParameterValue};

use super::ros::{RosDriver, seen};
use super::{Driver, DriverContext, Report};

/// The driver.
pub struct VirtualDriver(RosDriver);

impl Driver for VirtualDriver {
    fn parameters() -> Vec<(Descriptor, ParameterValue)> {
        Vec::new()
    }

    fn open(place: DriverContext<'_>) -> Result<Self> {
        let topic = ("", topics::VIRTUAL_DETECTION);
        RosDriver::follow(place, CmdVel::TwistStamped, topic, seen).map(Self)
    }

    async fn report(&mut self) -> Report {
        self.0.report().await
    }

    async fn drive(&mut self, command: Command) -> Result<()> {
        self.0.drive(command).await
    }

    fn sensor(&self) -> String {
        self.0.sensor()
    }

    fn health(&self) -> Vec<(&'static str, String)> {
        vec![("detections", self.0.n_readings().to_string())]
    }
}
