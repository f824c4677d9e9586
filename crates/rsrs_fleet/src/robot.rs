//! The final gate in front of a robot's wheels, real or virtual.
//!
//! Invariants, held by the fake network: no robot moves without a fresh lease of one epoch and a
//! confirmed parameter digest; no robot obeys two epochs; a stop latches until a newer epoch arms.
//!
//! On a real robot, what the gate lets through goes to the wheels by way of [`limits`], and
//! [`detector`] makes detections of what its sensor measures.

pub mod detector;
pub mod limits;
mod stand_reason;

use std::collections::VecDeque;
use std::time::Duration;

use rsrs_core::robot::controller::Command;

use crate::e_stop::{EStop, Locks, Message};
use crate::epoch::{self, ImplausibleEpoch};
use crate::heartbeat::Heartbeat;
use crate::message::{
    E_STOP_REASON, Lease, LeaseState, RobotState, Status, StopCause, armed_reason,
};
use crate::timing::{
    CONTROLLER_TIMEOUT, LEASE_DURATION, LOCK_QUERY_DURATION, LOCKSTEP_GRACE, RESUME_TIMEOUT,
    RUNNER_GONE_TIMEOUT,
};

pub use stand_reason::StandReason;
pub(crate) use stand_reason::WORLD_REPLACED;

/// What happens to a robot.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A lease arrived.
    Lease(Lease),
    /// Its controller reported with which parameters it drives.
    Controller(Status),
    /// A velocity command arrived.
    Command(Command),
    /// A velocity command arrived that the robot cannot follow; its sender is not to be obeyed
    /// with an older one either.
    CommandRefused,
    /// A message on one of the e-stop's topics; locks are those of other robots.
    EStop(Message),
    /// The simulator that this robot is in has placed no world with it, or has placed one: the run that it
    /// belonged to ended with the world before, although its lease may come again.
    WithoutWorld(bool),
    /// The driver of its wheels or sensor failed.
    Fault(String),
    /// The driver works again. A robot whose driver failed in a running run stays out of it.
    Repaired,
    /// The battery was measured, in volts.
    Battery(f32),
    /// Time passed.
    Tick,
}

/// How a robot's gate is set up.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotOptions {
    /// Name of the robot, as leases name it.
    pub name: String,
    /// Age at which a velocity command is stale.
    pub command_timeout: Duration,
    /// What a lapse of its permission does.
    pub lapse: Lapse,
}

/// What it does when the permission to move lapses: the lease runs out, or the controller is silent
/// or has other parameters than the confirmed ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lapse {
    /// It stops a robot on a floor. One whose lease ran out may be let go on for a moment
    /// ([`RESUME_TIMEOUT`]) by a lease that echoes a status from after that, which said that it stood:
    /// so its runner knows. Any other lapse is final.
    Stops,
    /// It freezes the world of a robot in lockstep, in which nothing moves meanwhile, and heals by
    /// itself for a while ([`LOCKSTEP_GRACE`]).
    Freezes,
}

/// The gate of one robot.
#[derive(Clone, Debug)]
pub struct Robot {
    options: RobotOptions,
    bound: Option<Binding>,
    latched: Option<String>,
    fault: Option<String>,
    e_stop: EStop,
    asking: Asking,
    is_without_world: bool,
    /// An epoch that no runner made, and that was refused last.
    refused_epoch: Option<ImplausibleEpoch>,
    /// The newest word of its controller, and when it came.
    controller: Option<(Status, Duration)>,
    /// The newest epoch that its controller has reported, and the highest counter in it.
    reported: (u64, u64),
    command: Option<(Command, Duration)>,
    lapsed: Option<Lapsed>,
    battery_v: f32,
    beat: Heartbeat<(RobotState, StopCause)>,
    sent: VecDeque<(u64, Duration)>,
}

