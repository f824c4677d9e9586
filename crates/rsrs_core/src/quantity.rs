//! Quantities that a sweep can vary, in one table; the values of a sweep, and cells of them.

mod cell;
mod number;
mod region;
mod unit;
mod values;

use std::fmt;
use std::str::FromStr;

use serde::de::{self, Deserialize, Deserializer};
use serde::{Serialize, Serializer};

use self::number::PREFIX;
use crate::document::{did_you_mean, is_name, nearest};
use crate::robot::contact::ContactModel;
use crate::robot::profile::RobotProfile;

pub use crate::bounds::Bounds;
pub use cell::{Cell, CellError};
pub use number::{Number, NumberUnit};
pub use unit::OtherUnit;
pub use values::AxisValues;

/// A quantity that a sweep can vary.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Axis {
    /// Forward speed `v`, in metres per second.
    Speed,
    /// Turning rate `ω`, in radians per second.
    TurnRate,
    /// Forward speed where nothing is detected, in metres per second; without a value `v`.
    UndetectedSpeed,
    /// Turning rate where nothing is detected, in radians per second; without a value `-ω`.
    UndetectedTurnRate,
    /// Number of robots `N`.
    Robots,
    /// Radius of the disc in which robots start, in metres.
    PlacementRadius,
    /// Side of the square arena, in metres.
    Arena,
    /// Range of the sensor, in metres: a polygon keeps its shape, and its farthest corner is there.
    Range,
    /// Half of the sensor's opening angle, in radians: a polygon is stretched across its own axis, and
    /// its range stays.
    HalfAngle,
    /// Size of a sensing polygon, relative to the profile's; dimensionless.
    PolygonScale,
    /// Probability of detecting a neighbour in the region.
    TruePositive,
    /// Probability of a detection without one.
    FalsePositive,
    /// Standard deviation of both gains between robots, absolute; dimensionless.
    Heterogeneity,
    /// Steps by which a detection arrives late.
    LatencySteps,
    /// Standard deviation of the velocity disturbance, in metres per second.
    Gust,
    /// Time constant of the turning rate, in seconds.
    YawLag,
    /// Control period `Δt`, in seconds.
    Period,
    /// By how much the sensing region is turned about the robot, in radians; left is positive.
    SensorBearing,
    /// Mean gain of the speed, `θᵃ₁`, at every command; dimensionless.
    SpeedGain,
    /// Mean gain of the turning rate, `θᵃ₂`, at every command; dimensionless.
    TurnGain,
    /// Standard deviation of both gains from step to step; dimensionless.
    GainNoise,
    /// Standard deviation between robots of a turning rate that was not commanded, in radians per second.
    TurnBias,
    /// Standard deviation of the heading's random change per step, in radians.
    HeadingNoise,
    /// Coulomb's coefficient of two bodies that push each other; dimensionless.
    ContactFriction,
    /// A named number of a controller's table.
    Number(Number),
}

/// What is known of a quantity, besides its physics.
struct Row {
    /// Whose row it is; of no meaning in the row of a table's number, which its own axis holds.
    axis: Axis,
    key: &'static str,
    name: &'static str,
    /// Empty for what is dimensionless.
    unit: &'static str,
    bounds: Bounds,
    /// A greater amount than this is likely in the unit behind it.
    other_unit: Option<(f64, &'static str)>,
    kind: Kind,
}

enum Kind {
    /// Decided by the operator of a fleet.
    Setting,
    /// Likewise, in a controller's table.
    Number,
    /// What a robot is like.
    Capability {
        /// `None` if this robot does not have it.
        get: fn(&RobotProfile) -> Option<f64>,
        /// Fails with what robots are that do not have it: `whose sensor is a cone`.
        set: fn(&mut RobotProfile, f64) -> Result<(), &'static str>,
        /// What a perfect robot has; `None` where another value makes another robot.
        ideal: Option<f64>,
        /// `None` where that is up to the swarm.
        worse: Option<Worse>,
    },
}

/// Which values of a capability make the worse robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Worse {
    /// Greater ones: noise, errors, delays.
    More,
    /// Smaller ones.
    Less,
    /// Those further from 1 on the same side: mean gains.
    FartherFromOne,
}

