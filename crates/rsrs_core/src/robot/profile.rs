//! The measured robot: what step 1 of the method finds out, as a file.

mod check;
mod differences;
mod file;
mod unmeasured;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::document::source::InFile;
use crate::document::{self, DocumentError};
use crate::help::Help;
use crate::out_of_range::OutOfRange;
use crate::robot::contact::ContactModel;
use crate::robot::sensor::file::SensorEntry;
use crate::robot::sensor::{DETECTION, FurtherSensor, ReadingNames, SensorFlaw, SensorProblem};
use crate::robot::wheels::Wheels;

use file::ProfileFile;

pub use crate::robot::sensor::{Cone, MAX_CORNERS, Sees, Sensing};

/// A robot as it was measured: every capability, with where its number comes from.
///
/// # Source
///
/// §IV step 1: actuation, sensing, computation.
///
/// In a file, `sensing` is the one sensor of a robot that detects its neighbours ahead; `sensors` is a list of any, whose
/// first one is `sensing` here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "ProfileFile", into = "ProfileFile")]
pub struct RobotProfile {
    /// Name of the kind of robot.
    pub name: String,
    /// Its body.
    pub body: Body,
    /// How it follows commands: `θᵃ` and disturbances.
    pub actuation: Actuation,
    /// What it detects: `θˢ`; of several sensors the first.
    pub sensing: Sensing,
    /// Its other sensors.
    pub further_sensors: Vec<FurtherSensor>,
    /// How often it decides.
    pub computation: Computation,
    /// Where the numbers come from.
    pub provenance: Provenance,
}

/// The body of a robot: a disc.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Radius of the disc, in metres.
    pub radius_m: f64,
    /// A robot that touches another within this angle of its heading cannot drive on; in radians.
    pub front_half_angle_rad: f64,
    /// Whether a robot that cannot drive on still turns.
    pub rotates_while_blocked: bool,
    /// What robots do when they touch (default: `stop`): stop in place with another one in front, and
    /// cannot be pushed; push each other, or pass through each other.
    #[serde(default, skip_serializing_if = "ContactModel::is_usual")]
    pub contact: ContactModel,
    /// Coulomb's coefficient of the friction between two robots that push each other (`contact: push`), and along
    /// walls at which these slide, from 0 to 2 (default: 0, they slide freely); objects have their own;
    /// dimensionless.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact_friction: Option<f64>,
}

/// How a robot follows its commands.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Actuation {
    /// Forward speed.
    pub speed: SpeedActuation,
    /// Turning rate.
    pub turn: TurnActuation,
    /// Its two wheels, if they are what limits a turn while it drives; without them, speed and turning rate
    /// have their own limits alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wheels: Option<Wheels>,
    /// Velocity disturbance `w`.
    pub gust: Gust,
    /// Time constant with which the turning rate follows its command, in seconds; 0 is at once.
    pub yaw_lag_s: f64,
}

/// How a robot follows its commanded speed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedActuation {
    /// Least and greatest safe speed, in metres per second.
    pub limits_m_s: [f64; 2],
    /// Mean gain `θᵃ₁` at each measured command.
    pub gain_by_command: Vec<SpeedGain>,
    /// Standard deviation of the gain between robots; dimensionless.
    pub robot_sd: f64,
    /// Standard deviation of the gain from step to step; dimensionless.
    pub step_sd: f64,
}

/// Mean speed gain at one command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpeedGain {
    /// Commanded speed, in metres per second.
    pub commanded_m_s: f64,
    /// Mean gain `θᵃ₁`; dimensionless.
    pub mean: f64,
}

/// How a robot follows its commanded turning rate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TurnActuation {
    /// Least and greatest safe turning rate, in radians per second.
    pub limits_rad_s: [f64; 2],
    /// Mean gain `θᵃ₂` at each measured command.
    pub gain_by_command: Vec<TurnGain>,
    /// Mean gain `θᵃ₂` at each measured command while the robot drives forward; where it is left
    /// out, that of turning in place.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub driving_gain_by_command: Option<Vec<TurnGain>>,
    /// Standard deviation of the gain between robots; dimensionless.
    pub robot_sd: f64,
    /// Standard deviation of the gain from step to step; dimensionless.
    pub step_sd: f64,
    /// Standard deviation between robots of a constant turning-rate bias, in
    /// radians per second.
    pub bias_sd_rad_s: f64,
    /// Standard deviation of the heading's random change in each step, in radians.
    pub heading_noise_sd_rad: f64,
}