#[derive(Clone, Debug)]
struct Binding {
    run_id: String,
    epoch: u64,
    parameter_digest: u64,
    running: bool,
    /// When a lease of it was received last.
    received: Duration,
    fresh_until: Duration,
}

impl Binding {
    /// Whether the runner has been silent for longer than a lease lasts.
    fn is_alone(&self, now: Duration) -> bool {
        now.saturating_sub(self.received) > LEASE_DURATION
    }
}

/// A lapse that may heal.
#[derive(Clone, Copy, Debug)]
struct Lapsed {
    since: Duration,
    /// Whether its runner knows of it and lets the robot go on.
    is_excused: bool,
}

/// So long a robot whose process has just started belongs to no run.
#[derive(Clone, Copy, Debug, Default)]
struct Asking {
    length: Duration,
    began: Option<Duration>,
}

impl Asking {
    fn is_over(self, now: Duration) -> bool {
        self.began.map_or(self.length.is_zero(), |began| now.saturating_sub(began) >= self.length)
    }
}

impl Lapse {
    /// How long it may last before it is final.
    const fn grace(self) -> Duration {
        match self {
            Self::Stops => RESUME_TIMEOUT,
            Self::Freezes => LOCKSTEP_GRACE,
        }
    }
}

/// Statuses whose sending time is remembered: well over what a fresh lease can echo.
const REMEMBERED: usize = 64;

impl Robot {
    /// A robot that belongs to no run.
    pub fn new(options: RobotOptions) -> Self {
        Self {
            options,
            bound: None,
            latched: None,
            fault: None,
            e_stop: EStop::default(),
            asking: Asking::default(),
            is_without_world: false,
            refused_epoch: None,
            controller: None,
            reported: (0, 0),
            command: None,
            lapsed: None,
            battery_v: f32::NAN,
            beat: Heartbeat::default(),
            sent: VecDeque::new(),
        }
    }

    /// The same robot, that counts its statuses up from a number above all that it ever counted
    /// before it was started again, as the wall clock's milliseconds are.
    #[must_use]
    pub fn counting_from(mut self, counter: u64) -> Self {
        self.beat = Heartbeat::from(counter);
        self
    }

    /// The same robot, in a process that has just started: it asks the others what the e-stop has
    /// locked before it belongs to a run.
    #[must_use]
    pub fn of_a_new_process(self) -> Self {
        Self { asking: Asking { length: LOCK_QUERY_DURATION, began: None }, ..self }
    }

    /// A robot with other options that has forgotten its runs, and neither the e-stop nor what would be an old word
    /// of its controller.
    #[must_use]
    pub fn anew(&self, options: RobotOptions) -> Self {
        Self {
            e_stop: self.e_stop.clone(),
            asking: self.asking,
            is_without_world: self.is_without_world,
            reported: self.reported,
            ..Self::new(options)
        }
    }

    /// Who has locked it by the e-stop, as it answers others who ask.
    pub fn locks(&self) -> Locks {
        self.e_stop.locks()
    }

    /// The epoch that it refused last because no runner made it.
    pub fn refused_epoch(&self) -> Option<ImplausibleEpoch> {
        self.refused_epoch
    }

    /// Takes an event, and returns a status to publish, if it is time for one or the robot's state
    /// changed.
    pub fn on_event(&mut self, event: Event, now: Duration) -> Option<Status> {
        // What has run out by now has run out, whatever comes now.
        self.asking.began.get_or_insert(now);
        self.latch(now);
        match event {
            Event::Lease(lease) => self.on_lease(&lease, now),
            Event::Controller(status) => self.receive_controller(status, now),
            Event::Command(command) => self.command = Some((command, now)),
            Event::EStop(Message::State { source, engaged }) => {
                self.e_stop.receive((source, engaged), now);
            }
            Event::EStop(Message::Release(sources)) => self.e_stop.release(&sources),
            // Who has been there all the time has the newest locks.
            Event::EStop(Message::Locks { locks, .. }) if !self.asking.is_over(now) => {
                self.e_stop.adopt(&locks, now);
            }
            Event::WithoutWorld(is_without) => {
                self.is_without_world = is_without;
                if self.bound.is_some() {
                    self.latched.get_or_insert_with(|| WORLD_REPLACED.to_owned());
                }
            }
            Event::CommandRefused => self.command = None,
            Event::Fault(reason) => self.fault = Some(reason),
            Event::Repaired => self.fault = None,
            Event::Battery(battery_v) => self.battery_v = battery_v,
            Event::EStop(Message::Locks { .. }) | Event::Tick => {}
        }
        self.latch(now);
        self.status_due(now)
    }

