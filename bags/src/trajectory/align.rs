//! Rows out of robots that were recorded in step: the same instant of all robots in one sample.

use std::ops::Range;

use super::TrajectoryError;
use super::collect::{Collected, RecordedRobot};
use super::command;
use super::pose::PoseSample;
use super::resample::Rows;
use super::resample::most_step_ns;

/// Fewer commands than this do not show how regular they are.
const MIN_COMMANDS: usize = 10;

/// Poses and commands are of one rate if their periods differ by less than one in so many.
const SAME_RATE: u64 = 4;

/// The median distance of two poses of one robot, over all robots, in nanoseconds.
///
/// # Errors
///
/// [`TrajectoryError::TooFewPoses`] if no robot has two, and [`TrajectoryError::TooClose`] if most
/// have the same time.
pub fn median_period_ns(robots: &[RecordedRobot]) -> Result<u64, TrajectoryError> {
    let mut distances_ns: Vec<u64> = robots
        .iter()
        .flat_map(|robot| robot.poses.windows(2))
        .map(|pair| pair[1].stamp_ns.saturating_sub(pair[0].stamp_ns))
        .collect();
    distances_ns.sort_unstable();
    match (distances_ns.get(distances_ns.len() / 2), robots.first()) {
        (Some(&period_ns), _) if period_ns > 0 => Ok(period_ns),
        (Some(_), Some(robot)) => Err(TrajectoryError::TooClose {
            robot: robot.name.clone(),
            time_s: seconds(robot.poses[0].stamp_ns),
            distance_s: 0.0,
            period_s: 0.0,
        }),
        (_, robot) => {
            let robot = robot.map(|robot| robot.name.clone()).unwrap_or_default();
            Err(TrajectoryError::TooFewPoses { robot, n_samples: 1 })
        }
    }
}

/// The period of the trajectory, in nanoseconds: that of the commands if they come regularly and at
/// a lower rate than the poses, for the controller thinks once per command; else that of the poses.
///
/// Commands are regular if the distances of nine in ten are within a factor of 1.5 of the median.
pub fn period_ns(robots: &[RecordedRobot], recorded_ns: u64) -> u64 {
    let mut distances_ns: Vec<u64> = robots
        .iter()
        .flat_map(|robot| robot.commands.windows(2))
        .map(|pair| pair[1].log_ns.saturating_sub(pair[0].log_ns))
        .collect();
    distances_ns.sort_unstable();
    let n_distances = distances_ns.len();
    if n_distances < MIN_COMMANDS * robots.len() {
        return recorded_ns;
    }
    let at_percent = |percent: usize| distances_ns[(n_distances - 1) * percent / 100];
    let (low_ns, middle_ns, high_ns) = (at_percent(5), at_percent(50), at_percent(95));
    let is_regular = low_ns > middle_ns * 2 / 3 && high_ns < middle_ns * 3 / 2;
    // Poses that are rarer than commands are no reason to invent more of them.
    let is_rarer = middle_ns > recorded_ns + recorded_ns / SAME_RATE;
    if is_regular && is_rarer { middle_ns } else { recorded_ns }
}

/// Which poses of each robot stand side by side with those of all others, as many of each robot;
/// `None` if the robots were not recorded in step.
///
/// The edge of the window may fall between the robots of one sample, so the first and the last
/// sample are dropped where a robot lacks them.
pub fn side_by_side(collected: &Collected, period_ns: u64) -> Option<Vec<Range<usize>>> {
    let robots = &collected.robots[..];
    let is_regular = robots.iter().all(|robot| has_no_gaps(robot, period_ns));
    if !is_regular || comes_or_leaves(collected, period_ns) {
        return None;
    }
    let common = common_span(robots, period_ns)?;
    let poses = |robot: usize| &robots[robot].poses[common[robot].clone()];
    let is_near = |(one, other): (&PoseSample, &PoseSample)| {
        one.stamp_ns.abs_diff(other.stamp_ns) <= period_ns / 2
    };
    let are_near = (1..robots.len()).all(|robot| {
        poses(robot).len() == poses(0).len() && poses(robot).iter().zip(poses(0)).all(is_near)
    });
    are_near.then_some(common)
}

/// Puts those samples of the robots that [`side_by_side`] has found beside each other.
///
/// A run of hours fills memory, so what is no longer needed goes on the way.
pub fn align(robots: &mut [RecordedRobot], common: &[Range<usize>], period_ns: u64) -> Rows {
    let times_ns = robots[0].poses[common[0].clone()].iter().map(|pose| pose.stamp_ns).collect();
    let mut rows = Rows::new(times_ns, (robots.len(), period_ns));
    for (number, (robot, common)) in robots.iter_mut().zip(common).enumerate() {
        let poses = &robot.poses[common.clone()];
        rows.fill(number, poses, &command::answers(poses, &robot.commands, period_ns));
        (robot.poses, robot.commands) = (Vec::new(), Vec::new());
    }
    rows
}

/// Whether there is one pose in every period.
fn has_no_gaps(robot: &RecordedRobot, period_ns: u64) -> bool {
    robot.poses.windows(2).all(|pair| {
        let distance_ns = pair[1].stamp_ns.saturating_sub(pair[0].stamp_ns);
        (period_ns / 2..=most_step_ns(period_ns)).contains(&distance_ns)
    })
}

fn first_ns(robot: &RecordedRobot) -> u64 {
    robot.poses[0].stamp_ns
}

fn last_ns(robot: &RecordedRobot) -> u64 {
    robot.poses[robot.poses.len() - 1].stamp_ns
}

/// Whether a robot came or left more than one sample apart from the others.
fn comes_or_leaves(collected: &Collected, period_ns: u64) -> bool {
    let robots = &collected.robots;
    let earliest_ns = robots.iter().map(first_ns).min().unwrap_or(0);
    let latest_ns = robots.iter().map(last_ns).max().unwrap_or(0);
    let most_ns = most_step_ns(period_ns);
    robots.iter().any(|robot| {
        let late = first_ns(robot) - earliest_ns > most_ns;
        late || latest_ns - last_ns(robot) > most_ns
    })
}

/// Leaves out what some robots have before the first or after the last pose of another; `None` if
/// less than two poses are left of one.
fn common_span(robots: &[RecordedRobot], period_ns: u64) -> Option<Vec<Range<usize>>> {
    let half_ns = period_ns / 2;
    let start_ns = robots.iter().map(first_ns).max().unwrap_or(0);
    let end_ns = robots.iter().map(last_ns).min().unwrap_or(0);
    let common = |robot: &RecordedRobot| {
        let is_common = |pose: &PoseSample| {
            pose.stamp_ns.saturating_add(half_ns) >= start_ns
                && pose.stamp_ns <= end_ns.saturating_add(half_ns)
        };
        let from = robot.poses.iter().position(is_common).unwrap_or(robot.poses.len());
        let n_common = robot.poses[from..].iter().take_while(|pose| is_common(pose)).count();
        (n_common >= 2).then_some(from..from + n_common)
    };
    robots.iter().map(common).collect()
}

fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 / 1e9
}
