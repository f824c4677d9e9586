//! Bags of runs for tests, made from simulated episodes in the place of real robots.

use std::path::{Path, PathBuf};

use rsrs_bags::{BagOptions, BagWriter, ChannelId, Sample};
use rsrs_core::comparison::fixed::FixedRun;
use rsrs_core::conditions::{Conditions, Settings};
use rsrs_core::quantity::Axis;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_core::robot::unicycle::Pose;
use rsrs_fleet::experiment::{RobotLost, Time};
use rsrs_fleet::record::{ATTACHMENT, Backend, ENDING, Ending, EndingKind, ExperimentRecord};
use rsrs_msgs::builtin_interfaces::Time as Stamp;
use rsrs_msgs::geometry_msgs::{Pose as Pose3, PoseStamped, Quaternion, TwistStamped};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::{LeaseState, RunLease};
use rsrs_msgs::std_msgs;
use rsrs_msgs::topics::Topic;
use rsrs_msgs::{RosMessage, cdr, topics};
use rsrs_sim::draw::Seed;
use rsrs_sim::episode::run_episode;
use rsrs_testing::record::fleet_record;

/// The Flockbot's control period, in nanoseconds.
const PERIOD_NS: u64 = 130_000_000;

/// What one run was, and what its bag holds.
#[derive(Clone, Debug)]
pub struct Run {
    /// Speed of every robot, in metres per second.
    pub speed_m_s: f64,
    /// Turning rate of every robot, in radians per second.
    pub turn_rate_rad_s: f64,
    /// Number of robots.
    pub robots: u32,
    /// Radius of the disc in which they start, in metres.
    pub placement_radius_m: f64,
    /// How long the run was set to last, in seconds.
    pub duration_s: f64,
    /// How long it was recorded, in seconds.
    pub recorded_s: f64,
    /// Seed of the simulated world in the place of real robots.
    pub seed: u64,
    /// Whether its robots were ever allowed to move.
    pub starts: bool,
    /// The pace that the record states.
    pub time: Time,
    /// Probability that a robot sees what is there; real ones are as measured, blind ones have 0.
    pub sight: f64,
    /// Who knows where the robots are.
    pub seen_by: SeenBy,
    /// Where poses come from, as the record states it.
    pub pose_source: Option<PoseSource>,
    /// The fleet file in the bag.
    pub fleet: Option<String>,
    /// The robots whose lease only their controllers hold.
    pub controller_only: Vec<String>,
    /// What was to be done about a lost robot.
    pub robot_lost: RobotLost,
    /// Which run of a campaign it is whose number of runs was fixed.
    pub fixed: Option<FixedRun>,
    /// How the run ended.
    pub ending: Ending,
    /// What the bag lacks.
    pub lacks: Option<Part>,
    /// What is done to the poses of a moment before they are recorded, with those of the start.
    pub distortion: Option<Distortion>,
}

/// Who knows where robots are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SeenBy {
    /// They themselves: their odometry is in the frame of the world.
    Themselves,
    /// A tracker; the odometry of each robot began at another place, before the run.
    ATracker,
}

/// A tracker that does not publish poses as they are, or robots that do not move as they should: it
/// changes the first poses, and is given the second ones, of the start.
pub type Distortion = fn(&mut [Pose], &[Pose]);

/// A part of a bag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The record of the experiment.
    Record,
    /// How the run ended.
    Ending,
    /// Where the robots were.
    Poses,
}

impl Run {
    /// A completed run of nine Flockbots in the cell that mills, 120 s long.
    pub fn new(seed: u64) -> Self {
        Self {
            speed_m_s: 0.15,
            turn_rate_rad_s: 0.75,
            robots: 9,
            placement_radius_m: 0.60,
            duration_s: 120.0,
            recorded_s: 120.0,
            seed,
            starts: true,
            time: Time::RealTime,
            sight: 0.98,
            seen_by: SeenBy::Themselves,
            pose_source: None,
            fleet: None,
            controller_only: Vec::new(),
            robot_lost: RobotLost::Abort,
            fixed: None,
            ending: ended(EndingKind::Completed, ""),
            lacks: None,
            distortion: None,
        }
    }