/// Mean turn gain at one command.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TurnGain {
    /// Commanded turning rate, in radians per second.
    pub commanded_rad_s: f64,
    /// Mean gain `θᵃ₂`; dimensionless.
    pub mean: f64,
}

/// A velocity disturbance: an Ornstein-Uhlenbeck process on each axis of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gust {
    /// Stationary standard deviation on each axis, in metres per second; 0 is none.
    pub sd_m_s: f64,
    /// Correlation time, in seconds.
    pub time_constant_s: f64,
}

/// How often a robot decides.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Computation {
    /// Sampling period `Δt`, in seconds.
    pub period_s: f64,
}

/// Where the numbers of a profile come from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Provenance {
    /// The whole profile in one sentence.
    pub source: String,
    /// Whether a simulator made all or some of the trials that it was fitted to; left out if robots
    /// drove them, or nothing is stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trials: Option<TrialOrigin>,
    /// Number by number: dotted path of the key, and its source or `assumed` with the reason.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub numbers: BTreeMap<String, String>,
}

/// Why a profile cannot describe a robot.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// The text is not a profile.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// A number lies outside what it can mean.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// A gain table is empty or not ascending in its commands.
    #[error("{0} needs at least one entry, with ascending commands")]
    GainTable(&'static str),
    /// A friction of robots that push nobody.
    #[error(
        "body.contact_friction is {found}, and body.contact is {}: only bodies that push have friction",
        contact.name()
    )]
    Friction {
        /// The friction found.
        found: f64,
        /// What the robots do instead.
        contact: ContactModel,
    },
    /// Both a cone and a polygon, or neither.
    #[error("sensing needs exactly one of `cone` and `polygon_m`")]
    Region,
    /// The polygon is not convex, not counterclockwise, or has too few or too many corners.
    #[error(
        "sensing.polygon_m has {0} corners, expected 3 to {MAX_CORNERS}, convex and counterclockwise"
    )]
    Polygon(usize),
    /// Both a sensor and a list of them, or neither.
    #[error("a profile needs exactly one of `sensing` and `sensors`")]
    SensingOrSensors,
    /// A sensor of a list cannot be.
    #[error(transparent)]
    Sensor(#[from] SensorFlaw),
    /// The same, in a file.
    #[error("{file}:{line}: {problem}")]
    SensorAt {
        /// The file.
        file: String,
        /// Line of the sensor, from 1.
        line: u64,
        /// What is wrong there.
        problem: SensorProblem,
    },
}

impl Help for ProfileError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Document(error) => error.help(),
            Self::Sensor(flaw) => flaw.help(),
            Self::SensorAt { problem, .. } => problem.help(),
            Self::SensingOrSensors => Some(
                "give `sensing` for one sensor that detects neighbours ahead, or `sensors` for a list of any"
                    .to_owned(),
            ),
            _ => None,
        }
    }
}

impl InFile for RobotProfile {
    const WHAT: &'static str = "profile";
    const SOURCE: &'static str = "ProfileSource";
}

impl RobotProfile {
    /// Reads a profile and checks that it can describe a robot.
    pub fn parse(file: &str, text: &str) -> Result<Self, ProfileError> {
        let written: ProfileFile = document::parse(file, text)?;
        let profile = Self::try_from(written).map_err(|error| error.at_its_line(file, text))?;
        profile.check()?;
        Ok(profile)
    }

    /// The profile as a YAML document.
    pub fn to_yaml(&self) -> String {
        document::to_yaml(self)
    }

    /// Names this profile's content in provenance records: 16 hexadecimal digits.
    pub fn digest(&self) -> String {
        let mut digest = crate::digest::Digest::new("profile");
        let text = serde_json::to_string(self).expect("a profile is plain data");
        digest.text(&text);
        format!("{:016x}", digest.value())
    }

    /// Whether its one sensor detects neighbours ahead, and nothing else.
    pub fn has_one_plain_sensor(&self) -> bool {
        self.further_sensors.is_empty() && self.sensing.details.is_plain()
    }

