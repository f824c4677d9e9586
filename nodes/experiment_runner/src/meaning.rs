//! What the samples of a run mean to its machine.

use rsrs_core::robot::pose_source::PoseSource;
use rsrs_fleet::e_stop::{Locks, NoLocks, Source};
use rsrs_fleet::experiment::Time;
use rsrs_fleet::message::Status;
use rsrs_fleet::record::Backend;
use rsrs_fleet::runner::{Event, SampleKind};
use rsrs_msgs::builtin_interfaces::Time as Stamp;
use rsrs_msgs::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use rsrs_msgs::geometry_msgs::{self, PoseStamped, TransformStamped};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::{RobotStatus, RunLease};
use rsrs_msgs::std_msgs::{Bool, Header, Text};
use rsrs_msgs::tf2_msgs::TFMessage;
use rsrs_msgs::{RosMessage, cdr};
use rsrs_ros::clock::wall_time;
use rsrs_ros::session::ReceivedRaw;
use rsrs_ros::wire;

use crate::plan::Plan;
use crate::recorded_topics::Role;

/// The event of a sample, except for the simulator's.
///
/// # Errors
///
/// What is wrong with the sample.
pub fn events(plan: &Plan, role: Role, received: &ReceivedRaw) -> Result<Vec<Event>, String> {
    let data = received.message.as_slice();
    let robot = |index: usize| plan.record.robots[index].clone();
    Ok(match role {
        Role::Robot(index) => {
            let message: RobotStatus = decode(data)?;
            let ahead = seconds_ahead(message.header.stamp, received.received_time_ns);
            let clock = ahead.map(|seconds| Event::ClockAhead { robot: robot(index), seconds });
            let status = wire::status(message).map_err(|error| error.to_string())?;
            let status = Event::RobotStatus { robot: robot(index), status };
            clock.into_iter().chain([status]).collect()
        }
        Role::Controller(index) => {
            vec![Event::ControllerStatus { robot: robot(index), status: status(data)? }]
        }
        Role::Lease => {
            let message: RunLease = decode(data)?;
            let waited = (message.run_id == plan.record.run_id)
                .then(|| seconds_ahead(message.header.stamp, wall_time().to_nanos()?))
                .flatten()
                .map(|ahead_s| Event::Behind { seconds: -ahead_s });
            let lease = wire::lease(message).map_err(|error| error.to_string())?;
            waited.into_iter().chain([Event::LeaseReceived(lease)]).collect()
        }
        Role::EStop => {
            let (source, engaged) = (Source(received.writer), decode::<Bool>(data)?.data);
            vec![Event::EStop { source, engaged }]
        }
        Role::EStopRelease => {
            let locks: Locks =
                decode::<Text>(data)?.data.parse().map_err(|error: NoLocks| error.to_string())?;
            vec![Event::Release(locks.0.into_keys().collect())]
        }
        Role::Transforms | Role::StaticTransforms if plan.record.backend != Backend::Simulator => {
            transforms(decode(data)?)
        }
        Role::Diagnostics => diagnoses(plan, decode(data)?),
        Role::Odometry(index) if is_wanted(plan, index, PoseSource::Odom) => {
            let Odometry { header, pose, .. } = decode(data)?;
            pose_events(robot(index), (header, received.received_time_ns), &pose.pose)
        }
        Role::Pose(index) if is_wanted(plan, index, PoseSource::Pose) => {
            let PoseStamped { header, pose } = decode(data)?;
            pose_events(robot(index), (header, received.received_time_ns), &pose)
        }
        Role::Detection(_) => sampled(plan, role, data)?.into_iter().collect(),
        Role::Odometry(_)
        | Role::Pose(_)
        | Role::Simulator
        | Role::Command
        | Role::WorldDigest
        | Role::Clock
        | Role::Preparation
        | Role::Transforms
        | Role::StaticTransforms
        | Role::Markers
        | Role::Other => Vec::new(),
    })
}

