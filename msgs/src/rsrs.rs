//! Package `rsrs_msgs`: our own messages, defined in `msg/*.msg`.

use serde::{Deserialize, Serialize};

use crate::message::ros_messages;
use crate::std_msgs::Header;

/// The runner's permission to move.
///
/// A robot's lease is fresh for 500 ms after the robot itself sent the status counter that is
/// echoed here, on its own monotonic clock.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RunLease {
    /// When the runner sent this, by its clock; the frame is empty.
    pub header: Header,
    /// Which run this is; the same in the bag's experiment record.
    pub run_id: String,
    /// Counts up from 1; a new runner takes the highest epoch it has received, plus one.
    pub epoch: u64,
    /// [`RunLease::IDLE`], [`RunLease::ARMED`], [`RunLease::RUNNING`] or [`RunLease::STOPPED`].
    pub state: u8,
    /// Digest of the parameters every controller must report.
    pub parameter_digest: u64,
    /// Names of the robots that may move; shape `[n_robots]`.
    pub robots: Vec<String>,
    /// The last status counter received from each robot, 0 for none; shape `[n_robots]`.
    pub echoed_counter: Vec<u64>,
}

impl RunLease {
    /// No run.
    pub const IDLE: u8 = 0;
    /// Parameters are set and read-only; nothing moves yet.
    pub const ARMED: u8 = 1;
    /// Robots obey their controllers.
    pub const RUNNING: u8 = 2;
    /// The run is over; a stop latches until a newer epoch.
    pub const STOPPED: u8 = 3;
}

/// The status of a robot.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RobotStatus {
    /// When the robot sent this, by its clock; the frame is empty.
    pub header: Header,
    /// Rises with every status of this robot, over restarts too; the lease echoes it.
    pub counter: u64,
    /// The epoch obeyed now; 0 for none.
    pub epoch: u64,
    /// The run that it belongs to; empty for none.
    pub run_id: String,
    /// Digest of the parameters its controller has.
    pub parameter_digest: u64,
    /// [`RobotStatus::IDLE`], [`RobotStatus::ARMED`], [`RobotStatus::MOVING`],
    /// [`RobotStatus::STOPPED`] or [`RobotStatus::FAULT`].
    pub state: u8,
    /// Why it stands: [`RobotStatus::CAUSE_NONE`] to [`RobotStatus::CAUSE_HARDWARE`].
    pub stop_cause: u8,
    /// The cause in words, for people only; empty if it may move.
    pub stop_reason: String,
    /// Battery voltage, in volts; NaN if unknown.
    pub battery_v: f32,
}

impl RobotStatus {
    /// Alive, and no run has claimed it.
    pub const IDLE: u8 = 0;
    /// Bound to a run whose parameters it has; not moving.
    pub const ARMED: u8 = 1;
    /// Obeying its controller.
    pub const MOVING: u8 = 2;
    /// Stopped, and latched until a newer epoch.
    pub const STOPPED: u8 = 3;
    /// Cannot move; `stop_cause` and `stop_reason` give the cause.
    pub const FAULT: u8 = 4;

    /// It may move, or the sender is no robot.
    pub const CAUSE_NONE: u8 = 0;
    /// No run has claimed it.
    pub const CAUSE_NO_RUN: u8 = 1;
    /// Its node has just started and asks the others for the e-stop.
    pub const CAUSE_ASKING: u8 = 2;
    /// Its simulator has placed no world.
    pub const CAUSE_NO_WORLD: u8 = 3;
    /// Armed for `run_id`, which has not started.
    pub const CAUSE_WAITING: u8 = 4;
    /// It receives a running lease for which it was not armed.
    pub const CAUSE_NOT_ARMED: u8 = 5;
    /// Its lease ran out.
    pub const CAUSE_LEASE: u8 = 6;
    /// Its controller is silent, or has other parameters than the confirmed ones.
    pub const CAUSE_CONTROLLER: u8 = 7;
    /// The e-stop holds it, whatever else does.
    pub const CAUSE_E_STOP: u8 = 8;
    /// Latched until a newer epoch arms it.
    pub const CAUSE_LATCHED: u8 = 9;
    /// Its hardware has failed.
    pub const CAUSE_HARDWARE: u8 = 10;
}

/// The fingerprint of the simulated world after a lockstep step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct WorldDigest {
    /// Steps taken since the world was placed; 0 is the placement itself.
    pub step: u64,
    /// Digest over the bits of every robot's state.
    pub digest: u64,
}

/// The recorder's acknowledgement in a lockstep run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Recorded {
    /// The lowest step that has been taken on every recorded topic.
    pub step: u64,
}

ros_messages! {
    RunLease => "rsrs_msgs/msg/RunLease",
    RobotStatus => "rsrs_msgs/msg/RobotStatus",
    WorldDigest => "rsrs_msgs/msg/WorldDigest",
    Recorded => "rsrs_msgs/msg/Recorded",
}
