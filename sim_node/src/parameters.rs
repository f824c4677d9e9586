//! The parameters of the simulator: which world, from which seed, for how many steps, at what pace.

mod by_hand;

use std::collections::BTreeMap;
use std::time::Duration;

use rsrs_core::conditions::{Conditions, Impossible};
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::robot::sensor::FurtherReadings;
use rsrs_fleet::experiment::Time;
use rsrs_fleet::parameters::one_of;
use rsrs_fleet::parameters::simulator::{
    CONDITIONS, FULL_NAME, HARDWARE_ONLY, NODE, REPLICATE, ROBOTS, SEED, STEPS, TIME, TRACKED_BY,
};
use rsrs_fleet::simulator::{Gates, Placed, placement_digest};
use rsrs_ros::parameters::{
    Descriptor, NodeParameters, ParameterKind, ParameterServer, ParameterValue,
};
use rsrs_sim::controllers::Controllers;
use rsrs_sim::draw::Seed;
use rsrs_sim::placement::PlacementError;
use rsrs_sim::world::World;

use crate::rows::{Rows, RowsError};
use by_hand::{CELL, CellRefused};
pub use by_hand::{profile, take_cell};

/// Where the poses of real robots may come from, the usual one first.
const TRACKERS: [PoseSource; 2] = [PoseSource::Odom, PoseSource::Pose];

/// The end of ROS's time, whose seconds have 32 bits.
const END: Duration = Duration::from_secs(i32::MAX.unsigned_abs() as u64);

/// Why parameters do not make a world.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// There is no such parameter.
    #[error("{FULL_NAME} has no parameter `{name}`")]
    Unknown {
        /// The name.
        name: String,
    },
    /// The conditions are not those of an experiment.
    #[error("`{CONDITIONS}` is not an experiment's: {source}")]
    Unreadable {
        /// Where and why.
        source: serde_json::Error,
    },
    /// A number among the conditions cannot be.
    #[error("`{CONDITIONS}`: {source}")]
    Impossible {
        /// Which, and what it may be.
        #[from]
        source: Impossible,
    },
    /// A cell that was set by hand makes no world.
    #[error(transparent)]
    Cell(#[from] CellRefused),
    /// What the robots report has no topics.
    #[error("`{CONDITIONS}`: {0}")]
    Readings(#[from] FurtherReadings),
    /// The robots are not those of the conditions.
    #[error(transparent)]
    Rows(#[from] RowsError),
    /// Real robots do not wait.
    #[error(
        "`{TIME}` is `{}` and {name} is not one of this simulator's robots, expected `{}` for a world with \
         real robots",
        Time::Lockstep.key(), Time::RealTime.key()
    )]
    MixedLockstep {
        /// A real robot.
        name: String,
    },
    /// Robot nodes do not wait for the simulator's clock.
    #[error(
        "`{TIME}` is `{}` and `{HARDWARE_ONLY}` is true, expected `{}`",
        Time::Lockstep.key(), Time::RealTime.key()
    )]
    HardwareLockstep,
    /// Poses come from nowhere else.
    #[error("`{TRACKED_BY}` is `{found}`, expected {}", one_of(&TRACKERS.map(PoseSource::key)))]
    TrackedBy {
        /// The value.
        found: String,
    },
    /// The run ends after the end of ROS's time.
    #[error("`{STEPS}` is {steps}, expected at most {most} with a period of {period_s} s")]
    TooLong {
        /// Steps asked for.
        steps: u64,
        /// Steps that ROS's time is long enough for.
        most: u64,
        /// Length of a step, in seconds.
        period_s: f64,
    },
    /// There is no such pace.
    #[error("`{TIME}` is `{found}`, expected {}", one_of(&Time::ALL.map(Time::key)))]
    Time {
        /// The value.
        found: String,
    },
    /// The robots do not fit where they are to start.
    #[error(transparent)]
    Placement(#[from] PlacementError),
}

/// A world as the parameters ask for it.
pub struct Wanted {
    /// The world, its robots at their start poses.
    pub world: World,
    /// What decides where nobody else does.
    pub controllers: Controllers,
    /// What its pace needs.
    pub placed: Placed,
    /// What it was made of.
    pub conditions: Conditions,
    /// Whose rows it has.
    pub rows: Rows,
}