/// That a sample has come which must keep coming, or a pose that cannot be used and counts as none.
///
/// # Errors
///
/// If it is not of its topic's type.
pub fn sampled(plan: &Plan, role: Role, data: &[u8]) -> Result<Option<Event>, String> {
    let (index, kind) = match role {
        Role::Detection(index) => (index, SampleKind::Detection),
        Role::Odometry(index) if is_wanted(plan, index, PoseSource::Odom) => {
            (index, SampleKind::Pose)
        }
        Role::Pose(index) if is_wanted(plan, index, PoseSource::Pose) => (index, SampleKind::Pose),
        _ => return Ok(None),
    };
    // In lockstep the simulator waits for all of them.
    if plan.record.time == Time::Lockstep {
        return Ok(None);
    }
    let robot = plan.record.robots[index].clone();
    let pose = match role {
        Role::Odometry(_) => Some(decode::<Odometry>(data)?.pose.pose),
        Role::Pose(_) => Some(decode::<PoseStamped>(data)?.pose),
        _ => None,
    };
    Ok(Some(match pose.map(|pose| wire::pose(&pose)).transpose() {
        Ok(_) => Event::Sampled { robot, kind },
        Err(error) => Event::PoseUnusable { robot, reason: error.to_string() },
    }))
}

/// Understands a status.
///
/// # Errors
///
/// What is wrong with it.
pub fn status(data: &[u8]) -> Result<Status, String> {
    wire::status(decode(data)?).map_err(|error| error.to_string())
}

fn decode<M: RosMessage>(data: &[u8]) -> Result<M, String> {
    cdr::decode(data).map_err(|error| error.to_string())
}

/// The simulator has placed its robots itself; among real ones, it publishes their poses as the
/// tracker does.
fn is_wanted(plan: &Plan, robot: usize, source: PoseSource) -> bool {
    match plan.record.backend {
        Backend::Simulator => false,
        Backend::Fleet => plan.pose_of(robot) == source,
        Backend::Mixed => plan.tracked_by() == source,
    }
}

/// How far a stamp is ahead of a time on our clock, in seconds; `None` for one that was not set.
fn seconds_ahead(stamp: Stamp, ours_ns: u64) -> Option<f64> {
    let stamp_ns = stamp.to_nanos().filter(|nanos| *nanos > 0)?;
    Some((i128::from(stamp_ns) - i128::from(ours_ns)) as f64 / 1e9)
}

/// Diagnoses of the robots of this run: their hardware's name, or the first part of their own, is
/// that of the robot.
fn diagnoses(plan: &Plan, array: DiagnosticArray) -> Vec<Event> {
    let robots = &plan.record.robots;
    let of_robot = |diagnosis: &DiagnosticStatus| {
        let name = diagnosis.name.trim_start_matches('/');
        let first = name.split(['/', ':', ' ']).next().unwrap_or("");
        robots.iter().find(|robot| *robot == first || **robot == diagnosis.hardware_id).cloned()
    };
    array
        .status
        .into_iter()
        .filter_map(|diagnosis| {
            let robot = of_robot(&diagnosis)?;
            let is_error =
                matches!(diagnosis.level, DiagnosticStatus::ERROR | DiagnosticStatus::STALE);
            let error = is_error.then_some(diagnosis.message);
            Some(Event::Diagnosed { robot, part: diagnosis.name, error })
        })
        .collect()
}

fn transforms(message: TFMessage) -> Vec<Event> {
    let transforms = message.transforms.into_iter();
    let event = |transform: TransformStamped| Event::Transform {
        child: transform.child_frame_id,
        parent: transform.header.frame_id,
    };
    transforms.map(event).collect()
}

/// Where a robot is, and, where that is stamped, by which clock.
fn pose_events(
    robot: String,
    (header, received_ns): (Header, u64),
    pose: &geometry_msgs::Pose,
) -> Vec<Event> {
    let ahead = seconds_ahead(header.stamp, received_ns);
    let clock = ahead.map(|seconds| Event::PoseAhead { robot: robot.clone(), seconds });
    let pose = match wire::pose(pose) {
        Ok(pose) => Event::Pose { robot, frame: header.frame_id, pose },
        Err(error) => Event::PoseUnusable { robot, reason: error.to_string() },
    };
    clock.into_iter().chain([pose]).collect()
}
