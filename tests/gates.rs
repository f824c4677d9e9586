//! What the gates of a fleet are set to, over real DDS: one that was started with other files is named
//! before anything moves, and gates of others are noted.
//!
//! The test plays all bases, and the two foreign gates.

use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use crate::fleet::{ROBOTS, experiment, start_run};
use crate::processes::{Process, in_own_network, rsrs};
use rsrs_bags::Bag;
use rsrs_fleet::parameters::{Value, gate};
use rsrs_fleet::record::{ATTACHMENT, ExperimentRecord};
use rsrs_msgs::geometry_msgs::{Twist, TwistStamped};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::RobotStatus;
use rsrs_msgs::sensor_msgs::Range;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::{self, Qos, Topic};
use rsrs_ros::clock::wall_time;
use rsrs_ros::parameters::ParameterServer;
use rsrs_ros::session::{Publisher, Received, Session, Subscription};
use rsrs_testing::network::session;

/// Robots with gates of ours.
const OURS: [&str; 3] = [ROBOTS[0], ROBOTS[1], ROBOTS[2]];
/// Robots with gates of somebody else: one offers parameters of other names, one offers none.
const FOREIGN: [&str; 2] = [ROBOTS[3], ROBOTS[4]];
/// Interval of everything that the bases publish.
const PERIOD: Duration = Duration::from_millis(100);

fn files(folder: &Path, n_robots: usize) -> PathBuf {
    let robots = format!("robots: {n_robots}");
    let changes = [
        ("robots: 9", robots.as_str()),
        ("time: lockstep", "time: real_time"),
        ("driver: {kind: virtual}", "driver: {kind: ros}"),
    ];
    experiment(folder, 5, &changes)
}

fn node(arguments: &[&str]) -> Process {
    let mut command = rsrs();
    command.args(["node", arguments[0], "--interface", "127.0.0.1"]).args(&arguments[1..]);
    Process(command.stdout(Stdio::null()).spawn().expect("the program was built for this test"))
}

fn our_robot(folder: &Path, robot: &str, more: &[&str]) -> Process {
    let fleet = folder.join("fleets/nine_virtual.yaml").display().to_string();
    let arguments = ["robot", "--robots", robot, "--config", &fleet, "--ros-args"];
    node(&[&arguments[..], more].concat())
}

/// Sensors and poses of all robots, and the statuses of foreign gates.
async fn live(session: &Session) {
    let node = session.node("/", "bases").expect("the name is allowed");
    let on = |topic: Topic, robot: &str| (topic.for_robot(robot), topic.qos);
    let ranges: Vec<Publisher<Range>> = OURS
        .iter()
        .map(|robot| {
            let topic = topics::HARDWARE_RANGE.for_robot(robot);
            session.publish_on(&node, &topic, Qos::best_effort(10)).expect("it is allowed")
        })
        .collect();
    let wheels = OURS.iter().map(|robot| {
        let (topic, qos) = on(topics::HARDWARE_CMD_VEL_UNSTAMPED, robot);
        session.subscribe(&node, &topic, qos, |_: Received<Twist>| {})
    });
    let gates = FOREIGN.iter().map(|robot| {
        let (topic, qos) = on(topics::CMD_VEL, robot);
        session.subscribe(&node, &topic, qos, |_: Received<TwistStamped>| {})
    });
    let obeying: Result<Vec<Subscription>, _> = wheels.chain(gates).collect();
    let _obeying = obeying.expect("it is allowed");
    let poses: Vec<Publisher<Odometry>> = ROBOTS[..5]
        .iter()
        .map(|robot| {
            let (topic, qos) = on(topics::ODOM, robot);
            session.publish_on(&node, &topic, qos).expect("it is allowed")
        })
        .collect();
    let foreign: Vec<(Publisher<RobotStatus>, Publisher<Bool>)> = FOREIGN
        .iter()
        .map(|robot| {
            let (status, detection) = (on(topics::STATUS, robot), on(topics::DETECTION, robot));
            let status = session.publish_on(&node, &status.0, status.1).expect("it is allowed");
            let detection = session.publish_on(&node, &detection.0, detection.1);
            (status, detection.expect("it is allowed"))
        })
        .collect();
    let mut counter = rsrs_fleet::wire::first_counter(wall_time());
    let mut beat = tokio::time::interval(PERIOD);
    loop {
        beat.tick().await;
        counter += 1;
        for range in &ranges {
            let nothing = Range { range: 2.0, max_range: 2.0, ..Range::default() };
            range.publish(nothing).await.expect("a healthy network");
        }
        for (robot, pose) in poses.iter().enumerate() {
            let mut odometry = Odometry::default();
            odometry.pose.pose.position.x = robot as f64;
            odometry.pose.pose.orientation.w = 1.0;
            pose.publish(odometry).await.expect("a healthy network");
        }
        for (status, detection) in &foreign {
            let idle = RobotStatus { counter, battery_v: f32::NAN, ..RobotStatus::default() };
            status.publish(idle).await.expect("a healthy network");
            detection.publish(Bool { data: false }).await.expect("a healthy network");
        }
    }
}

