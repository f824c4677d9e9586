//! Robots without a microcontroller of ours: somebody else's base, and a robot of the simulator.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use rsrs_msgs::RosMessage;
use rsrs_msgs::geometry_msgs::{Twist, TwistStamped};
use rsrs_msgs::rsrs::RobotState;
use rsrs_msgs::sensor_msgs::{LaserScan, Range};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::{self, Topic};
use rsrs_ros::session::{NodeHandle, Session, Subscription};
use tokio::task::JoinHandle;

use super::micro::{Micro, Socket};
use super::rest_of_fleet::{DIGEST, Node, ROBOT, Runner};
use rsrs_testing::network::{eventually, in_own_network, session};

/// Longer than the time after which a sensor has failed.
const SILENCE: Duration = Duration::from_secs(2);

/// The last message of a topic.
struct Last<M> {
    message: Arc<Mutex<Option<(M, Instant)>>>,
    _subscription: Subscription,
}

impl<M: RosMessage> Last<M> {
    fn new(session: &Session, node: &NodeHandle, topic: Topic) -> Self {
        let message = Arc::new(Mutex::new(None));
        let received = Arc::clone(&message);
        let name = topic.for_robot(ROBOT);
        let subscription = session.subscribe(node, &name, topic.qos, move |sample| {
            let newest = Some((sample.message, Instant::now()));
            *received.lock().unwrap_or_else(PoisonError::into_inner) = newest;
        });
        Self { message, _subscription: subscription.expect("the topic is allowed") }
    }

    fn is(&self, expected: impl Fn(&M) -> bool) -> bool {
        let message = self.message.lock().unwrap_or_else(PoisonError::into_inner);
        message.as_ref().is_some_and(|(message, _)| expected(message))
    }

    fn is_silent_for(&self, duration: Duration) -> bool {
        let message = self.message.lock().unwrap_or_else(PoisonError::into_inner);
        message.as_ref().is_none_or(|(_, at)| at.elapsed() > duration)
    }
}

/// A publisher that repeats a message until it is changed.
struct Repeated<M> {
    message: Arc<Mutex<M>>,
    task: JoinHandle<()>,
}

impl<M: RosMessage> Repeated<M> {
    fn on(session: &Session, node: &NodeHandle, (name, topic): (&str, Topic), first: M) -> Self {
        let publisher =
            session.publish_on::<M>(node, name, topic.qos).expect("the topic is allowed");
        let message = Arc::new(Mutex::new(first));
        let repeated = Arc::clone(&message);
        let task = tokio::spawn(async move {
            loop {
                let message = repeated.lock().unwrap_or_else(PoisonError::into_inner).clone();
                publisher.publish(message).await.expect("a healthy network");
                tokio::time::sleep(Duration::from_millis(40)).await;
            }
        });
        Self { message, task }
    }

