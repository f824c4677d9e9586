//! What must be there before anything is set or moved; every problem is named at once.

use std::collections::{BTreeMap, BTreeSet};

use rsrs_core::document;
use rsrs_core::robot::unicycle::Pose;
use rsrs_msgs::{node_names, topics};

use crate::e_stop::{Locks, Source};
use crate::epoch;
use crate::fleet_file::CmdVel;
use crate::geofence::Geofence;
use crate::message::{RobotState, Status};
use crate::parameters::{GateSettings, controller, gate};
use crate::timing::LEASE_DURATION;

mod clocks;
mod objects;
mod places;
mod problem;

pub use clocks::ClockLead;
pub(crate) use clocks::notes as clock_notes;
pub(crate) use objects::note as object_note;
pub(crate) use places::unusable_poses;
pub use problem::Problem;

/// What an experiment needs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Expected {
    /// The robots.
    pub robots: Vec<String>,
    /// Whether a simulator must be there.
    pub simulator: bool,
    /// The topics it reads and writes.
    pub topics: Vec<ExpectedTopic>,
    /// Further topics by which robots are steered, and which may have one publisher each.
    pub steering: BTreeSet<String>,
    /// Topics on which commands reach what drives a robot: if they are published, somebody receives them.
    pub obeyed: BTreeSet<String>,
    /// Battery voltage below which a robot starts no run, in volts; robots without a limit are left
    /// out.
    pub battery_min_v: BTreeMap<String, f64>,
    /// Robots that must stand apart before they move; `None` where poses are not published, or the
    /// simulator has placed all of them.
    pub apart: Option<Apart>,
    /// What the gate of each robot must be set to, as the fleet file and the profile determine it; robots
    /// whose gates are not read are left out.
    pub gates: BTreeMap<String, GateSettings>,
    /// Robots without a gate of ours: their controllers hold their leases, and publish in their
    /// stead.
    pub controller_only: BTreeSet<String>,
    /// What no robot must leave; `None` if there is nothing, or poses are not looked at.
    pub geofence: Option<Geofence>,
    /// The objects of the world, by name; `None` where no tracker sees them.
    pub objects: Option<BTreeSet<String>>,
}

/// Robots with bodies, on one floor.
#[derive(Clone, Debug, PartialEq)]
pub struct Apart {
    /// Their names.
    pub robots: BTreeSet<String>,
    /// Radius of each body, in metres.
    pub radius_m: f64,
}

impl Expected {
    /// Who holds the lease of each robot, in words for the operator.
    pub fn leases(&self) -> Vec<String> {
        let (alone, gated): (Vec<&String>, Vec<_>) =
            self.robots.iter().partition(|robot| self.controller_only.contains(*robot));
        let gated = match (gated.len(), alone.len()) {
            (0, _) => None,
            (all, 0) => Some(format!("lease: gate on all {all} robots")),
            _ => {
                let names: Vec<&str> = gated.into_iter().map(String::as_str).collect();
                Some(format!("lease: gate on {}", names.join(", ")))
            }
        };
        let alone = alone.into_iter().map(|robot| {
            format!(
                "{robot}: lease: controller only; its base must stop by itself when commands stay away"
            )
        });
        gated.into_iter().chain(alone).collect()
    }
}

/// A topic that an experiment needs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExpectedTopic {
    /// Full name: `/robot_1/detection`.
    pub name: String,
    /// Type: `std_msgs/msg/Bool`.
    pub type_name: String,
    /// How many may publish it.
    pub publishers: Publishers,
}

/// How many publishers a topic must have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Publishers {
    /// Exactly one.
    One,
    /// At least one: each names whose samples it publishes.
    AtLeastOne,
    /// One at most; whether there is one shows in its samples.
    AtMostOne,
    /// Any number, none included.
    Any,
}

/// The part of the discovery database that preflight looks at.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Graph {
    /// All publishers of all topics.
    pub publishers: Vec<Endpoint>,
    /// All subscribers of all topics.
    pub subscribers: Vec<Endpoint>,
    /// Whether the simulator's node is there.
    pub simulator: bool,
    /// Topics that were asked for and cannot be recorded, and why.
    pub unrecordable: BTreeMap<String, String>,
    /// Topics that robots are steered by and whose ends do not fit each other.
    pub unfit: BTreeSet<UnfitTopic>,
    /// Topics on which a subscriber receives nothing that the run does not need.
    pub onlookers: BTreeSet<UnfitTopic>,
}

