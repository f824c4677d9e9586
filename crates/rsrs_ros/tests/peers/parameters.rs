//! Parameters, with requests and answers as ROS 2 sends them over Cyclone DDS.

use std::collections::BTreeMap;
use std::path::Path;

use rsrs_msgs::schema::schema_text;
use rsrs_ros::parameters::{
    ClientOptions, ParameterClient, ParameterClientError, ParameterServer, ParameterValue,
};
use rsrs_ros::session::Session;
use serde_json::{Value, json};

use crate::controllers::controller;
use crate::peer::Peer;
use rsrs_testing::network::{TIMEOUT, session};

/// Nodes of one participant.
const NODES: [&str; 3] = ["/robot_1/controller", "/robot_2/controller", "/robot_3/controller"];

/// The definitions that the script needs; it has those of the services itself.
fn schemas() -> BTreeMap<String, String> {
    let names = ["Parameter", "ParameterDescriptor", "ListParametersResult", "SetParametersResult"];
    names
        .iter()
        .map(|name| {
            let name = format!("rcl_interfaces/msg/{name}");
            let text = schema_text(&name).expect("bags hold these types, too");
            (name, text)
        })
        .collect()
}

fn controllers(session: &Session) -> ParameterServer {
    let nodes = (1..=NODES.len()).map(|robot| controller(robot, 0.0, robot as f64));
    ParameterServer::start(session, nodes.collect(), |_, _| Ok(())).expect("the services start")
}

/// What a dump must contain.
fn dump(speed: f64, turn_rate: f64) -> Value {
    json!({
        "speed": [3, speed, "Forward speed, in m/s.", [[0.0, 0.3]]],
        "turn_rate": [3, turn_rate, "In rad/s.", []],
    })
}

/// A visitor lists, describes, gets and sets the parameters of all nodes, in either mapping.
pub async fn cyclone_uses_ours(python: &Path) {
    let robots = session();
    let server = controllers(&robots);
    let mut visitor = Peer::start(python, "cyclone_visitor.py");

    visitor.send(&json!({ "schemas": schemas(), "nodes": NODES }));
    let headed: BTreeMap<String, Value> = visitor.receive().await;
    let plain: BTreeMap<String, Value> = visitor.receive().await;

    for (node, number) in NODES.iter().zip([1.0, 2.0, 3.0]) {
        let with_header = ((number + 8.0) / 64.0, number / 8.0);
        let first = dump(0.0, number);
        check_look(&headed[*node], &first, &dump(with_header.0, with_header.1));
        let last = dump(number / 64.0, number / 8.0);
        check_look(&plain[*node], &dump(with_header.0, with_header.1), &last);
        let speed = Some(ParameterValue::Double(number / 64.0));
        assert_eq!(server.get(node, "speed"), speed, "what Cyclone set is what {node} has");
    }
    let end: String = visitor.end().await;
    assert_eq!(end, "end");
    drop(server);
    robots.close().await;
}

fn check_look(seen: &Value, first: &Value, last: &Value) {
    assert_eq!(seen["first"], *first);
    assert_eq!(seen["set"], json!([[true, ""]]));
    let refused = "parameter 'speed' must be between 0 and 0.3, found 0.5";
    assert_eq!(seen["too fast"], json!([[false, refused]]));
    assert_eq!(seen["both"], json!([true, ""]));
    let undeclared = "parameter 'height' cannot be set because it was not declared";
    assert_eq!(seen["one of two"], json!([false, undeclared]));
    assert_eq!(seen["last"], *last, "a refused set changes nothing");
}

/// Our client finds out that a node over Cyclone DDS wants its own mapping.
pub async fn we_use_cyclones(python: &Path) {
    let lab = session();
    let node = lab.node("/", "runner").expect("the name is allowed");
    let client =
        ParameterClient::new(&lab, &node, ClientOptions { timeout: TIMEOUT, mapping: None });
    let mut foreign = Peer::start(python, "cyclone_node.py");
    foreign.send(&json!({ "schemas": schemas() }));
    let gain = |value| [("gain".to_owned(), ParameterValue::Double(value))];

    client.set_atomically("/foreign", &gain(2.5)).await.expect("the node answers");
    let refused = client.set_atomically("/foreign", &gain(9.0)).await.expect_err("a refusal");

    assert!(
        matches!(&refused, ParameterClientError::Refused { reason, .. } if reason == "too much"),
        "{refused}"
    );
    let values = client.get("/foreign", &["gain"]).await.expect("the node answers");
    assert_eq!(values, [ParameterValue::Double(2.5)]);
    assert_eq!(client.list("/foreign").await.expect("the node answers"), ["gain"]);
    let has: f64 = foreign.end().await;
    assert!((has - 2.5).abs() < f64::EPSILON, "{has}");
    drop(client);
    lab.close().await;
}