/// One number of a profile.
macro_rules! number {
    ($($field:ident).+, $worse:ident $(, $ideal:literal)?) => {
        Kind::Capability {
            get: |robot| Some(robot.$($field).+),
            set: |robot, value| {
                robot.$($field).+ = value;
                Ok(())
            },
            ideal: [$(Some($ideal),)? None][0],
            worse: Some(Worse::$worse),
        }
    };
}

/// A deviation of both gains, of which the greater one counts.
macro_rules! greater {
    ($sd:ident) => {
        Kind::Capability {
            get: |robot| Some(robot.actuation.speed.$sd.max(robot.actuation.turn.$sd)),
            set: |robot, value| {
                robot.actuation.speed.$sd = value;
                robot.actuation.turn.$sd = value;
                Ok(())
            },
            ideal: Some(0.0),
            worse: Some(Worse::More),
        }
    };
}

/// A property of the sensor's region.
const fn region(
    get: fn(&RobotProfile) -> Option<f64>,
    set: fn(&mut RobotProfile, f64) -> Result<(), &'static str>,
    worse: Option<Worse>,
) -> Kind {
    Kind::Capability { get, set, ideal: None, worse }
}

fn mean(gains: impl Iterator<Item = f64>) -> f64 {
    let gains: Vec<f64> = gains.collect();
    gains.iter().sum::<f64>() / gains.len() as f64
}

/// A robot of this method is small and slow, in metres per second.
pub(crate) const MAX_SPEED_M_S: f64 = 5.0;
/// One and a half turns a second, in radians per second.
pub(crate) const MAX_TURN_RATE_RAD_S: f64 = 10.0;
/// A binary sensor of a small robot does not reach further, in metres.
pub(crate) const MAX_SENSING_M: f64 = 20.0;

const MM_S: Option<(f64, &str)> = Some((MAX_SPEED_M_S, "mm/s"));
const DEGREES_S: Option<(f64, &str)> = Some((MAX_TURN_RATE_RAD_S, "degrees per second"));
const DEGREES: Option<(f64, &str)> = Some((std::f64::consts::PI, "degrees"));