/// A topic whose ends do not fit each other.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, thiserror::Error)]
#[error("{topic}: {reason}")]
pub struct UnfitTopic {
    /// Full name of the topic.
    pub topic: String,
    /// Which ends, and what to change.
    pub reason: String,
}

/// What to type so that a robot is commanded by messages of this type, to be put behind a sentence;
/// `None` if no command is of it.
pub fn commands_as(type_name: &str) -> Option<String> {
    let commands = CmdVel::of_type(type_name)?;
    let (key, start) = (commands.key(), start_controller(commands));
    Some(format!(": set `cmd_vel: {key}` in the fleet file, and {start}"))
}

/// What to do so that a controller publishes such commands.
fn start_controller(commands: CmdVel) -> String {
    format!("start the controller with `-p {}:={}`", controller::CMD_VEL_TYPE, commands.key())
}

/// One end of a topic.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Endpoint {
    /// Full name of its topic.
    pub topic: String,
    /// Type of its topic.
    pub type_name: String,
    /// Full name of its node; `None` if it is not announced.
    pub node: Option<String>,
    /// Its GUID.
    pub guid: [u8; 16],
}

/// What is there.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seen {
    /// Discovered endpoints.
    pub graph: Graph,
    /// Last status of each robot that was received.
    pub robots: BTreeMap<String, Status>,
    /// Controllers that were received, by robot.
    pub controllers: BTreeSet<String>,
    /// Runs of other runners whose leases are received now.
    pub other_runs: BTreeSet<String>,
    /// Who has engaged the e-stop, as the runner has received it.
    pub e_stop: Locks,
    /// The highest epoch that was received.
    pub highest_epoch: u64,
    /// How far each robot's wall clock is ahead of ours, by the stamps of its statuses;
    /// robots that do not stamp are left out.
    pub clocks: BTreeMap<String, ClockLead>,
    /// How far the clock by which each robot's poses are stamped is ahead of ours.
    pub pose_clocks: BTreeMap<String, ClockLead>,
    /// Frame and last pose of each robot whose pose was received.
    pub poses: BTreeMap<String, (String, Pose)>,
    /// By robot: why its last pose cannot be used.
    pub unusable_poses: BTreeMap<String, String>,
    /// By frame: the frame that it is in, by transforms.
    pub parents: BTreeMap<String, String>,
    /// How long messages wait on this machine until they are looked at, in seconds; `None` if that
    /// is not known.
    pub behind_s: Option<f64>,
    /// What robots' diagnostics call an error now.
    pub diagnostic_errors: BTreeSet<DiagnosticError>,
}

/// A part of a robot that its diagnostics call an error.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct DiagnosticError {
    /// The robot.
    pub robot: String,
    /// The part, as its diagnostics name it.
    pub part: String,
    /// The diagnosis.
    pub message: String,
}

/// Every reason not to start, in the order in which a person would look; none if the experiment
/// can.
pub fn problems(expected: &Expected, seen: &Seen) -> Vec<Problem> {
    let mut problems = Vec::new();
    problems.extend(e_stop(seen));
    let is_locked = |robot: &&String| seen.robots.get(*robot).is_some_and(Status::holds_e_stop);
    let robots: Vec<_> = expected.robots.iter().filter(is_locked).cloned().collect();
    if !robots.is_empty() {
        problems.push(Problem::Locked { robots });
    }
    problems.extend(seen.other_runs.iter().map(|run| Problem::OtherRunner { run_id: run.clone() }));
    let too_slow = too_slow(seen.behind_s);
    let reception = if too_slow.is_some() { Reception::Behind } else { Reception::InTime };
    problems.extend(too_slow);
    if reception == Reception::InTime && expected.simulator && !seen.graph.simulator {
        problems.push(Problem::SimulatorMissing);
    }
    for robot in &expected.robots {
        problems.extend(of_robot(robot, expected, seen, reception));
    }
    problems.extend(expected.apart.iter().flat_map(|apart| places::problems(apart, seen)));
    problems.extend(outside(expected.geofence, &expected.robots, &seen.poses));
    let (publishers, subscribers) =
        (by_topic(&seen.graph.publishers), by_topic(&seen.graph.subscribers));
    for topic in &expected.topics {
        let name = topic.name.as_str();
        let [publishers, subscribers] =
            [&publishers, &subscribers].map(|ends| ends.get(name).map_or(&[][..], Vec::as_slice));
        problems.extend(of_topic(topic, publishers, subscribers, (expected, &seen.graph)));
    }
    problems.extend(objects::strange(expected, &seen.graph));
    for topic in &expected.obeyed {
        let [publishers, subscribers] = [&publishers, &subscribers]
            .map(|ends| ends.get(topic.as_str()).map_or(&[][..], Vec::as_slice));
        let is_obeyed = subscribers.iter().any(|end| !is_onlooker(end));
        if !publishers.is_empty() && !is_obeyed {
            problems.push(Problem::NobodyObeys { topic: topic.clone() });
        }
    }
    problems.extend(seen.graph.unfit.iter().cloned().map(Problem::Unfit));
    let unrecordable = seen.graph.unrecordable.iter();
    problems.extend(unrecordable.map(|(topic, reason)| Problem::Unrecordable {
        topic: topic.clone(),
        reason: reason.clone(),
    }));
    problems
}

