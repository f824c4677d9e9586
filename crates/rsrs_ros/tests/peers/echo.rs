//! Every topic there and back: made-up messages of ours, as another maker understands them.

use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::pin::Pin;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rsrs_msgs::topics::{self, Durability, Qos, Reliability, Topic};
use rsrs_msgs::{
    RosMessage, cdr, diagnostic_msgs, geometry_msgs, motion_capture_tracking_interfaces, nav_msgs,
    rcl_interfaces, rosgraph_msgs, rsrs, schema, sensor_msgs, std_msgs, tf2_msgs,
    visualization_msgs,
};
use rsrs_ros::session::{NodeHandle, Received, Session, Subscription};
use serde::Serialize;

use crate::peer::{Maker, Peer};
use crate::sampler::sample;
use rsrs_testing::network::{TIMEOUT, session};

/// Made-up messages for each topic: sequences of several lengths, strings that disturb alignment.
const N_SAMPLES: u64 = 4;
/// Pause between two samples of a topic; slower than what a depth of one still keeps.
const PAUSE: Duration = Duration::from_millis(60);

/// A topic as it is sent to the script.
#[derive(Serialize)]
struct Plan {
    name: String,
    type_name: &'static str,
    schema: String,
    reliable: bool,
    transient_local: bool,
    depth: u32,
}

impl Plan {
    fn new(topic: &Topic, index: usize) -> Self {
        let Qos { reliability, durability, depth } = topic.qos;
        // Some topics share a name, with two types: each has a robot of its own here, or another name.
        let is_shared = topics::ALL.iter().filter(|other| other.name == topic.name).count() > 1;
        // Further detections have the name of any reading.
        let name = topic.for_robot(&format!("robot_{index}")).replace('*', "wall");
        let is_absolute = topic.name.starts_with('/');
        Self {
            name: if is_shared && is_absolute { format!("{name}_{index}") } else { name },
            type_name: topic.type_name,
            schema: schema::schema_text(topic.type_name).expect("every topic's type has a schema"),
            reliable: reliability == Reliability::Reliable,
            transient_local: durability == Durability::TransientLocal,
            depth,
        }
    }
}

/// Ends in its publisher, which stays for the peer to look at.
type Task<'a> = Pin<Box<dyn Future<Output = Box<dyn Any>> + 'a>>;

/// Sends messages on every topic that the peer has a type for, until each has come back as it was.
pub async fn every_topic_both_ways(maker: Maker, python: &Path) {
    let ours = session();
    let node = ours.node("/", "ours").expect("the name is allowed");
    let has = |topic: &&Topic| maker.has(topic.type_name.split('/').next().unwrap_or_default());
    let chosen: Vec<(Plan, Topic)> = topics::ALL
        .iter()
        .filter(has)
        .enumerate()
        .map(|(index, topic)| (Plan::new(topic, index), *topic))
        .collect();
    let script = if maker == Maker::Cyclone { "cyclone_echo.py" } else { "rclpy_echo.py" };
    let mut peer = Peer::start(python, script);
    let plans: Vec<&Plan> = chosen.iter().map(|(plan, _)| plan).collect();

    let echoes: Vec<Task> =
        chosen.iter().map(|(plan, topic)| echo_of_topic(&ours, &node, plan, *topic)).collect();
    peer.send(&plans);
    let ready: String = peer.receive().await;
    assert_eq!(ready, "ready");
    let publishers = tokio::select! {
        publishers = futures::future::join_all(echoes) => publishers,
        line = peer.receive::<String>() => panic!("nothing more was expected, received {line}"),
    };

    let seen: BTreeMap<String, BTreeSet<(String, bool, bool)>> = peer.end().await;
    for plan in plans {
        let is = (plan.type_name.to_owned(), plan.reliable, plan.transient_local);
        let seen = &seen[&plan.name];
        // ros2-client has publishers of its own on `/rosout` and `/parameter_events`.
        assert!(
            seen.contains(&is),
            "{maker:?} sees {}, published as {is:?}, as {seen:?}",
            plan.name
        );
        assert!(seen.iter().all(|(type_name, ..)| type_name == plan.type_name), "{seen:?}");
    }
    drop(publishers);
    ours.close().await;
}

