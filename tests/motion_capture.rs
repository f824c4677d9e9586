//! Poses as trackers publish them: of all bodies in one message, on topics of the tracker's own, as
//! transforms, by several machines, in millimetres and with y up.
//!
//! The test plays the floor: bases that obey, and a tracker that sees them.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use crate::fleet::{experiment, start_run};
use crate::processes::{Process, assert_completed, in_own_network, rsrs};
use crate::recorded::record_of;
use rsrs_core::robot::unicycle::Pose;
use rsrs_msgs::geometry_msgs::{
    Point, Pose as Pose3, PoseStamped, Quaternion, Transform, TransformStamped, Twist,
    TwistStamped, Vector3,
};
use rsrs_msgs::motion_capture_tracking_interfaces::{NamedPose, NamedPoseArray};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::std_msgs::{Bool, Header};
use rsrs_msgs::tf2_msgs::TFMessage;
use rsrs_msgs::topics;
use rsrs_ros::clock::wall_time;
use rsrs_ros::session::{Session, Subscription};
use rsrs_testing::network::session;
use rsrs_testing::python::{JAZZY, python_with};
use serde_json::Value;

const ROBOTS: [&str; 4] = ["robot_1", "robot_2", "robot_3", "robot_4"];
/// What the tracker calls them.
const BODIES: [&str; 4] = ["robot_1", "RigidBody 2", "robot_3", "robot_4"];
/// How the floor's tracker is described.
const Y_UP_MILLIMETRES: &str = "tracker: {offset_m: [0.5, -1.0], rotation_rad: 1.5707963267948966, scale: 0.001, axes: [x, -z, y]}";
const SPEED_M_S: f64 = 0.15;
const TURN_RATE_RAD_S: f64 = 0.75;
/// Interval of detections, and of poses.
const PERIODS: [Duration; 2] = [Duration::from_millis(130), Duration::from_millis(20)];
/// Long enough to be judged.
const RUN_S: u64 = 64;

/// As that tracker sees a robot on the floor.
fn seen(pose: Pose) -> Pose3 {
    // The floor is the tracker's ground, turned by a quarter, and moved.
    let (along_x, along_y) = (pose.y_m + 1.0, -(pose.x_m - 0.5));
    let (sine, cosine) = libm::sincos((pose.heading_rad - FRAC_PI_2) / 2.0);
    Pose3 {
        position: Point { x: along_x * 1000.0, y: 60.0, z: -along_y * 1000.0 },
        orientation: Quaternion { x: 0.0, y: sine, z: 0.0, w: cosine },
    }
}

fn header() -> Header {
    Header { stamp: wall_time(), frame_id: "mocap".to_owned() }
}

/// An experiment of four robots without gates of ours.
fn four_robots(folder: &Path, duration_s: u64, poses: &str) -> PathBuf {
    let changes = [
        ("robots: 9", "robots: 4"),
        ("time: lockstep", "time: real_time"),
        ("driver: {kind: virtual}", "driver: {kind: ros}, lease: controller"),
        ("pose: odom", poses),
        (
            "robot_2: {enabled: true, type: flockbot}",
            "robot_2: {enabled: true, type: flockbot, body: RigidBody 2}",
        ),
    ];
    experiment(folder, duration_s, &changes)
}

/// Bases that obey, and where they are.
struct Floor {
    poses: Mutex<Vec<Pose>>,
    commands: Arc<Mutex<Vec<Twist>>>,
    _subscriptions: Vec<Subscription>,
}

fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Floor {
    /// All on one ring, each heading along it, clockwise: who detects nothing stays on it.
    fn new(session: &Session) -> Self {
        let radius_m = SPEED_M_S / TURN_RATE_RAD_S;
        let on_ring = |robot: usize| {
            let angle_rad = robot as f64 * TAU / ROBOTS.len() as f64;
            Pose {
                x_m: radius_m * libm::cos(angle_rad),
                y_m: radius_m * libm::sin(angle_rad),
                heading_rad: angle_rad - FRAC_PI_2,
            }
        };
        let commands = Arc::new(Mutex::new(vec![Twist::default(); ROBOTS.len()]));
        let node = session.node("/", "bases").expect("the name is allowed");
        let subscriptions = ROBOTS.iter().enumerate().map(|(robot, name)| {
            let (topic, commands) = (topics::CMD_VEL, commands.clone());
            let obey = move |sample: rsrs_ros::session::Received<TwistStamped>| {
                lock(&commands)[robot] = sample.message.twist;
            };
            session.subscribe(&node, &topic.for_robot(name), topic.qos, obey).expect("allowed")
        });
        Self {
            poses: Mutex::new((0..ROBOTS.len()).map(on_ring).collect()),
            _subscriptions: subscriptions.collect(),
            commands,
        }
    }

    fn poses(&self) -> Vec<Pose> {
        lock(&self.poses).clone()
    }

    /// Moves all of them as they are commanded.
    fn advance(&self) {
        let period_s = PERIODS[1].as_secs_f64();
        let commands = lock(&self.commands).clone();
        for (pose, command) in lock(&self.poses).iter_mut().zip(commands) {
            let turn_rad = command.angular.z * period_s;
            let along_rad = pose.heading_rad + turn_rad / 2.0;
            pose.x_m += command.linear.x * period_s * libm::cos(along_rad);
            pose.y_m += command.linear.x * period_s * libm::sin(along_rad);
            pose.heading_rad += turn_rad;
        }
    }

    /// They move, see nothing, and publish odometry of their own, each with its own origin.
    async fn live(&self, session: &Session) {
        let node = session.node("/", "bases").expect("the name is allowed");
        let detections = ROBOTS.map(|robot| {
            let topic = topics::DETECTION;
            session.publish_on::<Bool>(&node, &topic.for_robot(robot), topic.qos).expect("allowed")
        });
        let odometry = ROBOTS.map(|robot| {
            let topic = topics::ODOM;
            session.publish_on::<Odometry>(&node, &topic.for_robot(robot), topic.qos).expect("fine")
        });
        let [mut sense, mut step] = PERIODS.map(tokio::time::interval);
        loop {
            tokio::select! {
                _ = sense.tick() => {
                    for (detection, own) in detections.iter().zip(&odometry) {
                        detection.publish(Bool { data: false }).await.expect("a healthy network");
                        let message = Odometry { header: header(), ..Odometry::default() };
                        own.publish(message).await.expect("a healthy network");
                    }
                }
                _ = step.tick() => self.advance(),
            }
        }
    }
}

/// A tracker that names its bodies, and sees more than robots.
async fn track_by_name(session: &Session, floor: &Floor) {
    let node = session.node("/", "tracker").expect("the name is allowed");
    let topic = topics::NAMED_POSES;
    let tracker = session.publish_on(&node, topic.name, topic.qos).expect("it is allowed");
    let mut period = tokio::time::interval(PERIODS[1]);
    loop {
        period.tick().await;
        let bodies = BODIES.iter().zip(floor.poses());
        let named =
            |(name, pose): (&&str, Pose)| NamedPose { name: (*name).to_owned(), pose: seen(pose) };
        let wand = NamedPose { name: "wand".to_owned(), pose: Pose3::default() };
        let poses = std::iter::once(wand).chain(bodies.map(named)).collect();
        let message = NamedPoseArray { header: header(), poses };
        tracker.publish(message).await.expect("a healthy network");
    }
}

async fn output(arguments: &[&str], experiment: &Path) -> (Option<i32>, String, String) {
    let mut command = rsrs();
    command.args(arguments).arg(experiment).args(["--interface", "127.0.0.1"]);
    let running = tokio::task::spawn_blocking(move || command.output());
    let output = running.await.expect("it does not panic").expect("the program was built");
    let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// Where `rsrs place --check` sees the robots.
async fn places(experiment: &Path) -> Value {
    let arguments = ["place", "--check", "--once", "--format", "json"];
    let (code, printed, errors) = output(&arguments, experiment).await;
    assert_eq!(code, Some(3), "they stand on a ring, and do not face out: {printed}{errors}");
    serde_json::from_str(&printed).unwrap_or_else(|_| panic!("no JSON: {printed}{errors}"))
}

fn assert_seen_at(places: &Value, expected: &[Pose], of_whom: &str) {
    for (seen, pose) in places["robots"].as_array().expect("a list").iter().zip(expected) {
        for (key, expected) in [("x_m", pose.x_m), ("y_m", pose.y_m)] {
            let found = seen["pose"][key].as_f64();
            let found =
                found.unwrap_or_else(|| panic!("{of_whom}: {seen} has no {key}: {places:#}"));
            assert!((found - expected).abs() < 1e-6, "{of_whom}: {seen}, expected {pose:?}");
        }
        let found = seen["pose"]["heading_rad"].as_f64().expect("a number");
        let off_rad = (found - pose.heading_rad).rem_euclid(TAU);
        assert!(off_rad.min(TAU - off_rad) < 1e-6, "{of_whom}: {seen}, expected {pose:?}");
    }
}

#[test]
fn robots_are_run_and_judged_by_a_tracker_with_y_up_in_millimetres_that_names_them() {
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let session = session();
        let floor = Floor::new(&session);
        tokio::select! {
            () = floor.live(&session) => {}
            () = track_by_name(&session, &floor) => {}
            () = run_and_judge(folder.path(), &floor) => {}
        }
        drop(floor);
        session.close().await;
    });
}

