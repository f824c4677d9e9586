//! A controller of other authors, with their numbers, does here what it is known for.

use rsrs_core::conditions::{Conditions, Placement};
use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::phase::Phase;
use rsrs_core::robot::controller::{Command, ControllerParameters};
use rsrs_core::robot::region::Region;

use crate::support::{count, perfect_flockbots};

const REPLICATES: u64 = 32;
/// Speed of a wheel at most, in metres per second, and distance of the wheels, in metres.
const WHEEL_M_S: f64 = 0.15;
const AXLE_M: f64 = 0.12;

/// What a robot on two wheels does when these turn at shares of their greatest speed.
fn wheels(left: f64, right: f64) -> Command {
    Command {
        speed_m_s: WHEEL_M_S * f64::midpoint(left, right),
        turn_rate_rad_s: WHEEL_M_S * (right - left) / AXLE_M,
    }
}

/// Robots that see far along a line.
fn line_of_sight(robots: usize, controller: ControllerParameters) -> Conditions {
    let mut conditions = perfect_flockbots();
    conditions.robots = robots;
    conditions.controller = controller;
    conditions.behaviour = Behaviour::Aggregation;
    conditions.robot.region = Region::Cone { half_angle_rad: 0.02, range_m: 4.0 };
    conditions.placement = Placement::DiscFacingOut { radius_m: 1.2 };
    conditions
}

/// M. Gauci, J. Chen, W. Li, T. J. Dodd and R. Groß, "Self-organized aggregation without computation",
/// IJRR 33(8), 2014: the best controller of their search, backward on a circle while nothing is seen,
/// and turning in place while something is.
#[test]
fn the_aggregation_controller_of_gauci_and_others_aggregates() {
    let gathering = ControllerParameters::of(wheels(1.0, -1.0), wheels(-0.7, -1.0));
    let milling = ControllerParameters::mirrored(0.15, 0.75);
    let cells =
        [line_of_sight(10, gathering), line_of_sight(20, gathering), line_of_sight(10, milling)];

    let aggregated = count(&cells, REPLICATES, 600.0, |judged| judged.phase == Phase::Aggregated);

    assert!(aggregated[0] >= 30 && aggregated[1] >= 28, "{aggregated:?} of {REPLICATES}");
    assert_eq!(aggregated[2], 0, "robots that mill are in no cluster");
}
