//! One pass over a bag: everything that bears on the trajectory.

use std::collections::{BTreeMap, BTreeSet};

use rsrs_core::robot::pose_source::PoseSource;
use rsrs_msgs::geometry_msgs::{PoseStamped, Twist, TwistStamped};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::RunLease;
use rsrs_msgs::tf2_msgs::TFMessage;
use rsrs_msgs::{RosMessage, cdr, topics};

use super::arrays::{self, NamedPoseArray, PoseArray};
use super::command::CommandSample;
use super::finding::Finding;
use super::frames::FrameChanges;
use super::pose::{self, PoseSample, RawPose};
use super::sources::{self, Chosen, described, has_poses, is_same, robot_commanded_by};
use super::transforms::Tree;
use super::{TrajectoryError, TrajectoryOptions};
use crate::{Bag, BagMessage, TopicInfo};

/// Transforms that never change; received once, and true from the beginning.
const TF_STATIC: &str = "/tf_static";

/// What was recorded of one robot.
#[derive(Debug)]
pub struct RecordedRobot {
    pub name: String,
    pub poses: Vec<PoseSample>,
    pub commands: Vec<CommandSample>,
    /// The frames of its poses, where they are of this robot alone.
    pub frames: FrameChanges,
}

/// A change of the run lease.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeaseSample {
    /// When it was recorded, in nanoseconds.
    pub log_ns: u64,
    /// Whether it let the robots move.
    pub running: bool,
    /// Of which run it is, by its place among them.
    pub run: usize,
}

/// What one pass over the bag found.
#[derive(Debug)]
pub struct Collected {
    /// All robots that have poses; `robot_2` before `robot_10`.
    pub robots: Vec<RecordedRobot>,
    /// The leases of the run, in the order of the bag; `None` if there is no such topic.
    pub lease: Option<Vec<LeaseSample>>,
    pub poses: PoseSource,
    /// The last log time in the bag, in nanoseconds.
    pub end_ns: u64,
    /// What was passed over.
    pub findings: Vec<Finding>,
}

/// Poses and commands by robot, as they are found.
#[derive(Default)]
struct RecordedSamples {
    poses: BTreeMap<String, Vec<PoseSample>>,
    commands: BTreeMap<String, Vec<CommandSample>>,
    lease: Vec<LeaseSample>,
    /// The runs that leases are of, by id, with the robots that they let move.
    runs: Vec<(String, BTreeSet<String>)>,
    /// The robots that the lease of the run names.
    members: BTreeSet<String>,
    /// The most poses in one message without names.
    n_unnamed: usize,
    tree: Tree,
    /// The frame at the upper end of each robot's transforms.
    frames: BTreeMap<String, String>,
    /// The frames of what each robot publishes by itself, or a tracker in its name.
    own_frames: BTreeMap<String, FrameChanges>,
}

/// Reads the bag once.
pub fn collect(bag: &Bag, options: &TrajectoryOptions) -> Result<Collected, TrajectoryError> {
    let topics = bag.topics();
    if let Some(damage) = bag.damage().into_iter().next() {
        return Err(TrajectoryError::Damaged(damage));
    }
    if bag.n_messages() == 0 {
        return Err(TrajectoryError::NoMessages { n_topics: topics.len() });
    }
    let Chosen { source, others } = sources::choose(&topics, options.poses)?;
    if let Some(topic) = arrays::topic(&topics, source) {
        arrays::check_layout(bag, topic)?;
    }
    let wanted = wanted_topics(&topics, source)?;

    let mut found = RecordedSamples::default();
    if source == PoseSource::Tf {
        found.tree = fixed(bag, &topics)?;
    }
    for message in bag.messages_on(wanted.iter().map(|topic| topic.name.as_str())) {
        found.take(source, &message?)?;
    }
    found.keep_one_run(options.run_id.as_deref());

    if found.poses.is_empty() {
        let silent = topics.iter().filter(|topic| has_poses(&topics, topic, source));
        let topics = silent.map(|topic| topic.name.clone()).collect();
        return Err(TrajectoryError::SilentPoses { topics });
    }
    if source == PoseSource::PoseArray {
        let topic = arrays::topic(&topics, source).map(|topic| topic.name.clone());
        found.name_by_number(topic.unwrap_or_default())?;
    }
    found.check_frames()?;
    found.check_members()?;
    let has_lease = topics.iter().any(|topic| topic.name == topics::LEASE.name);
    let (robots, mut findings) = found.robots(source, &topics)?;
    if !others.is_empty() {
        findings.push(Finding::Unstated { taken: source, others });
    }
    Ok(Collected {
        robots,
        lease: has_lease.then_some(found.lease),
        poses: source,
        end_ns: bag.files().iter().filter_map(|file| Some(file.bounds_ns?.1)).max().unwrap_or(0),
        findings,
    })
}

