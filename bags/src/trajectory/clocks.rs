//! Stamps of several clocks, put on that of the recorder.
//!
//! A robot stamps its commands, and a tracker on another machine stamps poses; one of them may count
//! seconds since it was switched on. The recorder has received both, so its clock then shows
//! how far theirs are apart, give or take the time on the way.

use super::TrajectoryError;
use super::collect::RecordedRobot;
use super::command::{self, CommandSample};
use super::finding::Finding;

/// Stamps and log times of two streams may differ by so much because one of them is longer on its
/// way, in nanoseconds; a command is obeyed for 300 ms at least.
const MAX_APART_NS: i128 = 250_000_000;

/// A run is looked at in so many parts: clocks may be set in the middle of it.
const N_PARTS: usize = 10;

/// How far the stamps of one stream are ahead of its log times, in nanoseconds.
struct Offsets {
    /// In each part of the run in which it has messages.
    of_part: Vec<Option<i128>>,
    /// Over all of it.
    middle: i128,
}

impl Offsets {
    /// By stamps and log times; `None` without any.
    fn new(times_ns: impl Iterator<Item = (u64, u64)> + Clone, run_ns: (u64, u64)) -> Option<Self> {
        let ahead = |(stamp_ns, log_ns): (u64, u64)| i128::from(stamp_ns) - i128::from(log_ns);
        let part_of = |log_ns: u64| {
            let passed = u128::from(log_ns.saturating_sub(run_ns.0)) * N_PARTS as u128;
            let part = passed / u128::from(run_ns.1 - run_ns.0 + 1);
            usize::try_from(part).map_or(N_PARTS - 1, |part| part.min(N_PARTS - 1))
        };
        let mut parts: Vec<Vec<i128>> = vec![Vec::new(); N_PARTS];
        for time_ns in times_ns.clone() {
            parts[part_of(time_ns.1)].push(ahead(time_ns));
        }
        let middle = median(times_ns.map(ahead).collect())?;
        Some(Self { of_part: parts.into_iter().map(median).collect(), middle })
    }

    /// How much they change during the run.
    fn spread(&self) -> i128 {
        spread(self.of_part.iter().flatten().copied())
    }
}

/// Puts all stamps on the recorder's clock, if they come from clocks that differ; `None` if they
/// agree, and nothing was changed.
///
/// # Errors
///
/// [`TrajectoryError::Clocks`] if no shift brings a robot's poses together with the others.
pub fn align(robots: &mut [RecordedRobot]) -> Result<Option<Finding>, TrajectoryError> {
    let logs_ns = || robots.iter().flat_map(|robot| &robot.poses).map(|pose| pose.log_ns);
    let Some(run_ns) = logs_ns().min().zip(logs_ns().max()) else { return Ok(None) };
    let of_poses = |robot: &RecordedRobot| {
        Offsets::new(robot.poses.iter().map(|pose| (pose.stamp_ns, pose.log_ns)), run_ns)
    };
    // Commands of which one has no stamp are put on log time anyway.
    let of_commands = |robot: &RecordedRobot| {
        let times = |command: &CommandSample| Some((command.stamp_ns?, command.log_ns));
        let times: Option<Vec<(u64, u64)>> = robot.commands.iter().map(times).collect();
        Offsets::new(times?.into_iter(), run_ns)
    };
    let poses: Vec<Option<Offsets>> = robots.iter().map(of_poses).collect();
    let commands: Vec<Option<Offsets>> = robots.iter().map(of_commands).collect();

    let all = || poses.iter().chain(&commands).flatten();
    let apart = |part: usize| spread(all().filter_map(|offsets| offsets.of_part[part]));
    if (0..N_PARTS).all(|part| apart(part) <= MAX_APART_NS) {
        return Ok(None);
    }
    let middles = || all().map(|offsets| offsets.middle);
    let seconds = |ns: Option<i128>| ns.unwrap_or(0) as f64 / 1e9;
    let (least_s, most_s) = (seconds(middles().min()), seconds(middles().max()));
    for (robot, (poses, commands)) in robots.iter_mut().zip(poses.iter().zip(&commands)) {
        shift(robot, poses.as_ref(), commands.as_ref())?;
    }
    Ok(Some(Finding::Clocks { least_s, most_s }))
}

/// How far the stamps of all poses are ahead of their log times, in nanoseconds; `None` without a pose.
pub fn ahead_ns(robots: &[RecordedRobot]) -> Option<i128> {
    let poses = robots.iter().flat_map(|robot| &robot.poses);
    median(poses.map(|pose| i128::from(pose.stamp_ns) - i128::from(pose.log_ns)).collect())
}