/// All quantities but those of controllers' tables, in the order of [`Axis`], those that an operator can set first.
const ROWS: [Row; 24] = [
    Row {
        axis: Axis::Speed,
        key: "speed_m_s",
        name: "speed",
        unit: "m/s",
        bounds: Bounds::SIGNED,
        other_unit: MM_S,
        kind: Kind::Setting,
    },
    Row {
        axis: Axis::TurnRate,
        key: "turn_rate_rad_s",
        name: "turning rate",
        unit: "rad/s",
        bounds: Bounds::SIGNED,
        other_unit: DEGREES_S,
        kind: Kind::Setting,
    },
    Row {
        axis: Axis::UndetectedSpeed,
        key: "undetected_speed_m_s",
        name: "speed without detection",
        unit: "m/s",
        bounds: Bounds::SIGNED,
        other_unit: MM_S,
        kind: Kind::Setting,
    },
    Row {
        axis: Axis::UndetectedTurnRate,
        key: "undetected_turn_rate_rad_s",
        name: "turning rate without detection",
        unit: "rad/s",
        bounds: Bounds::SIGNED,
        other_unit: DEGREES_S,
        kind: Kind::Setting,
    },
    Row {
        axis: Axis::Robots,
        key: "robots",
        name: "number of robots",
        unit: "robots",
        bounds: Bounds::ROBOTS,
        other_unit: None,
        kind: Kind::Setting,
    },
    Row {
        axis: Axis::PlacementRadius,
        key: "placement_radius_m",
        name: "placement radius",
        unit: "m",
        bounds: Bounds::SIZE,
        other_unit: Some((100.0, "mm")),
        kind: Kind::Setting,
    },
    Row {
        axis: Axis::Arena,
        key: "arena_m",
        name: "side of the arena",
        unit: "m",
        bounds: Bounds::SIZE,
        other_unit: None,
        kind: Kind::Setting,
    },
    Row {
        axis: Axis::Range,
        key: "range_m",
        name: "range of the sensor",
        unit: "m",
        bounds: Bounds::SIZE,
        other_unit: Some((MAX_SENSING_M, "mm")),
        kind: region(region::range_m, region::set_range, Some(Worse::Less)),
    },
    Row {
        axis: Axis::HalfAngle,
        key: "half_angle_rad",
        name: "half-angle of the sensor",
        unit: "rad",
        bounds: Bounds::HALF_ANGLE,
        other_unit: DEGREES,
        kind: region(region::half_angle_rad, region::set_half_angle, None),
    },
    Row {
        axis: Axis::PolygonScale,
        key: "polygon_scale",
        name: "size of the sensor's region",
        unit: "",
        bounds: Bounds::SIZE,
        other_unit: None,
        kind: region(region::scale, region::set_scale, None),
    },
    Row {
        axis: Axis::TruePositive,
        key: "true_positive",
        name: "true positive rate",
        unit: "",
        bounds: Bounds::PROBABILITY,
        other_unit: None,
        kind: number!(sensing.true_positive, Less, 1.0),
    },
    Row {
        axis: Axis::FalsePositive,
        key: "false_positive",
        name: "false positive rate",
        unit: "",
        bounds: Bounds::PROBABILITY,
        other_unit: None,
        kind: number!(sensing.false_positive, More, 0.0),
    },
    Row {
        axis: Axis::Heterogeneity,
        key: "heterogeneity",
        name: "spread of the gains between robots",
        unit: "",
        bounds: Bounds::AMOUNT,
        other_unit: None,
        kind: greater!(robot_sd),
    },
    Row {
        axis: Axis::LatencySteps,
        key: "latency_steps",
        name: "latency of the sensor",
        unit: "steps",
        bounds: Bounds::AMOUNT,
        other_unit: None,
        kind: Kind::Capability {
            get: |robot| Some(f64::from(robot.sensing.latency_steps)),
            set: |robot, value| {
                robot.sensing.latency_steps = value as u32;
                Ok(())
            },
            ideal: Some(0.0),
            worse: Some(Worse::More),
        },
    },
    Row {
        axis: Axis::Gust,
        key: "gust_m_s",
        name: "standard deviation of gusts",
        unit: "m/s",
        bounds: Bounds::AMOUNT,
        other_unit: MM_S,
        kind: number!(actuation.gust.sd_m_s, More, 0.0),
    },
    Row {
        axis: Axis::YawLag,
        key: "yaw_lag_s",
        name: "lag of the turning rate",
        unit: "s",
        bounds: Bounds::AMOUNT,
        other_unit: Some((5.0, "ms")),
        kind: number!(actuation.yaw_lag_s, More, 0.0),
    },
    Row {
        axis: Axis::Period,
        key: "period_s",
        name: "control period",
        unit: "s",
        bounds: Bounds::PERIOD,
        other_unit: Some((Bounds::PERIOD.most, "ms")),
        kind: number!(computation.period_s, More),
    },
    Row {
        axis: Axis::SensorBearing,
        key: "sensor_bearing_rad",
        name: "bearing of the sensor",
        unit: "rad",
        bounds: Bounds::BEARING,
        other_unit: DEGREES,
        kind: region(|_| Some(0.0), region::turn, None),
    },
    Row {
        axis: Axis::SpeedGain,
        key: "speed_gain",
        name: "gain of the speed",
        unit: "",
        bounds: Bounds::GAIN,
        other_unit: None,
        kind: Kind::Capability {
            get: |robot| {
                Some(mean(robot.actuation.speed.gain_by_command.iter().map(|gain| gain.mean)))
            },
            set: |robot, value| {
                for gain in &mut robot.actuation.speed.gain_by_command {
                    gain.mean = value;
                }
                Ok(())
            },
            ideal: Some(1.0),
            worse: Some(Worse::FartherFromOne),
        },
    },
    Row {
        axis: Axis::TurnGain,
        key: "turn_gain",
        name: "gain of the turning rate",
        unit: "",
        bounds: Bounds::GAIN,
        other_unit: None,
        kind: Kind::Capability {
            get: |robot| Some(mean(robot.actuation.turn.means())),
            set: |robot, value| {
                let turn = &mut robot.actuation.turn;
                let driving = turn.driving_gain_by_command.iter_mut().flatten();
                turn.gain_by_command.iter_mut().chain(driving).for_each(|gain| gain.mean = value);
                Ok(())
            },
            ideal: Some(1.0),
            worse: Some(Worse::FartherFromOne),
        },
    },
    Row {
        axis: Axis::GainNoise,
        key: "gain_noise",
        name: "spread of the gains per step",
        unit: "",
        bounds: Bounds::AMOUNT,
        other_unit: None,
        kind: greater!(step_sd),
    },
    Row {
        axis: Axis::TurnBias,
        key: "turn_bias_rad_s",
        name: "turn bias",
        unit: "rad/s",
        bounds: Bounds::AMOUNT,
        other_unit: DEGREES_S,
        kind: number!(actuation.turn.bias_sd_rad_s, More, 0.0),
    },
    Row {
        axis: Axis::HeadingNoise,
        key: "heading_noise_rad",
        name: "heading noise per step",
        unit: "rad",
        bounds: Bounds::AMOUNT,
        other_unit: DEGREES,
        kind: number!(actuation.turn.heading_noise_sd_rad, More, 0.0),
    },
    Row {
        axis: Axis::ContactFriction,
        key: "contact_friction",
        name: "friction of bodies that push",
        unit: "",
        bounds: Bounds::FRICTION,
        other_unit: None,
        kind: Kind::Capability {
            get: |robot| pushes(robot).then(|| robot.body.contact_friction.unwrap_or_default()),
            set: |robot, value| {
                if !pushes(robot) {
                    return Err("whose `body.contact` is not `push`");
                }
                robot.body.contact_friction = Some(value);
                Ok(())
            },
            ideal: None,
            worse: Some(Worse::More),
        },
    },
];

