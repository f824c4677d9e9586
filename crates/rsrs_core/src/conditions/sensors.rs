//! All sensors of a simulated robot.

use serde::{Deserialize, Serialize};

use super::{Conditions, SimulatedRobot};
use crate::robot::profile::RobotProfile;
use crate::robot::region::Region;
use crate::robot::sensor::{
    Cone, DETECTION, Detects, Reading, ReadingNames, Sees, Sensing, SensorDetails,
};

/// A sensor as the world simulates it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulatedSensor {
    /// Name of its first reading.
    pub name: String,
    /// What of a neighbour must lie in the region, or touch it.
    pub sees: Sees,
    /// Where things are detected, before it is turned by its bearing.
    pub region: Region,
    /// Probability of the first reading when its kind is nearest.
    pub true_positive: f64,
    /// Probability of the first reading when nothing is there.
    pub false_positive: f64,
    /// Steps by which a detection arrives late.
    pub latency_steps: u32,
    /// What else it tells.
    #[serde(default, skip_serializing_if = "SensorDetails::is_plain")]
    pub details: SensorDetails,
}

impl SimulatedSensor {
    /// The sensor of a checked profile.
    pub fn new(name: &str, sensing: &Sensing) -> Self {
        Self {
            name: name.to_owned(),
            sees: sensing.sees,
            region: Region::new(sensing),
            true_positive: sensing.true_positive,
            false_positive: sensing.false_positive,
            latency_steps: sensing.latency_steps,
            details: sensing.details.clone(),
        }
    }

    /// All its readings, the first one first.
    pub fn readings(&self) -> Vec<Reading> {
        let first = Reading {
            name: self.name.clone(),
            detects: self.details.detects,
            true_positive: self.true_positive,
            false_positive: self.false_positive,
            taken_for: self.details.taken_for.clone(),
        };
        std::iter::once(first).chain(self.details.or.iter().cloned()).collect()
    }

    /// A point of its region in the robot's frame, in metres: x ahead, y to the left.
    pub fn in_frame_of_robot(&self, [x_m, y_m]: [f64; 2]) -> [f64; 2] {
        let (sine, cosine) = libm::sincos(self.details.bearing_rad);
        [x_m * cosine - y_m * sine, x_m * sine + y_m * cosine]
    }
}

/// A sensor of a profile again, to be checked as one.
impl From<&SimulatedSensor> for Sensing {
    fn from(sensor: &SimulatedSensor) -> Self {
        let (cone, polygon_m) = match &sensor.region {
            Region::Cone { half_angle_rad, range_m } => {
                (Some(Cone { half_angle_rad: *half_angle_rad, range_m: *range_m }), None)
            }
            Region::Polygon { corners_m } => (None, Some(corners_m.clone())),
        };
        Self {
            sees: sensor.sees,
            cone,
            polygon_m,
            true_positive: sensor.true_positive,
            false_positive: sensor.false_positive,
            latency_steps: sensor.latency_steps,
            details: sensor.details.clone(),
        }
    }
}

impl SimulatedRobot {
    /// Whether its one sensor detects neighbours ahead, and nothing else.
    pub fn has_one_plain_sensor(&self) -> bool {
        self.details.is_plain() && self.further_sensors.is_empty()
    }

    /// All its sensors, that of `detection` first.
    pub fn sensors(&self) -> Vec<SimulatedSensor> {
        let first = SimulatedSensor {
            name: DETECTION.to_owned(),
            sees: self.sees,
            region: self.region.clone(),
            true_positive: self.true_positive,
            false_positive: self.false_positive,
            latency_steps: self.latency_steps,
            details: self.details.clone(),
        };
        std::iter::once(first).chain(self.further_sensors.iter().cloned()).collect()
    }

    /// What it reports, by name.
    pub fn reading_names(&self) -> ReadingNames {
        if self.has_one_plain_sensor() {
            return ReadingNames::default();
        }
        let sensors = self.sensors();
        ReadingNames::new(sensors.iter().map(|sensor| sensor.details.names(&sensor.name)))
    }

    /// How far away it detects the centre of another robot of its size, in metres, with the sensor that reaches
    /// farthest; that of the first sensor if none detects robots.
    pub fn reach_m(&self) -> f64 {
        reach_m(&self.sensors(), self.radius_m)
    }
}

impl RobotProfile {
    /// As [`SimulatedRobot::reach_m`].
    pub fn reach_m(&self) -> f64 {
        let sensors: Vec<SimulatedSensor> =
            self.sensors().map(|(name, sensing)| SimulatedSensor::new(name, sensing)).collect();
        reach_m(&sensors, self.body.radius_m)
    }
}

fn reach_m(sensors: &[SimulatedSensor], radius_m: f64) -> f64 {
    let reach_m = |sensor: &SimulatedSensor| sensor.region.reach_m(sensor.sees, radius_m);
    let of_robots = sensors.iter().filter(|sensor| sensor.details.kinds().any(Detects::is_robot));
    of_robots.map(reach_m).max_by(f64::total_cmp).unwrap_or_else(|| reach_m(&sensors[0]))
}

impl Conditions {
    /// Whether every robot has one sensor that detects neighbours ahead, and nothing else.
    pub fn have_one_plain_sensor(&self) -> bool {
        self.robot.has_one_plain_sensor()
            && self.own_robots.values().all(SimulatedRobot::has_one_plain_sensor)
    }
}
