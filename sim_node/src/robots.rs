//! The virtual robots: each with the topics and the gate of a real one.

use std::time::Duration;

use rsrs_core::controller::Command;
use rsrs_core::unicycle::Pose;
use rsrs_fleet::experiment::Time as Pace;
use rsrs_fleet::robot::{Event, Robot, RobotOptions};
use rsrs_fleet::simulator::Gate;
use rsrs_fleet::timing::{COMMAND_AT_LEAST, LOCKSTEP_GRACE, command_timeout};
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::{self, Point, PoseWithCovariance, TwistWithCovariance};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::RobotStatus;
use rsrs_msgs::std_msgs::{Bool, Header};
use rsrs_msgs::topics;
use rsrs_ros::clock::wall_time;
use rsrs_ros::session::{NodeHandle, Publisher, Session};
use rsrs_wire as wire;

use crate::frames::{FRAME, base_link, rotation};

/// Name of a robot's node in its namespace.
const NODE: &str = "robot";

/// One virtual robot.
pub struct VirtualRobot {
    /// Its name.
    pub name: String,
    /// Its node.
    pub node: NodeHandle,
    options: RobotOptions,
    gate: Robot,
    /// What the e-stop said last, and when.
    e_stop: Option<(bool, Duration)>,
    detection: Publisher<Bool>,
    odom: Publisher<Odometry>,
    status: Publisher<RobotStatus>,
}

/// Where a robot is and what it does there, in one step.
#[derive(Clone, Copy)]
pub struct Motion {
    /// Ground truth.
    pub pose: Pose,
    /// The command that it obeys.
    pub command: Command,
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
        let options = options(name, Pace::Lockstep, Duration::ZERO);
        Ok(Self {
            name: name.to_owned(),
            gate: new_gate(&options),
            options,
            e_stop: None,
            detection: session.publish_on(&node, &detection.for_robot(name), detection.qos)?,
            odom: session.publish_on(&node, &odom.for_robot(name), odom.qos)?,
            status: session.publish_on(&node, &status.for_robot(name), status.qos)?,
            node,
        })
    }

    /// Becomes a robot of a world with this pace and period.
    ///
    /// A robot that has to change for it is switched off and on again, as a real one would be: it
    /// has forgotten its runs. It remembers the e-stop.
    pub fn join(&mut self, pace: Pace, period: Duration) {
        let options = options(&self.name, pace, period);
        if options == self.options {
            return;
        }
        self.gate = new_gate(&options);
        self.options = options;
        if let Some((engaged, heard)) = self.e_stop {
            // A first status in the past is nobody's; the next is due within a beat.
            drop(self.gate.on_event(Event::EStop(engaged), heard));
        }
    }

    /// Lets the gate take an event, and publishes the status that follows, if one does.
    ///
    /// # Errors
    ///
    /// If the status cannot be published.
    pub async fn on_event(&mut self, event: Event, now: Duration) -> anyhow::Result<()> {
        if let Event::EStop(engaged) = event {
            self.e_stop = Some((engaged, now));
        }
        if let Some(status) = self.gate.on_event(event, now) {
            self.status.publish(wire::status_message(&status, wall_time())).await?;
        }
        Ok(())
    }

    /// What the gate says now.
    pub fn gate(&self, now: Duration) -> Gate {
        Gate { state: self.gate.state(now), drive: self.gate.drive(now) }
    }

    /// Publishes what the sensor reports in this step.
    ///
    /// # Errors
    ///
    /// If a reliable subscriber stops acknowledging.
    pub async fn publish_detection(&self, detection: Bool) -> anyhow::Result<()> {
        Ok(self.detection.publish(detection).await?)
    }

    /// Publishes where the robot is and what it does: ground truth, and the command obeyed.
    ///
    /// # Errors
    ///
    /// If a reliable subscriber stops acknowledging.
    pub async fn publish_motion(&self, motion: Motion, stamp: Time) -> anyhow::Result<()> {
        let Motion { pose, command } = motion;
        let pose = pose_message(pose);
        let odometry = Odometry {
            header: Header { stamp, frame_id: FRAME.to_owned() },
            child_frame_id: base_link(&self.name),
            pose: PoseWithCovariance { pose, ..PoseWithCovariance::default() },
            twist: TwistWithCovariance {
                twist: wire::twist(command),
                ..TwistWithCovariance::default()
            },
        };
        Ok(self.odom.publish(odometry).await?)
    }
}

fn new_gate(options: &RobotOptions) -> Robot {
    Robot::new(options.clone()).counting_from(wire::first_counter(wall_time()))
}

/// A pose on the floor as a message.
pub fn pose_message(pose: Pose) -> geometry_msgs::Pose {
    geometry_msgs::Pose {
        position: Point { x: pose.x_m, y: pose.y_m, z: 0.0 },
        orientation: rotation(pose.heading_rad),
    }
}

/// In lockstep a lapse freezes the world's time; on the wall's time it is a stop, as on a floor.
fn options(name: &str, pace: Pace, period: Duration) -> RobotOptions {
    let (command_timeout, lapse_grace) = match pace {
        Pace::Lockstep => (COMMAND_AT_LEAST, LOCKSTEP_GRACE),
        Pace::RealTime => (command_timeout(period.as_secs_f64()), Duration::ZERO),
    };
    RobotOptions { name: name.to_owned(), command_timeout, lapse_grace }
}
