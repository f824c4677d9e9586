//! What the runner last received from each robot and its controller.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use super::SampleKind;
use crate::message::{Echo, RobotState, Status};
use crate::timing::{DETECTION_TIMEOUT, NODE_TIMEOUT, POSE_TIMEOUT};

/// The robots of a run, in its order.
#[derive(Clone, Debug)]
pub(super) struct Roster {
    members: Vec<Member>,
}

#[derive(Clone, Debug)]
struct Member {
    name: String,
    robot: Option<LastStatus>,
    controller: Option<LastStatus>,
    /// When the last sample of each kind came, since the start of the movement.
    samples: BTreeMap<SampleKind, Duration>,
    /// Since when it is not as it should be during the run.
    troubled_since: Option<Duration>,
    lost: bool,
    /// It was lost, and has not been received since.
    is_silent: bool,
}

#[derive(Clone, Debug)]
struct LastStatus {
    status: Status,
    at: Duration,
}

impl LastStatus {
    /// Keeps the newer of two statuses.
    fn receive(slot: &mut Option<Self>, status: Status, at: Duration) {
        let last = slot.as_ref().map(|last| (last.status.counter, last.at));
        if status.is_news(last, at) {
            *slot = Some(Self { status, at });
        }
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
    /// It has not been received for as long as robots may be silent.
    pub silent: Duration,
}

impl Roster {
    pub(super) fn new(robots: &[String]) -> Self {
        let members = robots
            .iter()
            .map(|name| Member {
                name: name.clone(),
                robot: None,
                controller: None,
                samples: BTreeMap::new(),
                troubled_since: None,
                lost: false,
                is_silent: false,
            })
            .collect();
        Self { members }
    }

    fn member(&mut self, name: &str) -> Option<&mut Member> {
        self.members.iter_mut().find(|member| member.name == name)
    }

