//! Trajectories out of bags that a test writes.

use std::collections::BTreeMap;

use rsrs_bags::definitions::Definition;
use rsrs_bags::trajectory::{
    RecordedTrajectory, TrajectoryError, TrajectoryOptions, read_trajectory,
};
use rsrs_bags::{Bag, BagOptions, BagWriter, ChannelId, Sample};
use rsrs_msgs::geometry_msgs::Twist;
use rsrs_msgs::rsrs::LeaseState;
use rsrs_msgs::{RosMessage, cdr, topics};

use super::Recording;
use super::damage::temporary;

/// What a bag gives.
pub type Outcome = Result<RecordedTrajectory, TrajectoryError>;

/// The trajectory in a bag.
pub fn read(bag: &Bag) -> Outcome {
    read_trajectory(bag, &TrajectoryOptions::default())
}

/// The trajectory of two robots whose lease is RUNNING from the start, recorded by a recipe.
pub fn recorded(recipe: impl FnOnce(&mut Recording)) -> Outcome {
    let folder = temporary();
    let path = folder.path().join("run");
    let mut recording = Recording::new(&path, &["robot_10", "robot_2"]);
    recording.lease(0, LeaseState::Running);
    recipe(&mut recording);
    recording.writer.finish().expect("the disk has room");
    read(&Bag::open(&path)?)
}

/// The trajectory in a laboratory's bag, without any topic of ours.
pub struct Foreign {
    folder: tempfile::TempDir,
    writer: BagWriter,
    channels: BTreeMap<String, ChannelId>,
}

impl Foreign {
    /// Starts one.
    pub fn new() -> Self {
        let folder = temporary();
        let path = folder.path().join("run");
        let writer = BagWriter::create(&path, BagOptions::default()).expect("it is new");
        Self { folder, writer, channels: BTreeMap::new() }
    }

    /// Records a message on a topic.
    pub fn put<M: RosMessage>(&mut self, topic: &str, log_time_ns: u64, message: &M) {
        let writer = &mut self.writer;
        let channel = *self.channels.entry(topic.to_owned()).or_insert_with(|| {
            writer.add_topic(topic, M::TYPE_NAME, topics::POSE.qos).expect("it is new")
        });
        let data = cdr::encode(message);
        let sample = Sample { log_time_ns, publish_time_ns: 0, sequence: 0, data: &data };
        writer.write(channel, sample).expect("the disk has room");
    }

    /// Adds a topic of a type that is not ours.
    pub fn define(&mut self, topic: &str, definition: &Definition) {
        let qos = topics::POSE.qos;
        let channel = self.writer.add_topic_with_schema(topic, qos, definition).expect("new");
        self.channels.insert(topic.to_owned(), channel);
    }

    /// Records a command without stamp.
    pub fn command(&mut self, robot: &str, log_time_ns: u64, speed_m_s: f64) {
        let mut message = Twist::default();
        message.linear.x = speed_m_s;
        self.put(&format!("/{robot}/cmd_vel"), log_time_ns, &message);
    }

    /// Reads it.
    pub fn read(self) -> Outcome {
        self.read_with(&TrajectoryOptions::default())
    }

    /// Reads it in another way.
    pub fn read_with(self, options: &TrajectoryOptions) -> Outcome {
        self.writer.finish().expect("the disk has room");
        read_trajectory(&Bag::open(&self.folder.path().join("run"))?, options)
    }
}
