//! What a robot's wheels may be asked to do, and how fast they may come to do it.

use std::time::Duration;

use rsrs_core::robot::controller::Command;
use rsrs_core::robot::wheels::Wheels;

/// The most that a robot may be asked to do; all finite, none negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Greatest forward or backward speed, in metres per second.
    pub speed_m_s: f64,
    /// Greatest turning rate to either side, in radians per second.
    pub turn_rate_rad_s: f64,
    /// What its wheels can do together, if that is known.
    pub wheels: Option<Wheels>,
    /// Greatest growth of the speed, in metres per second squared; stopping is not held back.
    pub acceleration_m_s2: f64,
    /// Greatest growth of the turning rate, in radians per second squared.
    pub turn_acceleration_rad_s2: f64,
}

/// A velocity command that a robot cannot follow.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "velocity command ({} m/s, {} rad/s), expected at most {} m/s and {} rad/s{}",
    found.speed_m_s, found.turn_rate_rad_s, limits.speed_m_s, limits.turn_rate_rad_s,
    limits.wheels.map_or_else(String::new, |wheels| {
        format!(", and {} m/s of a wheel, {} m apart", wheels.speed_max_m_s, wheels.base_m)
    })
)]
pub struct BeyondLimits {
    /// The command.
    pub found: Command,
    /// What it may be.
    pub limits: Limits,
}

/// A command read from a decimal text may differ from its limit by rounding.
const ROUNDING: f64 = 1e-9;

impl Limits {
    /// Whether the robot can follow a command; one that is not a number is refused, too.
    ///
    /// A command beyond the limits is refused and not cut down to them: speed over turning rate is
    /// the radius of the circle, so that a robot that follows half of a command does another
    /// experiment unnoticed.
    pub fn check(&self, command: Command) -> Result<(), BeyondLimits> {
        let fits = |value: f64, most: f64| value.abs() <= most * (1.0 + ROUNDING);
        if fits(command.speed_m_s, self.speed_m_s)
            && fits(command.turn_rate_rad_s, self.turn_rate_rad_s)
            && self.wheels.is_none_or(|wheels| wheels.can(command))
        {
            Ok(())
        } else {
            Err(BeyondLimits { found: command, limits: *self })
        }
    }
}

/// Brings the wheels to a command no faster than the limits allow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    now: Command,
    at: Duration,
}

/// The longest time that one step of the ramp makes up for: after a stall, wheels do not jump.
const LONGEST_STEP: Duration = Duration::from_millis(100);

impl Ramp {
    /// Wheels that stand.
    pub fn standing(at: Duration) -> Self {
        Self { now: Command::STOP, at }
    }

    /// The command that the wheels get at `now`, which is never before the last call's, on the way to
    /// what the gate lets through.
    ///
    /// Speeds grow no faster than the limits allow; they fall, and change their sign up to zero, at
    /// once, because a stop is never held back.
    pub fn toward(&mut self, wanted: Command, limits: &Limits, now: Duration) -> Command {
        let step_s = now.saturating_sub(self.at).min(LONGEST_STEP).as_secs_f64();
        self.at = now;
        self.now = Command {
            speed_m_s: approach(
                self.now.speed_m_s,
                wanted.speed_m_s,
                limits.acceleration_m_s2 * step_s,
            ),
            turn_rate_rad_s: approach(
                self.now.turn_rate_rad_s,
                wanted.turn_rate_rad_s,
                limits.turn_acceleration_rad_s2 * step_s,
            ),
        };
        self.now
    }
}

/// From `from` to `to`, growing by at most `most`.
fn approach(from: f64, to: f64, most: f64) -> f64 {
    let start = if from * to > 0.0 { from.abs() } else { 0.0 };
    to.abs().min(start + most).copysign(to)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits {
        speed_m_s: 0.3,
        turn_rate_rad_s: 2.5,
        wheels: None,
        acceleration_m_s2: 1.0,
        turn_acceleration_rad_s2: 10.0,
    };

    fn command(speed_m_s: f64, turn_rate_rad_s: f64) -> Command {
        Command { speed_m_s, turn_rate_rad_s }
    }

    fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    #[test]
    fn commands_up_to_the_limits_are_followed_and_no_others() {
        for allowed in [command(0.3, -2.5), command(-0.3, 2.5), Command::STOP] {
            assert_eq!(LIMITS.check(allowed), Ok(()));
        }
        for refused in [
            command(0.31, 0.0),
            command(0.0, -2.6),
            command(f64::NAN, 0.0),
            command(0.0, f64::INFINITY),
            command(1e300, 0.0),
        ] {
            assert!(LIMITS.check(refused).is_err(), "{refused:?}");
        }
        assert_eq!(
            LIMITS.check(command(3.0, 0.5)).unwrap_err().to_string(),
            "velocity command (3 m/s, 0.5 rad/s), expected at most 0.3 m/s and 2.5 rad/s"
        );
    }

    #[test]
    fn what_is_too_fast_for_a_wheel_is_refused_though_each_command_is_allowed() {
        let wheels = Some(Wheels { base_m: 0.12, speed_max_m_s: 0.3 });
        let limits = Limits { wheels, ..LIMITS };

        for allowed in [command(0.3, 0.0), command(-0.18, 2.0), command(0.0, -2.5)] {
            assert_eq!(limits.check(allowed), Ok(()));
        }
        let error = limits.check(command(0.3, 2.0)).unwrap_err();
        assert_eq!(
            error.to_string(),
            "velocity command (0.3 m/s, 2 rad/s), expected at most 0.3 m/s and 2.5 rad/s, and 0.3 m/s of \
             a wheel, 0.12 m apart"
        );
    }

    #[test]
    fn speeds_grow_with_the_acceleration_and_reach_the_command() {
        let mut ramp = Ramp::standing(ms(0));

        let first = ramp.toward(command(0.15, 0.0), &LIMITS, ms(50));
        let last = ramp.toward(command(0.15, 0.0), &LIMITS, ms(150));

        assert!((first.speed_m_s - 0.05).abs() < 1e-12, "{first:?}");
        assert_eq!(last, command(0.15, 0.0));
    }

    #[test]
    fn a_stop_is_not_held_back() {
        let mut ramp = Ramp::standing(ms(0));
        ramp.toward(command(0.1, 0.75), &LIMITS, ms(100));

        assert_eq!(ramp.toward(Command::STOP, &LIMITS, ms(100)), Command::STOP);
    }

    #[test]
    fn a_turn_to_the_other_side_starts_from_zero() {
        let mut ramp = Ramp::standing(ms(0));
        ramp.toward(command(0.0, 0.75), &LIMITS, ms(100));

        let turned = ramp.toward(command(0.0, -0.75), &LIMITS, ms(110));

        assert!((turned.turn_rate_rad_s + 0.1).abs() < 1e-12, "{turned:?}");
    }

    #[test]
    fn after_a_stall_the_wheels_do_not_jump() {
        let mut ramp = Ramp::standing(ms(0));

        let after = ramp.toward(command(0.3, 0.0), &LIMITS, ms(10_000));

        assert!((after.speed_m_s - 0.1).abs() < 1e-12, "{after:?}");
    }
}
