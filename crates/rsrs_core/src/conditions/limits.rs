//! What a robot may be commanded.

use crate::help::Help;
use crate::numerals::{SAME, rounded};
use crate::quantity::Axis;
use crate::robot::controller::{Command, Controller, ControllerParameters};
use crate::robot::profile::{Actuation, RobotProfile};
use crate::robot::wheels::Wheels;

/// A command beyond what a robot may be given.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BeyondLimits {
    /// A speed or a turning rate.
    #[error(
        "{axis} is {}, beyond the robots' limits: expected {least} to {most} {}",
        rounded(*found), axis.unit()
    )]
    Command {
        /// The speed or the turning rate.
        axis: Axis,
        /// What was asked for, in the unit of the axis.
        found: f64,
        /// Least safe value, in the unit of the axis.
        least: f64,
        /// Greatest safe value, in the unit of the axis.
        most: f64,
    },
    /// Both together, of a wheel.
    #[error(
        "{} m/s at {} rad/s ask {:.3} m/s of a wheel, beyond the robots' wheels: expected at most {} m/s, \
         {} m apart",
        rounded(command.speed_m_s), rounded(command.turn_rate_rad_s), wheels.asked_m_s(*command),
        wheels.speed_max_m_s, wheels.base_m
    )]
    Wheels {
        /// What was asked for.
        command: Command,
        /// The robots' wheels.
        wheels: Wheels,
    },
}

impl Help for BeyondLimits {
    fn help(&self) -> Option<String> {
        Some(match self {
            Self::Command { axis, .. } => {
                let key = match axis {
                    Axis::Speed | Axis::UndetectedSpeed => "actuation.speed.limits_m_s",
                    _ => "actuation.turn.limits_rad_s",
                };
                format!(
                    "stay within the limits; if the robots were found to be safe beyond them, change \
                     `{key}` in their profile"
                )
            }
            Self::Wheels { .. } => "turn or drive slower: in a sweep, name the cells that the wheels can \
                                    do under `cells`; the wheels are `actuation.wheels` in the profile"
                .to_owned(),
        })
    }
}

impl RobotProfile {
    /// Refuses a controller with a command beyond the limits of speed and turning rate, or of the wheels.
    ///
    /// Standing and going straight on are commands of every robot: 0 is within any limits.
    pub fn check_limits(&self, controller: &Controller) -> Result<(), BeyondLimits> {
        let parameters = controller.parameters();
        // A mirrored controller drives forward, and its other command is within the limits if this one is.
        if let Some(mirrored) = parameters.filter(|parameters| parameters.undetected.is_none()) {
            let ControllerParameters { speed_m_s, turn_rate_rad_s, .. } = mirrored;
            self.check_amounts([(Axis::Speed, speed_m_s), (Axis::TurnRate, turn_rate_rad_s)])?;
            return self.check_wheels(controller);
        }
        for (index, command) in controller.commands().into_iter().enumerate() {
            let axes = match (parameters, index) {
                (Some(_), 1) => [Axis::UndetectedSpeed, Axis::UndetectedTurnRate],
                _ => [Axis::Speed, Axis::TurnRate],
            };
            self.check_either_way(command, axes)?;
        }
        self.check_wheels(controller)
    }

    /// [`Self::check_limits`] of one command of a controller that is not mirrored.
    pub fn check_command(&self, command: Command) -> Result<(), BeyondLimits> {
        self.check_either_way(command, [Axis::Speed, Axis::TurnRate])?;
        self.can_wheels(command)
    }

    /// Who is not mirrored may drive backward and turn to either side; the limits are those of both
    /// directions, as at the wheels.
    fn check_either_way(&self, command: Command, axes: [Axis; 2]) -> Result<(), BeyondLimits> {
        let [speed, turn] = axes;
        let amounts = [(speed, command.speed_m_s), (turn, command.turn_rate_rad_s)];
        self.check_amounts(amounts.map(|(axis, found)| (axis, found.abs()))).map_err(|error| {
            // What was asked for has its sign.
            match error {
                BeyondLimits::Command { axis, least, most, .. } => {
                    let asked =
                        if axis == speed { command.speed_m_s } else { command.turn_rate_rad_s };
                    BeyondLimits::Command { axis, found: asked, least, most }
                }
                wheels @ BeyondLimits::Wheels { .. } => wheels,
            }
        })
    }

    fn check_amounts(&self, [speed, turn]: [(Axis, f64); 2]) -> Result<(), BeyondLimits> {
        let Actuation { speed: drive, turn: steering, .. } = &self.actuation;
        for ((axis, found), [least, most]) in
            [(speed, drive.limits_m_s), (turn, steering.limits_rad_s)]
        {
            let is_within = found >= least * (1.0 - SAME) && found <= most * (1.0 + SAME);
            if !is_within && found != 0.0 {
                return Err(BeyondLimits::Command { axis, found, least, most });
            }
        }
        Ok(())
    }

    /// Refuses a controller with a command that asks more of a wheel than it can do.
    pub fn check_wheels(&self, controller: &Controller) -> Result<(), BeyondLimits> {
        controller.commands().into_iter().try_for_each(|command| self.can_wheels(command))
    }

