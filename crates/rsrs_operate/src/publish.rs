//! A bag back on the network, at the pace of its recording.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use rsrs_bags::{Bag, BagError};
use rsrs_msgs::RosMessage;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::rosgraph_msgs::Clock;
use rsrs_msgs::rsrs::{RobotStatus, RunLease};
use rsrs_msgs::{node_names, topics};
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::replay::{Selected, Selection};
use rsrs_ros::parameters::ParameterServer;
use rsrs_ros::session::{Endpoint, EndpointKind, Publisher, RawPublisher, Session, SessionOptions};

use crate::run::operator::Operator;
use rsrs_render::operator_event::OperatorEvent;
use rsrs_render::replay::Published;

/// How often `/clock` is published between messages.
const CLOCK_PERIOD: Duration = Duration::from_millis(25);

/// Time in which other publishers on the network are found, at least.
const DISCOVERY: Duration = Duration::from_secs(2);

/// How long the publishers stay after their last message. Some subscribers drop what they have not
/// looked at yet when a publisher leaves, though they have acknowledged it.
const LINGER: Duration = Duration::from_millis(500);

/// How to publish a bag.
#[derive(Clone, Copy, Debug)]
pub struct PublishOptions {
    /// How many times faster than recorded; positive.
    pub rate: f64,
    /// Whether to start again at the end.
    pub is_loop: bool,
    /// How much of the beginning to leave out, in seconds.
    pub start_s: f64,
    /// How long to wait for subscribers, in seconds.
    pub delay_s: f64,
}

/// Publishes a bag, to its end or until the operator requests a stop.
///
/// # Errors
///
/// If the network cannot be used, a reliable subscriber stops acknowledging, or the bag cannot be
/// read.
pub async fn publish(
    bag: &Bag,
    selection: &Selection,
    options: &PublishOptions,
    network: &SessionOptions,
    operator: &dyn Operator,
) -> anyhow::Result<Published> {
    let (guarded, foreign) = (&selection.guarded, &selection.foreign);
    if !guarded.is_empty() {
        operator.inform(&OperatorEvent::GuardedLeftOut { topics: guarded });
    }
    if !foreign.is_empty() {
        operator.inform(&OperatorEvent::ForeignLeftOut { topics: foreign });
    }
    let session = Session::open(network)?;
    let played = match without_living(&session, selection, operator).await {
        Ok(allowed) => {
            let stop = operator.stop_requested();
            play(&session, stop, bag, &allowed, options).await.map(|played| (played, allowed))
        }
        Err(error) => Err(error),
    };
    session.close().await;
    let (Played { n_messages, took, late }, allowed) = played?;
    Ok(Published {
        bag: bag.path().to_owned(),
        n_messages,
        n_topics: allowed.topics.len(),
        left_out: [&selection.guarded[..], &selection.foreign[..], &allowed.living[..]].concat(),
        took_s: took.as_secs_f64(),
        late_s: late.as_secs_f64(),
    })
}

/// What may be published on a network.
struct Allowed {
    topics: Vec<Selected>,
    /// Topics that are left out, because another program publishes them now.
    living: Vec<String>,
    /// Whether the recorded time is published where the bag has no clock of its own.
    clock: bool,
}

/// Leaves out what another program publishes now, unless it was asked for by name: two publishers of a
/// robot's topic would be taken for one, and live controllers would stamp their commands with a
/// recorded time.
async fn without_living(
    session: &Session,
    selection: &Selection,
    operator: &dyn Operator,
) -> anyhow::Result<Allowed> {
    // Names of nodes come a moment after the first question.
    session.endpoints();
    tokio::time::sleep(DISCOVERY).await;
    let mut writers = session.endpoints();
    writers.retain(|end| end.kind == EndpointKind::Writer);
    let is_live = |end: &Endpoint| {
        [RobotStatus::TYPE_NAME, RunLease::TYPE_NAME].contains(&end.type_name.as_str())
    };
    let has_robots = writers.iter().any(is_live);
    let publishers: BTreeMap<String, Option<String>> =
        writers.into_iter().map(|end| (end.topic, end.node)).collect();
    let (mut allowed, mut living) = (Vec::new(), Vec::new());
    for topic in &selection.topics {
        match publishers.get(&topic.name) {
            None if has_robots && topic.name == topics::CLOCK.name && !topic.is_named => {
                living.push(topic.name.clone());
            }
            Some(node) if !topic.is_named => {
                operator.inform(&OperatorEvent::LivingLeftOut {
                    topic: &topic.name,
                    node: node.as_deref(),
                });
                living.push(topic.name.clone());
            }
            _ => allowed.push(topic.clone()),
        }
    }
    if allowed.is_empty() {
        return Err(with_help(
            "nothing is left to publish: robots are live on this network",
            "publish into a network without robots, or name topics with `--topics`",
        ));
    }
    if has_robots && !allowed.iter().any(|topic: &Selected| topic.name == topics::CLOCK.name) {
        operator.inform(&OperatorEvent::TimeLeftOut);
    }
    Ok(Allowed { topics: allowed, living, clock: !has_robots })
}

