//! A run in real time, with the test as every controller and the runner.

use std::time::{Duration, Instant};

use rsrs_fleet::timing::LEASE_DURATION;
use rsrs_fleet::wire;
use rsrs_msgs::geometry_msgs::{Twist, TwistStamped};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rosgraph_msgs::Clock;
use rsrs_msgs::rsrs::{LeaseState, RobotState, RobotStatus, RunLease, WorldDigest};
use rsrs_msgs::std_msgs::{Bool, Header};
use rsrs_msgs::topics;
use rsrs_ros::clock::wall_time;
use rsrs_ros::session::{NodeHandle, Publisher, Session};

use crate::fleet::{
    FORWARD, Latest, ROBOTS, World, armed_lease, conditions, controller_status, publisher, start,
    until_it_listens,
};
use rsrs_testing::network::{TIMEOUT, eventually, in_own_network, session};

/// Interval of the leases, commands and controllers' statuses.
const BEAT: Duration = Duration::from_millis(50);
/// What a busy machine may take on top of the protocol's times.
const MARGIN: Duration = Duration::from_millis(1500);

#[test]
fn in_real_time_robots_move_while_their_gates_let_them_and_stand_within_the_lease_time() {
    in_own_network(
        "real_time::in_real_time_robots_move_while_their_gates_let_them_and_stand_within_the_lease_time",
        run,
    );
}

async fn run() {
    let _simulator = start();
    let session = session();
    let node = session.node("/", "fleet_runner").expect("the name is allowed");
    let seen = Seen {
        simulator: Latest::new(&session, &node, topics::SIMULATOR_STATUS),
        robots: Latest::new(&session, &node, topics::STATUS),
        odom: Latest::new(&session, &node, topics::ODOM),
        detections: Latest::new(&session, &node, topics::DETECTION),
        digest: Latest::new(&session, &node, topics::WORLD_DIGEST),
        clock: Latest::new(&session, &node, topics::CLOCK),
    };
    until_it_listens(&session).await;
    let world = World { conditions: conditions(), steps: 0, time: "real_time" };
    world.place(&session, &node).await.expect("the world can be placed");

    seen.stands_and_senses_before_the_start(world.digest()).await;
    // Controllers may come later than the world.
    let mut fleet_runner = FleetRunner::new(&session, &node, &seen.robots);
    until_a_twist_is_received(&session).await;
    fleet_runner.until(|| seen.robots.all_in_state(RobotState::Armed)).await;
    fleet_runner.lease.state = u8::from(LeaseState::Running);
    seen.moves(&mut fleet_runner).await;
    seen.one_that_receives_no_command_stands(&mut fleet_runner).await;
    seen.stops_without_leases(&world, &mut fleet_runner).await;
    seen.stays_when_leases_come_back(&mut fleet_runner).await;

    assert!(seen.clock.only().is_none(), "in real time nobody publishes /clock");
    session.close().await;
}

/// What is received from the simulator and its robots.
struct Seen {
    simulator: Latest<RobotStatus>,
    robots: Latest<RobotStatus>,
    odom: Latest<Odometry>,
    detections: Latest<Bool>,
    digest: Latest<WorldDigest>,
    clock: Latest<Clock>,
}

impl Seen {
    async fn stands_and_senses_before_the_start(&self, digest: u64) {
        let armed = self.simulator.in_state(RobotState::Armed).await;
        assert_eq!(armed.parameter_digest, digest);
        let all_speak = || {
            let odoms = self.odom.places();
            odoms.iter().all(Option::is_some)
                && ROBOTS.iter().all(|robot| self.detections.get(robot).is_some())
        };
        eventually("every robot senses", all_speak).await;
        let places = self.odom.places();

        tokio::time::sleep(Duration::from_millis(500)).await;

        assert_eq!(self.odom.places(), places, "nobody moves before the start");
        assert_eq!(self.digest.only().expect("it comes with every period").step, 1);
    }

    async fn moves(&self, fleet_runner: &mut FleetRunner<'_>) {
        let start = self.odom.places();
        let has_moved = |robot: usize| {
            let (from, to) = (start[robot], self.odom.place(ROBOTS[robot]));
            let (from, to) = (from.expect("it was there"), to.expect("it is there"));
            libm::hypot(to[0] - from[0], to[1] - from[1]) > 0.05
        };

        // The third robot's commands carry no stamp.
        fleet_runner.until(|| (0..ROBOTS.len()).all(has_moved)).await;

        assert_eq!(
            self.simulator.only().expect("it publishes").state,
            u8::from(RobotState::Moving)
        );
        let odometry = self.odom.get(ROBOTS[2]).expect("it has moved");
        assert_eq!(wire::command(&odometry.twist.twist), Ok(FORWARD));
        assert_eq!(odometry.child_frame_id, "robot_3/base_link");
        let age_ns = wall_time().to_nanos().zip(odometry.header.stamp.to_nanos());
        let age_ns = age_ns.map(|(now_ns, stamp_ns)| now_ns.abs_diff(stamp_ns));
        assert!(age_ns.is_some_and(|age_ns| age_ns < 5_000_000_000), "{age_ns:?}");
    }

