//! Robots that cluster objects do here what they do in a world that was written in Python from the documentation,
//! and moves bodies apart in another way.

use rsrs_core::conditions::{Arena, Conditions, Placement, Sides, Walls};
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::region::Region;
use rsrs_core::robot::sensor::{Detects, SensorDetails};
use rsrs_core::world::WorldFile;
use rsrs_testing::conditions::{exact_reading, objects_anywhere};
use serde_json::json;

use crate::support::perfect_flockbots;
use crate::ternary::{Wheels, assert_as_in_python, controller, n_runs, ours};

const WHEELS: Wheels = Wheels { most_m_s: 0.128, axle_m: 0.051 };
const ROBOT_M: f64 = 0.037;
const OBJECT_M: f64 = 0.05;
const ROBOTS: usize = 5;
const OBJECTS: usize = 20;
const RANGE_M: f64 = 3.0;
const SIDE_M: f64 = 3.0;
const BOX_M: f64 = 2.8;
const PERIOD_S: f64 = 0.1;
const TIMES_S: [f64; 4] = [0.0, 60.0, 120.0, 240.0];

/// Where nothing is seen, a robot, and an object.
fn commands() -> [Command; 3] {
    [WHEELS.command(0.5, 1.0), WHEELS.command(0.1, 0.5), WHEELS.command(1.0, 0.5)]
}

fn e_pucks() -> Conditions {
    let mut conditions = perfect_flockbots();
    conditions.robots = ROBOTS;
    conditions.placement = Placement::BoxFacingAnyWay(Sides { width_m: BOX_M, height_m: BOX_M });
    conditions.arena = Arena { side_m: SIDE_M, walls: Walls::Clamp };
    let objects = vec![objects_anywhere(OBJECTS, OBJECT_M, 0.0)];
    conditions.world = WorldFile { objects, ..WorldFile::NOTHING };
    conditions.period_s = PERIOD_S;
    let robot = &mut conditions.robot;
    robot.radius_m = ROBOT_M;
    robot.contact = ContactModel::Push;
    robot.region = Region::Cone { half_angle_rad: 0.0, range_m: RANGE_M };
    robot.details = SensorDetails {
        hidden_by: vec![Detects::Robot, Detects::Object],
        or: vec![exact_reading("object", Detects::Object)],
        ..SensorDetails::default()
    };
    let [nothing, robot, object] = commands();
    conditions.controller =
        controller(&conditions, ("object", object), ("detection", robot), nothing);
    conditions.check().expect("they make a world");
    conditions
}

#[test]
fn objects_are_clustered_as_in_another_world_that_shares_no_code() {
    let conditions = e_pucks();
    let commands = commands();
    let described = json!({
        "robots": ROBOTS, "objects": OBJECTS, "runs": n_runs(), "robot_m": ROBOT_M,
        "object_m": OBJECT_M, "box_m": BOX_M, "side_m": SIDE_M, "period_s": PERIOD_S,
        "range_m": RANGE_M, "times_s": TIMES_S,
        "speeds_m_s": commands.map(|it| it.speed_m_s),
        "turn_rates_rad_s": commands.map(|it| it.turn_rate_rad_s),
    });
    let ours = ours(&conditions, "objects_clustered", TIMES_S);
    assert_as_in_python("clustering.py", &described, &ours, TIMES_S);
    assert!(ours[3].0 > ours[0].0 + 0.05, "they gather: {ours:?}");
}
