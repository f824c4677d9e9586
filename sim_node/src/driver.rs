//! Samples and timers in, steps of the world out.

use std::time::{Duration, Instant};

use anyhow::Context;
use rsrs_core::controller::Command;
use rsrs_fleet::experiment::Time as Pace;
use rsrs_fleet::message::RobotState;
use rsrs_fleet::robot;
use rsrs_fleet::simulator::{Action, Event, Gate, Placed, Simulator};
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::Twist;
use rsrs_msgs::rsrs::{RobotStatus, WorldDigest};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics;
use rsrs_ros::clock::{ClockPublisher, wall_time};
use rsrs_ros::logging::Level;
use rsrs_ros::node_arguments::NodeArguments;
use rsrs_ros::parameters::{Arming, ParameterServer};
use rsrs_ros::session::{NodeHandle, Publisher, Session};
use rsrs_ros::shutdown;
use rsrs_sim::world::World;
use rsrs_wire as wire;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use crate::listening::{Ears, Heard};
use crate::parameters::{self, NODE, Wanted};
use crate::robots::{Motion, VirtualRobot};

/// How often gates are looked at while nothing arrives.
const GLANCE: Duration = Duration::from_millis(20);

/// How often, before a run in real time, controllers are asked whether they stamp their commands.
const LOOK_AROUND: Duration = Duration::from_secs(1);

/// The simulator and its ends of the network.
struct Simulation<'a> {
    session: &'a Session,
    node: NodeHandle,
    robots: Vec<VirtualRobot>,
    ears: Ears,
    machine: Simulator,
    stage: Option<Stage>,
    clock: ClockPublisher,
    digest: Publisher<WorldDigest>,
    status: Publisher<RobotStatus>,
    server: ParameterServer,
    arming: Arming,
    start: Instant,
    looked_around: Instant,
}

/// A placed world. Its robots are the first of the simulator's.
struct Stage {
    world: World,
    placed: Placed,
    /// What each robot does; shape `[n_robots]`.
    obeyed: Vec<Command>,
}

/// Runs the simulator until SIGINT or SIGTERM.
///
/// # Errors
///
/// If the network cannot be used, a start value of a parameter is wrong, or a reliable subscriber
/// stops acknowledging.
pub async fn run(options: NodeArguments) -> anyhow::Result<()> {
    let session = Session::open(&options.session)?;
    let (heard, mut events) = unbounded_channel();
    let mut simulation = Simulation::new(&session, &options, heard)?;
    for note in &options.ros.notes {
        simulation.node.say(Level::Warn, &note.to_string());
    }
    let hosted = options.robots.len();
    simulation.node.say(Level::Info, &format!("{hosted} virtual robots ready"));
    let ended = simulation.serve(&mut events).await;
    drop(simulation);
    session.close().await;
    ended
}

/// Serves the parameters, and tells of every change.
fn serve_parameters(
    session: &Session,
    options: &NodeArguments,
    heard: &UnboundedSender<Heard>,
) -> anyhow::Result<ParameterServer> {
    let hosted = options.robots.len();
    let given = options.ros.parameters(parameters::FULL_NAME);
    let starts: Vec<_> = given.clone().into_iter().collect();
    parameters::check(&starts, hosted).context("start value of a parameter")?;
    let changed = heard.clone();
    let server =
        ParameterServer::start(session, vec![parameters::declare(given)?], move |_, changes| {
            parameters::check(changes, hosted).map_err(|error| error.to_string())?;
            changed.send(Heard::Parameters).map_err(|_closed| "shutting down".to_owned())
        })?;
    // Start values may ask for a world.
    drop(heard.send(Heard::Parameters));
    Ok(server)
}

async fn until(due: Option<Instant>) {
    match due {
        Some(due) => tokio::time::sleep_until(due.into()).await,
        None => std::future::pending().await,
    }
}

impl<'a> Simulation<'a> {
    fn new(
        session: &'a Session,
        options: &NodeArguments,
        heard: UnboundedSender<Heard>,
    ) -> anyhow::Result<Self> {
        let node = session.node("/", NODE)?;
        let server = serve_parameters(session, options, &heard)?;
        let robots = options
            .robots
            .iter()
            .map(|name| VirtualRobot::new(session, name))
            .collect::<anyhow::Result<Vec<_>>>()?;
        let (digest, status) = (topics::WORLD_DIGEST, topics::SIMULATOR_STATUS);
        Ok(Self {
            session,
            ears: Ears::new(session, &node, &robots, heard)?,
            robots,
            machine: Simulator::new(),
            stage: None,
            clock: ClockPublisher::new(session, &node)?,
            digest: session.publish_on(&node, digest.name, digest.qos)?,
            status: session.publish_on(&node, status.name, status.qos)?,
            server,
            arming: Arming::Disarmed,
            start: Instant::now(),
            looked_around: Instant::now(),
            node,
        })
    }

    async fn serve(&mut self, events: &mut UnboundedReceiver<Heard>) -> anyhow::Result<()> {
        let mut glance = tokio::time::interval(GLANCE);
        glance.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
        let mut asked_to_stop = std::pin::pin!(shutdown::requested());
        loop {
            let due = self.machine.due().map(|due| self.start + due);
            tokio::select! {
                request = &mut asked_to_stop => {
                    request?;
                    return Ok(());
                }
                Some(heard) = events.recv() => self.hear(heard).await?,
                _ = glance.tick() => {
                    self.all_robots(&robot::Event::Tick).await?;
                    self.look_around()?;
                }
                () = until(due) => {}
            }
            self.look_at_gates().await?;
        }
    }

