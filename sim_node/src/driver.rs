//! Samples and timers in, steps of the world out.

use std::time::{Duration, Instant};

use rsrs_fleet::robot;
use rsrs_fleet::simulator::{Action, Event, Simulator};
use rsrs_msgs::geometry_msgs::TwistStamped;
use rsrs_msgs::rsrs::{Recorded, RobotStatus, RunLease, WorldDigest};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics;
use rsrs_ros::clock::ClockPublisher;
use rsrs_ros::logging::Level;
use rsrs_ros::node_arguments::NodeArguments;
use rsrs_ros::parameters::{Arming, ParameterServer};
use rsrs_ros::session::{NodeHandle, Publisher, Session, Subscription};
use rsrs_ros::shutdown;
use rsrs_sim::world::World;
use rsrs_wire as wire;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use crate::parameters::{self, NODE};
use crate::robots::VirtualRobot;

/// How often gates are looked at while nothing arrives.
const GLANCE: Duration = Duration::from_millis(20);

/// What reaches the simulator.
enum Heard {
    Lease(RunLease),
    EStop(bool),
    Controller(usize, RobotStatus),
    Command(usize, TwistStamped),
    Recorded(u64),
    Parameters,
}

/// The simulator and its ends of the network.
struct Simulation {
    node: NodeHandle,
    robots: Vec<VirtualRobot>,
    /// Robots of the placed world: the first of `robots`.
    n_placed: usize,
    machine: Simulator,
    world: Option<World>,
    clock: ClockPublisher,
    digest: Publisher<WorldDigest>,
    server: ParameterServer,
    arming: Arming,
    start: Instant,
}

/// Runs the simulator until SIGINT or SIGTERM.
///
/// # Errors
///
/// If the network cannot be used, or a reliable subscriber stops acknowledging.
pub async fn run(options: NodeArguments) -> anyhow::Result<()> {
    let session = Session::open(&options.session)?;
    let (heard, mut events) = unbounded_channel();
    let node = session.node("/", NODE)?;
    let hosted = options.robots.len();
    let changed = heard.clone();
    let server =
        ParameterServer::start(&session, vec![parameters::declare()], move |_, changes| {
            parameters::check(changes, hosted)?;
            changed.send(Heard::Parameters).map_err(|_closed| "shutting down".to_owned())
        })?;
    let mut robots = Vec::new();
    let mut subscriptions = listen(&session, &node, &heard)?;
    for (index, name) in options.robots.iter().enumerate() {
        robots.push(VirtualRobot::new(&session, name)?);
        subscriptions.extend(listen_to_robot(&session, (index, &robots[index]), &heard)?);
    }
    let digest = topics::WORLD_DIGEST;
    let mut simulation = Simulation {
        clock: ClockPublisher::new(&session, &node)?,
        digest: session.publish_on(&node, digest.name, digest.qos)?,
        n_placed: 0,
        arming: Arming::Disarmed,
        machine: Simulator::new(),
        world: None,
        start: Instant::now(),
        node,
        robots,
        server,
    };
    for note in &options.ros.notes {
        simulation.node.say(Level::Warn, &note.to_string());
    }
    simulation.node.say(Level::Info, &format!("{hosted} virtual robots ready"));
    let ended = simulation.serve(&mut events).await;
    drop((subscriptions, simulation));
    session.close().await;
    ended
}

fn listen(
    session: &Session,
    node: &NodeHandle,
    heard: &UnboundedSender<Heard>,
) -> anyhow::Result<Vec<Subscription>> {
    let (to_lease, to_stop, to_recorded) = (heard.clone(), heard.clone(), heard.clone());
    let (lease, e_stop, recorded) = (topics::LEASE, topics::E_STOP, topics::RECORDED);
    // A receiver is gone only while the node shuts down.
    Ok(vec![
        session.subscribe(node, lease.name, lease.qos, move |sample| {
            drop(to_lease.send(Heard::Lease(sample.message)));
        })?,
        session.subscribe(node, e_stop.name, e_stop.qos, move |sample| {
            let engaged: Bool = sample.message;
            drop(to_stop.send(Heard::EStop(engaged.data)));
        })?,
        session.subscribe(node, recorded.name, recorded.qos, move |sample| {
            let recorded: Recorded = sample.message;
            drop(to_recorded.send(Heard::Recorded(recorded.step)));
        })?,
    ])
}

fn listen_to_robot(
    session: &Session,
    (index, robot): (usize, &VirtualRobot),
    heard: &UnboundedSender<Heard>,
) -> anyhow::Result<[Subscription; 2]> {
    let (to_command, to_controller) = (heard.clone(), heard.clone());
    let (cmd_vel, status) = (topics::CMD_VEL, topics::CONTROLLER_STATUS);
    Ok([
        session.subscribe(
            &robot.node,
            &cmd_vel.for_robot(&robot.name),
            cmd_vel.qos,
            move |sample| drop(to_command.send(Heard::Command(index, sample.message))),
        )?,
        session.subscribe(
            &robot.node,
            &status.for_robot(&robot.name),
            status.qos,
            move |sample| {
                drop(to_controller.send(Heard::Controller(index, sample.message)));
            },
        )?,
    ])
}