    /// Makes the bag of this run.
    pub fn record(&self, folder: &Path, name: &str) -> PathBuf {
        let record = self.experiment(name).to_json();
        self.write(folder, name, (self.lacks != Some(Part::Record)).then_some(record.as_str()))
    }

    /// Makes the bag of this run, with another text where the record of the experiment belongs.
    pub fn record_with(&self, folder: &Path, name: &str, record: &str) -> PathBuf {
        self.write(folder, name, Some(record))
    }

    fn write(&self, folder: &Path, name: &str, record: Option<&str>) -> PathBuf {
        let conditions = self.conditions();
        let bag = folder.join(name);
        let mut recording = Recording::new(&bag, self);
        if let Some(record) = record {
            recording.attach(ATTACHMENT, record);
        }
        if let (Some(record), SeenBy::ATracker) = (record, self.seen_by) {
            recording.publish(record);
        }
        if let Some(fleet) = &self.fleet {
            recording.attach("fleet.yaml", fleet);
        }
        recording.run(self, &conditions);
        if self.lacks != Some(Part::Ending) {
            let pairs = self.ending.to_pairs();
            recording.writer.metadata(ENDING, pairs).expect("the disk has room");
        }
        recording.writer.finish().expect("the disk has room");
        bag
    }

    /// The simulated world in the place of real robots.
    fn conditions(&self) -> Conditions {
        let values = vec![
            (Axis::Speed, self.speed_m_s),
            (Axis::TurnRate, self.turn_rate_rad_s),
            (Axis::Robots, f64::from(self.robots)),
            (Axis::PlacementRadius, self.placement_radius_m),
            (Axis::TruePositive, self.sight),
        ];
        Conditions::resolve(&flockbot(), &Settings { values, ..Settings::default() })
            .expect("the run is possible")
    }

    fn experiment(&self, name: &str) -> ExperimentRecord {
        ExperimentRecord {
            run_id: name.to_owned(),
            duration_s: self.duration_s,
            seed: self.seed,
            robot_lost: self.robot_lost,
            // A fleet runs in real time.
            backend: match self.time {
                Time::Lockstep => Backend::Simulator,
                Time::RealTime => Backend::Fleet,
            },
            controller_only: self.controller_only.clone(),
            pose_source: self.pose_source,
            fixed: self.fixed,
            time: self.time,
            ..fleet_record(&flockbot().digest(), self.conditions())
        }
    }
}

/// An ending.
pub fn ended(kind: EndingKind, reason: &str) -> Ending {
    Ending { kind, reason: reason.to_owned(), ..Ending::completed() }
}

/// Cuts the recording of a bag in two and keeps the first half, as a full disk would.
pub fn cut_in_half(bag: &Path) {
    let name = bag.file_name().expect("the bag has a name").to_string_lossy();
    let path = bag.join(format!("{name}_0.mcap"));
    let bytes = std::fs::read(&path).expect("the bag was recorded");
    std::fs::write(&path, &bytes[..bytes.len() / 2]).expect("the folder is writable");
    std::fs::remove_file(bag.join("metadata.yaml")).expect("the bag was finished");
}

fn flockbot() -> RobotProfile {
    rsrs_testing::conditions::flockbot()
}

/// The topics of one robot.
struct Robot {
    odom: Option<ChannelId>,
    tracked: Option<ChannelId>,
    cmd_vel: ChannelId,
}

/// A bag that is being recorded.
struct Recording {
    writer: BagWriter,
    lease: ChannelId,
    robots: Vec<Robot>,
}

impl Recording {
    fn new(bag: &Path, run: &Run) -> Self {
        let mut writer = BagWriter::create(bag, BagOptions::default()).expect("the bag is new");
        let mut add = |topic: Topic, robot: &str| {
            writer
                .add_topic(&topic.for_robot(robot), topic.type_name, topic.qos)
                .expect("the topic is new")
        };
        let lease = add(topics::LEASE, "");
        let has_poses = run.lacks != Some(Part::Poses);
        let is_tracked = run.seen_by == SeenBy::ATracker;
        let robots = (1..=run.robots).map(|robot| {
            let name = format!("robot_{robot}");
            Robot {
                odom: has_poses.then(|| add(topics::ODOM, &name)),
                tracked: (has_poses && is_tracked).then(|| add(topics::POSE, &name)),
                cmd_vel: add(topics::CMD_VEL, &name),
            }
        });
        let robots = robots.collect();
        Self { writer, lease, robots }
    }

