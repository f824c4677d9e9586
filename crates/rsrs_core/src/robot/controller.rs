//! The controller of the paper, written once: the sweep, the dry run and the robot call this.

use serde::{Deserialize, Serialize};

use crate::digest::Digest;

/// What the operator sets on every robot: the swept plane of the phase diagram.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControllerParameters {
    /// Forward speed `v`, in metres per second; not negative.
    pub speed_m_s: f64,
    /// Turning rate `ω`, in radians per second; not negative.
    pub turn_rate_rad_s: f64,
}

impl ControllerParameters {
    /// Names these parameters in leases and statuses: a robot moves only under the digest that the
    /// runner confirmed.
    pub fn digest(&self) -> u64 {
        self.digest_with(Reaction::ToDetections)
    }

    /// [`Self::digest`] for a controller with a reaction: one that is left on a constant command is
    /// never taken for one that decides.
    pub fn digest_with(&self, reaction: Reaction) -> u64 {
        let mut digest = Digest::new(match reaction {
            Reaction::ToDetections => "controller_parameters",
            Reaction::Constant => "constant_command",
        });
        digest.number(self.speed_m_s);
        digest.number(self.turn_rate_rad_s);
        digest.value()
    }
}

/// What a controller makes of its sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reaction {
    /// It decides by what is detected.
    ToDetections,
    /// Every detection is a beat, and something is always seen: the command is constant.
    Constant,
}

/// A velocity command `u`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Command {
    /// Forward speed `u₁`, in metres per second.
    pub speed_m_s: f64,
    /// Turning rate `u₂`, in radians per second; positive is counterclockwise (REP 103).
    pub turn_rate_rad_s: f64,
}

impl Command {
    /// Stand still.
    pub const STOP: Self = Self { speed_m_s: 0.0, turn_rate_rad_s: 0.0 };
}

/// Decides the command from the binary detection: turn one way if something is seen, the other way
/// if not.
///
/// # Arguments
///
/// * `detected` — the sensor's output `y`.
/// * `parameters` — `v` and `ω`.
///
/// # Returns
///
/// Forward at `v`, turning counterclockwise at `ω` if something is detected, clockwise otherwise.
///
/// # Source
///
/// `eq:controller`, §IV step 3; the turning sense is that of `fig:milling_figure`.
///
/// # Example
///
/// ```
/// use rsrs_core::robot::controller::{ControllerParameters, decide};
///
/// let best = ControllerParameters { speed_m_s: 0.15, turn_rate_rad_s: 0.75 };
/// assert_eq!(decide(true, best).turn_rate_rad_s, 0.75);
/// assert_eq!(decide(false, best).turn_rate_rad_s, -0.75);
/// ```
#[expect(clippy::fn_params_excessive_bools, reason = "binary is what the sensor is")]
pub fn decide(detected: bool, parameters: ControllerParameters) -> Command {
    let turn_rate_rad_s =
        if detected { parameters.turn_rate_rad_s } else { -parameters.turn_rate_rad_s };
    Command { speed_m_s: parameters.speed_m_s, turn_rate_rad_s }
}
