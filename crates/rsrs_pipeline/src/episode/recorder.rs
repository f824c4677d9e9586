//! The bag of a run that no network has carried: the topics of every robot, the lease, the record and
//! how the run ended.

use std::collections::BTreeMap;
use std::path::Path;

use rsrs_bags::{BagError, BagOptions, BagSummary, BagWriter, ChannelId, Sample};
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::sensor::Readings;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::world::WorldFile;
use rsrs_fleet::record::{ATTACHMENT, ENDING, Ending, ExperimentRecord};
use rsrs_fleet::wire;
use rsrs_msgs::builtin_interfaces::Time as Stamp;
use rsrs_msgs::geometry_msgs::{self, Point, PoseWithCovariance, Quaternion, TwistWithCovariance};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::{LeaseState, RunLease};
use rsrs_msgs::std_msgs::{self, Bool, Header};
use rsrs_msgs::topics::{self, Topic};
use rsrs_msgs::{RosMessage, cdr};

/// One turn of a robot's control loop: what it saw, and what it did about it.
#[derive(Clone, Copy, Debug)]
pub struct RobotStep {
    /// Which robot, in the order of the record.
    pub robot: usize,
    /// When, in nanoseconds from the start.
    pub time_ns: u64,
    /// Where it was.
    pub pose: Pose,
    /// The command that brought it there.
    pub obeyed: Command,
    /// What its sensors reported.
    pub readings: Readings,
    /// The command that answers it.
    pub command: Command,
}

/// The topics of one robot.
struct Robot {
    name: String,
    detection: ChannelId,
    /// Of its readings besides `detection`.
    further: Vec<ChannelId>,
    odom: ChannelId,
    cmd_vel: ChannelId,
}

/// A bag that is being written.
pub struct Recorder<'a> {
    writer: BagWriter,
    record: &'a ExperimentRecord,
    lease: ChannelId,
    /// The record of the run and its ending as messages, which converters of bags keep.
    notes: [ChannelId; 2],
    /// The last log time, in nanoseconds.
    now_ns: u64,
    robots: Vec<Robot>,
    /// Where objects are.
    objects: Vec<ChannelId>,
}

impl<'a> Recorder<'a> {
    /// Opens a bag for a run, in a folder that must not exist, and returns it with the channels of
    /// topics besides the lease and those of the robots.
    pub fn open<const N: usize>(
        folder: &Path,
        record: &'a ExperimentRecord,
        more: [Topic; N],
    ) -> Result<(Self, [ChannelId; N]), BagError> {
        let custom_data = BTreeMap::from([
            ("run_id".to_owned(), record.run_id.clone()),
            ("rsrs_version".to_owned(), record.provenance.version.clone()),
        ]);
        let mut writer = BagWriter::create(folder, BagOptions { custom_data })?;
        writer.attach(ATTACHMENT, "application/json", record.to_json().as_bytes())?;
        let mut add = |topic: Topic, robot: &str| {
            writer.add_topic(&topic.for_robot(robot), topic.type_name, topic.qos)
        };
        let more = more.into_iter().map(|topic| add(topic, ""));
        let more: Vec<ChannelId> = more.collect::<Result<_, BagError>>()?;
        let lease = add(topics::LEASE, "")?;
        let notes = [add(topics::EXPERIMENT, "")?, add(topics::ENDING, "")?];
        let robots = record.robots.iter().map(|name| {
            Ok(Robot {
                name: name.clone(),
                detection: add(topics::DETECTION, name)?,
                further: Vec::new(),
                odom: add(topics::ODOM, name)?,
                cmd_vel: add(topics::CMD_VEL, name)?,
            })
        });
        let mut robots = robots.collect::<Result<Vec<_>, BagError>>()?;
        let readings = record.conditions.robot.reading_names();
        for robot in &mut robots {
            for reading in readings.further() {
                let Topic { type_name, qos, .. } = topics::FURTHER_DETECTION;
                let name = topics::further_detection(&robot.name, reading);
                robot.further.push(writer.add_topic(&name, type_name, qos)?);
            }
        }
        let objects = (0..record.conditions.world.n_objects()).map(|object| {
            let Topic { type_name, qos, .. } = topics::OBJECT_POSE;
            let name = topics::object_pose(&WorldFile::object_name(object));
            writer.add_topic(&name, type_name, qos)
        });
        let objects = objects.collect::<Result<_, BagError>>()?;
        let more = <[ChannelId; N]>::try_from(more)
            .unwrap_or_else(|_| unreachable!("one channel was added for each topic"));
        let mut recorder = Self { writer, record, lease, notes, now_ns: 0, robots, objects };
        recorder.put(notes[0], 0, &std_msgs::String { data: record.to_json() })?;
        Ok((recorder, more))
    }

