//! A bag back on the network, at the pace of its recording.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use rsrs_bags::{Bag, BagError, BagMessage};
use rsrs_msgs::topics;
use rsrs_ros::clock::ClockPublisher;
use rsrs_ros::session::{RawPublisher, Session, SessionOptions};
use rsrs_ros::shutdown;
use serde::Serialize;
use tokio::sync::mpsc::UnboundedReceiver;

use super::Pace;
use super::controls::{self, Wish};
use super::selection::Selection;
use crate::commands::run::say_note;
use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::recorded_run;
use crate::wording::{count, counted};

/// How often `/clock` says the time between messages.
const CLOCK_PERIOD: Duration = Duration::from_millis(25);

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
    /// Where the recording breaks off.
    #[serde(skip_serializing_if = "Option::is_none")]
    damage: Option<String>,
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
        (&selection.guarded, "they move robots or permit it; `--topics` takes them by name"),
        (&selection.foreign, "the bag does not hold them as ROS 2 sends them"),
    ] {
        if !names.is_empty() {
            say_note(&format!(
                "left out {} ({why}): {}",
                count(names.len() as u64),
                names.join(", ")
            ));
        }
    }
    let session = Session::open(network)?;
    let played = play(&session, bag, selection, pace).await;
    session.close().await;
    let Played { n_messages, took, late } = played?;
    let left_out = [&selection.guarded[..], &selection.foreign[..]].concat();
    let summary = Summary {
        bag: bag.path().to_owned(),
        n_messages,
        n_topics: selection.topics.len(),
        left_out,
        took_s: took.as_secs_f64(),
        late_s: late.as_secs_f64(),
        damage: recorded_run::break_in(bag),
    };
    report(format, &summary, &text(&summary))?;
    Ok(if summary.damage.is_some() { Outcome::NegativeAnswer } else { Outcome::Done })
}

fn text(summary: &Summary) -> String {
    let mut text = format!(
        "{}: {} on {} in {:.1} s, at most {:.3} s late",
        summary.bag.display(),
        counted(summary.n_messages, "message"),
        counted(summary.n_topics as u64, "topic"),
        summary.took_s,
        summary.late_s
    );
    if let Some(damage) = &summary.damage {
        text.extend(["\n", damage]);
    }
    text
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
    selection: &Selection,
    pace: &Pace,
) -> anyhow::Result<Played> {
    let mut publishers = BTreeMap::new();
    for topic in &selection.topics {
        let publisher = session.publish_raw(&topic.name, &topic.type_name, topic.qos)?;
        publishers.insert(topic.name.as_str(), publisher);
    }
    // A bag with its own clock keeps it.
    let clock = if publishers.contains_key(topics::CLOCK.name) {
        None
    } else {
        Some(ClockPublisher::new(session, &session.node("/", "replay")?)?)
    };
    let controls = controls::listen();
    if pace.is_paused && controls.is_none() {
        anyhow::bail!("`--pause` without a terminal, in which nobody could go on");
    }
    let mut player = Player {
        publishers,
        clock,
        controls,
        rate: pace.rate,
        state: if pace.is_paused { State::Paused } else { State::Playing },
        anchor: None,
        n_messages: 0,
        late: Duration::ZERO,
    };
    let began = Instant::now();
    let ended = tokio::select! {
        request = shutdown::requested() => { request?; Ok(()) }
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

/// Somebody who plays a bag.
struct Player<'a> {
    publishers: BTreeMap<&'a str, RawPublisher>,
    clock: Option<ClockPublisher>,
    controls: Option<UnboundedReceiver<Wish>>,
    rate: f64,
    state: State,
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
        loop {
            self.anchor = None;
            let n_before = self.n_messages;
            self.once(bag, from_ns).await?;
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
            if self.state == State::Quit {
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
        Ok(())
    }

    /// Waits until a message is due, and hears what the person at the keyboard wants.
    async fn wait_for(&mut self, log_ns: u64) -> anyhow::Result<()> {
        loop {
            match self.state {
                State::Quit => return Ok(()),
                State::Stepping(None) => {
                    self.state = State::Stepping(Some(log_ns));
                    self.anchor = Some((log_ns, Instant::now()));
                    return self.say_time(log_ns).await;
                }
                State::Stepping(Some(now_ns)) if log_ns <= now_ns => return Ok(()),
                State::Stepping(Some(_)) => self.state = State::Paused,
                State::Paused => {
                    let wish = self.next_wish().await;
                    self.obey(wish);
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
            self.say_time(log_ns).await?;
            return Ok(true);
        }
        let glance = due.min(now + CLOCK_PERIOD);
        tokio::select! {
            () = tokio::time::sleep_until(glance.into()) => {
                let passed_ns = nanoseconds(from.elapsed().as_secs_f64() * self.rate);
                self.say_time(log_ns.min(from_ns.saturating_add(passed_ns))).await?;
            }
            wish = next_wish(&mut self.controls) => self.obey(wish),
        }
        Ok(false)
    }

    async fn say_time(&self, time_ns: u64) -> anyhow::Result<()> {
        match &self.clock {
            Some(clock) => Ok(clock.publish(time_ns).await?),
            None => Ok(()),
        }
    }

    async fn next_wish(&mut self) -> Wish {
        next_wish(&mut self.controls).await
    }

    fn obey(&mut self, wish: Wish) {
        self.state = match (wish, self.state) {
            (Wish::Quit, _) => State::Quit,
            (Wish::Step, _) => State::Stepping(None),
            (Wish::Toggle, State::Playing) => State::Paused,
            (Wish::Toggle, _) => State::Playing,
        };
        if self.state == State::Paused {
            say_note("paused; Enter goes on, `s` and Enter makes a step, `q` and Enter ends");
        }
    }
}

/// Whole nanoseconds in so many seconds, which are not negative; more than fit are as many as fit.
fn nanoseconds(seconds: f64) -> u64 {
    let duration = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

/// The next thing that the person at the keyboard wants; never, where there is none.
async fn next_wish(controls: &mut Option<UnboundedReceiver<Wish>>) -> Wish {
    if let Some(receiver) = controls {
        match receiver.recv().await {
            Some(wish) => return wish,
            // The keyboard is gone.
            None => *controls = None,
        }
    }
    std::future::pending().await
}
