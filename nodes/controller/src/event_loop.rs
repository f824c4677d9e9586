//! Samples and timers in, commands and statuses out.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use rsrs_core::robot::controller::Reaction;
use rsrs_fleet::controller::{Action, Controller, Event, Settings, Stamp, nothing_on};
use rsrs_fleet::e_stop::{Locks, Message};
use rsrs_fleet::timing::{HEARTBEAT_PERIOD, TICK};
use rsrs_fleet::wire;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::rosgraph_msgs::Clock;
use rsrs_msgs::rsrs::{RobotStatus, RunLease};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics;
use rsrs_ros::clock::{since_boot, wall_time};
use rsrs_ros::cmd_vel::CmdVelPublisher;
use rsrs_ros::complaints::Complaints;
use rsrs_ros::e_stop::{EStopSubscriptions, LocksPublisher};
use rsrs_ros::logging::Level;
use rsrs_ros::node_arguments::NodeArguments;
use rsrs_ros::parameters::{Arming, ParameterServer, ParameterValue};
use rsrs_ros::ros_args::Note;
use rsrs_ros::runtime::beat;
use rsrs_ros::session::{NodeHandle, Publisher, Session, Subscription};
use rsrs_ros::shutdown;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use crate::NODE;
use crate::parameters;
use crate::virtual_detection::VirtualDetection;

/// What reaches the controllers: of one robot, or of all.
enum Input {
    Of(usize, Event),
    /// A further reading of a robot, by name.
    Reading(usize, String, bool),
    Virtual(usize, Bool),
    Lease(RunLease),
    Clock(u64),
    EStop(Message),
    ParametersOf(String),
}

/// One hosted controller and its ends of the network.
struct Hosted {
    robot: String,
    machine: Controller,
    node: NodeHandle,
    cmd_vel: CmdVelPublisher,
    status: Publisher<RobotStatus>,
    /// The status of the gate, where it is in the controller.
    gate_status: Option<Publisher<RobotStatus>>,
    arming: Arming,
    /// Whether the robot sees a virtual one, in a mixed fleet.
    virtual_detection: VirtualDetection,
    /// What its controller needs besides `detection`.
    further: BTreeMap<String, (Stamp, Subscription)>,
}

/// A controller that is to be hosted.
#[derive(Clone, Debug, PartialEq)]
pub struct Hosting {
    /// Its robot.
    pub robot: String,
    /// Start values of its parameters by name, from the command line or a parameter file.
    pub given: BTreeMap<String, ParameterValue>,
}

/// Runs a process that hosts controllers only, until SIGINT or SIGTERM.
pub async fn run(options: NodeArguments) -> anyhow::Result<()> {
    let session = Session::open_with(&options.session, &options.ros)?;
    let robots = options.robots.iter().map(|robot| Hosting {
        robot: robot.clone(),
        given: options.ros.parameters(&format!("/{robot}/{NODE}")),
    });
    let ended = serve(&session, robots.collect(), &options.ros.notes).await;
    session.close().await;
    ended
}