    /// Writes what a robot saw: `detection` last, which it answers.
    pub fn detection(&mut self, step: &RobotStep) -> Result<(), BagError> {
        for (place, channel) in self.robots[step.robot].further.clone().into_iter().enumerate() {
            self.put(channel, step.time_ns, &Bool { data: step.readings.has(place + 1) })?;
        }
        let channel = self.robots[step.robot].detection;
        self.put(channel, step.time_ns, &Bool { data: step.readings.detection() })
    }

    /// Writes where a robot was.
    pub fn odometry(&mut self, step: &RobotStep) -> Result<(), BagError> {
        let robot = &self.robots[step.robot];
        let (channel, message) = (robot.odom, odometry(&robot.name, step));
        self.put(channel, step.time_ns, &message)
    }

    /// Writes where an object was, in metres.
    pub fn object(
        &mut self,
        object: usize,
        time_ns: u64,
        place_m: [f64; 2],
    ) -> Result<(), BagError> {
        let channel = self.objects[object];
        self.put(channel, time_ns, &wire::object_pose(place_m, Stamp::from_nanos(time_ns)))
    }

    /// Writes a command.
    pub fn command(&mut self, step: &RobotStep) -> Result<(), BagError> {
        let channel = self.robots[step.robot].cmd_vel;
        let stamp = Stamp::from_nanos(step.time_ns);
        self.put(channel, step.time_ns, &wire::twist_stamped(step.command, stamp))
    }

    /// Writes a lease for all robots.
    pub fn lease(&mut self, time_ns: u64, state: LeaseState) -> Result<(), BagError> {
        let lease = RunLease {
            header: Header { stamp: Stamp::from_nanos(time_ns), frame_id: String::new() },
            run_id: self.record.run_id.clone(),
            epoch: 1,
            state: state.into(),
            parameter_digest: self.record.conditions.controller.digest(),
            robots: self.record.robots.clone(),
            echoed_counter: vec![0; self.record.robots.len()],
        };
        self.put(self.lease, time_ns, &lease)
    }

    /// Writes any message.
    pub fn put<M: RosMessage>(
        &mut self,
        channel: ChannelId,
        time_ns: u64,
        message: &M,
    ) -> Result<(), BagError> {
        self.now_ns = self.now_ns.max(time_ns);
        let data = cdr::encode(message);
        let sample =
            Sample { log_time_ns: time_ns, publish_time_ns: time_ns, sequence: 0, data: &data };
        self.writer.write(channel, sample)
    }

    /// Ends the bag of a completed run.
    pub fn close(mut self) -> Result<BagSummary, BagError> {
        let ending = Ending::completed();
        let text = std_msgs::String { data: ending.to_json(&self.record.run_id) };
        self.put(self.notes[1], self.now_ns, &text)?;
        self.writer.metadata(ENDING, ending.to_pairs())?;
        self.writer.finish()
    }
}

fn odometry(robot: &str, step: &RobotStep) -> Odometry {
    let Pose { x_m, y_m, heading_rad } = step.pose;
    let (sine, cosine) = libm::sincos(heading_rad / 2.0);
    let pose = geometry_msgs::Pose {
        position: Point { x: x_m, y: y_m, z: 0.0 },
        orientation: Quaternion { x: 0.0, y: 0.0, z: sine, w: cosine },
    };
    let stamp = Stamp::from_nanos(step.time_ns);
    Odometry {
        header: Header { stamp, frame_id: "map".to_owned() },
        child_frame_id: format!("{robot}/base_link"),
        pose: PoseWithCovariance { pose, ..PoseWithCovariance::default() },
        twist: TwistWithCovariance {
            twist: wire::twist(step.obeyed),
            ..TwistWithCovariance::default()
        },
    }
}
