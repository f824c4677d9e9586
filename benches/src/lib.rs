//! What the benchmarks run: the default world for any number of robots, and the loop that one would
//! write first, as the yardstick.
//!
//! `cargo bench -p rsrs_benches` runs everything; `--bench step n9` a part. Items are agent-steps,
//! so the item rate is agent-steps per second on one core. Compare within one run only: the same
//! program differs by a factor of two between machines and between minutes.

pub mod plain;

use std::collections::BTreeMap;

use rsrs_core::conditions::{Arena, Conditions, Placement, Sides, SimulatedSensor, Walls};
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::state_machine::{Row, StateMachine};
use rsrs_core::robot::controller::{Command, Controller, ControllerParameters};
use rsrs_core::robot::region::Region;
use rsrs_core::robot::sensor::{Detects, Reading, ReadingNames, SensorDetails};
use rsrs_core::world::{ObjectGroup, WorldFile};
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

/// Twenty robots that push twenty objects in a square of 3 m: of two sensors one tells objects from robots by what its
/// line of sight meets first, the other detects walls.
pub fn pushers() -> Conditions {
    let flockbots = flockbots(20);
    let objects =
        ObjectGroup { count: Some(20), places_m: None, radius_m: 0.05, friction: 0.0, weight: 1.0 };
    let mut robot = flockbots.robot.clone();
    robot.contact = ContactModel::Push;
    robot.region = Region::Cone { half_angle_rad: 0.0, range_m: 5.0 };
    robot.details = SensorDetails {
        hidden_by: vec![Detects::Robot, Detects::Object],
        or: vec![Reading {
            name: "object".to_owned(),
            detects: Detects::Object,
            true_positive: 1.0,
            false_positive: 0.0,
            taken_for: BTreeMap::new(),
        }],
        ..SensorDetails::default()
    };
    robot.further_sensors = vec![SimulatedSensor {
        name: "wall".to_owned(),
        sees: robot.sees,
        region: Region::Cone { half_angle_rad: 0.5, range_m: 0.3 },
        true_positive: 1.0,
        false_positive: 0.0,
        latency_steps: 0,
        details: SensorDetails { detects: Detects::Wall, ..SensorDetails::default() },
    }];
    let row = |seen: Option<&str>, speed_m_s: f64, turn_rate_rad_s: f64| Row {
        state: "gathers".to_owned(),
        when: seen.map(|name| (name.to_owned(), true)).into_iter().collect(),
        command: Command { speed_m_s, turn_rate_rad_s },
        next: Vec::new(),
    };
    let rows = vec![
        row(Some("object"), 0.15, -0.75),
        row(Some("detection"), 0.05, 0.75),
        row(None, 0.15, 0.75),
    ];
    let machine = StateMachine {
        rows,
        numbers: BTreeMap::new(),
        starts: BTreeMap::new(),
        sensors: ReadingNames::default(),
    };
    Conditions {
        controller: Controller::Machine(machine).for_robots_with(robot.reading_names()),
        robot,
        placement: Placement::BoxFacingAnyWay(Sides { width_m: 2.8, height_m: 2.8 }),
        arena: Arena { side_m: 3.0, walls: Walls::Stop },
        world: WorldFile { objects: vec![objects], ..WorldFile::NOTHING },
        ..flockbots
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