    fn attach(&mut self, name: &str, text: &str) {
        let attached = self.writer.attach(name, "text/plain", text.as_bytes());
        attached.expect("the disk has room");
    }

    /// The record as a message, which no converter of bags drops.
    fn publish(&mut self, record: &str) {
        let topic = topics::EXPERIMENT;
        let channel = self.writer.add_topic(topic.name, topic.type_name, topic.qos);
        self.put(
            channel.expect("the topic is new"),
            0,
            &std_msgs::String { data: record.to_owned() },
        );
    }

    fn run(&mut self, run: &Run, conditions: &Conditions) {
        let seed = Seed { seed: run.seed, replicate: 0 };
        let episode =
            run_episode(conditions, seed, run.recorded_s).expect("the robots fit into their disc");
        self.lease(0, if run.starts { LeaseState::Running } else { LeaseState::Armed });
        for sample in 0..episode.n_samples() {
            let time_ns = sample as u64 * PERIOD_NS;
            let commands = episode.commands_at(sample);
            let mut poses = episode.poses_at(sample).to_vec();
            if let Some(distort) = run.distortion {
                distort(&mut poses, episode.poses_at(0));
            }
            for (robot, (pose, command)) in poses.iter().zip(commands).enumerate() {
                let Robot { odom, tracked, cmd_vel } = self.robots[robot];
                let mut own = *pose;
                if let Some(tracked) = tracked {
                    self.put(tracked, time_ns, &seen(*pose, time_ns));
                    own = dead_reckoning(robot, (episode.poses_at(0)[robot], *pose));
                }
                if let Some(odom) = odom {
                    self.put(odom, time_ns, &odometry(own, time_ns));
                }
                self.put(cmd_vel, time_ns, &twist(*command, time_ns));
            }
        }
        self.lease(episode.n_samples() as u64 * PERIOD_NS, LeaseState::Stopped);
    }

    fn lease(&mut self, time_ns: u64, state: LeaseState) {
        self.put(
            self.lease,
            time_ns,
            &RunLease { state: state.into(), epoch: 1, ..RunLease::default() },
        );
    }

    fn put<M: RosMessage>(&mut self, channel: ChannelId, time_ns: u64, message: &M) {
        let data = cdr::encode(message);
        let sample =
            Sample { log_time_ns: time_ns, publish_time_ns: time_ns, sequence: 0, data: &data };
        self.writer.write(channel, sample).expect("the disk has room");
    }
}

fn odometry(pose: Pose, time_ns: u64) -> Odometry {
    let mut message = Odometry::default();
    message.header.stamp = Stamp::from_nanos(time_ns);
    "map".clone_into(&mut message.header.frame_id);
    message.pose.pose = in_space(pose);
    message
}

fn seen(pose: Pose, time_ns: u64) -> PoseStamped {
    let mut message = PoseStamped::default();
    message.header.stamp = Stamp::from_nanos(time_ns);
    "map".clone_into(&mut message.header.frame_id);
    message.pose = in_space(pose);
    message
}

fn in_space(pose: Pose) -> Pose3 {
    let mut message = Pose3::default();
    message.position.x = pose.x_m;
    message.position.y = pose.y_m;
    let (z, w) = libm::sincos(pose.heading_rad / 2.0);
    message.orientation = Quaternion { x: 0.0, y: 0.0, z, w };
    message
}

/// Where a robot believes to be that began to count its turns of wheels elsewhere.
fn dead_reckoning(robot: usize, (start, pose): (Pose, Pose)) -> Pose {
    let (sine, cosine) = libm::sincos(-start.heading_rad);
    let (x_m, y_m) = (pose.x_m - start.x_m, pose.y_m - start.y_m);
    Pose {
        x_m: 1.5 * robot as f64 + cosine * x_m - sine * y_m,
        y_m: sine * x_m + cosine * y_m,
        heading_rad: pose.heading_rad - start.heading_rad,
    }
}

fn twist(command: Command, time_ns: u64) -> TwistStamped {
    let mut message = TwistStamped::default();
    message.header.stamp = Stamp::from_nanos(time_ns);
    message.twist.linear.x = command.speed_m_s;
    message.twist.angular.z = command.turn_rate_rad_s;
    message
}
