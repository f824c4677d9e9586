//! Why a fleet file cannot be used, in words.

use std::collections::BTreeSet;
use std::fmt;

use rsrs_core::document::DocumentError;
use rsrs_core::help::Help;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::tracker::InvalidTracker;

use super::{FILE_VERSION, PROFILE};
use crate::geofence::InvalidGeofence;

/// Why a fleet file cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FleetFileError {
    /// The text is not a fleet file.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// A version of the format that is not this one.
    #[error("{file}: fileversion is {found}, expected {FILE_VERSION}")]
    Version {
        /// The file.
        file: String,
        /// The version found.
        found: u32,
    },
    /// A name that ROS would not take as a namespace.
    #[error(
        "{file}: robot name `{name}`, expected a letter, then letters, digits and single _, or with a \
         namespace `lab/robot_1`"
    )]
    Name {
        /// The file.
        file: String,
        /// The name found.
        name: String,
    },
    /// A robot whose name is the namespace of another one.
    #[error("{file}: {other} is in the namespace `/{robot}`, which is that of another robot")]
    Within {
        /// The file.
        file: String,
        /// The robot.
        robot: String,
        /// The other one.
        other: String,
    },
    /// A robot of a type that the file does not describe.
    #[error("{file}: {robot} has type `{found}`, expected one of: {}", expected.join(", "))]
    UnknownType {
        /// The file.
        file: String,
        /// The robot.
        robot: String,
        /// The type found.
        found: String,
        /// The types of the file.
        expected: Vec<String>,
    },
    /// A gate of ours is in front of the wheels, and another node is to hold the lease.
    #[error(
        "{file}: {robot} has a gate of ours, expected `lease: gate` or `driver: {{kind: ros}}`"
    )]
    HasGate {
        /// The file.
        file: String,
        /// The robot.
        robot: String,
    },
    /// A tracker that does not publish so.
    #[error("{file}: the `tracker` of {robot}, which has `pose: {pose}`: {reason}")]
    Tracker {
        /// The file.
        file: String,
        /// The robot.
        robot: String,
        /// Where its pose comes from.
        pose: PoseSource,
        /// What does not fit.
        reason: InvalidTracker,
    },
    /// Two robots that the tracker could not tell apart.
    #[error("{file}: the tracker calls both {} and {} `{body}`", robots[0], robots[1])]
    OneBody {
        /// The file.
        file: String,
        /// The two.
        robots: [String; 2],
        /// What it calls them.
        body: String,
    },
    /// A number that no robot has.
    #[error("{file}: `{key}` of {robot} is {found}, expected more than 0 and at most {most}")]
    Number {
        /// The file.
        file: String,
        /// The robot.
        robot: String,
        /// The key.
        key: &'static str,
        /// What it has.
        found: String,
        /// What it may have.
        most: u32,
    },
    /// Bounds of the floor between which nothing is.
    #[error("{file}: {reason}")]
    Geofence {
        /// The file.
        file: String,
        /// What is wrong.
        reason: InvalidGeofence,
    },
    /// Keys that neither the robots, nor their types, nor `all` set; all that is missing in the
    /// file.
    #[error("{file}: {}", robots.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Missing {
        /// The file.
        file: String,
        /// What each robot lacks.
        robots: Vec<Lack>,
    },
}

/// What a robot of a fleet file lacks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lack {
    /// The robot.
    pub robot: String,
    /// Whether it lacks `enabled`, which has no default.
    pub enabled: bool,
    /// Keys that nor its type nor `all` has.
    pub keys: Vec<&'static str>,
}

impl fmt::Display for Lack {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let named = |keys: &[&str]| {
            let keys: Vec<String> = keys.iter().map(|key| format!("`{key}`")).collect();
            keys.join(" and no ")
        };
        write!(formatter, "{} has no ", self.robot)?;
        match (self.enabled, &self.keys[..]) {
            (true, []) => write!(formatter, "`enabled`"),
            (true, keys) => {
                write!(formatter, "`enabled` and no {}, nor has its type or `all`", named(keys))
            }
            (false, keys) => write!(formatter, "{}, nor has its type or `all`", named(keys)),
        }
    }
}

impl Help for FleetFileError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Document(error) => error.help(),
            Self::Missing { robots, file } => {
                let keys: BTreeSet<&str> = robots.iter().flat_map(|it| &it.keys).copied().collect();
                let keys: Vec<String> = keys.into_iter().map(|key| format!("`{key}`")).collect();
                let shared = (!keys.is_empty()).then(|| {
                    format!("give {} under the robot, its type or `all`", keys.join(", "))
                });
                let measured = robots.iter().any(|lack| lack.keys.contains(&PROFILE));
                let measure = measured.then(|| {
                    format!(
                        "to make a profile, measure the robots: `rsrs measure plan {file} -o trials`"
                    )
                });
                let enabled = robots.iter().any(|lack| lack.enabled);
                let own =
                    enabled.then(|| "set `enabled: true` or `false` of each robot".to_owned());
                Some(shared.into_iter().chain(measure).chain(own).collect::<Vec<_>>().join("; "))
            }
            Self::Tracker { reason: InvalidTracker::NoNames, .. } => Some(
                "list what the poses in a message are of, in their order: `tracker: {names: [robot_1, \
                 box, robot_2]}`"
                    .to_owned(),
            ),
            Self::Within { .. } => Some(
                "give the robots names of which none is the namespace of another: `lab/robot_1` and \
                 `lab/robot_2`"
                    .to_owned(),
            ),
            Self::Version { .. }
            | Self::Name { .. }
            | Self::UnknownType { .. }
            | Self::HasGate { .. }
            | Self::OneBody { .. }
            | Self::Tracker { .. }
            | Self::Number { .. }
            | Self::Geofence { .. } => None,
        }
    }
}
