//! What must be there for a run, and what is there.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use rsrs_bags::trajectory::PoseReader;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::world::WorldFile;
use rsrs_fleet::experiment::Time;
use rsrs_fleet::fleet_file::FleetRobot;
use rsrs_fleet::placement::{PlaceCheck, WantedStart};
use rsrs_fleet::preflight::{self, Apart, Expected, ExpectedTopic, Graph, Publishers};
use rsrs_fleet::record::Backend;
use rsrs_fleet::runner::{MotionCheck, RunLength, RunnerOptions, SampleKind};
use rsrs_fleet::simulator::placement_digest;
use rsrs_fleet::timing::COUNTDOWN;
use rsrs_msgs::topics;
use rsrs_ros::session::{Endpoint, EndpointKind, Session};

use crate::endpoint_compatibility::{Compatibility, compatibility};
use crate::plan::{Plan, Poses};
use crate::recorded_topics::{RecordedTopic, Role};
use crate::tracked;

/// What the machine needs of a run.
pub fn runner_options(plan: &Plan, recorded_topics: &[RecordedTopic]) -> RunnerOptions {
    let record = &plan.record;
    let length = match record.time {
        Time::Lockstep => RunLength::Lockstep { steps: plan.steps() },
        Time::RealTime => {
            RunLength::RealTime { duration: Duration::from_secs_f64(record.duration_s) }
        }
    };
    RunnerOptions {
        run_id: record.run_id.clone(),
        expected: expected(plan, recorded_topics),
        controller: record.conditions.controller.clone(),
        reaction: plan.reaction(),
        simulator_digest: placement_digest(
            &record.conditions,
            record.seed,
            record.replicate,
            plan.steps(),
        ),
        length,
        robot_lost: record.robot_lost,
        judged: record.conditions.behaviour.window(),
        countdown: countdown(plan),
        place_check: plan.place_check,
        samples: samples(plan),
        motion: motion(plan),
        start: (record.backend != Backend::Simulator && plan.place_check != PlaceCheck::Off)
            .then(|| WantedStart::new(&record.conditions, record.replicate)),
    }
}

/// How long before robots move. Somebody stands beside real ones, and has set them down by hand; robots
/// that are to stand need no warning.
fn countdown(plan: &Plan) -> Duration {
    let stands = plan.record.conditions.controller.fastest() == Command::STOP;
    match plan.record.backend {
        Backend::Fleet | Backend::Mixed if !stands => COUNTDOWN,
        Backend::Fleet | Backend::Mixed | Backend::Simulator => Duration::ZERO,
    }
}

/// What poses are held against while robots move; the simulator moves its own as they are commanded.
fn motion(plan: &Plan) -> Option<MotionCheck> {
    let conditions = &plan.record.conditions;
    (plan.record.backend != Backend::Simulator).then(|| MotionCheck {
        period_s: conditions.period_s,
        bodies: conditions.bodies(),
        walls_m: conditions.arena.walls_m(),
    })
}

/// What must keep coming from every robot.
fn samples(plan: &Plan) -> BTreeSet<SampleKind> {
    if plan.record.time == Time::Lockstep {
        return BTreeSet::new();
    }
    let needs_poses = plan.poses == Poses::Required && plan.record.backend != Backend::Simulator;
    let poses = needs_poses.then_some(SampleKind::Pose);
    let readings = plan.record.conditions.robot.reading_names();
    let further = readings.further().map(|name| SampleKind::FurtherDetection(name.to_owned()));
    poses.into_iter().chain([SampleKind::Detection]).chain(further).collect()
}

fn expected(plan: &Plan, recorded_topics: &[RecordedTopic]) -> Expected {
    let reader = tracked::reader(plan);
    let topics = recorded_topics.iter().map(|recorded_topic| ExpectedTopic {
        name: recorded_topic.name.clone(),
        type_name: recorded_topic.type_name.clone(),
        publishers: if recorded_topic.name.ends_with(topics::VIRTUAL_DETECTION.name) {
            Publishers::AtMostOne
        } else {
            publishers(plan, &reader, recorded_topic)
        },
    });
    let limits = plan.robots.iter().filter_map(|robot| {
        let limit_v = robot.battery_min_v.filter(|_| !plan.is_virtual(robot))?;
        Some((robot.name.clone(), limit_v))
    });
    Expected {
        robots: plan.record.robots.clone(),
        simulator: plan.record.backend != Backend::Fleet,
        topics: topics.collect(),
        steering: steering(plan),
        obeyed: obeyed(plan),
        battery_min_v: limits.collect(),
        controller_only: plan.record.controller_only.iter().cloned().collect(),
        gates: plan.gates.clone(),
        geofence: plan.geofence,
        apart: apart(plan),
        objects: objects(plan),
    }
}

/// The objects of the world, where a tracker sees them.
pub fn objects(plan: &Plan) -> Option<BTreeSet<String>> {
    let n_objects = plan.record.conditions.world.n_objects();
    (plan.record.backend == Backend::Fleet)
        .then(|| (0..n_objects).map(WorldFile::object_name).collect())
}

