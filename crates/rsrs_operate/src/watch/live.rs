//! A fleet that runs now: its messages are received on a thread of their own, so that a terminal
//! that is slow holds up nothing but itself.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::Context;
use rsrs_core::robot::sensor::MOST_READINGS;
use rsrs_fleet::e_stop::Source;
use rsrs_fleet::observation::{Event, Observation};
use rsrs_fleet::stopper::MOST_ROBOTS;
use rsrs_msgs::node_names::WATCH as NODE;
use rsrs_msgs::topics::{self, Durability, Qos, Topic};
use rsrs_ros::parameters::ParameterServer;
use rsrs_ros::session::{EndpointKind, Session, SessionOptions, Subscription};
use tokio::sync::oneshot;

use super::watched_topic::{OF_SWARM, WatchedTopic};
use rsrs_ros::runtime::{beat, runtime};

/// How often the discovery database is looked at.
const POLL_PERIOD: Duration = Duration::from_millis(250);
/// Messages that wait for who looks; more are let go.
const QUEUE: usize = 100_000;
/// Samples that are kept for a subscription that is not looked at for a moment.
const DEPTH: u32 = 100;

/// What was received, and when since the beginning.
type Timed = (Duration, Event);

/// A fleet that is watched.
pub struct LiveFleet {
    received: Receiver<Timed>,
    /// Ends the thread when it is dropped.
    leave: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<anyhow::Result<()>>>,
    start: Instant,
    observation: Observation,
}

impl LiveFleet {
    /// Starts to receive, on a thread of its own; where no robots are named that should be there,
    /// they are found by the topics that they publish.
    ///
    /// A network that cannot be used shows with [`Self::update`].
    pub fn join(network: SessionOptions, robots: Vec<String>) -> anyhow::Result<Self> {
        let (to_us, received) = sync_channel(QUEUE);
        let (leave, left) = oneshot::channel();
        let start = Instant::now();
        let mut observation = Observation::default();
        for robot in &robots {
            observation.on_event(Event::Found { robot: robot.clone() }, Duration::ZERO);
        }
        let thread = std::thread::Builder::new().name("watch".to_owned());
        let thread = thread.spawn(move || {
            let watcher = Watcher { robots, received: to_us, start };
            runtime()?.block_on(watcher.watch(&network, left))
        });
        let thread = Some(thread.context("starting to receive")?);
        Ok(Self { received, leave: Some(leave), thread, start, observation })
    }

    /// Takes what was received since the last call.
    pub fn update(&mut self) -> anyhow::Result<()> {
        loop {
            match self.received.try_recv() {
                Ok((at, event)) => self.observation.on_event(event, at),
                Err(TryRecvError::Empty) => return Ok(()),
                Err(TryRecvError::Disconnected) => return self.ended(),
            }
        }
    }

    /// What is seen.
    pub fn observation(&self) -> &Observation {
        &self.observation
    }

    /// Since the beginning.
    pub fn now(&self) -> Duration {
        self.start.elapsed()
    }

    /// Leaves the network.
    pub fn leave(mut self) -> anyhow::Result<()> {
        drop(self.leave.take());
        self.ended()
    }

    fn ended(&mut self) -> anyhow::Result<()> {
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(ended)) => ended,
            Some(Err(panic)) => std::panic::resume_unwind(panic),
            None => Ok(()),
        }
    }
}

struct Watcher {
    /// Robots that should be there; none, if any counts.
    robots: Vec<String>,
    received: SyncSender<Timed>,
    start: Instant,
}

impl Watcher {
    async fn watch(
        self,
        network: &SessionOptions,
        left: oneshot::Receiver<()>,
    ) -> anyhow::Result<()> {
        let session = Session::open(network)?;
        let watched = tokio::select! {
            // Whoever drops the other end has left, too.
            _ = left => Ok(()),
            watched = self.look_around(&session) => watched,
            ended = session.ended() => Err(ended.into()),
        };
        session.close().await;
        watched
    }

