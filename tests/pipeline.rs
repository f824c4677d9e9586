//! The simulator and the controllers as processes over DDS, conducted by the test.

use crate::processes::in_own_network;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use rsrs_core::conditions::{Conditions, Settings};
use rsrs_core::quantity::Axis;
use rsrs_core::robot::harsher::HarsherFactors;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_msgs::RosMessage;
use rsrs_msgs::rsrs::{LeaseState, Recorded, RobotState, RobotStatus, RunLease, WorldDigest};
use rsrs_msgs::topics::{self, Topic};
use rsrs_ros::parameters::{ClientOptions, ParameterClient, ParameterValue};
use rsrs_ros::session::{NodeHandle, Publisher, Session, Subscription};
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::episode_digests;
use rsrs_testing::network::{TIMEOUT, eventually, session};
use tokio::sync::mpsc::{UnboundedSender, unbounded_channel};

const ROBOTS: [&str; 9] = [
    "robot_1", "robot_2", "robot_3", "robot_4", "robot_5", "robot_6", "robot_7", "robot_8",
    "robot_9",
];
const SEED: Seed = Seed { seed: 11, replicate: 4 };
/// 300 steps.
const DURATION_S: f64 = 39.0;

/// A node's process, ended with the test whatever happens.
struct Node(Child);

