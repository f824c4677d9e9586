//! Every controller, the runner and the recorder of a large simulated fleet, in one.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rsrs_core::conditions::{Conditions, Placement, Settings};
use rsrs_core::quantity::Axis;
use rsrs_core::robot::controller::decide;
use rsrs_fleet::wire;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::TwistStamped;
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::{LeaseState, Recorded, RobotState, RobotStatus, RunLease, WorldDigest};
use rsrs_msgs::std_msgs::{Bool, Header};
use rsrs_msgs::topics::{self, Qos};
use rsrs_ros::parameters::{ClientOptions, ParameterClient, ParameterValue};
use rsrs_ros::session::{NodeHandle, Publisher, Received, Session, Subscription};
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use rsrs_testing::conditions::flockbot;
/// Interval of leases and of the controllers' statuses.
const BEAT: Duration = Duration::from_millis(100);
/// Of the only run.
const EPOCH: u64 = 1;
/// How long to wait for the simulator to listen and to answer.
const TIMEOUT: Duration = Duration::from_secs(30);

/// What a fleet went through.
#[derive(Clone, Copy, Debug)]
pub struct Report {
    /// Steps whose digest was received.
    pub steps: u64,
    /// Detections that were answered.
    pub detections: u64,
    /// Poses that were received.
    pub poses: u64,
    /// Robots that reported last that they obey their controllers.
    pub moving: usize,
    /// Samples that the middleware lost of detections, poses and digests.
    pub lost: u64,
    /// From the first step that was received to the last, in wall-clock time.
    pub took: Duration,
}

/// The pace of a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeMode {
    /// By the wall clock.
    RealTime,
    /// By the answers.
    Lockstep {
        /// Steps to make.
        steps: u64,
    },
}

enum Input {
    Detection(usize, bool),
    Digest(u64),
}

/// Leads a simulated fleet.
pub struct FleetRunner<'a> {
    session: &'a Session,
    node: NodeHandle,
    robots: Vec<String>,
    conditions: Conditions,
    pace: TimeMode,
    /// Of the controllers' statuses, which are all sent at once.
    beats: u64,
    /// The last status of each robot.
    statuses: Arc<Mutex<Vec<RobotStatus>>>,
    poses: Arc<AtomicU64>,
    received: UnboundedReceiver<Input>,
    /// On topics that are to lose nothing.
    subscriptions: Vec<Subscription>,
    _to_statuses: Vec<Subscription>,
    commands: Vec<Publisher<TwistStamped>>,
    controllers: Vec<Publisher<RobotStatus>>,
    leases: Publisher<RunLease>,
    recorded: Publisher<Recorded>,
}

/// The names of so many robots.
pub fn names(n_robots: usize) -> Vec<String> {
    (1..=n_robots).map(|robot| format!("robot_{robot}")).collect()
}

/// So many Flockbots as measured, each with about the room of the paper's nine.
pub fn conditions(n_robots: usize) -> Conditions {
    let profile = flockbot();
    let values = vec![
        (Axis::Speed, 0.15),
        (Axis::TurnRate, 0.75),
        (Axis::Robots, n_robots as f64),
        (Axis::Arena, 60.0),
    ];
    let settings = Settings { values, ..Settings::default() };
    let mut conditions =
        Conditions::resolve(&profile, &settings).expect("so many robots can be simulated");
    let radius_m = 0.25 * (n_robots as f64).sqrt() + 0.3;
    conditions.placement = Placement::DiscFacingOut { radius_m };
    conditions
}

