//! The ending of a run, without keeping the whole of it.
//!
//! The judge looks at the last minute of a run, and runs go on for hours. Most of them need no more
//! mending than a pose here and there, or poses at the times of commands: no robot is out of reach,
//! and stamps rise. Whether a run is of that kind can be told while it is read, and then what came
//! long ago need not be kept. A run that is not (robots that were taken for one another, say) is
//! read again, and mended as a whole; so what comes out is always what it would be of the whole run,
//! to the bit.

mod bodies;
mod lean;
mod middle;
mod rows;
mod run;
mod steps;
#[cfg(test)]
mod tests;
mod track;

use std::collections::BTreeMap;

use rsrs_msgs::geometry_msgs::{PoseStamped, Twist, TwistStamped};
use rsrs_msgs::nav_msgs::Odometry;
use rsrs_msgs::rsrs::RunLease;
use rsrs_msgs::{RosMessage, cdr, topics};

use super::collect::{choose, natural_key, wanted_topics};
use super::command::CommandSample;
use super::{Keep, PoseSource, RecordedTrajectory, TrajectoryOptions, pose};
use crate::reader::Heard;
use crate::{Bag, TopicInfo};
use bodies::Bodies;
use run::Run;

/// A run that must be mended, or is refused: the whole of it tells which.
#[derive(Debug)]
struct NotClean;

type Outcome<T> = Result<T, NotClean>;

/// Reads the ending of a run that needs no mending.
///
/// # Returns
///
/// Exactly what the whole run gives, abridged; `None` if the whole run must be read.
pub fn read(bag: &Bag, options: &TrajectoryOptions) -> Option<RecordedTrajectory> {
    let Keep::Ending { seconds } = options.keep else { return None };
    let infos = bag.topics();
    let poses = choose(&infos, options.poses).ok()?;
    let wanted = wanted_topics(&infos, poses).ok()?;
    let (names, mut bodies) = match poses {
        PoseSource::Odom | PoseSource::Pose => (robots(&wanted, poses)?, None),
        PoseSource::NamedPoses | PoseSource::PoseArray | PoseSource::Tf => {
            let bodies = Bodies::find(bag, &infos, poses)?;
            (bodies.names.clone(), Some(bodies))
        }
    };
    let has_lease = infos.iter().any(|topic| topic.name == topics::LEASE.name);
    let mut run = Run::new(names, (seconds, has_lease));

    let mut hearers: Vec<Option<Hearer>> = Vec::new();
    let mut messages = bag.messages_on(wanted.iter().map(|topic| topic.name.as_str()));
    while let Some(advanced) = messages.advance() {
        advanced.ok()?;
        let heard = messages.heard();
        if heard.number >= hearers.len() {
            hearers.resize(heard.number + 1, None);
        }
        let hearer = hearers[heard.number]
            .get_or_insert_with(|| Hearer::of(&heard, (&run, bodies.as_ref())));
        match (hearer, &mut bodies) {
            (Hearer::Bodies, Some(bodies)) => bodies.take(&heard, &mut run),
            (hearer, _) => hearer.take(&heard, &mut run),
        }
        .ok()?;
    }
    let mut ending = run.finish(bag, poses).ok()?;
    ending.findings.splice(..0, bodies.into_iter().flat_map(Bodies::ignored));
    Some(ending)
}

/// The robots with poses, in order.
fn robots(wanted: &[&TopicInfo], poses: PoseSource) -> Option<Vec<String>> {
    let mut names: Vec<String> =
        wanted.iter().filter_map(|topic| pose::robot_of_topic(topic, poses)).collect();
    names.sort_by_cached_key(|name| natural_key(name));
    names.dedup();
    (!names.is_empty()).then_some(names)
}

/// What messages of one topic are.
#[derive(Clone, Copy)]
enum Hearer {
    Lease,
    /// Poses of all robots.
    Bodies,
    /// Poses of a robot.
    Odometry(usize),
    PoseStamped(usize),
    /// Commands of a robot.
    TwistStamped(usize),
    Twist(usize),
    /// Commands of somebody without poses.
    OfNobody,
    /// Of a type that was not asked for.
    Other,
}

impl Hearer {
    fn of(heard: &Heard, (run, bodies): (&Run, Option<&Bodies>)) -> Self {
        let (topic, type_name) = (&**heard.topic, &**heard.type_name);
        if bodies.is_some_and(|bodies| bodies.topic == topic) {
            return Self::Bodies;
        }
        if topic == topics::LEASE.name {
            return Self::Lease;
        }
        let by_name: BTreeMap<&str, usize> =
            run.names().enumerate().map(|(robot, name)| (name, robot)).collect();
        let robot = |relative: topics::Topic| {
            let name = pose::robot_before(topic, relative.name)?;
            Some(by_name.get(name.as_str()).copied())
        };
        let kind = |relative: topics::Topic, kind: fn(usize) -> Self| {
            Some(robot(relative)?.map_or(Self::OfNobody, kind))
        };
        let known = match type_name {
            Odometry::TYPE_NAME => kind(topics::ODOM, Self::Odometry),
            PoseStamped::TYPE_NAME => kind(topics::POSE, Self::PoseStamped),
            TwistStamped::TYPE_NAME => kind(topics::CMD_VEL, Self::TwistStamped),
            Twist::TYPE_NAME => kind(topics::CMD_VEL, Self::Twist),
            _ => None,
        };
        known.unwrap_or(Self::Other)
    }

    fn take(self, heard: &Heard, run: &mut Run) -> Outcome<()> {
        let log_ns = heard.log_time_ns;
        run.is_in_order(log_ns)?;
        match self {
            Self::Lease => {
                let lease: RunLease = cdr::decode(heard.bytes).map_err(|_refused| NotClean)?;
                run.lease(log_ns, lease)
            }
            Self::Odometry(robot) => {
                let raw = lean::odometry(heard.bytes).ok_or(NotClean)?;
                run.pose(robot, raw.sample(log_ns).map_err(|_refused| NotClean)?)
            }
            Self::PoseStamped(robot) => {
                let raw = lean::pose_stamped(heard.bytes).ok_or(NotClean)?;
                run.pose(robot, raw.sample(log_ns).map_err(|_refused| NotClean)?)
            }
            Self::TwistStamped(robot) => run.command(robot, stamped(heard)?),
            Self::Twist(robot) => run.command(robot, unstamped(heard)?),
            // Whether a robot is missing is said by the other way.
            Self::OfNobody if &**heard.type_name == Twist::TYPE_NAME => still(unstamped(heard)?),
            Self::OfNobody => still(stamped(heard)?),
            Self::Bodies | Self::Other => Err(NotClean),
        }
    }
}

fn stamped(heard: &Heard) -> Outcome<CommandSample> {
    let message = lean::twist_stamped(heard.bytes).ok_or(NotClean)?;
    CommandSample::of_stamped("", &message, heard.log_time_ns).map_err(|_refused| NotClean)
}

fn unstamped(heard: &Heard) -> Outcome<CommandSample> {
    let message = lean::twist(heard.bytes).ok_or(NotClean)?;
    CommandSample::of_unstamped("", message, heard.log_time_ns).map_err(|_refused| NotClean)
}

fn still(command: CommandSample) -> Outcome<()> {
    if command.moves() { Err(NotClean) } else { Ok(()) }
}
