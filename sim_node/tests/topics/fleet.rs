//! The simulator's process, its world, and what is received from it.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};

use rsrs_core::conditions::Conditions;
use rsrs_core::robot::controller::Command;
use rsrs_fleet::simulator::placement_digest;
use rsrs_msgs::RosMessage;
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::{LeaseState, RobotState, RobotStatus, RunLease};
use rsrs_msgs::topics::{self, Topic};
use rsrs_ros::clock::wall_time;
use rsrs_ros::parameters::{ClientOptions, ParameterClient, ParameterValue};
use rsrs_ros::session::{NodeHandle, Publisher, Received, Session, Subscription};
use rsrs_sim::draw::Seed;

use rsrs_testing::conditions::measured_flockbots;
use rsrs_testing::network::{NodeProcess, TIMEOUT, eventually};

pub const ROBOTS: [&str; 3] = ["robot_1", "robot_2", "robot_3"];
pub const SEED: Seed = Seed { seed: 11, replicate: 4 };
/// What every robot is commanded where nobody decides.
pub const FORWARD: Command = Command { speed_m_s: 0.15, turn_rate_rad_s: 0.75 };

pub fn start() -> NodeProcess {
    start_with(&ROBOTS.join(","))
}

pub fn start_with(robots: &str) -> NodeProcess {
    NodeProcess::start(robots, &[])
}

/// Three Flockbots as measured.
pub fn conditions() -> Conditions {
    measured_flockbots(3)
}

/// What the simulator is asked to place.
pub struct World {
    pub conditions: Conditions,
    pub steps: u64,
    pub time: &'static str,
}

impl World {
    pub fn digest(&self) -> u64 {
        placement_digest(&self.conditions, SEED.seed, SEED.replicate, self.steps)
    }

    /// Sets the simulator's parameters, all at once; the answer if it refuses.
    pub async fn place(&self, session: &Session, node: &NodeHandle) -> Result<(), String> {
        set_all(session, node, &self.values()).await
    }

    /// The simulator's parameters.
    pub fn values(&self) -> Vec<(String, ParameterValue)> {
        let json = serde_json::to_string(&self.conditions).expect("conditions are plain data");
        values(&json, self.steps, self.time)
    }
}

/// Sets the simulator's parameters to a text of conditions.
pub async fn set(
    session: &Session,
    node: &NodeHandle,
    conditions: &str,
    steps: u64,
    time: &str,
) -> Result<(), String> {
    set_all(session, node, &values(conditions, steps, time)).await
}

fn values(conditions: &str, steps: u64, time: &str) -> Vec<(String, ParameterValue)> {
    let integer = |value: u64| ParameterValue::Integer(value.cast_signed());
    vec![
        ("conditions".to_owned(), ParameterValue::String(conditions.to_owned())),
        ("seed".to_owned(), integer(SEED.seed)),
        ("replicate".to_owned(), integer(SEED.replicate)),
        ("steps".to_owned(), integer(steps)),
        ("time".to_owned(), ParameterValue::String(time.to_owned())),
    ]
}

/// Sets parameters of the simulator, all at once.
pub async fn set_all(
    session: &Session,
    node: &NodeHandle,
    values: &[(String, ParameterValue)],
) -> Result<(), String> {
    let client =
        ParameterClient::new(session, node, ClientOptions { timeout: TIMEOUT, mapping: None });
    client.set_atomically("/simulator", values).await.map_err(|error| format!("{error:?}"))
}

/// The newest message of every topic that a test subscribes to.
pub struct Latest<M> {
    messages: Arc<Mutex<BTreeMap<String, M>>>,
    _subscriptions: Vec<Subscription>,
}

