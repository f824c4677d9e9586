//! Stopping every robot, without a runner: statuses in, the e-stop out.
//!
//! What it decides is [`rsrs_fleet::stopper`]. Robots make themselves known by the topic of their
//! status, or are named by a lease or by who asks for the stop.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use rsrs_fleet::stopper::{Action, Answer, Ending, Event, Stopper, Word};
use rsrs_msgs::rsrs::{RobotStatus, RunLease};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics;
use rsrs_ros::logging::Level;
use rsrs_ros::session::{
    EndpointKind, NodeHandle, Publisher, Session, SessionOptions, Subscription,
};
use rsrs_wire as wire;
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};

/// Name of the node.
const NODE: &str = "rsrs_stop";

/// How often time passes for the machine while nothing arrives.
const GLANCE: Duration = Duration::from_millis(10);
/// How often the discovery database is looked at.
const LOOK_AROUND: Duration = Duration::from_millis(50);

/// What came of a stop or release.
#[derive(Clone, Debug, PartialEq)]
pub struct StopReport {
    /// How it ended.
    pub ending: Ending,
    /// What came of it for each robot, by name.
    pub answers: Vec<Answer>,
    /// How long it took, in seconds.
    pub took_s: f64,
}

/// Says the word until every known robot has acknowledged it, or the time is up.
///
/// # Arguments
///
/// * `robots` — those that should be there; others are found by their statuses.
/// * `interrupt` — when it completes, nobody waits any longer.
///
/// # Errors
///
/// If the network cannot be used. A robot that does not acknowledge is part of the report.
pub async fn say_to_all(
    word: Word,
    robots: &[String],
    network: &SessionOptions,
    interrupt: impl Future<Output = ()>,
) -> anyhow::Result<StopReport> {
    let session = Session::open(network)?;
    let told = Teller::new(&session, Stopper::new(word));
    let report = match told {
        Ok(mut teller) => teller.tell(robots, interrupt).await,
        Err(error) => Err(error),
    };
    session.close().await;
    report
}

/// A stopper and its ends of the network.
struct Teller<'a> {
    session: &'a Session,
    node: NodeHandle,
    machine: Stopper,
    e_stop: Publisher<Bool>,
    start: Instant,
    ears: BTreeMap<String, Subscription>,
    ending: Option<Ending>,
}

impl<'a> Teller<'a> {
    fn new(session: &'a Session, machine: Stopper) -> anyhow::Result<Self> {
        let node = session.node("/", NODE)?;
        let topic = topics::E_STOP;
        Ok(Self {
            e_stop: session.publish_on(&node, topic.name, topic.qos)?,
            session,
            node,
            machine,
            start: Instant::now(),
            ears: BTreeMap::new(),
            ending: None,
        })
    }

    async fn tell(
        &mut self,
        robots: &[String],
        interrupt: impl Future<Output = ()>,
    ) -> anyhow::Result<StopReport> {
        let (heard, mut events) = unbounded_channel();
        // The first word goes out before anything else is looked at.
        self.advance(Event::Tick).await?;
        for robot in robots {
            self.find(robot, &heard).await?;
        }
        let _leases = self.listen_to_leases(&heard)?;
        let mut glance = tokio::time::interval(GLANCE);
        glance.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
        let mut look = tokio::time::interval(LOOK_AROUND);
        look.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
        let mut interrupt = std::pin::pin!(interrupt);
        let mut is_interrupted = false;
        loop {
            if let Some(ending) = self.ending {
                let took_s = self.start.elapsed().as_secs_f64();
                return Ok(StopReport { ending, answers: self.machine.answers(), took_s });
            }
            tokio::select! {
                () = &mut interrupt, if !is_interrupted => {
                    is_interrupted = true;
                    self.advance(Event::Interrupt).await?;
                }
                Some(event) = events.recv() => match event {
                    Event::Found { robot } => self.find(&robot, &heard).await?,
                    event => self.advance(event).await?,
                },
                _ = look.tick() => {
                    for robot in self.robots_around() {
                        self.find(&robot, &heard).await?;
                    }
                }
                _ = glance.tick() => self.advance(Event::Tick).await?,
            }
        }
    }

    /// Lets the machine take an event, and does what follows.
    async fn advance(&mut self, event: Event) -> anyhow::Result<()> {
        for action in self.machine.on_event(event, self.start.elapsed()) {
            match action {
                Action::Say(data) => self.e_stop.publish(Bool { data }).await?,
                Action::Finish(ending) => self.ending = Some(ending),
            }
        }
        Ok(())
    }

    /// Listens to a robot, once.
    async fn find(&mut self, robot: &str, heard: &UnboundedSender<Event>) -> anyhow::Result<()> {
        if self.ears.contains_key(robot) {
            return Ok(());
        }
        let (name, heard, node) = (robot.to_owned(), heard.clone(), self.node.clone());
        let topic = topics::STATUS;
        let ear = self.session.subscribe(
            &self.node,
            &topic.for_robot(robot),
            topic.qos,
            move |sample: rsrs_ros::session::Received<RobotStatus>| {
                match wire::status(sample.message) {
                    // Nobody listens any more once it is over.
                    Ok(status) => {
                        drop(heard.send(Event::Status { robot: name.clone(), status }));
                    }
                    Err(error) => {
                        node.say(Level::Warn, &format!("refused a status of {name}: {error}"));
                    }
                }
            },
        )?;
        self.ears.insert(robot.to_owned(), ear);
        self.advance(Event::Found { robot: robot.to_owned() }).await
    }

    /// A lease names robots that have never been heard, too.
    fn listen_to_leases(&self, heard: &UnboundedSender<Event>) -> anyhow::Result<Subscription> {
        let heard = heard.clone();
        let topic = topics::LEASE;
        Ok(self.session.subscribe(
            &self.node,
            topic.name,
            topic.qos,
            move |sample: rsrs_ros::session::Received<RunLease>| {
                for robot in sample.message.robots {
                    // Nobody listens any more once it is over.
                    drop(heard.send(Event::Found { robot }));
                }
            },
        )?)
    }

    /// Robots whose status somebody publishes.
    fn robots_around(&self) -> Vec<String> {
        let endpoints = self.session.endpoints();
        let topics = endpoints
            .iter()
            .filter(|endpoint| endpoint.kind == EndpointKind::Writer)
            .filter(|endpoint| endpoint.type_name == topics::STATUS.type_name)
            .map(|endpoint| endpoint.topic.as_str());
        topics.filter_map(robot_of).map(str::to_owned).collect()
    }
}

/// `robot_3` of `/robot_3/status`; the simulator has a status and is no robot.
fn robot_of(topic: &str) -> Option<&str> {
    if topic == topics::SIMULATOR_STATUS.name {
        return None;
    }
    let robot = topic.strip_prefix('/')?.strip_suffix(topics::STATUS.name)?.strip_suffix('/')?;
    (!robot.contains('/')).then_some(robot)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_are_known_by_their_status_and_by_that_alone() {
        assert_eq!(robot_of("/robot_3/status"), Some("robot_3"));
        for other in ["/simulator/status", "/robot_3/controller/status", "/status", "/robot_3/odom"]
        {
            assert_eq!(robot_of(other), None, "{other}");
        }
    }
}
