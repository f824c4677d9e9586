//! What the samples of a run mean to its machine.

use rsrs_fleet::e_stop::{Message, Source};
use rsrs_fleet::experiment::Time;
use rsrs_fleet::fleet_file::CmdVel;
use rsrs_fleet::message::Status;
use rsrs_fleet::record::Backend;
use rsrs_fleet::runner::{Event, SampleKind};
use rsrs_fleet::wire::{self, Diagnosis};
use rsrs_msgs::cdr::decode;
use rsrs_msgs::diagnostic_msgs::DiagnosticArray;
use rsrs_msgs::geometry_msgs::{TransformStamped, Twist, TwistStamped};
use rsrs_msgs::rsrs::{RobotStatus, RunLease};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::tf2_msgs::TFMessage;
use rsrs_msgs::topics;
use rsrs_ros::clock::wall_time;
use rsrs_ros::session::ReceivedRaw;

use crate::plan::Plan;
use crate::recorded_topics::{RecordedTopic, Role};
use crate::tracked::{SeenPose, seconds_ahead};

/// The event of a sample, except for the simulator's.
///
/// # Errors
///
/// What is wrong with the sample, in words.
pub fn events(
    plan: &Plan,
    topic: &RecordedTopic,
    received: &ReceivedRaw,
) -> anyhow::Result<Vec<Event>> {
    let data = received.message.as_slice();
    let robot = |index: usize| plan.record.robots[index].clone();
    Ok(match topic.role {
        Role::Robot(index) => {
            let message: RobotStatus = decode(data)?;
            let ahead = seconds_ahead(message.header.stamp, received.received_time_ns);
            let clock = ahead.map(|seconds| Event::ClockAhead { robot: robot(index), seconds });
            let status = wire::status(message)?;
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
            let lease = wire::lease(message)?;
            waited.into_iter().chain([Event::LeaseReceived(lease)]).collect()
        }
        Role::EStop => {
            let (source, engaged) = (Source(received.writer), decode::<Bool>(data)?.data);
            vec![Event::EStop(Message::State { source, engaged })]
        }
        Role::EStopRelease => {
            let locks = wire::locks(decode(data)?)?;
            vec![Event::EStop(Message::Release(locks.0.into_keys().collect()))]
        }
        Role::Transforms | Role::StaticTransforms if plan.record.backend != Backend::Simulator => {
            transforms(decode(data)?)
        }
        Role::Diagnostics => diagnoses(plan, decode(data)?),
        // In lockstep the simulator waits for all of them.
        Role::Detection(index) if plan.record.time != Time::Lockstep => {
            vec![Event::Sampled { robot: robot(index), kind: SampleKind::Detection }]
        }
        Role::FurtherDetection(index) if plan.record.time != Time::Lockstep => {
            let reading = topics::further_reading(&topic.name).map(|(_, reading)| reading);
            let kind = SampleKind::FurtherDetection(reading.unwrap_or_default().to_owned());
            vec![Event::Sampled { robot: robot(index), kind }]
        }
        Role::Command(index)
            if plan.record.time != Time::Lockstep && plan.record.backend != Backend::Simulator =>
        {
            let command = wire::command(&commanded(plan, index, data)?)?;
            vec![Event::Commanded { robot: robot(index), command }]
        }
        Role::Detection(_)
        | Role::FurtherDetection(_)
        | Role::Odometry(_)
        | Role::Object
        | Role::Pose(_)
        | Role::Tracker
        | Role::Simulator
        | Role::Command(_)
        | Role::WorldDigest
        | Role::Clock
        | Role::Preparation
        | Role::Transforms
        | Role::StaticTransforms
        | Role::Markers
        | Role::Other => Vec::new(),
    })
}

/// Whether poses are looked at: the simulator has placed its robots itself; among real ones, it publishes
/// their poses as the tracker does.
pub fn looks_at_poses(plan: &Plan) -> bool {
    plan.record.backend != Backend::Simulator
}

/// Where a robot is, and, where that is stamped, by which clock.
pub fn pose_events(seen: SeenPose) -> Vec<Event> {
    let SeenPose { robot, frame, ahead_s, pose, counts } = seen;
    if !counts {
        return Vec::new();
    }
    let clock = ahead_s.map(|seconds| Event::PoseAhead { robot: robot.clone(), seconds });
    let pose = match pose {
        Ok(pose) => Event::Pose { robot, frame, pose },
        Err(reason) => Event::PoseUnusable { robot, reason },
    };
    clock.into_iter().chain([pose]).collect()
}

/// That a pose has come, which must keep coming, and where the robot is; one that cannot be used counts as
/// none.
pub fn pose_sampled(plan: &Plan, seen: SeenPose) -> Vec<Event> {
    let SeenPose { robot, frame, pose, counts, .. } = seen;
    // In lockstep the simulator waits for all of them.
    if plan.record.time == Time::Lockstep {
        return Vec::new();
    }
    match pose {
        Ok(pose) => {
            let sampled = Event::Sampled { robot: robot.clone(), kind: SampleKind::Pose };
            let place = counts.then_some(Event::Pose { robot, frame, pose });
            [sampled].into_iter().chain(place).collect()
        }
        Err(reason) => vec![Event::PoseUnusable { robot, reason }],
    }
}

/// The velocity in a command, of the type that the fleet file states.
fn commanded(plan: &Plan, robot: usize, data: &[u8]) -> anyhow::Result<Twist> {
    Ok(match plan.robots[robot].cmd_vel {
        CmdVel::TwistStamped => decode::<TwistStamped>(data)?.twist,
        CmdVel::Twist => decode(data)?,
    })
}

/// Understands a status, or says what is wrong with it.
pub fn status(data: &[u8]) -> anyhow::Result<Status> {
    Ok(wire::status(decode(data)?)?)
}

/// Diagnoses of the robots of this run.
fn diagnoses(plan: &Plan, array: DiagnosticArray) -> Vec<Event> {
    let event = |diagnosis: Diagnosis| {
        let robot = plan.record.robots.iter().find(|robot| diagnosis.is_of(robot))?.clone();
        let Diagnosis { part, error, .. } = diagnosis;
        Some(Event::Diagnosed { robot, part, error })
    };
    wire::diagnoses(array).into_iter().filter_map(event).collect()
}

fn transforms(message: TFMessage) -> Vec<Event> {
    let transforms = message.transforms.into_iter();
    let event = |transform: TransformStamped| Event::Transform {
        child: transform.child_frame_id,
        parent: transform.header.frame_id,
    };
    transforms.map(event).collect()
}
