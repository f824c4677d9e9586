//! Small bags of a swarm that drives straight, for tests to write and to spoil.

pub mod damage;
pub mod outcome;

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use mcap::WriteOptions;
use mcap::records::MessageHeader;
use rsrs_bags::{BagOptions, BagWriter, ChannelId, Sample};
use rsrs_msgs::builtin_interfaces::Time;
use rsrs_msgs::geometry_msgs::{Quaternion, TwistStamped};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::{LeaseState, RunLease};
use rsrs_msgs::std_msgs::Bool;
use rsrs_msgs::{RosMessage, cdr, topics};

/// Control period, in nanoseconds.
pub const PERIOD_NS: u64 = 130_000_000;

/// Speed of every robot, in metres per second.
pub const SPEED_M_S: f64 = 0.15;

/// A writer with the topics of some robots.
pub struct Recording {
    /// The bag.
    pub writer: BagWriter,
    /// The run lease.
    pub lease: ChannelId,
    robots: Vec<RobotChannels>,
}

struct RobotChannels {
    detection: ChannelId,
    cmd_vel: ChannelId,
    odom: ChannelId,
}

impl Recording {
    /// Starts a bag with these robots.
    pub fn new(folder: &Path, robots: &[&str]) -> Self {
        let writer = BagWriter::create(folder, BagOptions::default()).expect("it is new");
        Self::with(writer, robots)
    }

    /// Adds these robots to a bag.
    pub fn with(mut writer: BagWriter, robots: &[&str]) -> Self {
        let lease = add(&mut writer, topics::LEASE, "");
        let robots = robots
            .iter()
            .map(|robot| RobotChannels {
                detection: add(&mut writer, topics::DETECTION, robot),
                cmd_vel: add(&mut writer, topics::CMD_VEL, robot),
                odom: add(&mut writer, topics::ODOM, robot),
            })
            .collect();
        Self { writer, lease, robots }
    }

    /// Records one message at a log time.
    pub fn put<M: RosMessage>(&mut self, channel: ChannelId, log_time_ns: u64, message: &M) {
        let data = cdr::encode(message);
        let sample = Sample { log_time_ns, publish_time_ns: log_time_ns, sequence: 0, data: &data };
        self.writer.write(channel, sample).expect("the disk has room");
    }

    /// Records what all robots do in one step.
    pub fn step(&mut self, step: u64) {
        for robot in 0..self.robots.len() {
            self.detection(robot, step);
            self.odom(robot, step, &odometry(robot, step));
            self.cmd_vel(robot, step, SPEED_M_S);
        }
    }

    /// Records one robot's detection.
    pub fn detection(&mut self, robot: usize, step: u64) {
        let message = Bool { data: step.is_multiple_of(2) };
        self.put(self.robots[robot].detection, step * PERIOD_NS, &message);
    }

    /// Records one robot's pose.
    pub fn odom(&mut self, robot: usize, step: u64, message: &Odometry) {
        self.put(self.robots[robot].odom, step * PERIOD_NS, message);
    }

    /// Records one robot's command.
    pub fn cmd_vel(&mut self, robot: usize, step: u64, speed_m_s: f64) {
        let mut message = TwistStamped::default();
        message.header.stamp = Time::from_nanos(step * PERIOD_NS);
        message.twist.linear.x = speed_m_s;
        message.twist.angular.z = step as f64;
        self.put(self.robots[robot].cmd_vel, step * PERIOD_NS, &message);
    }

    /// Records the lease.
    pub fn lease(&mut self, step: u64, state: LeaseState) {
        let message = RunLease { state: state.into(), epoch: 1, ..RunLease::default() };
        self.put(self.lease, step * PERIOD_NS, &message);
    }
}

/// A file by another writer, as its bytes: one detection per log time, and a topic without messages.
pub fn foreign(options: WriteOptions, log_times_ns: impl IntoIterator<Item = u64>) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut writer = options.create(&mut file).expect("room");
    let schema = writer.add_schema("std_msgs/msg/Bool", "ros2msg", b"bool data").expect("room");
    let pairs = BTreeMap::new();
    let channel_id = writer.add_channel(schema, "/detection", "cdr", &pairs).expect("room");
    writer.add_channel(schema, "/nobody", "cdr", &pairs).expect("room");
    for log_time in log_times_ns {
        let header = MessageHeader { channel_id, sequence: 0, log_time, publish_time: 1 };
        writer.write_to_known_channel(&header, &[0, 1, 0, 0, 1]).expect("room");
    }
    writer.finish().expect("room");
    drop(writer);
    file.into_inner()
}

fn add(writer: &mut BagWriter, topic: topics::Topic, robot: &str) -> ChannelId {
    writer.add_topic(&topic.for_robot(robot), topic.type_name, topic.qos).expect("it is new")
}

/// Robot `n` drives along y = n.
pub fn odometry(robot: usize, step: u64) -> Odometry {
    let mut message = Odometry::default();
    message.header.stamp = Time::from_nanos(step * PERIOD_NS);
    "map".clone_into(&mut message.header.frame_id);
    let pose = &mut message.pose.pose;
    pose.position.x = SPEED_M_S * (step * PERIOD_NS) as f64 / 1e9;
    pose.position.y = robot as f64;
    pose.orientation = Quaternion::default();
    message
}
