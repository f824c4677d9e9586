//! The capabilities of a robot as axes: what it has on each, and the same robot with others.

use super::check;
use super::resolve::ConditionsError;
use crate::diagram::axis::Axis;
use crate::robot::profile::{RobotProfile, Sensing};
use crate::robot::shape::{self, Opening};

impl RobotProfile {
    /// The robot with other capabilities.
    ///
    /// The region of a sensor is scaled, opened, given its range and turned, in this order, whatever
    /// the order of the values. A cone that is turned becomes a polygon ([`shape::turned_cone`]).
    ///
    /// # Arguments
    ///
    /// * `values` — on axes that are capabilities; of one that occurs twice the later value counts.
    ///
    /// # Errors
    ///
    /// [`ConditionsError`]: a value that the axis cannot have, or that this robot cannot.
    ///
    /// # Panics
    ///
    /// If an axis is a setting, as the speed is.
    pub fn with_capabilities(&self, values: &[(Axis, f64)]) -> Result<Self, ConditionsError> {
        let mut robot = self.clone();
        for (axis, value) in values {
            check_value(*axis, *value)?;
            set(&mut robot, *axis, *value);
        }
        let last = |wanted: Axis| {
            let values = values.iter().rev().find(|(axis, _)| *axis == wanted);
            values.map(|(_, value)| *value)
        };
        set_region(&mut robot.sensing, last)?;
        robot.check()?;
        Ok(robot)
    }

    /// What the robot has on an axis.
    ///
    /// # Returns
    ///
    /// In the unit of the axis, of two gains the mean and of two standard deviations the greater one;
    /// `None` for settings, and for what this sensor does not have.
    pub fn capability(&self, axis: Axis) -> Option<f64> {
        let Self { actuation, sensing, .. } = self;
        let (speed, turn) = (&actuation.speed, &actuation.turn);
        let mean = |gains: Vec<f64>| gains.iter().sum::<f64>() / gains.len() as f64;
        match axis {
            Axis::Range => Some(match (&sensing.cone, &sensing.polygon_m) {
                (Some(cone), _) => cone.range_m,
                (None, corners_m) => shape::range_m(corners_m.as_deref()?),
            }),
            Axis::HalfAngle => match (&sensing.cone, &sensing.polygon_m) {
                (Some(cone), _) => Some(cone.half_angle_rad),
                (None, corners_m) => Some(Opening::of(corners_m.as_deref()?)?.half_angle_rad),
            },
            Axis::PolygonScale => sensing.polygon_m.as_ref().map(|_| 1.0),
            Axis::SensorBearing => Some(0.0),
            Axis::TruePositive => Some(sensing.true_positive),
            Axis::FalsePositive => Some(sensing.false_positive),
            Axis::LatencySteps => Some(f64::from(sensing.latency_steps)),
            Axis::Heterogeneity => Some(speed.robot_sd.max(turn.robot_sd)),
            Axis::GainNoise => Some(speed.step_sd.max(turn.step_sd)),
            Axis::SpeedGain => {
                Some(mean(speed.gain_by_command.iter().map(|gain| gain.mean).collect()))
            }
            Axis::TurnGain => Some(mean(turn.means().collect())),
            Axis::TurnBias => Some(turn.bias_sd_rad_s),
            Axis::HeadingNoise => Some(turn.heading_noise_sd_rad),
            Axis::Gust => Some(actuation.gust.sd_m_s),
            Axis::YawLag => Some(actuation.yaw_lag_s),
            Axis::Period => Some(self.computation.period_s),
            Axis::Speed
            | Axis::TurnRate
            | Axis::UndetectedSpeed
            | Axis::UndetectedTurnRate
            | Axis::Robots
            | Axis::PlacementRadius
            | Axis::Arena => None,
        }
    }
}

