//! What a swarm did, out of a bag: the poses and commands that the judge wants.
//!
//! It takes any laboratory's bag that has a pose source for each robot and its commands. Robots that
//! were recorded in step, to within half a period, are taken as they are; others are resampled. What
//! was mended on the way is in [`RecordedTrajectory::findings`], and what cannot be mended is
//! refused by name: a trajectory is never made up.

mod align;
mod arrays;
mod clocks;
mod collect;
mod command;
mod error;
mod finding;
mod frame_changes;
mod frames;
mod jumps;
mod needed;
mod objects;
mod pose;
mod resample;
mod sources;
mod tracked;
mod transforms;
mod window;

use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_core::robot::unicycle::Pose;
use rsrs_core::tracker::{Tracker, TrackerFrame};

use crate::Bag;
use resample::Times;

pub use error::{TrajectoryError, UnreadablePoses};
pub use finding::Finding;
pub use needed::Needed;
pub use pose::RawPose;
pub use tracked::{PoseReader, TrackedTopic};
pub use window::{RunningWindow, WindowSource};

/// What to take from a bag.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrajectoryOptions {
    /// Where poses come from; `None` takes the first of [`PoseSource::ALL`] that has all robots.
    pub poses: Option<PoseSource>,
    /// Whose leases define when the swarm was running; without any of this run, those of the first one
    /// that was RUNNING.
    pub run_id: Option<String>,
    /// What of the run must be known well.
    pub needed: Needed,
    /// The tracker that published them, where the record describes it; used with `poses`.
    pub tracker: Option<RecordedTracker>,
}

/// A tracker as the record of a run describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedTracker {
    /// How it publishes, and where its frame is on the floor.
    pub tracker: Tracker,
    /// The robots of the run.
    pub robots: Vec<String>,
    /// Radius of their bodies, in metres: machines that agree about a robot are not that far apart.
    pub radius_m: f64,
}

/// A trajectory with findings about the bag.
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
    /// What was mended on the way; empty for a bag that needed nothing.
    pub findings: Vec<Finding>,
}