impl Simulation {
    async fn serve(&mut self, events: &mut UnboundedReceiver<Heard>) -> anyhow::Result<()> {
        let mut glance = tokio::time::interval(GLANCE);
        glance.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
        let mut asked_to_stop = std::pin::pin!(shutdown::requested());
        loop {
            tokio::select! {
                request = &mut asked_to_stop => {
                    request?;
                    return Ok(());
                }
                Some(heard) = events.recv() => self.hear(heard).await?,
                _ = glance.tick() => self.all_robots(&robot::Event::Tick).await?,
            }
            let now = self.start.elapsed();
            let placed = &self.robots[..self.n_placed];
            let is_bound = placed.iter().any(|robot| robot.is_bound(now));
            let arming = if is_bound { Arming::Armed } else { Arming::Disarmed };
            let permitted = !placed.is_empty() && placed.iter().all(|robot| robot.may_move(now));
            self.advance(Event::Permission(permitted)).await?;
            self.hold_parameters(arming)?;
        }
    }

    /// Nobody replaces the world of a run that holds its robots.
    fn hold_parameters(&mut self, arming: Arming) -> anyhow::Result<()> {
        if arming != self.arming {
            self.arming = arming;
            self.server.set_arming(self.node.full_name(), arming)?;
        }
        Ok(())
    }

    async fn hear(&mut self, heard: Heard) -> anyhow::Result<()> {
        let now = self.start.elapsed();
        match heard {
            Heard::Lease(message) => match wire::lease(message) {
                Ok(lease) => self.all_robots(&robot::Event::Lease(lease)).await,
                Err(error) => {
                    self.node.say(Level::Warn, &format!("refused: {error}"));
                    Ok(())
                }
            },
            Heard::EStop(engaged) => self.all_robots(&robot::Event::EStop(engaged)).await,
            Heard::Controller(index, status) => {
                let parameter_digest = status.parameter_digest;
                self.robots[index]
                    .on_event(robot::Event::Controller { parameter_digest }, now)
                    .await
            }
            Heard::Command(index, message) => self.command(index, &message).await,
            Heard::Recorded(step) => self.advance(Event::Recorded { step }).await,
            Heard::Parameters => self.place().await,
        }
    }

    async fn all_robots(&mut self, event: &robot::Event) -> anyhow::Result<()> {
        let now = self.start.elapsed();
        for robot in &mut self.robots {
            robot.on_event(event.clone(), now).await?;
        }
        Ok(())
    }

    async fn command(&mut self, robot: usize, message: &TwistStamped) -> anyhow::Result<()> {
        match wire::command(&message.twist) {
            Ok(command) => {
                let stamp_ns = message.header.stamp.to_nanos();
                self.advance(Event::Command { robot, stamp_ns, command }).await
            }
            Err(error) => {
                self.robots[robot].node.say(Level::Warn, &format!("refused: {error}"));
                Ok(())
            }
        }
    }

    /// Places the world that the parameters ask for; a run that is under way ends with it.
    async fn place(&mut self) -> anyhow::Result<()> {
        match parameters::wanted(&self.server, self.robots.len()) {
            Ok(Some(wanted)) => {
                let n_robots = wanted.world.n_robots();
                self.n_placed = n_robots;
                self.world = Some(wanted.world);
                let (steps, period_ns) = (wanted.steps, wanted.period_ns);
                self.advance(Event::Placed { n_robots, steps, period_ns }).await
            }
            Ok(None) => {
                self.world = None;
                self.n_placed = 0;
                Ok(())
            }
            Err(error) => {
                self.world = None;
                self.n_placed = 0;
                self.node.say(Level::Error, &format!("no world is placed: {error}"));
                Ok(())
            }
        }
    }

    /// Lets the machine take an event, and does what follows.
    async fn advance(&mut self, event: Event) -> anyhow::Result<()> {
        for action in self.machine.on_event(event, self.start.elapsed()) {
            match action {
                Action::Sense { step, stamp_ns } => self.sense(step, stamp_ns).await?,
                Action::Advance { commands } => {
                    self.world
                        .as_mut()
                        .expect("only a placed world is advanced")
                        .advance(&commands);
                }
                Action::Refuse { robot, reason } => {
                    self.robots[robot].node.say(Level::Warn, &format!("refused: {reason}"));
                }
                Action::Complete => self.node.say(Level::Info, "all steps are made"),
                Action::Void { reason } => {
                    self.node.say(Level::Error, &format!("run is void: {reason}"));
                }
            }
        }
        Ok(())
    }

    /// Publishes one step: the clock first, then detections, then poses, then the digest.
    async fn sense(&mut self, step: u64, stamp_ns: u64) -> anyhow::Result<()> {
        let world = self.world.as_mut().expect("only a placed world is sensed");
        self.clock.publish(stamp_ns).await?;
        let digest = world.digest();
        let detections = world.sense().to_vec();
        for (robot, data) in self.robots.iter().zip(detections) {
            robot.publish_detection(Bool { data }).await?;
        }
        for (robot, pose) in self.robots.iter().zip(world.poses()) {
            robot.publish_pose(pose, stamp_ns).await?;
        }
        Ok(self.digest.publish(WorldDigest { step, digest }).await?)
    }
}
