//! Two virtual robots and a real one, whose base is the test.

use std::time::Duration;

use rsrs_core::robot::unicycle::Pose;
use rsrs_msgs::geometry_msgs::{self, Point, Quaternion};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics;
use rsrs_ros::parameters::ParameterValue;
use rsrs_ros::session::{NodeHandle, Publisher, Session};

use crate::fleet::{Latest, ROBOTS, World, conditions, publisher, set_all, start};
use rsrs_testing::network::{eventually, in_own_network, session};

/// The third robot of this world is none of the simulator's.
const REAL: &str = "real_1";

#[test]
fn real_robots_are_seen_by_virtual_ones_and_receive_those_that_they_would_see() {
    in_own_network(
        "mixed::real_robots_are_seen_by_virtual_ones_and_receive_those_that_they_would_see",
        mixing,
    );
}

async fn mixing() {
    let _simulator = start();
    let session = session();
    let node = session.node("/", "base").expect("the name is allowed");
    let odom = Latest::<Odometry>::new(&session, &node, topics::ODOM);
    let detections = Latest::<Bool>::new(&session, &node, topics::DETECTION);
    let given = Latest::<Bool>::at(&session, &node, topics::VIRTUAL_DETECTION, &[REAL]);
    let base = publisher::<Odometry>(&session, &node, topics::ODOM, REAL);
    place(&session, &node).await;
    eventually("the virtual robots are there", || {
        ROBOTS[..2].iter().all(|robot| odom.get(robot).is_some() && detections.get(robot).is_some())
    })
    .await;
    assert!(odom.get(ROBOTS[2]).is_none(), "the world has two robots of the simulator");
    let [x_m, y_m, sine, cosine] = odom.place(ROBOTS[0]).expect("it is there");
    let virtual_one = Pose { x_m, y_m, heading_rad: 2.0 * libm::atan2(sine, cosine) };
    assert!(!detections.get(ROBOTS[0]).expect("it senses").data, "all look outwards");

    // Half a metre ahead of the virtual one, and looking back at it.
    let ahead =
        Pose { heading_rad: virtual_one.heading_rad + std::f64::consts::PI, ..beyond(virtual_one) };
    until(&base, ahead, "both see each other", || {
        detections.get(ROBOTS[0]).is_some_and(|seen| seen.data)
            && given.get(REAL).is_some_and(|seen| seen.data)
    })
    .await;
    // Looking away, it sees nobody, and is still seen.
    let away = Pose { heading_rad: virtual_one.heading_rad, ..ahead };
    until(&base, away, "only the virtual one sees", || {
        detections.get(ROBOTS[0]).is_some_and(|seen| seen.data)
            && given.get(REAL).is_some_and(|seen| !seen.data)
    })
    .await;
    assert_eq!(odom.place(ROBOTS[0]), Some([x_m, y_m, sine, cosine]), "nobody moves without a run");
    session.close().await;
}

/// Half a metre ahead.
fn beyond(pose: Pose) -> Pose {
    let (sine, cosine) = libm::sincos(pose.heading_rad);
    Pose { x_m: pose.x_m + 0.5 * cosine, y_m: pose.y_m + 0.5 * sine, ..pose }
}

/// Two virtual robots and a real one, whose sensors do not err.
async fn place(session: &Session, node: &NodeHandle) {
    let mut conditions = conditions();
    (conditions.robot.true_positive, conditions.robot.false_positive) = (1.0, 0.0);
    let world = World { conditions, steps: 0, time: "real_time" };
    let names = [ROBOTS[0], ROBOTS[1], REAL].map(str::to_owned).to_vec();
    let robots = ("robots".to_owned(), ParameterValue::StringArray(names));
    let mut values = world.values();
    values.push(robots);

    set_all(session, node, &values).await.expect("the world can be placed");
}

/// Publishes where the real robot is until a condition holds.
async fn until(base: &Publisher<Odometry>, pose: Pose, what: &str, condition: impl Fn() -> bool) {
    let (sine, cosine) = libm::sincos(pose.heading_rad / 2.0);
    let mut odometry = Odometry::default();
    odometry.pose.pose = geometry_msgs::Pose {
        position: Point { x: pose.x_m, y: pose.y_m, z: 0.0 },
        orientation: Quaternion { x: 0.0, y: 0.0, z: sine, w: cosine },
    };
    let publishing = async {
        loop {
            base.publish(odometry.clone()).await.expect("a healthy network");
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    tokio::select! {
        () = publishing => {}
        () = eventually(what, &condition) => {}
    }
}