/// The e-stop as it is engaged, by the nodes that are there.
fn e_stop(seen: &Seen) -> Option<Problem> {
    let node = |source: &Source| {
        let ends = seen.graph.publishers.iter();
        ends.filter(|end| end.guid == source.0).find_map(|end| end.node.clone())
    };
    let by: BTreeSet<String> = seen.e_stop.0.keys().filter_map(node).collect();
    (!seen.e_stop.0.is_empty()).then(|| Problem::EStop { by: by.into_iter().collect() })
}

/// Whether silence and old stamps are evidence about the robots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reception {
    /// They do.
    InTime,
    /// They are not: what was reported waits here.
    Behind,
}

/// Messages later than this keep no lease alive.
pub(crate) fn too_slow(behind_s: Option<f64>) -> Option<Problem> {
    let behind_s = behind_s.filter(|behind_s| *behind_s > LEASE_DURATION.as_secs_f64())?;
    Some(Problem::TooSlow { behind_s })
}

fn of_robot(robot: &str, expected: &Expected, seen: &Seen, reception: Reception) -> Vec<Problem> {
    let named = || robot.to_owned();
    let in_time = reception == Reception::InTime;
    let mut problems = Vec::new();
    match seen.robots.get(robot) {
        None if in_time && expected.controller_only.contains(robot) => {
            problems.push(Problem::LeaseNotHeld { robot: named() });
        }
        None if in_time => problems.push(Problem::RobotMissing { robot: named() }),
        None => {}
        Some(status) => {
            problems.extend(of_status(robot, status, expected.battery_min_v.get(robot)));
            // A runner with a simulator sets the conditions itself.
            if status.is_without_world() && !expected.simulator {
                problems.push(Problem::WithoutWorld { robot: named() });
            }
            if let Err(refused) = epoch::check(status.epoch, seen.highest_epoch) {
                problems.push(Problem::Epoch { robot: named(), refused });
            }
        }
    }
    if in_time && !seen.controllers.contains(robot) {
        problems.push(Problem::ControllerMissing { robot: named() });
    }
    if in_time {
        let unusable = |lead: &&ClockLead| lead.is_apart() && !lead.is_steady();
        let clock = seen.clocks.get(robot).filter(unusable);
        problems.extend(clock.map(|lead| Problem::Clock { robot: named(), lead: *lead }));
        let clock = seen.pose_clocks.get(robot).filter(unusable);
        problems.extend(clock.map(|lead| Problem::PoseClock { robot: named(), lead: *lead }));
    }
    problems.extend(diagnosed(robot, seen));
    problems
}

/// Robots that are not where the geofence keeps them. It is in the frame of the poses, so that they
/// must have one.
pub fn outside(
    geofence: Option<Geofence>,
    robots: &[String],
    poses: &BTreeMap<String, (String, Pose)>,
) -> Vec<Problem> {
    let Some(geofence) = geofence else { return Vec::new() };
    let known = || robots.iter().filter_map(|robot| Some((robot, poses.get(robot)?)));
    let frames: BTreeSet<&String> = known().map(|(_, (frame, _))| frame).collect();
    if frames.len() > 1 {
        let frames = frames.into_iter().cloned().collect();
        return vec![Problem::FenceFrames { frames }];
    }
    let outside = known().filter(|(_, (_, pose))| !geofence.contains(*pose));
    let problem = |(robot, (_, pose)): (&String, &(String, Pose))| Problem::Outside {
        robot: robot.clone(),
        x_m: pose.x_m,
        y_m: pose.y_m,
    };
    outside.map(problem).collect()
}

