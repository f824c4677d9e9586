//! The protocol's events from ROS messages, and messages from its actions.
//!
//! What a message cannot mean in the protocol is refused here, so that no machine has to check its
//! events again.

use rsrs_core::printable::one_line;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::Pose;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use rsrs_msgs::geometry_msgs::{
    self, NoOrientation, Point, PoseStamped, Quaternion, Twist, TwistStamped, Vector3,
};
use rsrs_msgs::rsrs::{EStopLock, EStopLocks, LockCause, RobotStatus, RunLease, UnknownNumber};
use rsrs_msgs::std_msgs::Header;

use crate::e_stop::{Locks, MOST_SOURCES, Source};
use crate::message::{Echo, Lease, LeaseState, RobotState, Status, StopCause};

/// Why a message does not mean anything in the protocol.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InvalidMessage {
    /// A state or a cause that the protocol does not have.
    #[error(transparent)]
    Unknown(#[from] UnknownNumber),
    /// A lease whose lists do not belong together.
    #[error("lease for {robots} robots with {counters} echoed counters")]
    Lengths {
        /// Robots named.
        robots: usize,
        /// Counters echoed.
        counters: usize,
    },
    /// A velocity that is not a number.
    #[error("velocity command that is not finite")]
    NotFinite,
    /// A position that is not a number.
    #[error("position that is not finite: ({x_m}, {y_m}) m")]
    Position {
        /// To the front, as found.
        x_m: f64,
        /// To the left, as found.
        y_m: f64,
    },
    /// A pose without an orientation.
    #[error(transparent)]
    Orientation(#[from] NoOrientation),
}

/// What a part of some robot says of itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnosis {
    /// The part, as it calls itself.
    pub part: String,
    hardware: String,
    /// What is wrong with it; `None` where nothing is.
    pub error: Option<String>,
}

impl Diagnosis {
    /// Whether it is of this robot: its hardware's name, or what its own begins with, is that of the robot.
    pub fn is_of(&self, robot: &str) -> bool {
        let rest = self.part.trim_start_matches('/').strip_prefix(robot);
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['/', ':', ' ']))
            || self.hardware.trim_start_matches('/') == robot
    }
}

/// Understands diagnoses.
pub fn diagnoses(array: DiagnosticArray) -> Vec<Diagnosis> {
    let diagnosis = |DiagnosticStatus { level, name, message, hardware_id, .. }| Diagnosis {
        part: name,
        hardware: hardware_id,
        error: match level {
            DiagnosticStatus::STALE if message.is_empty() => Some("no longer updated".to_owned()),
            DiagnosticStatus::ERROR | DiagnosticStatus::STALE => Some(message),
            _ => None,
        },
    };
    array.status.into_iter().map(diagnosis).collect()
}

/// Where a node that starts now, by the wall clock, begins to count its statuses: above all that it
/// counted before it was started again, as long as its clock goes forward and it sends fewer than a
/// thousand a second.
pub fn first_counter(now: Time) -> u64 {
    now.to_nanos().unwrap_or(0) / 1_000_000
}

/// Reads a lease.
pub fn lease(message: RunLease) -> Result<Lease, InvalidMessage> {
    let state = LeaseState::try_from(message.state)?;
    let (robots, counters) = (message.robots.len(), message.echoed_counter.len());
    if robots != counters {
        return Err(InvalidMessage::Lengths { robots, counters });
    }
    let echoes = message.robots.into_iter().zip(message.echoed_counter);
    Ok(Lease {
        run_id: message.run_id,
        epoch: message.epoch,
        state,
        parameter_digest: message.parameter_digest,
        robots: echoes.map(|(robot, counter)| Echo { robot, counter }).collect(),
    })
}

