//! Poses of all robots at the same times, by interpolation.

use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::{Pose, within_half_a_turn};

use super::collect::RecordedRobot;
use super::finding::Finding;
use super::needed::Needed;
use super::pose::PoseSample;
use super::{TrajectoryError, command};

/// A gap of more than this is named, in nanoseconds.
const NAMED_GAP_NS: u64 = 1_000_000_000;

/// A robot of which more poses are missing than this share, where it must be known, is not known well
/// enough.
const MAX_MISSING: f64 = 0.2;

/// Start and end of the run are left out up to one in so many parts of it ... (the start as far as the
/// time that is judged)
const MAX_TRIMMED: u64 = 10;

/// ... and up to this, in nanoseconds.
const MAX_TRIMMED_NS: u64 = 10_000_000_000;

/// What a run is interpolated from and to.
#[derive(Clone, Copy)]
pub struct Times {
    /// The median distance of poses, in nanoseconds.
    pub recorded_ns: u64,
    /// The period of the trajectory, in nanoseconds.
    pub period_ns: u64,
    /// What of the run must be known.
    pub needed: Needed,
}

/// How completely a robot was seen, in nanoseconds.
struct Seen<'a> {
    robot: &'a str,
    /// Its first and its last pose.
    span_ns: (u64, u64),
    /// The longest time without a pose.
    longest_ns: u64,
    /// The times between two poses between which some are missing.
    lacks_ns: Vec<(u64, u64)>,
}

impl Seen<'_> {
    /// The time that lacks poses within a span, in nanoseconds.
    fn missing_ns(&self, (start_ns, end_ns): (u64, u64), recorded_ns: u64) -> u64 {
        let within = |(from_ns, to_ns): &(u64, u64)| {
            let within_ns = (*to_ns).min(end_ns).saturating_sub((*from_ns).max(start_ns));
            within_ns.saturating_sub(recorded_ns)
        };
        self.lacks_ns.iter().map(within).sum()
    }
}

/// Interpolates the robots' poses to one grid of times.
pub fn resample(
    robots: &[RecordedRobot],
    times: Times,
    findings: &mut Vec<Finding>,
) -> Result<Rows, TrajectoryError> {
    let Times { recorded_ns, period_ns, .. } = times;
    let seen: Vec<Seen> = robots.iter().map(|robot| see(robot, recorded_ns)).collect();
    let (start_ns, end_ns) = check(&seen, times, findings)?;
    let times_ns = (start_ns..=end_ns).step_by(to_usize(period_ns));
    let mut rows = Rows::new(times_ns.clone().collect(), (robots.len(), period_ns));
    for (number, robot) in robots.iter().enumerate() {
        let poses: Vec<PoseSample> =
            times_ns.clone().map(|time_ns| pose_at(&robot.poses, time_ns)).collect();
        rows.fill(number, &poses, &command::answers(&poses, &robot.commands, period_ns));
    }
    Ok(rows)
}

/// A time or a count that is in memory many times over.
fn to_usize(number: u64) -> usize {
    usize::try_from(number).expect("a process has addresses of 64 bits")
}

/// The longest time between two poses of a robot of which none is missing between them, in
/// nanoseconds.
pub fn most_step_ns(recorded_ns: u64) -> u64 {
    recorded_ns + recorded_ns / 2
}

/// Looks how completely a robot was seen.
fn see(robot: &RecordedRobot, recorded_ns: u64) -> Seen<'_> {
    let steps = || robot.poses.windows(2).map(|pair| (pair[0].stamp_ns, pair[1].stamp_ns));
    let lacks = |(from_ns, to_ns): &(u64, u64)| to_ns - from_ns > most_step_ns(recorded_ns);
    Seen {
        robot: &robot.name,
        span_ns: (robot.poses[0].stamp_ns, robot.poses[robot.poses.len() - 1].stamp_ns),
        longest_ns: steps().map(|(from_ns, to_ns)| to_ns - from_ns).max().unwrap_or(0),
        lacks_ns: steps().filter(lacks).collect(),
    }
}