async fn play(folder: &Path, session: &Session) {
    let of_three = files(folder, 3);
    let _sound = OURS[..2].iter().map(|robot| our_robot(folder, robot, &[])).collect::<Vec<_>>();
    let stale = our_robot(folder, OURS[2], &["-p", "detection_threshold:=0.6"]);

    let refused = start_run(&of_three, &folder.join("refused")).ended().await.1;

    assert!(
        refused
            .contains("robot_3: `detection_threshold` is 0.6 m, expected 0.75 m by the fleet file"),
        "{refused}"
    );
    assert!(!folder.join("refused").exists(), "no bag is opened:\n{refused}");
    drop(stale);

    let of_five = files(folder, 5);
    let _mended = our_robot(folder, OURS[2], &["-p", "debounce:=3"]);
    let foreign = session.node(&format!("/{}", FOREIGN[0]), "robot").expect("it is allowed");
    let _server = ParameterServer::without_parameters(session, &foreign).expect("it is allowed");
    let _controllers = node(&["controller", "--robots", &FOREIGN.join(",")]);
    let bag = folder.join("with_foreign");

    let printed = start_run(&of_five, &bag).ended().await.1;

    assert!(
        printed.contains("settings of the gates of robot_4, robot_5 are not known"),
        "{printed}"
    );
    assert!(
        printed.contains("`debounce` differs between robots: 1 on robot_1, robot_2; 3 on robot_3"),
        "{printed}"
    );
    assert!(!printed.contains("expected 0.75 m"), "{printed}");
    // Their gates do not arm, which is of no importance here: the bag has what was read.
    let bag = Bag::open(&bag).expect("a bag");
    let attached = &bag.attachment(ATTACHMENT).expect("it is attached").data;
    let record = ExperimentRecord::from_json(&String::from_utf8_lossy(attached)).expect("one");
    assert_eq!(record.gates.keys().collect::<Vec<_>>(), OURS.iter().collect::<Vec<_>>());
    let third = &record.gates[OURS[2]];
    assert_eq!(third[gate::DEBOUNCE], Value::Integer(3));
    assert_eq!(third[gate::PERIOD], Value::Double(0.13));
    assert_eq!(third[gate::DRIVER], Value::Text("ros".to_owned()));
    let of_profile = Value::Text(record.provenance.profile_digest);
    assert_eq!(third[gate::PROFILE_DIGEST], of_profile);
}

#[test]
fn a_gate_with_another_threshold_is_named_and_all_settings_are_in_the_record() {
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let session = session();
        tokio::select! {
            () = live(&session) => {}
            () = play(folder.path(), &session) => {}
        }
        session.close().await;
    });
}
