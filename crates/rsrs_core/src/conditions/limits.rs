//! What a robot may be commanded.

use crate::help::Help;
use crate::quantity::Axis;
use crate::robot::controller::ControllerParameters;
use crate::robot::profile::RobotProfile;

/// A command beyond what a robot may be given.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "{axis} is {found}, beyond the robots' limits: expected {least} to {most} {}",
    axis.unit()
)]
pub struct BeyondLimits {
    /// The speed or the turning rate.
    pub axis: Axis,
    /// What was asked for, in the unit of the axis.
    pub found: f64,
    /// Least safe value, in the unit of the axis.
    pub least: f64,
    /// Greatest safe value, in the unit of the axis.
    pub most: f64,
}

impl Help for BeyondLimits {
    fn help(&self) -> Option<String> {
        let key = match self.axis {
            Axis::Speed | Axis::UndetectedSpeed => "actuation.speed.limits_m_s",
            _ => "actuation.turn.limits_rad_s",
        };
        Some(format!(
            "stay within the limits; if the robots were found to be safe beyond them, change `{key}` \
             in their profile"
        ))
    }
}

impl RobotProfile {
    /// Refuses a controller with a command beyond the limits, which the wheels of a robot refuse as well.
    ///
    /// Standing and going straight on are commands of every robot: 0 is within any limits.
    ///
    /// # Errors
    ///
    /// [`BeyondLimits`], of the speed first.
    pub fn check_limits(&self, controller: ControllerParameters) -> Result<(), BeyondLimits> {
        let (speed, turn) = (self.actuation.speed.limits_m_s, self.actuation.turn.limits_rad_s);
        let mut values = vec![
            (Axis::Speed, controller.speed_m_s, speed),
            (Axis::TurnRate, controller.turn_rate_rad_s, turn),
        ];
        if let Some(undetected) = controller.undetected {
            values.push((Axis::UndetectedSpeed, undetected.speed_m_s, speed));
            values.push((Axis::UndetectedTurnRate, undetected.turn_rate_rad_s, turn));
        }
        for (axis, found, [least, most]) in values {
            // A controller that is not mirrored may drive backward and turn to either side; the limits
            // are those of both directions, as at the wheels.
            let amount = if controller.undetected.is_some() { found.abs() } else { found };
            let is_within = amount >= least * (1.0 - SAME) && amount <= most * (1.0 + SAME);
            if !is_within && found != 0.0 {
                return Err(BeyondLimits { axis, found, least, most });
            }
        }
        Ok(())
    }
}

/// Numbers that differ by less than this share were the same before they were written; dimensionless.
const SAME: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    const FLOCKBOT: &str = include_str!("../../../../launch_configs/profiles/flockbot.yaml");

    #[test]
    fn what_a_robot_may_not_be_commanded_is_refused_with_its_limits() {
        let profile = RobotProfile::parse("flockbot.yaml", FLOCKBOT).unwrap();
        let check = |speed_m_s, turn_rate_rad_s| {
            let command = ControllerParameters::mirrored(speed_m_s, turn_rate_rad_s);
            profile.check_limits(command).map_err(|error| error.to_string())
        };

        assert_eq!(check(0.02, 0.1), Ok(()));
        assert_eq!(check(0.1 + 0.2, 2.5), Ok(()), "a rounding error is no excess");
        assert_eq!(check(0.0, 0.75), Ok(()), "a turn in place");
        assert_eq!(check(0.15, 0.0), Ok(()), "straight on");
        for (speed_m_s, turn_rate_rad_s, expected) in [
            (0.31, 0.75, "speed_m_s is 0.31, beyond the robots' limits: expected 0.02 to 0.3 m/s"),
            (0.01, 0.75, "speed_m_s is 0.01, beyond the robots' limits: expected 0.02 to 0.3 m/s"),
            (
                0.15,
                2.6,
                "turn_rate_rad_s is 2.6, beyond the robots' limits: expected 0.1 to 2.5 rad/s",
            ),
        ] {
            assert_eq!(check(speed_m_s, turn_rate_rad_s), Err(expected.to_owned()));
        }
        assert!(check(f64::NAN, 0.75).is_err());
    }
}
