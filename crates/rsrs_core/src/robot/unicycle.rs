//! The unicycle: a pose, and how one command moves it.

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

/// Moves one robot by one control period, free of noise and contact.
///
/// The position moves along the heading that held *before* the turn. This is the analytic form in
/// double precision; the simulator's world is its own definition in single precision and is held
/// against this one.
///
/// # Arguments
///
/// * `pose` — `z(ℓ)`.
/// * `command` — `u(ℓ)`.
/// * `gain` — `θᵃ`.
/// * `period_s` — `Δt`, in seconds.
///
/// # Returns
///
/// `z(ℓ+1)`.
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
    fn the_position_moves_along_the_heading_before_the_turn() {
        let command = Command { speed_m_s: 0.15, turn_rate_rad_s: 0.75 };

        let next = step(Pose::default(), command, ActuationGain { speed: 0.97, turn: 1.0 }, 0.13);

        assert!((next.x_m - 0.15 * 0.97 * 0.13).abs() < 1e-15);
        assert!(next.y_m.abs() < 1e-15);
        assert!((next.heading_rad - 0.0975).abs() < 1e-15);
    }
}
