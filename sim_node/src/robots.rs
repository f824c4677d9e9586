//! The virtual robots: each with the topics and the gate of a real one.

use std::time::Duration;

use rsrs_core::unicycle::Pose;
use rsrs_fleet::message::RobotState;
use rsrs_fleet::robot::{Event, Robot, RobotOptions};
use rsrs_fleet::timing::{COMMAND_AT_LEAST, LOCKSTEP_GRACE};
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::{self, Point, PoseWithCovariance, Quaternion, TwistWithCovariance};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::RobotStatus;
use rsrs_msgs::std_msgs::{Bool, Header};
use rsrs_msgs::topics;
use rsrs_ros::clock::wall_time;
use rsrs_ros::session::{NodeHandle, Publisher, Session};
use rsrs_wire as wire;

/// Name of a robot's node in its namespace.
const NODE: &str = "robot";

/// One virtual robot.
pub struct VirtualRobot {
    /// Its name.
    pub name: String,
    /// Its node.
    pub node: NodeHandle,
    gate: Robot,
    detection: Publisher<Bool>,
    odom: Publisher<Odometry>,
    status: Publisher<RobotStatus>,
}

impl VirtualRobot {
    /// Puts a robot on the network.
    ///
    /// # Errors
    ///
    /// If a topic cannot be made.
    pub fn new(session: &Session, name: &str) -> anyhow::Result<Self> {
        let node = session.node(&format!("/{name}"), NODE)?;
        let (detection, odom, status) = (topics::DETECTION, topics::ODOM, topics::STATUS);
        let gate = Robot::new(RobotOptions {
            name: name.to_owned(),
            command_timeout: COMMAND_AT_LEAST,
            lapse_grace: LOCKSTEP_GRACE,
        });
        Ok(Self {
            name: name.to_owned(),
            gate,
            detection: session.publish_on(&node, &detection.for_robot(name), detection.qos)?,
            odom: session.publish_on(&node, &odom.for_robot(name), odom.qos)?,
            status: session.publish_on(&node, &status.for_robot(name), status.qos)?,
            node,
        })
    }

    /// Lets the gate take an event, and publishes the status that follows, if one does.
    ///
    /// # Errors
    ///
    /// If the status cannot be published.
    pub async fn on_event(&mut self, event: Event, now: Duration) -> anyhow::Result<()> {
        if let Some(status) = self.gate.on_event(event, now) {
            self.status.publish(wire::status_message(&status, wall_time())).await?;
        }
        Ok(())
    }

    /// Whether the gate lets the robot move.
    pub fn may_move(&self, now: Duration) -> bool {
        self.gate.standing(now).is_none()
    }

    /// Whether a run holds the robot, moving or about to.
    pub fn is_bound(&self, now: Duration) -> bool {
        matches!(self.gate.state(now), RobotState::Armed | RobotState::Moving)
    }

    /// Publishes what the sensor reports in this step.
    ///
    /// # Errors
    ///
    /// If a reliable subscriber stops acknowledging.
    pub async fn publish_detection(&self, detection: Bool) -> anyhow::Result<()> {
        Ok(self.detection.publish(detection).await?)
    }

    /// Publishes where the robot is: ground truth.
    ///
    /// # Errors
    ///
    /// If a reliable subscriber stops acknowledging.
    pub async fn publish_pose(&self, pose: Pose, stamp_ns: u64) -> anyhow::Result<()> {
        let (sine, cosine) = libm::sincos(pose.heading_rad / 2.0);
        let pose = geometry_msgs::Pose {
            position: Point { x: pose.x_m, y: pose.y_m, z: 0.0 },
            orientation: Quaternion { x: 0.0, y: 0.0, z: sine, w: cosine },
        };
        let odometry = Odometry {
            header: Header { stamp: Time::from_nanos(stamp_ns), frame_id: "map".to_owned() },
            child_frame_id: format!("{}/base_link", self.name),
            pose: PoseWithCovariance { pose, ..PoseWithCovariance::default() },
            twist: TwistWithCovariance::default(),
        };
        Ok(self.odom.publish(odometry).await?)
    }
}
