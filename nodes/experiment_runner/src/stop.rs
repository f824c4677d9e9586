//! Stopping every robot, without a runner: statuses in, the e-stop out.
//!
//! What it decides is [`rsrs_fleet::stopper`]. Robots make themselves known by the topic of their
//! status, or are named by a lease or by who asks for the stop.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

use rsrs_fleet::e_stop::{LockCause, Locks, Source};
use rsrs_fleet::stopper::{
    Action, Event, MOST_ROBOTS, RobotAcknowledgement, StopCommand, StopOutcome, Stopper,
};
use rsrs_fleet::timing::TICK;
use rsrs_fleet::wire;
use rsrs_msgs::node_names::STOP as NODE;
use rsrs_msgs::rsrs::{EStopLocks, RunLease};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics;
use rsrs_ros::e_stop::EStopSubscriptions;
use rsrs_ros::logging::Level;
use rsrs_ros::runtime::beat;
use rsrs_ros::session::{
    EndpointKind, NodeHandle, Publisher, Session, SessionError, SessionOptions, Subscription,
};
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};

/// How often the discovery database is looked at.
const POLL_PERIOD: Duration = Duration::from_millis(50);

/// What came of a stop or release.
#[derive(Clone, Debug, PartialEq)]
pub struct StopReport {
    /// How it ended.
    pub ending: StopOutcome,
    /// What came of it for each robot, by name.
    pub answers: Vec<RobotAcknowledgement>,
    /// Who still holds robots after a release.
    pub holding: Vec<Holding>,
    /// How long it took, in seconds.
    pub took_s: f64,
}

impl StopReport {
    /// Names of the robots that have not acknowledged.
    pub fn unacknowledged(&self) -> Vec<&str> {
        let silent = self.answers.iter().filter(|answer| answer.acknowledged_after.is_none());
        silent.map(|answer| answer.robot.as_str()).collect()
    }
}

/// A lock of the e-stop that a release leaves alone.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Holding {
    /// Who holds it.
    pub source: Source,
    /// The full name of its node, if it is there and announced.
    pub node: Option<String>,
    /// How it came to lock.
    pub cause: LockCause,
}

/// Joins a network as who can stop its robots, and publishes nothing that concerns them.
pub fn join(network: &SessionOptions) -> Result<Session, SessionError> {
    let session = Session::open(network)?;
    session.node("/", NODE)?;
    Ok(session)
}

/// Publishes the command on a session of [`join`] until every known robot has acknowledged it, the
/// time is up, or `interrupt` completes, and leaves the network. These robots should be there;
/// others are found by their statuses.
///
/// # Errors
///
/// If the network cannot be used. A robot that does not acknowledge is part of the report.
pub async fn command_all(
    session: Session,
    command: StopCommand,
    robots: &[String],
    interrupt: impl Future<Output = ()>,
) -> anyhow::Result<StopReport> {
    let given = StopNode::new(&session, Stopper::new(command).over(session.transport()));
    let report = match given {
        Ok(mut stop_node) => tokio::select! {
            report = stop_node.run(robots, interrupt) => report,
            ended = session.ended() => Err(ended.into()),
        },
        Err(error) => Err(error),
    };
    session.close().await;
    report
}

/// A stopper and its ends of the network.
struct StopNode<'a> {
    session: &'a Session,
    node: NodeHandle,
    machine: Stopper,
    e_stop: Publisher<Bool>,
    release: Publisher<EStopLocks>,
    start: Instant,
    status_subscriptions: BTreeMap<String, Subscription>,
    /// Names that are no robot's.
    refused: BTreeSet<String>,
    /// Nodes of the publishers of the e-stop topic, as far as they were ever known.
    nodes: BTreeMap<Source, String>,
    ending: Option<StopOutcome>,
}

impl<'a> StopNode<'a> {
    fn new(session: &'a Session, machine: Stopper) -> anyhow::Result<Self> {
        let node = session.node("/", NODE)?;
        let topic = topics::E_STOP;
        Ok(Self {
            e_stop: session.publish_on(&node, topic.name, topic.qos)?,
            release: {
                let topic = topics::E_STOP_RELEASE;
                session.publish_on(&node, topic.name, topic.qos)?
            },
            refused: BTreeSet::new(),
            nodes: BTreeMap::new(),
            session,
            node,
            machine,
            start: Instant::now(),
            status_subscriptions: BTreeMap::new(),
            ending: None,
        })
    }

    async fn run(
        &mut self,
        robots: &[String],
        interrupt: impl Future<Output = ()>,
    ) -> anyhow::Result<StopReport> {
        let (received, mut events) = unbounded_channel();
        // The first message goes out before anything else is looked at.
        self.advance(Event::Tick).await;
        for robot in robots {
            self.find(robot, &received).await;
        }
        let _leases = self.listen_to_leases(&received)?;
        let _e_stop = self.listen_to_e_stop(&received)?;
        let mut tick = beat(TICK);
        let mut look = beat(POLL_PERIOD);
        let mut interrupt = std::pin::pin!(interrupt);
        let mut is_interrupted = false;
        loop {
            if let Some(ending) = self.ending {
                return Ok(self.report(ending));
            }
            tokio::select! {
                () = &mut interrupt, if !is_interrupted => {
                    is_interrupted = true;
                    self.advance(Event::Interrupt).await;
                }
                Some(event) = events.recv() => match event {
                    Event::Discovered { robot } => self.find(&robot, &received).await,
                    event => self.advance(event).await,
                },
                _ = look.tick() => self.look_around(&received).await,
                _ = tick.tick() => self.advance(Event::Tick).await,
            }
        }
    }