fn pushes(robot: &RobotProfile) -> bool {
    robot.body.contact == ContactModel::Push
}

impl Axis {
    /// All axes but the numbers of controllers' tables, those that an operator can set first.
    pub const ALL: [Self; ROWS.len()] = {
        let mut all = [Self::Speed; ROWS.len()];
        let mut index = 0;
        while index < ROWS.len() {
            all[index] = ROWS[index].axis;
            index += 1;
        }
        all
    };

    fn row(self) -> &'static Row {
        match self {
            Self::Number(number) => number.row(),
            _ => ROWS.iter().find(|row| row.axis == self).expect("each has a row"),
        }
    }

    /// The name in files and on the command line: `speed_m_s`.
    pub fn key(self) -> &'static str {
        self.row().key
    }

    /// The name in a sentence: `turning rate`.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// The label on a picture's axis: `speed (m/s)`.
    pub fn label(self) -> String {
        let Row { name, unit, .. } = self.row();
        let names_it = unit.is_empty() || name.rsplit(' ').next() == Some(*unit);
        if names_it { (*name).to_owned() } else { format!("{name} ({unit})") }
    }

    /// The unit behind a number: `m/s`; empty for dimensionless axes.
    pub fn unit(self) -> &'static str {
        self.row().unit
    }

    /// Between which values it can mean anything.
    pub fn bounds(self) -> Bounds {
        self.row().bounds
    }

    /// Whether the axis is a property of the robots rather than a setting: it cannot be set on a
    /// real fleet.
    pub fn is_capability(self) -> bool {
        matches!(self.row().kind, Kind::Capability { .. })
    }

    /// Whether only whole numbers make sense.
    pub fn is_count(self) -> bool {
        matches!(self.unit(), "robots" | "steps")
    }

    /// What a perfect robot has; `None` for settings, and where another value makes another robot.
    pub fn ideal(self) -> Option<f64> {
        match self.row().kind {
            Kind::Capability { ideal, .. } => ideal,
            Kind::Setting | Kind::Number => None,
        }
    }

    /// Which values make the worse robot; `None` for settings, and where that is up to the swarm.
    pub fn worse(self) -> Option<Worse> {
        match self.row().kind {
            Kind::Capability { worse, .. } => worse,
            Kind::Setting | Kind::Number => None,
        }
    }

    /// Gives a robot another capability. If it cannot have it, the error says which robots cannot:
    /// `whose sensor is a cone`.
    ///
    /// # Panics
    ///
    /// If the axis is a setting, as the speed is.
    pub(crate) fn set(self, robot: &mut RobotProfile, value: f64) -> Result<(), &'static str> {
        match self.row().kind {
            Kind::Capability { set, .. } => set(robot, value),
            Kind::Setting | Kind::Number => unreachable!("{self} is a setting and no capability"),
        }
    }
}

