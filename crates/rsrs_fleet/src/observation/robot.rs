//! What is known of one robot.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use rsrs_core::robot::controller::Command;
use rsrs_core::robot::sensor::MOST_READINGS;
use rsrs_core::robot::unicycle::Pose;

use super::Freshness;
use crate::message::{Lease, LeaseState, RobotState, Status, StopCause};
use crate::timing::{NODE_TIMEOUT, POSE_TIMEOUT, SENSOR_TIMEOUT};
use crate::wire::Diagnosis;
use rsrs_core::robot::pose_source::PoseSource;

/// Over how long a rate is taken.
const WINDOW: Duration = Duration::from_secs(3);
/// Samples that are remembered for a rate: fast topics need no more.
const MOST_SAMPLES: usize = 64;

/// A value, and when it was received.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen<T> {
    /// The value.
    pub value: T,
    /// When.
    pub at: Duration,
}

impl<T> Seen<T> {
    /// How long ago it was received.
    pub fn age(&self, now: Duration) -> Duration {
        now.saturating_sub(self.at)
    }
}

/// How often samples of a topic come.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rate(VecDeque<Duration>);

impl Rate {
    /// A sample came.
    pub fn received(&mut self, now: Duration) {
        if self.0.len() == MOST_SAMPLES {
            self.0.pop_front();
        }
        self.0.push_back(now);
    }

    /// Samples in a second, over the last three; `None` before the second sample ever.
    ///
    /// When samples stay away it falls, down to 0 after three seconds.
    pub fn hz(&self, now: Duration) -> Option<f64> {
        if self.0.len() < 2 {
            return None;
        }
        let recent = self.0.iter().filter(|at| now.saturating_sub(**at) <= WINDOW);
        let times: Vec<Duration> = recent.copied().collect();
        let [first, .., last] = times[..] else { return Some(0.0) };
        let n_intervals = (times.len() - 1) as f64;
        let span_s = last.saturating_sub(first).as_secs_f64();
        let silence_s = now.saturating_sub(last).as_secs_f64();
        // A sample that is not due yet is evidence of nothing.
        let overdue_s = (silence_s - 2.0 * span_s / n_intervals).max(0.0);
        let all_s = span_s + overdue_s;
        (all_s > 0.0).then(|| n_intervals / all_s)
    }
}

/// What a robot does, by its newest status and that status' age.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// No status was ever received.
    Unseen,
    /// Its statuses stay away.
    Silent,
    /// It belongs to no run.
    Idle,
    /// It is bound to a run that has not started.
    Armed,
    /// It may move.
    Moving,
    /// It stands, for this cause.
    Stopped(StopCause),
    /// The e-stop holds it.
    EStop,
    /// Its hardware has failed.
    Fault,
}

impl Condition {
    /// In at most eight letters.
    pub fn label(self) -> &'static str {
        match self {
            Self::Unseen => "unseen",
            Self::Silent => "silent",
            Self::Idle => "idle",
            Self::Armed => "armed",
            Self::Moving => "moving",
            Self::Stopped(StopCause::Lease) => "no lease",
            Self::Stopped(StopCause::Controller) => "no ctrl",
            Self::Stopped(StopCause::NotArmed) => "unarmed",
            Self::Stopped(StopCause::NoWorld) => "no world",
            Self::Stopped(_) => "stopped",
            Self::EStop => "E-STOP",
            Self::Fault => "FAULT",
        }
    }

    /// Whether a person should look.
    pub fn is_alarming(self) -> bool {
        match self {
            Self::Silent | Self::EStop | Self::Fault => true,
            Self::Stopped(cause) => matches!(cause, StopCause::Lease | StopCause::Controller),
            Self::Unseen | Self::Idle | Self::Armed | Self::Moving => false,
        }
    }
}

/// The runner's lease from a robot's point of view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeaseView {
    /// No lease is received.
    None,
    /// The lease does not name it.
    NotNamed,
    /// The lease names it, and it obeys another epoch, or none.
    OtherEpoch,
    /// It obeys the lease, which lets it do this.
    Holds(LeaseState),
}

impl LeaseView {
    /// In at most eight letters.
    pub fn label(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::NotNamed => "not in",
            Self::OtherEpoch => "other",
            Self::Holds(LeaseState::Idle) => "idle",
            Self::Holds(LeaseState::Armed) => "armed",
            Self::Holds(LeaseState::Running) => "running",
            Self::Holds(LeaseState::Stopped) => "stopped",
        }
    }
}

/// What was said of a part is forgotten after this; diagnoses come once a second.
const DIAGNOSIS_TIMEOUT: Duration = Duration::from_secs(5);
/// Parts of a robot with which something may be wrong at a time.
const MOST_PARTS: usize = 32;

/// One robot.
#[derive(Clone, Debug, Default)]
pub struct ObservedRobot {
    freshness: Freshness,
    /// Its newest detection.
    pub detection: Option<Seen<bool>>,
    /// The newest of each further sensor, by name.
    further: BTreeMap<String, Seen<bool>>,
    /// How often detections come.
    pub detection_rate: Rate,
    /// Its newest command.
    pub command: Option<Seen<Command>>,
    /// How often commands come.
    pub command_rate: Rate,
    /// Its newest status.
    pub status: Option<Seen<Status>>,
    /// The newest lease that names it, as far as it is for it.
    pub(super) lease: Option<Seen<Lease>>,
    odometry: Option<Seen<Pose>>,
    odometry_rate: Rate,
    tracked: Option<Seen<Pose>>,
    tracked_rate: Rate,
    /// By part, what is wrong with it.
    faults: BTreeMap<String, Seen<String>>,
}