/// Runs controllers of one or more robots on a session of the caller until SIGINT or SIGTERM. The
/// first of them logs the notes.
pub async fn serve(session: &Session, robots: Vec<Hosting>, notes: &[Note]) -> anyhow::Result<()> {
    let (received, mut events) = unbounded_channel();
    let (names, declared): (Vec<_>, Vec<_>) = robots
        .into_iter()
        .map(|Hosting { robot, given }| {
            let declared = parameters::declare(&robot, given);
            (robot, declared)
        })
        .unzip();
    let declared = declared.into_iter().collect::<Result<Vec<_>, _>>()?;
    let limits: BTreeMap<String, [f64; 2]> = (declared.iter())
        .map(|node| (format!("{}/{}", node.namespace, node.name), parameters::limits(node)))
        .collect();
    let changed = received.clone();
    let server = ParameterServer::start(session, declared, move |node, changes| {
        limits.get(node).map_or(Ok(()), |limits| parameters::check_table(changes, *limits))?;
        changed
            .send(Input::ParametersOf(node.to_owned()))
            .map_err(|_closed| "the node is shutting down".to_owned())
    })?;
    let mut hosted = Vec::new();
    let mut e_stop = None;
    let mut subscriptions = Vec::new();
    for (index, robot) in names.iter().enumerate() {
        hosted.push(host(session, &server, robot)?);
        let node = &hosted[index].node;
        let reaction = parameters::reaction(&server, node.full_name());
        subscriptions.push(subscribe_detection(session, node, index, robot, reaction, &received)?);
        subscriptions.push(subscribe_virtual_detection(session, node, index, robot, &received)?);
    }
    if let Some(first) = hosted.first() {
        subscriptions.extend(subscribe_lease_and_clock(session, &first.node, &received)?);
        if hosted.iter().any(|controller| controller.machine.gate().is_some()) {
            e_stop = Some(EStop::new(session, &first.node, &received)?);
        }
        for note in notes {
            first.node.log(note.level(), &note.to_string());
        }
        let ready = match &*names {
            [robot] => format!("controller of {robot} ready"),
            _ => format!("{} controllers ready", names.len()),
        };
        first.node.log(Level::Info, &ready);
    }
    tokio::select! {
        ended = run_loop(&mut hosted, (&server, e_stop), (session, &received), &mut events) => ended,
        ended = session.ended() => Err(ended.into()),
    }
}

fn host(session: &Session, server: &ParameterServer, robot: &str) -> anyhow::Result<Hosted> {
    let node = session.node(&format!("/{robot}"), NODE)?;
    let cmd_vel = parameters::cmd_vel(server, node.full_name()).topic();
    let cmd_vel = CmdVelPublisher::new(session, &node, robot, cmd_vel)?;
    let status = topics::CONTROLLER_STATUS;
    let status = session.publish_on(&node, &status.for_robot(robot), status.qos)?;
    let first_counter = wire::first_counter(wall_time());
    let machine = parameters::controller(server, node.full_name(), robot, session.transport())
        .counting_from(first_counter)
        .of_a_new_process();
    let gate_status = if machine.gate().is_some() {
        node.log(Level::Info, "holds the lease: the robot has no gate of ours");
        let topic = topics::STATUS;
        Some(session.publish_on(&node, &topic.for_robot(robot), topic.qos)?)
    } else {
        None
    };
    let (arming, virtual_detection) = (Arming::Disarmed, VirtualDetection::default());
    let robot = robot.to_owned();
    let further = BTreeMap::new();
    Ok(Hosted {
        robot,
        machine,
        node,
        cmd_vel,
        status,
        gate_status,
        arming,
        virtual_detection,
        further,
    })
}

fn subscribe_detection(
    session: &Session,
    node: &NodeHandle,
    index: usize,
    robot: &str,
    reaction: Reaction,
    received: &UnboundedSender<Input>,
) -> anyhow::Result<Subscription> {
    let received = received.clone();
    let topic = topics::DETECTION;
    Ok(session.subscribe(node, &topic.for_robot(robot), topic.qos, move |sample| {
        let detection: Bool = sample.message;
        let is_detected = detection.data || reaction == Reaction::Constant;
        // The receiver is gone only while the node shuts down.
        drop(received.send(Input::Of(index, Event::Detection(is_detected))));
    })?)
}

impl Hosted {
    /// Receives what its controller needs besides `detection`, and nothing else.
    fn follow(
        &mut self,
        session: &Session,
        index: usize,
        received: &UnboundedSender<Input>,
    ) -> anyhow::Result<()> {
        let Settings { controller, stamp, .. } = self.machine.settings();
        let (names, stamp) = (controller.reading_names(), *stamp);
        self.further.retain(|name, (of, _)| names.place(name).is_some() && *of == stamp);
        for name in names.further() {
            if self.further.contains_key(name) {
                continue;
            }
            let (received, reading) = (received.clone(), name.to_owned());
            let topic = topics::further_detection(&self.robot, name);
            let qos = match stamp {
                Stamp::Clock => topics::FURTHER_DETECTION.qos,
                // Robots may publish it as they like, and what is old is of no use.
                Stamp::Wall => topics::DETECTION.qos,
            };
            let subscription = session.subscribe(&self.node, &topic, qos, move |sample| {
                let Bool { data } = sample.message;
                drop(received.send(Input::Reading(index, reading.clone(), data)));
            })?;
            self.further.insert(name.to_owned(), (stamp, subscription));
        }
        Ok(())
    }

