//! The publishers of a robot.

use rsrs_fleet::message::Status;
use rsrs_fleet::wire;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::diagnostic_msgs::DiagnosticArray;
use rsrs_msgs::rsrs::RobotStatus;
use rsrs_msgs::sensor_msgs::Range;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics;
use rsrs_ros::clock::wall_time;
use rsrs_ros::session::{NodeHandle, PublishError, Publisher, Session, SessionError};

use crate::diagnostics::{self, Health};

/// A robot's publishers. Publishing fails if a reliable subscriber stops acknowledging.
pub struct Publishers {
    robot: String,
    detection: Publisher<Bool>,
    range: Publisher<Range>,
    status: Publisher<RobotStatus>,
    diagnostics: Publisher<DiagnosticArray>,
}

impl Publishers {
    /// Starts to publish.
    pub fn new(session: &Session, node: &NodeHandle, robot: &str) -> Result<Self, SessionError> {
        let (detection, range, status) = (topics::DETECTION, topics::RANGE, topics::STATUS);
        let diagnostics = topics::DIAGNOSTICS;
        Ok(Self {
            robot: robot.to_owned(),
            detection: session.publish_on(node, &detection.for_robot(robot), detection.qos)?,
            range: session.publish_on(node, &range.for_robot(robot), range.qos)?,
            status: session.publish_on(node, &status.for_robot(robot), status.qos)?,
            diagnostics: session.publish_on(node, diagnostics.name, diagnostics.qos)?,
        })
    }

    /// Whether the robot sees something.
    pub async fn detection(&self, detection: Bool) -> Result<(), PublishError> {
        self.detection.publish(detection).await
    }

    /// What its sensor measured; time and frame are filled in where the sensor has none.
    pub async fn range(&self, mut range: Range) -> Result<(), PublishError> {
        if range.header.stamp == Time::default() {
            range.header.stamp = wall_time();
        }
        if range.header.frame_id.is_empty() {
            range.header.frame_id = format!("{}/range", self.robot);
        }
        self.range.publish(range).await
    }

    /// What its gate does.
    pub async fn status(&self, status: &Status) -> Result<(), PublishError> {
        self.status.publish(wire::status_message(status, wall_time())).await
    }

    /// How its parts are.
    pub async fn health(&self, health: Health<'_>) -> Result<(), PublishError> {
        self.diagnostics.publish(diagnostics::message(health, wall_time())).await
    }
}
