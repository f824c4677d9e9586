//! The unicycle: a pose, and how one command moves it.

use std::f64::consts::{PI, TAU};

use serde::{Deserialize, Serialize};

use crate::robot::controller::Command;

/// Position and heading of one robot: the state `z` of the paper.
///
/// Right-handed, z up, positive turn counterclockwise (REP 103).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Pose {
    /// `z₁`, in metres.
    pub x_m: f64,
    /// `z₂`, in metres.
    pub y_m: f64,
    /// `z₃`, in radians; any number of turns.
    pub heading_rad: f64,
}

impl Pose {
    /// The pose a share of the way, from 0 to 1, to the next one: on a straight line, and turned the short
    /// way.
    #[must_use]
    pub fn between(self, next: Self, share: f64) -> Self {
        let turn_rad = within_half_a_turn(next.heading_rad - self.heading_rad);
        Self { heading_rad: self.heading_rad + turn_rad * share, ..self.mixed(next, share) }
    }

    /// As [`Pose::between`], but turned as the headings say, which count turns.
    #[must_use]
    pub fn mixed(self, next: Self, share: f64) -> Self {
        let mix = |from: f64, to: f64| from + (to - from) * share;
        Self {
            x_m: mix(self.x_m, next.x_m),
            y_m: mix(self.y_m, next.y_m),
            heading_rad: mix(self.heading_rad, next.heading_rad),
        }
    }

    /// The pose in the frame of another: x ahead of it, y to its left, the heading as it differs.
    #[must_use]
    pub fn relative_to(self, frame: Self) -> Self {
        let (sine, cosine) = libm::sincos(frame.heading_rad);
        let (dx_m, dy_m) = (self.x_m - frame.x_m, self.y_m - frame.y_m);
        Self {
            x_m: dx_m * cosine + dy_m * sine,
            y_m: dy_m * cosine - dx_m * sine,
            heading_rad: self.heading_rad - frame.heading_rad,
        }
    }

    /// Where a place in the frame of this pose, ahead and to the left in metres, is in the frame in which the
    /// pose is given.
    pub fn place_m(self, [ahead_m, left_m]: [f64; 2]) -> [f64; 2] {
        let (sine, cosine) = libm::sincos(self.heading_rad);
        [
            self.x_m + (ahead_m * cosine - left_m * sine),
            self.y_m + (ahead_m * sine + left_m * cosine),
        ]
    }
}

/// The same angle, in radians, from -π to below π.
pub fn within_half_a_turn(angle_rad: f64) -> f64 {
    let wrapped = angle_rad - TAU * libm::floor((angle_rad + PI) / TAU);
    if wrapped >= PI { wrapped - TAU } else { wrapped }
}

/// Actuation gains `(θᵃ₁, θᵃ₂)` of one robot: what it delivers over what it is asked; dimensionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActuationGain {
    /// `θᵃ₁`, of the forward speed.
    pub speed: f64,
    /// `θᵃ₂`, of the turning rate.
    pub turn: f64,
}

impl ActuationGain {
    /// A robot that delivers exactly what it is asked.
    pub const PERFECT: Self = Self { speed: 1.0, turn: 1.0 };
}

/// Moves one robot by one control period `Δt`, from `z(ℓ)` to `z(ℓ+1)` by the command `u(ℓ)` with
/// the gain `θᵃ`, free of noise and contact.
///
/// The position moves along the heading that held *before* the turn. This is the analytic form in
/// double precision; the simulator's world is its own definition in single precision and is held
/// against this one.
///
/// # Source
///
/// `eq:disc_kine` with `eq:disc_func`, §IV step 2.
pub fn step(pose: Pose, command: Command, gain: ActuationGain, period_s: f64) -> Pose {
    let (sine, cosine) = libm::sincos(pose.heading_rad);
    let speed_m_s = command.speed_m_s * gain.speed;
    Pose {
        x_m: pose.x_m + speed_m_s * cosine * period_s,
        y_m: pose.y_m + speed_m_s * sine * period_s,
        heading_rad: pose.heading_rad + command.turn_rate_rad_s * gain.turn * period_s,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_wrapped_to_half_a_turn() {
        for (angle_rad, expected_rad) in [(0.0, 0.0), (4.0, 4.0 - TAU), (-4.0, TAU - 4.0)] {
            assert!((within_half_a_turn(angle_rad) - expected_rad).abs() < 1e-12, "{angle_rad}");
        }
    }

    #[test]
    fn the_position_moves_along_the_heading_before_the_turn() {
        let command = Command { speed_m_s: 0.15, turn_rate_rad_s: 0.75 };

        let next = step(Pose::default(), command, ActuationGain { speed: 0.97, turn: 1.0 }, 0.13);

        assert!((next.x_m - 0.15 * 0.97 * 0.13).abs() < 1e-15);
        assert!(next.y_m.abs() < 1e-15);
        assert!((next.heading_rad - 0.0975).abs() < 1e-15);
    }
}
