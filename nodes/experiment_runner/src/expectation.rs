//! What must be there for a run, and what is there.

use std::collections::BTreeMap;
use std::time::Duration;

use rsrs_fleet::experiment::Time;
use rsrs_fleet::fleet_file::PoseSource;
use rsrs_fleet::placement::{CLEARANCE_RADII, StartDisc};
use rsrs_fleet::preflight::{self, Expected, ExpectedTopic, Graph, Publishers};
use rsrs_fleet::record::Backend;
use rsrs_fleet::runner::{Pace, RunnerOptions};
use rsrs_fleet::simulator::placement_digest;
use rsrs_fleet::timing::COUNTDOWN;
use rsrs_ros::session::{Endpoint, EndpointKind, Session};

use crate::ears::{Ear, Role};
use crate::plan::{PlaceCheck, Plan, Poses};

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
        reaction: plan.reaction(),
        simulator_digest: placement_digest(
            &record.conditions,
            record.seed,
            record.replicate,
            plan.steps(),
        ),
        pace,
        robot_lost: record.robot_lost,
        // Somebody stands beside real robots, and has set them down by hand.
        countdown: match record.backend {
            Backend::Fleet | Backend::Mixed => COUNTDOWN,
            Backend::Simulator => Duration::ZERO,
        },
        start: (record.backend != Backend::Simulator && plan.place_check == PlaceCheck::On)
            .then(|| start(plan)),
    }
}

fn start(plan: &Plan) -> StartDisc {
    let conditions = &plan.record.conditions;
    let radius_m = conditions.placement.radius_m();
    StartDisc { radius_m, clearance_m: CLEARANCE_RADII * conditions.robot.radius_m }
}

fn expected(plan: &Plan, ears: &[Ear]) -> Expected {
    let topics = ears.iter().map(|ear| ExpectedTopic {
        name: ear.name.clone(),
        type_name: ear.type_name.clone(),
        publishers: publishers(plan, ear.role),
    });
    let limits = plan.robots.iter().filter_map(|robot| {
        let limit_v = robot.battery_min_v.filter(|_| !plan.is_virtual(robot))?;
        Some((robot.name.clone(), limit_v))
    });
    Expected {
        robots: plan.record.robots.clone(),
        simulator: plan.record.backend != Backend::Fleet,
        topics: topics.collect(),
        battery_min_v: limits.collect(),
        controller_only: plan.record.controller_only.iter().cloned().collect(),
    }
}

fn publishers(plan: &Plan, role: Role) -> Publishers {
    match role {
        Role::Detection | Role::Command => Publishers::One,
        Role::Odometry(_) | Role::Pose(_) if plan.poses == Poses::IfThere => Publishers::AtMostOne,
        Role::Odometry(robot) if plan.pose_of(robot) == PoseSource::Odom => Publishers::One,
        Role::Pose(robot) if plan.pose_of(robot) == PoseSource::Pose => Publishers::One,
        Role::Robot(_) | Role::Controller(_) => Publishers::AtMostOne,
        _ => Publishers::Any,
    }
}

/// What there is in the network.
///
/// # Arguments
///
/// * `simulator` — whether the simulator was heard just now.
/// * `unrecordable` — topics that were asked for and cannot be recorded, and why.
pub fn graph(session: &Session, simulator: Heard, unrecordable: BTreeMap<String, String>) -> Graph {
    let (writers, readers): (Vec<_>, Vec<_>) =
        session.endpoints().into_iter().partition(|endpoint| endpoint.kind == EndpointKind::Writer);
    Graph {
        publishers: writers.into_iter().map(end).collect(),
        subscribers: readers.into_iter().map(end).collect(),
        simulator: simulator == Heard::Recently,
        unrecordable,
    }
}

fn end(endpoint: Endpoint) -> preflight::Endpoint {
    let Endpoint { topic, type_name, node, .. } = endpoint;
    preflight::Endpoint { topic, type_name, node }
}

/// Whether somebody was heard.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard {
    /// Within the time in which a node counts as alive.
    Recently,
    /// Never, or too long ago.
    Not,
}
