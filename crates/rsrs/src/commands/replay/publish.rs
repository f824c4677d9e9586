//! A bag back on the network, at the pace of its recording.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use rsrs_bags::{Bag, BagError, BagMessage};
use rsrs_msgs::RosMessage;
use rsrs_msgs::rsrs::{RobotStatus, RunLease};
use rsrs_msgs::topics;
use rsrs_ros::clock::ClockPublisher;
use rsrs_ros::parameters::ParameterServer;
use rsrs_ros::session::{Endpoint, EndpointKind, RawPublisher, Session, SessionOptions};
use rsrs_ros::shutdown;
use serde::Serialize;

use super::Pace;
use super::controls::{Controls, KEYS, PlayerKey};
use super::selection::{Selected, Selection};
use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::notes::print_note;
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::wording::{count, counted};

/// How often `/clock` says the time between messages.
const CLOCK_PERIOD: Duration = Duration::from_millis(25);

/// Time in which other publishers on the network are found, at least.
const DISCOVERY: Duration = Duration::from_secs(2);

/// How long the publishers stay after their last message. Some subscribers drop what they have not
/// looked at yet when a publisher leaves, though they have acknowledged it.
const LINGER: Duration = Duration::from_millis(500);

/// What was published.
#[derive(Serialize)]
struct Summary {
    bag: PathBuf,
    /// Messages that went out.
    n_messages: u64,
    /// Topics that they went out on.
    n_topics: usize,
    /// Topics that were left out.
    left_out: Vec<String>,
    /// How long it took, pauses included, in seconds.
    took_s: f64,
    /// How far it fell behind its pace at worst, in seconds.
    late_s: f64,
}

/// Publishes a bag.
///
/// # Errors
///
/// If the network cannot be used, a reliable subscriber stops acknowledging, or the bag cannot be
/// read.
pub async fn run(
    bag: &Bag,
    (selection, pace): (&Selection, &Pace),
    network: &SessionOptions,
    format: Format,
) -> anyhow::Result<Outcome> {
    for (names, why) in [
        (&selection.guarded, "robots are steered by them; `--topics` takes them by name"),
        (&selection.foreign, "the bag does not hold them as ROS 2 sends them"),
    ] {
        if !names.is_empty() {
            print_note(&format!(
                "left out {} ({why}): {}",
                count(names.len() as u64),
                names.join(", ")
            ));
        }
    }
    let session = Session::open(network)?;
    let played = match without_living(&session, selection).await {
        Ok(allowed) => play(&session, bag, &allowed, pace).await.map(|played| (played, allowed)),
        Err(error) => Err(error),
    };
    session.close().await;
    let (Played { n_messages, took, late }, allowed) = played?;
    let n_topics = allowed.topics.len();
    let left_out = [&selection.guarded[..], &selection.foreign[..], &allowed.living[..]].concat();
    let summary = Summary {
        bag: bag.path().to_owned(),
        n_messages,
        n_topics,
        left_out,
        took_s: took.as_secs_f64(),
        late_s: late.as_secs_f64(),
    };
    report(format, &summary, &text(&summary))?;
    Ok(Outcome::Done)
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
async fn without_living(session: &Session, selection: &Selection) -> anyhow::Result<Allowed> {
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
                let node = node.as_deref().unwrap_or("a program without a name");
                print_note(&format!(
                    "left out {}: {node} publishes it now; `--topics` takes it by name",
                    topic.name
                ));
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
        print_note("the time is not published: there are robots on this network");
    }
    Ok(Allowed { topics: allowed, living, clock: !has_robots })
}

fn text(summary: &Summary) -> String {
    format!(
        "{}: {} on {} in {:.1} s, at most {:.3} s late",
        summary.bag.display(),
        counted(summary.n_messages, "message"),
        counted(summary.n_topics as u64, "topic"),
        summary.took_s,
        summary.late_s
    )
}

/// What came of it.
struct Played {
    n_messages: u64,
    took: Duration,
    late: Duration,
}

