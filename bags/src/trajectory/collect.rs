//! One pass over a bag: everything that bears on the trajectory.

use std::collections::{BTreeMap, BTreeSet};

use rsrs_core::natural_order::natural_key;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::tracker::{HandOver, Taken, TrackerFrame};
use rsrs_msgs::geometry_msgs::{PoseArray, PoseStamped, Twist, TwistStamped};
use rsrs_msgs::motion_capture_tracking_interfaces::NamedPoseArray;
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::{LeaseState, RunLease};
use rsrs_msgs::{RosMessage, cdr, topics};

use super::arrays;
use super::command::CommandSample;
use super::finding::Finding;
use super::frame_changes::FrameChanges;
use super::pose::{self, PoseSample, RawPose};
use super::sources::{self, Chosen, described, has_poses, is_same, robot_commanded_by};
use super::tracked::PoseReader;
use super::transforms::Tree;
use super::{RecordedTracker, TrajectoryError, TrajectoryOptions, UnreadablePoses};
use crate::{Bag, BagMessage, TopicInfo};

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
    /// How many poses a message without names has, which must not change.
    n_unnamed: Option<usize>,
    tree: Tree,
    /// The frame at the upper end of each robot's transforms.
    frames: BTreeMap<String, String>,
    /// The frames of what each robot publishes by itself, or a tracker in its name.
    own_frames: BTreeMap<String, FrameChanges>,
    /// What reads the poses of a tracker that is described.
    described: Option<DescribedTracker>,
}

/// A tracker that the record of the run describes.
struct DescribedTracker {
    reader: PoseReader,
    frame: TrackerFrame,
    /// Which of its machines counts for each robot.
    machines: HandOver<usize>,
    /// Machines that saw a robot in two places: by robot, the greatest distance, in metres.
    apart: BTreeMap<String, (f64, [usize; 2])>,
}

impl DescribedTracker {
    fn new(source: PoseSource, described: &RecordedTracker) -> Self {
        let RecordedTracker { tracker, robots, radius_m } = described;
        Self {
            reader: PoseReader::new(source, tracker, robots),
            frame: tracker.frame,
            machines: HandOver::new(*radius_m),
            apart: BTreeMap::new(),
        }
    }

    /// Whether this pose of a robot counts, now that several machines may see it.
    fn counts(&mut self, robot: &str, machine: usize, sample: &PoseSample) -> bool {
        match self.machines.take(robot, machine, sample.log_ns, sample.pose) {
            Taken::Used => true,
            Taken::Spare => false,
            Taken::Apart { by_m, other } => {
                let known = self.apart.entry(robot.to_owned()).or_insert((by_m, [other, machine]));
                if by_m > known.0 {
                    *known = (by_m, [other, machine]);
                }
                false
            }
        }
    }

    /// What the machines disagreed about.
    fn findings(&self) -> Vec<Finding> {
        let topic_of = |robot: &str, machine: usize| {
            let of_machine = self.reader.topics().iter().filter(|topic| topic.machine == machine);
            let mut of_robot = of_machine
                .filter(|topic| topic.robot.as_deref().is_none_or(|other| other == robot));
            of_robot.next().map(|topic| topic.name.clone()).unwrap_or_default()
        };
        let finding = |(robot, (by_m, machines)): (&String, &(f64, [usize; 2]))| Finding::Apart {
            robot: robot.clone(),
            by_m: *by_m,
            topics: machines.map(|machine| topic_of(robot, machine)),
        };
        self.apart.iter().map(finding).collect()
    }
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
    let mut found = RecordedSamples::default();
    let Chosen { source, others } = match (options.poses, &options.tracker) {
        (Some(source), Some(described)) => {
            found.described = Some(DescribedTracker::new(source, described));
            Chosen { source, others: Vec::new() }
        }
        (asked, _) => sources::choose(&topics, asked)?,
    };
    let wanted = {
        let has_poses = |topic: &TopicInfo| match &found.described {
            None => has_poses(&topics, topic, source),
            Some(described) => described.reader.index_of(&topic.name, &topic.type_name).is_some(),
        };
        wanted_topics(&topics, &has_poses)?
    };
    if let Some(described) = &found.described {
        described.reader.check(&topics)?;
    }
    for topic in &wanted {
        arrays::check_layout(bag, topic)?;
    }
    if source == PoseSource::Tf {
        found.take_fixed(bag, &topics)?;
    }
    for message in bag.messages_on(wanted.iter().map(|topic| topic.name.as_str())) {
        found.take(source, &message?)?;
    }
    found.keep_one_run(options.run_id.as_deref());

