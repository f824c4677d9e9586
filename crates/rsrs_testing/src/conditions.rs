//! Conditions that tests and benchmarks share: nine harsher Flockbots at (0.15 m/s, 0.75 rad/s).

use rsrs_core::conditions::Conditions;

/// Nine harsher Flockbots: detection 0.80, false positives 0.08, gain sd 0.05.
pub fn flockbot_conditions() -> Conditions {
    Conditions::flockbots(9)
}
