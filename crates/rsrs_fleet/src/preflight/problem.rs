//! The reasons not to start a run, in words.

use std::collections::BTreeSet;

use rsrs_core::numerals::counted;
use rsrs_core::world::WorldFile;
use rsrs_msgs::topics;

use super::{ClockLead, DiagnosticError, UnfitTopic, commands_as, start_controller};
use crate::epoch::ImplausibleEpoch;
use crate::fleet_file::CmdVel;
use crate::message::OTHER_RUNNER;
use crate::parameters::Deviation;
use crate::placement;
use crate::timing::LEASE_DURATION;

fn by(nodes: &[String]) -> String {
    if nodes.is_empty() { String::new() } else { format!(" by {}", nodes.join(", ")) }
}

/// What to type where commands are of another type.
fn of_commands(topic: &str, found: &str) -> String {
    let is_of_commands = topic.ends_with("/cmd_vel");
    is_of_commands.then(|| commands_as(found)).flatten().unwrap_or_default()
}

/// What to type where commands are published as another type, by what the robot's base takes.
fn of_publisher(topic: &str, found: &str, (expected, taken): (&str, &BTreeSet<String>)) -> String {
    let words = CmdVel::of_type(found).zip(CmdVel::of_type(expected));
    match words.filter(|_| topic.ends_with("/cmd_vel")) {
        Some((_, wanted)) if taken.contains(expected) => {
            format!(": {}", start_controller(wanted))
        }
        Some((sent, _)) if taken.contains(found) => {
            format!(": set `cmd_vel: {}` in the fleet file", sent.key())
        }
        _ => of_commands(topic, found),
    }
}

/// Whether a topic has another name, or what else to do about it.
fn of_missing(topic: &str, nearest: Option<&str>) -> String {
    match nearest {
        Some(nearest) => format!("; did you mean {nearest}?"),
        None if topics::object_of(topic).is_some() => {
            " (an object of the run's world: have it tracked, or take it out of the world's file)"
                .to_owned()
        }
        None => String::new(),
    }
}

/// The objects of a world: `9 objects, object_1 to object_9`.
fn objects_in_words(n_objects: usize) -> String {
    let count = counted(n_objects as u64, "object");
    let names = |first: usize, last: usize| {
        let [first, last] = [first, last].map(WorldFile::object_name);
        if first == last { first } else { format!("{first} to {last}") }
    };
    n_objects.checked_sub(1).map_or(count.clone(), |last| format!("{count}, {}", names(0, last)))
}