    if found.poses.is_empty() {
        let silent = wanted
            .iter()
            .filter(|topic| robot_commanded_by(topic).is_none() && !is_same(topic, topics::LEASE));
        let topics = silent.map(|topic| topic.name.clone()).collect();
        return Err(TrajectoryError::SilentPoses { topics });
    }
    if source == PoseSource::PoseArray && found.described.is_none() {
        let topic = arrays::topic(&topics, source).map(|topic| topic.name.clone());
        found.name_by_number(topic.unwrap_or_default())?;
    }
    found.check_frames()?;
    found.check_members()?;
    let has_lease = topics.iter().any(|topic| topic.name == topics::LEASE.name);
    let (robots, mut findings) = found.robots(source, &topics)?;
    findings.extend(found.described.iter().flat_map(DescribedTracker::findings));
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
fn wanted_topics<'a>(
    topics: &'a [TopicInfo],
    has_poses: &dyn Fn(&TopicInfo) -> bool,
) -> Result<Vec<&'a TopicInfo>, TrajectoryError> {
    let wanted: Vec<&TopicInfo> = topics
        .iter()
        .filter(|topic| {
            has_poses(topic) || robot_commanded_by(topic).is_some() || is_same(topic, topics::LEASE)
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
            let running = lease.state == LeaseState::Running;
            let run = self.runs.iter().position(|(run_id, _)| *run_id == lease.run_id);
            let run = run.unwrap_or_else(|| {
                self.runs.push((lease.run_id, BTreeSet::new()));
                self.runs.len() - 1
            });
            self.lease.push(LeaseSample { log_ns, running, run });
            if running {
                self.runs[run].1.extend(lease.robots);
            }
        } else if let Some(robot) = pose::robot_of(topic, topics::CMD_VEL) {
            let command = if &*message.type_name == Twist::TYPE_NAME {
                CommandSample::of_unstamped(&robot, decode::<Twist>(message)?, log_ns)?
            } else {
                CommandSample::of_stamped(&robot, &decode::<TwistStamped>(message)?, log_ns)?
            };
            self.commands.entry(robot).or_default().push(command);
        } else {
            let (machine, raw) = self.raw_poses(source, message)?;
            for raw in raw {
                self.take_pose((source, machine), raw, log_ns)?;
            }
        }
        Ok(())
    }

    /// Takes the transforms that never change.
    fn take_fixed(&mut self, bag: &Bag, topics: &[TopicInfo]) -> Result<(), TrajectoryError> {
        // They never change: received once, and true from the beginning.
        let is_fixed = |topic: &&TopicInfo| is_same(topic, topics::TF_STATIC);
        let names = topics.iter().filter(is_fixed).map(|topic| topic.name.as_str());
        for message in bag.messages_on(names) {
            let fixed = self.raw_poses(PoseSource::Tf, &message?)?;
            drop(fixed);
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
        (source, machine): (PoseSource, usize),
        raw: RawPose,
        log_ns: u64,
    ) -> Result<(), TrajectoryError> {
        if source == PoseSource::Tf {
            let before = self.frames.insert(raw.robot.clone(), raw.frame.clone());
            if let Some(expected) = before.filter(|before| *before != raw.frame) {
                let tree = self.described.as_ref().map_or(&self.tree, |it| it.reader.tree());
                if !tree.leads(&expected, &raw.frame) {
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
        let robot = raw.robot.clone();
        let mut sample = raw.sample(log_ns)?;
        if let Some(described) = &mut self.described {
            sample.pose = described.frame.on_floor(sample.pose);
            if !described.counts(&robot, machine, &sample) {
                return Ok(());
            }
        }
        self.poses.entry(robot).or_default().push(sample);
        Ok(())
    }

    fn raw_poses(
        &mut self,
        source: PoseSource,
        message: &BagMessage,
    ) -> Result<(usize, Vec<RawPose>), TrajectoryError> {
        if let Some(described) = &mut self.described {
            let index = described.reader.index_of(&message.topic, &message.type_name);
            let index = index.expect("only such topics were asked for");
            let raw = described.reader.take(index, &message.bytes);
            let raw = raw.map_err(|reason| TrajectoryError::OfTracker {
                topic: message.topic.to_string(),
                time_s: message.log_time_ns as f64 / 1e9,
                reason,
            })?;
            return Ok((described.reader.topics()[index].machine, raw));
        }
        let robot =
            |known| pose::robot_of(&message.topic, known).expect("only such topics were asked for");
        let raw = match source {
            PoseSource::Odom => {
                let Odometry { header, pose, .. } = decode(message)?;
                vec![pose::of_message(robot(topics::ODOM), &header, pose.pose)]
            }
            PoseSource::Pose => {
                let PoseStamped { header, pose } = decode(message)?;
                vec![pose::of_message(robot(topics::POSE), &header, pose)]
            }
            PoseSource::NamedPoses => arrays::named(decode::<NamedPoseArray>(message)?),
            PoseSource::PoseArray => {
                let array = decode::<PoseArray>(message)?;
                let found = array.poses.len();
                let expected = *self.n_unnamed.get_or_insert(found);
                if found != expected {
                    return Err(TrajectoryError::OfTracker {
                        topic: message.topic.to_string(),
                        time_s: message.log_time_ns as f64 / 1e9,
                        reason: UnreadablePoses::Length { found, expected },
                    });
                }
                arrays::in_order(array, |number| number.to_string())
            }
            PoseSource::Tf => self.tree.take(decode(message)?, &pose::robot_of_frame, None),
        };
        Ok((0, raw))
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
        let n_poses = self.n_unnamed.unwrap_or(0);
        if names.len() != n_poses {
            let n_robots = names.len();
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

fn decode<M: RosMessage>(message: &BagMessage) -> Result<M, TrajectoryError> {
    cdr::decode(&message.bytes).map_err(|source| TrajectoryError::Message {
        topic: message.topic.to_string(),
        time_s: message.log_time_ns as f64 / 1e9,
        source,
    })
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
