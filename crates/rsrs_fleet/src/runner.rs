//! The conductor of one run: looks, sets, arms, runs, stops, and closes the bag whatever happens.

use std::collections::BTreeMap;
use std::time::Duration;

use rsrs_core::controller::ControllerParameters;

use crate::experiment::RobotLost;
use crate::message::{Lease, LeaseState, Status};
use crate::preflight::{self, Expected, Graph, Seen};
use crate::timing::{ARM, BEAT, CONFIGURE, DISCOVER, LOCKSTEP_GRACE, RECORDER, SILENCE, STAND};

mod outcome;
mod requests;
mod roster;

pub use outcome::{Failure, Outcome, Target};
use requests::Requests;
use roster::{Bond, Roster};

/// What a runner is to do.
#[derive(Clone, Debug, PartialEq)]
pub struct RunnerOptions {
    /// Names the run; no two runs share it.
    pub run_id: String,
    /// What must be there; its robots are the robots of the run.
    pub expected: Expected,
    /// What every controller is set to.
    pub controller: ControllerParameters,
    /// Digest of the world that the simulator must have placed
    /// ([`crate::simulator::placement_digest`]); unused without a simulator.
    pub simulator_digest: u64,
    /// When the run is complete.
    pub pace: Pace,
    /// What to do when a robot is lost.
    pub robot_lost: RobotLost,
}

/// When a run is complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// When the simulator has made these steps and the recorder has taken them all.
    Lockstep {
        /// Steps.
        steps: u64,
    },
    /// When this time has passed on the wall.
    RealTime {
        /// The time.
        duration: Duration,
    },
}

/// What happens to a runner.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The discovery database as it is now.
    Seen(Graph),
    /// A robot said what it does.
    RobotStatus {
        /// The robot.
        robot: String,
        /// Its word.
        status: Status,
    },
    /// A controller said what it does.
    ControllerStatus {
        /// Its robot.
        robot: String,
        /// Its word.
        status: Status,
    },
    /// A request to set parameters was answered.
    ParametersSet {
        /// Who answered.
        target: Target,
        /// Why not, if not.
        result: Result<(), String>,
    },
    /// A request to read parameters was answered.
    ReadBack {
        /// Who answered.
        target: Target,
        /// Digest of the parameters, or why there is none.
        result: Result<u64, String>,
    },
    /// The recorder hears every topic.
    RecorderReady,
    /// The recorder has taken every topic up to this step.
    Recorded {
        /// The step.
        step: u64,
    },
    /// The recorder cannot go on.
    RecorderFailed {
        /// Why.
        reason: String,
    },
    /// The bag is closed.
    RecorderClosed,
    /// The simulator has made all steps.
    SimulatorComplete,
    /// The simulator says that the run does not count.
    SimulatorVoid {
        /// Why.
        reason: String,
    },
    /// A lease was heard, from whomever.
    LeaseHeard(Lease),
    /// The e-stop topic said engaged or released.
    EStop(bool),
    /// Someone wants the run to end now.
    Interrupt {
        /// Why.
        reason: String,
    },
    /// Time passed.
    Tick,
}

/// What a runner does.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Publish a lease.
    PublishLease(Lease),
    /// Set all parameters of a target at once: a robot's to [`RunnerOptions::controller`].
    Configure(Target),
    /// Read the parameters of a target and digest them.
    ReadBack(Target),
    /// Open the bag and subscribe to every topic.
    OpenRecorder,
    /// Drain and close the bag.
    CloseRecorder,
    /// Tell the operator.
    Say(String),
    /// The run is over; nothing more comes.
    Finish {
        /// How it ended.
        outcome: Outcome,
        /// Robots that did not say that they stand; someone should go and look.
        not_standing: Vec<String>,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Discover,
    Configure,
    ReadBack,
    Record,
    Arm,
    Run,
    Stop,
    Close,
    Done,
}

/// The conductor of one run.
#[derive(Clone, Debug)]
pub struct Runner {
    options: RunnerOptions,
    phase: Phase,
    /// Since when it is in its phase; `None` before the first event.
    since: Option<Duration>,
    graph: Graph,
    roster: Roster,
    requests: Requests,
    /// Other runs by id: their epoch, and when they were heard last.
    others: BTreeMap<String, (u64, Duration)>,
    highest_epoch: u64,
    /// The epoch of this run; 0 before it arms.
    epoch: u64,
    e_stop: bool,
    recorder_opened: bool,
    recorder_closed: bool,
    recorded: u64,
    simulated_at: Option<Duration>,
    last_lease: Option<(LeaseState, Duration)>,
    outcome: Option<Outcome>,
    not_standing: Vec<String>,
}

impl Runner {
    /// A runner that has not looked yet.
    pub fn new(options: RunnerOptions) -> Self {
        Self {
            phase: Phase::Discover,
            since: None,
            graph: Graph::default(),
            roster: Roster::new(&options.expected.robots),
            requests: Requests::default(),
            others: BTreeMap::new(),
            highest_epoch: 0,
            epoch: 0,
            e_stop: false,
            recorder_opened: false,
            recorder_closed: false,
            recorded: 0,
            simulated_at: None,
            last_lease: None,
            outcome: None,
            not_standing: Vec::new(),
            options,
        }
    }

    /// The epoch of this run; 0 before it arms.
    pub fn epoch(&self) -> u64 {
        self.epoch
    }

    /// How the run ended; `None` while it goes on. It is known before the bag is closed.
    pub fn outcome(&self) -> Option<&Outcome> {
        self.outcome.as_ref()
    }

