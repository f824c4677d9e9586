//! The list of sensors as people write it, and whether it can be.

use serde::{Deserialize, Serialize};

use super::{Cone, DETECTION, Detects, FurtherSensor, MOST_READINGS, Reading, Sees, Sensing};
use super::{SensorDetails, SensorFlaw, SensorProblem, half_angle, is_convex};
use crate::bounds::Bounds;
use crate::document::{is_name, nearest};
use crate::numerals::is_zero;

/// A sensor of a list: with `name`, `detects` and the probabilities of one reading, or with `one_of` for several.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SensorEntry {
    /// Name of its reading, which is also its topic, `detection/NAME`; that of the first sensor is `detection`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// What it detects (default: `robot`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub detects: Option<Detects>,
    /// Several kinds of things in the same region, of which the nearest counts: one reading for each, of which one
    /// at most is true.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub one_of: Option<Vec<Reading>>,
    /// Whether a neighbour is seen when its body touches the region (`body`, the default), or when its centre lies
    /// in it (`centre`).
    #[serde(default = "body")]
    pub sees: Sees,
    /// A conical region; give this or `polygon_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cone: Option<Cone>,
    /// A convex polygon in the sensor's frame (x along its bearing, y left), counterclockwise, at most 8
    /// corners, in metres; shape `[n_corners][2]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub polygon_m: Option<Vec<[f64; 2]>>,
    /// By how much the region is turned about the robot's centre, in radians (default: 0, ahead); left is positive.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub bearing_rad: f64,
    /// What hides things behind it (default: nothing): `robot`, `kin`, `other`, `wall`, `object` and `goal`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub hidden_by: Vec<Detects>,
    /// Probability of a detection when something is in the region.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub true_positive: Option<f64>,
    /// Probability of a detection when nothing is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub false_positive: Option<f64>,
    /// Steps by which a detection arrives late (default: 0).
    #[serde(default)]
    pub latency_steps: u32,
}

fn body() -> Sees {
    Sees::Body
}

impl SensorEntry {
    /// A sensor as an entry of a list.
    pub fn new(name: &str, sensing: &Sensing) -> Self {
        let SensorDetails { detects, bearing_rad, hidden_by, taken_for, or } =
            sensing.details.clone();
        let (true_positive, false_positive) = (sensing.true_positive, sensing.false_positive);
        let name = name.to_owned();
        let shared = Self {
            name: None,
            detects: None,
            one_of: None,
            sees: sensing.sees,
            cone: sensing.cone,
            polygon_m: sensing.polygon_m.clone(),
            bearing_rad,
            hidden_by,
            true_positive: None,
            false_positive: None,
            latency_steps: sensing.latency_steps,
        };
        if or.is_empty() {
            return Self {
                name: Some(name),
                detects: (detects != Detects::default()).then_some(detects),
                true_positive: Some(true_positive),
                false_positive: Some(false_positive),
                ..shared
            };
        }
        let first = Reading { name, detects, true_positive, false_positive, taken_for };
        Self { one_of: Some(std::iter::once(first).chain(or).collect()), ..shared }
    }

    /// Its readings, if it has what they need.
    fn readings(&self) -> Result<Vec<Reading>, SensorProblem> {
        let missing = |key| SensorProblem::Missing(key);
        let Some(readings) = &self.one_of else {
            return Ok(vec![Reading {
                name: self.name.clone().ok_or(missing("name"))?,
                detects: self.detects.unwrap_or_default(),
                true_positive: self.true_positive.ok_or(missing("true_positive"))?,
                false_positive: self.false_positive.ok_or(missing("false_positive"))?,
                taken_for: std::collections::BTreeMap::new(),
            }]);
        };
        let beside = [
            ("name", self.name.is_some()),
            ("detects", self.detects.is_some()),
            ("true_positive", self.true_positive.is_some()),
            ("false_positive", self.false_positive.is_some()),
        ];
        if let Some((key, _)) = beside.into_iter().find(|(_, is_given)| *is_given) {
            return Err(SensorProblem::BesideOneOf(key));
        }
        if readings.len() < 2 {
            return Err(SensorProblem::OneOf(readings.len()));
        }
        Ok(readings.clone())
    }

    /// Whether it can be a sensor.
    fn check(&self) -> Result<Vec<Reading>, SensorProblem> {
        let readings = self.readings()?;
        for (place, reading) in readings.iter().enumerate() {
            if !is_name(&reading.name) {
                return Err(SensorProblem::Name(reading.name.clone()));
            }
            let mut before = readings[..place].iter();
            let shared = |other: &Reading| {
                Some((other.name.clone(), reading.detects.shared_with(other.detects)?))
            };
            if let Some((first, kind)) = before.find_map(shared) {
                let second = reading.name.clone();
                return Err(SensorProblem::Kinds { first, second, kind: kind.key() });
            }
            check_row(reading, &readings)?;
        }
        let alarms: f64 = readings.iter().map(|reading| reading.false_positive).sum();
        if alarms > MOST_SUM {
            return Err(SensorProblem::Row { place: "nothing", found: alarms });
        }
        let angle = |it| format!("an angle {it} rad");
        within("bearing_rad", self.bearing_rad, Bounds::BEARING, angle)?;
        within("latency_steps", self.latency_steps.into(), Bounds::AMOUNT, Bounds::number)?;
        self.check_region()?;
        Ok(readings)
    }

