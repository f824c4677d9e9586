//! How many robots can mill.

use std::ops::RangeInclusive;

use rsrs_core::conditions::{Conditions, Placement, Region};
use rsrs_core::theory::Ring;

use crate::support::{n_milling, perfect_flockbots};

const REPLICATES: u64 = 8;

/// Robots without noise that see as far as those of the GMU simulator, and steer so often that it
/// does not widen the cone.
fn far_sighted(robots: usize) -> Conditions {
    let mut conditions = perfect_flockbots();
    conditions.robots = robots;
    conditions.period_s = 0.01;
    conditions.arena.side_m = 100.0;
    conditions.robot.region = Region::Cone { half_angle_rad: 0.2, range_m: 3.6 };
    conditions
}

/// Holds so many robots against geometry.
fn check(
    robots: RangeInclusive<usize>,
    duration_s: f64,
    (speed_m_s, turn_rate_rad_s, radius_m): (f64, f64, f64),
) {
    let cells: Vec<Conditions> = robots
        .map(|robots| {
            let mut conditions = far_sighted(robots);
            conditions.controller.speed_m_s = speed_m_s;
            conditions.controller.turn_rate_rad_s = turn_rate_rad_s;
            conditions.placement = Placement::DiscFacingOut { radius_m };
            conditions
        })
        .collect();

    let counts = n_milling(&cells, REPLICATES, duration_s);

    for (cell, n_milling) in cells.iter().zip(counts) {
        let exists = Ring::of(cell).expect("robots with a cone see bodies").exists();
        assert_eq!(exists, (5..=14).contains(&cell.robots));
        // A start may lead to two rings in place of one.
        let is_right = if exists { n_milling >= REPLICATES - 2 } else { n_milling == 0 };
        assert!(is_right, "{} robots: {n_milling} of {REPLICATES} mill", cell.robots);
    }
}

#[test]
fn five_robots_mill_and_four_run_into_each_other() {
    // A tight turn: else robots circle, each for itself, wider than their ring would be.
    check(3..=8, 600.0, (0.15, 1.5, 0.9));
}

#[test]
fn fourteen_robots_mill_and_fifteen_grow_out_of_sight() {
    // Fast, as the ring of fourteen is 7 m wide and that of fifteen would be 19 m.
    check(9..=16, 3000.0, (0.3, 0.75, 1.5));
}