    fn receive_controller(&mut self, status: Status, now: Duration) {
        // In the newest epoch that it has reported, a word that is not above all others may be of a process
        // that has died: it counts as one of no epoch, which confirms nothing.
        let (epoch, counter) = self.reported;
        let is_old = status.epoch == epoch && status.counter <= counter;
        if epoch::check(status.epoch, self.epoch()).is_ok() {
            self.reported = self.reported.max((status.epoch, status.counter));
        }
        let status = if is_old { Status { epoch: 0, ..status } } else { status };
        let last = self.controller.as_ref().map(|(status, at)| (status.counter, *at));
        let rises = last.is_none_or(|(counter, _)| status.counter > counter);
        // While a run may still move the robot, silence makes no old word true.
        if rises || (self.is_free(now) && status.is_news(last, now)) {
            self.controller = Some((status, now));
        }
    }

    fn on_lease(&mut self, lease: &Lease, now: Duration) {
        let Some(echo) = lease.echo(&self.options.name) else { return };
        let sent_at = self.sent.iter().find(|(counter, _)| *counter == echo).map(|(_, at)| *at);
        let highest = self.bound.as_ref().map_or(0, |bound| bound.epoch);
        // A lease that comes late, as from before this robot was started again, does not arm.
        let is_prompt = sent_at.is_some_and(|at| now.saturating_sub(at) <= LEASE_DURATION);
        let is_new = lease.epoch > highest && lease.state == LeaseState::Armed && is_prompt;
        if is_new && self.asking.is_over(now) {
            match epoch::check(lease.epoch, highest) {
                Ok(_) => self.bind(lease, now),
                Err(refused) => self.refused_epoch = Some(refused),
            }
        }
        let Some(bound) = &mut self.bound else { return };
        if lease.epoch != bound.epoch || lease.run_id != bound.run_id {
            return;
        }
        bound.received = now;
        if let (Some(sent_at), Some(lapsed)) = (sent_at, &mut self.lapsed) {
            lapsed.is_excused |= lease.state == LeaseState::Running && sent_at > lapsed.since;
        }
        match lease.state {
            LeaseState::Running => bound.running = true,
            LeaseState::Stopped => {
                self.latched.get_or_insert_with(|| "stopped by the runner".to_owned());
            }
            LeaseState::Idle | LeaseState::Armed => {}
        }
        if let Some(sent_at) = sent_at {
            bound.fresh_until = bound.fresh_until.max(sent_at + LEASE_DURATION);
        }
    }

    fn bind(&mut self, lease: &Lease, now: Duration) {
        self.bound = Some(Binding {
            run_id: lease.run_id.clone(),
            epoch: lease.epoch,
            parameter_digest: lease.parameter_digest,
            running: false,
            received: now,
            fresh_until: now,
        });
        self.latched = None;
        self.lapsed = None;
        self.command = None;
        self.e_stop.forget_silent(now);
    }

