//! Poses of all robots in one message, and whose they are.

use std::collections::BTreeSet;

use rsrs_msgs::tf2_msgs::TFMessage;
use rsrs_msgs::{RosMessage, cdr, topics};

use super::run::Run;
use super::{NotClean, Outcome};
use crate::reader::Heard;
use crate::trajectory::arrays::{self, NamedPoseArray, PoseArray};
use crate::trajectory::collect::{commanded, fixed, natural_key};
use crate::trajectory::pose::RawPose;
use crate::trajectory::transforms::Tree;
use crate::trajectory::{Finding, PoseSource};
use crate::{Bag, TopicInfo};

/// Among so many messages of the beginning is one with each robot.
const N_ASKED: usize = 4096;

/// A source of poses that tells the robots apart in its messages.
pub struct Bodies {
    /// The topic.
    pub topic: String,
    /// The robots, in order.
    pub names: Vec<String>,
    /// What else is seen.
    pub others: BTreeSet<String>,
    source: PoseSource,
    tree: Tree,
    /// The frame of all poses, where it matters.
    frame: Option<String>,
    /// The robot that should be next.
    next: usize,
}

impl Bodies {
    /// Looks who is in the messages of a bag.
    ///
    /// # Returns
    ///
    /// `None` if not all are there that were commanded.
    pub fn find(bag: &Bag, infos: &[TopicInfo], source: PoseSource) -> Option<Self> {
        let topic = match arrays::topic(infos, source) {
            Some(topic) => {
                arrays::check_layout(bag, topic).ok()?;
                topic.name.clone()
            }
            None => topics::TF.name.to_owned(),
        };
        let mut names = commanded(infos);
        names.sort_by_cached_key(|name| natural_key(name));
        let tree = if source == PoseSource::Tf { fixed(bag, infos).ok()? } else { Tree::default() };
        let others = BTreeSet::new();
        let mut bodies = Self { topic, names, others, source, tree, frame: None, next: 0 };
        if source != PoseSource::PoseArray {
            let fixed = bodies.tree.clone();
            let mut seen = BTreeSet::new();
            for message in bag.messages_on([bodies.topic.as_str()]).take(N_ASKED) {
                let raw = bodies.raw(&message.ok()?.bytes).ok()?;
                seen.extend(raw.into_iter().map(|raw| raw.robot));
            }
            if !bodies.names.iter().all(|name| seen.remove(name)) {
                return None;
            }
            bodies.others = seen;
            bodies.tree = fixed;
        }
        (!bodies.names.is_empty()).then_some(bodies)
    }

    /// Hears one message.
    pub fn take(&mut self, heard: &Heard, run: &mut Run) -> Outcome<()> {
        for raw in self.raw(heard.bytes)? {
            if self.source == PoseSource::Tf {
                let frame = self.frame.get_or_insert_with(|| raw.frame.clone());
                if *frame != raw.frame {
                    return Err(NotClean);
                }
            }
            let robot = self.robot(&raw.robot);
            if robot.is_none() && !self.others.contains(&raw.robot) {
                return Err(NotClean);
            }
            let sample = raw.sample(heard.log_time_ns).map_err(|_refused| NotClean)?;
            robot.map_or(Ok(()), |robot| run.pose(robot, sample))?;
        }
        Ok(())
    }

    /// What is seen and is no robot of the run.
    pub fn ignored(self) -> impl Iterator<Item = Finding> {
        self.others.into_iter().map(|name| Finding::Ignored { name })
    }

    fn raw(&mut self, bytes: &[u8]) -> Outcome<Vec<RawPose>> {
        match self.source {
            PoseSource::NamedPoses => Ok(decode::<NamedPoseArray>(bytes)?.into_raw()),
            PoseSource::PoseArray => {
                let array = decode::<PoseArray>(bytes)?;
                // Who has which number is told by how many there are.
                if array.n_bodies() == self.names.len() {
                    Ok(array.into_raw())
                } else {
                    Err(NotClean)
                }
            }
            PoseSource::Tf => Ok(self.tree.take(decode::<TFMessage>(bytes)?)),
            PoseSource::Odom | PoseSource::Pose => Err(NotClean),
        }
    }

    fn robot(&mut self, name: &str) -> Option<usize> {
        if self.source == PoseSource::PoseArray {
            return name.parse().ok();
        }
        // Nearly always they come in the same order.
        let n_robots = self.names.len();
        let mut from_here = (self.next..n_robots).chain(0..self.next);
        let robot = from_here.find(|robot| self.names[*robot] == name)?;
        self.next = (robot + 1) % n_robots;
        Some(robot)
    }
}

fn decode<M: RosMessage>(bytes: &[u8]) -> Outcome<M> {
    cdr::decode(bytes).map_err(|_refused| NotClean)
}
