//! Cells of nine Flockbots in which every phase occurs.

use rsrs_core::conditions::{Conditions, Settings};
use rsrs_core::quantity::Axis;
use rsrs_core::robot::profile::RobotProfile;

/// Speed (m/s), turning rate (rad/s), placement radius (m), probability to see.
pub const CELLS: [[f64; 4]; 8] = [
    [0.15, 0.75, 0.60, 0.98],
    [0.15, 0.75, 0.60, 0.80],
    [0.30, 0.75, 0.60, 0.80],
    [0.15, 0.25, 0.60, 0.80],
    [0.30, 0.25, 0.60, 0.80],
    [0.05, 0.25, 0.60, 0.80],
    [0.20, 1.25, 0.90, 0.80],
    [0.10, 0.75, 0.90, 0.80],
];

/// The robot.
pub fn flockbot() -> RobotProfile {
    rsrs_testing::conditions::flockbot()
}

/// What a cell stands for.
pub fn conditions(cell: [f64; 4]) -> Conditions {
    let [speed, turn_rate, placement_radius, true_positive] = cell;
    let values = vec![
        (Axis::Speed, speed),
        (Axis::TurnRate, turn_rate),
        (Axis::Robots, 9.0),
        (Axis::PlacementRadius, placement_radius),
        (Axis::TruePositive, true_positive),
    ];
    Conditions::resolve(&flockbot(), &Settings { values, ..Settings::default() })
        .expect("the cell is possible")
}