impl<M: RosMessage + Clone + Send + 'static> Latest<M> {
    /// Subscribes to a topic of every robot, or to the one of the swarm.
    pub fn new(session: &Session, node: &NodeHandle, topic: Topic) -> Self {
        let robots = if topic.is_absolute() { &ROBOTS[..1] } else { &ROBOTS[..] };
        Self::at(session, node, topic, robots)
    }

    /// Subscribes to a topic of these robots.
    pub fn at(session: &Session, node: &NodeHandle, topic: Topic, robots: &[&str]) -> Self {
        let messages = Arc::new(Mutex::new(BTreeMap::new()));
        let subscribe = |robot: &&str| {
            let (messages, key) = (Arc::clone(&messages), (*robot).to_owned());
            let deliver = move |sample: Received<M>| {
                let mut messages = messages.lock().expect("no test panics while it looks");
                messages.insert(key.clone(), sample.message);
            };
            session.subscribe(node, &topic.for_robot(robot), topic.qos, deliver)
        };
        let subscriptions = robots.iter().map(subscribe).collect::<Result<_, _>>();
        Self { messages, _subscriptions: subscriptions.expect("the topics are allowed") }
    }

    /// The newest message of a robot's topic.
    pub fn get(&self, robot: &str) -> Option<M> {
        self.messages.lock().expect("no test panics while it looks").get(robot).cloned()
    }

    /// The newest message of the swarm's topic.
    pub fn only(&self) -> Option<M> {
        self.get(ROBOTS[0])
    }
}

impl Latest<RobotStatus> {
    /// Waits until the simulator reports that it is in a state, and returns that status.
    pub async fn in_state(&self, state: RobotState) -> RobotStatus {
        let is_reported = || self.only().is_some_and(|status| status.state == state);
        eventually(&format!("the simulator is in state {state}"), is_reported).await;
        self.only().expect("it has just been there")
    }

    /// Whether every robot is in a state.
    pub fn all_in_state(&self, state: RobotState) -> bool {
        ROBOTS.iter().all(|robot| self.get(robot).is_some_and(|status| status.state == state))
    }
}

impl Latest<Odometry> {
    /// Position and orientation of a robot.
    pub fn place(&self, robot: &str) -> Option<[f64; 4]> {
        let pose = self.get(robot)?.pose.pose;
        Some([pose.position.x, pose.position.y, pose.orientation.z, pose.orientation.w])
    }

    /// Position and orientation of every robot.
    pub fn places(&self) -> Vec<Option<[f64; 4]>> {
        ROBOTS.iter().map(|robot| self.place(robot)).collect()
    }
}

pub fn publisher<M: RosMessage>(
    session: &Session,
    node: &NodeHandle,
    topic: Topic,
    robot: &str,
) -> Publisher<M> {
    session.publish_on(node, &topic.for_robot(robot), topic.qos).expect("the topic is allowed")
}

/// What a controller with these parameters reports now that it is armed by [`armed_lease`].
pub fn controller_status(parameter_digest: u64) -> RobotStatus {
    let counter = rsrs_fleet::wire::first_counter(wall_time());
    RobotStatus { counter, epoch: 1, parameter_digest, ..RobotStatus::default() }
}

/// A lease that arms every robot.
pub fn armed_lease() -> RunLease {
    RunLease {
        run_id: "run".to_owned(),
        epoch: 1,
        state: u8::from(LeaseState::Armed),
        parameter_digest: conditions().controller.digest(),
        robots: ROBOTS.iter().map(|robot| (*robot).to_owned()).collect(),
        echoed_counter: vec![0; ROBOTS.len()],
        ..RunLease::default()
    }
}

/// Waits until the simulator receives all that a fleet runner publishes.
pub async fn until_it_listens(session: &Session) {
    for topic in [topics::LEASE, topics::RECORDED] {
        session.wait_for_readers(topic.name, 1, TIMEOUT).await.expect("the simulator subscribes");
    }
    for robot in ROBOTS {
        for topic in [topics::CMD_VEL, topics::CONTROLLER_STATUS] {
            let name = topic.for_robot(robot);
            session.wait_for_readers(&name, 1, TIMEOUT).await.expect("the simulator subscribes");
        }
    }
}
