//! A simulated run as a bag: the topics, times and texts of a run in lockstep, without the network.

use std::collections::BTreeMap;
use std::path::Path;

use rsrs_bags::{BagError, BagOptions, BagSummary, BagWriter, ChannelId, Sample};
use rsrs_core::conditions::Conditions;
use rsrs_core::controller::{Command, decide};
use rsrs_core::trajectory::Trajectory;
use rsrs_core::unicycle::Pose;
use rsrs_fleet::record::{ATTACHMENT, ENDING, Ending, EndingKind, ExperimentRecord};
use rsrs_msgs::builtin_interfaces::Time as Stamp;
use rsrs_msgs::geometry_msgs::{self, Point, PoseWithCovariance, Quaternion, TwistWithCovariance};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rosgraph_msgs::Clock;
use rsrs_msgs::rsrs::{RunLease, WorldDigest};
use rsrs_msgs::std_msgs::{Bool, Header};
use rsrs_msgs::topics::{self, Topic};
use rsrs_msgs::{RosMessage, cdr};
use rsrs_sim::draw::Seed;
use rsrs_sim::placement::PlacementError;
use rsrs_sim::world::World;
use rsrs_wire as wire;

/// Why there is no bag of a simulated run.
#[derive(Debug, thiserror::Error)]
pub enum EpisodeError {
    /// The robots do not fit where they are to start.
    #[error(transparent)]
    Placement(#[from] PlacementError),
    /// The bag cannot be written.
    #[error(transparent)]
    Bag(#[from] BagError),
}

/// Simulates the run that a record describes, and writes it as a bag.
///
/// The bag has what a recorded run in lockstep has: of every robot detection, odometry and command,
/// the clock, the world's digest, the lease from RUNNING to STOPPED, the record and how the run
/// ended. What only a network has is not there: statuses, parameters, logs.
///
/// # Arguments
///
/// * `folder` — where the bag goes; it must not exist.
/// * `record` — the run, with its seed and replicate.
///
/// # Returns
///
/// What was written, and the run as it was in memory.
///
/// # Errors
///
/// [`EpisodeError`].
pub fn write(
    folder: &Path,
    record: &ExperimentRecord,
) -> Result<(BagSummary, Trajectory), EpisodeError> {
    let conditions = &record.conditions;
    let seed = Seed { seed: record.seed, replicate: record.replicate };
    let mut world = World::new(conditions, seed)?;
    let mut recorder = Recorder::open(folder, record)?;
    let mut trajectory = Trajectory::new(conditions.period_s, conditions.robots);
    let mut obeyed = vec![Command::STOP; conditions.robots];
    recorder.lease(0, RunLease::RUNNING)?;
    let steps = conditions.steps(record.duration_s);
    for step in 1..=steps {
        let digest = world.digest();
        let detections = world.sense().to_vec();
        let poses: Vec<Pose> = world.poses().collect();
        let commands: Vec<Command> =
            detections.iter().map(|seen| decide(*seen, conditions.controller)).collect();
        let moment = Moment { poses: &poses, detections: &detections, obeyed: &obeyed, digest };
        recorder.step(step, &moment, &commands)?;
        world.advance(&commands);
        trajectory.poses.extend(poses);
        trajectory.commands.extend_from_slice(&commands);
        obeyed = commands;
    }
    recorder.lease(steps, RunLease::STOPPED)?;
    Ok((recorder.close()?, trajectory))
}

/// What the simulator shows of one step.
struct Moment<'a> {
    /// Where the robots are; shape `[n_robots]`.
    poses: &'a [Pose],
    /// What they see; shape `[n_robots]`.
    detections: &'a [bool],
    /// The commands that brought them here; shape `[n_robots]`.
    obeyed: &'a [Command],
    /// The fingerprint of the world.
    digest: u64,
}

/// The topics of one robot.
struct Robot {
    name: String,
    detection: ChannelId,
    odom: ChannelId,
    cmd_vel: ChannelId,
}

/// A bag that is being written.
struct Recorder<'a> {
    writer: BagWriter,
    record: &'a ExperimentRecord,
    period_ns: u64,
    clock: ChannelId,
    digest: ChannelId,
    lease: ChannelId,
    robots: Vec<Robot>,
}

