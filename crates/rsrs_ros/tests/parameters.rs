//! Parameter services over real DDS, each test in a network of its own.

mod controllers;

use std::sync::{Arc, Mutex};
use std::time::Duration;

use controllers::controller;
use rsrs_msgs::rcl_interfaces::ParameterEvent;
use rsrs_msgs::topics;
use rsrs_ros::parameters::{
    Arming, ClientOptions, Mapping, ParameterClient, ParameterClientError, ParameterServer,
    ParameterValue,
};
use rsrs_ros::session::{Received, Session};
use rsrs_testing::network::{TIMEOUT, eventually, in_own_network, session};

/// Controllers of `n_robots`, whose speed may not be 0.13.
fn controllers(session: &Session, n_robots: usize) -> ParameterServer {
    let nodes = (1..=n_robots).map(|robot| controller(robot, 0.1, robot as f64));
    ParameterServer::start(session, nodes.collect(), |node, changes| {
        let unlucky = changes.contains(&("speed".into(), ParameterValue::Double(0.13)));
        if unlucky { Err(format!("{node} is superstitious")) } else { Ok(()) }
    })
    .expect("the services start")
}

fn values(values: &[(&str, f64)]) -> Vec<(String, ParameterValue)> {
    values.iter().map(|&(name, value)| (name.into(), ParameterValue::Double(value))).collect()
}

/// What every client should see, however it asks.
async fn use_controllers(mapping: Option<Mapping>) {
    let (fleet, lab) = (session(), session());
    let server = controllers(&fleet, 9);
    let node = lab.node("/", "runner").expect("the name is allowed");
    let options = ClientOptions { timeout: TIMEOUT, mapping };
    let client = ParameterClient::new(&lab, &node, options);
    let (third, ninth) = ("/robot_3/controller", "/robot_9/controller");

    client
        .set_atomically(third, &values(&[("speed", 0.2), ("turn_rate", 0.5)]))
        .await
        .expect("the node answers");

    let names = ["turn_rate", "speed"];
    let expected = [ParameterValue::Double(0.5), ParameterValue::Double(0.2)];
    assert_eq!(client.get(third, &names).await.expect("the node answers"), expected);
    assert_eq!(server.get(third, "speed"), Some(ParameterValue::Double(0.2)));
    assert_eq!(
        client.get(ninth, &["turn_rate"]).await.expect("the node answers"),
        [ParameterValue::Double(9.0)]
    );
    assert_eq!(client.list(ninth).await.expect("the node answers"), ["speed", "turn_rate"]);
    let described = client.describe(ninth, &["speed"]).await.expect("the node answers");
    assert_eq!(described[0].description, "Forward speed, in m/s.");
    assert_eq!(described[0].floating_point_range.len(), 1);

    refuses(&client, third).await;
    assert_eq!(client.get(third, &names).await.expect("the node answers"), expected);
    drop((client, server));
    lab.close().await;
    fleet.close().await;
}

async fn refuses(client: &ParameterClient<'_>, node: &str) {
    let cases = [
        (values(&[("speed", 0.1), ("turn_rate", f64::NAN)]), "parameter 'turn_rate' cannot be NaN"),
        (values(&[("speed", 0.5)]), "parameter 'speed' must be between 0 and 0.3, found 0.5"),
        (
            values(&[("height", 1.0)]),
            "parameter 'height' cannot be set because it was not declared",
        ),
        (values(&[("speed", 0.13)]), "/robot_3/controller is superstitious"),
    ];
    for (changes, expected) in cases {
        match client.set_atomically(node, &changes).await.expect_err("a refusal") {
            ParameterClientError::Refused { reason, .. } => assert_eq!(reason, expected),
            other => panic!("expected a refusal, found {other}"),
        }
    }
    let error = client.get(node, &["height"]).await.expect_err("a refusal");
    assert!(matches!(error, ParameterClientError::NoSuchParameter { .. }), "{error}");
}

#[test]
fn parameters_of_many_nodes_are_set_and_read_in_the_enhanced_mapping() {
    let name = "parameters_of_many_nodes_are_set_and_read_in_the_enhanced_mapping";
    in_own_network(name, async || use_controllers(Some(Mapping::Enhanced)).await);
}

#[test]
fn parameters_of_many_nodes_are_set_and_read_in_the_mapping_of_cyclone() {
    let name = "parameters_of_many_nodes_are_set_and_read_in_the_mapping_of_cyclone";
    in_own_network(name, async || use_controllers(Some(Mapping::Cyclone)).await);
}

