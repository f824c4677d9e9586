//! What the runner last received from each robot and its controller.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use rsrs_core::robot::unicycle::Pose;

use super::pauses::Pauses;
use super::{Failure, LossCause, SampleKind};
use crate::geofence::Geofence;
use crate::message::{Echo, RobotState, Status, StopCause};
use crate::record::PausedRobot;
use crate::timing::{
    DETECTION_TIMEOUT, NODE_TIMEOUT, OUTSIDE_POSES, OUTSIDE_TIMEOUT, POSE_TIMEOUT, STAND_TIMEOUT,
};

/// The robots of a run, in its order.
#[derive(Clone, Debug)]
pub(super) struct Roster {
    members: Vec<Member>,
    /// By name: the place among the members.
    places: BTreeMap<String, usize>,
    /// The epoch in which robots move now; `None` before and after.
    moving_in: Option<u64>,
}

#[derive(Clone, Debug, Default)]
struct Member {
    name: String,
    robot: Option<LastStatus>,
    controller: Option<LastStatus>,
    /// When the last sample of each kind came, since the start of the movement.
    samples: BTreeMap<SampleKind, Duration>,
    /// Since when it is not as it should be during the run.
    troubled_since: Option<Duration>,
    pauses: Pauses,
    /// Where it is outside of the geofence, if its last poses are there.
    outside: Option<Outside>,
    /// When it was lost, if it was.
    lost: Option<Duration>,
    /// It was lost, and has not been received since.
    is_silent: bool,
    /// What was last noted of whether it stands, since it was lost.
    noted: Option<Standing>,
}

/// Where a robot is that has left the geofence.
#[derive(Clone, Copy, Debug)]
struct Outside {
    since: Duration,
    n_poses: u32,
    last: Pose,
}

impl Outside {
    /// Whether it is no single pose that is wrong.
    fn is_certain(self, now: Duration) -> bool {
        self.n_poses >= OUTSIDE_POSES || now.saturating_sub(self.since) >= OUTSIDE_TIMEOUT
    }
}

/// Whether a lost robot stands, as far as its statuses tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Standing {
    Stands,
    /// It should, and reports that it moves.
    Moves,
}

#[derive(Clone, Debug)]
struct LastStatus {
    status: Status,
    at: Duration,
}

impl LastStatus {
    /// Keeps the newer of two statuses. Returns whether that is this one.
    fn receive(slot: &mut Option<Self>, status: Status, at: Duration) -> bool {
        let last = slot.as_ref().map(|last| (last.status.counter, last.at));
        let is_news = status.is_news(last, at);
        if is_news {
            *slot = Some(Self { status, at });
        }
        is_news
    }

    fn is_recent(&self, now: Duration) -> bool {
        now.saturating_sub(self.at) <= NODE_TIMEOUT
    }
}

/// What a run expects its robots to report.
#[derive(Clone, Copy, Debug)]
pub(super) struct RunBinding<'a> {
    pub run_id: &'a str,
    pub epoch: u64,
    pub parameter_digest: u64,
}

/// How long a robot may be not as it should be during a run.
#[derive(Clone, Copy, Debug)]
pub(super) struct LossTimeouts {
    /// It stands.
    pub standing: Duration,
    /// It stands because its lease ran out, and may be let go on.
    pub paused: Duration,
    /// It has not been received for as long as robots may be silent.
    pub silent: Duration,
}

/// Whether a robot stands because its lease ran out, and may still be let go on in this epoch; its
/// controller, too, may have been out of reach. What is final is reported as that.
fn may_heal(status: &Status, epoch: u64) -> bool {
    status.epoch == epoch
        && status.state == RobotState::Stopped
        && matches!(status.stop_cause, StopCause::Lease | StopCause::Controller)
}

impl Roster {
    pub(super) fn new(robots: &[String]) -> Self {
        let members =
            robots.iter().map(|name| Member { name: name.clone(), ..Member::default() }).collect();
        let places = robots.iter().enumerate().map(|(place, name)| (name.clone(), place)).collect();
        Self { members, places, moving_in: None }
    }

    fn member(&mut self, name: &str) -> Option<&mut Member> {
        self.places.get(name).map(|place| &mut self.members[*place])
    }

    /// Whether it is a robot of the run.
    pub(super) fn has(&self, name: &str) -> bool {
        self.places.contains_key(name)
    }

