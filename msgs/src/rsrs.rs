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

/// What a robot says of itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RobotStatus {
    /// When the robot sent this, by its clock; the frame is empty.
    pub header: Header,
    /// Rises with every status of this robot, over restarts too; the lease echoes it.
    pub counter: u64,
    /// The epoch obeyed now; 0 for none.
    pub epoch: u64,
    /// Digest of the parameters its controller has.
    pub parameter_digest: u64,
    /// [`RobotStatus::IDLE`], [`RobotStatus::ARMED`], [`RobotStatus::MOVING`],
    /// [`RobotStatus::STOPPED`] or [`RobotStatus::FAULT`].
    pub state: u8,
    /// Why it stopped; empty if it did not.
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
    /// Cannot move; `stop_reason` says why.
    pub const FAULT: u8 = 4;
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
