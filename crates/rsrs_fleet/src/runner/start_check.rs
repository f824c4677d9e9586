//! What the runner has received besides statuses: clocks, diagnoses, poses, the e-stop.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::Duration;

use rsrs_core::robot::unicycle::Pose;

use crate::placement::{self, WantedStart};
use crate::preflight::{ClockLead, DiagnosticError, Problem};
use crate::timing::CLOCK_LOOK;

/// What was received of robots before and during a run.
#[derive(Clone, Debug, Default)]
pub(super) struct StartCheck {
    clocks: BTreeMap<String, Clock>,
    behind_s: Recent,
    /// By robot and part: the diagnosis.
    diagnostic_errors: BTreeMap<(String, String), String>,
    /// By robot: the frame and the last pose in it.
    pub(super) poses: BTreeMap<String, (String, Pose)>,
    /// By robot: why its last pose cannot be used.
    pub(super) unusable_poses: BTreeMap<String, String>,
    /// By robot: how many poses came, since when, and when the last one did.
    pose_times: BTreeMap<String, PoseTimes>,
    /// By which each robot's poses are stamped.
    pose_clocks: BTreeMap<String, Clock>,
    /// By frame: the frame that it is in.
    pub(super) parents: BTreeMap<String, String>,
}

/// When poses of a robot came.
#[derive(Clone, Copy, Debug)]
struct PoseTimes {
    n_poses: u32,
    first: Duration,
    last: Duration,
}

/// Poses that come less often than this, in Hz, are reported: a robot moves far between two of
/// them.
const FEW_POSES_HZ: f64 = 5.0;

/// Errors of diagnostics that are kept; names of parts are anybody's.
const MOST_ERRORS: usize = 1_000;

/// Frames that are kept; trees of transforms are smaller.
const MOST_FRAMES: usize = 10_000;

/// The last numbers of a kind, as many as statuses and leases come in half a second.
#[derive(Clone, Debug, Default)]
struct Recent(VecDeque<f64>);

impl Recent {
    const LENGTH: usize = 10;

    fn push(&mut self, number: f64) {
        self.0.truncate(Self::LENGTH - 1);
        self.0.push_front(number);
    }

    fn largest(&self) -> Option<f64> {
        self.0.iter().copied().reduce(f64::max)
    }
}

/// A clock as its stamps show it.
///
/// The way of a message makes it old and never young: the largest of several leads is nearest to the
/// clock's.
#[derive(Clone, Debug)]
struct Clock {
    /// Its lead in the first moments, in seconds.
    early_s: f64,
    recent: Recent,
    first: Duration,
    last: Duration,
}

/// How long the first moments of a clock are.
const EARLY: Duration = Duration::from_millis(500);

impl Clock {
    fn receive(clocks: &mut BTreeMap<String, Self>, robot: String, ahead_s: f64, now: Duration) {
        let new = || Self { early_s: ahead_s, recent: Recent::default(), first: now, last: now };
        let clock = clocks.entry(robot).or_insert_with(new);
        if now.saturating_sub(clock.first) <= EARLY {
            clock.early_s = clock.early_s.max(ahead_s);
        }
        clock.recent.push(ahead_s);
        clock.last = now;
    }

    fn leads(clocks: &BTreeMap<String, Self>) -> BTreeMap<String, ClockLead> {
        let lead = |(robot, clock): (&String, &Self)| {
            let ahead_s = clock.recent.largest()?;
            let is_known = clock.last.saturating_sub(clock.first) >= CLOCK_LOOK;
            let change_s = is_known.then_some(ahead_s - clock.early_s);
            Some((robot.clone(), ClockLead { ahead_s, change_s }))
        };
        clocks.iter().filter_map(lead).collect()
    }
}

impl StartCheck {
    pub(super) fn receive_clock(&mut self, robot: String, ahead_s: f64, now: Duration) {
        Clock::receive(&mut self.clocks, robot, ahead_s, now);
    }

    pub(super) fn receive_delay(&mut self, behind_s: f64) {
        self.behind_s.push(behind_s);
    }

    /// Returns a note for the operator, if it is news of an error.
    pub(super) fn receive_diagnosis(
        &mut self,
        robot: String,
        part: String,
        error: Option<String>,
    ) -> Option<String> {
        let Some(message) = error else {
            self.diagnostic_errors.remove(&(robot, part));
            return None;
        };
        if self.diagnostic_errors.len() >= MOST_ERRORS {
            return None;
        }
        let text = format!("diagnostics of {robot}: {part}: {message}");
        self.diagnostic_errors.insert((robot, part), message).is_none().then_some(text)
    }

    pub(super) fn receive_pose(&mut self, robot: String, frame: String, pose: Pose, now: Duration) {
        let first = PoseTimes { n_poses: 0, first: now, last: now };
        let times = self.pose_times.entry(robot.clone()).or_insert(first);
        *times = PoseTimes { n_poses: times.n_poses + 1, last: now, ..*times };
        self.unusable_poses.remove(&robot);
        self.poses.insert(robot, (frame, pose));
    }

    /// Returns a note for the operator, if it is the first of the robot.
    pub(super) fn receive_unusable_pose(
        &mut self,
        robot: String,
        reason: String,
    ) -> Option<String> {
        self.poses.remove(&robot);
        let text = format!("a pose of {robot} cannot be used: {reason}");
        self.unusable_poses.insert(robot, reason).is_none().then_some(text)
    }