/// Sets what is not the sensor's region.
fn set(robot: &mut RobotProfile, axis: Axis, value: f64) {
    let (actuation, sensing) = (&mut robot.actuation, &mut robot.sensing);
    match axis {
        Axis::TruePositive => sensing.true_positive = value,
        Axis::FalsePositive => sensing.false_positive = value,
        Axis::LatencySteps => sensing.latency_steps = value as u32,
        Axis::Heterogeneity => {
            actuation.speed.robot_sd = value;
            actuation.turn.robot_sd = value;
        }
        Axis::GainNoise => {
            actuation.speed.step_sd = value;
            actuation.turn.step_sd = value;
        }
        Axis::SpeedGain => {
            actuation.speed.gain_by_command.iter_mut().for_each(|gain| gain.mean = value);
        }
        Axis::TurnGain => {
            let turn = &mut actuation.turn;
            let driving = turn.driving_gain_by_command.iter_mut().flatten();
            turn.gain_by_command.iter_mut().chain(driving).for_each(|gain| gain.mean = value);
        }
        Axis::TurnBias => actuation.turn.bias_sd_rad_s = value,
        Axis::HeadingNoise => actuation.turn.heading_noise_sd_rad = value,
        Axis::Gust => actuation.gust.sd_m_s = value,
        Axis::YawLag => actuation.yaw_lag_s = value,
        Axis::Period => robot.computation.period_s = value,
        Axis::Range | Axis::HalfAngle | Axis::PolygonScale | Axis::SensorBearing => {}
        Axis::Speed
        | Axis::TurnRate
        | Axis::UndetectedSpeed
        | Axis::UndetectedTurnRate
        | Axis::Robots
        | Axis::PlacementRadius
        | Axis::Arena => {
            unreachable!("{axis} is a setting and no capability")
        }
    }
}

fn set_region(
    sensing: &mut Sensing,
    value: impl Fn(Axis) -> Option<f64>,
) -> Result<(), ConditionsError> {
    let refuse = |axis, sensor| Err(ConditionsError::NotOfThisSensor { axis, sensor });
    let turn_rad = value(Axis::SensorBearing).filter(|turn_rad| *turn_rad != 0.0);
    if let Some(cone) = &mut sensing.cone {
        if value(Axis::PolygonScale).is_some() {
            return refuse(Axis::PolygonScale, "cone");
        }
        cone.half_angle_rad = value(Axis::HalfAngle).unwrap_or(cone.half_angle_rad);
        cone.range_m = value(Axis::Range).unwrap_or(cone.range_m);
        if let Some(turn_rad) = turn_rad {
            sensing.polygon_m = Some(shape::turned_cone(*cone, turn_rad));
            sensing.cone = None;
        }
        return Ok(());
    }
    let Some(corners_m) = &mut sensing.polygon_m else { return Ok(()) };
    if let Some(scale) = value(Axis::PolygonScale) {
        *corners_m = shape::scaled(corners_m, scale);
    }
    if let Some(half_angle_rad) = value(Axis::HalfAngle) {
        match shape::stretched(corners_m, half_angle_rad) {
            Some(stretched) => *corners_m = stretched,
            None => return refuse(Axis::HalfAngle, "polygon that is not all in front of it"),
        }
    }
    if let Some(range_m) = value(Axis::Range) {
        *corners_m = shape::scaled(corners_m, range_m / shape::range_m(corners_m));
    }
    if let Some(turn_rad) = turn_rad {
        *corners_m = shape::turned(corners_m, turn_rad);
    }
    Ok(())
}

/// What an axis can mean.
pub(crate) fn bounds(axis: Axis) -> check::Bounds {
    match axis {
        Axis::Robots => check::ROBOTS,
        Axis::TruePositive | Axis::FalsePositive => check::PROBABILITY,
        Axis::HalfAngle => check::HALF_ANGLE,
        Axis::SensorBearing => check::BEARING,
        Axis::Speed | Axis::TurnRate | Axis::UndetectedSpeed | Axis::UndetectedTurnRate => {
            check::SIGNED
        }
        Axis::Heterogeneity
        | Axis::GainNoise
        | Axis::TurnBias
        | Axis::HeadingNoise
        | Axis::LatencySteps
        | Axis::Gust
        | Axis::YawLag => check::AMOUNT,
        Axis::PlacementRadius
        | Axis::Arena
        | Axis::Range
        | Axis::PolygonScale
        | Axis::SpeedGain
        | Axis::TurnGain => check::SIZE,
        Axis::Period => check::PERIOD,
    }
}

/// Refuses a value outside what the axis can mean.
pub(super) fn check_value(axis: Axis, found: f64) -> Result<(), ConditionsError> {
    check_bounds(axis, found, bounds(axis))
}

/// Refuses a value outside bounds.
pub(super) fn check_bounds(
    axis: Axis,
    found: f64,
    bounds: check::Bounds,
) -> Result<(), ConditionsError> {
    let whole = !axis.is_count() || found.fract() == 0.0;
    if bounds.contains(found) && whole {
        return Ok(());
    }
    let kind = if axis.is_count() { "a whole number" } else { "a number" };
    Err(ConditionsError::OutOfRange { axis, found, expected: format!("{kind} {bounds}") })
}
