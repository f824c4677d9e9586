//! A run in lockstep, with the test as every controller, the runner and the recorder.

use std::time::Duration;

use rsrs_core::robot::controller::{Command, decide};
use rsrs_fleet::wire;
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::TwistStamped;
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::{LeaseState, Recorded, RobotState, RobotStatus, RunLease, WorldDigest};
use rsrs_msgs::std_msgs::{Bool, Header};
use rsrs_msgs::topics;
use rsrs_ros::session::{NodeHandle, Publisher, Received, Session, Subscription};
use rsrs_sim::episode::episode_digests;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};

use crate::fleet::{
    Latest, ROBOTS, SEED, World, armed_lease, conditions, controller_status, publisher, start,
    until_it_listens,
};
use rsrs_testing::network::{TIMEOUT, in_own_network, session};

const STEPS: u64 = 50;
/// The Flockbot's.
const PERIOD_NS: u64 = 130_000_000;

#[test]
fn in_lockstep_the_world_passes_through_the_states_of_the_replicate() {
    in_own_network(
        "lockstep::in_lockstep_the_world_passes_through_the_states_of_the_replicate",
        run,
    );
}

enum Input {
    Detection(usize, bool),
    Digest(WorldDigest),
    /// The command in the first robot's odometry.
    Obeyed(Command),
}

fn listen(
    session: &Session,
    node: &NodeHandle,
    received: &UnboundedSender<Input>,
) -> Vec<Subscription> {
    let mut subscriptions = Vec::new();
    for (index, robot) in ROBOTS.iter().enumerate() {
        let (to_received, topic) = (received.clone(), topics::DETECTION);
        // The test has ended when there is no receiver.
        let deliver = move |sample: Received<Bool>| {
            drop(to_received.send(Input::Detection(index, sample.message.data)));
        };
        subscriptions.push(session.subscribe(node, &topic.for_robot(robot), topic.qos, deliver));
    }
    let (to_received, topic) = (received.clone(), topics::WORLD_DIGEST);
    let deliver = move |sample: Received<WorldDigest>| {
        drop(to_received.send(Input::Digest(sample.message)));
    };
    subscriptions.push(session.subscribe(node, topic.name, topic.qos, deliver));
    let (to_received, topic) = (received.clone(), topics::ODOM);
    let deliver = move |sample: Received<Odometry>| {
        drop(to_received.send(Input::Obeyed(command_of(&sample.message))));
    };
    subscriptions.push(session.subscribe(node, &topic.for_robot(ROBOTS[0]), topic.qos, deliver));
    subscriptions.into_iter().map(|made| made.expect("the topics are allowed")).collect()
}

async fn run() {
    let _simulator = start();
    let session = session();
    let node = session.node("/", "fleet_runner").expect("the name is allowed");
    let simulator = Latest::<RobotStatus>::new(&session, &node, topics::SIMULATOR_STATUS);
    let robots = Latest::<RobotStatus>::new(&session, &node, topics::STATUS);
    let (to_received, mut received) = unbounded_channel();
    let subscriptions = listen(&session, &node, &to_received);
    let world = World { conditions: conditions(), steps: STEPS, time: "lockstep" };
    let duration_s = STEPS as f64 * world.conditions.period_s;
    let expected = episode_digests(&world.conditions, SEED, duration_s).expect("the robots fit");
    until_it_listens(&session).await;
    for topic in [topics::DETECTION, topics::ODOM] {
        let name = topic.for_robot(ROBOTS[0]);
        session.wait_for_writers(&name, 1, TIMEOUT).await.expect("the simulator publishes");
    }
    world.place(&session, &node).await.expect("the world can be placed");
    let armed = simulator.in_state(RobotState::Armed).await;
    assert_eq!(armed.parameter_digest, world.digest());

    let mut fleet_runner = FleetRunner::new(&session, &node, &robots);
    let run = fleet_runner.run(&mut received);
    tokio::time::timeout(TIMEOUT, run).await.expect("the run ends");

    let stopped = simulator.in_state(RobotState::Stopped).await;
    assert_eq!(stopped.stop_reason, "all steps are made");
    assert_eq!(stopped.parameter_digest, world.digest());
    let bits: Vec<u64> = fleet_runner.digests.iter().map(|digest| digest.digest).collect();
    assert!(bits == expected, "the states differ from those of the replicate");
    // The pose of a step comes with the command that led to it.
    let (obeyed, commanded) = (&fleet_runner.obeyed, &fleet_runner.commanded);
    assert_eq!(obeyed[0], Command::STOP);
    assert_eq!(obeyed[1..], commanded[..obeyed.len() - 1]);
    drop(subscriptions);
    session.close().await;
}