/// Puts a lease into a message, sent at `stamp`.
pub fn lease_message(lease: &Lease, stamp: Time) -> RunLease {
    RunLease {
        header: Header { stamp, frame_id: String::new() },
        run_id: lease.run_id.clone(),
        epoch: lease.epoch,
        state: lease.state.into(),
        parameter_digest: lease.parameter_digest,
        robots: lease.robots.iter().map(|echo| echo.robot.clone()).collect(),
        echoed_counter: lease.robots.iter().map(|echo| echo.counter).collect(),
    }
}

/// The longest reason for standing that is kept, in characters.
const MOST_REASON: usize = 200;

/// Reads a status; its reason is anybody's text, and is kept as one line that is not too long.
pub fn status(message: RobotStatus) -> Result<Status, InvalidMessage> {
    let state = RobotState::try_from(message.state)?;
    let stop_cause = StopCause::try_from(message.stop_cause)?;
    Ok(Status {
        counter: message.counter,
        epoch: message.epoch,
        run_id: message.run_id,
        parameter_digest: message.parameter_digest,
        state,
        stop_cause,
        stop_reason: one_line(&message.stop_reason).chars().take(MOST_REASON).collect(),
        battery_v: message.battery_v,
    })
}

/// Puts a status into a message, sent at `stamp`.
pub fn status_message(status: &Status, stamp: Time) -> RobotStatus {
    RobotStatus {
        header: Header { stamp, frame_id: String::new() },
        counter: status.counter,
        epoch: status.epoch,
        run_id: status.run_id.clone(),
        parameter_digest: status.parameter_digest,
        stop_cause: status.stop_cause.into(),
        state: status.state.into(),
        stop_reason: status.stop_reason.clone(),
        battery_v: status.battery_v,
    }
}

/// Reads locks of the e-stop; of more than a robot keeps, one stands for the rest.
pub fn locks(message: EStopLocks) -> Result<Locks, InvalidMessage> {
    let lock = |EStopLock { source, cause }| Ok((Source(source), LockCause::try_from(cause)?));
    message.locks.into_iter().take(MOST_SOURCES + 1).map(lock).collect::<Result<_, _>>().map(Locks)
}

/// Puts locks of the e-stop into a message.
pub fn locks_message(locks: &Locks) -> EStopLocks {
    let lock = |(source, cause): (&Source, &LockCause)| EStopLock {
        source: source.0,
        cause: (*cause).into(),
    };
    EStopLocks { locks: locks.0.iter().map(lock).collect() }
}

/// Reads a velocity command of finite numbers: `x` of the linear part, `z` of the angular
/// part (REP 103).
pub fn command(twist: &Twist) -> Result<Command, InvalidMessage> {
    let command = Command { speed_m_s: twist.linear.x, turn_rate_rad_s: twist.angular.z };
    if command.speed_m_s.is_finite() && command.turn_rate_rad_s.is_finite() {
        Ok(command)
    } else {
        Err(InvalidMessage::NotFinite)
    }
}

/// Reads a pose on the floor: its heading is the turn around the vertical axis (REP 103).
pub fn pose(message: &geometry_msgs::Pose) -> Result<Pose, InvalidMessage> {
    let (x_m, y_m) = (message.position.x, message.position.y);
    if !(x_m.is_finite() && y_m.is_finite()) {
        return Err(InvalidMessage::Position { x_m, y_m });
    }
    Ok(Pose { x_m, y_m, heading_rad: message.orientation.heading_rad()? })
}

/// Puts a velocity command into a message.
pub fn twist(command: Command) -> Twist {
    Twist {
        linear: Vector3 { x: command.speed_m_s, y: 0.0, z: 0.0 },
        angular: Vector3 { x: 0.0, y: 0.0, z: command.turn_rate_rad_s },
    }
}

/// Puts a velocity command into a stamped message.
pub fn twist_stamped(command: Command, stamp: Time) -> TwistStamped {
    TwistStamped {
        header: Header { stamp, frame_id: "base_link".to_owned() },
        twist: twist(command),
    }
}