    /// Whether the pose of every robot is known, and how often it comes.
    pub(super) fn has_poses_of(&self, robots: &[String]) -> bool {
        let n_poses = |robot| self.pose_times.get(robot).map_or(0, |times| times.n_poses);
        robots.iter().all(|robot| n_poses(robot) >= 2)
    }

    /// Robots of which no pose was ever received.
    pub(super) fn without_poses(&self, robots: &[String]) -> Vec<String> {
        robots.iter().filter(|robot| !self.pose_times.contains_key(*robot)).cloned().collect()
    }

    /// How often poses of robots come, where that is seldom.
    fn few_poses(&self, robots: &[String]) -> Vec<String> {
        let rate_hz = |times: &PoseTimes| {
            let passed_s = times.last.saturating_sub(times.first).as_secs_f64();
            let intervals = times.n_poses.checked_sub(1).filter(|intervals| *intervals > 0)?;
            (passed_s > 0.0).then(|| f64::from(intervals) / passed_s)
        };
        let few = robots.iter().filter_map(|robot| {
            let rate_hz = rate_hz(self.pose_times.get(robot)?).filter(|hz| *hz < FEW_POSES_HZ)?;
            Some(format!("poses of {robot} come at {rate_hz:.1} Hz, expected 10 Hz or more"))
        });
        few.collect()
    }

    pub(super) fn receive_pose_clock(&mut self, robot: String, ahead_s: f64, now: Duration) {
        Clock::receive(&mut self.pose_clocks, robot, ahead_s, now);
    }

    pub(super) fn receive_transform(&mut self, child: &str, parent: String) {
        if self.parents.len() < MOST_FRAMES {
            let child = child.trim_start_matches('/').to_owned();
            self.parents.insert(child, parent);
        }
    }

    pub(super) fn pose_clocks(&self) -> BTreeMap<String, ClockLead> {
        Clock::leads(&self.pose_clocks)
    }

    pub(super) fn clocks(&self) -> BTreeMap<String, ClockLead> {
        Clock::leads(&self.clocks)
    }

    /// The longest wait of the last second on this machine.
    pub(super) fn behind_s(&self) -> Option<f64> {
        self.behind_s.largest()
    }

    pub(super) fn diagnostic_errors(&self) -> BTreeSet<DiagnosticError> {
        let diagnostic_errors = self.diagnostic_errors.iter().map(|((robot, part), message)| {
            DiagnosticError { robot: robot.clone(), part: part.clone(), message: message.clone() }
        });
        diagnostic_errors.collect()
    }

    /// Note for the operator on where the robots stand.
    pub(super) fn standing_places(&self, wanted: &WantedStart, robots: &[String]) -> Vec<String> {
        let (known, unknown): (Vec<_>, Vec<_>) =
            robots.iter().enumerate().partition(|(_, robot)| self.poses.contains_key(*robot));
        if known.is_empty() {
            return vec!["start poses not checked: no pose was received".to_owned()];
        }
        if let Some(frames) = self.frames_of(robots) {
            return vec![format!(
                "start poses not checked: they are in different frames, {frames}"
            )];
        }
        let deviations = placement::deviations(wanted, &self.known_poses(robots));
        let notes = unknown.iter().map(|(_, robot)| format!("{robot}: no pose received"));
        let mut notes: Vec<_> = notes.chain(deviations.iter().map(ToString::to_string)).collect();
        if notes.is_empty() {
            notes.push(format!("all {} robots stand where they should start", robots.len()));
        }
        notes.extend(self.few_poses(robots));
        notes
    }

    /// Why robots cannot be held to stand where they should start; nothing if all of them do.
    pub(super) fn misplaced(&self, wanted: &WantedStart, robots: &[String]) -> Vec<Problem> {
        let unknown = robots.iter().filter(|robot| !self.poses.contains_key(*robot));
        let unknown = unknown.map(|robot| Problem::PlaceUnknown { robot: robot.clone() });
        let frames = self.frames_of(robots).map(|frames| Problem::PlacesInFrames { frames });
        let is_one_frame = frames.is_none();
        let mut problems: Vec<Problem> = unknown.chain(frames).collect();
        if is_one_frame {
            let deviations = placement::deviations(wanted, &self.known_poses(robots));
            problems.extend(deviations.into_iter().map(Problem::Misplaced));
        }
        problems
    }

    /// Numbers, names and poses of those robots whose pose is known.
    fn known_poses(&self, robots: &[String]) -> Vec<(usize, String, Pose)> {
        let known = robots.iter().enumerate().filter_map(|(number, robot)| {
            let (_, pose) = self.poses.get(robot)?;
            Some((number, robot.clone(), *pose))
        });
        known.collect()
    }

    /// The frames of their poses, if there are several.
    fn frames_of(&self, robots: &[String]) -> Option<String> {
        let known = robots.iter().filter_map(|robot| self.poses.get(robot));
        let frames: BTreeSet<&String> = known.map(|(frame, _)| frame).collect();
        let names: Vec<String> = frames.into_iter().map(|frame| format!("`{frame}`")).collect();
        (names.len() > 1).then(|| names.join(", "))
    }
}
