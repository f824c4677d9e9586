//! The virtual robots: each with the topics and the gate of a real one.

use std::time::Duration;

use rsrs_core::robot::controller::Command;
use rsrs_core::robot::sensor::{ReadingNames, Readings};
use rsrs_core::robot::unicycle::Pose;
use rsrs_fleet::e_stop::Locks;
use rsrs_fleet::experiment::Time as TimeMode;
use rsrs_fleet::message::RobotState;
use rsrs_fleet::robot::{Event, Lapse, Robot, RobotOptions};
use rsrs_fleet::simulator::{Gate, Gates};
use rsrs_fleet::timing::{Transport, command_timeout};
use rsrs_fleet::wire;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::{self, Point, PoseWithCovariance, TwistWithCovariance};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::RobotStatus;
use rsrs_msgs::std_msgs::{Bool, Header};
use rsrs_msgs::topics::{self, Topic};
use rsrs_ros::clock::wall_time;
use rsrs_ros::complaints::Complaints;
use rsrs_ros::session::{NodeHandle, Publisher, Session};

use crate::frames::{FRAME, base_link, rotation};

/// One virtual robot.
pub struct VirtualRobot {
    /// Its name.
    pub name: String,
    /// The simulator's node, to which its topics belong.
    pub node: NodeHandle,
    options: RobotOptions,
    transport: Transport,
    /// What stands between commands and the wheels; unused where that is elsewhere.
    gate: Robot,
    gates: Gates,
    /// What the gate of a robot node let through last, and when.
    let_through: Option<(Command, Duration)>,
    detection: Publisher<Bool>,
    /// Of its readings besides `detection`, in this world.
    further: Vec<Publisher<Bool>>,
    odom: Publisher<Odometry>,
    /// The status of the gate, where it is here.
    status: Option<Publisher<RobotStatus>>,
    complaints: Complaints,
}

/// Wheels stop by themselves when their robot's node sends nothing for so long.
const WHEELS_TIMEOUT: Duration = Duration::from_millis(250);

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
    pub fn new(
        session: &Session,
        node: &NodeHandle,
        name: &str,
        gates: Gates,
    ) -> anyhow::Result<Self> {
        let node = node.clone();
        let (odom, status) = (topics::ODOM, topics::STATUS);
        let detection = match gates {
            Gates::Here => topics::DETECTION,
            Gates::Elsewhere => topics::VIRTUAL_DETECTION,
        };
        let options = options(name, TimeMode::Lockstep, Duration::ZERO, session.transport());
        Ok(Self {
            name: name.to_owned(),
            gate: counting(Robot::new(options.clone())).of_a_new_process(),
            options,
            detection: session.publish_on(&node, &detection.for_robot(name), detection.qos)?,
            further: Vec::new(),
            odom: session.publish_on(&node, &odom.for_robot(name), odom.qos)?,
            status: match gates {
                Gates::Here => {
                    Some(session.publish_on(&node, &status.for_robot(name), status.qos)?)
                }
                Gates::Elsewhere => None,
            },
            complaints: Complaints::default(),
            gates,
            transport: session.transport(),
            let_through: None,
            node,
        })
    }

    /// Logs a warning about it, one a second at most.
    pub fn warn(&mut self, text: &str) {
        self.complaints.warn(&self.node, &format!("{}: {text}", self.name));
    }

    /// Becomes a robot of a world with this pace and period.
    ///
    /// A robot that has to change for it is switched off and on again, as a real one would be: it
    /// has forgotten its runs. It remembers the e-stop.
    pub fn join(&mut self, pace: TimeMode, period: Duration) {
        let options = options(&self.name, pace, period, self.transport);
        if options == self.options {
            return;
        }
        self.gate = counting(self.gate.anew(options.clone()));
        self.options = options;
    }

    /// Has topics for what it reports in a world, which those who come later get from its beginning.
    pub fn report(&mut self, session: &Session, readings: &ReadingNames) -> anyhow::Result<()> {
        self.further.clear();
        for reading in readings.further() {
            let topic = topics::further_detection(&self.name, reading);
            let qos = topics::FURTHER_DETECTION.qos;
            self.further.push(session.publish_on(&self.node, &topic, qos)?);
        }
        Ok(())
    }

    /// Lets the gate take an event, and publishes the status that follows, if one does.
    pub async fn on_event(&mut self, event: Event, now: Duration) -> anyhow::Result<()> {
        let Some(publisher) = &self.status else {
            if let Event::Command(command) = event {
                self.let_through = Some((command, now));
            }
            return Ok(());
        };
        if let Some(status) = self.gate.on_event(event, now) {
            publisher.publish(wire::status_message(&status, wall_time())).await?;
        }
        Ok(())
    }

    /// The run that its gate obeys, if any.
    pub fn run_id(&self) -> Option<&str> {
        self.gate.run_id()
    }

    /// Who has locked it by the e-stop.
    pub fn locks(&self) -> Locks {
        self.gate.locks()
    }

    /// The state of the gate now, and the command that it lets through.
    pub fn gate(&self, now: Duration) -> Gate {
        if self.gates == Gates::Elsewhere {
            let fresh = self.let_through.filter(|(command, at)| {
                *command != Command::STOP && now.saturating_sub(*at) <= WHEELS_TIMEOUT
            });
            return match fresh {
                Some((drive, _)) => Gate { state: RobotState::Moving, drive, is_in_run: true },
                None => Gate { state: RobotState::Idle, drive: Command::STOP, is_in_run: false },
            };
        }
        Gate {
            state: self.gate.state(now),
            drive: self.gate.drive(now),
            is_in_run: self.gate.is_in_run(now),
        }
    }

    /// The two shapes of the commands that move it, stamped first.
    pub fn command_topics(&self) -> [Topic; 2] {
        match self.gates {
            Gates::Here => [topics::CMD_VEL, topics::CMD_VEL_UNSTAMPED],
            Gates::Elsewhere => [topics::HARDWARE_CMD_VEL, topics::HARDWARE_CMD_VEL_UNSTAMPED],
        }
    }

    /// Publishes what the sensors report in this step: `detection` last, which the controller answers.
    pub async fn publish_readings(&self, readings: Readings) -> anyhow::Result<()> {
        for (place, further) in self.further.iter().enumerate() {
            further.publish(Bool { data: readings.has(place + 1) }).await?;
        }
        Ok(self.detection.publish(Bool { data: readings.detection() }).await?)
    }

    /// Publishes where the robot is and what it does: ground truth, and the command obeyed.
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

fn counting(gate: Robot) -> Robot {
    gate.counting_from(wire::first_counter(wall_time()))
}

/// A pose on the floor as a message.
pub fn pose_message(pose: Pose) -> geometry_msgs::Pose {
    geometry_msgs::Pose {
        position: Point { x: pose.x_m, y: pose.y_m, z: 0.0 },
        orientation: rotation(pose.heading_rad),
    }
}

/// In lockstep a lapse freezes the world's time; in wall-clock time it is a stop, as on a floor.
fn options(name: &str, pace: TimeMode, period: Duration, transport: Transport) -> RobotOptions {
    let (command_timeout, lapse) = match pace {
        TimeMode::Lockstep => (transport.least_command_timeout(), Lapse::Freezes),
        TimeMode::RealTime => (command_timeout(period.as_secs_f64(), transport), Lapse::Stops),
    };
    RobotOptions { name: name.to_owned(), command_timeout, lapse }
}
