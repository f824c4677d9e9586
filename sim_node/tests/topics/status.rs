//! What the simulator reports of itself, and what it refuses.

use rsrs_core::conditions::Placement;
use rsrs_msgs::rsrs::{RobotState, RobotStatus};
use rsrs_msgs::topics;
use rsrs_ros::parameters::ParameterValue;

use crate::fleet::{Latest, World, conditions, set, set_all, start};
use rsrs_testing::network::{in_own_network, session};

#[test]
fn the_status_states_what_is_placed_and_why_nothing_is() {
    in_own_network("status::the_status_states_what_is_placed_and_why_nothing_is", placing);
}

async fn placing() {
    let _simulator = start();
    let session = session();
    let node = session.node("/", "visitor").expect("the name is allowed");
    let statuses = Latest::<RobotStatus>::new(&session, &node, topics::SIMULATOR_STATUS);
    let mut world = World { conditions: conditions(), steps: 3, time: "lockstep" };

    let idle = statuses.in_state(RobotState::Idle).await;
    assert_eq!((idle.parameter_digest, idle.battery_v.is_nan()), (0, true));
    assert_eq!(idle.stop_reason, "no world is placed");

    // What makes no world is refused by name, and changes nothing.
    world.conditions.robot.true_positive = 1.5;
    let refusal = world.place(&session, &node).await.expect_err("it makes no world");
    assert!(refusal.contains("robot.true_positive is 1.5"), "{refusal}");
    let refusal =
        set(&session, &node, "{\"robots\": 3", 3, "lockstep").await.expect_err("it makes no world");
    assert!(refusal.contains("`conditions` is not an experiment's"), "{refusal}");
    assert_eq!(statuses.in_state(RobotState::Idle).await.parameter_digest, 0);

    // Only placing shows that robots do not fit.
    world.conditions = conditions();
    world.conditions.placement = Placement::DiscFacingOut { radius_m: 0.01 };
    world.place(&session, &node).await.expect("every number is possible");
    let fault = statuses.in_state(RobotState::Fault).await;
    assert_eq!(fault.parameter_digest, 0);
    assert!(fault.stop_reason.contains("3 robots do not fit"), "{}", fault.stop_reason);

    world.conditions = conditions();
    world.place(&session, &node).await.expect("the world can be placed");
    let armed = statuses.in_state(RobotState::Armed).await;
    assert_eq!(armed.parameter_digest, world.digest());
    assert!(armed.counter > fault.counter);

    set(&session, &node, "", 3, "lockstep").await.expect("no world is a choice");
    statuses.in_state(RobotState::Idle).await;

    // What `ros2 param set /simulator cell ...` does.
    let cell = |text: &str| [("cell".to_owned(), ParameterValue::String(text.to_owned()))];
    let typed = cell("speed_m_s=0.15,turn_rate_rad_s=0.75,robots=3");
    set_all(&session, &node, &typed).await.expect("it is a cell");
    let of_cell = statuses.in_state(RobotState::Armed).await;
    assert_eq!(of_cell.parameter_digest, world.digest());
    let refusal = set_all(&session, &node, &cell("speed=3")).await.expect_err("it is no cell");
    assert!(refusal.contains("expected values such as"), "{refusal}");
    session.close().await;
}
