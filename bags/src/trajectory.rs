//! What a swarm did, out of a bag: the poses and commands that the judge wants.
//!
//! It takes any laboratory's bag that has a pose source for each robot and its commands. It does
//! not resample: robots must have been recorded in step, to within half a period.

mod align;
mod collect;
mod command;
mod error;
mod pose;
mod window;

use std::fmt;

use rsrs_core::trajectory::Trajectory;

use crate::{Bag, Damage};

pub use error::TrajectoryError;
pub use window::{RunningWindow, WindowSource};

/// Where poses come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PoseSource {
    /// `nav_msgs/Odometry` on `/<robot>/odom`: ground truth from a simulator, the robot's own
    /// estimate elsewhere.
    Odom,
    /// `geometry_msgs/PoseStamped` on `/<robot>/pose`: a tracker.
    Pose,
    /// `tf2_msgs/TFMessage` on `/tf`: transforms to `<robot>/base_link` or `<robot>/base_footprint`
    /// from one frame that all robots share.
    Tf,
}

impl PoseSource {
    /// All of them, the first choice first.
    pub const ALL: [Self; 3] = [Self::Odom, Self::Pose, Self::Tf];
}

impl fmt::Display for PoseSource {
    fn fmt(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str(match self {
            Self::Odom => "odom",
            Self::Pose => "pose",
            Self::Tf => "tf",
        })
    }
}

/// What to take from a bag.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TrajectoryOptions {
    /// Where poses come from; `None` takes the first of [`PoseSource::ALL`] that is there.
    pub poses: Option<PoseSource>,
}

/// A trajectory with what the bag says of it.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedTrajectory {
    /// Poses and commands while the swarm was running.
    pub trajectory: Trajectory,
    /// Names of the robots, in the order of the trajectory's rows: `robot_2` before `robot_10`.
    pub robots: Vec<String>,
    /// Where the poses came from.
    pub poses: PoseSource,
    /// When the swarm was running.
    pub window: RunningWindow,
    /// Time of the first sample, in nanoseconds, by the stamps of the poses.
    pub start_ns: u64,
    /// Where the bag breaks off; empty for a whole bag.
    pub damage: Vec<Damage>,
}

/// Reads poses and commands out of a bag.
///
/// Sample `k` of a robot is its `k`th pose within the running window, with the command that
/// answered it: the latest command up to half a period after the pose. A command older than
/// 2.5 periods (and 300 ms) has run out on the robot, which stands still then. The period is the
/// median distance of pose stamps.
///
/// A bag that breaks off is read up to there; [`RecordedTrajectory::damage`] says so.
///
/// # Errors
///
/// [`TrajectoryError`]: no poses, no commands, no running time, poses that are not numbers, or
/// robots that were not recorded in step.
///
/// # Source
///
/// Command timeout: DESIGN, as the robot's own.
pub fn read_trajectory(
    bag: &Bag,
    options: &TrajectoryOptions,
) -> Result<RecordedTrajectory, TrajectoryError> {
    let collected = collect::collect(bag, options)?;
    let period_ns = align::median_period_ns(&collected.robots)?;
    let window = window::running_window(&collected, period_ns)?;
    let (trajectory, start_ns) = align::align(&collected, &window, period_ns)?;
    Ok(RecordedTrajectory {
        trajectory,
        robots: collected.robots.into_iter().map(|robot| robot.name).collect(),
        poses: collected.poses,
        window,
        start_ns,
        damage: bag.damage(),
    })
}