/// What their batteries and diagnostics tell of the robots, before they move.
pub(crate) fn health(expected: &Expected, seen: &Seen) -> Vec<Problem> {
    let of_robot = |robot: &String| {
        let status = seen.robots.get(robot);
        let battery =
            status.and_then(|status| battery(robot, status, expected.battery_min_v.get(robot)));
        battery.into_iter().chain(diagnosed(robot, seen)).collect::<Vec<_>>()
    };
    expected.robots.iter().flat_map(of_robot).collect()
}

fn diagnosed(robot: &str, seen: &Seen) -> impl Iterator<Item = Problem> {
    let errors = seen.diagnostic_errors.iter().filter(move |error| error.robot == robot);
    errors.cloned().map(Problem::Diagnostic)
}

fn of_status(robot: &str, status: &Status, battery_min_v: Option<&f64>) -> Option<Problem> {
    let named = || robot.to_owned();
    if status.state == RobotState::Fault {
        return Some(Problem::Faulted { robot: named(), reason: status.stop_reason.clone() });
    }
    battery(robot, status, battery_min_v)
}

/// What is wrong with a robot's battery, if it has a limit.
pub(crate) fn battery(
    robot: &str,
    status: &Status,
    battery_min_v: Option<&f64>,
) -> Option<Problem> {
    let named = || robot.to_owned();
    let (expected_v, found_v) = (*battery_min_v?, f64::from(status.battery_v));
    if found_v.is_nan() {
        return Some(Problem::BatteryUnknown { robot: named(), expected_v });
    }
    (found_v < expected_v).then(|| Problem::BatteryLow { robot: named(), found_v, expected_v })
}

/// Programs that look at what robots are commanded and drive none: command-line tools have hidden names.
const ONLOOKERS: [&str; 9] = [
    node_names::RUNNER,
    "foxglove_bridge",
    "lichtblick_bridge",
    "plotjuggler",
    "rosbag2_recorder",
    "rosbridge_websocket",
    node_names::STOP,
    node_names::WATCH,
    "rviz2",
];

fn is_onlooker(end: &Endpoint) -> bool {
    // Who does not state its name may be a base.
    let name = end.node.as_deref().and_then(|node| node.rsplit('/').next());
    name.is_some_and(|name| name.starts_with('_') || ONLOOKERS.contains(&name))
}

/// The ends of each topic.
type ByTopic<'a> = BTreeMap<&'a str, Vec<&'a Endpoint>>;

fn by_topic(ends: &[Endpoint]) -> ByTopic<'_> {
    let mut topics = ByTopic::new();
    for end in ends {
        topics.entry(&end.topic).or_default().push(end);
    }
    topics
}

fn of_topic(
    topic: &ExpectedTopic,
    publishers: &[&Endpoint],
    subscribers: &[&Endpoint],
    (expected, graph): (&Expected, &Graph),
) -> Vec<Problem> {
    let (right, wrong): (Vec<&Endpoint>, Vec<_>) =
        publishers.iter().copied().partition(|end| end.type_name == topic.type_name);
    let named = || topic.name.clone();
    let mut problems: Vec<_> = types(&wrong)
        .map(|found| Problem::WrongType {
            topic: named(),
            nodes: nodes_of(&wrong, &found),
            found,
            expected: topic.type_name.clone(),
            taken: taken(subscribers),
        })
        .collect();
    let explained = right.is_empty() && !wrong.is_empty();
    match (topic.publishers, right.len()) {
        (Publishers::One | Publishers::AtLeastOne, 0) if !explained => {
            problems.push(match renamed(topic, graph) {
                Some((node, renamed)) => Problem::Renamed { topic: named(), node, renamed },
                None => Problem::NoPublisher {
                    topic: named(),
                    nearest: nearest_topic(topic, expected, graph),
                },
            });
        }
        (Publishers::One | Publishers::AtMostOne, found @ 2..) => {
            problems.push(Problem::SeveralPublishers { topic: named(), found });
        }
        _ => {}
    }
    if topic.publishers == Publishers::One {
        problems.extend(mismatched_subscribers(topic, subscribers));
    }
    problems
}

