//! The rest of a fleet for one robot: a runner with its lease, and a node process that dies with
//! its test.

use std::process::ExitStatus;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rsrs_msgs::geometry_msgs::{Twist, TwistStamped, Vector3};
use rsrs_msgs::rsrs::{LeaseState, RobotState, RobotStatus, RunLease};
use rsrs_msgs::std_msgs::{Bool, Header};
use rsrs_msgs::topics;
use rsrs_ros::clock::wall_time;
use rsrs_ros::session::{NodeHandle, Publisher, Session, Subscription};
use tokio::task::JoinHandle;

use rsrs_testing::network::{NodeProcess, TIMEOUT};

/// The robot of all tests.
pub const ROBOT: &str = "robot_1";
/// Digest that the runner and the foreign controller agree upon.
pub const DIGEST: u64 = 7;
const BEAT: Duration = Duration::from_millis(100);

/// The robot's node.
pub struct Node(NodeProcess);

impl Node {
    pub fn start(arguments: &[&str]) -> Self {
        Self(NodeProcess::start(ROBOT, arguments))
    }

    pub fn id(&self) -> u32 {
        self.0.0.id()
    }

    pub fn wait(&mut self) -> ExitStatus {
        self.0.0.wait().expect("the node is our child")
    }

    #[expect(unsafe_code, reason = "a system call without a safe wrapper")]
    pub fn signal(&self, signal: libc::c_int) {
        let pid = libc::pid_t::try_from(self.id()).expect("process numbers fit");
        // SAFETY: sends a signal to our own child, which has not been waited for.
        let sent = unsafe { libc::kill(pid, signal) };
        assert_eq!(sent, 0);
    }
}

/// What the runner publishes, and what it received.
#[derive(Debug, Default)]
pub struct RunnerMessages {
    /// `None` is silence.
    pub lease: Option<(u64, u8)>,
    /// The digest of the lease.
    pub digest: u64,
    /// Digest of a controller outside the robot's process; `None` if there is none.
    pub foreign_controller: Option<u64>,
    /// What is published on the e-stop topic; `None` is silence.
    pub e_stop: Option<bool>,
    /// What is published on `cmd_vel` with every beat; `None` is silence.
    pub command: Option<(f64, f64)>,
    pub status: RobotStatus,
    /// Digest of the controller in the robot's process.
    pub controller_digest: u64,
}

/// A runner, and a controller if it is to play one.
pub struct Runner {
    messages: Arc<Mutex<RunnerMessages>>,
    task: JoinHandle<()>,
    _subscriptions: [Subscription; 2],
}

impl Runner {
    pub fn start(session: &Session, node: &NodeHandle) -> Self {
        let messages =
            Arc::new(Mutex::new(RunnerMessages { digest: DIGEST, ..RunnerMessages::default() }));
        let (to_status, to_controller) = (Arc::clone(&messages), Arc::clone(&messages));
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
        let task = tokio::spawn(publish(publishers, Arc::clone(&messages)));
        Self { messages, task, _subscriptions: subscriptions }
    }

    pub fn messages(&self) -> MutexGuard<'_, RunnerMessages> {
        lock(&self.messages)
    }

    pub fn state(&self) -> u8 {
        self.messages().status.state
    }

    /// Arms an epoch, waits for the robot to arm, and runs.
    pub async fn run_epoch(&self, epoch: u64) {
        self.start_epoch(epoch).await;
        self.until_it_is("moving", |status| status.state == RobotState::Moving).await;
    }

    /// Arms the robot, and lets it move.
    pub async fn start_epoch(&self, epoch: u64) {
        self.messages().lease = Some((epoch, u8::from(LeaseState::Armed)));
        self.until_it_is("armed", |status| {
            (status.state, status.epoch) == (u8::from(RobotState::Armed), epoch)
        })
        .await;
        self.messages().lease = Some((epoch, u8::from(LeaseState::Running)));
    }

    /// Waits for a status.
    pub async fn until_it_is(&self, what: &str, is_so: impl Fn(&RobotStatus) -> bool) {
        let start = Instant::now();
        while !is_so(&self.messages().status) {
            let received = self.messages().status.clone();
            assert!(start.elapsed() < TIMEOUT, "the robot is not {what}, it reports {received:?}");
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }
}

impl Drop for Runner {
    fn drop(&mut self) {
        self.task.abort();
    }
}

fn lock(messages: &Mutex<RunnerMessages>) -> MutexGuard<'_, RunnerMessages> {
    messages.lock().unwrap_or_else(PoisonError::into_inner)
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

async fn publish(publishers: Publishers, messages: Arc<Mutex<RunnerMessages>>) {
    let why = "a healthy network";
    let mut beat = tokio::time::interval(BEAT);
    let mut epoch = 0;
    loop {
        beat.tick().await;
        let (lease, foreign, e_stop, command) = {
            let messages = lock(&messages);
            let lease = messages.lease.map(|(epoch, state)| RunLease {
                run_id: format!("run {epoch}"),
                epoch,
                state,
                parameter_digest: messages.digest,
                robots: vec![ROBOT.to_owned()],
                echoed_counter: vec![messages.status.counter],
                ..RunLease::default()
            });
            (lease, messages.foreign_controller, messages.e_stop, messages.command)
        };
        if let Some(parameter_digest) = foreign {
            let counter = rsrs_fleet::wire::first_counter(wall_time());
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
