//! The pace of a simulated fleet: when its world senses, when it moves, and what it reports.
//!
//! In lockstep the world steps when every controller has answered and the recorder is close enough
//! behind; in real time it steps every control period, with whatever the robots' gates let through.
//! The machine owns no world. It decides when to sense and when to advance; its driver does so.

use std::borrow::Cow;
use std::time::Duration;

use rsrs_core::conditions::Conditions;
use rsrs_core::digest::Digest;
use rsrs_core::robot::controller::Command;

use crate::experiment::Time;
use crate::heartbeat::Heartbeat;
use crate::message::{RobotState, Status, StopCause};

mod lockstep;
mod manual;
mod real_time;

use lockstep::Lockstep;
pub use lockstep::VoidCause;
use manual::ManualControl;
pub use manual::{ManualCommand, ManualControlRefused, PlaybackState};
use real_time::RealTime;

/// Steps that the simulator may be ahead of the recorder.
pub const RECORDER_WINDOW: u64 = 20;

/// Greatest command that a world takes, in m/s and rad/s: what an axis of a sweep may ask for. Beyond
/// it, single precision would overflow sooner or later.
pub const MAX_COMMAND: f64 = 1e3;

/// Names the world of one replicate of these conditions that is to make so many steps: the
/// simulator reports it in its status, and the runner expects it.
pub fn placement_digest(conditions: &Conditions, seed: u64, replicate: u64, steps: u64) -> u64 {
    let mut digest = Digest::new("placement");
    for word in [conditions.digest(), seed, replicate, steps] {
        digest.word(word);
    }
    digest.value()
}

/// A world whose robots stand at their start poses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Placed {
    /// Its name, as [`placement_digest`] gives it.
    pub digest: u64,
    /// Names of the robots that the simulator moves; shape `[n_robots]`.
    pub robots: Vec<String>,
    /// Steps to make in lockstep; in real time the runner ends the run, and this is only part of
    /// the name.
    pub steps: u64,
    /// Length of one step, in nanoseconds; above 0.
    pub period_ns: u64,
    /// The pace.
    pub time: Time,
    /// Where the robots' gates are.
    pub gates: Gates,
}

/// Where the gates in front of virtual wheels are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gates {
    /// In the simulator, which therefore sees when a run is over.
    #[default]
    Here,
    /// In nodes of the robots' own; a robot that stands may move again.
    Elsewhere,
}

/// The gate of one robot now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gate {
    /// What the robot does.
    pub state: RobotState,
    /// What its wheels do: [`Command::STOP`] unless it moves.
    pub drive: Command,
    /// Whether a run holds it, so that it may move, now or in a moment
    /// ([`Robot::is_in_run`](crate::robot::Robot::is_in_run)).
    pub is_in_run: bool,
}

/// What happens to the simulator.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A world was placed; it takes the place of the one before.
    Placed(Placed),
    /// There is no world, because none was requested.
    Removed,
    /// There is no world, because the one that was asked for cannot be placed.
    NotPlaced {
        /// Why not.
        reason: String,
    },
    /// The gates of all placed robots were looked at; shape `[n_robots]`. To be sent whenever
    /// something has happened, and when [`Simulator::due`] has come.
    Gates(Vec<Gate>),
    /// A velocity command arrived.
    Command {
        /// Index of the robot.
        robot: usize,
        /// Simulated time that it is stamped with, in nanoseconds; `None` for an unstamped one.
        stamp_ns: Option<u64>,
        /// The command.
        command: Command,
    },
    /// The recorder has taken every topic up to this step.
    Recorded {
        /// The step.
        step: u64,
    },
}

/// What the simulator does.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Sense, and publish the detections, the poses and the digest of this step; in lockstep, the
    /// clock before them.
    Sense {
        /// The step, from 1. In real time it repeats while the world stands.
        step: u64,
        /// Its simulated time, in nanoseconds; `None` in real time, where stamps are wall-clock time.
        stamp_ns: Option<u64>,
    },
    /// Move all robots by one step.
    Advance {
        /// One command for each robot; shape `[n_robots]`.
        commands: Vec<Command>,
    },
    /// Move all robots by one step, each as the conditions' controller decides.
    AdvanceFreely,
    /// Answer the request for steps: no more are made.
    Stepped {
        /// Steps that were not made.
        left: u64,
    },
    /// Give a command to a robot's gate.
    Obey {
        /// Index of the robot.
        robot: usize,
        /// The command.
        command: Command,
    },
    /// Refuse a command, and log it.
    Refuse {
        /// Index of the robot.
        robot: usize,
        /// Why.
        reason: Refusal,
    },
    /// Log that the world does not keep up with the wall clock.
    Overrun {
        /// Periods that were left out since the run started.
        missed: u64,
    },
    /// The run is over.
    Complete {
        /// Why.
        reason: &'static str,
    },
    /// The run cannot be completed and does not count.
    Void {
        /// Why.
        reason: String,
    },
    /// Publish a status.
    Status(Status),
}

