//! The parameters of a robot, as other programs set them, and its health, as monitors receive it.

use std::time::Instant;

use rsrs_msgs::diagnostic_msgs::{DiagnosticArray, DiagnosticStatus};
use rsrs_msgs::rsrs::RobotState;
use rsrs_msgs::topics;
use rsrs_ros::parameters::{ClientOptions, ParameterClient, ParameterValue};
use tokio::sync::mpsc::unbounded_channel;

use super::micro::{Micro, Socket};
use super::rest_of_fleet::{DIGEST, Node, Runner};
use rsrs_testing::network::{TIMEOUT, eventually, in_own_network, session};

const NODE: &str = "/robot_1/robot";

fn double(name: &str, value: f64) -> (String, ParameterValue) {
    (name.to_owned(), ParameterValue::Double(value))
}

#[test]
fn parameters_are_set_together_within_their_ranges_and_not_during_a_run() {
    let name = "parameters::parameters_are_set_together_within_their_ranges_and_not_during_a_run";
    in_own_network(name, async || {
        let socket = Socket::new();
        let _micro = Micro::plug_in(&socket.path());
        let port = socket.path().display().to_string();
        let node = Node::start(&["--driver", "serial", "--port", &port, "--without-controller"]);
        let session = session();
        let visitor = session.node("/", "visitor").expect("the name is allowed");
        let options = ClientOptions { timeout: TIMEOUT, mapping: None };
        let client = ParameterClient::new(&session, &visitor, options);
        let runner = Runner::start(&session, &visitor);

        let good = [double("acceleration_max", 2.0), double("detection_threshold", 0.4)];
        client.set_atomically(NODE, &good).await.expect("both are in range");
        for refused in [
            double("acceleration_max", 1e6),
            double("acceleration_max", f64::NAN),
            double("speed_max", 0.2),
            ("debounce".to_owned(), ParameterValue::Integer(0)),
            ("serial.port".to_owned(), ParameterValue::String("/dev/null".to_owned())),
        ] {
            let both = [double("detection_threshold", 0.9), refused.clone()];
            client.set_atomically(NODE, &both).await.expect_err(&refused.0);
        }
        let names = ["acceleration_max", "detection_threshold", "speed_max"];
        let values = client.get(NODE, &names).await.expect("they are there");
        let expected = [2.0, 0.4, 0.3].map(ParameterValue::Double);
        assert_eq!(values, expected);

        runner.messages().foreign_controller = Some(DIGEST);
        runner.run_epoch(1).await;
        client.set_atomically(NODE, &good).await.expect_err("a run holds the parameters");
        runner.messages().lease = None;
        eventually("the lease runs out", || runner.state() == RobotState::Stopped).await;
        // It may go on within a second, and is over after that.
        let start = Instant::now();
        while let Err(error) = client.set_atomically(NODE, &good).await {
            assert!(start.elapsed() < TIMEOUT, "the run is over: {error}");
        }

        drop((node, runner));
        session.close().await;
    });
}

#[test]
fn diagnostics_name_the_part_that_fails() {
    in_own_network("parameters::diagnostics_name_the_part_that_fails", async || {
        let socket = Socket::new();
        let port = socket.path().display().to_string();
        let node = Node::start(&["--driver", "serial", "--port", &port, "--without-controller"]);
        let session = session();
        let visitor = session.node("/", "visitor").expect("the name is allowed");
        let (to_test, mut received) = unbounded_channel::<DiagnosticArray>();
        let topic = topics::DIAGNOSTICS;
        let _subscription = session
            .subscribe(&visitor, topic.name, topic.qos, move |sample| {
                drop(to_test.send(sample.message));
            })
            .expect("the topic is allowed");
        let mut hardware_reports = |level: u8, text: &str| {
            std::iter::from_fn(|| received.try_recv().ok()).any(|array| {
                let hardware = &array.status[0];
                assert_eq!(hardware.name, "robot_1: serial driver");
                hardware.level == level && hardware.message.contains(text)
            })
        };

        eventually("the missing port is named", || {
            hardware_reports(DiagnosticStatus::ERROR, "cannot be opened")
        })
        .await;
        let _micro = Micro::plug_in(&socket.path());
        eventually("all is well", || hardware_reports(DiagnosticStatus::OK, "work")).await;

        drop(node);
        session.close().await;
    });
}
