//! Stops everything: publishes the stop until every robot has acknowledged, with or without a
//! runner.
//!
//! A robot acknowledges by its status: while the e-stop holds it, it is stopped and its reason begins
//! with [`E_STOP_REASON`](crate::message::E_STOP_REASON). The lock outlives its source. A robot
//! that was stopped in a run stands until a newer epoch arms it, released or not.
//!
//! A release names the locks that it ends, as the robots report them. It leaves alone what still holds:
//! a source that still publishes `true`, or has and is still there to publish `false`.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use serde::Serialize;

use crate::e_stop::{LockCause, Locks, Message, Source};
use crate::message::{RobotState, Status};
use crate::timing::{ACKNOWLEDGE_TIMEOUT, NODE_TIMEOUT, REPEAT_PERIOD, Transport};

/// What every robot is to receive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StopCommand {
    /// Stand, whatever else is published.
    #[default]
    #[serde(rename = "stop")]
    Engage,
    /// A newer epoch may move you.
    Release,
}

/// What happens to a stopper.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// There is a robot of this name, or there should be.
    Discovered {
        /// The robot.
        robot: String,
    },
    /// The status of a robot.
    Status {
        /// The robot.
        robot: String,
        /// Its status.
        status: Status,
    },
    /// A message on one of the e-stop's topics; another release is no business of ours.
    EStop(Message),
    /// Publishers of the e-stop topic that are there now, without our own.
    Publishers(BTreeSet<Source>),
    /// Someone does not want to wait any longer.
    Interrupt,
    /// Time passed.
    Tick,
}

/// What a stopper does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Action {
    /// Publish this on the e-stop topic.
    Publish(bool),
    /// Release the locks of these sources.
    Release(BTreeSet<Source>),
    /// It is over, and so it ended; nothing more comes.
    Finish(StopOutcome),
}

/// How a stop or release ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopOutcome {
    /// Every known robot has acknowledged, and there is at least one.
    Acknowledged,
    /// The time is up, and some robot has not acknowledged, or there is none.
    TimedOut,
    /// It was interrupted while some robot had not acknowledged.
    Interrupted,
    /// A release would do harm: robots are in a run, and would take the silence after it for a stop.
    /// Nothing was published.
    InRun,
}

/// What came of a stop for one robot.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotAcknowledgement {
    /// The robot.
    pub robot: String,
    /// From the first message until its acknowledgement was received; `None` if it has not acknowledged.
    pub acknowledged_after: Option<Duration>,
    /// Its last status; `None` if none was received.
    pub last: Option<Status>,
}

/// Robots that are followed; no fleet of this protocol is that large.
pub const MOST_ROBOTS: usize = 1_000;

/// Stops, or releases, every robot there is.
#[derive(Clone, Debug, Default)]
pub struct Stopper {
    command: StopCommand,
    robots: BTreeMap<String, LastStatus>,
    /// By who reports them: the locks of robots.
    locks: BTreeMap<Source, Locks>,
    /// When each source published `true` last.
    engaged_at: BTreeMap<Source, Duration>,
    present: BTreeSet<Source>,
    started: Option<Duration>,
    /// When the command was published first, and last.
    published: Option<(Duration, Duration)>,
    is_interrupted: bool,
    is_over: bool,
    transport: Transport,
}

#[derive(Clone, Debug, Default)]
struct LastStatus {
    /// Its newest status, and when it came.
    last: Option<(Status, Duration)>,
    acknowledged: Option<Duration>,
}

impl Stopper {
    /// A stopper without robots that has published nothing.
    pub fn new(command: StopCommand) -> Self {
        Self { command, ..Self::default() }
    }

    /// The same over another transport, on which it depends how long it looks for robots.
    #[must_use]
    pub fn over(self, transport: Transport) -> Self {
        Self { transport, ..self }
    }

    /// Takes an event, and returns what to do, in order.
    pub fn on_event(&mut self, event: Event, now: Duration) -> Vec<Action> {
        if self.is_over {
            return Vec::new();
        }
        let started = *self.started.get_or_insert(now);
        self.take(event, now);

        let elapsed = now.saturating_sub(started);
        let mut actions = self.due_messages(elapsed, now);
        if let Some(ending) = self.ending(elapsed) {
            self.is_over = true;
            actions.push(Action::Finish(ending));
        }
        actions
    }

    /// What came of it for each robot so far, by name.
    pub fn answers(&self) -> Vec<RobotAcknowledgement> {
        let first = self.published.map_or(Duration::ZERO, |(first, _)| first);
        let answers = self.robots.iter().map(|(robot, received)| RobotAcknowledgement {
            robot: robot.clone(),
            acknowledged_after: received.acknowledged.map(|at| at.saturating_sub(first)),
            last: received.last.as_ref().map(|(status, _)| status.clone()),
        });
        answers.collect()
    }

