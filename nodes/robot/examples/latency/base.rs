//! The runner, the base driver and a witness of the topics between, in one.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use anyhow::bail;
use rsrs_msgs::RosMessage;
use rsrs_msgs::geometry_msgs::{Twist, TwistStamped};
use rsrs_msgs::rsrs::{LeaseState, RobotState, RobotStatus, RunLease};
use rsrs_msgs::sensor_msgs::Range;
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::topics::{self, Qos, Topic};
use rsrs_ros::parameters::{ClientOptions, ParameterClient, ParameterValue};
use rsrs_ros::session::{NodeHandle, Publisher, Received, Session, Subscription};

use crate::ROBOT;

/// How long to wait for robot and controller.
const TIMEOUT: Duration = Duration::from_secs(30);
/// Interval of the sensor's readings; each is another than the one before.
const READING: Duration = Duration::from_millis(47);
/// Interval of leases.
const BEAT: Duration = Duration::from_millis(100);

/// What followed a change of the detection, in nanoseconds after it was sent.
#[derive(Clone, Copy, Debug)]
#[expect(clippy::struct_field_names, reason = "names end in units")]
pub struct Followed {
    /// The controller sent its answer.
    pub command_ns: u64,
    /// The robot sent it on to the wheels.
    pub wheels_ns: u64,
    /// The base driver had it in hand.
    pub base_ns: u64,
}

/// Something that was received: when it was sent, when it was in hand, and which way it commands to
/// turn.
#[derive(Clone, Copy, Debug)]
struct LastCommand {
    sent_ns: u64,
    in_hand_ns: u64,
    is_left: bool,
}

#[derive(Debug, Default)]
struct Witness {
    detections: Vec<LastCommand>,
    commands: Vec<LastCommand>,
    wheels: Vec<LastCommand>,
    status: RobotStatus,
    controller_digest: u64,
}

type Shared = Arc<Mutex<Witness>>;

/// Everything around one robot.
pub struct Base {
    witness: Shared,
    node: NodeHandle,
    lease: Publisher<RunLease>,
    range: Publisher<Range>,
    _subscriptions: [Subscription; 5],
}

impl Base {
    /// Connects to a robot, and waits until it subscribes.
    pub async fn new(session: &Session) -> anyhow::Result<Self> {
        let node = session.node("/", "base")?;
        let witness = Shared::default();
        let subscriptions = [
            receive::<Bool>(session, &node, topics::DETECTION, &witness, |witness, sample| {
                witness.detections.push(received(sample, |message| message.data));
            })?,
            receive::<TwistStamped>(
                session,
                &node,
                topics::CMD_VEL,
                &witness,
                |witness, sample| {
                    witness
                        .commands
                        .push(received(sample, |message| message.twist.angular.z > 0.0));
                },
            )?,
            receive::<Twist>(
                session,
                &node,
                topics::HARDWARE_CMD_VEL_UNSTAMPED,
                &witness,
                |witness, sample| {
                    witness.wheels.push(received(sample, |message| message.angular.z > 0.0));
                },
            )?,
            receive::<RobotStatus>(session, &node, topics::STATUS, &witness, |witness, sample| {
                witness.status.clone_from(&sample.message);
            })?,
            receive::<RobotStatus>(
                session,
                &node,
                topics::CONTROLLER_STATUS,
                &witness,
                |witness, sample| witness.controller_digest = sample.message.parameter_digest,
            )?,
        ];
        let readings = topics::HARDWARE_RANGE.for_robot(ROBOT);
        let range = session.publish_on(&node, &readings, Qos::reliable(10))?;
        let lease = session.publish_on(&node, topics::LEASE.name, topics::LEASE.qos)?;
        session.wait_for_readers(&readings, 1, TIMEOUT).await?;
        let commands = topics::CMD_VEL.for_robot(ROBOT);
        session.wait_for_writers(&commands, 1, TIMEOUT).await?;
        Ok(Self { witness, node, lease, range, _subscriptions: subscriptions })
    }

    /// Sets the controller to turn so slowly that the ramp holds nothing back.
    pub async fn set_controller(&self, session: &Session) -> anyhow::Result<()> {
        let options = ClientOptions { timeout: TIMEOUT, mapping: None };
        let client = ParameterClient::new(session, &self.node, options);
        let values = [("speed", 0.01), ("turn_rate", 0.02)]
            .map(|(name, value)| (name.to_owned(), ParameterValue::Double(value)));
        client.set_atomically(&format!("/{ROBOT}/controller"), &values).await?;
        // Until its next statuses have come, leases would carry the digest of what it was before,
        // and a robot that is stopped by that stays so for the epoch.
        tokio::time::sleep(5 * BEAT).await;
        lock(&self.witness).controller_digest = 0;
        let start = Instant::now();
        while lock(&self.witness).controller_digest == 0 {
            if start.elapsed() > TIMEOUT {
                bail!("the controller publishes nothing for {TIMEOUT:?}");
            }
            tokio::time::sleep(BEAT).await;
        }
        Ok(())
    }