    async fn look_at_gates(&mut self) -> anyhow::Result<()> {
        if self.machine.due().is_some() {
            // What lapses in real time stops for good, before the world hears of it.
            self.all_robots(&robot::Event::Tick).await?;
        }
        let now = self.start.elapsed();
        let gates: Vec<Gate> = self.placed_robots().iter().map(|robot| robot.gate(now)).collect();
        let is_bound =
            gates.iter().any(|gate| matches!(gate.state, RobotState::Armed | RobotState::Moving));
        let arming = if is_bound { Arming::Armed } else { Arming::Disarmed };
        self.advance(Event::Gates(gates)).await?;
        self.hold_parameters(arming)
    }

    fn placed_robots(&self) -> &[VirtualRobot] {
        &self.robots[..self.stage.as_ref().map_or(0, |stage| stage.placed.n_robots)]
    }

    /// Nobody replaces the world of a run that holds its robots.
    fn hold_parameters(&mut self, arming: Arming) -> anyhow::Result<()> {
        if arming != self.arming {
            self.arming = arming;
            self.server.set_arming(self.node.full_name(), arming)?;
        }
        Ok(())
    }

    /// Before a run in real time, finds out who stamps commands.
    fn look_around(&mut self) -> anyhow::Result<()> {
        let is_idle =
            self.arming == Arming::Disarmed && self.looked_around.elapsed() >= LOOK_AROUND;
        if is_idle && self.machine.due().is_some() {
            self.looked_around = Instant::now();
            self.ears.follow_types(self.session, &self.robots, Pace::RealTime)?;
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
            Heard::Command { robot, stamp_ns, twist } => {
                self.command((robot, stamp_ns), &twist).await
            }
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

    async fn command(
        &mut self,
        (robot, stamp_ns): (usize, Option<u64>),
        twist: &Twist,
    ) -> anyhow::Result<()> {
        match wire::command(twist) {
            Ok(command) => self.advance(Event::Command { robot, stamp_ns, command }).await,
            Err(error) => {
                self.robots[robot].node.say(Level::Warn, &format!("refused: {error}"));
                Ok(())
            }
        }
    }

    /// Places the world that the parameters ask for; a run that is under way ends with it.
    async fn place(&mut self) -> anyhow::Result<()> {
        self.stage = None;
        match parameters::wanted(&self.server, self.robots.len()) {
            Ok(Some(Wanted { world, placed })) => {
                for robot in &mut self.robots[..placed.n_robots] {
                    robot.join(placed.time, Duration::from_nanos(placed.period_ns));
                }
                self.ears.follow_types(self.session, &self.robots, placed.time)?;
                let obeyed = vec![Command::STOP; placed.n_robots];
                self.stage = Some(Stage { world, placed, obeyed });
                self.advance(Event::Placed(placed)).await
            }
            Ok(None) => self.advance(Event::Removed).await,
            Err(error) => {
                self.node.say(Level::Error, &format!("no world is placed: {error}"));
                self.advance(Event::NotPlaced { reason: error.to_string() }).await
            }
        }
    }

    /// Lets the machine take an event, and does what follows.
    async fn advance(&mut self, event: Event) -> anyhow::Result<()> {
        for action in self.machine.on_event(event, self.start.elapsed()) {
            match action {
                Action::Sense { step, stamp_ns } => self.sense(step, stamp_ns).await?,
                Action::Advance { commands } => self.stage().advance(commands),
                Action::Obey { robot, command } => {
                    let now = self.start.elapsed();
                    self.robots[robot].on_event(robot::Event::Command(command), now).await?;
                }
                Action::Refuse { robot, reason } => {
                    self.robots[robot].node.say(Level::Warn, &format!("refused: {reason}"));
                }
                Action::Overrun { missed } => {
                    let text = format!("too slow for real time: {missed} periods left out so far");
                    self.node.say(Level::Warn, &text);
                }
                Action::Complete { reason } => {
                    self.stage().obeyed.fill(Command::STOP);
                    self.node.say(Level::Info, &format!("the run is over: {reason}"));
                }
                Action::Void { reason } => {
                    self.node.say(Level::Error, &format!("run is void: {reason}"));
                }
                Action::Status(status) => {
                    self.status.publish(wire::status_message(&status, wall_time())).await?;
                }
            }
        }
        Ok(())
    }

    fn stage(&mut self) -> &mut Stage {
        self.stage.as_mut().expect("the machine moves only worlds that were placed")
    }

    /// Publishes one step: the clock first, then detections, then poses, then the digest.
    async fn sense(&mut self, step: u64, stamp_ns: Option<u64>) -> anyhow::Result<()> {
        let stage = self.stage.as_mut().expect("the machine senses only worlds that were placed");
        if let Some(stamp_ns) = stamp_ns {
            self.clock.publish(stamp_ns).await?;
        }
        let stamp = stamp_ns.map_or_else(wall_time, Time::from_nanos);
        let digest = stage.world.digest();
        let detections = stage.world.sense().to_vec();
        for (robot, data) in self.robots.iter().zip(detections) {
            robot.publish_detection(Bool { data }).await?;
        }
        for ((robot, pose), command) in
            self.robots.iter().zip(stage.world.poses()).zip(&stage.obeyed)
        {
            robot.publish_motion(Motion { pose, command: *command }, stamp).await?;
        }
        Ok(self.digest.publish(WorldDigest { step, digest }).await?)
    }
}

impl Stage {
    fn advance(&mut self, commands: Vec<Command>) {
        self.world.advance(&commands);
        self.obeyed = commands;
    }
}