async fn run_and_judge(folder: &Path, floor: &Floor) {
    let poses = format!("pose: named_poses, {Y_UP_MILLIMETRES}");
    let experiment = four_robots(folder, RUN_S, &poses);
    let places = places(&experiment).await;
    assert_seen_at(&places, &floor.poses(), "the tracker");
    assert_eq!(places["others"], serde_json::json!(["wand"]));
    assert_eq!(places["problems"], serde_json::json!([]));

    let mut controllers = rsrs();
    controllers.args(["node", "controller", "--interface", "127.0.0.1"]);
    controllers.args(["--robots", &ROBOTS.join(","), "--ros-args", "-p", "lease:=controller"]);
    let _controllers = Process(controllers.stdout(Stdio::null()).spawn().expect("it was built"));
    let bag = folder.join("bag");
    let run = start_run(&experiment, &bag);
    let (code, printed) = run.ended().await;
    assert_completed(code, &printed);

    let labelled = rsrs().arg("label").arg(&bag).args(["--format", "json"]).output();
    let labelled = labelled.expect("it was built");
    let errors = String::from_utf8_lossy(&labelled.stderr);
    let labels: Value = serde_json::from_slice(&labelled.stdout).expect(&errors);
    assert_eq!(labels[0]["poses"], "named_poses", "{labels:#}");
    assert_eq!(labels[0]["phase"], "stable_milling", "{labels:#}");
    let (_, record) = record_of(&bag);
    let tracker = record.tracker.expect("it is in the record");
    assert_eq!(tracker.body_of("robot_2"), "RigidBody 2");
    let drawn = rsrs().arg("draw").arg(&bag).arg("-o").arg(folder.join("run.svg")).output();
    assert!(drawn.expect("it was built").status.success());
}

/// Sees every robot where it stands, as transforms and on topics of the tracker's own, of which two
/// machines have one each.
async fn track_otherwise(session: &Session, floor: &Floor) {
    let node = session.node("/", "tracker").expect("the name is allowed");
    let tf = session.publish_on(&node, topics::TF.name, topics::TF.qos).expect("it is allowed");
    let bodies = ["robot_1", "RigidBody2", "robot_3", "robot_4"];
    let machine = |name: &str| {
        let topics = bodies.map(|body| format!("/{name}/{body}/pose"));
        topics.map(|topic| {
            session.publish_on::<PoseStamped>(&node, &topic, topics::POSE.qos).expect("allowed")
        })
    };
    let machines = [machine("vrpn_a"), machine("vrpn_b")];
    let mut period = tokio::time::interval(PERIODS[1]);
    loop {
        period.tick().await;
        let poses = floor.poses();
        let transforms = bodies.iter().zip(&poses).map(|(body, pose)| {
            let Pose3 { position: Point { x, y, z }, orientation } = seen(*pose);
            TransformStamped {
                header: header(),
                child_frame_id: format!("{body}/base_link"),
                transform: Transform { translation: Vector3 { x, y, z }, rotation: orientation },
            }
        });
        let message = TFMessage { transforms: transforms.collect() };
        tf.publish(message).await.expect("a healthy network");
        for (number, publishers) in machines.iter().enumerate() {
            for (robot, (publisher, pose)) in publishers.iter().zip(&poses).enumerate() {
                // The second machine has another idea of where the third robot is.
                let error_m = if (number, robot) == (1, 2) { 0.4 } else { 0.0 };
                let pose = seen(Pose { x_m: pose.x_m + error_m, ..*pose });
                let message = PoseStamped { header: header(), pose };
                publisher.publish(message).await.expect("a healthy network");
            }
        }
    }
}

#[test]
fn transforms_and_topics_of_two_machines_are_read_where_the_fleet_file_says() {
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let session = session();
        let floor = Floor::new(&session);
        tokio::select! {
            () = track_otherwise(&session, &floor) => {}
            () = check_both(folder.path(), &floor) => {}
        }
        drop(floor);
        session.close().await;
    });
}

