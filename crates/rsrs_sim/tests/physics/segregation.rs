//! Robots of several classes segregate here as in a world that was written in Python from the documentation, and moves
//! bodies apart in another way.

use rsrs_core::conditions::{Arena, Conditions, Placement, Sides, Walls};
use rsrs_core::robot::contact::ContactModel;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::profile::Sees;
use rsrs_core::robot::region::Region;
use rsrs_core::robot::sensor::{Detects, SensorDetails};
use rsrs_core::world::{RobotClass, WorldFile};
use rsrs_testing::conditions::exact_reading;
use serde_json::json;

use crate::support::perfect_flockbots;
use crate::ternary::{Wheels, assert_as_in_python, controller, n_runs, ours};

const WHEELS: Wheels = Wheels { most_m_s: 0.2, axle_m: 0.14 };
const ROBOT_M: f64 = 0.085;
const ROBOTS: usize = 12;
const CLASSES: usize = 3;
const HALF_ANGLE_RAD: f64 = 0.35;
const RANGE_M: f64 = 2.0;
const SIDE_M: f64 = 3.0;
const BOX_M: f64 = 1.8;
const PERIOD_S: f64 = 0.1;
/// How far apart bodies of one cluster are at most, in metres.
const APART_M: f64 = 0.05;
const TIMES_S: [f64; 4] = [0.0, 20.0, 60.0, 120.0];

/// Where nothing is seen, kin, and another robot: those of P. Mitrano et al., MRS 2019.
fn commands() -> [Command; 3] {
    [WHEELS.command(-1.0, 1.0 / 3.0), WHEELS.command(1.0 / 3.0, 1.0), WHEELS.command(-1.0, 1.0)]
}

fn foot_bots() -> Conditions {
    let mut conditions = perfect_flockbots();
    conditions.robots = ROBOTS;
    conditions.placement = Placement::BoxFacingAnyWay(Sides { width_m: BOX_M, height_m: BOX_M });
    conditions.arena = Arena { side_m: SIDE_M, walls: Walls::Clamp };
    let class =
        |place: usize| RobotClass { name: format!("class_{place}"), ..RobotClass::default() };
    let classes = (0..CLASSES).map(class).collect();
    conditions.world = WorldFile { classes, ..WorldFile::NOTHING };
    conditions.period_s = PERIOD_S;
    let robot = &mut conditions.robot;
    robot.radius_m = ROBOT_M;
    robot.contact = ContactModel::Push;
    robot.sees = Sees::Centre;
    robot.region = Region::Cone { half_angle_rad: HALF_ANGLE_RAD, range_m: RANGE_M };
    robot.details = SensorDetails {
        detects: Detects::Kin,
        hidden_by: vec![Detects::Robot],
        or: vec![exact_reading("other", Detects::Other)],
        ..SensorDetails::default()
    };
    let [nothing, kin, other] = commands();
    conditions.controller = controller(&conditions, ("detection", kin), ("other", other), nothing);
    conditions.check().expect("they make a world");
    conditions
}

#[test]
fn classes_segregate_as_in_another_world_that_shares_no_code() {
    let conditions = foot_bots();
    let commands = commands();
    let described = json!({
        "robots": ROBOTS, "classes": CLASSES, "runs": n_runs(), "robot_m": ROBOT_M, "box_m": BOX_M,
        "side_m": SIDE_M, "period_s": PERIOD_S, "half_angle_rad": HALF_ANGLE_RAD,
        "range_m": RANGE_M, "apart_m": APART_M, "times_s": TIMES_S,
        "speeds_m_s": commands.map(|it| it.speed_m_s),
        "turn_rates_rad_s": commands.map(|it| it.turn_rate_rad_s),
    });
    let ours = ours(&conditions, "segregated", TIMES_S);
    assert_as_in_python("segregation.py", &described, &ours, TIMES_S);
    assert!(ours[3].0 > ours[0].0 + 0.1, "they segregate: {ours:?}");
}