    fn change(&self, change: impl FnOnce(&mut M)) {
        change(&mut self.message.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

impl<M> Drop for Repeated<M> {
    fn drop(&mut self) {
        self.task.abort();
    }
}

#[test]
fn a_base_of_somebody_else_is_driven_by_its_range_sensor() {
    in_own_network("drivers::a_base_of_somebody_else_is_driven_by_its_range_sensor", async || {
        let start_values = [
            ["-p", "speed:=0.15"],
            ["-p", "turn_rate:=0.75"],
            ["-p", "debounce:=3"],
            ["-p", "detection_threshold:=0.6"],
        ];
        let arguments = ["--driver", "ros", "--ros-args"];
        let node = Node::start(&[&arguments[..], start_values.as_flattened()].concat());
        let session = session();
        let base = session.node("/robot_1", "base").expect("the name is allowed");
        let wheels = Last::<Twist>::new(&session, &base, topics::HARDWARE_CMD_VEL_UNSTAMPED);
        let detection = Last::<Bool>::new(&session, &base, topics::DETECTION);
        let range = Last::<Range>::new(&session, &base, topics::RANGE);
        let runner = Runner::start(&session, &base);
        eventually("a robot without a sensor is in fault", || runner.state() == RobotState::Fault)
            .await;
        let awaited = "no reading of the sensor yet, from /robot_1/hardware/range";
        let is_named = || runner.messages().status.stop_reason.contains(awaited);
        eventually("the topic of the sensor is named", is_named).await;

        let far = Range { min_range: 0.02, max_range: 2.0, range: 1.5, ..Range::default() };
        let topic = topics::HARDWARE_RANGE;
        let sensor = Repeated::on(&session, &base, (&topic.for_robot(ROBOT), topic), far);
        eventually("the controller is received", || runner.messages().controller_digest != 0).await;
        let digest = runner.messages().controller_digest;
        runner.messages().digest = digest;
        runner.run_epoch(1).await;

        eventually("it turns right", || {
            wheels.is(|twist| (twist.linear.x, twist.angular.z) == (0.15, -0.75))
        })
        .await;
        sensor.change(|reading| reading.range = 0.59);
        eventually("it sees", || detection.is(|detection| detection.data)).await;
        eventually("it turns left", || {
            wheels.is(|twist| (twist.linear.x, twist.angular.z) == (0.15, 0.75))
        })
        .await;
        assert!(range.is(|range| range.range < 0.6 && range.header.frame_id == "robot_1/range"));

        drop(sensor);
        eventually("the wheels stand", || wheels.is(|twist| *twist == Twist::default())).await;
        let reason = runner.messages().status.stop_reason.clone();
        assert!(reason.contains("no valid reading of the sensor for more than 500 ms"), "{reason}");
        drop((node, runner));
        session.close().await;
    });
}

#[test]
fn a_laser_scanner_sees_what_is_ahead() {
    in_own_network("drivers::a_laser_scanner_sees_what_is_ahead", async || {
        let arguments = ["--driver", "ros", "--without-controller", "--ros-args"];
        let start_values = [
            ["-p", "ros.sensor_type:=laser_scan"],
            ["-p", "ros.sensor_topic:=lidar/scan"],
            ["-p", "ros.sector_half_angle:=0.3"],
        ];
        let node = Node::start(&[&arguments[..], start_values.as_flattened()].concat());
        let session = session();
        let base = session.node("/robot_1", "base").expect("the name is allowed");
        let detection = Last::<Bool>::new(&session, &base, topics::DETECTION);
        let behind = LaserScan {
            angle_min: -3.0,
            angle_increment: 0.5,
            range_min: 0.1,
            range_max: 8.0,
            // The seventh ray is straight ahead.
            ranges: vec![0.3, 0.3, 0.3, 0.3, 0.3, 0.3, f32::INFINITY, 0.3, 0.3, 0.3, 0.3, 0.3],
            ..LaserScan::default()
        };
        let topic = ("/robot_1/lidar/scan", topics::HARDWARE_SCAN);
        let scanner = Repeated::on(&session, &base, topic, behind);

        eventually("it sees nothing", || detection.is(|detection| !detection.data)).await;
        scanner.change(|scan| scan.ranges[6] = 0.5);
        eventually("it sees", || detection.is(|detection| detection.data)).await;

        drop((scanner, node));
        session.close().await;
    });
}

#[test]
fn a_sensor_that_decides_by_itself_is_believed_until_it_is_silent() {
    let name = "drivers::a_sensor_that_decides_by_itself_is_believed_until_it_is_silent";
    in_own_network(name, async || {
        let arguments = ["--driver", "ros", "--without-controller", "--ros-args"];
        let node = Node::start(&[&arguments[..], &["-p", "ros.sensor_type:=bool"]].concat());
        let session = session();
        let base = session.node("/robot_1", "base").expect("the name is allowed");
        let detection = Last::<Bool>::new(&session, &base, topics::DETECTION);
        let runner = Runner::start(&session, &base);
        let topic = topics::HARDWARE_DETECTION;
        let name = topic.for_robot(ROBOT);
        let camera = Repeated::on(&session, &base, (&name, topic), Bool { data: false });

        eventually("it sees nothing", || detection.is(|detection| !detection.data)).await;
        camera.change(|seen| seen.data = true);
        eventually("it sees", || detection.is(|detection| detection.data)).await;
        drop(camera);
        eventually("it is in fault", || runner.state() == RobotState::Fault).await;

        drop((runner, node));
        session.close().await;
    });
}

#[test]
fn further_sensors_of_a_microcontroller_have_a_topic_each_and_none_while_they_are_silent() {
    let name = "drivers::\
        further_sensors_of_a_microcontroller_have_a_topic_each_and_none_while_they_are_silent";
    in_own_network(name, async || {
        let socket = Socket::new();
        let micro = Micro::plug_in(&socket.path());
        micro.inside().further = ",wall=1,object=0";
        let port = socket.path().display().to_string();
        let arguments = ["--driver", "serial", "--port", &port, "--without-controller"];
        let node = Node::start(&arguments);
        let session = session();
        let visitor = session.node("/", "visitor").expect("the name is allowed");
        let of = |name: &'static str| {
            let topic = Topic { name, qos: topics::DETECTION.qos, ..topics::FURTHER_DETECTION };
            Last::<Bool>::new(&session, &visitor, topic)
        };
        let (wall, object) = (of("detection/wall"), of("detection/object"));

        eventually("both are known", || wall.is(|it| it.data) && object.is(|it| !it.data)).await;
        micro.inside().further = ",object=1";
        eventually("the object is there", || object.is(|it| it.data)).await;
        eventually("nothing is known of the wall", || wall.is_silent_for(SILENCE)).await;
        assert!(!object.is_silent_for(SILENCE));
        // Seven may be named, and two were.
        let (last, too_many) = (of("detection/e"), of("detection/f"));
        micro.inside().further = ",object=1,a=1,b=1,c=1,d=1,e=1,f=1,g=1";
        eventually("the last that may be is there", || last.is(|it| it.data)).await;
        eventually("and goes on", || last.is(|it| it.data) && !object.is_silent_for(SILENCE)).await;
        assert!(!too_many.is(|_| true), "one too many has a topic");

        drop((node, micro));
        session.close().await;
    });
}

#[test]
fn a_robot_of_the_simulator_is_gated_as_a_real_one() {
    in_own_network("drivers::a_robot_of_the_simulator_is_gated_as_a_real_one", async || {
        let node = Node::start(&["--driver", "virtual", "--without-controller"]);
        let session = session();
        let world = session.node("/", "world").expect("the name is allowed");
        let wheels = Last::<TwistStamped>::new(&session, &world, topics::HARDWARE_CMD_VEL);
        let detection = Last::<Bool>::new(&session, &world, topics::DETECTION);
        let runner = Runner::start(&session, &world);
        let topic = topics::VIRTUAL_DETECTION;
        let name = topic.for_robot(ROBOT);
        let _eyes = Repeated::on(&session, &world, (&name, topic), Bool { data: true });
        runner.messages().foreign_controller = Some(DIGEST);
        runner.messages().command = Some((0.1, 0.5));

        eventually("it sees", || detection.is(|detection| detection.data)).await;
        eventually("it stands without a lease", || {
            wheels.is(|wheels| wheels.twist == Twist::default())
        })
        .await;
        runner.run_epoch(1).await;
        eventually("it moves", || {
            wheels.is(|wheels| (wheels.twist.linear.x, wheels.twist.angular.z) == (0.1, 0.5))
        })
        .await;
        runner.messages().e_stop = Some(true);
        eventually("it stands", || wheels.is(|wheels| wheels.twist == Twist::default())).await;

        drop((node, runner));
        session.close().await;
    });
}