    /// Takes an event.
    ///
    /// # Returns
    ///
    /// What to do, in order. Answers to [`Action::Configure`] and [`Action::ReadBack`] come back as
    /// events; those that never come are asked for again.
    pub fn on_event(&mut self, event: Event, now: Duration) -> Vec<Action> {
        let mut actions = Vec::new();
        if self.phase == Phase::Done {
            return actions;
        }
        self.since.get_or_insert(now);
        self.take(event, now, &mut actions);
        self.go_on(now, &mut actions);
        if self.phase != Phase::Done {
            actions.extend(self.lease_due(now).map(Action::PublishLease));
        }
        actions
    }

    fn take(&mut self, event: Event, now: Duration, actions: &mut Vec<Action>) {
        match event {
            Event::Seen(graph) => self.graph = graph,
            Event::RobotStatus { robot, status } => {
                self.highest_epoch = self.highest_epoch.max(status.epoch);
                self.roster.hear_robot(&robot, status, now);
            }
            Event::ControllerStatus { robot, status } => {
                self.highest_epoch = self.highest_epoch.max(status.epoch);
                self.roster.hear_controller(&robot, status, now);
            }
            Event::ParametersSet { target, result } if self.phase == Phase::Configure => {
                self.requests.answer(&target, result);
            }
            Event::ReadBack { target, result } if self.phase == Phase::ReadBack => {
                let confirmed = result.and_then(|found| self.confirm(&target, found));
                self.requests.answer(&target, confirmed);
            }
            Event::RecorderReady if self.phase == Phase::Record => self.arm(now, actions),
            // Answers that come after their phase is over: to repeated requests, or too late.
            Event::ParametersSet { .. }
            | Event::ReadBack { .. }
            | Event::RecorderReady
            | Event::Tick => {}
            Event::Recorded { step } => self.recorded = self.recorded.max(step),
            Event::RecorderFailed { reason } => self.fail_recorder(reason, now, actions),
            Event::RecorderClosed => self.recorder_closed = true,
            Event::SimulatorComplete => {
                self.simulated_at.get_or_insert(now);
            }
            Event::SimulatorVoid { reason } => self.end(Outcome::Void { reason }, now, actions),
            Event::LeaseHeard(lease) => self.hear_lease(lease, now, actions),
            Event::EStop(engaged) => {
                self.e_stop = engaged;
                if engaged && self.phase != Phase::Discover {
                    self.abort("e-stop".to_owned(), now, actions);
                }
            }
            Event::Interrupt { reason } => self.abort(reason, now, actions),
        }
    }

    fn confirm(&self, target: &Target, found: u64) -> Result<(), String> {
        let expected = match target {
            Target::Robot(_) => self.options.controller.digest(),
            Target::Simulator => self.options.simulator_digest,
        };
        if found == expected {
            return Ok(());
        }
        Err(format!("digest {found:016x}, expected {expected:016x}"))
    }

    /// A runner that hears another with a right to the same robots stops.
    fn hear_lease(&mut self, lease: Lease, now: Duration, actions: &mut Vec<Action>) {
        if lease.run_id == self.options.run_id {
            return;
        }
        self.highest_epoch = self.highest_epoch.max(lease.epoch);
        if self.phase != Phase::Discover && lease.epoch >= self.epoch {
            self.abort(format!("another runner is active, run {}", lease.run_id), now, actions);
        }
        self.others.insert(lease.run_id, (lease.epoch, now));
    }

    fn abort(&mut self, reason: String, now: Duration, actions: &mut Vec<Action>) {
        self.end(Outcome::Aborted { reason }, now, actions);
    }

    fn fail(&mut self, problems: Vec<Failure>, now: Duration, actions: &mut Vec<Action>) {
        self.end(Outcome::Failed { problems }, now, actions);
    }

    /// Data that is lost outweighs a run that went well until then.
    fn fail_recorder(&mut self, reason: String, now: Duration, actions: &mut Vec<Action>) {
        actions.push(Action::Say(format!("recorder: {reason}")));
        let problems = vec![Failure::Recorder { reason }];
        if self.outcome == Some(Outcome::Completed) {
            self.outcome = Some(Outcome::Failed { problems });
        } else {
            self.fail(problems, now, actions);
        }
    }

    /// Ends the run; the first reason to do so is the one that counts.
    fn end(&mut self, outcome: Outcome, now: Duration, actions: &mut Vec<Action>) {
        if self.outcome.is_some() {
            return;
        }
        self.outcome = Some(outcome);
        if self.epoch == 0 {
            self.close(now, actions);
        } else {
            actions.push(Action::Say("stopping every robot".to_owned()));
            self.enter(Phase::Stop, now);
        }
    }

    fn enter(&mut self, phase: Phase, now: Duration) {
        self.phase = phase;
        self.since = Some(now);
    }

    /// How long the runner is in its phase.
    fn elapsed(&self, now: Duration) -> Duration {
        now.saturating_sub(self.since.unwrap_or(now))
    }

    fn lease_state(&self) -> LeaseState {
        match self.phase {
            Phase::Arm => LeaseState::Armed,
            Phase::Run => LeaseState::Running,
            Phase::Stop | Phase::Close if self.epoch > 0 => LeaseState::Stopped,
            _ => LeaseState::Idle,
        }
    }

    /// Ten leases a second, and one at once when the permission changes.
    fn lease_due(&mut self, now: Duration) -> Option<Lease> {
        let state = self.lease_state();
        let due = self
            .last_lease
            .is_none_or(|(last, at)| last != state || now.saturating_sub(at) >= BEAT);
        if !due {
            return None;
        }
        self.last_lease = Some((state, now));
        Some(Lease {
            run_id: self.options.run_id.clone(),
            epoch: self.epoch,
            state,
            parameter_digest: self.options.controller.digest(),
            robots: self.roster.echoes(),
        })
    }
}

mod phases;

#[cfg(test)]
mod tests;
