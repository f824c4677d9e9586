//! Conditions that tests and benchmarks share: Flockbots at (0.15 m/s, 0.75 rad/s), and parts of others.

use rsrs_core::conditions::{Conditions, Settings};
use rsrs_core::quantity::Axis;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::robot::sensor::{Detects, Reading};
use rsrs_core::world::ObjectGroup;

/// Nine harsher Flockbots: detection 0.80, false positives 0.08, gain sd 0.05.
pub fn flockbot_conditions() -> Conditions {
    Conditions::flockbots(9)
}

/// Objects anywhere: how many, their radius in metres and their friction.
pub fn objects_anywhere(count: usize, radius_m: f64, friction: f64) -> ObjectGroup {
    ObjectGroup { count: Some(count), places_m: None, radius_m, friction, weight: 1.0 }
}

/// One of several kinds that a sensor tells from each other without ever being wrong.
pub fn exact_reading(name: &str, detects: Detects) -> Reading {
    let (name, taken_for) = (name.to_owned(), [].into());
    Reading { name, detects, true_positive: 1.0, false_positive: 0.0, taken_for }
}

/// The text of the Flockbot's profile.
pub const FLOCKBOT: &str = include_str!("../../../launch_configs/profiles/flockbot.yaml");

/// The Flockbot as measured.
pub fn flockbot() -> RobotProfile {
    RobotProfile::parse("flockbot.yaml", FLOCKBOT).expect("the profile that ships is good")
}

/// So many Flockbots as measured.
pub fn measured_flockbots(n_robots: u32) -> Conditions {
    let robots = (Axis::Robots, f64::from(n_robots));
    let values = vec![(Axis::Speed, 0.15), (Axis::TurnRate, 0.75), robots];
    Conditions::resolve(&flockbot(), &Settings { values, ..Settings::default() })
        .expect("they can be simulated")
}