    pub(super) fn receive_robot(&mut self, name: &str, status: Status, now: Duration) {
        let moving_in = self.moving_in;
        let Some(member) = self.member(name) else { return };
        let is_news = LastStatus::receive(&mut member.robot, status, now);
        if let (true, Some(epoch), Some(last)) = (is_news, moving_in, &member.robot)
            && last.status.epoch == epoch
            && member.lost.is_none()
        {
            member.pauses.receive(&last.status, now);
        }
    }

    pub(super) fn receive_controller(&mut self, name: &str, status: Status, now: Duration) {
        if let Some(member) = self.member(name) {
            LastStatus::receive(&mut member.controller, status, now);
        }
    }

    pub(super) fn receive_sample(&mut self, name: &str, kind: SampleKind, now: Duration) {
        if let Some(member) = self.member(name) {
            member.samples.insert(kind, now);
        }
    }

    /// Where a robot is while robots move.
    pub(super) fn receive_place(
        &mut self,
        name: &str,
        pose: Pose,
        geofence: Geofence,
        now: Duration,
    ) {
        let Some(member) = self.member(name) else { return };
        let is_inside = geofence.contains(pose);
        let before = member.outside.unwrap_or(Outside { since: now, n_poses: 0, last: pose });
        let n_poses = before.n_poses + 1;
        member.outside = (!is_inside).then_some(Outside { n_poses, last: pose, ..before });
    }

    /// The robots are about to move: samples count from now on.
    pub(super) fn forget_samples(&mut self) {
        for member in &mut self.members {
            member.samples.clear();
        }
    }

    /// The robots are about to move in this epoch: that one stands is a pause from now on.
    pub(super) fn follow_pauses(&mut self, epoch: u64, now: Duration) {
        self.moving_in = Some(epoch);
        for member in &mut self.members {
            member.pauses = Pauses::from(now);
        }
    }

    /// Ends the run's motion, and returns when robots stood because their leases had run out, in the
    /// order in which they did.
    pub(super) fn end(&mut self, now: Duration) -> Vec<PausedRobot> {
        self.moving_in = None;
        let pauses = self.members.iter_mut().flat_map(|member| {
            let name = member.name.clone();
            member.pauses.all(now).into_iter().map(move |(after_s, stood_s)| PausedRobot {
                robot: name.clone(),
                after_s,
                stood_s,
            })
        });
        let mut pauses: Vec<_> = pauses.collect();
        pauses.sort_by(|a, b| a.after_s.total_cmp(&b.after_s));
        pauses
    }

    /// Robots that go on after a pause that was not reported yet, and how long each stood at most.
    pub(super) fn newly_resumed(&mut self) -> Vec<(String, Duration)> {
        let resumed = self
            .members
            .iter_mut()
            .filter_map(|member| Some((member.name.clone(), member.pauses.take_news()?)));
        resumed.collect()
    }

    /// Robots of which no sample of some kind has come since the start.
    pub(super) fn without_samples(
        &self,
        kinds: &BTreeSet<SampleKind>,
    ) -> Vec<(String, SampleKind)> {
        let present = self.members.iter().filter(|member| member.lost.is_none());
        let missing = present.flat_map(|member| {
            let missing = kinds.iter().filter(|kind| !member.samples.contains_key(*kind));
            missing.map(|kind| (member.name.clone(), kind.clone()))
        });
        missing.collect()
    }

    /// How long no pose has come of each robot that is not lost, and of which one has come since the
    /// start.
    pub(super) fn pose_silences(&self, now: Duration) -> impl Iterator<Item = (&str, Duration)> {
        self.members.iter().filter(|member| member.lost.is_none()).filter_map(move |member| {
            let at = member.samples.get(&SampleKind::Pose)?;
            Some((member.name.as_str(), now.saturating_sub(*at)))
        })
    }

    /// The highest epoch that a robot or controller of this run obeys.
    pub(super) fn highest_epoch(&self) -> u64 {
        let sides = self.members.iter().flat_map(|member| [&member.robot, &member.controller]);
        sides.flatten().map(|received| received.status.epoch).max().unwrap_or(0)
    }

    /// Another run for whose start a robot or controller of this run waits, in this epoch: of two
    /// runners that cannot receive each other, both may have taken it.
    pub(super) fn armed_for_another(&self, binding: RunBinding<'_>, now: Duration) -> Option<&str> {
        let sides = self.members.iter().flat_map(|member| [&member.robot, &member.controller]);
        let recent = sides.flatten().filter(|received| received.is_recent(now));
        recent.filter(|received| received.status.epoch == binding.epoch).find_map(|received| {
            received.status.armed_for().filter(|run_id| *run_id != binding.run_id)
        })
    }

