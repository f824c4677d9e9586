//! What the robot node receives from the network.

use rsrs_fleet::e_stop::Message;
use rsrs_msgs::geometry_msgs::{Twist, TwistStamped};
use rsrs_msgs::rsrs::{RobotStatus, RunLease};
use rsrs_msgs::topics;
use rsrs_ros::e_stop::EStopSubscriptions;
use rsrs_ros::session::{NodeHandle, Session, SessionError, Subscription};
use tokio::sync::mpsc::UnboundedSender;

/// What reaches the robot.
#[derive(Debug)]
pub enum Input {
    /// A lease.
    Lease(RunLease),
    /// Something of the e-stop.
    EStop(Message),
    /// The status of its controller.
    Controller(RobotStatus),
    /// A velocity command.
    Command(Twist),
    /// A parameter was set.
    Parameters,
}

/// The type of velocity commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Commands {
    /// `geometry_msgs/TwistStamped`.
    Stamped,
    /// `geometry_msgs/Twist`.
    Unstamped,
}

/// Starts to listen.
pub fn listen(
    session: &Session,
    node: &NodeHandle,
    robot: &str,
    commands: Commands,
    received: &UnboundedSender<Input>,
) -> Result<[Subscription; 3], SessionError> {
    let (to_lease, to_controller) = (received.clone(), received.clone());
    let (lease, status) = (topics::LEASE, topics::CONTROLLER_STATUS);
    // In all of these, the receiver is gone only while the node shuts down.
    Ok([
        session.subscribe(node, lease.name, lease.qos, move |sample| {
            drop(to_lease.send(Input::Lease(sample.message)));
        })?,
        session.subscribe(node, &status.for_robot(robot), status.qos, move |sample| {
            drop(to_controller.send(Input::Controller(sample.message)));
        })?,
        listen_to_commands(session, node, robot, commands, received.clone())?,
    ])
}

/// Starts to listen to the e-stop.
pub fn listen_to_e_stop(
    session: &Session,
    node: &NodeHandle,
    received: &UnboundedSender<Input>,
) -> Result<EStopSubscriptions, SessionError> {
    let received = received.clone();
    EStopSubscriptions::new(session, node, move |message| {
        // The receiver is gone only while the node shuts down.
        drop(received.send(Input::EStop(message)));
    })
}

fn listen_to_commands(
    session: &Session,
    node: &NodeHandle,
    robot: &str,
    commands: Commands,
    received: UnboundedSender<Input>,
) -> Result<Subscription, SessionError> {
    match commands {
        Commands::Stamped => {
            let topic = topics::CMD_VEL;
            session.subscribe(node, &topic.for_robot(robot), topic.qos, move |sample| {
                let stamped: TwistStamped = sample.message;
                drop(received.send(Input::Command(stamped.twist)));
            })
        }
        Commands::Unstamped => {
            let topic = topics::CMD_VEL_UNSTAMPED;
            session.subscribe(node, &topic.for_robot(robot), topic.qos, move |sample| {
                drop(received.send(Input::Command(sample.message)));
            })
        }
    }
}