/// Whether robots were seen well enough to be interpolated, the findings about it, and from when to
/// when all of them were seen, in nanoseconds.
fn check(
    seen: &[Seen],
    times: Times,
    findings: &mut Vec<Finding>,
) -> Result<(u64, u64), TrajectoryError> {
    let (start_ns, end_ns) = common_span(seen, times, findings)?;
    let needed_ns = (end_ns.saturating_sub(times.needed.window_ns()).max(start_ns), end_ns);
    for robot in seen {
        findings.extend(gaps(robot, (start_ns, needed_ns), times)?);
        findings.extend(missing(robot, needed_ns, times)?);
    }
    findings.push(Finding::Resampled {
        recorded_s: seconds(times.recorded_ns),
        period_s: seconds(times.period_ns),
    });
    Ok((start_ns, end_ns))
}

/// Refuses a robot that was not seen too often where it must be known.
fn missing(
    seen: &Seen,
    needed_ns: (u64, u64),
    times: Times,
) -> Result<Option<Finding>, TrajectoryError> {
    let share_of = |(start_ns, end_ns): (u64, u64)| {
        let missing_ns = seen.missing_ns((start_ns, end_ns), times.recorded_ns);
        missing_ns as f64 / (end_ns - start_ns).max(1) as f64
    };
    let (robot, longest_s) = (seen.robot.to_owned(), seconds(seen.longest_ns));
    let share = share_of(needed_ns);
    if share > MAX_MISSING {
        let (limit, needed) = (MAX_MISSING, times.needed);
        return Err(TrajectoryError::TooManyMissing { robot, share, limit, longest_s, needed });
    }
    let share = share_of(seen.span_ns);
    Ok((share > 0.0).then_some(Finding::Missing { robot, share, longest_s }))
}

/// Names every long time without a pose of a robot from `start_ns` on, and refuses one within
/// `needed_ns`, where it must be known.
fn gaps(
    seen: &Seen,
    (start_ns, needed_ns): (u64, (u64, u64)),
    times: Times,
) -> Result<Vec<Finding>, TrajectoryError> {
    let mut findings = Vec::new();
    let most_ns = times.needed.most_gap_ns(times.recorded_ns);
    let least_ns = NAMED_GAP_NS.max(times.recorded_ns * 3 / 2);
    for (from_ns, to_ns) in &seen.lacks_ns {
        let is_within = *to_ns > start_ns && *from_ns < needed_ns.1;
        if !is_within || to_ns - from_ns <= least_ns {
            continue;
        }
        let is_judged = *to_ns > needed_ns.0;
        let robot = seen.robot.to_owned();
        let from_s = seconds(from_ns.saturating_sub(start_ns));
        let to_s = seconds(to_ns - start_ns);
        if is_judged && to_ns - from_ns > most_ns {
            let (limit_s, needed) = (seconds(most_ns), times.needed);
            return Err(TrajectoryError::Gap { robot, from_s, to_s, limit_s, needed });
        }
        findings.push(Finding::Gap { robot, from_s, to_s, is_judged });
    }
    Ok(findings)
}

/// The time through which all robots have poses.
fn common_span(
    seen: &[Seen],
    times: Times,
    findings: &mut Vec<Finding>,
) -> Result<(u64, u64), TrajectoryError> {
    let firsts = || seen.iter().map(|robot| robot.span_ns.0);
    let lasts = || seen.iter().map(|robot| robot.span_ns.1);
    let (earliest_ns, latest_ns) = (firsts().min().unwrap_or(0), lasts().max().unwrap_or(0));
    let (start_ns, end_ns) = (firsts().max().unwrap_or(0), lasts().min().unwrap_or(0));
    let usual_ns = times.recorded_ns.max(times.period_ns) * 3 / 2;
    let all_ns = latest_ns - earliest_ns;
    let most_ns = (all_ns / MAX_TRIMMED).min(MAX_TRIMMED_NS).max(usual_ns);
    for Seen { robot, span_ns: (first_ns, last_ns), .. } in seen {
        let late_ns = first_ns - earliest_ns;
        let early_ns = latest_ns - last_ns;
        let robot = || (*robot).to_owned();
        // Whoever came late was there for all that is judged.
        let is_late =
            late_ns > most_ns && end_ns.saturating_sub(start_ns) < times.needed.window_ns();
        if is_late || early_ns > most_ns || start_ns >= end_ns {
            return Err(TrajectoryError::Span {
                robot: robot(),
                first_s: seconds(*first_ns),
                last_s: seconds(*last_ns),
                expected_first_s: seconds(earliest_ns),
                expected_last_s: seconds(latest_ns),
            });
        }
        if late_ns > usual_ns {
            findings.push(Finding::LateStart { robot: robot(), by_s: seconds(late_ns) });
        }
        if early_ns > usual_ns {
            findings.push(Finding::EarlyEnd { robot: robot(), by_s: seconds(early_ns) });
        }
    }
    Ok((start_ns, end_ns))
}