async fn check_both(folder: &Path, floor: &Floor) {
    let called = |body: &str, poses: &str| {
        let experiment = four_robots(folder, RUN_S, &format!("pose: {poses}"));
        let fleet = folder.join("fleets/nine_virtual.yaml");
        let text = std::fs::read_to_string(&fleet).expect("it was written");
        std::fs::write(&fleet, text.replace("RigidBody 2", body)).expect("writable");
        experiment
    };
    let with = |keys: &str| Y_UP_MILLIMETRES.replace("tracker: {", &format!("tracker: {{{keys}, "));

    let transforms = with("parent: mocap");
    let by_tf = places(&called("RigidBody2/base_link", &format!("tf, {transforms}"))).await;
    assert_seen_at(&by_tf, &floor.poses(), "transforms");
    assert_eq!(by_tf["problems"], serde_json::json!([]));

    let machines = with("topics: [\"/vrpn_a/{body}/pose\", \"/vrpn_b/{body}/pose\"]");
    let by_topics = places(&called("RigidBody2", &format!("pose, {machines}"))).await;
    assert_eq!(by_topics["problems"], serde_json::json!([]));
    let notes = by_topics["notes"].to_string();
    assert!(notes.contains("robot_3 is seen 0.40 m apart by /vrpn_"), "{notes}");
    assert_eq!(notes.matches("apart").count(), 1, "{notes}");

    let nowhere = with("topics: [/elsewhere]");
    let experiment = called("RigidBody2", &format!("named_poses, {nowhere}"));
    let (code, printed, _) = output(&["place", "--check", "--once"], &experiment).await;
    assert_eq!(code, Some(3), "{printed}");
    assert!(printed.contains("/elsewhere: no publisher"), "{printed}");
    assert!(printed.contains("4 of 4 robots are not seen"), "{printed}");
}

#[test]
fn poses_of_rclpy_are_read_as_an_array_as_odometry_and_as_poses_of_each_robot() {
    // Outside the network namespace, where the package index can be reached.
    let python = python_with(&JAZZY);
    in_own_network(async || {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/interop/tracker.py");
        let mut tracker = Command::new(&python);
        for variable in ["ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_STATIC_PEERS", "ROS_LOCALHOST_ONLY"]
        {
            tracker.env_remove(variable);
        }
        tracker.arg(script).env("ROS_DOMAIN_ID", "42").stdout(Stdio::null());
        tracker.env("ROS_LOG_DIR", folder.path().join("logs"));
        let tracker = Process(tracker.spawn().expect("the interpreter is there"));
        check_kinds(folder.path()).await;
        drop(tracker);
    });
}

/// As `tracker.py` has them: in millimetres with y up, one robot each 0.5 m along the tracker's x.
async fn check_kinds(folder: &Path) {
    let frame = "scale: 0.001, axes: [x, -z, y]";
    let expected: Vec<Pose> = (0..ROBOTS.len())
        .map(|robot| Pose { x_m: 0.5 * robot as f64, y_m: -0.25, heading_rad: 0.5 })
        .collect();
    for (kind, keys) in [
        (
            "pose_array",
            "names: [robot_4, box, robot_3, RigidBody 2, robot_1], topics: [/mocap/poses]",
        ),
        ("odom", "topics: [tracked/odom]"),
        ("pose", "topics: [tracked/pose]"),
    ] {
        let poses = format!("pose: {kind}, tracker: {{{keys}, {frame}}}");
        let places = places(&four_robots(folder, RUN_S, &poses)).await;
        assert_seen_at(&places, &expected, kind);
        assert_eq!(places["problems"], serde_json::json!([]), "{kind}");
    }

    // One name too few: nothing tells whose poses these are.
    let names = "names: [robot_4, robot_3, RigidBody 2, robot_1], topics: [/mocap/poses]";
    let poses = format!("pose: pose_array, tracker: {{{names}, {frame}}}");
    let experiment = four_robots(folder, RUN_S, &poses);
    let (code, printed, _) = output(&["place", "--check", "--once"], &experiment).await;
    assert_eq!(code, Some(3), "{printed}");
    let reason = "a message on /mocap/poses: it has 5 poses, expected 4: without names";
    assert!(printed.contains(reason), "{printed}");

    // Nor does a run start with them.
    let mut run = rsrs();
    run.args(["run", "--backend", "fleet", "--interface", "127.0.0.1"]).arg(&experiment);
    let run = Process::start(run.arg("-o").arg(folder.join("bag")));
    let (code, printed) = run.ended().await;
    assert_eq!(code, Some(1), "{printed}");
    assert!(printed.contains(reason), "{printed}");
}