    async fn one_that_receives_no_command_stands(&self, fleet_runner: &mut FleetRunner<'_>) {
        fleet_runner.silent = Some(0);
        let stands = || {
            let odometry = self.odom.get(ROBOTS[0]).expect("it has moved");
            odometry.twist.twist == Twist::default()
        };
        fleet_runner.until(stands).await;
        let (first, second) = (self.odom.place(ROBOTS[0]), self.odom.place(ROBOTS[1]));

        fleet_runner.until(|| self.odom.place(ROBOTS[1]) != second).await;

        let (now, then) = (self.odom.place(ROBOTS[0]).expect("it is there"), first);
        let then = then.expect("it was there");
        assert_eq!(now[..2], then[..2], "it stands while the others go on");
    }

    async fn stops_without_leases(&self, world: &World, fleet_runner: &mut FleetRunner<'_>) {
        let silence = Instant::now();
        fleet_runner.runner = Runner::Dead;
        fleet_runner.until(|| self.robots.all_in_state(RobotState::Stopped)).await;
        let stopped = self.simulator.in_state(RobotState::Stopped).await;
        assert!(silence.elapsed() < LEASE_DURATION + MARGIN, "{:?}", silence.elapsed());
        assert_eq!(stopped.stop_reason, "every robot has stopped");
        assert_eq!(stopped.parameter_digest, world.digest());

        // The last step's poses may still be under way.
        tokio::time::sleep(Duration::from_millis(300)).await;
        let (places, digest) = (self.odom.places(), self.digest.only());
        tokio::time::sleep(Duration::from_millis(500)).await;
        assert_eq!(self.odom.places(), places, "robots that have stopped stay where they are");
        assert_eq!(self.digest.only(), digest);
        assert!(self.digest.only().is_some_and(|digest| digest.step > 5), "{digest:?}");
        let odometry = self.odom.get(ROBOTS[1]).expect("sensors go on");
        assert_eq!(odometry.twist.twist, Twist::default());
    }

    async fn stays_when_leases_come_back(&self, fleet_runner: &mut FleetRunner<'_>) {
        let places = self.odom.places();
        fleet_runner.runner = Runner::Alive;
        for _ in 0..10 {
            fleet_runner.beat().await;
            tokio::time::sleep(BEAT).await;
        }
        assert!(self.robots.all_in_state(RobotState::Stopped), "a lapse is a stop");
        assert_eq!(self.odom.places(), places);
    }
}

/// Waits until the simulator listens to the third robot's commands as what they are.
async fn until_a_twist_is_received(session: &Session) {
    let topic = topics::CMD_VEL_UNSTAMPED;
    let is_received = || {
        session.endpoints().iter().any(|endpoint| {
            endpoint.topic == topic.for_robot(ROBOTS[2])
                && endpoint.type_name == topic.type_name
                && endpoint.kind == rsrs_ros::session::EndpointKind::Reader
        })
    };
    eventually("unstamped commands are received", is_received).await;
}

/// Whether leases come.
#[derive(PartialEq)]
enum Runner {
    Alive,
    Dead,
}

/// The runner and the controllers in one. It goes quiet when nobody waits in it.
struct FleetRunner<'a> {
    runner: Runner,
    robots: &'a Latest<RobotStatus>,
    lease: RunLease,
    /// A robot that gets no command.
    silent: Option<usize>,
    leases: Publisher<RunLease>,
    controllers: Vec<Publisher<RobotStatus>>,
    stamped: Vec<Publisher<TwistStamped>>,
    unstamped: Publisher<Twist>,
}

impl<'a> FleetRunner<'a> {
    fn new(session: &Session, node: &NodeHandle, robots: &'a Latest<RobotStatus>) -> Self {
        let status = topics::CONTROLLER_STATUS;
        Self {
            runner: Runner::Alive,
            robots,
            lease: armed_lease(),
            silent: None,
            leases: publisher(session, node, topics::LEASE, ROBOTS[0]),
            controllers: ROBOTS.map(|robot| publisher(session, node, status, robot)).into(),
            stamped: ROBOTS[..2]
                .iter()
                .map(|robot| publisher(session, node, topics::CMD_VEL, robot))
                .collect(),
            unstamped: publisher(session, node, topics::CMD_VEL_UNSTAMPED, ROBOTS[2]),
        }
    }

    /// Runs until a condition holds.
    async fn until(&mut self, condition: impl Fn() -> bool) {
        let start = Instant::now();
        while !condition() {
            assert!(start.elapsed() < TIMEOUT, "what was waited for never came true");
            self.beat().await;
            tokio::time::sleep(BEAT).await;
        }
    }

    async fn beat(&mut self) {
        for (robot, echo) in ROBOTS.iter().zip(&mut self.lease.echoed_counter) {
            *echo = self.robots.get(robot).map_or(0, |status| status.counter);
        }
        if self.runner == Runner::Alive {
            self.leases.publish(self.lease.clone()).await.expect("a healthy network");
        }
        let parameter_digest = self.lease.parameter_digest;
        for controller in &self.controllers {
            let status = controller_status(parameter_digest);
            controller.publish(status).await.expect("a healthy network");
        }
        let twist = wire::twist(FORWARD);
        for (robot, publisher) in self.stamped.iter().enumerate() {
            if self.silent != Some(robot) {
                let header = Header { stamp: wall_time(), ..Header::default() };
                let message = TwistStamped { header, twist };
                publisher.publish(message).await.expect("a healthy network");
            }
        }
        self.unstamped.publish(twist).await.expect("a healthy network");
    }
}