impl<'a> FleetRunner<'a> {
    /// Connects to a simulator, and waits until it subscribes.
    pub async fn new(session: &'a Session, n_robots: usize, pace: TimeMode) -> Self {
        let node = session.node("/", "fleet_runner").expect("the name is allowed");
        let robots = names(n_robots);
        let (to_received, received) = unbounded_channel();
        let statuses = Arc::new(Mutex::new(vec![RobotStatus::default(); n_robots]));
        let poses = Arc::new(AtomicU64::new(0));
        let subscriptions = listen(session, &node, &robots, &to_received, &poses);
        let to_statuses = listen_to_statuses(session, &node, &robots, &statuses);
        let fleet_runner = Self {
            commands: of_each(session, &node, &robots, topics::CMD_VEL.name, topics::CMD_VEL.qos),
            controllers: of_each(
                session,
                &node,
                &robots,
                topics::CONTROLLER_STATUS.name,
                topics::CONTROLLER_STATUS.qos,
            ),
            leases: one(session, &node, topics::LEASE.name, topics::LEASE.qos),
            recorded: one(session, &node, topics::RECORDED.name, topics::RECORDED.qos),
            conditions: conditions(n_robots),
            session,
            node,
            robots,
            pace,
            beats: 0,
            statuses,
            poses,
            received,
            subscriptions,
            _to_statuses: to_statuses,
        };
        for robot in &fleet_runner.robots {
            for topic in [topics::CMD_VEL, topics::CONTROLLER_STATUS] {
                let name = topic.for_robot(robot);
                session.wait_for_readers(&name, 1, TIMEOUT).await.expect("it subscribes");
            }
            let name = topics::ODOM.for_robot(robot);
            session.wait_for_writers(&name, 1, TIMEOUT).await.expect("it publishes");
        }
        fleet_runner
    }

    /// Places the world.
    pub async fn place(&self) {
        let options = ClientOptions { timeout: TIMEOUT, mapping: None };
        let client = ParameterClient::new(self.session, &self.node, options);
        let json = serde_json::to_string(&self.conditions).expect("conditions are plain data");
        let (time, steps) = match self.pace {
            TimeMode::RealTime => ("real_time", 0),
            TimeMode::Lockstep { steps } => ("lockstep", steps),
        };
        let values = [
            ("conditions".to_owned(), ParameterValue::String(json)),
            ("steps".to_owned(), ParameterValue::Integer(steps.cast_signed())),
            ("time".to_owned(), ParameterValue::String(time.to_owned())),
        ];
        client.set_atomically("/simulator", &values).await.expect("the world can be placed");
    }

    /// Leads the fleet until `until` has passed, or all steps of a lockstep run are made.
    pub async fn run(&mut self, until: Duration) -> Report {
        let mut beat = tokio::time::interval(BEAT);
        beat.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
        let start = Instant::now();
        let mut lease = self.lease();
        let mut answered = vec![0; self.robots.len()];
        let (mut steps, mut first, mut last) = (0, None, None);
        let wanted = match self.pace {
            TimeMode::RealTime => u64::MAX,
            TimeMode::Lockstep { steps } => steps,
        };
        while start.elapsed() < until && steps < wanted {
            tokio::select! {
                Some(received) = self.received.recv() => match received {
                    Input::Detection(robot, detected) => {
                        answered[robot] += 1;
                        self.answer(robot, (detected, answered[robot])).await;
                    }
                    Input::Digest(step) => {
                        steps += 1;
                        last = Some(Instant::now());
                        first = first.or(last);
                        self.recorded.publish(Recorded { step }).await.expect("a healthy network");
                    }
                },
                _ = beat.tick() => self.beat(&mut lease).await,
            }
        }
        let lost = self.subscriptions.iter().map(|subscription| subscription.counts().lost).sum();
        let took = first.zip(last).map(|(first, last): (Instant, Instant)| last - first);
        Report {
            steps,
            detections: answered.iter().sum(),
            poses: self.poses.load(Ordering::Relaxed),
            moving: self
                .of_statuses(|status| status.state == RobotState::Moving)
                .iter()
                .filter(|moves| **moves)
                .count(),
            lost,
            took: took.unwrap_or_default(),
        }
    }

    /// Something of the last status of each robot.
    fn of_statuses<T>(&self, part: impl Fn(&RobotStatus) -> T) -> Vec<T> {
        self.statuses.lock().expect("nobody panics while it writes").iter().map(part).collect()
    }

    fn lease(&self) -> RunLease {
        RunLease {
            run_id: "scale".to_owned(),
            epoch: EPOCH,
            state: u8::from(LeaseState::Armed),
            parameter_digest: self.conditions.controller.digest(),
            robots: self.robots.clone(),
            echoed_counter: vec![0; self.robots.len()],
            ..RunLease::default()
        }
    }

