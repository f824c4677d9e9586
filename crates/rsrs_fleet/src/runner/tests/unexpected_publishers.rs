//! A node that begins to publish what only one node may.

use super::*;
use crate::preflight::{Endpoint, ExpectedTopic, Publishers};

const TOPIC: &str = "/robot_1/cmd_vel";
const HARDWARE: &str = "/robot_1/hardware/cmd_vel";

fn publisher(guid: u8, node: Option<&str>) -> Endpoint {
    Endpoint {
        topic: TOPIC.to_owned(),
        type_name: "geometry_msgs/msg/TwistStamped".to_owned(),
        node: node.map(str::to_owned),
        guid: [guid; 16],
    }
}

/// A running run, and what is seen next.
fn outcome_after(publishers: &[Endpoint]) -> Outcome {
    let mut bench = Bench::with(|options| {
        options.length = RunLength::RealTime { duration: Duration::from_secs(4) };
        options.expected.steering = [HARDWARE.to_owned()].into();
        options.expected.topics = vec![ExpectedTopic {
            name: TOPIC.to_owned(),
            type_name: "geometry_msgs/msg/TwistStamped".to_owned(),
            publishers: Publishers::One,
        }];
    });
    let gate = Endpoint { topic: HARDWARE.to_owned(), ..publisher(3, Some("/robot_1/robot")) };
    bench.publishers = vec![publisher(1, Some("/robot_1/controller")), gate];
    bench.run();
    bench.publishers.extend(publishers.iter().cloned());
    bench.end().0
}

#[test]
fn a_second_publisher_of_commands_ends_the_run_with_its_nodes_name() {
    let reason = "a second publisher of /robot_1/cmd_vel: node /teleop".to_owned();
    assert_eq!(outcome_after(&[publisher(2, Some("/teleop"))]), Outcome::Aborted { reason });

    let unstamped = Endpoint {
        type_name: "geometry_msgs/msg/Twist".to_owned(),
        ..publisher(2, Some("/teleop"))
    };
    assert!(matches!(outcome_after(&[unstamped]), Outcome::Aborted { .. }));
}

#[test]
fn a_second_publisher_behind_the_gate_ends_the_run_too() {
    let teleop = Endpoint { topic: HARDWARE.to_owned(), ..publisher(4, Some("/teleop")) };

    assert_eq!(outcome_after(&[]), Outcome::Completed);
    let reason = "a second publisher of /robot_1/hardware/cmd_vel: node /teleop".to_owned();
    assert_eq!(outcome_after(&[teleop]), Outcome::Aborted { reason });
}

#[test]
fn a_publisher_without_a_name_ends_it_too() {
    let Outcome::Aborted { reason } = outcome_after(&[publisher(2, None)]) else { panic!() };

    assert!(reason.ends_with("of a node that does not state its name"), "{reason}");
}

#[test]
fn a_controller_that_starts_again_is_no_stranger() {
    let again = publisher(2, Some("/robot_1/controller"));

    assert_eq!(outcome_after(&[again]), Outcome::Completed);
}