/// Why a command was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// It carries no stamp, so that its step is not defined.
    #[error("unstamped command: lockstep needs geometry_msgs/TwistStamped")]
    Unstamped,
    /// It belongs to another step.
    #[error("command stamped {found_ns} ns, expected {expected_ns} ns")]
    OtherStep {
        /// Its stamp.
        found_ns: u64,
        /// The stamp of the step that waits.
        expected_ns: u64,
    },
    /// The robot has already answered this step.
    #[error("second command for one detection")]
    Second,
    /// No robot could follow it, or it is not a number.
    #[error(
        "command of {} m/s and {} rad/s, expected at most {MAX_COMMAND} of each",
        found.speed_m_s, found.turn_rate_rad_s
    )]
    TooGreat {
        /// The command.
        found: Command,
    },
    /// No step waits for commands.
    #[error("no step waits for a command")]
    NotWaiting,
    /// The robot is none of the placed ones.
    #[error("the placed world has {n_robots} robots, and this is not one of them")]
    NotPlaced {
        /// Robots of the placed world.
        n_robots: usize,
    },
}

/// The pace of a simulated fleet, and its key in files.
#[derive(Clone, Debug, Default)]
pub struct Simulator {
    world: WorldState,
    /// How many worlds were placed so far: the number of the newest.
    n_worlds: u64,
    heartbeat: Heartbeat<Standing>,
}

/// How it stands with the simulator.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Standing {
    state: RobotState,
    /// Names the placed world; 0 is none.
    digest: u64,
    /// Which of the simulator's worlds it is, or was.
    world: u64,
    /// Why it does not move; empty while it does.
    reason: Cow<'static, str>,
}

#[derive(Clone, Debug, Default)]
#[expect(clippy::large_enum_variant, reason = "a simulator has one world")]
enum WorldState {
    #[default]
    Empty,
    Refused(String),
    Placed(Run),
}

#[derive(Clone, Debug)]
struct Run {
    placed: Placed,
    progress: Progress,
    pace: TimeMode,
    /// Whether a run holds one of the robots.
    is_held: bool,
    manual: Option<ManualControl>,
}

/// How far a run has come.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Progress {
    Waiting,
    Started,
    Complete(&'static str),
    Void(String),
}

#[derive(Clone, Debug)]
enum TimeMode {
    Lockstep(Lockstep),
    RealTime(RealTime),
}

impl Simulator {
    /// A simulator that waits to be placed.
    pub fn new() -> Self {
        Self::default()
    }

    /// The step that has been sensed last; 0 before the first.
    pub fn step(&self) -> u64 {
        match &self.world {
            WorldState::Placed(Run { manual: Some(manual), .. }) => manual.step(),
            WorldState::Placed(Run { pace: TimeMode::Lockstep(pace), .. }) => pace.step(),
            WorldState::Placed(Run { pace: TimeMode::RealTime(pace), .. }) => pace.step(),
            WorldState::Empty | WorldState::Refused(_) => 0,
        }
    }

    /// When the gates must be looked at even if nothing happens: the next period in real time.
    pub fn due(&self) -> Option<Duration> {
        match &self.world {
            WorldState::Placed(Run { manual: Some(manual), .. }) => manual.due(),
            WorldState::Placed(Run { pace: TimeMode::RealTime(pace), .. }) => Some(pace.due()),
            _ => None,
        }
    }

    /// Takes an event, and returns what to do, in order; a status whenever one is due or something
    /// has changed.
    pub fn on_event(&mut self, event: Event, now: Duration) -> Vec<Action> {
        let mut actions = Vec::new();
        match event {
            Event::Placed(placed) => {
                // A request may come twice.
                if !self.world.is_untouched(&placed) {
                    self.n_worlds += 1;
                }
                self.world = WorldState::Placed(Run::new(placed, now));
            }
            Event::Removed => self.world = WorldState::Empty,
            Event::NotPlaced { reason } => self.world = WorldState::Refused(reason),
            Event::Gates(_) | Event::Command { .. } | Event::Recorded { .. } => {
                if let WorldState::Placed(run) = &mut self.world {
                    run.on_event(&event, now, &mut actions);
                }
            }
        }
        actions.extend(self.status_due(now).map(Action::Status));
        actions
    }