fn command_of(odometry: &Odometry) -> Command {
    assert_eq!(odometry.child_frame_id, "robot_1/base_link");
    wire::command(&odometry.twist.twist).expect("the twist is finite")
}

/// The runner, the controllers and the recorder in one.
struct FleetRunner<'a> {
    robots: &'a Latest<RobotStatus>,
    leases: Publisher<RunLease>,
    recorded: Publisher<Recorded>,
    controllers: Vec<Publisher<RobotStatus>>,
    commands: Vec<Publisher<TwistStamped>>,
    steps_answered: [u64; ROBOTS.len()],
    digests: Vec<WorldDigest>,
    /// What the first robot obeyed, by its odometry.
    obeyed: Vec<Command>,
    /// What it was commanded.
    commanded: Vec<Command>,
}

impl<'a> FleetRunner<'a> {
    fn new(session: &Session, node: &NodeHandle, robots: &'a Latest<RobotStatus>) -> Self {
        Self {
            robots,
            leases: publisher(session, node, topics::LEASE, ROBOTS[0]),
            recorded: publisher(session, node, topics::RECORDED, ROBOTS[0]),
            controllers: ROBOTS
                .map(|robot| publisher(session, node, topics::CONTROLLER_STATUS, robot))
                .into(),
            commands: ROBOTS.map(|robot| publisher(session, node, topics::CMD_VEL, robot)).into(),
            steps_answered: [0; ROBOTS.len()],
            digests: Vec::new(),
            obeyed: Vec::new(),
            commanded: Vec::new(),
        }
    }

    /// Leads the run until every digest has come, and every detection was answered.
    async fn run(&mut self, received: &mut UnboundedReceiver<Input>) {
        let mut lease = armed_lease();
        let mut beat = tokio::time::interval(Duration::from_millis(50));
        while (self.digests.len() as u64) < STEPS || self.steps_answered != [STEPS; ROBOTS.len()] {
            tokio::select! {
                Some(received) = received.recv() => self.receive(received).await,
                _ = beat.tick() => self.beat(&mut lease).await,
            }
        }
        // The pose is published before the digest, but on another topic.
        while (self.obeyed.len() as u64) < STEPS {
            self.receive(received.recv().await.expect("the subscriptions live")).await;
        }
    }

    async fn receive(&mut self, received: Input) {
        match received {
            Input::Detection(robot, detected) => {
                let command =
                    decide(detected, conditions().controller.parameters().expect("two commands"));
                self.steps_answered[robot] += 1;
                let step = self.steps_answered[robot];
                let stamp = Time::from_nanos(step * PERIOD_NS);
                let header = Header { stamp, ..Header::default() };
                let twist = wire::twist(command);
                let publisher = &self.commands[robot];
                publisher.publish(TwistStamped { header, twist }).await.expect("a healthy network");
                if robot == 0 {
                    self.commanded.push(command);
                }
            }
            Input::Digest(digest) => {
                self.digests.push(digest);
                let step = digest.step;
                self.recorded.publish(Recorded { step }).await.expect("a healthy network");
            }
            Input::Obeyed(command) => self.obeyed.push(command),
        }
    }

    async fn beat(&mut self, lease: &mut RunLease) {
        let parameter_digest = lease.parameter_digest;
        for controller in &self.controllers {
            let status = controller_status(parameter_digest);
            controller.publish(status).await.expect("a healthy network");
        }
        for (robot, echo) in ROBOTS.iter().zip(&mut lease.echoed_counter) {
            *echo = self.robots.get(robot).map_or(0, |status| status.counter);
        }
        if self.robots.all_in_state(RobotState::Armed) {
            lease.state = u8::from(LeaseState::Running);
        }
        self.leases.publish(lease.clone()).await.expect("a healthy network");
    }
}