    /// Its sensors with the names of their first readings, the first sensor first.
    pub fn sensors(&self) -> impl Iterator<Item = (&str, &Sensing)> {
        let further = self.further_sensors.iter();
        std::iter::once((DETECTION, &self.sensing))
            .chain(further.map(|sensor| (sensor.name.as_str(), &sensor.sensing)))
    }

    /// The same, to be changed.
    pub fn sensings_mut(&mut self) -> impl Iterator<Item = &mut Sensing> {
        let further = self.further_sensors.iter_mut().map(|sensor| &mut sensor.sensing);
        std::iter::once(&mut self.sensing).chain(further)
    }

    /// What it reports, by name.
    pub fn reading_names(&self) -> ReadingNames {
        ReadingNames::new(self.sensors().map(|(name, sensing)| sensing.details.names(name)))
    }

    /// Its sensors as a list.
    pub fn sensor_entries(&self) -> Vec<SensorEntry> {
        self.sensors().map(|(name, sensing)| SensorEntry::new(name, sensing)).collect()
    }
}

/// A gain read from a table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GainAt {
    /// Mean gain; dimensionless.
    pub mean: f64,
    /// Whether the command lies outside the measured ones, so that the nearest was held.
    pub held: bool,
}

impl SpeedActuation {
    /// Mean gain at a command: linear between measured commands, the nearest held outside.
    pub fn gain_at(&self, commanded_m_s: f64) -> GainAt {
        let table = self.gain_by_command.iter().map(|gain| (gain.commanded_m_s, gain.mean));
        read_table(&table.collect::<Vec<_>>(), commanded_m_s)
    }
}

impl TurnActuation {
    /// All measured mean gains, in place and while driving; dimensionless.
    pub fn means(&self) -> impl Iterator<Item = f64> {
        self.gain_by_command
            .iter()
            .chain(self.driving_gain_by_command.iter().flatten())
            .map(|gain| gain.mean)
    }

    /// Mean gain at a turning rate of this size: linear between measured commands, the nearest held
    /// outside. A robot that drives may turn by another gain than one that turns in place.
    pub fn gain_at(&self, commanded_rad_s: f64, speed_m_s: f64) -> GainAt {
        let driving = self.driving_gain_by_command.as_ref().filter(|_| speed_m_s != 0.0);
        let table = driving.unwrap_or(&self.gain_by_command);
        let table = table.iter().map(|gain| (gain.commanded_rad_s, gain.mean));
        read_table(&table.collect::<Vec<_>>(), commanded_rad_s)
    }
}

fn read_table(table: &[(f64, f64)], command: f64) -> GainAt {
    let (first, last) = (table[0], table[table.len() - 1]);
    if command <= first.0 {
        return GainAt { mean: first.1, held: command < first.0 };
    }
    if command >= last.0 {
        return GainAt { mean: last.1, held: command > last.0 };
    }
    let above = table.partition_point(|(commanded, _)| *commanded <= command);
    let (low, high) = (table[above - 1], table[above]);
    let share = (command - low.0) / (high.0 - low.0);
    GainAt { mean: low.1 + share * (high.1 - low.1), held: false }
}

/// How far trials are those of a simulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TrialOrigin {
    /// All of them.
    Simulated,
    /// Some of them.
    PartlySimulated,
}

impl TrialOrigin {
    /// Whose trials they are, for a sentence: `trials of …`.
    pub fn whose(self) -> &'static str {
        match self {
            Self::Simulated => "the simulator",
            Self::PartlySimulated => "the simulator and of robots",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: [(f64, f64); 2] = [(0.025, 0.879), (0.050, 0.971)];

    #[test]
    fn the_nearest_gain_is_held_outside_the_measured_commands() {
        assert_eq!(read_table(&TABLE, 0.15), GainAt { mean: 0.971, held: true });
        assert_eq!(read_table(&TABLE, 0.05), GainAt { mean: 0.971, held: false });
        assert_eq!(read_table(&TABLE, 0.01), GainAt { mean: 0.879, held: true });
    }

    #[test]
    fn the_gain_is_linear_between_measured_commands() {
        let between = read_table(&TABLE, 0.0375);

        assert!((between.mean - 0.925).abs() < 1e-12 && !between.held);
    }
}