    fn status_due(&mut self, now: Duration) -> Option<Status> {
        let standing = self.standing();
        let counter = self.heartbeat.due(standing.clone(), now)?;
        Some(Status {
            counter,
            epoch: standing.world,
            run_id: String::new(),
            parameter_digest: standing.digest,
            state: standing.state,
            stop_cause: StopCause::None,
            stop_reason: standing.reason.into_owned(),
            battery_v: f32::NAN,
        })
    }

    fn standing(&self) -> Standing {
        let (state, digest, reason) = match &self.world {
            WorldState::Empty => (RobotState::Idle, 0, "no world is placed".into()),
            WorldState::Refused(reason) => (RobotState::Fault, 0, reason.clone().into()),
            WorldState::Placed(Run { manual: Some(_), .. }) => {
                let reason = "moved by hand: a run needs a world that is placed anew";
                (RobotState::Idle, 0, reason.into())
            }
            WorldState::Placed(Run { placed, progress, .. }) => {
                let (state, reason) = match progress {
                    Progress::Waiting => {
                        (RobotState::Armed, "placed, waiting for the start".into())
                    }
                    Progress::Started => (RobotState::Moving, "".into()),
                    Progress::Complete(reason) => (RobotState::Stopped, (*reason).into()),
                    Progress::Void(reason) => (RobotState::Fault, reason.clone().into()),
                };
                (state, placed.digest, reason)
            }
        };
        Standing { state, digest, world: self.n_worlds, reason }
    }
}

impl WorldState {
    /// Whether this world is there, and as it was placed.
    fn is_untouched(&self, wanted: &Placed) -> bool {
        matches!(self, Self::Placed(Run { placed, progress: Progress::Waiting, manual: None, .. })
            if placed == wanted)
    }
}

impl Run {
    fn new(placed: Placed, now: Duration) -> Self {
        assert!(placed.period_ns > 0, "time goes on with every step");
        let pace = match placed.time {
            Time::Lockstep => TimeMode::Lockstep(Lockstep::default()),
            Time::RealTime => TimeMode::RealTime(RealTime::new(now)),
        };
        Self { placed, progress: Progress::Waiting, pace, is_held: false, manual: None }
    }

    fn on_event(&mut self, event: &Event, now: Duration, actions: &mut Vec<Action>) {
        let Self { placed, progress, pace, is_held, manual } = self;
        let mut turn = Turn { placed, progress, now, actions };
        if let Event::Gates(gates) = event {
            *is_held = gates.iter().any(|gate| gate.is_in_run);
        }
        if let Some(manual) = manual {
            if *is_held {
                manual.pause(&mut turn);
            }
            manual.on_event(event, &mut turn);
            return;
        }
        match pace {
            TimeMode::Lockstep(lockstep) => {
                if matches!(turn.progress, Progress::Waiting | Progress::Started) {
                    lockstep.on_event(event, &mut turn);
                }
            }
            TimeMode::RealTime(real_time) => real_time.on_event(event, &mut turn),
        }
    }
}

/// An event of a run: what is known when it happens, and what follows from it.
struct Turn<'a> {
    placed: &'a Placed,
    progress: &'a mut Progress,
    now: Duration,
    actions: &'a mut Vec<Action>,
}

impl Turn<'_> {
    fn complete(&mut self, reason: &'static str) {
        *self.progress = Progress::Complete(reason);
        self.actions.push(Action::Complete { reason });
    }

    fn void(&mut self, cause: &VoidCause) {
        let reason = cause.to_string();
        *self.progress = Progress::Void(reason.clone());
        self.actions.push(Action::Void { reason });
    }
}

/// Refuses what no robot of the world can follow, at any pace.
fn check(placed: &Placed, robot: usize, command: Command) -> Result<(), Refusal> {
    if robot >= placed.robots.len() {
        return Err(Refusal::NotPlaced { n_robots: placed.robots.len() });
    }
    let Command { speed_m_s, turn_rate_rad_s } = command;
    if speed_m_s.abs() <= MAX_COMMAND && turn_rate_rad_s.abs() <= MAX_COMMAND {
        Ok(())
    } else {
        Err(Refusal::TooGreat { found: command })
    }
}

#[cfg(test)]
mod tests;