/// By how much another stream is to be set back so that its stamps are of the clock of the poses,
/// in nanoseconds.
///
/// Its `times_ns` are pairs of stamp and log time; by `poses_ns` the stamps of the poses are ahead
/// of their log times.
pub fn behind_poses_ns(times_ns: &[(u64, u64)], poses_ns: i128) -> i128 {
    let ahead = |(stamp_ns, log_ns): &(u64, u64)| i128::from(*stamp_ns) - i128::from(*log_ns);
    let apart_ns = median(times_ns.iter().map(ahead).collect()).map_or(0, |it| it - poses_ns);
    if apart_ns.abs() <= MAX_APART_NS { 0 } else { apart_ns }
}

fn shift(
    robot: &mut RecordedRobot,
    poses: Option<&Offsets>,
    commands: Option<&Offsets>,
) -> Result<(), TrajectoryError> {
    if let Some(offsets) = poses {
        if offsets.spread() > MAX_APART_NS {
            let by_s = offsets.spread() as f64 / 1e9;
            return Err(TrajectoryError::Clocks { robot: robot.name.clone(), by_s });
        }
        for pose in &mut robot.poses {
            pose.stamp_ns = command::set_back(pose.stamp_ns, offsets.middle);
        }
    }
    let Some(offsets) = commands else { return Ok(()) };
    for command in &mut robot.commands {
        // By stamps that do not run evenly nothing is known: its log time counts.
        let is_even = offsets.spread() <= MAX_APART_NS;
        let shifted = |stamp_ns| command::set_back(stamp_ns, offsets.middle);
        command.stamp_ns = command.stamp_ns.filter(|_| is_even).map(shifted);
    }
    Ok(())
}

fn median(mut numbers: Vec<i128>) -> Option<i128> {
    let middle = numbers.len() / 2;
    if numbers.is_empty() {
        return None;
    }
    Some(*numbers.select_nth_unstable(middle).1)
}

fn spread(numbers: impl Iterator<Item = i128>) -> i128 {
    let bounds = numbers.fold(None, |bounds: Option<(i128, i128)>, number| {
        let (least, most) = bounds.unwrap_or((number, number));
        Some((least.min(number), most.max(number)))
    });
    bounds.map_or(0, |(least, most)| most - least)
}

/// Stamps may go back by so much: a tracker's jitter, not another clock. In nanoseconds.
const MAX_BACK_NS: u64 = 200_000_000;

/// More poses of one robot with equal stamps than this share come from two publishers.
const MAX_EQUAL_SHARE: f64 = 0.05;

/// Sorts a robot's poses by stamp and keeps one for each stamp; refuses a clock that went back, and
/// many stamps that are equal.
pub fn sort(robot: &mut RecordedRobot) -> Result<(), TrajectoryError> {
    let mut latest_ns = 0;
    for pose in &robot.poses {
        let back_ns = latest_ns.max(pose.stamp_ns) - pose.stamp_ns;
        if back_ns > MAX_BACK_NS {
            return Err(TrajectoryError::ClockBackwards {
                robot: robot.name.clone(),
                time_s: latest_ns as f64 / 1e9,
                by_s: back_ns as f64 / 1e9,
            });
        }
        latest_ns = latest_ns.max(pose.stamp_ns);
    }
    robot.poses.sort_by_key(|pose| pose.stamp_ns);
    let n_all = robot.poses.len();
    let first_equal = robot
        .poses
        .windows(2)
        .find(|pair| pair[0].stamp_ns == pair[1].stamp_ns)
        .map(|pair| pair[0].stamp_ns);
    robot.poses.dedup_by_key(|pose| pose.stamp_ns);
    let n_equal = n_all - robot.poses.len();
    match first_equal {
        Some(at_ns) if n_equal as f64 > MAX_EQUAL_SHARE * n_all as f64 => {
            Err(TrajectoryError::TooClose {
                robot: robot.name.clone(),
                time_s: at_ns as f64 / 1e9,
                distance_s: 0.0,
                period_s: median_distance_s(robot),
            })
        }
        _ => Ok(()),
    }
}

fn median_distance_s(robot: &RecordedRobot) -> f64 {
    let mut distances_ns: Vec<u64> =
        robot.poses.windows(2).map(|pair| pair[1].stamp_ns - pair[0].stamp_ns).collect();
    distances_ns.sort_unstable();
    distances_ns.get(distances_ns.len() / 2).map_or(0.0, |distance_ns| *distance_ns as f64 / 1e9)
}