#[test]
fn clients_of_both_mappings_do_not_take_each_others_answers() {
    let name = "clients_of_both_mappings_do_not_take_each_others_answers";
    in_own_network(name, async || {
        let (fleet, lab) = (session(), session());
        let _server = controllers(&fleet, 1);
        let node = lab.node("/", "runner").unwrap();
        let client = |mapping| {
            let options = ClientOptions { timeout: TIMEOUT, mapping: Some(mapping) };
            ParameterClient::new(&lab, &node, options)
        };
        let (enhanced, cyclone) = (client(Mapping::Enhanced), client(Mapping::Cyclone));
        let controller = "/robot_1/controller";

        for _ in 0..100 {
            let (speed, turn_rate) = futures::future::join(
                enhanced.get(controller, &["speed"]),
                cyclone.get(controller, &["turn_rate"]),
            )
            .await;
            assert_eq!(speed.unwrap(), [ParameterValue::Double(0.1)]);
            assert_eq!(turn_rate.unwrap(), [ParameterValue::Double(1.0)]);
        }
        drop((enhanced, cyclone));
        lab.close().await;
        fleet.close().await;
    });
}

#[test]
fn a_node_that_is_not_there_is_named_after_the_patience() {
    in_own_network("a_node_that_is_not_there_is_named_after_the_patience", async || {
        let lab = session();
        let node = lab.node("/", "runner").unwrap();
        let options = ClientOptions { timeout: Duration::from_millis(300), mapping: None };
        let client = ParameterClient::new(&lab, &node, options);

        let error = client.list("/robot_7/controller").await.unwrap_err();

        let expected = "node `/robot_7/controller` did not answer 0 times in 0.3 s";
        assert_eq!(error.to_string(), expected);
        drop(client);
        lab.close().await;
    });
}

#[test]
fn armed_robots_keep_their_parameters_and_their_node_may_still_change_them() {
    let name = "armed_robots_keep_their_parameters_and_their_node_may_still_change_them";
    in_own_network(name, async || {
        let (fleet, lab) = (session(), session());
        let server = controllers(&fleet, 1);
        let node = lab.node("/", "runner").unwrap();
        let options = ClientOptions { timeout: TIMEOUT, mapping: None };
        let client = ParameterClient::new(&lab, &node, options);
        let controller = "/robot_1/controller";

        server.set_arming(controller, Arming::Armed).unwrap();
        let error =
            client.set_atomically(controller, &values(&[("speed", 0.2)])).await.unwrap_err();
        server.set_local(controller, "speed", ParameterValue::Double(0.25)).unwrap();

        assert_eq!(
            error.to_string(),
            "node `/robot_1/controller` refused: \
             parameter 'speed' cannot be set while the robot is armed"
        );
        assert_eq!(
            client.get(controller, &["speed"]).await.unwrap(),
            [ParameterValue::Double(0.25)]
        );
        server.set_arming(controller, Arming::Disarmed).unwrap();
        client.set_atomically(controller, &values(&[("speed", 0.2)])).await.unwrap();
        assert!(server.set_local(controller, "speed", ParameterValue::Double(9.0)).is_err());
        drop((client, server));
        lab.close().await;
        fleet.close().await;
    });
}

#[test]
fn every_change_is_published_on_parameter_events() {
    in_own_network("every_change_is_published_on_parameter_events", async || {
        let (fleet, lab) = (session(), session());
        let node = lab.node("/", "runner").unwrap();
        let events: Arc<Mutex<Vec<ParameterEvent>>> = Arc::default();
        let changes = Arc::clone(&events);
        let topic = topics::PARAMETER_EVENTS;
        let deliver = move |received: Received<ParameterEvent>| {
            changes.lock().unwrap().push(received.message);
        };
        let _subscription = lab.subscribe(&node, topic.name, topic.qos, deliver).unwrap();
        let server = controllers(&fleet, 2);
        // One of the server's, and one of each node that nobody uses.
        lab.wait_for_writers(topic.name, 3, TIMEOUT).await.unwrap();
        fleet.wait_for_readers(topic.name, 1, TIMEOUT).await.unwrap();
        let options = ClientOptions { timeout: TIMEOUT, mapping: None };
        let client = ParameterClient::new(&lab, &node, options);

        client.set_atomically("/robot_2/controller", &values(&[("speed", 0.2)])).await.unwrap();

        let change = || {
            let events = events.lock().unwrap();
            events.iter().find(|event| !event.changed_parameters.is_empty()).cloned()
        };
        eventually("the change is published", || change().is_some()).await;
        let event = change().unwrap();
        assert_eq!(event.node, "/robot_2/controller");
        assert_eq!(event.changed_parameters[0].name, "speed");
        assert_eq!(event.changed_parameters[0].value, ParameterValue::Double(0.2).to_wire());
        assert!(event.stamp.sec > 0);
        drop((client, server));
        lab.close().await;
        fleet.close().await;
    });
}
