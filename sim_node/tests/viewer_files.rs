//! The files that set up viewers name topics and frames that are there.

use std::path::Path;

use rsrs_msgs::geometry_msgs::TwistStamped;
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::{self, Topic};
use serde_json::Value;

fn text(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../launch_configs/viewers");
    std::fs::read_to_string(folder.join(name)).expect("the file is part of the project")
}

/// Every text in a document, keys among them.
fn texts(value: &Value, found: &mut Vec<String>) {
    match value {
        Value::String(text) => found.push(text.clone()),
        Value::Array(values) => values.iter().for_each(|value| texts(value, found)),
        Value::Object(members) => {
            for (key, value) in members {
                found.push(key.clone());
                texts(value, found);
            }
        }
        Value::Null | Value::Bool(_) | Value::Number(_) => {}
    }
}

/// The topics that a document names.
fn topics_in(document: &Value) -> Vec<String> {
    let mut found = Vec::new();
    texts(document, &mut found);
    found.retain(|text| text.starts_with('/'));
    found
}

fn check(document: &Value) {
    let named = topics_in(document);

    assert!(named.contains(&topics::MARKERS.name.to_owned()), "{named:?}");
    for name in &named {
        assert!(topics::ALL.iter().any(|topic| topic.name == name), "nobody publishes {name}");
    }
}

#[test]
fn the_layout_of_rviz_has_existing_topics_with_a_quality_of_service_that_matches() {
    let document: Value = serde_saphyr::from_str(&text("swarm.rviz")).unwrap();

    check(&document);
    let manager = &document["Visualization Manager"];
    assert_eq!(manager["Global Options"]["Fixed Frame"], "map");
    let displays = manager["Displays"].as_array().unwrap();
    let markers = displays.iter().find(|display| display["Name"] == "Swarm").unwrap();
    assert_eq!(markers["Topic"]["Reliability Policy"], "Reliable");
    assert_eq!(markers["Topic"]["Durability Policy"], "Volatile");
    assert_eq!(topics::MARKERS.qos, topics::Qos::reliable(10));
}

#[test]
fn the_layout_of_foxglove_has_existing_topics() {
    let document: Value = serde_json::from_str(&text("swarm.foxglove.json")).unwrap();

    check(&document);
    assert_eq!(document["configById"]["3D!swarm"]["followTf"], "map");
}

/// A topic with a message of its type, whose fields can be looked up.
fn sample<M: serde::Serialize + Default>(topic: Topic) -> (Topic, Value) {
    (topic, serde_json::to_value(M::default()).expect("messages are plain data"))
}

#[test]
fn the_layout_of_plotjuggler_has_existing_fields() {
    let layout = text("swarm.plotjuggler.xml");
    let samples = [
        sample::<Bool>(topics::DETECTION),
        sample::<TwistStamped>(topics::CMD_VEL),
        sample::<Odometry>(topics::ODOM),
    ];
    let named: Vec<&str> = layout
        .split("<curve name=\"")
        .skip(1)
        .map(|rest| &rest[..rest.find('"').expect("attributes end")])
        .collect();

    assert_eq!(named.len(), 9 * 5);
    for name in named {
        let (robot, field) = name[1..].split_once('/').expect("a robot and a topic");
        let is_shown = samples.iter().any(|(topic, message)| {
            let path = name.strip_prefix(&topic.for_robot(robot));
            let value = path.and_then(|path| message.pointer(path));
            value.is_some_and(|value| value.is_number() || value.is_boolean())
        });
        assert!(robot.starts_with("robot_") && is_shown, "nobody publishes {name}: {field}");
    }
}