    /// Counters of the last statuses of all robots, for the lease.
    pub(super) fn echoes(&self) -> Vec<Echo> {
        self.members.iter().map(Member::echo).collect()
    }

    /// The same of those that were not lost: others are not to move.
    pub(super) fn echoes_of_present(&self) -> Vec<Echo> {
        self.members.iter().filter(|member| member.lost.is_none()).map(Member::echo).collect()
    }

    /// The last status of every robot that is received now.
    pub(super) fn recent_robots(&self, now: Duration) -> BTreeMap<String, Status> {
        self.members
            .iter()
            .filter_map(|member| Some((member.name.clone(), member.recent(now)?.clone())))
            .collect()
    }

    /// Robots whose controller is received now.
    pub(super) fn recent_controllers(&self, now: Duration) -> BTreeSet<String> {
        self.members
            .iter()
            .filter(|member| {
                member.controller.as_ref().is_some_and(|received| received.is_recent(now))
            })
            .map(|member| member.name.clone())
            .collect()
    }

    /// Robots that have not confirmed that they are armed for this run, with what they report
    /// instead.
    pub(super) fn not_armed(&self, binding: RunBinding<'_>, now: Duration) -> Vec<Unarmed> {
        let mut waiting = Vec::new();
        for member in &self.members {
            let sides = [("", &member.robot), (" (controller)", &member.controller)];
            for (side, received) in sides {
                if let Some((found, may_heal)) = unlike_armed(received.as_ref(), binding, now) {
                    let robot = format!("{}{side}", member.name);
                    let failure = Failure::NotArmed { robot, found };
                    waiting.push(Unarmed { failure, may_heal });
                }
            }
        }
        waiting
    }

    /// Robots that were lost just now: not as they should be for longer than the timeouts (a
    /// hardware fault is final at once), or standing for more than `most_paused` in all because
    /// their leases had run out.
    pub(super) fn newly_lost(
        &mut self,
        epoch: u64,
        timeouts: LossTimeouts,
        most_paused: Duration,
        now: Duration,
    ) -> Vec<(String, String)> {
        let mut lost = Vec::new();
        for member in self.members.iter_mut().filter(|member| member.lost.is_none()) {
            if let Some(cause) = member.giving_up(most_paused, now) {
                lost.push(member.lose(&cause, now));
                continue;
            }
            let Some(trouble) = member.trouble(epoch, now) else {
                member.troubled_since = None;
                continue;
            };
            let since = *member.troubled_since.get_or_insert(now);
            let timeout = match member.recent(now) {
                Some(status) if status.state == RobotState::Fault => Duration::ZERO,
                Some(status) if may_heal(status, epoch) => timeouts.paused,
                Some(_) => timeouts.standing,
                None => timeouts.silent,
            };
            if now.saturating_sub(since) >= timeout {
                lost.push(member.lose(&trouble, now));
            }
        }
        lost
    }

    /// Notes on lost robots: that one stands, once it reports so, or that it does not.
    pub(super) fn news_of_lost(&mut self, epoch: u64, now: Duration) -> Vec<String> {
        self.members.iter_mut().filter_map(|member| member.news_of_lost(epoch, now)).collect()
    }

    pub(super) fn holds_e_stop(&self) -> bool {
        let robots = self.members.iter().filter_map(|member| member.robot.as_ref());
        robots.into_iter().any(|received| received.status.holds_e_stop())
    }

    pub(super) fn all_lost(&self) -> bool {
        self.members.iter().all(|member| member.lost.is_some())
    }

    /// Robots that have not reported since then that they stand, for good: one that is armed may
    /// have the start still to come.
    pub(super) fn not_standing(&self, epoch: u64, since: Duration) -> Vec<String> {
        self.members
            .iter()
            .filter(|member| {
                !member.robot.as_ref().is_some_and(|received| {
                    let obeys = received.status.epoch == epoch;
                    received.at > since && !(obeys && received.status.may_yet_move())
                })
            })
            .map(|member| member.name.clone())
            .collect()
    }
}

/// A robot, or a controller, that has not confirmed that it is armed for a run.
#[derive(Clone, Debug)]
pub(super) struct Unarmed {
    /// Which, and what it reports instead.
    pub failure: Failure,
    /// Whether it is armed again by itself when it receives leases, and is received.
    pub may_heal: bool,
}