impl<'a> Recorder<'a> {
    fn open(folder: &Path, record: &'a ExperimentRecord) -> Result<Self, BagError> {
        let custom_data = BTreeMap::from([
            ("run_id".to_owned(), record.run_id.clone()),
            ("rsrs_version".to_owned(), record.provenance.version.clone()),
        ]);
        let mut writer = BagWriter::create(folder, BagOptions { custom_data })?;
        writer.attach(ATTACHMENT, "application/json", record.to_json().as_bytes())?;
        let mut add = |topic: Topic, robot: &str| {
            writer.add_topic(&topic.for_robot(robot), topic.type_name, topic.qos)
        };
        let (clock, digest, lease) =
            (add(topics::CLOCK, "")?, add(topics::WORLD_DIGEST, "")?, add(topics::LEASE, "")?);
        let robots = record.robots.iter().map(|name| {
            Ok(Robot {
                name: name.clone(),
                detection: add(topics::DETECTION, name)?,
                odom: add(topics::ODOM, name)?,
                cmd_vel: add(topics::CMD_VEL, name)?,
            })
        });
        let robots = robots.collect::<Result<_, BagError>>()?;
        let period_ns = period_ns(&record.conditions);
        Ok(Self { writer, record, period_ns, clock, digest, lease, robots })
    }

    /// Writes one step in the order in which the simulator publishes it: the clock first.
    fn step(&mut self, step: u64, moment: &Moment, commands: &[Command]) -> Result<(), BagError> {
        let time_ns = step * self.period_ns;
        let stamp = Stamp::from_nanos(time_ns);
        let Self { writer, robots, .. } = self;
        put(writer, (self.clock, time_ns), &Clock { clock: stamp })?;
        for (robot, data) in robots.iter().zip(moment.detections) {
            put(writer, (robot.detection, time_ns), &Bool { data: *data })?;
        }
        for ((robot, pose), obeyed) in robots.iter().zip(moment.poses).zip(moment.obeyed) {
            put(writer, (robot.odom, time_ns), &odometry(&robot.name, (*pose, *obeyed), stamp))?;
        }
        put(writer, (self.digest, time_ns), &WorldDigest { step, digest: moment.digest })?;
        for (robot, command) in robots.iter().zip(commands) {
            put(writer, (robot.cmd_vel, time_ns), &wire::twist_stamped(*command, stamp))?;
        }
        Ok(())
    }

    fn lease(&mut self, step: u64, state: u8) -> Result<(), BagError> {
        let time_ns = step * self.period_ns;
        let lease = RunLease {
            header: Header { stamp: Stamp::from_nanos(time_ns), frame_id: String::new() },
            run_id: self.record.run_id.clone(),
            epoch: 1,
            state,
            parameter_digest: self.record.conditions.controller.digest(),
            robots: self.record.robots.clone(),
            echoed_counter: vec![0; self.record.robots.len()],
        };
        put(&mut self.writer, (self.lease, time_ns), &lease)
    }

    fn close(mut self) -> Result<BagSummary, BagError> {
        let ending = Ending { kind: EndingKind::Completed, reason: String::new() };
        self.writer.metadata(ENDING, ending.to_pairs())?;
        self.writer.finish()
    }
}

fn put<M: RosMessage>(
    writer: &mut BagWriter,
    (channel, time_ns): (ChannelId, u64),
    message: &M,
) -> Result<(), BagError> {
    let data = cdr::encode(message);
    let sample =
        Sample { log_time_ns: time_ns, publish_time_ns: time_ns, sequence: 0, data: &data };
    writer.write(channel, sample)
}

/// Where a robot is, as the simulator says it.
fn odometry(robot: &str, (pose, obeyed): (Pose, Command), stamp: Stamp) -> Odometry {
    let (sine, cosine) = libm::sincos(pose.heading_rad / 2.0);
    let pose = geometry_msgs::Pose {
        position: Point { x: pose.x_m, y: pose.y_m, z: 0.0 },
        orientation: Quaternion { x: 0.0, y: 0.0, z: sine, w: cosine },
    };
    Odometry {
        header: Header { stamp, frame_id: "map".to_owned() },
        child_frame_id: format!("{robot}/base_link"),
        pose: PoseWithCovariance { pose, ..PoseWithCovariance::default() },
        twist: TwistWithCovariance { twist: wire::twist(obeyed), ..TwistWithCovariance::default() },
    }
}

/// The period as a whole number of nanoseconds, as the simulator stamps it.
fn period_ns(conditions: &Conditions) -> u64 {
    u64::try_from(std::time::Duration::from_secs_f64(conditions.period_s).as_nanos())
        .expect("conditions allow at most 60 s")
}