async fn play(
    session: &Session,
    bag: &Bag,
    allowed: &Allowed,
    pace: &Pace,
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
        let node = session.node("/", "replay")?;
        let parameters = ParameterServer::without_parameters(session, &node)?;
        Some((ClockPublisher::new(session, &node)?, parameters))
    };
    let controls = Controls::listen();
    if pace.is_paused && !controls.has_person() {
        anyhow::bail!("`--pause` needs a terminal from which to go on");
    }
    let mut player = Player {
        publishers,
        clock,
        controls,
        rate: pace.rate,
        state: if pace.is_paused { State::Paused } else { State::Playing },
        place: Place::default(),
        anchor: None,
        n_messages: 0,
        late: Duration::ZERO,
    };
    let began = Instant::now();
    let ended = tokio::select! {
        request = shutdown::requested() => { request?; Ok(()) }
        ended = session.ended() => Err(ended.into()),
        ended = async { player.whole(bag, pace).await?; player.settle().await } => ended,
    };
    ended?;
    Ok(Played { n_messages: player.n_messages, took: began.elapsed(), late: player.late })
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Playing,
    Paused,
    /// Playing what was recorded at this time, in nanoseconds, and pausing behind it; `None` before
    /// the first message.
    Stepping(Option<u64>),
    Quit,
}

/// Where somebody is in a bag, in nanoseconds of log time.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    /// The beginning of the bag.
    first: u64,
    /// What was played last, or gone to.
    now: u64,
    /// Where a person wants to be instead.
    wanted: Option<u64>,
}

impl Place {
    /// Notes where a person wants to be: not before the beginning.
    fn go(&mut self, from_ns: u64, by_s: f64) {
        let by_ns = nanoseconds(by_s.abs());
        let to_ns =
            if by_s < 0.0 { from_ns.saturating_sub(by_ns) } else { from_ns.saturating_add(by_ns) };
        self.now = to_ns.max(self.first);
        self.wanted = Some(self.now);
    }
}

/// Somebody who plays a bag.
struct Player<'a> {
    publishers: BTreeMap<&'a str, RawPublisher>,
    /// The clock, and what tools ask of its node.
    clock: Option<(ClockPublisher, ParameterServer)>,
    controls: Controls,
    rate: f64,
    state: State,
    place: Place,
    /// A log time, in nanoseconds, and when it was played.
    anchor: Option<(u64, Instant)>,
    n_messages: u64,
    late: Duration,
}