    /// Latches what must not heal by itself.
    fn latch(&mut self, now: Duration) {
        if self.is_held(now) {
            self.e_stop.lapse(now);
        }
        if self.e_stop.is_engaged() && self.bound.is_some() {
            self.latched.get_or_insert_with(|| "stopped by the e-stop".to_owned());
        }
        let running = self.bound.as_ref().is_some_and(|bound| bound.running);
        if !running || self.latched.is_some() {
            return;
        }
        if let Some(reason) = &self.fault {
            self.latched = Some(StandReason::Fault(reason.clone()).to_string());
            return;
        }
        self.follow_lapse(now);
    }

    /// Looks whether the permission to move has lapsed, and whether that has healed or is final.
    fn follow_lapse(&mut self, now: Duration) {
        let reason = self.bound.as_ref().and_then(|bound| self.lapse_of(bound, now));
        let lapsed = match (&reason, self.lapsed) {
            (None, None) => return,
            (None, Some(lapsed)) if lapsed.is_excused => {
                self.lapsed = None;
                return;
            }
            (_, Some(lapsed)) => lapsed,
            (Some(reason), None) => match (self.options.lapse, reason, &self.bound) {
                (Lapse::Freezes, ..) => Lapsed { since: now, is_excused: true },
                (Lapse::Stops, StandReason::LeaseLapsed, Some(bound)) => {
                    Lapsed { since: bound.fresh_until, is_excused: false }
                }
                (Lapse::Stops, ..) => {
                    self.latched = Some(reason.to_string());
                    return;
                }
            },
        };
        self.lapsed = Some(lapsed);
        if now.saturating_sub(lapsed.since) >= self.options.lapse.grace() {
            self.latched = Some(reason.unwrap_or(StandReason::LeaseLapsed).to_string());
        }
    }

    /// Why the permission to move has lapsed; `None` if it has not.
    fn lapse_of(&self, bound: &Binding, now: Duration) -> Option<StandReason> {
        if now > bound.fresh_until {
            return Some(StandReason::LeaseLapsed);
        }
        let is_confirmed = self.controller.as_ref().is_some_and(|(status, received)| {
            // One that was started again in the middle obeys no epoch, of whichever runner.
            status.epoch == bound.epoch
                && status.parameter_digest == bound.parameter_digest
                && now.saturating_sub(*received) <= CONTROLLER_TIMEOUT
        });
        (!is_confirmed).then_some(StandReason::ControllerUnconfirmed)
    }

    /// Silence counts while the robot could move.
    fn e_stop_holds(&self, now: Duration) -> bool {
        self.e_stop.is_engaged() || (self.is_held(now) && self.e_stop.would_lapse(now))
    }

    /// Whether a run could move it: one that stands for good, or whose runner is gone, is not held.
    fn is_held(&self, now: Duration) -> bool {
        self.bound.as_ref().is_some_and(|bound| !bound.is_alone(now)) && self.latched.is_none()
    }

    /// Whether no run will move it, as far as can be observed: a runner may come back after a
    /// while.
    fn is_free(&self, now: Duration) -> bool {
        let is_left = |bound: &Binding| now.saturating_sub(bound.received) > RUNNER_GONE_TIMEOUT;
        self.latched.is_some() || self.bound.as_ref().is_none_or(is_left)
    }

    /// Why the robot must stand now; `None` if it may move.
    pub fn standing(&self, now: Duration) -> Option<StandReason> {
        if let Some(reason) = &self.fault {
            return Some(StandReason::Fault(reason.clone()));
        }
        if self.e_stop_holds(now) {
            return Some(StandReason::EStop);
        }
        if let Some(reason) = &self.latched {
            return Some(StandReason::Latched(reason.clone()));
        }
        let Some(bound) = &self.bound else {
            return Some(match (self.asking.is_over(now), self.is_without_world) {
                (_, true) => StandReason::WithoutWorld,
                (false, false) => StandReason::Asking,
                (true, false) => StandReason::Idle,
            });
        };
        if !bound.running {
            // A runner that died before the start holds no robot and no parameters.
            let is_alone = bound.is_alone(now);
            return Some(if is_alone { StandReason::LeaseLapsed } else { StandReason::Armed });
        }
        let is_paused = self.lapsed.is_some_and(|lapsed| !lapsed.is_excused);
        self.lapse_of(bound, now).or_else(|| is_paused.then_some(StandReason::LeaseLapsed))
    }

