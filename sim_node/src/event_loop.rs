//! Samples and timers in, steps of the world out.

mod placing;

use std::time::{Duration, Instant};

use anyhow::Context;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_fleet::e_stop::Locks;
use rsrs_fleet::experiment::Time as TimeMode;
use rsrs_fleet::message::Lease;
use rsrs_fleet::parameters::simulator::FULL_NAME;
use rsrs_fleet::robot;
use rsrs_fleet::simulator::{Action, Event, Gate, Simulator};
use rsrs_fleet::timing::TICK;
use rsrs_fleet::wire;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::{PoseStamped, Twist};
use rsrs_msgs::rosgraph_msgs::Clock;
use rsrs_msgs::rsrs::{RobotStatus, WorldDigest};
use rsrs_msgs::simulation_interfaces::{Result as Outcome, StepSimulationResponse};
use rsrs_msgs::topics;
use rsrs_ros::clock::wall_time;
use rsrs_ros::complaints::Complaints;
use rsrs_ros::e_stop::LocksPublisher;
use rsrs_ros::logging::Level;
use rsrs_ros::node_arguments::NodeArguments;
use rsrs_ros::parameters::{Arming, ParameterServer};
use rsrs_ros::runtime::beat;
use rsrs_ros::services::{Responder, Service};
use rsrs_ros::session::{NodeHandle, Publisher, Session};
use rsrs_ros::shutdown;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use crate::NODE;
use crate::display::Display;
use crate::mixed::RealRobots;
use crate::parameters;
use crate::placed_world::{PlacedWorld, Sensed};
use crate::robots::VirtualRobot;
use crate::services;
use crate::subscriptions::{Input, Subscriptions};
use crate::virtual_pose_publisher::VirtualPosePublisher;

/// How often, before a run in real time, controllers are asked whether they stamp their commands.
const LOOK_AROUND: Duration = Duration::from_secs(1);

/// The simulator and its ends of the network.
pub struct Simulation<'a> {
    session: &'a Session,
    node: NodeHandle,
    /// Names of the robots that it stands in for.
    hosted: Vec<String>,
    robots: Vec<VirtualRobot>,
    subscriptions: Subscriptions,
    to_me: UnboundedSender<Input>,
    real: RealRobots,
    /// Of each object of the placed world.
    objects: Vec<Publisher<PoseStamped>>,
    /// Publishes the poses of virtual robots together with the tracker's, if one follows real robots.
    virtual_pose_publisher: Option<VirtualPosePublisher>,
    display: Display,
    _services: Vec<Service>,
    /// Who waits for steps.
    pub(crate) steps: Option<Step>,
    /// Whether this program was requested to end.
    pub(crate) is_quitting: bool,
    pub(crate) machine: Simulator,
    pub(crate) placed_world: Option<PlacedWorld>,
    /// Simulated time of the last step, in nanoseconds; `None` in real time.
    pub(crate) stamp_ns: Option<u64>,
    clock: Publisher<Clock>,
    digest: Publisher<WorldDigest>,
    status: Publisher<RobotStatus>,
    server: ParameterServer,
    /// What robots of a cell are that is set by hand.
    profile: RobotProfile,
    locks: LocksPublisher,
    arming: Arming,
    pub(crate) start: Instant,
    complaints: Complaints,
    looked_around: Instant,
    sensed_nothing: Instant,
}

/// Steps that a client waits for.
pub struct Step {
    /// How many.
    pub asked: u64,
    /// The client.
    pub responder: Responder<StepSimulationResponse>,
}

/// Runs the simulator until SIGINT or SIGTERM.
pub async fn run(options: NodeArguments) -> anyhow::Result<()> {
    let session = Session::open_with(&options.session, &options.ros)?;
    let (received, mut events) = unbounded_channel();
    let mut simulation = Simulation::new(&session, &options, received)?;
    for note in &options.ros.notes {
        simulation.node.log(note.level(), &note.to_string());
    }
    let hosted = options.robots.len();
    simulation.node.log(Level::Info, &format!("{hosted} virtual robots ready"));
    let ended = tokio::select! {
        ended = simulation.serve(&mut events) => ended,
        ended = session.ended() => Err(ended.into()),
    };
    drop(simulation);
    session.close().await;
    ended
}