/// One reason not to start.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Problem {
    /// No status of a robot.
    #[error("{robot}: no status received")]
    RobotMissing {
        /// The robot.
        robot: String,
    },
    /// No controller holds the lease of a robot without a gate.
    #[error(
        "{robot}: nobody holds its lease, expected its controller to (start it with \
         `-p lease:=controller`)"
    )]
    LeaseNotHeld {
        /// The robot.
        robot: String,
    },
    /// No status of a controller.
    #[error("{robot}: no status of its controller received")]
    ControllerMissing {
        /// The robot.
        robot: String,
    },
    /// No simulator.
    #[error("no simulator discovered")]
    SimulatorMissing,
    /// A topic has another type than expected; the middleware would never match it.
    #[error(
        "{topic}: type is {found}{}, expected {expected}{}",
        by(nodes),
        of_publisher(topic, found, (expected, taken))
    )]
    WrongType {
        /// The topic.
        topic: String,
        /// Who publishes it so.
        nodes: Vec<String>,
        /// The type found.
        found: String,
        /// The type expected.
        expected: String,
        /// The types that those wait for who drive the robot.
        taken: BTreeSet<String>,
    },
    /// A node of a robot waits for another type; it receives nothing.
    #[error(
        "{topic}: {node} waits for {found}, and {expected} is sent{}",
        of_commands(topic, found)
    )]
    WrongSubscriber {
        /// The topic.
        topic: String,
        /// The node.
        node: String,
        /// The type that it expects.
        found: String,
        /// The type of the topic.
        expected: String,
    },
    /// The ends of a topic that robots are steered by do not fit each other.
    #[error("{0}")]
    Unfit(UnfitTopic),
    /// A topic that was asked for cannot be recorded.
    #[error("{topic}: {reason}")]
    Unrecordable {
        /// The topic.
        topic: String,
        /// Why not.
        reason: String,
    },
    /// A topic that must have one publisher has none.
    #[error("{topic}: no publisher{}", of_missing(topic, nearest.as_deref()))]
    NoPublisher {
        /// The topic.
        topic: String,
        /// One of its type that is there, with nearly its name.
        nearest: Option<String>,
    },
    /// Objects are tracked that the world of the run does not have.
    #[error(
        "{}: the run's world has {} (add what is tracked to the world's file, give it the name of an object, or take \
         it off the floor)",
        topics.join(", "),
        objects_in_words(*n_objects)
    )]
    StrangeObjects {
        /// On which topics.
        topics: Vec<String>,
        /// Objects of the world.
        n_objects: usize,
    },
    /// A topic that must have one publisher has none, and a node of its robot has another one in its place.
    #[error(
        "{topic}: no publisher, and {node} has {renamed} in its place (`-r` there: a run needs the names of \
         the robot's own topics; rename those of the other program)"
    )]
    Renamed {
        /// The topic.
        topic: String,
        /// The node.
        node: String,
        /// The topic that it has instead.
        renamed: String,
    },
    /// Nobody receives what a robot is commanded.
    #[error(
        "{topic}: nobody receives it, so the robot would stand (start its base; `ros2 topic info -v \
         {topic}` shows who subscribes)"
    )]
    NobodyObeys {
        /// The topic.
        topic: String,
    },
    /// A topic of one robot has several publishers.
    #[error("{topic}: {found} publishers, expected 1 (two of one name?)")]
    SeveralPublishers {
        /// The topic.
        topic: String,
        /// Publishers found, of the right type.
        found: usize,
    },
    /// Another runner is at work.
    #[error("{OTHER_RUNNER}, run {run_id}")]
    OtherRunner {
        /// Its run.
        run_id: String,
    },
    /// A robot's hardware has failed.
    #[error("{robot}: {reason}")]
    Faulted {
        /// The robot.
        robot: String,
        /// The value reported.
        reason: String,
    },
    /// Its battery is low.
    #[error("{robot}: battery at {found_v:.2} V, expected at least {expected_v:.2} V")]
    BatteryLow {
        /// The robot.
        robot: String,
        /// Its voltage, in volts.
        found_v: f64,
        /// The limit in the fleet file, in volts.
        expected_v: f64,
    },
    /// Its battery should be checked, and it does not report its voltage.
    #[error("{robot}: battery unknown, expected at least {expected_v:.2} V")]
    BatteryUnknown {
        /// The robot.
        robot: String,
        /// The limit in the fleet file, in volts.
        expected_v: f64,
    },
    /// Its wall clock is not ours and does not go as ours does; recorded times could not be aligned.
    #[error("{robot}: clock {lead} ours, and {} (let chrony set it)", lead.unsteady())]
    Clock {
        /// The robot.
        robot: String,
        /// How far its clock is ahead.
        lead: ClockLead,
    },
    /// The runner's machine does not keep up with the messages; that it receives no robot in time
    /// is not the robots' fault.
    #[error(
        "this machine is too slow: what it receives waits {behind_s:.1} s until it is looked at, \
         expected at most {} s",
        LEASE_DURATION.as_secs_f64()
    )]
    TooSlow {
        /// The longest wait of the last second, in seconds.
        behind_s: f64,
    },
    /// Its gate is not set as the fleet file and the profile determine it.
    #[error(
        "{robot}: {deviation} by the fleet file and its profile (an old file on the robot, or `-p` there? \
         start its node with the files of this machine)"
    )]
    Setting {
        /// The robot.
        robot: String,
        /// Which parameter, and what it should be.
        deviation: Deviation,
    },
    /// Its diagnostics report an error.
    #[error("{}: diagnostics: {}: {}", .0.robot, .0.part, .0.message)]
    Diagnostic(DiagnosticError),
    /// The e-stop holds robots, though no source may publish it any more.
    #[error("the e-stop holds {} (`rsrs stop --release` lets them go)", robots.join(", "))]
    Locked {
        /// The robots.
        robots: Vec<String>,
    },
    /// The e-stop is engaged.
    #[error("the e-stop is engaged{}{}", if by.is_empty() { "" } else { " by " }, by.join(", "))]
    EStop {
        /// Nodes that have engaged it, those that announce their name.
        by: Vec<String>,
    },
    /// A simulator has the robot, and nothing for it to sense and to move in.
    #[error(
        "{robot}: its simulator has placed no world (let this run set its conditions: \
         `driver: {{kind: virtual}}` in the fleet file)"
    )]
    WithoutWorld {
        /// The robot.
        robot: String,
    },
    /// It obeys an epoch that no runner made, and will obey no other.
    #[error("{robot}: {refused}; start its node again")]
    Epoch {
        /// The robot.
        robot: String,
        /// The epoch.
        refused: ImplausibleEpoch,
    },
    /// The publisher of its poses has another clock, which does not go as ours does; commands and poses
    /// could not be aligned.
    #[error(
        "{robot}: its poses are stamped {lead} our clock, and {} (set the clock of whoever publishes \
         them, or stamp with it)",
        lead.unsteady()
    )]
    PoseClock {
        /// The robot.
        robot: String,
        /// How far the stamps are ahead.
        lead: ClockLead,
    },
    /// The last pose of a robot cannot be used.
    #[error("{robot}: its pose cannot be used: {reason}")]
    PoseUnusable {
        /// The robot.
        robot: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A robot does not stand where it should start, and is required to.
    #[error("{0}")]
    Misplaced(placement::Deviation),
    /// A robot is required to stand where it should start, and its pose was not received.
    #[error("{robot}: no pose received, so it is unknown whether it stands where it should start")]
    PlaceUnknown {
        /// The robot.
        robot: String,
    },
    /// Robots are required to stand where they should start, and their poses cannot be compared.
    #[error(
        "start poses are in different frames, {frames}, and cannot be held against their places"
    )]
    PlacesInFrames {
        /// The frames.
        frames: String,
    },
    /// Robots that cannot all be at their poses.
    #[error(
        "{} are on one spot: centres less than {radius_m:.3} m apart, which is their radius (odometry \
         that starts at 0, 0 on each robot is no pose on the floor: publish poses in one frame, with z up)",
        robots.join(", ")
    )]
    OneSpot {
        /// Their names.
        robots: Vec<String>,
        /// Radius of their bodies, in metres.
        radius_m: f64,
    },
    /// A robot is not where the fleet file keeps its robots.
    #[error("{robot}: at ({x_m:.2}, {y_m:.2}) m, outside of the fleet file's `geofence`")]
    Outside {
        /// The robot.
        robot: String,
        /// Where it is, in metres.
        x_m: f64,
        /// Where it is, in metres.
        y_m: f64,
    },
    /// The geofence is in the frame of the poses, and there are several.
    #[error(
        "the fleet file's `geofence` is in the frame of the poses, and these are in {}: publish them in \
         one frame, as a tracker does, or take the geofence out",
        frames.iter().map(|frame| format!("`{frame}`")).collect::<Vec<_>>().join(", ")
    )]
    FenceFrames {
        /// The frames.
        frames: Vec<String>,
    },
    /// Poses in frames between which there is no transform.
    #[error(
        "poses are in different frames that no transform on /tf or /tf_static ties together: {} \
         (publish them in one frame)",
        frames.iter().map(|(robot, frame)| format!("{robot} in `{frame}`")).collect::<Vec<_>>().join(", ")
    )]
    Frames {
        /// One robot of each frame, and the frame.
        frames: Vec<(String, String)>,
    },
}