    fn take(&mut self, event: Event, now: Duration) {
        match event {
            Event::Discovered { robot } => {
                if self.follows(&robot) {
                    self.robots.entry(robot).or_default();
                }
            }
            Event::Status { robot, .. } if !self.follows(&robot) => {}
            Event::Status { robot, status } => {
                let (command, is_published) = (self.command, self.published.is_some());
                let received = self.robots.entry(robot).or_default();
                let last = received.last.as_ref().map(|(status, at)| (status.counter, *at));
                if !status.is_news(last, now) {
                    return;
                }
                // A status that contradicts an earlier one counts: another command may have come after
                // ours.
                received.acknowledged = (is_published && acknowledges(command, &status))
                    .then(|| received.acknowledged.unwrap_or(now));
                received.last = Some((status, now));
            }
            Event::EStop(Message::State { source, engaged: true }) => {
                let is_known = self.engaged_at.contains_key(&source);
                if is_known || self.engaged_at.len() < MOST_ROBOTS {
                    self.engaged_at.insert(source, now);
                }
            }
            Event::EStop(Message::State { source, engaged: false }) => {
                self.engaged_at.remove(&source);
            }
            Event::EStop(Message::Locks { reporter, locks }) => {
                if self.locks.contains_key(&reporter) || self.locks.len() < MOST_ROBOTS {
                    self.locks.insert(reporter, locks);
                }
            }
            Event::Publishers(present) => self.present = present,
            Event::Interrupt => self.is_interrupted = true,
            Event::EStop(Message::Release(_)) | Event::Tick => {}
        }
    }

    /// Whether it follows a robot of this name, or has room for one more.
    ///
    /// Names come from the network, and a sender may send any number.
    pub fn follows(&self, robot: &str) -> bool {
        self.robots.contains_key(robot) || self.robots.len() < MOST_ROBOTS
    }

    /// Publishes the command ten times a second; a release only after a look at what it would do.
    fn due_messages(&mut self, elapsed: Duration, now: Duration) -> Vec<Action> {
        if self.published.is_none()
            && self.command == StopCommand::Release
            && (elapsed < self.transport.robot_search_duration() || self.is_in_run())
        {
            return Vec::new();
        }
        if self.published.is_some_and(|(_, last)| now.saturating_sub(last) < REPEAT_PERIOD) {
            return Vec::new();
        }
        let first = self.published.map_or(now, |(first, _)| first);
        self.published = Some((first, now));
        if self.command == StopCommand::Engage {
            return vec![Action::Publish(true)];
        }
        // Locks without sources, as that of twist_mux, receive a `false`.
        let holding = self.holding(now);
        let all = self.all_locks().0.into_keys();
        let released: BTreeSet<_> = all.filter(|source| !holding.0.contains_key(source)).collect();
        let release = (!released.is_empty()).then_some(Action::Release(released));
        [Action::Publish(false)].into_iter().chain(release).collect()
    }

    /// Locks that no release ends: their sources are there to do it, or still publish `true`.
    pub fn holding(&self, now: Duration) -> Locks {
        let mut locks = self.all_locks();
        let is_repeated = |source: &Source| {
            self.engaged_at.get(source).is_some_and(|at| now.saturating_sub(*at) <= NODE_TIMEOUT)
        };
        locks.0.retain(|source, cause| {
            is_repeated(source) || (*cause == LockCause::Engaged && self.present.contains(source))
        });
        locks
    }

    /// Every lock that a robot reports.
    fn all_locks(&self) -> Locks {
        let mut all = BTreeMap::new();
        for (source, cause) in self.locks.values().flat_map(|locks| &locks.0) {
            let worst = all.entry(*source).or_insert(*cause);
            *worst = (*worst).min(*cause);
        }
        Locks(all)
    }

    fn ending(&self, elapsed: Duration) -> Option<StopOutcome> {
        let all = !self.robots.is_empty()
            && self.robots.values().all(|received| received.acknowledged.is_some());
        if self.command == StopCommand::Release
            && elapsed >= self.transport.robot_search_duration()
            && self.published.is_none()
        {
            return Some(StopOutcome::InRun);
        }
        if all && elapsed >= self.transport.robot_search_duration() {
            Some(StopOutcome::Acknowledged)
        } else if self.is_interrupted {
            Some(if all { StopOutcome::Acknowledged } else { StopOutcome::Interrupted })
        } else {
            (elapsed >= self.transport.robot_search_duration() + ACKNOWLEDGE_TIMEOUT)
                .then_some(StopOutcome::TimedOut)
        }
    }

    fn is_in_run(&self) -> bool {
        let last = self.robots.values().filter_map(|received| received.last.as_ref());
        last.into_iter()
            .any(|(status, _)| matches!(status.state, RobotState::Armed | RobotState::Moving))
    }
}

/// A robot whose hardware has failed reports that, and that the e-stop holds it: it may be
/// repaired.
fn acknowledges(command: StopCommand, status: &Status) -> bool {
    match command {
        StopCommand::Engage => status.holds_e_stop(),
        StopCommand::Release => !status.holds_e_stop(),
    }
}

#[cfg(test)]
mod tests;