    fn can_wheels(&self, command: Command) -> Result<(), BeyondLimits> {
        match self.actuation.wheels {
            Some(wheels) if !wheels.can(command) => Err(BeyondLimits::Wheels { command, wheels }),
            _ => Ok(()),
        }
    }
}

/// Between which commands somebody else than a controller of ours may choose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CommandRange {
    /// Least and greatest speed, in metres per second.
    pub speed_m_s: [f64; 2],
    /// Least and greatest turning rate, in radians per second.
    pub turn_rate_rad_s: [f64; 2],
    /// What the robots' wheels can do, if that is known.
    pub wheels: Option<Wheels>,
}

impl CommandRange {
    /// What a robot may be commanded: from standing still to its greatest speed, turning to either side.
    pub fn new(profile: &RobotProfile) -> Self {
        let ([_, speed], [_, turn]) =
            (profile.actuation.speed.limits_m_s, profile.actuation.turn.limits_rad_s);
        Self {
            speed_m_s: [0.0, speed],
            turn_rate_rad_s: [-turn, turn],
            wheels: profile.actuation.wheels,
        }
    }

    /// A command, each number of it moved into its range; what is too fast for a wheel is the same circle,
    /// driven slower.
    pub fn nearest(&self, command: Command) -> Command {
        let within = |number: f64, [least, most]: [f64; 2]| number.max(least).min(most);
        let speed_m_s = within(command.speed_m_s, self.speed_m_s);
        let turn_rate_rad_s = within(command.turn_rate_rad_s, self.turn_rate_rad_s);
        let command = Command { speed_m_s, turn_rate_rad_s };
        match self.wheels {
            Some(wheels) if !wheels.can(command) => {
                let share = wheels.speed_max_m_s / wheels.asked_m_s(command);
                Command { speed_m_s: speed_m_s * share, turn_rate_rad_s: turn_rate_rad_s * share }
            }
            _ => command,
        }
    }

    /// The greatest command to either side.
    pub fn most(&self) -> Command {
        let most = |[least, most]: [f64; 2]| least.abs().max(most.abs());
        Command { speed_m_s: most(self.speed_m_s), turn_rate_rad_s: most(self.turn_rate_rad_s) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use rsrs_testing::conditions::FLOCKBOT;

    #[test]
    fn a_command_from_outside_is_moved_into_the_range_and_within_the_wheels() {
        let mut profile = RobotProfile::parse("flockbot.yaml", FLOCKBOT).unwrap();
        let command = |speed_m_s, turn_rate_rad_s| Command { speed_m_s, turn_rate_rad_s };
        let range = CommandRange::new(&profile);

        assert_eq!(range.nearest(command(-1.0, 9.0)), command(0.0, range.turn_rate_rad_s[1]));
        assert_eq!(range.nearest(command(0.1, -0.5)), command(0.1, -0.5));
        assert_eq!(range.most(), command(range.speed_m_s[1], range.turn_rate_rad_s[1]));

        let wheels = Wheels { base_m: 0.1, speed_max_m_s: 0.1 };
        profile.actuation.wheels = Some(wheels);
        let slower = CommandRange::new(&profile).nearest(command(0.2, 2.0));
        assert!(wheels.can(slower), "{slower:?}");
        assert!((slower.speed_m_s / slower.turn_rate_rad_s - 0.1).abs() < 1e-12, "{slower:?}");
    }

    #[test]
    fn what_a_robot_may_not_be_commanded_is_refused_with_its_limits() {
        let profile = RobotProfile::parse("flockbot.yaml", FLOCKBOT).unwrap();
        let check = |speed_m_s, turn_rate_rad_s| {
            let command = ControllerParameters::mirrored(speed_m_s, turn_rate_rad_s);
            profile.check_limits(&command.into()).map_err(|error| error.to_string())
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

    #[test]
    fn what_both_commands_ask_of_a_wheel_is_refused_with_the_wheels() {
        let text = FLOCKBOT
            .replace("actuation:", "actuation:\n  wheels: {base_m: 0.12, speed_max_m_s: 0.3}");
        let profile = RobotProfile::parse("flockbot.yaml", &text).unwrap();
        let without = RobotProfile::parse("flockbot.yaml", FLOCKBOT).unwrap();
        let corner = ControllerParameters::mirrored(0.3, 2.0);

        assert_eq!(without.check_limits(&corner.into()), Ok(()));
        assert_eq!(profile.check_limits(&ControllerParameters::mirrored(0.18, 2.0).into()), Ok(()));
        let error = profile.check_limits(&corner.into()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "0.3 m/s at 2 rad/s ask 0.420 m/s of a wheel, beyond the robots' wheels: expected at most 0.3 \
             m/s, 0.12 m apart"
        );
        assert!(error.help().unwrap().contains("`actuation.wheels`"));
        let backward = Command { speed_m_s: -0.3, turn_rate_rad_s: -1.0 };
        let either = ControllerParameters::new(Command::STOP, backward);
        assert!(profile.check_limits(&either.into()).is_err(), "of both commands");
        assert_ne!(profile.digest(), without.digest());
    }
}
