//! The report of `rsrs measure fit`: robots, commands and the sensor.

use serde::Serialize;

use super::motion::RobotGain;
use super::sensor::SensorMap;
use crate::statistics::variance::Estimate;

/// One robot at one commanded speed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpeedFit {
    /// The robot.
    pub robot: String,
    /// Commanded speed, in metres per second.
    pub commanded_m_s: f64,
    /// Trials made.
    pub n_trials: usize,
    /// Mean of the measured speeds, in metres per second.
    pub mean_m_s: f64,
    /// Their standard deviation, in metres per second; `None` for one trial.
    pub sd_m_s: Option<f64>,
    /// `θᵃ₁`, dimensionless.
    pub gain: f64,
    /// Lower bound of Student's 95 % interval; `None` for one trial.
    pub gain_low: Option<f64>,
    /// Upper bound.
    pub gain_high: Option<f64>,
}

/// One robot at one commanded turning rate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TurnFit {
    /// The robot.
    pub robot: String,
    /// Commanded turning rate, in radians per second.
    pub commanded_rad_s: f64,
    /// Trials made.
    pub n_trials: usize,
    /// Mean of the measured turning rates, in radians per second.
    pub mean_rad_s: f64,
    /// Their standard deviation, in radians per second; `None` for one trial.
    pub sd_rad_s: Option<f64>,
    /// `θᵃ₂`, dimensionless.
    pub gain: f64,
    /// Lower bound of Student's 95 % interval; `None` for one trial.
    pub gain_low: Option<f64>,
    /// Upper bound.
    pub gain_high: Option<f64>,
}

/// The sensor as the simulator uses it, with exact 95 % intervals.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SensorFit {
    /// Probability of a detection while a neighbour's centre is in the polygon.
    pub true_positive: f64,
    /// Lower bound.
    pub true_positive_low: f64,
    /// Upper bound.
    pub true_positive_high: f64,
    /// Probability of a detection while none is near.
    pub false_positive: f64,
    /// Lower bound.
    pub false_positive_low: f64,
    /// Upper bound.
    pub false_positive_high: f64,
    /// The simulator's polygon, counterclockwise, in metres; shape `[n_corners][2]`.
    pub polygon_m: Vec<[f64; 2]>,
}

impl SensorFit {
    pub(super) fn new(map: &SensorMap) -> Self {
        let (hit, alarm) = (map.true_positive, map.false_positive);
        Self {
            true_positive: hit.value,
            true_positive_low: hit.low,
            true_positive_high: hit.high,
            false_positive: alarm.value,
            false_positive_low: alarm.low,
            false_positive_high: alarm.high,
            polygon_m: map.polygon_m.clone(),
        }
    }
}

/// One line of the speeds.
pub(super) fn speed_fit(robot: &RobotGain, names: &[String]) -> SpeedFit {
    let Estimate { value: gain, low: gain_low, high: gain_high } = robot.gain;
    SpeedFit {
        robot: names[robot.robot].clone(),
        commanded_m_s: robot.command,
        n_trials: robot.gains.len(),
        mean_m_s: gain * robot.command,
        sd_m_s: robot.sd().map(|sd| sd * robot.command),
        gain,
        gain_low,
        gain_high,
    }
}

/// One line of the turns.
pub(super) fn turn_fit(robot: &RobotGain, names: &[String]) -> TurnFit {
    let Estimate { value: gain, low: gain_low, high: gain_high } = robot.gain;
    TurnFit {
        robot: names[robot.robot].clone(),
        commanded_rad_s: robot.command,
        n_trials: robot.gains.len(),
        mean_rad_s: gain * robot.command,
        sd_rad_s: robot.sd().map(|sd| sd * robot.command.abs()),
        gain,
        gain_low,
        gain_high,
    }
}
