//! What must be there for a run, and what is there.

use std::time::Duration;

use rsrs_fleet::experiment::Time;
use rsrs_fleet::fleet_file::PoseSource;
use rsrs_fleet::preflight::{Expected, ExpectedTopic, Graph, Publisher, Publishers};
use rsrs_fleet::record::Backend;
use rsrs_fleet::runner::{Pace, RunnerOptions};
use rsrs_fleet::simulator::placement_digest;
use rsrs_msgs::topics;
use rsrs_ros::session::{EndpointKind, Session};

use crate::ears::{Ear, Role};
use crate::plan::Plan;

/// What the machine must know of a run.
pub fn runner_options(plan: &Plan, ears: &[Ear]) -> RunnerOptions {
    let record = &plan.record;
    let pace = match record.time {
        Time::Lockstep => Pace::Lockstep { steps: plan.steps() },
        Time::RealTime => Pace::RealTime { duration: Duration::from_secs_f64(record.duration_s) },
    };
    RunnerOptions {
        run_id: record.run_id.clone(),
        expected: expected(plan, ears),
        controller: record.conditions.controller,
        simulator_digest: placement_digest(
            &record.conditions,
            record.seed,
            record.replicate,
            plan.steps(),
        ),
        pace,
        robot_lost: record.robot_lost,
    }
}

fn expected(plan: &Plan, ears: &[Ear]) -> Expected {
    let tracked = plan.record.backend == Backend::Fleet
        && plan.robots.iter().any(|robot| robot.pose == PoseSource::Pose);
    let topics = ears
        .iter()
        .filter_map(|ear| {
            let publishers = match ear.role {
                Role::Detection | Role::Command => Publishers::One,
                Role::Odometry if !tracked => Publishers::One,
                _ => return None,
            };
            let type_name = ear.topic.type_name.to_owned();
            Some(ExpectedTopic { name: ear.name.clone(), type_name, publishers })
        })
        .chain(tracked.then(|| plan.robots.iter().map(pose_topic)).into_iter().flatten())
        .collect();
    Expected {
        robots: plan.record.robots.clone(),
        simulator: plan.record.backend == Backend::Simulator,
        topics,
    }
}

fn pose_topic(robot: &rsrs_fleet::fleet_file::FleetRobot) -> ExpectedTopic {
    let topic = match robot.pose {
        PoseSource::Odom => topics::ODOM,
        PoseSource::Pose => topics::POSE,
    };
    ExpectedTopic {
        name: topic.for_robot(&robot.name),
        type_name: topic.type_name.to_owned(),
        publishers: Publishers::One,
    }
}

/// What there is in the network.
///
/// # Arguments
///
/// * `simulator` — whether the simulator was heard just now.
pub fn graph(session: &Session, simulator: Heard) -> Graph {
    let publishers = session
        .endpoints()
        .into_iter()
        .filter(|endpoint| endpoint.kind == EndpointKind::Writer)
        .map(|endpoint| Publisher { topic: endpoint.topic, type_name: endpoint.type_name })
        .collect();
    Graph { publishers, simulator: simulator == Heard::Recently }
}

/// Whether somebody was heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard {
    /// Within the time in which a node counts as alive.
    Recently,
    /// Never, or too long ago.
    Not,
}