/// The topics with poses, commands and the lease; each must have one type.
fn wanted_topics(
    topics: &[TopicInfo],
    source: PoseSource,
) -> Result<Vec<&TopicInfo>, TrajectoryError> {
    let wanted: Vec<&TopicInfo> = topics
        .iter()
        .filter(|topic| {
            has_poses(topics, topic, source)
                || robot_commanded_by(topic).is_some()
                || is_same(topic, topics::LEASE)
        })
        .collect();
    for topic in &wanted {
        let types: BTreeSet<&str> = topics
            .iter()
            .filter(|other| other.name == topic.name)
            .map(|other| other.type_name.as_str())
            .collect();
        if types.len() > 1 {
            let types = types.into_iter().map(str::to_owned).collect();
            return Err(TrajectoryError::TwoTypes { topic: topic.name.clone(), types });
        }
    }
    Ok(wanted)
}

impl RecordedSamples {
    fn take(&mut self, source: PoseSource, message: &BagMessage) -> Result<(), TrajectoryError> {
        let topic = &*message.topic;
        let log_ns = message.log_time_ns;
        if topic == topics::LEASE.name {
            let lease = decode::<RunLease>(message)?;
            let running = lease.state == RunLease::RUNNING;
            let run = self.runs.iter().position(|(run_id, _)| *run_id == lease.run_id);
            let run = run.unwrap_or_else(|| {
                self.runs.push((lease.run_id, BTreeSet::new()));
                self.runs.len() - 1
            });
            self.lease.push(LeaseSample { log_ns, running, run });
            if running {
                self.runs[run].1.extend(lease.robots);
            }
        } else if let Some(robot) = pose::robot_before(topic, topics::CMD_VEL.name) {
            let command = if &*message.type_name == Twist::TYPE_NAME {
                CommandSample::of_unstamped(&robot, decode::<Twist>(message)?, log_ns)?
            } else {
                CommandSample::of_stamped(&robot, &decode::<TwistStamped>(message)?, log_ns)?
            };
            self.commands.entry(robot).or_default().push(command);
        } else {
            for raw in self.raw_poses(source, message)? {
                self.take_pose(source, raw, log_ns)?;
            }
        }
        Ok(())
    }

    /// Forgets the leases of other runs, who may be anybody in the same network.
    fn keep_one_run(&mut self, run_id: Option<&str>) {
        let named = self.runs.iter().position(|(known, _)| Some(known.as_str()) == run_id);
        let first = || self.lease.iter().find(|sample| sample.running).map(|sample| sample.run);
        let Some(run) = named.or_else(first) else { return };
        self.lease.retain(|sample| sample.run == run);
        self.members = std::mem::take(&mut self.runs[run].1);
    }

    fn take_pose(
        &mut self,
        source: PoseSource,
        raw: RawPose,
        log_ns: u64,
    ) -> Result<(), TrajectoryError> {
        if source == PoseSource::Tf {
            let before = self.frames.insert(raw.robot.clone(), raw.frame.clone());
            if let Some(expected) = before.filter(|before| *before != raw.frame) {
                if !self.tree.leads(&expected, &raw.frame) {
                    let (robot, found) = (raw.robot, raw.frame);
                    return Err(TrajectoryError::Frames { robot, found, expected });
                }
                // The upper part of the chain came later than the lower: until then it was unknown
                // where the robot was.
                self.poses.remove(&raw.robot);
            }
        }
        if source.is_of_each_robot() {
            self.own_frames.entry(raw.robot.clone()).or_default().take(log_ns, &raw.frame);
        }
        self.poses.entry(raw.robot.clone()).or_default().push(raw.sample(log_ns)?);
        Ok(())
    }

    fn raw_poses(
        &mut self,
        source: PoseSource,
        message: &BagMessage,
    ) -> Result<Vec<RawPose>, TrajectoryError> {
        let robot = |relative| {
            pose::robot_before(&message.topic, relative).expect("only such topics were asked for")
        };
        Ok(match source {
            PoseSource::Odom => {
                let Odometry { header, pose, .. } = decode(message)?;
                vec![pose::of_message(robot(topics::ODOM.name), &header, pose.pose)]
            }
            PoseSource::Pose => {
                let PoseStamped { header, pose } = decode(message)?;
                vec![pose::of_message(robot(topics::POSE.name), &header, pose)]
            }
            PoseSource::NamedPoses => decode::<NamedPoseArray>(message)?.into_raw(),
            PoseSource::PoseArray => {
                let array = decode::<PoseArray>(message)?;
                self.n_unnamed = self.n_unnamed.max(array.n_bodies());
                array.into_raw()
            }
            PoseSource::Tf => self.tree.take(decode(message)?),
        })
    }

