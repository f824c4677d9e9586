//! What the robot node receives from the network.

use rsrs_fleet::e_stop::Message;
use rsrs_fleet::fleet_file::CmdVel;
use rsrs_msgs::geometry_msgs::Twist;
use rsrs_msgs::rsrs::{RobotStatus, RunLease};
use rsrs_msgs::topics;
use rsrs_ros::cmd_vel;
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

/// Starts to listen.
pub fn listen(
    session: &Session,
    node: &NodeHandle,
    robot: &str,
    commands: CmdVel,
    received: &UnboundedSender<Input>,
) -> Result<[Subscription; 3], SessionError> {
    let (to_lease, to_controller, to_commands) =
        (received.clone(), received.clone(), received.clone());
    let (lease, status) = (topics::LEASE, topics::CONTROLLER_STATUS);
    // In all of these, the receiver is gone only while the node shuts down.
    Ok([
        session.subscribe(node, lease.name, lease.qos, move |sample| {
            drop(to_lease.send(Input::Lease(sample.message)));
        })?,
        session.subscribe(node, &status.for_robot(robot), status.qos, move |sample| {
            drop(to_controller.send(Input::Controller(sample.message)));
        })?,
        cmd_vel::subscribe(session, node, robot, commands.topic(), move |twist, _stamp| {
            drop(to_commands.send(Input::Command(twist)));
        })?,
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