    fn report(&self, ending: StopOutcome) -> StopReport {
        let now = self.start.elapsed();
        let holding = self.machine.holding(now).0.into_iter();
        StopReport {
            ending,
            answers: self.machine.answers(),
            holding: holding
                .map(|(source, cause)| Holding {
                    source,
                    node: self.nodes.get(&source).cloned(),
                    cause,
                })
                .collect(),
            took_s: now.as_secs_f64(),
        }
    }

    /// Lets the machine take an event, and does what follows. What cannot be published now is
    /// published again soon: a stop is never given up.
    async fn advance(&mut self, event: Event) {
        for action in self.machine.on_event(event, self.start.elapsed()) {
            let published = match action {
                Action::Publish(data) => self.e_stop.publish(Bool { data }).await,
                Action::Release(sources) => {
                    // Why they lock does not matter to a release.
                    let locks = sources.into_iter().map(|source| (source, LockCause::Engaged));
                    self.release.publish(wire::locks_message(&Locks(locks.collect()))).await
                }
                Action::Finish(ending) => {
                    self.ending = Some(ending);
                    Ok(())
                }
            };
            if let Err(error) = published {
                self.node.log(Level::Error, &error.to_string());
            }
        }
    }

    async fn look_around(&mut self, received: &UnboundedSender<Event>) {
        let endpoints = self.session.endpoints();
        let writers = endpoints.iter().filter(|endpoint| endpoint.kind == EndpointKind::Writer);
        let of_e_stop = writers.clone().filter(|endpoint| endpoint.topic == topics::E_STOP.name);
        for endpoint in of_e_stop.clone() {
            if let Some(node) = &endpoint.node {
                self.nodes.insert(Source(endpoint.guid), node.clone());
            }
        }
        let present = of_e_stop.map(|endpoint| Source(endpoint.guid)).collect();
        let robots: Vec<&str> = writers
            .filter(|endpoint| endpoint.type_name == topics::STATUS.type_name)
            .filter_map(|endpoint| topics::STATUS.robot_of(&endpoint.topic))
            .collect();
        for robot in robots {
            self.find(robot, received).await;
        }
        self.advance(Event::Publishers(present)).await;
    }

    /// Subscribes to a robot, once; a name that no robot can have is left out.
    async fn find(&mut self, robot: &str, received: &UnboundedSender<Event>) {
        let is_new =
            !self.status_subscriptions.contains_key(robot) && !self.refused.contains(robot);
        if !is_new || !self.machine.follows(robot) {
            return;
        }
        let reason = if topics::is_namespace(robot) {
            match self.listen_to_robot(robot, received) {
                Ok(subscription) => {
                    self.status_subscriptions.insert(robot.to_owned(), subscription);
                    self.advance(Event::Discovered { robot: robot.to_owned() }).await;
                    return;
                }
                Err(error) => error.to_string(),
            }
        } else {
            "no robot can have this name".to_owned()
        };
        if self.refused.len() < MOST_ROBOTS {
            self.node.log(Level::Warn, &format!("left out robot `{robot}`: {reason}"));
            self.refused.insert(robot.to_owned());
        }
    }

    fn listen_to_robot(
        &self,
        robot: &str,
        received: &UnboundedSender<Event>,
    ) -> Result<Subscription, SessionError> {
        let (name, received, node) = (robot.to_owned(), received.clone(), self.node.clone());
        let (topic, full_name) = (topics::STATUS, topics::STATUS.for_robot(robot));
        self.session.subscribe(&self.node, &full_name, topic.qos, move |sample| {
            match wire::status(sample.message) {
                // There is no receiver once it is over.
                Ok(status) => drop(received.send(Event::Status { robot: name.clone(), status })),
                Err(error) => {
                    node.log(Level::Warn, &format!("refused a status of {name}: {error}"));
                }
            }
        })
    }

    /// Which sources lock, by their own messages and by the robots' reports.
    fn listen_to_e_stop(
        &self,
        received: &UnboundedSender<Event>,
    ) -> Result<EStopSubscriptions, SessionError> {
        let received = received.clone();
        EStopSubscriptions::new(self.session, &self.node, move |message| {
            // There is no receiver once it is over.
            drop(received.send(Event::EStop(message)));
        })
    }

    /// A lease names robots that have never been received, too.
    fn listen_to_leases(&self, received: &UnboundedSender<Event>) -> anyhow::Result<Subscription> {
        let received = received.clone();
        let topic = topics::LEASE;
        Ok(self.session.subscribe(&self.node, topic.name, topic.qos, move |sample| {
            let lease: RunLease = sample.message;
            for robot in lease.robots.into_iter().take(MOST_ROBOTS) {
                // There is no receiver once it is over.
                drop(received.send(Event::Discovered { robot }));
            }
        })?)
    }
}
