//! What the benchmarks run: the default world for any number of robots, and the loop that one would
//! write first, as the yardstick.
//!
//! `cargo bench -p rsrs_benches` runs everything; `--bench step n9` a part. Items are agent-steps,
//! so the item rate is agent-steps per second on one core. Compare within one run only: the same
//! program differs by a factor of two between machines and between minutes.

pub mod plain;

use rsrs_core::conditions::{Arena, Conditions, Placement, Walls};
use rsrs_core::robot::controller::ControllerParameters;
use rsrs_testing::conditions::flockbot_conditions;

/// Steps of a run of 300 s.
pub const STEPS: u64 = 2307;

/// Harsher Flockbots at the paper's best cell, as densely placed as nine are by default.
pub fn flockbots(robots: usize) -> Conditions {
    let radius_m = 0.825 * (robots as f64 / 9.0).sqrt();
    Conditions {
        robots,
        placement: Placement::DiscFacingOut { radius_m },
        arena: Arena { side_m: 15_f64.max(4.0 * radius_m), walls: Walls::Stop },
        ..flockbot_conditions()
    }
}

/// A grid of cells over speed and turning rate, 0.05 to 0.30 m/s and 0.25 to 2.00 rad/s.
pub fn diagram(n_per_axis: usize) -> Vec<Conditions> {
    let at = |index: usize, from: f64, to: f64| {
        from + (to - from) * index as f64 / (n_per_axis - 1).max(1) as f64
    };
    (0..n_per_axis * n_per_axis)
        .map(|cell| {
            let speed_m_s = at(cell % n_per_axis, 0.05, 0.30);
            let turn_rate_rad_s = at(cell / n_per_axis, 0.25, 2.00);
            let controller = ControllerParameters::mirrored(speed_m_s, turn_rate_rad_s).into();
            Conditions { controller, ..flockbots(9) }
        })
        .collect()
}