/// Reads poses and commands out of a bag.
///
/// Sample `k` of a robot is its `k`th pose within the running window, with the command that
/// answered it: the latest command up to half a period after the pose. A command older than
/// 2.5 periods (and 300 ms) has run out on the robot, which stands still then. The period is the
/// median distance of commands if they come regularly, else that of pose stamps.
///
/// Robots that are not in step, of which poses are missing or which came late are interpolated at every
/// period. Within the time that is judged ([`rsrs_core::judge::window::WINDOW_S`]) that goes over gaps of at most [`rsrs_core::judge::window::MAX_GAP_S`]
/// and at most 20 % of a robot's poses; before it gaps are named. Single
/// poses out of all reach are left out, and robots that a tracker took for one another are set
/// right. Objects that have poses in the bag ([`topics::OBJECT_POSE`](rsrs_msgs::topics::OBJECT_POSE)) are where they were
/// at the times of the samples, `object_2` before `object_10`. Stamps of several clocks are put on one, by the log times beside them.
///
/// # Errors
///
/// [`TrajectoryError`]: a bag that is damaged, no poses or none of some robot, no commands, no running
/// time, poses in several frames or that are not numbers, too many missing, clocks that go back, jumps that nothing
/// explains, robots that came or left in the middle, robots that start on one spot.
///
/// # Source
///
/// Command timeout: DESIGN, as the robot's own.
pub fn read_trajectory(
    bag: &Bag,
    options: &TrajectoryOptions,
) -> Result<RecordedTrajectory, TrajectoryError> {
    let mut collected = collect::collect(bag, options)?;
    for robot in &mut collected.robots {
        clocks::sort(robot)?;
    }
    let clocks = clocks::align(&mut collected.robots)?;
    let poses_ns = clocks::ahead_ns(&collected.robots).unwrap_or(0);
    let recorded_ns = align::median_period_ns(&collected.robots)?;
    let period_ns = align::period_ns(&collected.robots, recorded_ns);
    let window = window::running_window(&collected, period_ns)?;
    frames::check(&collected.robots, &window)?;
    let frame = frames::of_robots(&collected.robots, &window).map(str::to_owned);
    window::cut(&mut collected, &window, (recorded_ns, options.needed))?;
    let mut findings = std::mem::take(&mut collected.findings);
    findings.extend(clocks);
    findings.extend(jumps::mend(&mut collected.robots, recorded_ns)?);

    let is_one_rate = period_ns == recorded_ns;
    let common = is_one_rate.then(|| align::side_by_side(&collected, period_ns)).flatten();
    let rows = if let Some(common) = common {
        align::align(&mut collected.robots, &common, period_ns)
    } else {
        let times = Times { recorded_ns, period_ns, needed: options.needed };
        resample::resample(&collected.robots, times, &mut findings)?
    };
    let robots: Vec<String> = collected.robots.into_iter().map(|robot| robot.name).collect();
    refuse_one_spot(rows.trajectory.poses_at(0), &robots)?;
    let mut trajectory = rows.trajectory;
    let on_floor = match (options.poses, &options.tracker) {
        (Some(_), Some(described)) => described.tracker.frame,
        _ => TrackerFrame::default(),
    };
    let mut objects = objects::collect(bag, poses_ns, on_floor)?;
    let other = frame.and_then(|frame| frames::other_frame(&objects, &frame, &window));
    let speeds_m_s = trajectory.commands.iter().map(|command| command.speed_m_s.abs());
    let speed_m_s = speeds_m_s.fold(0.0, f64::max);
    let places = other.map_or_else(
        || {
            findings.extend(objects::tidy(&mut objects, speed_m_s, &rows.times_ns)?);
            objects::at(&objects, &rows.times_ns)
        },
        Err,
    );
    match places {
        Ok(objects_m) => (trajectory.n_objects, trajectory.objects_m) = (objects.len(), objects_m),
        Err(unknown) => findings.push(unknown),
    }
    Ok(RecordedTrajectory {
        trajectory,
        robots,
        poses: collected.poses,
        window,
        start_ns: rows.times_ns[0],
        findings,
    })
}

/// Centres of robots are further apart than this, in metres: bodies are wider.
const MIN_APART_M: f64 = 0.02;

/// Refuses robots that start on one spot.
fn refuse_one_spot(starts: &[Pose], robots: &[String]) -> Result<(), TrajectoryError> {
    let is_near = |one: &Pose, other: &Pose| {
        libm::hypot(one.x_m - other.x_m, one.y_m - other.y_m) < MIN_APART_M
    };
    for (first, start) in starts.iter().enumerate() {
        let others = (first + 1..starts.len()).filter(|other| is_near(start, &starts[*other]));
        let together: Vec<String> =
            std::iter::once(first).chain(others).map(|robot| robots[robot].clone()).collect();
        if together.len() > 1 {
            let (x_m, y_m) = (start.x_m, start.y_m);
            return Err(TrajectoryError::OneSpot { robots: together, x_m, y_m });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x_m: f64, y_m: f64) -> Pose {
        Pose { x_m, y_m, heading_rad: 0.0 }
    }

    #[test]
    fn robots_side_by_side_are_distinguished_from_robots_on_one_spot() {
        let robots: Vec<String> = (1..=3).map(|robot| format!("robot_{robot}")).collect();

        assert!(refuse_one_spot(&[at(0.0, 0.0), at(0.05, 0.0), at(0.0, 0.05)], &robots).is_ok());
        let error =
            refuse_one_spot(&[at(0.0, 0.0), at(1.0, 0.0), at(0.001, 0.0)], &robots).unwrap_err();
        assert_eq!(
            error.to_string(),
            "robots robot_1, robot_3 start on one spot, (0.00 m, 0.00 m): each has poses in a frame \
             of its own?"
        );
    }
}