/// Makes the task of the topic's type.
fn echo_of_topic<'a>(
    ours: &'a Session,
    node: &'a NodeHandle,
    plan: &'a Plan,
    topic: Topic,
) -> Task<'a> {
    /// The task of the type whose name it is.
    macro_rules! of_type {
        ($($message:ty,)+) => {
            match topic.type_name {
                $(<$message as RosMessage>::TYPE_NAME => {
                    Box::pin(echo::<$message>(ours, node, plan, topic.qos))
                })+
                other => panic!("`{other}` is not among the types of this test"),
            }
        };
    }
    of_type! {
        diagnostic_msgs::DiagnosticArray,
        geometry_msgs::PoseArray,
        geometry_msgs::PoseStamped,
        geometry_msgs::Twist,
        geometry_msgs::TwistStamped,
        motion_capture_tracking_interfaces::NamedPoseArray,
        nav_msgs::Odometry,
        rcl_interfaces::Log,
        rcl_interfaces::ParameterEvent,
        rosgraph_msgs::Clock,
        rsrs::EStopLocks,
        rsrs::Recorded,
        rsrs::RobotStatus,
        rsrs::RunLease,
        rsrs::WorldDigest,
        sensor_msgs::LaserScan,
        sensor_msgs::Range,
        std_msgs::Bool,
        std_msgs::String,
        tf2_msgs::TFMessage,
        visualization_msgs::MarkerArray,
    }
}

/// What has come on a topic, as bytes.
type Come = Arc<Mutex<BTreeSet<Vec<u8>>>>;

async fn echo<M: RosMessage>(
    ours: &Session,
    node: &NodeHandle,
    plan: &Plan,
    qos: Qos,
) -> Box<dyn Any> {
    let messages: Vec<M> = (0..N_SAMPLES).map(sample).collect();
    let wanted: BTreeSet<Vec<u8>> = messages.iter().map(cdr::encode).collect();
    let publisher = ours.publish_on(node, &plan.name, qos).expect("the topic is allowed");
    let (come, _subscription) = listen::<M>(ours, node, plan, qos);

    let send = async {
        for message in messages.iter().cycle() {
            publisher.publish(message.clone()).await.expect("a healthy network");
            tokio::time::sleep(PAUSE).await;
            if wanted.is_subset(&come.lock().expect("nobody panics with it")) {
                return;
            }
        }
    };
    let sent = tokio::time::timeout(TIMEOUT, send).await;

    let n_come = wanted.intersection(&come.lock().expect("nobody panics with it")).count();
    assert!(sent.is_ok(), "{}: {n_come} of {N_SAMPLES} messages came back", plan.name);
    if qos.durability == Durability::TransientLocal {
        // Nobody publishes any more, and yet whoever comes now receives the echo.
        let (come, _subscription) = listen::<M>(ours, node, plan, qos);
        // As many of the last ones as the topic keeps.
        let kept = wanted.len().min(usize::try_from(qos.depth).expect("it is small"));
        let came = rsrs_testing::network::eventually("a late subscriber receives the echo", || {
            let come = come.lock().expect("nobody panics with it");
            come.len() >= kept && come.is_subset(&wanted)
        });
        came.await;
    }
    Box::new(publisher)
}

fn listen<M: RosMessage>(
    ours: &Session,
    node: &NodeHandle,
    plan: &Plan,
    qos: Qos,
) -> (Come, Subscription) {
    let come = Come::default();
    let to = Arc::clone(&come);
    let deliver = move |sample: Received<M>| {
        to.lock().expect("nobody panics with it").insert(cdr::encode(&sample.message));
    };
    let subscription = ours.subscribe(node, &format!("/echo{}", plan.name), qos, deliver);
    (come, subscription.expect("the topic is allowed"))
}