/// Declares the simulator's parameters: no world, unless the command line or a parameter file has
/// `given` one by start values. These are checked by the server of the parameters, and by
/// [`check`].
pub fn declare(mut given: BTreeMap<String, ParameterValue>) -> Result<NodeParameters, WorldError> {
    let text = |name, description| Descriptor::new(name, ParameterKind::String, description);
    let count = |name, description, most: f64| {
        let descriptor = Descriptor::new(name, ParameterKind::Integer, description);
        (descriptor.within(0.0, most), ParameterValue::Integer(0))
    };
    let time = text(TIME, "Pace: by the controllers' answers, or by the clock on the wall.");
    let robots = Descriptor::new(
        ROBOTS,
        ParameterKind::StringArray,
        "Robots of the world; others than ours are real and followed. Empty: the first of ours.",
    );
    let tracked_by =
        text(TRACKED_BY, "Topic of the real robots' poses, in the frame of the world.");
    let mut parameters = vec![
        (
            text(
                CONDITIONS,
                "Conditions of the experiment, as JSON, for programs; by hand, set `cell`. Empty is no world.",
            ),
            ParameterValue::String(String::new()),
        ),
        count(SEED, "Seed of the world, below 2^63.", i64::MAX as f64),
        count(REPLICATE, "Number of the replicate, from 0.", i64::MAX as f64),
        count(STEPS, "Steps to make in lockstep.", f64::from(u32::MAX)),
        (
            time.limited_to(&one_of(&Time::ALL.map(Time::key))),
            ParameterValue::String(Time::default().key().to_owned()),
        ),
        (robots, ParameterValue::StringArray(Vec::new())),
        (
            tracked_by.limited_to(&one_of(&TRACKERS.map(PoseSource::key))),
            ParameterValue::String(TRACKERS[0].key().to_owned()),
        ),
        (hardware_only(), ParameterValue::Bool(false)),
    ];
    parameters.extend(by_hand::declared());
    for (descriptor, value) in &mut parameters {
        if let Some(start) = given.remove(&descriptor.name) {
            *value = start;
        }
    }
    match given.into_keys().next() {
        Some(name) => Err(WorldError::Unknown { name }),
        None => Ok(NodeParameters { namespace: "/".to_owned(), name: NODE.to_owned(), parameters }),
    }
}

fn hardware_only() -> Descriptor {
    let description = "Whether the robots are nodes of their own (`rsrs node robot --driver virtual`), and \
                       this is only what their sensors and wheels are: set at the start.";
    Descriptor::new(HARDWARE_ONLY, ParameterKind::Bool, description).read_only()
}

/// Where the gates of the robots are.
pub fn gates(server: &ParameterServer) -> Gates {
    if server.get(FULL_NAME, HARDWARE_ONLY) == Some(ParameterValue::Bool(true)) {
        Gates::Elsewhere
    } else {
        Gates::Here
    }
}

/// Whether values can make a world, as far as that shows without the others, which stay as they
/// are. The simulator stands in for `hosted` robots, and robots of a cell are as the profile
/// describes.
///
/// The error is for the response to the client that sets them.
pub fn check(
    values: &[(String, ParameterValue)],
    hosted: &[String],
    profile: &RobotProfile,
) -> Result<(), WorldError> {
    let (mut conditions, mut names, mut time) = (None, &[][..], None);
    let mut steps = 0;
    for (name, value) in values {
        match (name.as_str(), value) {
            (CONDITIONS, ParameterValue::String(text)) if !text.is_empty() => {
                conditions = Some(read_conditions(text)?);
            }
            (CELL, ParameterValue::String(text)) if !text.is_empty() => {
                conditions = Some(by_hand::conditions(text, profile)?);
            }
            (TIME, ParameterValue::String(text)) => time = Some(read_time(text)?),
            (ROBOTS, ParameterValue::StringArray(values)) => names = values,
            (TRACKED_BY, ParameterValue::String(text)) => drop(read_tracker(text)?),
            (STEPS, ParameterValue::Integer(value)) => steps = value.unsigned_abs(),
            _ => {}
        }
    }
    let Some(conditions) = conditions else { return Ok(()) };
    check_length(&conditions, steps)?;
    let rows = Rows::new(names, hosted, conditions.robots)?;
    time.map_or(Ok(()), |time| check_mixed(&rows, time))
}

