//! How many robots can mill.

use std::ops::RangeInclusive;

use rsrs_core::conditions::{Conditions, Placement};
use rsrs_core::diagram::theory::Ring;
use rsrs_core::judge::phase::{Phase, Verdict};
use rsrs_core::robot::controller::ControllerParameters;
use rsrs_core::robot::region::Region;
use rsrs_sim::batch::Batch;

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

/// Robots that drive and turn at these rates, from a disc of this radius.
fn driving(robots: usize, (speed_m_s, turn_rate_rad_s, radius_m): (f64, f64, f64)) -> Conditions {
    let mut conditions = far_sighted(robots);
    conditions.controller = ControllerParameters::mirrored(speed_m_s, turn_rate_rad_s).into();
    conditions.placement = Placement::DiscFacingOut { radius_m };
    conditions
}

/// Holds so many robots against geometry.
fn check(robots: RangeInclusive<usize>, duration_s: f64, how: (f64, f64, f64)) {
    let cells: Vec<Conditions> = robots.map(|robots| driving(robots, how)).collect();

    let counts = n_milling(&cells, REPLICATES, duration_s);

    for (cell, n_milling) in cells.iter().zip(counts) {
        let exists = Ring::new(cell).expect("robots with a cone see bodies").exists();
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
fn fourteen_robots_mill_on_the_ring_of_geometry_and_fifteen_at_the_end_of_their_reach() {
    // Fast, as the ring of fourteen is 14 m wide.
    let cells: Vec<Conditions> = (9..=16).map(|robots| driving(robots, (0.3, 0.75, 1.5))).collect();

    for cell in &cells {
        let ring = Ring::new(cell).expect("robots with a cone see bodies");
        let reach_m = cell.bodies().reach_m.expect("their sensor is known");
        // From fifteen on the ring would be wider than they see: it grows until each only just sees
        // the next.
        let chord_m = ring.chord_m().map_or(reach_m, |chord_m| chord_m.min(reach_m));
        let angle_rad = std::f64::consts::PI / cell.robots as f64;
        assert_eq!(ring.exists(), cell.robots <= 14);

        let judged = Batch::new().judge(cell, 1, 0..REPLICATES, 3000.0).expect("fit and long");

        let is_mill = |judged: &&Verdict| judged.phase == Phase::STABLE_MILLING;
        let mills: Vec<&Verdict> = judged.iter().filter(is_mill).collect();
        // A start may lead to two rings in place of one.
        assert!(mills.len() as u64 >= REPLICATES - 2, "{} robots: {judged:?}", cell.robots);
        for mill in mills {
            let found_m = 2.0 * mill.evidence.mean_radius_m * libm::sin(angle_rad);
            // Steering once per period widens the ring a little.
            assert!((found_m / chord_m - 1.0).abs() < 0.05, "{}: {found_m}", cell.robots);
        }
    }
}
