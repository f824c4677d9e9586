//! Poses of all robots at the same times, by interpolation.

use std::f64::consts::{PI, TAU};

use rsrs_core::unicycle::Pose;

use super::collect::RecordedRobot;
use super::finding::Finding;
use super::pose::PoseSample;
use super::rows::Rows;
use super::{Keep, TrajectoryError, command};

/// Between poses further apart than this, in nanoseconds, nobody knows what a robot did: a circle
/// of 0.75 rad/s at 0.15 m/s departs from its chord by 1.4 cm in this time.
const MAX_GAP_NS: u64 = 1_000_000_000;

/// A robot of which more poses are missing than this share is not known well enough.
const MAX_MISSING: f64 = 0.2;

/// Start and end of the run are left out up to one in so many parts of it ...
const MAX_TRIMMED: u64 = 10;

/// ... and up to this, in nanoseconds.
const MAX_TRIMMED_NS: u64 = 10_000_000_000;

/// Robots of a run and the time between the samples of its trajectory.
pub struct Run<'a> {
    /// Their poses while the swarm was running, two at least.
    pub robots: &'a [RecordedRobot],
    /// The median distance of poses, in nanoseconds.
    pub recorded_ns: u64,
    /// The period of the trajectory, in nanoseconds.
    pub period_ns: u64,
    /// Whether the bag ends before the run did.
    pub breaks_off: bool,
}

/// Interpolates the robots' poses to one grid of times.
///
/// # Errors
///
/// [`TrajectoryError::Gap`], [`TrajectoryError::TooManyMissing`] and [`TrajectoryError::Span`].
pub fn resample(
    run: &Run,
    keep: Keep,
    findings: &mut Vec<Finding>,
) -> Result<Rows, TrajectoryError> {
    for robot in run.robots {
        findings.extend(check_gaps(robot, run.recorded_ns)?);
    }
    let (start_ns, end_ns) = common_span(run, findings)?;
    findings.push(Finding::Resampled {
        recorded_s: seconds(run.recorded_ns),
        period_s: seconds(run.period_ns),
    });
    let n_all = (end_ns - start_ns) / run.period_ns + 1;
    let mut rows = Rows::new((n_all, start_ns), (run.robots.len(), run.period_ns), keep);
    let times_ns: Vec<u64> =
        rows.samples.iter().map(|sample| start_ns + sample * run.period_ns).collect();
    for (number, robot) in run.robots.iter().enumerate() {
        let poses: Vec<PoseSample> =
            times_ns.iter().map(|time_ns| pose_at(&robot.poses, *time_ns)).collect();
        rows.fill(number, &poses, &command::answers(&poses, &robot.commands, run.period_ns));
    }
    Ok(rows)
}

/// Refuses a robot that nobody saw for too long, or too often.
fn check_gaps(robot: &RecordedRobot, recorded_ns: u64) -> Result<Option<Finding>, TrajectoryError> {
    let steps = || robot.poses.windows(2).map(|pair| pair[1].stamp_ns - pair[0].stamp_ns);
    let most_ns = MAX_GAP_NS.max(recorded_ns * 3 / 2);
    if let Some(pair) =
        robot.poses.windows(2).find(|pair| pair[1].stamp_ns - pair[0].stamp_ns > most_ns)
    {
        return Err(TrajectoryError::Gap {
            robot: robot.name.clone(),
            time_s: seconds(pair[1].stamp_ns),
            distance_s: seconds(pair[1].stamp_ns - pair[0].stamp_ns),
            period_s: seconds(recorded_ns),
        });
    }
    let is_gap = |step_ns: &u64| *step_ns > recorded_ns + recorded_ns / 2;
    let missing_ns: u64 = steps().filter(is_gap).map(|step_ns| step_ns - recorded_ns).sum();
    let whole_ns: u64 = steps().sum();
    let share = missing_ns as f64 / whole_ns.max(1) as f64;
    let longest_s = seconds(steps().max().unwrap_or(0));
    if share > MAX_MISSING {
        let (robot, limit) = (robot.name.clone(), MAX_MISSING);
        return Err(TrajectoryError::TooManyMissing { robot, share, limit, longest_s });
    }
    let finding = || Finding::Missing { robot: robot.name.clone(), share, longest_s };
    Ok((missing_ns > 0).then(finding))
}

/// The time through which all robots have poses.
fn common_span(run: &Run, findings: &mut Vec<Finding>) -> Result<(u64, u64), TrajectoryError> {
    let spans = || run.robots.iter().map(|robot| (robot, first_ns(robot), last_ns(robot)));
    let earliest_ns = spans().map(|span| span.1).min().unwrap_or(0);
    let latest_ns = spans().map(|span| span.2).max().unwrap_or(0);
    let start_ns = spans().map(|span| span.1).max().unwrap_or(0);
    let end_ns = spans().map(|span| span.2).min().unwrap_or(0);
    let usual_ns = run.recorded_ns.max(run.period_ns) * 3 / 2;
    let all_ns = latest_ns - earliest_ns;
    let most_ns = (all_ns / MAX_TRIMMED).min(MAX_TRIMMED_NS).max(usual_ns);
    for (robot, first_ns, last_ns) in spans() {
        let late_ns = first_ns - earliest_ns;
        let early_ns = if run.breaks_off { 0 } else { latest_ns - last_ns };
        if late_ns > most_ns || early_ns > most_ns || start_ns >= end_ns {
            return Err(TrajectoryError::Span {
                robot: robot.name.clone(),
                first_s: seconds(first_ns),
                last_s: seconds(last_ns),
                expected_first_s: seconds(earliest_ns),
                expected_last_s: seconds(latest_ns),
            });
        }
        let robot = || robot.name.clone();
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
    let between = |from: f64, to: f64| from + (to - from) * share;
    let log_step_ns = u128::from(next.log_ns.saturating_sub(before.log_ns));
    let log_passed_ns = log_step_ns * u128::from(passed_ns) / u128::from(step_ns);
    let turn_rad = wrap(next.pose.heading_rad - before.pose.heading_rad);
    PoseSample {
        stamp_ns: time_ns,
        log_ns: before.log_ns + u64::try_from(log_passed_ns).expect("it is a part of 64 bits"),
        pose: Pose {
            x_m: between(before.pose.x_m, next.pose.x_m),
            y_m: between(before.pose.y_m, next.pose.y_m),
            heading_rad: wrap(before.pose.heading_rad + turn_rad * share),
        },
    }
}

/// The same angle within half a turn of zero.
fn wrap(angle_rad: f64) -> f64 {
    let wrapped = angle_rad - TAU * libm::floor((angle_rad + PI) / TAU);
    if wrapped >= PI { wrapped - TAU } else { wrapped }
}

/// Their number was checked.
fn first_ns(robot: &RecordedRobot) -> u64 {
    robot.poses[0].stamp_ns
}

/// Their number was checked.
fn last_ns(robot: &RecordedRobot) -> u64 {
    robot.poses[robot.poses.len() - 1].stamp_ns
}

fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 / 1e9
}

#[cfg(test)]
mod tests {
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

    #[test]
    fn angles_are_wrapped_to_half_a_turn() {
        for (angle_rad, expected_rad) in [(0.0, 0.0), (4.0, 4.0 - TAU), (-4.0, TAU - 4.0)] {
            assert!((wrap(angle_rad) - expected_rad).abs() < 1e-12, "{angle_rad}");
        }
    }
}