/// What is reported instead of being armed, and whether that may heal.
fn unlike_armed(
    received: Option<&LastStatus>,
    binding: RunBinding<'_>,
    now: Duration,
) -> Option<(String, bool)> {
    let Some(received) = received.filter(|received| received.is_recent(now)) else {
        return Some(("silent".to_owned(), true));
    };
    let status = &received.status;
    let is_of_run = status.epoch == binding.epoch;
    // A robot whose lease ran out, or a controller that has received none for a while.
    let has_lapsed = status.state == RobotState::Stopped
        && matches!(status.stop_cause, StopCause::Lease | StopCause::None);
    if status.parameter_digest != binding.parameter_digest {
        // A robot waits for the word of its controller.
        let is_unknown = status.parameter_digest == 0;
        return Some((
            format!(
                "parameter digest {:016x}, expected {:016x}",
                status.parameter_digest, binding.parameter_digest
            ),
            is_unknown,
        ));
    }
    let armed = is_of_run && status.state == RobotState::Armed;
    (!armed).then(|| {
        let reason = match status.stop_reason.as_str() {
            "" => String::new(),
            reason => format!(" ({reason})"),
        };
        let found = format!(
            "{} in epoch {}{reason}, expected armed in epoch {}",
            status.state, status.epoch, binding.epoch
        );
        (found, is_of_run && has_lapsed)
    })
}

impl Member {
    fn echo(&self) -> Echo {
        let counter = self.robot.as_ref().map_or(0, |received| received.status.counter);
        Echo { robot: self.name.clone(), counter }
    }

    /// It was lost: its name, and why.
    fn lose(&mut self, cause: &LossCause, now: Duration) -> (String, String) {
        self.lost = Some(now);
        self.pauses.give_up();
        // What is reported of it as its loss needs no second note.
        let stands = self.recent(now).is_some_and(|status| status.state != RobotState::Moving);
        self.noted = stands.then_some(Standing::Stands);
        (self.name.clone(), cause.to_string())
    }

    fn recent(&self, now: Duration) -> Option<&Status> {
        self.robot.as_ref().filter(|robot| robot.is_recent(now)).map(|robot| &robot.status)
    }

    fn news_of_lost(&mut self, epoch: u64, now: Duration) -> Option<String> {
        let lost = self.lost?;
        let Some(status) = self.recent(now) else {
            (self.is_silent, self.noted) = (true, None);
            return None;
        };
        let name = &self.name;
        if status.state != RobotState::Moving || status.epoch != epoch {
            if self.noted.replace(Standing::Stands) == Some(Standing::Stands) {
                return None;
            }
            let again = if self.is_silent { "is received again, and " } else { "" };
            self.is_silent = false;
            return Some(format!("{name} {again}stands until the next run"));
        }
        let is_late = now.saturating_sub(lost) >= STAND_TIMEOUT;
        if !is_late || self.noted.replace(Standing::Moves) == Some(Standing::Moves) {
            return None;
        }
        Some(format!("{name} was given up and reports that it still moves: stop it by hand"))
    }

    /// Why it is given up, whatever it does now.
    fn giving_up(&self, most_paused: Duration, now: Duration) -> Option<LossCause> {
        if let Some((kind, silence)) = self.sample_missing(now) {
            return Some(LossCause::NoSample { kind, silence_s: silence.as_secs() });
        }
        if let Some(Outside { last, .. }) = self.outside.filter(|it| it.is_certain(now)) {
            return Some(LossCause::LeftGeofence { x_m: last.x_m, y_m: last.y_m });
        }
        let stood = self.pauses.total(now);
        (stood > most_paused).then_some(LossCause::StoodTooLong { stood_s: stood.as_secs_f64() })
    }

    /// What came, and comes no more.
    fn sample_missing(&self, now: Duration) -> Option<(SampleKind, Duration)> {
        self.samples.iter().find_map(|(kind, at)| {
            let silence = match kind {
                SampleKind::Detection | SampleKind::FurtherDetection(_) => DETECTION_TIMEOUT,
                SampleKind::Pose => POSE_TIMEOUT,
            };
            (now.saturating_sub(*at) > silence).then_some((kind.clone(), silence))
        })
    }

    fn trouble(&self, epoch: u64, now: Duration) -> Option<LossCause> {
        let Some(status) = self.recent(now) else { return Some(LossCause::Silent) };
        if status.state == RobotState::Moving && status.epoch == epoch {
            return None;
        }
        let reason =
            if status.stop_reason.is_empty() { "no reason given" } else { &status.stop_reason };
        let (state, epoch, reason) = (status.state, status.epoch, reason.to_owned());
        Some(LossCause::NotMoving { state, epoch, reason })
    }
}