    /// Whether a run holds it on the floor: it may move, now or in a moment.
    pub fn is_in_run(&self, now: Duration) -> bool {
        match self.state(now) {
            RobotState::Armed | RobotState::Moving => true,
            RobotState::Stopped => {
                let lapses = self.lapsed.is_some() && self.options.lapse == Lapse::Stops;
                lapses && self.latched.is_none() && !self.e_stop_holds(now)
            }
            RobotState::Idle | RobotState::Fault => false,
        }
    }

    /// What the wheels do now: the last command while it is fresh and the robot may move.
    pub fn drive(&self, now: Duration) -> Command {
        match self.command {
            Some((command, received))
                if self.standing(now).is_none()
                    && now.saturating_sub(received) <= self.options.command_timeout =>
            {
                command
            }
            _ => Command::STOP,
        }
    }

    /// The robot's state, as statuses report it.
    pub fn state(&self, now: Duration) -> RobotState {
        match self.standing(now) {
            None => RobotState::Moving,
            Some(StandReason::Idle | StandReason::Asking | StandReason::WithoutWorld) => {
                RobotState::Idle
            }
            Some(StandReason::Armed) => RobotState::Armed,
            Some(StandReason::Fault(_)) => RobotState::Fault,
            Some(_) => RobotState::Stopped,
        }
    }

    /// The epoch that the robot obeys; 0 is none.
    pub fn epoch(&self) -> u64 {
        self.bound.as_ref().map_or(0, |bound| bound.epoch)
    }

    /// The run that the robot obeys; `None` if it belongs to none.
    pub fn run_id(&self) -> Option<&str> {
        self.bound.as_ref().map(|bound| bound.run_id.as_str())
    }

    /// Whether the robot stands until a newer epoch arms it, and why.
    pub fn latched(&self) -> Option<&str> {
        self.latched.as_deref()
    }

    /// Digest of its controller's parameters, by the controller's last word; while a run holds the
    /// robot, by a word of that run.
    fn parameter_digest(&self, now: Duration) -> u64 {
        match (&self.controller, &self.bound) {
            (None, _) => 0,
            (Some((status, _)), Some(bound))
                if self.is_held(now) && status.epoch != bound.epoch =>
            {
                0
            }
            (Some((status, _)), _) => status.parameter_digest,
        }
    }

    fn status_due(&mut self, now: Duration) -> Option<Status> {
        let state = self.state(now);
        let cause = self.standing(now).map_or(StopCause::None, |reason| reason.cause());
        let counter = self.beat.due((state, cause), now)?;
        self.sent.push_back((counter, now));
        if self.sent.len() > REMEMBERED {
            self.sent.pop_front();
        }
        let (stop_cause, stop_reason) = match (self.standing(now), &self.bound) {
            (None, _) => (StopCause::None, String::new()),
            (Some(StandReason::Armed), Some(bound)) => {
                (StopCause::Waiting, armed_reason(&bound.run_id))
            }
            // The stopper must see that this one has received it, too.
            (Some(reason @ StandReason::Fault(_)), _) if self.e_stop_holds(now) => {
                (StopCause::EStop, format!("{E_STOP_REASON}; {reason}"))
            }
            (Some(reason), _) => (reason.cause(), reason.to_string()),
        };
        Some(Status {
            counter,
            epoch: self.epoch(),
            run_id: self.run_id().unwrap_or_default().to_owned(),
            parameter_digest: self.parameter_digest(now),
            state,
            stop_cause,
            stop_reason,
            battery_v: self.battery_v,
        })
    }
}

#[cfg(test)]
mod tests;