    /// Refuses robots whose transforms start from different frames.
    fn check_frames(&self) -> Result<(), TrajectoryError> {
        let Some(expected) = self.frames.values().next() else { return Ok(()) };
        match self.frames.iter().find(|(_, frame)| *frame != expected) {
            None => Ok(()),
            Some((robot, found)) => {
                let (robot, found) = (robot.clone(), found.clone());
                Err(TrajectoryError::Frames { robot, found, expected: expected.clone() })
            }
        }
    }

    /// Gives poses without names the names of the robots, in their order.
    fn name_by_number(&mut self, topic: String) -> Result<(), TrajectoryError> {
        let commanded = || self.commands.keys().cloned().collect();
        let mut names: Vec<String> = if self.members.is_empty() {
            commanded()
        } else {
            self.members.iter().cloned().collect()
        };
        if names.len() != self.n_unnamed {
            let (n_poses, n_robots) = (self.n_unnamed, names.len());
            return Err(TrajectoryError::Unnamed { topic, n_poses, n_robots });
        }
        names.sort_by_cached_key(|name| natural_key(name));
        let numbered = std::mem::take(&mut self.poses);
        self.poses = numbered
            .into_iter()
            .map(|(number, poses)| {
                let number: usize = number.parse().expect("the array was named by numbers");
                (names[number].clone(), poses)
            })
            .collect();
        Ok(())
    }

    /// Refuses a run of which some robots have no poses.
    fn check_members(&self) -> Result<(), TrajectoryError> {
        let moved = self
            .commands
            .iter()
            .filter(|(_, commands)| commands.iter().any(CommandSample::moves))
            .map(|(robot, _)| robot.clone());
        let members: BTreeSet<String> =
            if self.members.is_empty() { moved.collect() } else { self.members.clone() };
        let is_missing = |robot: &String| !self.poses.contains_key(robot);
        let mut robots: Vec<String> = members.into_iter().filter(is_missing).collect();
        if robots.is_empty() {
            return Ok(());
        }
        robots.sort_by_cached_key(|robot| natural_key(robot));
        Err(TrajectoryError::MissingRobots { robots })
    }

    /// The robots of the run, in order, and what has poses and is none of them.
    fn robots(
        &mut self,
        source: PoseSource,
        topics: &[TopicInfo],
    ) -> Result<(Vec<RecordedRobot>, Vec<Finding>), TrajectoryError> {
        // A tracker sees more than robots; a topic in a robot's name is a robot's.
        let may_be_others = !source.is_of_each_robot();
        let has_robots = self.poses.keys().any(|name| self.commands.contains_key(name));
        let mut robots = Vec::new();
        let mut findings = Vec::new();
        for (name, mut poses) in std::mem::take(&mut self.poses) {
            let is_other = !self.members.is_empty() && !self.members.contains(&name);
            let commands = self.commands.remove(&name);
            if is_other || (may_be_others && commands.is_none() && has_robots) {
                findings.push(Finding::Ignored { name });
                continue;
            }
            let Some(commands) = commands else {
                let expected = topics::CMD_VEL.for_robot(&name);
                let topics = described(topics);
                return Err(TrajectoryError::NoCommands { robot: name, expected, topics });
            };
            pose::fill_missing_stamps(&mut poses);
            let frames = self.own_frames.remove(&name).unwrap_or_default();
            robots.push(RecordedRobot { name, poses, commands, frames });
        }
        robots.sort_by_cached_key(|robot: &RecordedRobot| natural_key(&robot.name));
        Ok((robots, findings))
    }
}

/// The transforms that never change.
///
/// # Errors
///
/// If the bag cannot be read there, or a message is none.
fn fixed(bag: &Bag, topics: &[TopicInfo]) -> Result<Tree, TrajectoryError> {
    let is_fixed =
        |topic: &&TopicInfo| topic.name == TF_STATIC && topic.type_name == TFMessage::TYPE_NAME;
    let names = topics.iter().filter(is_fixed).map(|topic| topic.name.as_str());
    let mut tree = Tree::default();
    for message in bag.messages_on(names) {
        drop(tree.take(decode(&message?)?));
    }
    Ok(tree)
}

fn decode<M: RosMessage>(message: &BagMessage) -> Result<M, TrajectoryError> {
    cdr::decode(&message.bytes).map_err(|source| TrajectoryError::Message {
        topic: message.topic.to_string(),
        time_s: message.log_time_ns as f64 / 1e9,
        source,
    })
}

/// Orders names by the number at their end, where there is one.
pub fn natural_key(name: &str) -> (String, Option<u64>) {
    let stem = name.trim_end_matches(|character: char| character.is_ascii_digit());
    (stem.to_owned(), name[stem.len()..].parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_are_in_the_order_in_which_people_count() {
        let mut names = ["robot_10", "robot_2", "robot", "rabbit_3"];

        names.sort_by_key(|name| natural_key(name));

        assert_eq!(names, ["rabbit_3", "robot", "robot_2", "robot_10"]);
    }
}