/// The node of the topic's robot that should have it, and has a topic of another name and the same type:
/// one of `-r`.
fn renamed(topic: &ExpectedTopic, graph: &Graph) -> Option<(String, String)> {
    // A node has as many readings as its robot has sensors, all of one type.
    let is_further = |name: &str| topics::further_reading(name).is_some();
    if is_further(&topic.name) {
        return None;
    }
    let (namespace, name) = topic.name.rsplit_once('/')?;
    let own = [gate::NODE, controller::NODE].map(|node| format!("{namespace}/{node}"));
    let of_own = |end: &&Endpoint| {
        let is_own = end.node.as_ref().is_some_and(|node| own.contains(node));
        // Topics of the swarm, and further ones of the robot, have their own names.
        let is_another = !end.topic.starts_with("/swarm/")
            && !end.topic.ends_with("/virtual_detection")
            && !is_further(&end.topic);
        is_own && is_another && end.type_name == topic.type_name && end.topic != topic.name
    };
    let is_of_commands = name == "cmd_vel";
    let is_named_so = |end: &&Endpoint| !end.topic.ends_with("/hardware/cmd_vel");
    let published = graph.publishers.iter().filter(of_own).find(is_named_so);
    // What a controller subscribes in place of detections.
    let mut subscribed = graph.subscribers.iter().filter(of_own);
    let found = published.or_else(|| subscribed.find(|_| !is_of_commands))?;
    Some((found.node.clone()?, found.topic.clone()))
}

/// Nodes of the topic's robot that wait for another type, and for that alone.
fn mismatched_subscribers(topic: &ExpectedTopic, subscribers: &[&Endpoint]) -> Vec<Problem> {
    let mut types_of: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    let robot = topic.name.rsplit_once('/').map_or("", |(namespace, _)| namespace);
    for end in subscribers {
        let node = end.node.as_deref().unwrap_or("");
        if node.strip_prefix(robot).is_some_and(|name| name.starts_with('/')) {
            types_of.entry(node).or_default().insert(&end.type_name);
        }
    }
    types_of.retain(|_, types| !types.contains(topic.type_name.as_str()));
    types_of
        .into_iter()
        .map(|(node, types)| Problem::WrongSubscriber {
            topic: topic.name.clone(),
            node: node.to_owned(),
            found: types.into_iter().collect::<Vec<_>>().join(", "),
            expected: topic.type_name.clone(),
        })
        .collect()
}

/// What those wait for who drive a robot by a topic.
fn taken(subscribers: &[&Endpoint]) -> BTreeSet<String> {
    let bases = subscribers.iter().filter(|end| !is_onlooker(end));
    bases.map(|end| end.type_name.clone()).collect()
}

/// The nodes that have an end of this type, those that announce their name.
fn nodes_of(ends: &[&Endpoint], type_name: &str) -> Vec<String> {
    let of_type = ends.iter().filter(|end| end.type_name == type_name);
    let nodes: BTreeSet<String> = of_type.filter_map(|end| end.node.clone()).collect();
    nodes.into_iter().collect()
}

/// Each type once.
fn types(ends: &[&Endpoint]) -> impl Iterator<Item = String> + use<> {
    let types: BTreeSet<_> = ends.iter().map(|end| end.type_name.clone()).collect();
    types.into_iter()
}

/// A topic of the same type that nobody else expects: a slip of the hand away, or the same in another namespace.
fn nearest_topic(missing: &ExpectedTopic, expected: &Expected, graph: &Graph) -> Option<String> {
    let is_expected = |name: &str| expected.topics.iter().any(|topic| topic.name == name);
    let mut others: Vec<&str> = (graph.publishers.iter())
        .filter(|end| end.type_name == missing.type_name && !is_expected(&end.topic))
        .map(|end| end.topic.as_str())
        .collect();
    others.sort_unstable();
    let is_in_another =
        |other: &&str| other.ends_with(&missing.name) || missing.name.ends_with(*other);
    let slip = others.iter().find(|other| is_slip(&missing.name, other));
    slip.or_else(|| others.iter().find(|other| is_in_another(other))).map(|name| (*name).to_owned())
}

/// Whether each part of a name is nearly that of another, with the same digits: `robot_4` is another robot than
/// `robot_3`.
fn is_slip(name: &str, other: &str) -> bool {
    let digits = |part: &str| -> String { part.chars().filter(char::is_ascii_digit).collect() };
    let [parts, others] = [name, other].map(|name| name.split('/').collect::<Vec<_>>());
    let is_near = |(part, other): (&&str, &&str)| {
        part == other
            || digits(part) == digits(other) && document::nearest(part, [*other]).is_some()
    };
    parts.len() == others.len() && parts.iter().zip(&others).all(is_near)
}

#[cfg(test)]
mod tests;
