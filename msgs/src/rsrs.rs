//! Package `rsrs_msgs`: our own messages, defined in `msg/*.msg`.

use std::fmt;

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
    /// A [`LeaseState`].
    pub state: u8,
    /// Digest of the parameters every controller must report.
    pub parameter_digest: u64,
    /// Names of the robots that may move; shape `[n_robots]`.
    pub robots: Vec<String>,
    /// The last status counter received from each robot, 0 for none; shape `[n_robots]`.
    pub echoed_counter: Vec<u64>,
}

/// The status of a robot.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RobotStatus {
    /// When the robot sent this, by its clock; the frame is empty.
    pub header: Header,
    /// Rises with every status of this robot, over restarts too; the lease echoes it.
    pub counter: u64,
    /// The epoch obeyed now; 0 for none. From the simulator: the number of its world, from 1.
    pub epoch: u64,
    /// The run that it belongs to; empty for none.
    pub run_id: String,
    /// Digest of the parameters its controller has.
    pub parameter_digest: u64,
    /// A [`RobotState`].
    pub state: u8,
    /// Why it stands: a [`StopCause`].
    pub stop_cause: u8,
    /// The cause in words, for people only; empty if it may move.
    pub stop_reason: String,
    /// Battery voltage, in volts; NaN if unknown.
    pub battery_v: f32,
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

/// A number in a message that stands for nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{kind} {found}, expected {} to {}", known[0], known[1])]
pub struct UnknownNumber {
    /// Of what, such as `lease state`.
    pub kind: &'static str,
    /// The number found.
    pub found: u8,
    /// The least and the greatest that stand for something.
    pub known: [u8; 2],
}