/// Serves the parameters, and reports every change.
fn serve_parameters(
    session: &Session,
    options: &NodeArguments,
    received: &UnboundedSender<Input>,
) -> anyhow::Result<(ParameterServer, RobotProfile)> {
    let hosted = options.robots.clone();
    let given = options.ros.parameters(FULL_NAME);
    let starts: Vec<_> = given.clone().into_iter().collect();
    let profile = parameters::profile(&given)?;
    parameters::check(&starts, &hosted, &profile).context("start value of a parameter")?;
    let (changed, of_cells) = (received.clone(), profile.clone());
    let server =
        ParameterServer::start(session, vec![parameters::declare(given)?], move |_, changes| {
            parameters::check(changes, &hosted, &of_cells).map_err(|error| error.to_string())?;
            changed.send(Input::Parameters).map_err(|_closed| "shutting down".to_owned())
        })?;
    // Start values may ask for a world.
    drop(received.send(Input::Parameters));
    Ok((server, profile))
}

fn step_response(left: u64, asked: u64) -> StepSimulationResponse {
    let result = if left == 0 {
        services::done()
    } else {
        let text = format!("{left} of {asked} steps were not made: the world was stopped");
        services::outcome(Outcome::OPERATION_FAILED, &text)
    };
    StepSimulationResponse { result }
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
        received: UnboundedSender<Input>,
    ) -> anyhow::Result<Self> {
        let node = session.node("/", NODE)?;
        let (server, profile) = serve_parameters(session, options, &received)?;
        let gates = parameters::gates(&server);
        let robots = options
            .robots
            .iter()
            .map(|name| VirtualRobot::new(session, &node, name, gates))
            .collect::<anyhow::Result<Vec<_>>>()?;
        let (digest, status) = (topics::WORLD_DIGEST, topics::SIMULATOR_STATUS);
        // The receiver is gone only while the node shuts down.
        let to_me = received.clone();
        let manual_call = move |call| drop(to_me.send(Input::Call(call)));
        Ok(Self {
            session,
            hosted: options.robots.clone(),
            profile,
            display: Display::new(session, &node)?,
            _services: services::offer(session, &node, manual_call)?,
            subscriptions: Subscriptions::new(session, &node, &robots, received.clone())?,
            to_me: received,
            real: RealRobots::default(),
            objects: Vec::new(),
            virtual_pose_publisher: None,
            steps: None,
            is_quitting: false,
            stamp_ns: None,
            robots,
            machine: Simulator::new(),
            placed_world: None,
            clock: session.publish_on(&node, topics::CLOCK.name, topics::CLOCK.qos)?,
            digest: session.publish_on(&node, digest.name, digest.qos)?,
            status: session.publish_on(&node, status.name, status.qos)?,
            locks: LocksPublisher::new(session, &node)?,
            server,
            arming: Arming::Disarmed,
            start: Instant::now(),
            looked_around: Instant::now(),
            complaints: Complaints::default(),
            sensed_nothing: Instant::now(),
            node,
        })
    }

    async fn serve(&mut self, events: &mut UnboundedReceiver<Input>) -> anyhow::Result<()> {
        let mut tick = beat(TICK);
        let mut asked_to_stop = std::pin::pin!(shutdown::requested());
        while !self.is_quitting {
            let due = self.machine.due().map(|due| self.start + due);
            tokio::select! {
                request = &mut asked_to_stop => {
                    request?;
                    return Ok(());
                }
                Some(received) = events.recv() => self.receive(received).await?,
                _ = tick.tick() => {
                    self.all_robots(&robot::Event::Tick).await?;
                    self.look_around()?;
                    self.sense_nothing().await?;
                    self.display.look_around(self.session).await;
                }
                () = until(due) => {}
            }
            self.look_at_gates().await?;
            let locks = self.robots.iter().flat_map(|robot| robot.locks().0).collect();
            self.locks.publish(Locks(locks)).await?;
        }
        Ok(())
    }

    async fn look_at_gates(&mut self) -> anyhow::Result<()> {
        if self.machine.due().is_some() {
            // What lapses in real time stops for good, before the world is notified.
            self.all_robots(&robot::Event::Tick).await?;
        }
        let now = self.start.elapsed();
        let gates: Vec<Gate> = self.placed_robots().iter().map(|robot| robot.gate(now)).collect();
        let is_bound = gates.iter().any(|gate| gate.is_in_run);
        let arming = if is_bound { Arming::Armed } else { Arming::Disarmed };
        self.advance(Event::Gates(gates)).await?;
        self.hold_parameters(arming)
    }

    fn placed_robots(&self) -> &[VirtualRobot] {
        &self.robots[..self
            .placed_world
            .as_ref()
            .map_or(0, |placed_world| placed_world.placed.robots.len())]
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
            self.subscriptions.follow_types(self.session, &self.robots, TimeMode::RealTime)?;
        }
        Ok(())
    }

    async fn receive(&mut self, received: Input) -> anyhow::Result<()> {
        let now = self.start.elapsed();
        match received {
            Input::Lease(message) => match wire::lease(message) {
                Ok(lease) => self.give_lease(&lease, now).await,
                Err(error) => {
                    self.complaints.warn(&self.node, &format!("refused: {error}"));
                    Ok(())
                }
            },
            Input::EStop(message) => self.all_robots(&robot::Event::EStop(message)).await,
            Input::Controller(index, status) => self.receive_controller(index, status, now).await,
            Input::Command { robot, stamp_ns, twist } => {
                self.command(robot, stamp_ns, &twist).await
            }
            Input::Recorded(step) => self.advance(Event::Recorded { step }).await,
            Input::Parameters => self.place().await,
            Input::Pose { robot, header, pose } => {
                if let Some(virtual_pose_publisher) = &mut self.virtual_pose_publisher {
                    virtual_pose_publisher.follow(robot, &header).await?;
                }
                // A pose of a world before this one may still come.
                let placed_world = self.placed_world.as_mut();
                if let Some(robot) =
                    placed_world.and_then(|placed_world| placed_world.followed.get_mut(robot))
                {
                    robot.receive(pose);
                }
                Ok(())
            }
            Input::Call(call) => self.answer(call).await,
        }
    }

    async fn receive_controller(
        &mut self,
        index: usize,
        message: RobotStatus,
        now: Duration,
    ) -> anyhow::Result<()> {
        let robot = &mut self.robots[index];
        match wire::status(message) {
            Ok(status) => robot.on_event(robot::Event::Controller(status), now).await,
            Err(error) => {
                robot.warn(&format!("refused: {error}"));
                Ok(())
            }
        }
    }

    /// Gives each robot that a lease names what is for it.
    async fn give_lease(&mut self, lease: &Lease, now: Duration) -> anyhow::Result<()> {
        let of_each = lease.of_each(self.robots.iter().map(|robot| robot.name.as_str()));
        for (robot, lease) in self.robots.iter_mut().zip(of_each) {
            if let Some(lease) = lease {
                robot.on_event(robot::Event::Lease(lease), now).await?;
            }
        }
        Ok(())
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
        robot: usize,
        stamp_ns: Option<u64>,
        twist: &Twist,
    ) -> anyhow::Result<()> {
        match wire::command(twist) {
            Ok(command) => self.advance(Event::Command { robot, stamp_ns, command }).await,
            Err(error) => {
                self.robots[robot].warn(&format!("refused: {error}"));
                Ok(())
            }
        }
    }

    /// Lets the machine take an event, and does what follows.
    async fn advance(&mut self, event: Event) -> anyhow::Result<()> {
        let actions = self.machine.on_event(event, self.start.elapsed());
        self.act(actions).await
    }

    /// Carries out an action of the machine.
    pub(crate) async fn act(&mut self, actions: Vec<Action>) -> anyhow::Result<()> {
        for action in actions {
            match action {
                Action::Sense { step, stamp_ns } => self.sense(step, stamp_ns).await?,
                Action::Advance { commands } => self.placed_world().advance(commands),
                Action::AdvanceFreely => self.placed_world().advance_freely(),
                Action::Stepped { left } => self.stepped(left),
                Action::Obey { robot, command } => {
                    let now = self.start.elapsed();
                    self.robots[robot].on_event(robot::Event::Command(command), now).await?;
                }
                Action::Refuse { robot, reason } => {
                    self.robots[robot].warn(&format!("refused: {reason}"));
                }
                Action::Overrun { missed } => {
                    let text = format!("too slow for real time: {missed} periods left out so far");
                    self.node.log(Level::Warn, &text);
                }
                Action::Complete { reason } => {
                    self.placed_world().stand();
                    self.node.log(Level::Info, &format!("the run is over: {reason}"));
                }
                Action::Void { reason } => {
                    self.node.log(Level::Error, &format!("run is void: {reason}"));
                }
                Action::Status(mut status) => {
                    // Whose run it is that it reports on.
                    let run_id = self.placed_robots().iter().find_map(VirtualRobot::run_id);
                    status.run_id = run_id.unwrap_or_default().to_owned();
                    self.status.publish(wire::status_message(&status, wall_time())).await?;
                }
            }
        }
        Ok(())
    }

    fn placed_world(&mut self) -> &mut PlacedWorld {
        self.placed_world.as_mut().expect("the machine moves only worlds that were placed")
    }

    /// Answers the clients that requested steps.
    fn stepped(&mut self, left: u64) {
        let Some(Step { asked, responder }) = self.steps.take() else { return };
        responder.send(step_response(left, asked));
    }

    /// Publishes one step: the clock first, then detections, then poses of robots and of objects, then the digest.
    async fn sense(&mut self, step: u64, stamp_ns: Option<u64>) -> anyhow::Result<()> {
        let placed_world =
            self.placed_world.as_mut().expect("the machine senses only worlds that were placed");
        self.stamp_ns = stamp_ns;
        if let Some(stamp_ns) = stamp_ns {
            self.clock.publish(Clock { clock: Time::from_nanos(stamp_ns) }).await?;
        }
        let stamp = stamp_ns.map_or_else(wall_time, Time::from_nanos);
        let Sensed { digest, ours, virtual_detections, objects_m } = placed_world.sense();
        for (robot, (readings, _)) in self.robots.iter().zip(&ours) {
            robot.publish_readings(*readings).await?;
        }
        self.real.publish(&virtual_detections).await?;
        for robot in placed_world
            .followed
            .iter_mut()
            .filter_map(|robot| robot.falls_silent().then_some(robot.row))
        {
            let name = &placed_world.rows.names[robot];
            self.node.log(Level::Warn, &format!("no pose of {name} comes any more, or none yet"));
        }
        for (robot, (_, motion)) in self.robots.iter().zip(&ours) {
            robot.publish_motion(*motion, stamp).await?;
        }
        for (object, place_m) in self.objects.iter().zip(objects_m) {
            object.publish(wire::object_pose(place_m, stamp)).await?;
        }
        if let Some(virtual_pose_publisher) = &mut self.virtual_pose_publisher {
            virtual_pose_publisher.step(ours.iter().map(|(_, motion)| motion.pose));
        }
        self.digest.publish(WorldDigest { step, digest }).await?;
        let world_ns = stamp.to_nanos().unwrap_or(0);
        if self.display.is_due(world_ns) {
            let label = self.display.label(&placed_world.history).await;
            self.display.show(placed_world.scene(stamp, &label), world_ns);
        }
        Ok(())
    }
}
