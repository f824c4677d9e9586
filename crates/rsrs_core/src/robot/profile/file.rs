//! A profile as people write it: with one sensor, or with a list of them.

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use serde_saphyr::Spanned;

use super::{Actuation, Body, Computation, ProfileError, Provenance, RobotProfile};
use crate::document;
use crate::robot::sensor::file::{SensorEntry, sensors};
use crate::robot::sensor::{Sensing, SensorFlaw};

/// A robot as it was measured: every capability, with where its number comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProfileFile {
    /// Name of the kind of robot.
    name: String,
    /// Its body.
    body: Body,
    /// How it follows commands: `θᵃ` and disturbances.
    actuation: Actuation,
    /// What it detects: `θˢ`; give this for one sensor that detects neighbours ahead, or `sensors`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sensing: Option<Sensing>,
    /// Its sensors, if it has several or one that is not as in `sensing`; the first is that of the topic `detection`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sensors: Option<Vec<SensorEntry>>,
    /// How often it decides.
    computation: Computation,
    /// Where the numbers come from.
    provenance: Provenance,
}

impl TryFrom<ProfileFile> for RobotProfile {
    type Error = ProfileError;

    fn try_from(file: ProfileFile) -> Result<Self, ProfileError> {
        let (sensing, further_sensors) = match (file.sensing, file.sensors) {
            (Some(sensing), None) => (sensing, Vec::new()),
            (None, Some(entries)) => sensors(&entries)?,
            _ => return Err(ProfileError::SensingOrSensors),
        };
        Ok(Self {
            name: file.name,
            body: file.body,
            actuation: file.actuation,
            sensing,
            further_sensors,
            computation: file.computation,
            provenance: file.provenance,
        })
    }
}

impl From<RobotProfile> for ProfileFile {
    fn from(robot: RobotProfile) -> Self {
        let list = (!robot.has_one_plain_sensor()).then(|| robot.sensor_entries());
        Self {
            name: robot.name,
            body: robot.body,
            actuation: robot.actuation,
            sensing: list.is_none().then_some(robot.sensing),
            sensors: list,
            computation: robot.computation,
            provenance: robot.provenance,
        }
    }
}

/// Where the sensors of a list are in its file.
#[derive(Deserialize)]
struct Lines {
    sensors: Vec<Spanned<IgnoredAny>>,
}

impl ProfileError {
    /// The same, with the line of a sensor in its file.
    pub(super) fn at_its_line(self, file: &str, text: &str) -> Self {
        let Self::Sensor(SensorFlaw { sensor, problem }) = self else { return self };
        let lines = document::parse::<Lines>(file, text).ok();
        let line = lines.and_then(|lines| Some(lines.sensors.get(sensor)?.defined.line()));
        Self::SensorAt { file: file.to_owned(), line: line.unwrap_or(1), problem }
    }
}

/// That of its file.
impl JsonSchema for RobotProfile {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "RobotProfile".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        ProfileFile::json_schema(generator)
    }
}
