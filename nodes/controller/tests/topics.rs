//! The controller node as a process, over real DDS in a network of its own.

use std::time::Duration;

use rsrs_msgs::geometry_msgs::TwistStamped;
use rsrs_msgs::rsrs::{LeaseState, RobotState, RobotStatus, RunLease};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::{self, Qos};
use rsrs_ros::parameters::{ClientOptions, ParameterClient, ParameterValue};
use rsrs_ros::session::{NodeHandle, Publisher, Session};
use rsrs_testing::network::{NodeProcess, TIMEOUT, eventually, in_own_network, run_node, session};
use tokio::sync::mpsc::{UnboundedReceiver, unbounded_channel};

const SEEN: Bool = Bool { data: true };
const NOT_SEEN: Bool = Bool { data: false };
const CONTROLLER: &str = "/robot_2/controller";

/// The node, where it is a process of its own.
#[test]
fn node() {
    run_node(rsrs_controller_node::main);
}

fn start_with(more_for_ros: &[&str]) -> NodeProcess {
    let arguments = ["--ros-args", "-p", "speed:=0.15", "-p", "turn_rate:=0.75"];
    let arguments = [&arguments[..], more_for_ros].concat();
    NodeProcess::start("robot_1,robot_2", &arguments)
}

#[test]
fn topics_have_the_names_that_they_are_remapped_to_and_nothing_goes_to_rosout() {
    in_own_network(
        "topics_have_the_names_that_they_are_remapped_to_and_nothing_goes_to_rosout",
        remapped,
    );
}

async fn remapped() {
    let _node = start_with(&[
        "-r",
        "/robot_2/detection:=/camera/seen",
        "-r",
        "/robot_2/cmd_vel:=/base/cmd_vel",
        "--disable-rosout-logs",
    ]);
    let session = session();
    let visitor = session.node("/", "visitor").expect("the name is allowed");
    let (to_commands, mut commands) = unbounded_channel::<TwistStamped>();
    let qos = topics::CMD_VEL.qos;
    let _commands = session
        .subscribe(&visitor, "/base/cmd_vel", qos, move |sample| {
            drop(to_commands.send(sample.message));
        })
        .expect("the topic is allowed");
    // As a sensor of ROS 2 publishes.
    let detections = session
        .publish_on::<Bool>(&visitor, "/camera/seen", Qos::best_effort(5))
        .expect("the topic is allowed");

    assert_eq!(command_for(SEEN, &detections, &mut commands).await, (0.15, 0.75));
    assert_eq!(command_for(NOT_SEEN, &detections, &mut commands).await, (0.15, -0.75));

    let named = || {
        let mut endpoints = session.endpoints();
        endpoints.retain(|end| end.node.as_deref() == Some(CONTROLLER));
        endpoints
    };
    // A node announces its endpoints one after the other.
    let is_named = || named().iter().any(|end| end.topic == "/base/cmd_vel");
    eventually("the controller's node has the topic of its commands", is_named).await;
    let topics: Vec<String> = named().into_iter().map(|end| end.topic).collect();
    let left = ["/rosout", "/robot_2/cmd_vel", "/robot_2/detection"];
    assert!(!topics.iter().any(|topic| left.contains(&topic.as_str())), "{topics:?}");
    drop((detections, visitor));
    session.close().await;
}

async fn publisher(session: &Session, node: &NodeHandle) -> Publisher<Bool> {
    let topic = topics::DETECTION.for_robot("robot_2");
    let publisher = session
        .publish_on::<Bool>(node, &topic, topics::DETECTION.qos)
        .expect("the topic is allowed");
    session.wait_for_readers(&topic, 1, TIMEOUT).await.expect("the controller subscribes");
    publisher
}

/// Publishes detections until a command answers, so that no matching delay is waited out blindly.
async fn command_for(
    detection: Bool,
    detections: &Publisher<Bool>,
    commands: &mut UnboundedReceiver<TwistStamped>,
) -> (f64, f64) {
    while commands.try_recv().is_ok() {}
    let command = async {
        loop {
            detections.publish(detection).await.expect("a healthy network");
            tokio::select! {
                command = commands.recv() => break command.expect("the subscription lives"),
                () = tokio::time::sleep(Duration::from_millis(500)) => {}
            }
        }
    };
    let command = tokio::time::timeout(TIMEOUT, command).await.expect("the controller answers");
    (command.twist.linear.x, command.twist.angular.z)
}

#[test]
fn commands_follow_detections_and_parameters_and_an_armed_controller_keeps_them() {
    in_own_network(
        "commands_follow_detections_and_parameters_and_an_armed_controller_keeps_them",
        body,
    );
}