    async fn answer(&self, robot: usize, (detected, step): (bool, u64)) {
        let period = Duration::from_secs_f64(self.conditions.period_s);
        let period_ns = u64::try_from(period.as_nanos()).expect("a period is short");
        let twist = wire::twist(decide(
            detected,
            self.conditions.controller.parameters().expect("two commands"),
        ));
        let header = Header { stamp: Time::from_nanos(step * period_ns), ..Header::default() };
        let command = TwistStamped { header, twist };
        self.commands[robot].publish(command).await.expect("a healthy network");
    }

    async fn beat(&mut self, lease: &mut RunLease) {
        self.beats += 1;
        let status = RobotStatus {
            counter: self.beats,
            epoch: EPOCH,
            parameter_digest: lease.parameter_digest,
            state: u8::from(RobotState::Armed),
            ..RobotStatus::default()
        };
        for controller in &self.controllers {
            let status = status.clone();
            controller.publish(status).await.expect("a healthy network");
        }
        // Only who is armed may be started.
        let is_armed =
            |status: &RobotStatus| status.epoch == EPOCH && status.state == RobotState::Armed;
        if self.of_statuses(is_armed).iter().all(|is_armed| *is_armed) {
            lease.state = u8::from(LeaseState::Running);
        }
        lease.echoed_counter = self.of_statuses(|status| status.counter);
        self.leases.publish(lease.clone()).await.expect("a healthy network");
    }
}

fn listen(
    session: &Session,
    node: &NodeHandle,
    robots: &[String],
    received: &UnboundedSender<Input>,
    poses: &Arc<AtomicU64>,
) -> Vec<Subscription> {
    let mut made = Vec::new();
    for (index, robot) in robots.iter().enumerate() {
        let (to_received, topic) = (received.clone(), topics::DETECTION);
        // The fleet runner has ended when there is no receiver.
        let deliver = move |sample: Received<Bool>| {
            drop(to_received.send(Input::Detection(index, sample.message.data)));
        };
        made.push(session.subscribe(node, &topic.for_robot(robot), topic.qos, deliver));
        let (poses, topic) = (Arc::clone(poses), topics::ODOM);
        let deliver = move |_: Received<Odometry>| {
            poses.fetch_add(1, Ordering::Relaxed);
        };
        made.push(session.subscribe(node, &topic.for_robot(robot), topic.qos, deliver));
    }
    let (to_received, topic) = (received.clone(), topics::WORLD_DIGEST);
    let deliver = move |sample: Received<WorldDigest>| {
        drop(to_received.send(Input::Digest(sample.message.step)));
    };
    made.push(session.subscribe(node, topic.name, topic.qos, deliver));
    made.into_iter().map(|made| made.expect("the topics are allowed")).collect()
}

fn listen_to_statuses(
    session: &Session,
    node: &NodeHandle,
    robots: &[String],
    statuses: &Arc<Mutex<Vec<RobotStatus>>>,
) -> Vec<Subscription> {
    let listen = |(index, robot): (usize, &String)| {
        let (statuses, topic) = (Arc::clone(statuses), topics::STATUS);
        let deliver = move |sample: Received<RobotStatus>| {
            statuses.lock().expect("nobody panics while it writes")[index] = sample.message;
        };
        let subscription = session.subscribe(node, &topic.for_robot(robot), topic.qos, deliver);
        subscription.expect("the topic is allowed")
    };
    robots.iter().enumerate().map(listen).collect()
}

fn of_each<M: rsrs_msgs::RosMessage>(
    session: &Session,
    node: &NodeHandle,
    robots: &[String],
    name: &str,
    qos: Qos,
) -> Vec<Publisher<M>> {
    robots.iter().map(|robot| one(session, node, &format!("/{robot}/{name}"), qos)).collect()
}

fn one<M: rsrs_msgs::RosMessage>(
    session: &Session,
    node: &NodeHandle,
    name: &str,
    qos: Qos,
) -> Publisher<M> {
    session.publish_on(node, name, qos).expect("the topic is allowed")
}
