//! Two wheels, and how fast they must turn for a command.

use serde::{Deserialize, Serialize};

use crate::numerals::SAME;
use crate::robot::controller::Command;

/// The wheels of a differential drive, side by side about the centre of the body.
///
/// A robot that turns while it drives asks more of its outer wheel than either command by itself.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Wheels {
    /// Distance of the two wheels, in metres.
    pub base_m: f64,
    /// Greatest speed of a wheel over the floor, forward and backward, in metres per second.
    pub speed_max_m_s: f64,
}

impl Wheels {
    /// Speed of the faster wheel for a command, in metres per second: `|v| + |ω| b / 2`.
    pub fn asked_m_s(&self, command: Command) -> f64 {
        command.speed_m_s.abs() + command.turn_rate_rad_s.abs() * self.base_m / 2.0
    }

    /// The command of a robot whose wheels drive with these speeds, in metres per second.
    pub fn command(&self, left_m_s: f64, right_m_s: f64) -> Command {
        Command {
            speed_m_s: f64::midpoint(left_m_s, right_m_s),
            turn_rate_rad_s: (right_m_s - left_m_s) / self.base_m,
        }
    }

    /// Speeds of the left and the right wheel for a command, in metres per second.
    pub fn speeds_m_s(&self, command: Command) -> [f64; 2] {
        let turn_m_s = command.turn_rate_rad_s * self.base_m / 2.0;
        [command.speed_m_s - turn_m_s, command.speed_m_s + turn_m_s]
    }

    /// Whether both wheels can do what a command asks of them.
    pub fn can(&self, command: Command) -> bool {
        self.asked_m_s(command) <= self.speed_max_m_s * (1.0 + SAME)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const E_PUCK: Wheels = Wheels { base_m: 0.051, speed_max_m_s: 0.128 };

    fn command(speed_m_s: f64, turn_rate_rad_s: f64) -> Command {
        Command { speed_m_s, turn_rate_rad_s }
    }

    #[test]
    fn the_outer_wheel_is_asked_for_more_than_either_command() {
        // Both wheels at full speed, one of them, and a turn in place.
        for (left, right) in [(1.0, 1.0), (0.3, -1.0), (-0.7, -1.0), (1.0, -1.0)] {
            let command = E_PUCK.command(0.128 * left, 0.128 * right);

            let asked_m_s = E_PUCK.asked_m_s(command);

            assert!((asked_m_s - 0.128).abs() < 1e-12, "{left} {right}: {asked_m_s}");
            assert!(E_PUCK.can(command));
            assert!(!E_PUCK.can(E_PUCK.command(1.01 * 0.128 * left, 1.01 * 0.128 * right)));
        }
    }

    #[test]
    fn what_is_no_number_is_beyond_all_wheels() {
        assert!(!E_PUCK.can(command(f64::NAN, 0.0)));
        assert!(!E_PUCK.can(command(0.0, f64::INFINITY)));
    }
}