/// What steers a robot behind its gate, or in place of its sensor.
fn steering(plan: &Plan) -> BTreeSet<String> {
    let topics = [topics::HARDWARE_CMD_VEL, topics::VIRTUAL_DETECTION];
    let robots = plan.record.robots.iter();
    robots.flat_map(|robot| topics.map(|topic| topic.for_robot(robot))).collect()
}

/// By which topics real robots are driven: behind a gate, a base may take what the gate lets through.
fn obeyed(plan: &Plan) -> BTreeSet<String> {
    let topics = [topics::CMD_VEL, topics::HARDWARE_CMD_VEL];
    let is_real =
        |robot: &&FleetRobot| plan.record.backend != Backend::Simulator && !plan.is_virtual(robot);
    let real = plan.robots.iter().filter(is_real);
    real.flat_map(|robot| topics.map(|topic| topic.for_robot(&robot.name))).collect()
}

/// Robots whose poses are published, and were not made by the simulator.
pub fn apart(plan: &Plan) -> Option<Apart> {
    if plan.poses != Poses::Required || plan.record.backend == Backend::Simulator {
        return None;
    }
    let real = plan.robots.iter().filter(|robot| !plan.is_virtual(robot));
    Some(Apart {
        robots: real.map(|robot| robot.name.clone()).collect(),
        radius_m: plan.record.conditions.smallest_radius_m(),
    })
}

/// How many may publish a topic with poses.
pub fn publishers_of_poses(plan: &Plan, topic: &RecordedTopic) -> Publishers {
    publishers(plan, &tracked::reader(plan), topic)
}

/// All publishers that are known here.
pub fn publishers_there(session: &Session) -> Vec<preflight::Endpoint> {
    let endpoints = session.endpoints().into_iter();
    endpoints.filter(|endpoint| endpoint.kind == EndpointKind::Writer).map(end).collect()
}

fn publishers(plan: &Plan, reader: &PoseReader, recorded_topic: &RecordedTopic) -> Publishers {
    let is_virtual = |robot: usize| plan.is_virtual(&plan.robots[robot]);
    match recorded_topic.role {
        Role::Detection(_) | Role::Command(_) => Publishers::One,
        Role::Odometry(_) | Role::Pose(_) if plan.poses == Poses::IfThere => Publishers::AtMostOne,
        Role::Odometry(robot) if is_virtual(robot) => Publishers::One,
        Role::Pose(robot) if is_virtual(robot) => Publishers::Any,
        Role::Odometry(_) | Role::Pose(_) | Role::Tracker | Role::Transforms => {
            let place = reader.index_of(&recorded_topic.name, &recorded_topic.type_name);
            if place.is_some() { trackers(plan) } else { Publishers::Any }
        }
        Role::FurtherDetection(robot)
            if plan.record.backend == Backend::Fleet && !is_virtual(robot) =>
        {
            Publishers::One
        }
        Role::Object if plan.record.backend == Backend::Fleet => Publishers::One,
        // The simulator publishes further detections, and where objects are, once it has placed the world.
        Role::FurtherDetection(_) | Role::Object | Role::Robot(_) | Role::Controller(_) => {
            Publishers::AtMostOne
        }
        _ => Publishers::Any,
    }
}

/// How many machines of a tracker may publish a topic. Where there are several topics, not each machine
/// has to be there, as long as all robots are seen.
fn trackers(plan: &Plan) -> Publishers {
    let has_several = plan.record.tracker.as_ref().is_some_and(|it| it.topics.len() > 1);
    let is_needed =
        plan.poses == Poses::Required && plan.record.backend != Backend::Simulator && !has_several;
    match (plan.tracked_by(), is_needed) {
        // Each message tells whose poses it has.
        (PoseSource::NamedPoses | PoseSource::Tf, true) => Publishers::AtLeastOne,
        (PoseSource::NamedPoses | PoseSource::Tf, false) => Publishers::Any,
        (PoseSource::Odom | PoseSource::Pose | PoseSource::PoseArray, true) => Publishers::One,
        (PoseSource::Odom | PoseSource::Pose | PoseSource::PoseArray, false) => {
            Publishers::AtMostOne
        }
    }
}

/// What there is in the network, but for the simulator. Topics that were asked for and cannot be recorded are
/// `unrecordable`, each with the reason.
pub fn graph(session: &Session, plan: &Plan, unrecordable: BTreeMap<String, String>) -> Graph {
    let endpoints = session.endpoints();
    let Compatibility { unfit, onlookers } = compatibility(&endpoints, &plan.record.robots);
    let (writers, readers): (Vec<_>, Vec<_>) =
        endpoints.into_iter().partition(|endpoint| endpoint.kind == EndpointKind::Writer);
    Graph {
        unfit,
        onlookers,
        publishers: writers.into_iter().map(end).collect(),
        subscribers: readers.into_iter().map(end).collect(),
        simulator: false,
        unrecordable,
    }
}

fn end(endpoint: Endpoint) -> preflight::Endpoint {
    let Endpoint { topic, type_name, node, guid, .. } = endpoint;
    preflight::Endpoint { topic, type_name, node, guid }
}