impl RobotProfile {
    /// What the robot has on an axis, in its unit: of two gains the mean, and of two standard
    /// deviations the greater one. `None` for settings, and for what this robot does not have.
    pub fn capability(&self, axis: Axis) -> Option<f64> {
        match axis.row().kind {
            Kind::Capability { get, .. } => get(self),
            Kind::Setting | Kind::Number => None,
        }
    }
}

/// A name that is no axis.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown axis `{found}`{}", or_number(found, *nearest))]
pub struct UnknownAxis {
    /// The name found.
    pub found: String,
    /// The axis closest in spelling.
    pub nearest: Option<&'static str>,
}

/// The axis that was meant; where none is near, that it may be a number of a controller's table.
fn or_number(found: &str, nearest: Option<&str>) -> String {
    match nearest {
        None if is_name(found) => {
            format!("; a named number of a controller is `{PREFIX}{found}`")
        }
        nearest => did_you_mean(nearest),
    }
}

impl FromStr for Axis {
    type Err = UnknownAxis;

    fn from_str(key: &str) -> Result<Self, UnknownAxis> {
        if let Some(number) = Number::from_key(key) {
            return Ok(Self::Number(number));
        }
        // What ends with a unit may be a number of a table.
        let number = || Number::new(key).filter(|_| NumberUnit::new(key) != NumberUnit::None);
        Self::ALL.into_iter().find(|axis| axis.key() == key).ok_or_else(|| UnknownAxis {
            found: key.to_owned(),
            nearest: nearest(key, Self::ALL.map(Self::key))
                .or_else(|| number().map(|number| Self::Number(number).key())),
        })
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.key())
    }
}

impl Serialize for Axis {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.key())
    }
}

impl<'de> Deserialize<'de> for Axis {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let key = String::deserialize(deserializer)?;
        key.parse().map_err(de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_quantity_is_in_its_place_in_the_table() {
        for (index, row) in ROWS.iter().enumerate() {
            assert_eq!(Axis::ALL[index], row.axis, "{}", row.key);
            assert_eq!(row.key.parse(), Ok(row.axis));
        }
    }

    #[test]
    fn what_is_worse_leads_away_from_the_perfect_robot() {
        for axis in Axis::ALL {
            let (Some(ideal), Some(worse)) = (axis.ideal(), axis.worse()) else { continue };

            let Bounds { least, most } = axis.bounds();
            let best = match worse {
                Worse::More => least,
                Worse::Less => most,
                Worse::FartherFromOne => 1.0,
            };
            assert_eq!(ideal.to_bits(), best.to_bits(), "{axis}");
        }
    }
}