/// What came of it.
struct Played {
    n_messages: u64,
    took: Duration,
    late: Duration,
}

async fn play(
    session: &Session,
    stop: impl Future<Output = String>,
    bag: &Bag,
    allowed: &Allowed,
    options: &PublishOptions,
) -> anyhow::Result<Played> {
    let mut publishers = BTreeMap::new();
    for topic in &allowed.topics {
        let publisher = session.publish_raw(&topic.name, &topic.type_name, topic.qos)?;
        publishers.insert(topic.name.as_str(), publisher);
    }
    // A bag with its own clock keeps it.
    let clock = if publishers.contains_key(topics::CLOCK.name) || !allowed.clock {
        None
    } else {
        let node = session.node("/", node_names::REPLAY)?;
        let parameters = ParameterServer::without_parameters(session, &node)?;
        let clock = session.publish_on(&node, topics::CLOCK.name, topics::CLOCK.qos)?;
        Some((clock, parameters))
    };
    let mut player = Player {
        publishers,
        clock,
        rate: options.rate,
        anchor: None,
        n_messages: 0,
        late: Duration::ZERO,
    };
    let began = Instant::now();
    let ended = tokio::select! {
        _reason = stop => Ok(()),
        ended = session.ended() => Err(ended.into()),
        ended = async { player.whole(bag, options).await?; player.settle().await } => ended,
    };
    ended?;
    Ok(Played { n_messages: player.n_messages, took: began.elapsed(), late: player.late })
}

struct Player<'a> {
    publishers: BTreeMap<&'a str, RawPublisher>,
    /// The clock, and the parameter services of its node.
    clock: Option<(Publisher<Clock>, ParameterServer)>,
    rate: f64,
    /// A log time, in nanoseconds, and when it was played.
    anchor: Option<(u64, Instant)>,
    n_messages: u64,
    late: Duration,
}

impl Player<'_> {
    async fn whole(&mut self, bag: &Bag, options: &PublishOptions) -> anyhow::Result<()> {
        tokio::time::sleep(Duration::from_secs_f64(options.delay_s)).await;
        let from_ns = bag.info().start_ns.unwrap_or(0).saturating_add(nanoseconds(options.start_s));
        loop {
            self.anchor = None;
            let n_before = self.n_messages;
            self.once(bag, from_ns).await?;
            if !options.is_loop || self.n_messages == n_before {
                return Ok(());
            }
        }
    }

    /// Waits until subscribers have everything, which would be lost with the publishers.
    async fn settle(&self) -> anyhow::Result<()> {
        for publisher in self.publishers.values() {
            publisher.acknowledged().await?;
        }
        tokio::time::sleep(LINGER).await;
        Ok(())
    }

    /// Plays from here to the end.
    async fn once(&mut self, bag: &Bag, from_ns: u64) -> anyhow::Result<()> {
        let names: Vec<&str> = self.publishers.keys().copied().collect();
        for message in bag.messages_on(names) {
            let message = match message {
                Ok(message) => message,
                // What came before the break has gone out; the summary names its place.
                Err(BagError::Incomplete { .. }) => continue,
                Err(error) => return Err(error.into()),
            };
            if message.log_time_ns < from_ns {
                continue;
            }
            self.wait_for(message.log_time_ns).await?;
            if let Some(publisher) = self.publishers.get(&*message.topic) {
                publisher.publish(&message.bytes).await?;
                self.n_messages += 1;
            }
        }
        Ok(())
    }

    /// Waits until a message is due, and publishes the time meanwhile.
    async fn wait_for(&mut self, log_ns: u64) -> anyhow::Result<()> {
        let (from_ns, from) = *self.anchor.get_or_insert((log_ns, Instant::now()));
        // Messages of several topics or files may be a little out of order.
        let after_s = log_ns.saturating_sub(from_ns) as f64 / 1e9 / self.rate;
        let due = from + Duration::try_from_secs_f64(after_s).unwrap_or(Duration::MAX / 4);
        loop {
            let now = Instant::now();
            if now >= due {
                self.late = self.late.max(now - due);
                return self.show_time(log_ns).await;
            }
            tokio::time::sleep_until(due.min(now + CLOCK_PERIOD).into()).await;
            let passed_ns = nanoseconds(from.elapsed().as_secs_f64() * self.rate);
            self.show_time(log_ns.min(from_ns.saturating_add(passed_ns))).await?;
        }
    }

    async fn show_time(&self, time_ns: u64) -> anyhow::Result<()> {
        match &self.clock {
            Some((clock, _)) => {
                Ok(clock.publish(Clock { clock: Time::from_nanos(time_ns) }).await?)
            }
            None => Ok(()),
        }
    }
}

/// Whole nanoseconds in so many seconds, which are not negative; more than fit are as many as fit.
fn nanoseconds(seconds: f64) -> u64 {
    let duration = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}
