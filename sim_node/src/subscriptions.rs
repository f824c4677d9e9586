//! What the simulator receives, and from which topics.

use std::collections::BTreeSet;

use rsrs_core::robot::unicycle::Pose;
use rsrs_fleet::e_stop::Message;
use rsrs_fleet::experiment::Time as TimeMode;
use rsrs_msgs::geometry_msgs::Twist;
use rsrs_msgs::rsrs::{Recorded, RobotStatus, RunLease};
use rsrs_msgs::std_msgs::Header;
use rsrs_msgs::topics::{self, Topic};
use rsrs_ros::cmd_vel;
use rsrs_ros::e_stop::EStopSubscriptions;
use rsrs_ros::session::{EndpointKind, NodeHandle, Session, Subscription};
use tokio::sync::mpsc::UnboundedSender;

use crate::robots::VirtualRobot;
use crate::services::Call;

/// What reaches the simulator.
pub enum Input {
    /// A lease.
    Lease(RunLease),
    /// The e-stop.
    EStop(Message),
    /// A status of the controller of a robot.
    Controller(usize, RobotStatus),
    /// A velocity command for a robot, and its stamp in nanoseconds, if it has one.
    Command {
        /// Index of the robot.
        robot: usize,
        /// The stamp.
        stamp_ns: Option<u64>,
        /// The command.
        twist: Twist,
    },
    /// The recorder has taken every topic up to this step.
    Recorded(u64),
    /// Parameters were changed.
    Parameters,
    /// Where a real robot is.
    Pose {
        /// Index among the real robots of the world.
        robot: usize,
        /// When its source saw it there, and what it calls the frame of the world.
        header: Header,
        /// Its pose in the frame of the world.
        pose: Pose,
    },
    /// A request of manual control.
    Call(Call),
}

/// Everything that the simulator subscribes to, until it is dropped.
pub struct Subscriptions {
    received: UnboundedSender<Input>,
    commands: Vec<Commands>,
    _others: Vec<Subscription>,
    _e_stop: EStopSubscriptions,
}

/// The velocity commands of one robot. They have one of two types, and the middleware matches
/// topics by name alone, so only one of them is subscribed to at a time.
struct Commands {
    topic: Topic,
    _subscription: Subscription,
}

impl Subscriptions {
    /// Subscribes for the swarm and for each robot, whose commands are stamped until
    /// [`Subscriptions::follow_types`] selects others.
    pub fn new(
        session: &Session,
        node: &NodeHandle,
        robots: &[VirtualRobot],
        received: UnboundedSender<Input>,
    ) -> anyhow::Result<Self> {
        let mut others = listen(session, node, &received)?;
        let mut commands = Vec::new();
        for (index, robot) in robots.iter().enumerate() {
            let [stamped, _] = robot.command_topics();
            commands.push(listen_to_commands(session, index, robot, stamped, &received)?);
            others.push(listen_to_controller(session, index, robot, &received)?);
        }
        let to_stop = received.clone();
        let e_stop = move |message| drop(to_stop.send(Input::EStop(message)));
        let e_stop = EStopSubscriptions::new(session, node, e_stop)?;
        Ok(Self { received, commands, _others: others, _e_stop: e_stop })
    }

    /// Subscribes to commands of the type that each robot's controller publishes: in real time, with
    /// or without a stamp; in lockstep, with one.
    pub fn follow_types(
        &mut self,
        session: &Session,
        robots: &[VirtualRobot],
        pace: TimeMode,
    ) -> anyhow::Result<()> {
        let endpoints = match pace {
            TimeMode::Lockstep => Vec::new(),
            TimeMode::RealTime => session.endpoints(),
        };
        let writers = endpoints.iter().filter(|endpoint| endpoint.kind == EndpointKind::Writer);
        let published: BTreeSet<(&str, &str)> = writers
            .map(|endpoint| (endpoint.topic.as_str(), endpoint.type_name.as_str()))
            .collect();
        for (index, robot) in robots.iter().enumerate() {
            let [stamped, unstamped] = robot.command_topics();
            let name = stamped.for_robot(&robot.name);
            let is_published = |topic: Topic| published.contains(&(name.as_str(), topic.type_name));
            let is_unstamped = is_published(unstamped) && !is_published(stamped);
            let wanted = if is_unstamped { unstamped } else { stamped };
            if self.commands[index].topic != wanted {
                self.commands[index] =
                    listen_to_commands(session, index, robot, wanted, &self.received)?;
            }
        }
        Ok(())
    }
}

// In all of these, the receiver is gone only while the node shuts down.

fn listen(
    session: &Session,
    node: &NodeHandle,
    received: &UnboundedSender<Input>,
) -> anyhow::Result<Vec<Subscription>> {
    let (to_lease, to_recorded) = (received.clone(), received.clone());
    let (lease, recorded) = (topics::LEASE, topics::RECORDED);
    Ok(vec![
        session.subscribe(node, lease.name, lease.qos, move |sample| {
            drop(to_lease.send(Input::Lease(sample.message)));
        })?,
        session.subscribe(node, recorded.name, recorded.qos, move |sample| {
            let recorded: Recorded = sample.message;
            drop(to_recorded.send(Input::Recorded(recorded.step)));
        })?,
    ])
}

fn listen_to_controller(
    session: &Session,
    index: usize,
    robot: &VirtualRobot,
    received: &UnboundedSender<Input>,
) -> anyhow::Result<Subscription> {
    let (received, topic) = (received.clone(), topics::CONTROLLER_STATUS);
    let name = topic.for_robot(&robot.name);
    Ok(session.subscribe(&robot.node, &name, topic.qos, move |sample| {
        drop(received.send(Input::Controller(index, sample.message)));
    })?)
}

fn listen_to_commands(
    session: &Session,
    index: usize,
    robot: &VirtualRobot,
    topic: Topic,
    received: &UnboundedSender<Input>,
) -> anyhow::Result<Commands> {
    let received = received.clone();
    let deliver = move |twist, stamp_ns| {
        drop(received.send(Input::Command { robot: index, stamp_ns, twist }));
    };
    let subscription = cmd_vel::subscribe(session, &robot.node, &robot.name, topic, deliver)?;
    Ok(Commands { topic, _subscription: subscription })
}
