//! The numbers of a simulated robot that a sweep can vary, in one table.

use std::borrow::Cow;

use super::SimulatedRobot;
use crate::quantity::Axis;

/// A number of a simulated robot: its axis bounds it, and states which values make the worse robot.
pub(crate) struct RobotNumber {
    /// Dotted path in conditions.
    pub key: &'static str,
    /// The axis, which may set two numbers at once.
    pub axis: Axis,
    /// What tells it from the other one of its axis.
    name: Option<&'static str>,
    pub get: fn(&SimulatedRobot) -> f64,
}

impl RobotNumber {
    /// Its name with its unit.
    pub fn name(&self) -> Cow<'static, str> {
        self.name.map_or_else(|| self.axis.label().into(), Cow::from)
    }
}

macro_rules! number {
    ($field:ident $(.$part:ident)?, $axis:ident $(, $name:literal)?) => {
        RobotNumber {
            key: concat!("robot.", stringify!($field) $(, ".", stringify!($part))?),
            axis: Axis::$axis,
            name: [$(Some($name),)? None][0],
            get: |robot| f64::from(robot.$field$(.$part)?),
        }
    };
}

/// All of them, in the order of a profile.
pub(crate) const ROBOT_NUMBERS: [RobotNumber; 14] = [
    number!(contact_friction, ContactFriction),
    number!(speed_gain.mean, SpeedGain),
    number!(speed_gain.robot_sd, Heterogeneity, "speed gain, sd between robots"),
    number!(speed_gain.step_sd, GainNoise, "speed gain, sd between steps"),
    number!(turn_gain.mean, TurnGain),
    number!(turn_gain.robot_sd, Heterogeneity, "turn gain, sd between robots"),
    number!(turn_gain.step_sd, GainNoise, "turn gain, sd between steps"),
    number!(turn_bias_sd_rad_s, TurnBias),
    number!(heading_noise_sd_rad, HeadingNoise),
    number!(gust_sd_m_s, Gust),
    number!(yaw_lag_s, YawLag),
    number!(true_positive, TruePositive),
    number!(false_positive, FalsePositive),
    number!(latency_steps, LatencySteps),
];