    /// Runs the robot, with a sensor that changes its mind all the time.
    pub async fn run(&mut self, duration: Duration) -> anyhow::Result<Vec<Followed>> {
        let (mut beat, mut reading) = (tokio::time::interval(BEAT), tokio::time::interval(READING));
        let (start, mut moved, mut is_near) = (Instant::now(), None::<Instant>, false);
        while moved.is_none_or(|moved| moved.elapsed() < duration) {
            tokio::select! {
                _ = beat.tick() => {
                    let state = self.beat().await?;
                    if state == RobotState::Moving && moved.is_none() {
                        lock(&self.witness).detections.clear();
                        moved = Some(Instant::now());
                    }
                }
                _ = reading.tick() => {
                    is_near = !is_near;
                    let range = if is_near { 0.3 } else { 2.0 };
                    self.range.publish(Range { range, max_range: 2.0, ..Range::default() }).await?;
                }
            }
            if moved.is_none() && start.elapsed() > TIMEOUT {
                bail!("the robot does not move, it reports {:?}", lock(&self.witness).status);
            }
        }
        // The last ones are still on their way.
        tokio::time::sleep(BEAT).await;
        Ok(lock(&self.witness).followed())
    }

    /// Sends a lease, and returns what the robot does.
    async fn beat(&self) -> anyhow::Result<u8> {
        let (status, parameter_digest) = {
            let witness = lock(&self.witness);
            (witness.status.clone(), witness.controller_digest)
        };
        let is_armed = status.epoch == 1 && status.state != RobotState::Idle;
        let lease = RunLease {
            run_id: "latency".to_owned(),
            epoch: 1,
            state: if is_armed {
                u8::from(LeaseState::Running)
            } else {
                u8::from(LeaseState::Armed)
            },
            parameter_digest,
            robots: vec![ROBOT.to_owned()],
            echoed_counter: vec![status.counter],
            ..RunLease::default()
        };
        self.lease.publish(lease).await?;
        Ok(status.state)
    }
}

impl Witness {
    /// What followed each change of the detection.
    fn followed(&self) -> Vec<Followed> {
        let changes = self.detections.windows(2).filter(|pair| pair[0].is_left != pair[1].is_left);
        changes
            .filter_map(|pair| {
                let command = answer(&self.commands, pair[1])?;
                let wheels = answer(&self.wheels, command)?;
                let since = |later_ns: u64| later_ns - pair[1].sent_ns;
                Some(Followed {
                    command_ns: since(command.sent_ns),
                    wheels_ns: since(wheels.sent_ns),
                    base_ns: since(wheels.in_hand_ns),
                })
            })
            .collect()
    }
}

/// The first of these that was sent after something and turns the same way.
fn answer(received: &[LastCommand], to: LastCommand) -> Option<LastCommand> {
    let first = received.partition_point(|received| received.sent_ns < to.sent_ns);
    received[first..].iter().find(|received| received.is_left == to.is_left).copied()
}

fn received<M>(sample: &Received<M>, left: impl Fn(&M) -> bool) -> LastCommand {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    let in_hand_ns = u64::try_from(since_1970.as_nanos()).expect("64 bits last until 2554");
    let sent_ns = sample.source_time_ns.expect("our nodes stamp what they send");
    LastCommand { sent_ns, in_hand_ns, is_left: left(&sample.message) }
}

fn receive<M: RosMessage>(
    session: &Session,
    node: &NodeHandle,
    topic: Topic,
    witness: &Shared,
    put: impl Fn(&mut Witness, &Received<M>) + Send + 'static,
) -> anyhow::Result<Subscription> {
    let witness = Arc::clone(witness);
    let deliver = move |sample: Received<M>| put(&mut lock(&witness), &sample);
    Ok(session.subscribe(node, &topic.for_robot(ROBOT), topic.qos, deliver)?)
}

fn lock(witness: &Shared) -> std::sync::MutexGuard<'_, Witness> {
    witness.lock().unwrap_or_else(PoisonError::into_inner)
}