    /// Subscribes topics as they appear; never ends but by an error.
    async fn look_around(&self, session: &Session) -> anyhow::Result<()> {
        // So that other programs see who subscribes, and tools of parameters get an answer.
        let node = session.node("/", NODE)?;
        let _parameters = ParameterServer::without_parameters(session, &node)?;
        let mut subscriptions = BTreeMap::new();
        let (mut robots, mut objects) = (BTreeSet::new(), BTreeSet::new());
        let mut n_further = BTreeMap::new();
        for topic in OF_SWARM {
            let watched = WatchedTopic::of_owner(topic, "");
            subscriptions.insert(key(topic.name, &topic), self.subscribe(session, watched)?);
        }
        let mut look = beat(POLL_PERIOD);
        loop {
            look.tick().await;
            for watched in self.new_topics(session, &subscriptions) {
                // Any node in the network may publish under any name.
                let known = if watched.is_of_object() { &mut objects } else { &mut robots };
                if known.len() == MOST_ROBOTS && !known.contains(&watched.owner) {
                    continue;
                }
                let is_new = known.insert(watched.owner.clone());
                if !topics::is_namespace(&watched.owner) {
                    if is_new {
                        log::warn!("left out `{}`: nothing can have this name", watched.owner);
                    }
                    continue;
                }
                if watched.is_further() {
                    let n_known: &mut usize = n_further.entry(watched.owner.clone()).or_default();
                    if *n_known == MOST_READINGS - 1 {
                        continue;
                    }
                    *n_known += 1;
                }
                let name = watched.name();
                let subscription = self.subscribe(session, watched.clone())?;
                subscriptions.insert(key(&name, &watched.topic), subscription);
            }
        }
    }

    /// Topics of robots and objects that have a publisher and are not subscribed yet.
    fn new_topics(
        &self,
        session: &Session,
        subscriptions: &BTreeMap<(String, &'static str), Subscription>,
    ) -> Vec<WatchedTopic> {
        let writers = session.endpoints().into_iter();
        let published: Vec<WatchedTopic> = writers
            .filter(|end| end.kind == EndpointKind::Writer)
            .filter_map(|end| WatchedTopic::new(&end.topic, &end.type_name))
            .filter(|watched| !watched.owner.is_empty())
            .collect();
        let shown = published.iter().filter(|watched| watched.shows_a_robot());
        let shown: BTreeSet<&str> = shown.map(|watched| watched.owner.as_str()).collect();
        let is_robot = |robot: &String| {
            if self.robots.is_empty() {
                shown.contains(robot.as_str())
            } else {
                self.robots.contains(robot)
            }
        };
        let mut new = published.clone();
        new.retain(|watched| {
            let is_wanted = watched.is_of_object() || is_robot(&watched.owner);
            is_wanted && !subscriptions.contains_key(&key(&watched.name(), &watched.topic))
        });
        new.dedup();
        new
    }

    /// Subscribes best effort, so that a viewer which does not keep up delays no publisher; latched
    /// topics keep their quality of service.
    fn subscribe(&self, session: &Session, watched: WatchedTopic) -> anyhow::Result<Subscription> {
        let Topic { type_name, qos, .. } = watched.topic;
        let name = watched.name();
        let qos = match qos.durability {
            // Where an object is comes again and again, of a tracker that keeps nothing, and so do readings.
            _ if watched.is_of_object() || watched.is_further() => Qos::best_effort(DEPTH),
            Durability::Volatile => Qos::best_effort(DEPTH),
            Durability::TransientLocal => qos,
        };
        let (received, start, of) = (self.received.clone(), self.start, name.clone());
        Ok(session.subscribe_raw(&name, type_name, qos, move |sample| {
            match watched.understand(Source(sample.writer), &sample.message) {
                // A queue that is full, or at whose end nobody is, takes no more.
                Ok(event) => drop(received.try_send((start.elapsed(), event))),
                Err(reason) => log::warn!("refused a message on {of}: {reason}"),
            }
        })?)
    }
}

/// Names of topics, with their types: commands come in two.
fn key(name: &str, topic: &Topic) -> (String, &'static str) {
    (name.to_owned(), topic.type_name)
}