impl ObservedRobot {
    /// One of which nothing was received yet.
    pub(super) fn watched(freshness: Freshness) -> Self {
        Self { freshness, ..Self::default() }
    }

    pub(super) fn take_pose(&mut self, source: PoseSource, pose: Pose, now: Duration) {
        let (slot, rate) = match source {
            PoseSource::Odom => (&mut self.odometry, &mut self.odometry_rate),
            PoseSource::Pose | PoseSource::NamedPoses | PoseSource::PoseArray | PoseSource::Tf => {
                (&mut self.tracked, &mut self.tracked_rate)
            }
        };
        *slot = Some(Seen { value: pose, at: now });
        rate.received(now);
    }

    /// Takes a further reading, of as many as a robot can have.
    #[expect(clippy::fn_params_excessive_bools, reason = "binary is what a reading is")]
    pub(super) fn take_reading(&mut self, reading: String, is_true: bool, now: Duration) {
        if self.further.contains_key(&reading) || self.further.len() < MOST_READINGS - 1 {
            self.further.insert(reading, Seen { value: is_true, at: now });
        }
    }

    /// What its further sensors reported last, by name.
    pub fn further_readings(&self) -> impl Iterator<Item = (&str, Seen<bool>)> {
        self.further.iter().map(|(name, seen)| (name.as_str(), *seen))
    }

    /// A message that was late, or came again, changes nothing.
    pub(super) fn take_status(&mut self, status: Status, now: Duration) {
        let last = self.status.as_ref().map(|seen| (seen.value.counter, seen.at));
        if status.is_news(last, now) {
            self.status = Some(Seen { value: status, at: now });
        }
    }

    pub(super) fn take_diagnosis(&mut self, diagnosis: Diagnosis, now: Duration) {
        let Diagnosis { part, error, .. } = diagnosis;
        let Some(message) = error else {
            self.faults.remove(&part);
            return;
        };
        self.faults.retain(|_, seen| seen.age(now) <= DIAGNOSIS_TIMEOUT);
        if self.faults.contains_key(&part) || self.faults.len() < MOST_PARTS {
            self.faults.insert(part, Seen { value: message, at: now });
        }
    }

    /// What parts of it say is wrong with them, as far as they still say so: part and message.
    pub fn faults(&self, now: Duration) -> impl Iterator<Item = (&str, &str)> {
        let lasts = move |seen: &Seen<String>| seen.age(now) <= DIAGNOSIS_TIMEOUT;
        let faults = self.faults.iter().filter(move |(_, seen)| lasts(seen));
        faults.map(|(part, seen)| (part.as_str(), seen.value.as_str()))
    }

    /// Where it is: as a tracker sees it, unless none does; each robot's own estimate has an origin
    /// of its own.
    pub fn pose(&self, now: Duration) -> Option<Seen<Pose>> {
        self.tracked
            .filter(|pose| self.odometry.is_none() || pose.age(now) <= POSE_TIMEOUT)
            .or(self.odometry)
    }

    /// How often poses come, from where they are taken.
    pub fn pose_hz(&self, now: Duration) -> Option<f64> {
        let is_tracked = self.tracked.is_some() && self.pose(now) == self.tracked;
        let rate = if is_tracked { &self.tracked_rate } else { &self.odometry_rate };
        rate.hz(now)
    }

    /// Whether it detected another one within the last second.
    pub fn detects(&self, now: Duration) -> Option<bool> {
        let detection = self.detection.filter(|seen| seen.age(now) <= SENSOR_TIMEOUT)?;
        Some(detection.value)
    }

    /// What it does.
    pub fn condition(&self, now: Duration) -> Condition {
        let Some(Seen { value: status, .. }) = &self.status else { return Condition::Unseen };
        if self.status.as_ref().is_some_and(|seen| !self.freshness.lasts(seen.age(now))) {
            return Condition::Silent;
        }
        match status.state {
            RobotState::Fault => Condition::Fault,
            _ if status.holds_e_stop() => Condition::EStop,
            RobotState::Idle if status.is_without_world() => Condition::Stopped(StopCause::NoWorld),
            RobotState::Idle => Condition::Idle,
            RobotState::Armed => Condition::Armed,
            RobotState::Moving => Condition::Moving,
            RobotState::Stopped => Condition::Stopped(status.stop_cause),
        }
    }

    /// Its battery voltage, if it publishes one.
    pub fn battery_v(&self) -> Option<f32> {
        let battery_v = self.status.as_ref()?.value.battery_v;
        battery_v.is_finite().then_some(battery_v)
    }

    /// Whether a command that is not zero came within the last second.
    pub(super) fn is_commanded_to_move(&self, now: Duration) -> bool {
        let moves = |command: &Command| command.speed_m_s != 0.0 || command.turn_rate_rad_s != 0.0;
        self.command.is_some_and(|seen| moves(&seen.value) && seen.age(now) <= NODE_TIMEOUT)
    }
}