/// Where an object is on the floor, in metres; discs head nowhere.
pub fn object_pose(place_m: [f64; 2], stamp: Time) -> PoseStamped {
    let [x, y] = place_m;
    let position = Point { x, y, z: 0.0 };
    PoseStamped {
        header: Header { stamp, frame_id: "map".to_owned() },
        pose: geometry_msgs::Pose {
            position,
            orientation: Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 },
        },
    }
}

#[cfg(test)]
mod tests {

    use super::*;

    #[test]
    fn a_lease_comes_back_as_it_went() {
        let sent = Lease {
            run_id: "run 7".to_owned(),
            epoch: 7,
            state: LeaseState::Running,
            parameter_digest: 42,
            robots: vec![Echo { robot: "robot_1".to_owned(), counter: 3 }],
        };

        assert_eq!(lease(lease_message(&sent, Time::default())), Ok(sent));
    }

    #[test]
    fn a_status_comes_back_as_it_went() {
        let sent = Status {
            counter: 3,
            epoch: 7,
            run_id: "run 7".to_owned(),
            parameter_digest: 42,
            state: RobotState::Fault,
            stop_cause: StopCause::Hardware,
            stop_reason: "wheel".to_owned(),
            battery_v: 7.4,
        };

        assert_eq!(status(status_message(&sent, Time::default())), Ok(sent));
    }

    #[test]
    fn locks_come_back_as_they_went_and_a_cause_that_does_not_exist_is_refused() {
        let sent = Locks(
            [(Source([1; 16]), LockCause::Engaged), (Source([2; 16]), LockCause::Silent)].into(),
        );
        let mut message = locks_message(&sent);

        assert_eq!(locks(message.clone()), Ok(sent));
        assert_eq!(locks(EStopLocks::default()), Ok(Locks::default()));
        message.locks[1].cause = 0;
        let refused = locks(message).unwrap_err().to_string();
        assert_eq!(refused, "cause of a lock 0, expected 1 to 2");
    }

    #[test]
    fn a_state_that_does_not_exist_is_refused() {
        let message = RunLease { state: 9, ..RunLease::default() };

        assert_eq!(
            lease(message),
            Err(UnknownNumber { kind: "lease state", found: 9, known: [0, 3] }.into())
        );
    }

    #[test]
    fn a_lease_with_lists_of_different_lengths_is_refused() {
        let message = RunLease { robots: vec!["robot_1".to_owned()], ..RunLease::default() };

        assert_eq!(lease(message), Err(InvalidMessage::Lengths { robots: 1, counters: 0 }));
    }

    #[test]
    fn a_velocity_that_is_not_a_number_is_refused() {
        let mut message = twist(Command { speed_m_s: 0.15, turn_rate_rad_s: -0.75 });
        assert_eq!(command(&message), Ok(Command { speed_m_s: 0.15, turn_rate_rad_s: -0.75 }));

        message.angular.z = f64::NAN;

        assert_eq!(command(&message), Err(InvalidMessage::NotFinite));
    }

    #[test]
    fn a_pose_has_a_heading_around_the_vertical_axis_and_a_place() {
        let half_rad = 0.5 * 2.5;
        let mut message = geometry_msgs::Pose::default();
        message.position.x = 1.0;
        message.orientation =
            Quaternion { x: 0.0, y: 0.0, z: libm::sin(half_rad), w: libm::cos(half_rad) };

        let found = pose(&message).unwrap();
        let positions_only = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 0.0 };
        let without = geometry_msgs::Pose { orientation: positions_only, ..message };
        message.position.y = f64::NAN;

        assert!((found.heading_rad - 2.5).abs() < 1e-12 && (found.x_m - 1.0).abs() < 1e-12);
        assert!(matches!(pose(&message), Err(InvalidMessage::Position { .. })));
        let reason = pose(&without).unwrap_err().to_string();
        assert_eq!(reason, "no orientation: a quaternion of length 0.000, expected 1");
    }
}
