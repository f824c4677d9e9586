//! What the nodes say to each other, free of any wire format.

use std::fmt;
use std::time::Duration;

use crate::timing::LEASE;

/// The runner's permission to move, repeated ten times a second.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lease {
    /// The run that it belongs to.
    pub run_id: String,
    /// Rises with every run; a robot never obeys an epoch lower than one it has received.
    pub epoch: u64,
    /// What the robots may do.
    pub state: LeaseState,
    /// Digest of the controller parameters that the runner confirmed.
    pub parameter_digest: u64,
    /// The robots of the run, each with the counter of the last status the runner received from it.
    pub robots: Vec<Echo>,
}

/// One robot's place in a lease.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Echo {
    /// The robot.
    pub robot: String,
    /// Counter of its last status that the runner received; 0 if none.
    pub counter: u64,
}

impl Lease {
    /// The echo for one robot, if it is part of the run.
    pub fn echo(&self, robot: &str) -> Option<u64> {
        self.robots.iter().find(|echo| echo.robot == robot).map(|echo| echo.counter)
    }
}

/// What a lease lets the robots do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeaseState {
    /// Nothing; the runner prepares.
    Idle,
    /// Bind to this epoch and stand still.
    Armed,
    /// Move.
    Running,
    /// Stand still for good.
    Stopped,
}

/// What a robot, or its controller, says of itself, ten times a second and on change.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// Rises with every status sent, over restarts too, because whoever starts begins above all that
    /// it ever counted; the lease echoes it.
    pub counter: u64,
    /// The epoch obeyed; 0 is none.
    pub epoch: u64,
    /// Digest of its controller's parameters; 0 is unknown.
    pub parameter_digest: u64,
    /// What it does.
    pub state: RobotState,
    /// Why it stands; empty while it may move.
    pub stop_reason: String,
    /// Battery voltage; not a number if unknown.
    pub battery_v: f32,
}

/// How the reason of a robot that stands begins while the e-stop holds it, whatever else does.
pub const E_STOP_REASON: &str = "e-stop";

/// The reason of a robot of a simulator that has placed no world with it: it senses and moves nothing.
pub const WITHOUT_WORLD_REASON: &str = "its simulator has placed no world: set its `conditions`";

/// Around the name of the run for which a robot or controller waits.
const ARMED_FOR: (&str, &str) = ("armed for run ", ", waiting for the start");

/// The reason of a robot or controller that stands because its run has not started, as its statuses
/// tell it: whose it is.
pub fn armed_reason(run_id: &str) -> String {
    let (before, after) = ARMED_FOR;
    format!("{before}{run_id}{after}")
}

impl Status {
    /// The run for whose start it waits; `None` if it does not wait, or does not say.
    pub fn armed_for(&self) -> Option<&str> {
        let (before, after) = ARMED_FOR;
        let run_id = self.stop_reason.strip_prefix(before)?.strip_suffix(after)?;
        (self.state == RobotState::Armed).then_some(run_id)
    }

    /// Whether it is newer than what was received from its sender last.
    ///
    /// A lower counter is that of a message that was late, or came again. Who was silent for as long
    /// as a lease lasts may say anything: no lease echoes it, so that nothing it says keeps a robot
    /// moving, and one whose clock was set back before it started would not be received otherwise.
    ///
    /// # Arguments
    ///
    /// * `last` — the counter of the newest status so far, and when it was received.
    pub fn is_news(&self, last: Option<(u64, Duration)>, now: Duration) -> bool {
        last.is_none_or(|(counter, at)| self.counter > counter || now.saturating_sub(at) > LEASE)
    }

    /// Whether it is a robot of a simulator without a world.
    pub fn is_without_world(&self) -> bool {
        self.state == RobotState::Idle && self.stop_reason == WITHOUT_WORLD_REASON
    }

    /// Whether this robot has received the e-stop and is locked by it.
    pub fn holds_e_stop(&self) -> bool {
        let stands = matches!(self.state, RobotState::Stopped | RobotState::Fault);
        stands && self.stop_reason.starts_with(E_STOP_REASON)
    }
}

/// What a robot does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RobotState {
    /// It belongs to no run.
    Idle,
    /// It is bound to an epoch and stands.
    Armed,
    /// It may move.
    Moving,
    /// It stands and stays so until a newer epoch arms it.
    Stopped,
    /// Its hardware has failed.
    Fault,
}

impl fmt::Display for RobotState {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Idle => "idle",
            Self::Armed => "armed",
            Self::Moving => "moving",
            Self::Stopped => "stopped",
            Self::Fault => "fault",
        })
    }
}