/// Enums that messages contain as a `uint8`, whose constants are those of the `.msg` file.
macro_rules! numbered {
    ($(
        $(#[$attribute:meta])*
        $name:ident, $kind:literal {
            $($(#[$of_variant:meta])* $variant:ident = $number:literal,)+
        }
    )+) => {
        $(
            $(#[$attribute])*
            #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
            #[repr(u8)]
            pub enum $name {
                $($(#[$of_variant])* $variant = $number,)+
            }

            impl $name {
                /// All of them, in the order of their numbers.
                pub const ALL: &[Self] = &[$(Self::$variant),+];
            }

            impl From<$name> for u8 {
                fn from(value: $name) -> Self {
                    value as Self
                }
            }

            impl PartialEq<$name> for u8 {
                fn eq(&self, other: &$name) -> bool {
                    *self == Self::from(*other)
                }
            }

            impl TryFrom<u8> for $name {
                type Error = UnknownNumber;

                fn try_from(found: u8) -> Result<Self, UnknownNumber> {
                    let [least, .., most] = Self::ALL else { unreachable!("there are several") };
                    let known = [*least as u8, *most as u8];
                    let mut all = Self::ALL.iter().copied();
                    all.find(|value| *value as u8 == found).ok_or(UnknownNumber {
                        kind: $kind,
                        found,
                        known,
                    })
                }
            }
        )+
    };
}

numbered! {
    /// What a lease lets the robots do.
    LeaseState, "lease state" {
        /// Nothing; the runner prepares.
        Idle = 0,
        /// Bind to this epoch and stand still.
        Armed = 1,
        /// Move.
        Running = 2,
        /// Stand still for good.
        Stopped = 3,
    }

    /// What a robot does.
    RobotState, "robot state" {
        /// It belongs to no run.
        Idle = 0,
        /// It is bound to an epoch and stands.
        Armed = 1,
        /// It may move.
        Moving = 2,
        /// It stands, and stays so until a newer epoch arms it if its stop is latched.
        Stopped = 3,
        /// Its hardware has failed.
        Fault = 4,
    }

    /// Why a robot stands.
    #[derive(Default)]
    StopCause, "stop cause" {
        /// It may move, or the sender is no robot.
        #[default]
        None = 0,
        /// No run has claimed it.
        NoRun = 1,
        /// Its node has just started and asks the others for the e-stop.
        Asking = 2,
        /// Its simulator has placed no world with it: it senses and moves nothing.
        NoWorld = 3,
        /// It is armed for a run that has not started.
        Waiting = 4,
        /// It receives a running lease for which it was not armed.
        NotArmed = 5,
        /// Its lease ran out.
        Lease = 6,
        /// Its controller is silent, or has other parameters than the confirmed ones.
        Controller = 7,
        /// The e-stop holds it, whatever else does.
        EStop = 8,
        /// Latched until a newer epoch arms it.
        Latched = 9,
        /// Its hardware has failed.
        Hardware = 10,
    }

    /// How a source of the e-stop came to lock.
    LockCause, "cause of a lock" {
        /// It published `true`.
        Engaged = 1,
        /// It was received during a run, and then no more.
        Silent = 2,
    }
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

/// A lock of the e-stop, by who holds it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EStopLock {
    /// GUID of the publisher on `/swarm/e_stop` that locks.
    pub source: [u8; 16],
    /// A [`LockCause`].
    pub cause: u8,
}

/// Locks of the e-stop: those that hold, or those that a release ends.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EStopLocks {
    /// One for each source; shape `[n_sources]`.
    pub locks: Vec<EStopLock>,
}

ros_messages! {
    RunLease => "rsrs_msgs/msg/RunLease",
    RobotStatus => "rsrs_msgs/msg/RobotStatus",
    WorldDigest => "rsrs_msgs/msg/WorldDigest",
    Recorded => "rsrs_msgs/msg/Recorded",
    EStopLock => "rsrs_msgs/msg/EStopLock",
    EStopLocks => "rsrs_msgs/msg/EStopLocks",
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RosMessage;
    use crate::schema::own_text;

    /// The constants of a definition whose names have a prefix, in order, such as `E_STOP` of
    /// `uint8 CAUSE_E_STOP = 8`.
    fn constants(type_name: &str, prefix: &str) -> Vec<(String, u8)> {
        let lines = own_text(type_name).unwrap().lines();
        let constant = |line: &str| {
            let (name, number) = line.strip_prefix("uint8 ")?.split_once(" = ")?;
            Some((name.strip_prefix(prefix)?.to_owned(), number.parse().unwrap()))
        };
        lines.filter_map(constant).collect()
    }

    /// The same of an enum: `EStop` is `E_STOP`.
    fn variants<E: fmt::Debug + Copy + Into<u8>>(all: &[E]) -> Vec<(String, u8)> {
        let name = |value: &E| {
            let mut name = String::new();
            for letter in format!("{value:?}").chars() {
                if letter.is_uppercase() && !name.is_empty() {
                    name.push('_');
                }
                name.push(letter.to_ascii_uppercase());
            }
            name
        };
        all.iter().map(|value| (name(value), (*value).into())).collect()
    }

    #[test]
    fn enums_have_the_numbers_of_the_definitions() {
        assert_eq!(variants(LeaseState::ALL), constants(RunLease::TYPE_NAME, ""));
        let of_status = constants(RobotStatus::TYPE_NAME, "");
        let is_state = |(name, _): &&(String, u8)| !name.starts_with("CAUSE_");
        let states: Vec<_> = of_status.iter().filter(is_state).cloned().collect();
        assert_eq!(variants(RobotState::ALL), states);
        assert_eq!(variants(StopCause::ALL), constants(RobotStatus::TYPE_NAME, "CAUSE_"));
        assert_eq!(variants(LockCause::ALL), constants(EStopLock::TYPE_NAME, ""));
    }

    #[test]
    fn a_number_that_stands_for_nothing_is_refused() {
        assert_eq!(RobotState::try_from(4), Ok(RobotState::Fault));
        let refused = RobotState::try_from(5).unwrap_err().to_string();
        assert_eq!(refused, "robot state 5, expected 0 to 4");
        assert!(LockCause::try_from(0).is_err());
    }
}