    /// The event of a further reading, if its controller needs it.
    #[expect(clippy::fn_params_excessive_bools, reason = "binary is what a reading is")]
    fn reading(&self, name: &str, is_true: bool) -> Option<Event> {
        let reading = self.machine.settings().controller.reading_names().place(name)?;
        Some(Event::Reading { reading, is_true })
    }
}

/// In a mixed fleet the simulator publishes which real robots see virtual ones.
fn subscribe_virtual_detection(
    session: &Session,
    node: &NodeHandle,
    index: usize,
    robot: &str,
    received: &UnboundedSender<Input>,
) -> anyhow::Result<Subscription> {
    let (received, topic) = (received.clone(), topics::VIRTUAL_DETECTION);
    Ok(session.subscribe(node, &topic.for_robot(robot), topic.qos, move |sample| {
        drop(received.send(Input::Virtual(index, sample.message)));
    })?)
}

fn subscribe_lease_and_clock(
    session: &Session,
    node: &NodeHandle,
    received: &UnboundedSender<Input>,
) -> anyhow::Result<[Subscription; 2]> {
    let (to_lease, to_clock) = (received.clone(), received.clone());
    let (lease, clock) = (topics::LEASE, topics::CLOCK);
    Ok([
        session.subscribe(node, lease.name, lease.qos, move |sample| {
            drop(to_lease.send(Input::Lease(sample.message)));
        })?,
        session.subscribe(node, clock.name, clock.qos, move |sample| {
            let clock: Clock = sample.message;
            if let Some(stamp_ns) = clock.clock.to_nanos() {
                drop(to_clock.send(Input::Clock(stamp_ns)));
            }
        })?,
    ])
}

/// The e-stop of controllers that hold leases: it stops them, and publishes their locks for others.
struct EStop {
    locks: LocksPublisher,
    _subscriptions: EStopSubscriptions,
}

impl EStop {
    fn new(
        session: &Session,
        node: &NodeHandle,
        received: &UnboundedSender<Input>,
    ) -> anyhow::Result<Self> {
        let received = received.clone();
        let deliver = move |message| drop(received.send(Input::EStop(message)));
        Ok(Self {
            locks: LocksPublisher::new(session, node)?,
            _subscriptions: EStopSubscriptions::new(session, node, deliver)?,
        })
    }

    /// Publishes what is locked on any of the robots.
    async fn publish(&mut self, hosted: &[Hosted]) -> anyhow::Result<()> {
        let gates = hosted.iter().filter_map(|controller| controller.machine.gate());
        let locks = gates.flat_map(|gate| gate.locks().0).collect();
        Ok(self.locks.publish(Locks(locks)).await?)
    }
}