async fn body() {
    let node = start_with(&[]);
    let session = session();
    let visitor = session.node("/", "visitor").expect("the name is allowed");
    let (to_commands, mut commands) = unbounded_channel::<TwistStamped>();
    let (to_statuses, mut statuses) = unbounded_channel::<RobotStatus>();
    let cmd_vel = topics::CMD_VEL;
    let _commands = session
        .subscribe(&visitor, &cmd_vel.for_robot("robot_2"), cmd_vel.qos, move |sample| {
            drop(to_commands.send(sample.message));
        })
        .expect("the topic is allowed");
    let status = topics::CONTROLLER_STATUS;
    let _statuses = session
        .subscribe(&visitor, &status.for_robot("robot_2"), status.qos, move |sample| {
            drop(to_statuses.send(sample.message));
        })
        .expect("the topic is allowed");
    let detections = publisher(&session, &visitor).await;

    // The command changes sign with the detection.
    assert_eq!(command_for(SEEN, &detections, &mut commands).await, (0.15, 0.75));
    assert_eq!(command_for(NOT_SEEN, &detections, &mut commands).await, (0.15, -0.75));

    // What the simulator publishes in a mixed fleet counts as well, until it falls silent.
    let topic = topics::VIRTUAL_DETECTION;
    let name = topic.for_robot("robot_2");
    let simulator = session.publish_on::<Bool>(&visitor, &name, topic.qos).expect("allowed");
    session.wait_for_readers(&name, 1, TIMEOUT).await.expect("the controller subscribes");
    let sees_virtual_robot = async {
        while command_for(NOT_SEEN, &detections, &mut commands).await != (0.15, 0.75) {
            simulator.publish(SEEN).await.expect("a healthy network");
        }
    };
    tokio::time::timeout(TIMEOUT, sees_virtual_robot).await.expect("the virtual robot is seen");
    tokio::time::sleep(Duration::from_millis(600)).await;
    assert_eq!(command_for(NOT_SEEN, &detections, &mut commands).await, (0.15, -0.75));

    // A valid parameter takes effect, one beyond the robot's limit does not.
    let options = ClientOptions { timeout: TIMEOUT, mapping: None };
    let client = ParameterClient::new(&session, &visitor, options);
    let speed = |value| [("speed".to_owned(), ParameterValue::Double(value))];
    client.set_atomically(CONTROLLER, &speed(0.2)).await.expect("0.2 m/s is allowed");
    assert_eq!(command_for(SEEN, &detections, &mut commands).await, (0.2, 0.75));
    client.set_atomically(CONTROLLER, &speed(0.5)).await.expect_err("0.5 m/s is too fast");
    assert_eq!(command_for(SEEN, &detections, &mut commands).await, (0.2, 0.75));

    // A run holds the parameters; when its lease has run out, they are free again.
    let arming = hold_lease(&session, &visitor, &mut statuses).await;
    client.set_atomically(CONTROLLER, &speed(0.1)).await.expect_err("a run holds the parameters");
    arming.abort();
    eventually("the lease runs out", || {
        std::iter::from_fn(|| statuses.try_recv().ok())
            .any(|status| status.state == RobotState::Stopped)
    })
    .await;
    client.set_atomically(CONTROLLER, &speed(0.1)).await.expect("the run is over");

    stop_in_order(node);
    session.close().await;
}

/// Publishes an armed lease ten times a second, until the controller reports that it is armed.
async fn hold_lease(
    session: &Session,
    visitor: &NodeHandle,
    statuses: &mut UnboundedReceiver<RobotStatus>,
) -> tokio::task::JoinHandle<()> {
    let lease = RunLease {
        run_id: "run".to_owned(),
        epoch: 1,
        state: u8::from(LeaseState::Armed),
        robots: vec!["robot_2".to_owned()],
        echoed_counter: vec![0],
        ..RunLease::default()
    };
    let leases = session
        .publish_on::<RunLease>(visitor, topics::LEASE.name, topics::LEASE.qos)
        .expect("the topic is allowed");
    let arming = tokio::spawn(async move {
        loop {
            leases.publish(lease.clone()).await.expect("a healthy network");
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    });
    eventually("the controller is armed", || {
        std::iter::from_fn(|| statuses.try_recv().ok())
            .any(|status| status.state == RobotState::Armed && status.epoch == 1)
    })
    .await;
    arming
}

/// SIGTERM ends the node with exit code 0.
#[expect(unsafe_code, reason = "a system call without a safe wrapper")]
fn stop_in_order(mut node: NodeProcess) {
    let pid = libc::pid_t::try_from(node.0.id()).expect("process numbers fit");
    // SAFETY: sends a signal to our own child, which has not been waited for.
    let sent = unsafe { libc::kill(pid, libc::SIGTERM) };
    assert_eq!(sent, 0);
    let status = node.0.wait().expect("the node is our child");
    assert!(status.success(), "the node ended with {status}");
}