/// Makes the world that the parameters ask for; `None` while no conditions are set.
pub fn wanted(server: &ParameterServer, hosted: &[String]) -> Result<Option<Wanted>, WorldError> {
    let integer = |name| server.integer(FULL_NAME, name).unsigned_abs();
    let conditions = server.text(FULL_NAME, CONDITIONS);
    if conditions.is_empty() {
        return Ok(None);
    }
    let conditions = read_conditions(&conditions)?;
    let rows = Rows::new(&names(server), hosted, conditions.robots)?;
    let time = read_time(&server.text(FULL_NAME, TIME))?;
    check_mixed(&rows, time)?;
    let (seed, replicate, steps) = (integer(SEED), integer(REPLICATE), integer(STEPS));
    check_length(&conditions, steps)?;
    let placed = Placed {
        digest: placement_digest(&conditions, seed, replicate, steps),
        robots: rows.ours.iter().map(|row| rows.names[*row].clone()).collect(),
        steps,
        period_ns: period_ns(&conditions),
        time,
        gates: gates(server),
    };
    check_gates(&placed)?;
    let seed = Seed { seed, replicate };
    let world = World::new(&conditions, seed)?;
    let controllers = Controllers::new(&conditions, seed);
    Ok(Some(Wanted { world, controllers, placed, conditions, rows }))
}

/// Where the poses of real robots come from.
pub fn tracked_by(server: &ParameterServer) -> Result<PoseSource, WorldError> {
    read_tracker(&server.text(FULL_NAME, TRACKED_BY))
}

fn names(server: &ParameterServer) -> Vec<String> {
    match server.get(FULL_NAME, ROBOTS) {
        Some(ParameterValue::StringArray(names)) => names,
        other => unreachable!("{ROBOTS} was declared as an array of strings, found {other:?}"),
    }
}

/// The period as a whole number of nanoseconds: the stamps of a run are multiples of it.
fn period_ns(conditions: &Conditions) -> u64 {
    nanos(Duration::from_secs_f64(conditions.period_s))
}

fn nanos(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).expect("584 years are longer than any ROS time")
}

fn read_conditions(text: &str) -> Result<Conditions, WorldError> {
    let conditions: Conditions =
        serde_json::from_str(text).map_err(|source| WorldError::Unreadable { source })?;
    conditions.check()?;
    Ok(conditions)
}

fn check_gates(placed: &Placed) -> Result<(), WorldError> {
    if placed.time == Time::Lockstep && placed.gates == Gates::Elsewhere {
        return Err(WorldError::HardwareLockstep);
    }
    Ok(())
}

/// Real robots do not wait for each other.
fn check_mixed(rows: &Rows, time: Time) -> Result<(), WorldError> {
    match rows.tracked.first() {
        Some(row) if time == Time::Lockstep => {
            Err(WorldError::MixedLockstep { name: rows.names[*row].clone() })
        }
        _ => Ok(()),
    }
}

fn read_tracker(text: &str) -> Result<PoseSource, WorldError> {
    TRACKERS
        .into_iter()
        .find(|tracker| tracker.key() == text)
        .ok_or_else(|| WorldError::TrackedBy { found: text.to_owned() })
}

/// Stamps are simulated times, which must fit ROS's 32-bit seconds.
fn check_length(conditions: &Conditions, steps: u64) -> Result<(), WorldError> {
    let most = nanos(END) / period_ns(conditions);
    if steps <= most {
        return Ok(());
    }
    Err(WorldError::TooLong { steps, most, period_s: conditions.period_s })
}

fn read_time(text: &str) -> Result<Time, WorldError> {
    Time::from_key(text).ok_or_else(|| WorldError::Time { found: text.to_owned() })
}

#[cfg(test)]
mod tests;
