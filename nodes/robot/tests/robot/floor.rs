//! The rest of a fleet for one robot: a runner with its lease, and a node process that dies with
//! its test.

use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rsrs_msgs::geometry_msgs::{Twist, TwistStamped, Vector3};
use rsrs_msgs::rsrs::{RobotStatus, RunLease};
use rsrs_msgs::std_msgs::{Bool, Header};
use rsrs_msgs::topics;
use rsrs_ros::clock::wall_time;
use rsrs_ros::session::{NodeHandle, Publisher, Session, Subscription};
use tokio::task::JoinHandle;

use rsrs_testing::network::TIMEOUT;

/// The robot of all tests.
pub const ROBOT: &str = "robot_1";
/// Digest that the runner and the foreign controller agree upon.
pub const DIGEST: u64 = 7;
const BEAT: Duration = Duration::from_millis(100);

/// The node's process, ended with the test whatever happens.
pub struct Node(pub Child);

impl Node {
    pub fn start(arguments: &[&str]) -> Self {
        let child = Command::new(env!("CARGO_BIN_EXE_robot_node"))
            .args(["--interface", "127.0.0.1", "--robots", ROBOT])
            .args(arguments)
            .env("ROS_DOMAIN_ID", "42")
            .stdout(Stdio::null())
            .spawn()
            .expect("the node was built for this test");
        Self(child)
    }

    pub fn signal(&self, signal: libc::c_int) {
        let pid = libc::pid_t::try_from(self.0.id()).expect("process numbers fit");
        // SAFETY: sends a signal to our own child, which has not been waited for.
        let sent = unsafe { libc::kill(pid, signal) };
        assert_eq!(sent, 0);
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

/// What the runner says, and what it received.
#[derive(Debug, Default)]
pub struct Said {
    /// `None` is silence.
    pub lease: Option<(u64, u8)>,
    /// The digest of the lease.
    pub digest: u64,
    /// Digest of a controller outside the robot's process; `None` if there is none.
    pub foreign_controller: Option<u64>,
    /// What is said on the e-stop topic; `None` is silence.
    pub e_stop: Option<bool>,
    /// What is said on `cmd_vel` with every beat; `None` is silence.
    pub command: Option<(f64, f64)>,
    pub status: RobotStatus,
    /// Digest of the controller in the robot's process.
    pub controller_digest: u64,
}

/// A runner, and a controller if it is told to play one.
pub struct Runner {
    printed: Arc<Mutex<Said>>,
    task: JoinHandle<()>,
    _subscriptions: [Subscription; 2],
}

impl Runner {
    pub fn start(session: &Session, node: &NodeHandle) -> Self {
        let printed = Arc::new(Mutex::new(Said { digest: DIGEST, ..Said::default() }));
        let (to_status, to_controller) = (Arc::clone(&printed), Arc::clone(&printed));
        let (status, controller) = (topics::STATUS, topics::CONTROLLER_STATUS);
        let subscriptions = [
            session
                .subscribe(node, &status.for_robot(ROBOT), status.qos, move |sample| {
                    lock(&to_status).status = sample.message;
                })
                .expect("the topic is allowed"),
            session
                .subscribe(node, &controller.for_robot(ROBOT), controller.qos, move |sample| {
                    let status: RobotStatus = sample.message;
                    lock(&to_controller).controller_digest = status.parameter_digest;
                })
                .expect("the topic is allowed"),
        ];
        let publishers = Publishers::new(session, node);
        let task = tokio::spawn(speak(publishers, Arc::clone(&printed)));
        Self { printed, task, _subscriptions: subscriptions }
    }

    pub fn printed(&self) -> MutexGuard<'_, Said> {
        lock(&self.printed)
    }

    pub fn state(&self) -> u8 {
        self.printed().status.state
    }

    /// Arms an epoch, waits for the robot to arm, and runs.
    pub async fn run_epoch(&self, epoch: u64) {
        self.printed().lease = Some((epoch, RunLease::ARMED));
        self.says("armed", |status| (status.state, status.epoch) == (RobotStatus::ARMED, epoch))
            .await;
        self.printed().lease = Some((epoch, RunLease::RUNNING));
        self.says("moving", |status| status.state == RobotStatus::MOVING).await;
    }

    /// Waits for a status.
    pub async fn says(&self, what: &str, is_so: impl Fn(&RobotStatus) -> bool) {
        let start = Instant::now();
        while !is_so(&self.printed().status) {
            let received = self.printed().status.clone();
            assert!(start.elapsed() < TIMEOUT, "the robot is not {what}, it says {received:?}");
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }
}

impl Drop for Runner {
    fn drop(&mut self) {
        self.task.abort();
    }
}

fn lock(printed: &Mutex<Said>) -> MutexGuard<'_, Said> {
    printed.lock().unwrap_or_else(PoisonError::into_inner)
}

struct Publishers {
    lease: Publisher<RunLease>,
    e_stop: Publisher<Bool>,
    controller: Publisher<RobotStatus>,
    command: Publisher<TwistStamped>,
}

impl Publishers {
    fn new(session: &Session, node: &NodeHandle) -> Self {
        let why = "the topic is allowed";
        let (lease, e_stop) = (topics::LEASE, topics::E_STOP);
        let (status, command) = (topics::CONTROLLER_STATUS, topics::CMD_VEL);
        Self {
            lease: session.publish_on(node, lease.name, lease.qos).expect(why),
            e_stop: session.publish_on(node, e_stop.name, e_stop.qos).expect(why),
            controller: session.publish_on(node, &status.for_robot(ROBOT), status.qos).expect(why),
            command: session.publish_on(node, &command.for_robot(ROBOT), command.qos).expect(why),
        }
    }
}

async fn speak(publishers: Publishers, printed: Arc<Mutex<Said>>) {
    let why = "a healthy network";
    let mut beat = tokio::time::interval(BEAT);
    let mut epoch = 0;
    loop {
        beat.tick().await;
        let (lease, foreign, e_stop, command) = {
            let printed = lock(&printed);
            let lease = printed.lease.map(|(epoch, state)| RunLease {
                run_id: format!("run {epoch}"),
                epoch,
                state,
                parameter_digest: printed.digest,
                robots: vec![ROBOT.to_owned()],
                echoed_counter: vec![printed.status.counter],
                ..RunLease::default()
            });
            (lease, printed.foreign_controller, printed.e_stop, printed.command)
        };
        if let Some(parameter_digest) = foreign {
            let counter = rsrs_ros::wire::first_counter(wall_time());
            // A controller stays in the run that it was armed for last.
            epoch = lease.as_ref().map_or(epoch, |lease| lease.epoch);
            let status = RobotStatus { counter, epoch, parameter_digest, ..RobotStatus::default() };
            publishers.controller.publish(status).await.expect(why);
        }
        if let Some(lease) = lease {
            publishers.lease.publish(lease).await.expect(why);
        }
        if let Some(data) = e_stop {
            publishers.e_stop.publish(Bool { data }).await.expect(why);
        }
        if let Some((x, z)) = command {
            let twist = Twist {
                linear: Vector3 { x, ..Vector3::default() },
                angular: Vector3 { z, ..Vector3::default() },
            };
            publishers
                .command
                .publish(TwistStamped { header: Header::default(), twist })
                .await
                .expect(why);
        }
    }
}