    pub(super) fn receive_robot(&mut self, name: &str, status: Status, now: Duration) {
        if let Some(member) = self.member(name) {
            LastStatus::receive(&mut member.robot, status, now);
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

    /// The robots are about to move: samples count from now on.
    pub(super) fn forget_samples(&mut self) {
        for member in &mut self.members {
            member.samples.clear();
        }
    }

    /// Robots of which no sample of some kind has come since the start.
    pub(super) fn without_samples(
        &self,
        kinds: &BTreeSet<SampleKind>,
    ) -> Vec<(String, SampleKind)> {
        let present = self.members.iter().filter(|member| !member.lost);
        let missing = present.flat_map(|member| {
            let missing = kinds.iter().filter(|kind| !member.samples.contains_key(*kind));
            missing.map(|kind| (member.name.clone(), *kind))
        });
        missing.collect()
    }

    /// How long no pose has come of each robot that is not lost, and of which one has come since the
    /// start.
    pub(super) fn pose_silences(&self, now: Duration) -> impl Iterator<Item = (&str, Duration)> {
        self.members.iter().filter(|member| !member.lost).filter_map(move |member| {
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

    /// Counters of the last statuses, for the lease.
    pub(super) fn echoes(&self) -> Vec<Echo> {
        self.members
            .iter()
            .map(|member| Echo {
                robot: member.name.clone(),
                counter: member.robot.as_ref().map_or(0, |received| received.status.counter),
            })
            .collect()
    }

    /// The last status of every robot that is received now.
    pub(super) fn recent_robots(&self, now: Duration) -> BTreeMap<String, Status> {
        self.members
            .iter()
            .filter_map(|member| {
                let received = member.robot.as_ref().filter(|received| received.is_recent(now))?;
                Some((member.name.clone(), received.status.clone()))
            })
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
    pub(super) fn not_armed(
        &self,
        binding: RunBinding<'_>,
        now: Duration,
    ) -> Vec<(String, String)> {
        let mut waiting = Vec::new();
        for member in &self.members {
            let sides = [("", &member.robot), (" (controller)", &member.controller)];
            for (side, received) in sides {
                if let Some(found) = unlike_armed(received.as_ref(), binding, now) {
                    waiting.push((format!("{}{side}", member.name), found));
                }
            }
        }
        waiting
    }

    /// Robots that were lost just now: not as they should be for longer than the timeouts.
    ///
    /// # Arguments
    ///
    /// * `timeouts` — how long trouble may last, but for a hardware fault, which is final.
    pub(super) fn newly_lost(
        &mut self,
        epoch: u64,
        timeouts: LossTimeouts,
        now: Duration,
    ) -> Vec<(String, String)> {
        let mut lost = Vec::new();
        for member in self.members.iter_mut().filter(|member| !member.lost) {
            if let Some((kind, silence)) = member.sample_missing(now) {
                member.lost = true;
                let reason = format!("no {kind} received for more than {} s", silence.as_secs());
                lost.push((member.name.clone(), reason));
                continue;
            }
            let Some(trouble) = member.trouble(epoch, now) else {
                member.troubled_since = None;
                continue;
            };
            let since = *member.troubled_since.get_or_insert(now);
            let received = member.robot.as_ref().filter(|received| received.is_recent(now));
            let timeout = match received {
                Some(received) if received.status.state == RobotState::Fault => Duration::ZERO,
                Some(_) => timeouts.standing,
                None => timeouts.silent,
            };
            if now.saturating_sub(since) >= timeout {
                member.lost = true;
                lost.push((member.name.clone(), trouble));
            }
        }
        lost
    }

    /// Lost robots that are received again, each time they are.
    pub(super) fn newly_back(&mut self, now: Duration) -> Vec<String> {
        let mut back = Vec::new();
        for member in self.members.iter_mut().filter(|member| member.lost) {
            let is_received = member.robot.as_ref().is_some_and(|robot| robot.is_recent(now));
            if is_received && member.is_silent {
                back.push(member.name.clone());
            }
            member.is_silent = !is_received;
        }
        back
    }

    /// Whether the e-stop holds a robot.
    pub(super) fn holds_e_stop(&self) -> bool {
        let robots = self.members.iter().filter_map(|member| member.robot.as_ref());
        robots.into_iter().any(|received| received.status.holds_e_stop())
    }

    pub(super) fn all_lost(&self) -> bool {
        self.members.iter().all(|member| member.lost)
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

fn unlike_armed(
    received: Option<&LastStatus>,
    binding: RunBinding<'_>,
    now: Duration,
) -> Option<String> {
    let Some(received) = received.filter(|received| received.is_recent(now)) else {
        return Some("silent".to_owned());
    };
    let status = &received.status;
    if status.parameter_digest != binding.parameter_digest {
        return Some(format!(
            "parameter digest {:016x}, expected {:016x}",
            status.parameter_digest, binding.parameter_digest
        ));
    }
    let armed = status.epoch == binding.epoch && status.state == RobotState::Armed;
    (!armed).then(|| {
        format!(
            "{} in epoch {}, expected armed in epoch {}",
            status.state, status.epoch, binding.epoch
        )
    })
}

impl Member {
    /// What came, and comes no more.
    fn sample_missing(&self, now: Duration) -> Option<(SampleKind, Duration)> {
        self.samples.iter().find_map(|(kind, at)| {
            let silence = match kind {
                SampleKind::Detection => DETECTION_TIMEOUT,
                SampleKind::Pose => POSE_TIMEOUT,
            };
            (now.saturating_sub(*at) > silence).then_some((*kind, silence))
        })
    }

    fn trouble(&self, epoch: u64, now: Duration) -> Option<String> {
        let Some(received) = self.robot.as_ref().filter(|received| received.is_recent(now)) else {
            return Some(format!("silent for more than {} s", NODE_TIMEOUT.as_secs()));
        };
        let status = &received.status;
        if status.state == RobotState::Moving && status.epoch == epoch {
            return None;
        }
        let reason =
            if status.stop_reason.is_empty() { "no reason given" } else { &status.stop_reason };
        Some(format!("{} in epoch {}: {reason}", status.state, status.epoch))
    }
}
