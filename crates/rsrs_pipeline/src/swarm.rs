//! A swarm as the theory of mills has it.

use rsrs_core::conditions::Conditions;
use rsrs_core::diagram::theory::{Condition, Ring};
use rsrs_core::quantity::Axis;
use rsrs_core::robot::controller::ControllerParameters;

/// Radii of rings that differ by no more than this share are the same: steering once per period, noise
/// and misses change that of an ideal ring a little.
const SAME_RADIUS: f64 = 0.15;

/// Robots on a ring, their commands, and how far their wheels follow them.
#[derive(Clone, Copy, Debug)]
pub struct Swarm {
    /// The ring that they can form.
    pub ring: Ring,
    speed_m_s: f64,
    turn_rate_rad_s: f64,
    speed_gain: f64,
    turn_gain: f64,
}

impl Swarm {
    /// Robots under these conditions; `None` if the theory does not hold for them, see [`Ring::new`].
    pub fn new(conditions: &Conditions) -> Option<Self> {
        let Conditions { controller, robot, .. } = conditions;
        let ControllerParameters { speed_m_s, turn_rate_rad_s, .. } = controller.parameters()?;
        Some(Self {
            ring: Ring::new(conditions)?,
            speed_m_s,
            turn_rate_rad_s,
            speed_gain: robot.speed_gain.mean,
            turn_gain: robot.turn_gain.mean,
        })
    }

    /// The robots with another value on an axis. Theory does not depend on every axis.
    #[must_use]
    pub fn with(mut self, axis: Axis, value: f64) -> Self {
        match axis {
            Axis::Speed => self.speed_m_s = value,
            Axis::TurnRate => self.turn_rate_rad_s = value,
            Axis::Robots => self.ring.n_robots = value,
            Axis::Range => self.ring.range_m = value,
            Axis::HalfAngle => self.ring.half_angle_rad = value,
            Axis::TruePositive => self.ring.true_positive = value,
            Axis::FalsePositive => self.ring.false_positive = value,
            Axis::SpeedGain => self.speed_gain = value,
            Axis::TurnGain => self.turn_gain = value,
            _ => {}
        }
        self
    }

    /// Whether a condition holds; `None` where it has no meaning.
    pub fn meets(self, condition: Condition) -> Option<bool> {
        let (speed_m_s, turn_rate_rad_s) = self.delivered();
        condition.margin(&self.ring, speed_m_s, turn_rate_rad_s).map(|margin| margin > 0.0)
    }

    /// Whether a ring that was simulated is that of theory, by its radius in metres.
    pub fn is_ring(self, simulated_m: f64) -> bool {
        let (speed_m_s, turn_rate_rad_s) = self.delivered();
        let expected_m = self.ring.radius_m().map(|ring_m| ring_m.max(speed_m_s / turn_rate_rad_s));
        expected_m.is_some_and(|ring_m| (simulated_m / ring_m - 1.0).abs() <= SAME_RADIUS)
    }

    /// Share of the time in which robots on the ring turn towards its inside; `None` without a ring.
    pub fn turn_balance(self) -> Option<f64> {
        let (speed_m_s, turn_rate_rad_s) = self.delivered();
        self.ring.turn_balance(speed_m_s, turn_rate_rad_s)
    }

    /// Speed and turning rate that the wheels deliver.
    fn delivered(self) -> (f64, f64) {
        (self.speed_m_s * self.speed_gain, self.turn_rate_rad_s * self.turn_gain)
    }
}