/// The pose at a time between a robot's first and last one.
fn pose_at(poses: &[PoseSample], time_ns: u64) -> PoseSample {
    let after = poses.partition_point(|pose| pose.stamp_ns < time_ns).min(poses.len() - 1);
    let (before, next) = (poses[after.saturating_sub(1)], poses[after]);
    let step_ns = next.stamp_ns - before.stamp_ns;
    if step_ns == 0 || next.stamp_ns <= time_ns {
        return PoseSample { stamp_ns: time_ns, ..next };
    }
    let passed_ns = time_ns - before.stamp_ns;
    let share = passed_ns as f64 / step_ns as f64;
    let log_step_ns = u128::from(next.log_ns.saturating_sub(before.log_ns));
    let log_passed_ns = log_step_ns * u128::from(passed_ns) / u128::from(step_ns);
    let pose = before.pose.between(next.pose, share);
    PoseSample {
        stamp_ns: time_ns,
        log_ns: before.log_ns + u64::try_from(log_passed_ns).expect("it is a part of 64 bits"),
        pose: Pose { heading_rad: within_half_a_turn(pose.heading_rad), ..pose },
    }
}

fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 / 1e9
}

/// A trajectory and when its samples are.
pub struct Rows {
    pub trajectory: Trajectory,
    /// Time of each sample, in nanoseconds.
    pub times_ns: Vec<u64>,
}

impl Rows {
    /// A trajectory with samples at these times, in which no robot has done anything yet.
    pub fn new(times_ns: Vec<u64>, (n_robots, period_ns): (usize, u64)) -> Self {
        let mut trajectory = Trajectory::new(period_ns as f64 / 1e9, n_robots);
        let n_cells = times_ns.len() * n_robots;
        trajectory.poses = vec![Pose { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 }; n_cells];
        trajectory.commands = vec![Command::STOP; n_cells];
        Self { trajectory, times_ns }
    }

    /// Puts in what one robot did, in each of the samples.
    pub fn fill(&mut self, robot: usize, poses: &[PoseSample], commands: &[Command]) {
        let n_robots = self.trajectory.n_robots;
        for (sample, (pose, command)) in poses.iter().zip(commands).enumerate() {
            self.trajectory.poses[sample * n_robots + robot] = pose.pose;
            self.trajectory.commands[sample * n_robots + robot] = *command;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn sample(stamp_ns: u64, x_m: f64, heading_rad: f64) -> PoseSample {
        PoseSample { stamp_ns, log_ns: stamp_ns + 7, pose: Pose { x_m, y_m: 0.0, heading_rad } }
    }

    #[test]
    fn between_two_poses_the_robot_is_between_them_and_turns_the_short_way() {
        let poses = [sample(0, 0.0, 3.0), sample(100, 1.0, -3.0), sample(200, 1.0, -3.0)];

        let middle = pose_at(&poses, 50);

        assert!((middle.pose.x_m - 0.5).abs() < 1e-12);
        assert!((middle.pose.heading_rad.abs() - PI).abs() < 1e-9, "{middle:?}");
        assert_eq!(middle.log_ns, 57);
        assert_eq!(pose_at(&poses, 100).pose, poses[1].pose);
        assert_eq!(pose_at(&poses, 0).pose, poses[0].pose);
        assert_eq!(pose_at(&poses, 200).pose, poses[2].pose);
    }
}
