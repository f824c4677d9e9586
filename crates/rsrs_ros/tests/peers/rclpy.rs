//! A stock ROS 2 (rclpy over Fast DDS) uses our parameters and topics, and we use its.

use std::cell::Cell;
use std::path::Path;
use std::time::Duration;

use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics;
use rsrs_ros::parameters::{ClientOptions, ParameterClient, ParameterServer, ParameterValue};
use rsrs_ros::session::Session;
use serde_json::{Value, json};

use crate::controllers::controller;
use rsrs_testing::network::{TIMEOUT, session, within};

/// The client's node.
const VISITOR: &str = "/visitor";

fn controllers(session: &Session) -> ParameterServer {
    let nodes = (1..=3).map(|robot| controller(robot, 0.15, 0.75));
    ParameterServer::start(session, nodes.collect(), |_, _| Ok(())).expect("the services start")
}

/// Runs the client, while robot 3 detects something ten times a second and sets the client's gain;
/// once that is answered and the client's node is known by name, robot 2 detects something, too, which
/// the client waits for.
async fn run_client(python: &Path, robots: &Session) -> Value {
    let node = robots.node("/robot_3", "controller").expect("the name is allowed");
    let detection = |robot| {
        let topic = topics::DETECTION.for_robot(robot);
        let publisher = robots.publish_on(&node, &topic, topics::DETECTION.qos);
        publisher.expect("the topic is allowed")
    };
    let (third, second) = (detection("robot_3"), detection("robot_2"));
    let logs = tempfile::tempdir().expect("a folder to write in");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers/rclpy_client.py");
    let mut client = tokio::process::Command::new(python);
    client.arg("-B").arg(script).env("ROS_DOMAIN_ID", "42").env("ROS_LOG_DIR", logs.path());
    client.kill_on_drop(true);
    let options = ClientOptions { timeout: TIMEOUT, mapping: None };
    let visitor = ParameterClient::new(robots, &node, options);
    let gain = [("gain".to_owned(), ParameterValue::Double(2.5))];

    let mut visitor_is_seen = false;
    let gain_is_answered = Cell::new(false);
    let set_gain = async {
        let outcome = visitor.set_atomically(VISITOR, &gain).await;
        gain_is_answered.set(true);
        outcome
    };
    let both = futures::future::join(client.output(), set_gain);
    let mut both = std::pin::pin!(tokio::time::timeout(2 * TIMEOUT, both));
    let (output, gain_is_set) = loop {
        third.publish(Bool { data: true }).await.expect("a healthy network");
        visitor_is_seen |= robots.node_names().contains(&VISITOR.to_owned());
        if gain_is_answered.get() && visitor_is_seen {
            second.publish(Bool { data: true }).await.expect("a healthy network");
        }
        tokio::select! {
            ended = &mut both => break ended.expect("rclpy ends"),
            () = tokio::time::sleep(Duration::from_millis(100)) => {}
        }
    };

    let output = output.expect("python starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "rclpy failed: {errors}");
    gain_is_set.expect("rclpy lets its parameter be set");
    assert!(visitor_is_seen, "its node has a name");
    serde_json::from_slice(&output.stdout).expect("the client prints JSON")
}

async fn what_rclpy_sees(python: &Path) -> Value {
    let robots = session();
    let server = controllers(&robots);

    let seen = run_client(python, &robots).await;

    let speed = server.get("/robot_3/controller", "speed");
    assert_eq!(speed, Some(ParameterValue::Double(0.25)), "what rclpy set is what the node has");
    // Before a participant that says nothing is given up.
    within(Duration::from_secs(30), "the visitor has left", || {
        !robots.node_names().contains(&VISITOR.to_owned())
    })
    .await;
    drop(server);
    robots.close().await;
    seen
}

/// Everything that `ros2 param` does, and a topic both ways.
pub async fn uses_ours(python: &Path) {
    let seen = what_rclpy_sees(python).await;

    assert_eq!(seen["listed"], json!(["speed", "turn_rate"]));
    assert_eq!(seen["first"], json!([0.15, 0.75]));
    assert_eq!(seen["described"], json!(["Forward speed, in m/s.", 3, 0.0, 0.3]));
    assert_eq!(seen["set"], json!([true, ""]));
    let refused = "parameter 'speed' must be between 0 and 0.3, found 0.5";
    assert_eq!(seen["out of range"], json!([false, refused]));
    assert_eq!(seen["wrong type"][0], json!(false));
    assert_eq!(
        seen["undeclared"],
        json!([false, "parameter 'height' cannot be set because it was not declared"])
    );
    assert_eq!(seen["set one"], json!([true]));
    assert_eq!(seen["last"], json!([0.25, 0.5]), "a refused set changes nothing");
    assert_eq!(seen["detection"], json!(true));
    assert_eq!(seen["changed"], json!(["speed"]));
    assert_eq!(seen["gain"], json!(2.5), "our client sets its parameter");
    let nodes = ["/robot_1/controller", "/robot_2/controller", "/robot_3/controller", "/visitor"];
    assert_eq!(seen["nodes"], json!(nodes));
    let dump = |speed: f64, turn_rate: f64| json!({ "speed": speed, "turn_rate": turn_rate });
    let dumps = json!({
        "/robot_1/controller": dump(0.15, 0.75),
        "/robot_2/controller": dump(0.15, 0.75),
        "/robot_3/controller": dump(0.25, 0.5),
    });
    assert_eq!(seen["dumps"], dumps);
    assert_eq!(seen["services"].as_array().map(Vec::len), Some(6));
    assert_eq!(seen["publishers"]["/robot_3/detection"], json!(["std_msgs/msg/Bool"]));
}