    fn check_region(&self) -> Result<(), SensorProblem> {
        match (&self.cone, &self.polygon_m) {
            (Some(Cone { half_angle_rad, range_m }), None) => {
                within("range_m", *range_m, Bounds::SIZE, Bounds::number)?;
                half_angle(*half_angle_rad, self.sees).map_err(|expected| {
                    SensorProblem::OutOfRange {
                        key: "half_angle_rad",
                        found: *half_angle_rad,
                        expected,
                    }
                })
            }
            (None, Some(corners_m)) => {
                for coordinate in corners_m.iter().flatten() {
                    within("polygon_m", *coordinate, Bounds::COORDINATE, Bounds::number)?;
                }
                if is_convex(corners_m) {
                    return Ok(());
                }
                Err(SensorProblem::Polygon(corners_m.len()))
            }
            _ => Err(SensorProblem::Region),
        }
    }
}

fn within(
    key: &'static str,
    found: f64,
    bounds: Bounds,
    expected: impl Fn(Bounds) -> String,
) -> Result<(), SensorProblem> {
    if bounds.contains(found) {
        return Ok(());
    }
    Err(SensorProblem::OutOfRange { key, found, expected: expected(bounds).into() })
}

/// What rounding adds to probabilities that are 1 together.
const MOST_SUM: f64 = 1.0 + 1e-9;

/// Whether a reading's row of the confusion table is one.
fn check_row(reading: &Reading, readings: &[Reading]) -> Result<(), SensorProblem> {
    let probability = |key, found| within(key, found, Bounds::PROBABILITY, Bounds::probability);
    probability("true_positive", reading.true_positive)?;
    probability("false_positive", reading.false_positive)?;
    let mut sum = reading.true_positive;
    let others = || readings.iter().map(|it| it.name.as_str()).filter(|it| *it != reading.name);
    for (found, likely) in &reading.taken_for {
        probability("taken_for", *likely)?;
        if !others().any(|name| name == found) {
            let nearest = nearest(found, others()).map(str::to_owned);
            return Err(SensorProblem::TakenFor { found: found.clone(), nearest });
        }
        sum += likely;
    }
    if sum > MOST_SUM {
        return Err(SensorProblem::Row { place: reading.detects.one(), found: sum });
    }
    Ok(())
}

/// The sensors of a list, the first of which is that of `detection`.
pub fn sensors(entries: &[SensorEntry]) -> Result<(Sensing, Vec<FurtherSensor>), SensorFlaw> {
    let mut sensors = Vec::new();
    let mut names: Vec<String> = Vec::new();
    for (sensor, entry) in entries.iter().enumerate() {
        let refuse = |problem| SensorFlaw { sensor, problem };
        let readings = entry.check().map_err(refuse)?;
        for Reading { name, .. } in &readings {
            if names.is_empty() && name != DETECTION {
                return Err(refuse(SensorProblem::First(name.clone())));
            }
            if names.contains(name) {
                return Err(refuse(SensorProblem::Twice(name.clone())));
            }
            names.push(name.clone());
        }
        if names.len() > MOST_READINGS {
            return Err(refuse(SensorProblem::Readings(names.len())));
        }
        sensors.push(sensor_of(entry, readings));
    }
    let mut sensors = sensors.into_iter();
    let problem = SensorProblem::Nothing;
    let first = sensors.next().ok_or(SensorFlaw { sensor: 0, problem })?;
    Ok((first.sensing, sensors.collect()))
}

/// What a checked entry comes to.
fn sensor_of(entry: &SensorEntry, readings: Vec<Reading>) -> FurtherSensor {
    let mut readings = readings.into_iter();
    let first = readings.next().expect("a checked sensor has a reading");
    let Reading { name, detects, true_positive, false_positive, taken_for } = first;
    let details = SensorDetails {
        detects,
        bearing_rad: entry.bearing_rad,
        hidden_by: entry.hidden_by.clone(),
        taken_for,
        or: readings.collect(),
    };
    let sensing = Sensing {
        sees: entry.sees,
        cone: entry.cone,
        polygon_m: entry.polygon_m.clone(),
        true_positive,
        false_positive,
        latency_steps: entry.latency_steps,
        details,
    };
    FurtherSensor { name, sensing }
}