impl Drop for Node {
    fn drop(&mut self) {
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

fn start(node: &str, ros_args: &[&str]) -> Node {
    let child = Command::new(env!("CARGO_BIN_EXE_rsrs"))
        .args(["node", node, "--interface", "127.0.0.1", "--robots", &ROBOTS.join(",")])
        .arg("--ros-args")
        .args(ros_args)
        .env("ROS_DOMAIN_ID", "42")
        .stdout(Stdio::null())
        .spawn()
        .expect("the binary was built for this test");
    Node(child)
}

/// The default world: nine Flockbots, harsher than measured, at the paper's cell.
fn conditions() -> Conditions {
    let profile =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../launch_configs/profiles/flockbot.yaml");
    let text = std::fs::read_to_string(profile).expect("the profile is there");
    let measured = RobotProfile::parse("flockbot.yaml", &text).expect("the profile is good");
    let simulated = HarsherFactors::default().apply(&measured).expect("the defaults are harsher");
    let values = vec![
        (Axis::Speed, 0.15),
        (Axis::TurnRate, 0.75),
        (Axis::Robots, 9.0),
        (Axis::PlacementRadius, 0.825),
    ];
    Conditions::resolve(&simulated, &Settings { values, ..Settings::default() })
        .expect("the paper's cell can be simulated")
}

fn publisher<M: RosMessage>(session: &Session, node: &NodeHandle, topic: Topic) -> Publisher<M> {
    session.publish_on(node, topic.name, topic.qos).expect("the topic is allowed")
}

#[test]
fn a_lockstep_run_over_dds_passes_through_the_states_of_the_replicate() {
    in_own_network(async || {
        let conditions = conditions();
        let expected = episode_digests(&conditions, SEED, DURATION_S).expect("the robots fit");
        let _simulator = start("sim", &[]);
        let _controllers = start(
            "controller",
            &["-p", "speed:=0.15", "-p", "turn_rate:=0.75", "-p", "stamp_from_clock:=true"],
        );
        let session = session();
        let node = session.node("/", "campaign_runner").expect("the name is allowed");
        let (to_digests, mut digests) = unbounded_channel::<WorldDigest>();
        let topic = topics::WORLD_DIGEST;
        let _digests = session
            .subscribe(&node, topic.name, topic.qos, move |sample| {
                to_digests.send(sample.message).expect("the test listens to the end");
            })
            .expect("the topic is allowed");
        let (to_statuses, mut statuses) = unbounded_channel();
        let statuses_of_all = receive_robots(&session, &node, &to_statuses).await;
        let options = ClientOptions { timeout: TIMEOUT, mapping: None };
        let client = ParameterClient::new(&session, &node, options);
        place(&client, &conditions, expected.len()).await;

        let leases = publisher::<RunLease>(&session, &node, topics::LEASE);
        let recorded = publisher::<Recorded>(&session, &node, topics::RECORDED);
        session.wait_for_readers(topics::LEASE.name, 2, TIMEOUT).await.expect("nodes listen");
        let mut lease = armed_lease(&conditions);
        let mut states = [u8::from(RobotState::Idle); ROBOTS.len()];
        let mut seen: Vec<WorldDigest> = Vec::new();
        let mut beat = tokio::time::interval(Duration::from_millis(100));
        let run = async {
            while seen.len() < expected.len() {
                tokio::select! {
                    Some((robot, status)) = statuses.recv() => {
                        lease.echoed_counter[robot] = status.counter;
                        states[robot] = status.state;
                        if states.iter().all(|state| *state == RobotState::Armed) {
                            lease.state = u8::from(LeaseState::Running);
                        }
                    }
                    Some(digest) = digests.recv() => {
                        seen.push(digest);
                        recorded.publish(Recorded { step: digest.step }).await.expect("a healthy network");
                    }
                    _ = beat.tick() => leases.publish(lease.clone()).await.expect("a healthy network"),
                }
            }
        };
        tokio::time::timeout(TIMEOUT, run).await.expect("the run ends");

        let steps: Vec<u64> = seen.iter().map(|digest| digest.step).collect();
        assert_eq!(steps, (1..=expected.len() as u64).collect::<Vec<_>>());
        let bits: Vec<u64> = seen.iter().map(|digest| digest.digest).collect();
        assert!(bits == expected, "the states differ from those of the replicate");

        // Without leases, every robot stands within the lease time.
        let stands = || {
            while let Ok((robot, status)) = statuses.try_recv() {
                states[robot] = status.state;
            }
            states.iter().all(|state| *state == RobotState::Stopped)
        };
        eventually("all robots stand", stands).await;
        drop(statuses_of_all);
        session.close().await;
    });
}

/// Receives every robot's statuses, once every end of the lockstep has found its other end.
async fn receive_robots(
    session: &Session,
    node: &NodeHandle,
    statuses: &UnboundedSender<(usize, RobotStatus)>,
) -> Vec<Subscription> {
    let mut subscriptions = Vec::new();
    for (index, robot) in ROBOTS.iter().enumerate() {
        let statuses = statuses.clone();
        let topic = topics::STATUS;
        let subscription =
            session.subscribe(node, &topic.for_robot(robot), topic.qos, move |sample| {
                // The test has ended when nobody listens.
                drop(statuses.send((index, sample.message)));
            });
        subscriptions.push(subscription.expect("the topic is allowed"));
        let detection = topics::DETECTION.for_robot(robot);
        session.wait_for_readers(&detection, 1, TIMEOUT).await.expect("a controller listens");
        let cmd_vel = topics::CMD_VEL.for_robot(robot);
        session.wait_for_readers(&cmd_vel, 1, TIMEOUT).await.expect("the simulator listens");
    }
    subscriptions
}

fn armed_lease(conditions: &Conditions) -> RunLease {
    RunLease {
        run_id: "run".to_owned(),
        epoch: 1,
        state: u8::from(LeaseState::Armed),
        parameter_digest: conditions.controller.digest(),
        robots: ROBOTS.iter().map(|robot| (*robot).to_owned()).collect(),
        echoed_counter: vec![0; ROBOTS.len()],
        ..RunLease::default()
    }
}

async fn place(client: &ParameterClient<'_>, conditions: &Conditions, steps: usize) {
    let json = serde_json::to_string(conditions).expect("conditions are plain data");
    let integer = |value: u64| ParameterValue::Integer(value.cast_signed());
    let values = [
        ("conditions".to_owned(), ParameterValue::String(json)),
        ("seed".to_owned(), integer(SEED.seed)),
        ("replicate".to_owned(), integer(SEED.replicate)),
        ("steps".to_owned(), integer(steps as u64)),
    ];
    client.set_atomically("/simulator", &values).await.expect("the world can be placed");
    let impossible = [("conditions".to_owned(), ParameterValue::String("{}".to_owned()))];
    client.set_atomically("/simulator", &impossible).await.expect_err("that is no experiment");
}