impl Player<'_> {
    async fn whole(&mut self, bag: &Bag, pace: &Pace) -> anyhow::Result<()> {
        tokio::time::sleep(Duration::from_secs_f64(pace.delay_s)).await;
        let first_ns = bag.info().start_ns.unwrap_or(0);
        let from_ns = first_ns.saturating_add(nanoseconds(pace.start_s));
        self.place.first = first_ns;
        loop {
            self.anchor = None;
            self.place.now = from_ns;
            let n_before = self.n_messages;
            self.once(bag, from_ns).await?;
            while let Some(wanted_ns) = self.place.wanted.take() {
                self.anchor = None;
                self.once(bag, wanted_ns).await?;
            }
            let is_idle = self.n_messages == n_before;
            if !pace.is_loop || self.state == State::Quit || is_idle {
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

    /// Plays from here to the end, or to where somebody wants to be elsewhere.
    async fn once(&mut self, bag: &Bag, from_ns: u64) -> anyhow::Result<()> {
        let names: Vec<&str> = self.publishers.keys().copied().collect();
        for message in bag.messages_on(names) {
            let message = match message {
                Ok(message) => message,
                // What came before the break has gone out; the summary says where it is.
                Err(BagError::Incomplete { .. }) => continue,
                Err(error) => return Err(error.into()),
            };
            if message.log_time_ns < from_ns {
                continue;
            }
            self.wait_for(message.log_time_ns).await?;
            if self.state == State::Quit || self.place.wanted.is_some() {
                return Ok(());
            }
            self.send(&message).await?;
        }
        Ok(())
    }

    async fn send(&mut self, message: &BagMessage) -> anyhow::Result<()> {
        let publisher = self.publishers.get(&*message.topic);
        let publisher = publisher.expect("only topics with publishers are read");
        publisher.publish(&message.bytes).await?;
        self.n_messages += 1;
        self.place.now = self.place.now.max(message.log_time_ns);
        Ok(())
    }

    /// Waits until a message is due, and receives what the person at the keyboard wants.
    async fn wait_for(&mut self, log_ns: u64) -> anyhow::Result<()> {
        loop {
            match self.state {
                _ if self.place.wanted.is_some() => return Ok(()),
                State::Quit => return Ok(()),
                State::Stepping(None) => {
                    self.state = State::Stepping(Some(log_ns));
                    self.anchor = Some((log_ns, Instant::now()));
                    return self.show_time(log_ns).await;
                }
                State::Stepping(Some(now_ns)) if log_ns <= now_ns => return Ok(()),
                State::Stepping(Some(_)) => self.state = State::Paused,
                State::Paused => {
                    let key = self.controls.next().await;
                    self.obey(key);
                    // Time did not pass.
                    self.anchor = None;
                }
                State::Playing => {
                    if self.is_due(log_ns).await? {
                        return Ok(());
                    }
                }
            }
        }
    }

    /// Waits a little for a message; true once it is due.
    async fn is_due(&mut self, log_ns: u64) -> anyhow::Result<bool> {
        let (from_ns, from) = *self.anchor.get_or_insert((log_ns, Instant::now()));
        // Messages of several topics or files may be a little out of order.
        let after_s = log_ns.saturating_sub(from_ns) as f64 / 1e9 / self.rate;
        let due = from + Duration::try_from_secs_f64(after_s).unwrap_or(Duration::MAX / 4);
        let now = Instant::now();
        if now >= due {
            self.late = self.late.max(now - due);
            self.show_time(log_ns).await?;
            return Ok(true);
        }
        let glance = due.min(now + CLOCK_PERIOD);
        tokio::select! {
            () = tokio::time::sleep_until(glance.into()) => {
                let passed_ns = nanoseconds(from.elapsed().as_secs_f64() * self.rate);
                self.show_time(log_ns.min(from_ns.saturating_add(passed_ns))).await?;
            }
            key = self.controls.next() => self.obey(key),
        }
        Ok(false)
    }

    async fn show_time(&self, time_ns: u64) -> anyhow::Result<()> {
        match &self.clock {
            Some((clock, _)) => Ok(clock.publish(time_ns).await?),
            None => Ok(()),
        }
    }

    fn obey(&mut self, key: PlayerKey) {
        self.state = match (key, self.state) {
            (PlayerKey::Quit, _) => State::Quit,
            (PlayerKey::Step, _) => State::Stepping(None),
            (PlayerKey::Toggle, State::Playing)
            | (PlayerKey::GoTo(_) | PlayerKey::GoBy(_), State::Stepping(_)) => State::Paused,
            (PlayerKey::Toggle, _) => State::Playing,
            (PlayerKey::GoTo(_) | PlayerKey::GoBy(_), state) => state,
        };
        match key {
            PlayerKey::GoTo(time_s) => self.place.go(self.place.first, time_s),
            PlayerKey::GoBy(by_s) => self.place.go(self.place.now, by_s),
            PlayerKey::Toggle | PlayerKey::Step | PlayerKey::Quit => {}
        }
        let at_s = self.place.now.saturating_sub(self.place.first) as f64 / 1e9;
        if self.state == State::Paused {
            print_note(&format!("paused at {at_s:.2} s; {KEYS}"));
        } else if self.place.wanted.is_some() {
            print_note(&format!("at {at_s:.2} s"));
        }
    }
}

/// Whole nanoseconds in so many seconds, which are not negative; more than fit are as many as fit.
fn nanoseconds(seconds: f64) -> u64 {
    let duration = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}