/// Takes what is received, and looks at the controllers' clocks, until the process is asked to end.
async fn run_loop(
    hosted: &mut [Hosted],
    (server, mut e_stop): (&ParameterServer, Option<EStop>),
    (session, sender): (&Session, &UnboundedSender<Input>),
    events: &mut UnboundedReceiver<Input>,
) -> anyhow::Result<()> {
    let start = since_boot();
    let passed = || since_boot().saturating_sub(start);
    let holds_lease = hosted.iter().any(|controller| controller.machine.gate().is_some());
    // A lease that has run out is noticed by looking.
    let mut beat = beat(if holds_lease { TICK } else { HEARTBEAT_PERIOD });
    let mut complaints = Complaints::default();
    let mut asked_to_stop = std::pin::pin!(shutdown::requested());
    loop {
        tokio::select! {
            request = &mut asked_to_stop => {
                request?;
                return Ok(());
            }
            Some(received) = events.recv() => {
                if let Input::Virtual(index, detection) = received {
                    hosted[index].virtual_detection.receive(detection, Instant::now());
                }
                for (index, event) in dispatch(received, hosted, server, &mut complaints) {
                    let is_set = matches!(event, Event::Parameters(_));
                    let controller = &mut hosted[index];
                    step(controller, server, event, passed()).await?;
                    if is_set {
                        controller.follow(session, index, sender)?;
                    }
                    if let Some(silent) = controller.machine.silent_reading(passed()) {
                        let names = controller.machine.settings().controller.reading_names();
                        let name = names.iter().nth(silent).unwrap_or_default();
                        complaints.warn(&controller.node, &nothing_on(name));
                    }
                }
            }
            _ = beat.tick() => {
                for controller in hosted.iter_mut() {
                    step(controller, server, Event::Tick, passed()).await?;
                }
            }
        }
        if let Some(e_stop) = &mut e_stop {
            e_stop.publish(hosted).await?;
        }
    }
}

/// The events that follow from what was received, each with the index of its controller.
fn dispatch(
    received: Input,
    hosted: &[Hosted],
    server: &ParameterServer,
    complaints: &mut Complaints,
) -> Vec<(usize, Event)> {
    let all = |event: Event| (0..hosted.len()).map(|index| (index, event.clone())).collect();
    match received {
        Input::Of(index, Event::Detection(detected)) => {
            let detected =
                hosted[index].virtual_detection.with(Bool { data: detected }, Instant::now());
            vec![(index, Event::Detection(detected))]
        }
        Input::Of(index, event) => vec![(index, event)],
        Input::Reading(index, name, is_true) => {
            let event = hosted[index].reading(&name, is_true);
            event.map(|event| (index, event)).into_iter().collect()
        }
        Input::Virtual(..) => Vec::new(),
        Input::Clock(stamp_ns) => all(Event::Clock(stamp_ns)),
        Input::EStop(message) => all(Event::EStop(message)),
        Input::Lease(message) => match wire::lease(message) {
            Ok(lease) => {
                let robots = hosted.iter().map(|controller| controller.robot.as_str());
                let leases = lease.of_each(robots).into_iter().enumerate();
                leases.filter_map(|(index, lease)| Some((index, Event::Lease(lease?)))).collect()
            }
            Err(error) => {
                if let Some(first) = hosted.first() {
                    complaints.warn(&first.node, &format!("refused: {error}"));
                }
                Vec::new()
            }
        },
        Input::ParametersOf(node) => hosted
            .iter()
            .position(|controller| controller.node.full_name() == node)
            .map(|index| (index, Event::Parameters(parameters::settings(server, &node))))
            .into_iter()
            .collect(),
    }
}

async fn step(
    controller: &mut Hosted,
    server: &ParameterServer,
    event: Event,
    now: Duration,
) -> anyhow::Result<()> {
    for action in controller.machine.on_event(event, now) {
        match action {
            Action::Command { command, stamp_ns } => {
                let stamp = stamp_ns.map_or_else(wall_time, Time::from_nanos);
                controller.cmd_vel.publish(command, stamp).await?;
            }
            Action::Status(status) => {
                let message = wire::status_message(&status, wall_time());
                controller.status.publish(message).await?;
            }
            Action::GateStatus(status) => {
                let publisher = controller.gate_status.as_ref();
                let publisher = publisher.expect("a controller with a gate has its topic");
                publisher.publish(wire::status_message(&status, wall_time())).await?;
            }
        }
    }
    let arming = if controller.machine.is_armed(now) { Arming::Armed } else { Arming::Disarmed };
    if arming != controller.arming {
        controller.arming = arming;
        server.set_arming(controller.node.full_name(), arming)?;
    }
    Ok(())
}
