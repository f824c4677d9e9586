//! Poses of all robots at the same times, by interpolation.

use std::f64::consts::{PI, TAU};

use rsrs_core::robot::unicycle::Pose;

use super::collect::RecordedRobot;
use super::finding::Finding;
use super::pose::PoseSample;
use super::rows::Rows;
use super::{TrajectoryError, command};

/// Between poses further apart than this, in nanoseconds, the motion of a robot is unknown: a circle
/// of 0.75 rad/s at 0.15 m/s departs from its chord by 1.4 cm in this time.
const MAX_GAP_NS: u64 = 1_000_000_000;

/// A robot of which more poses are missing than this share is not known well enough.
const MAX_MISSING: f64 = 0.2;

/// Start and end of the run are left out up to one in so many parts of it ...
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
}

/// How completely a robot was seen, in nanoseconds.
#[derive(Clone, Copy)]
struct Seen<'a> {
    robot: &'a str,
    /// Its first and its last pose.
    span_ns: (u64, u64),
    /// The longest time without a pose.
    longest_ns: u64,
    /// The time that lacks poses.
    missing_ns: u64,
}

/// Interpolates the robots' poses to one grid of times.
///
/// # Errors
///
/// [`TrajectoryError::Gap`], [`TrajectoryError::TooManyMissing`] and [`TrajectoryError::Span`].
pub fn resample(
    robots: &[RecordedRobot],
    times: Times,
    findings: &mut Vec<Finding>,
) -> Result<Rows, TrajectoryError> {
    let Times { recorded_ns, period_ns } = times;
    let see = |robot| see(robot, recorded_ns);
    let seen = robots.iter().map(see).collect::<Result<Vec<_>, _>>()?;
    let (start_ns, end_ns) = check(&seen, times, findings)?;
    let times_ns = (start_ns..=end_ns).step_by(to_usize(period_ns));
    let n_samples = to_usize((end_ns - start_ns) / period_ns + 1);
    let mut rows = Rows::new((n_samples, start_ns), (robots.len(), period_ns));
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

/// The longest time between two poses of a robot that may be interpolated, in nanoseconds.
pub fn most_gap_ns(recorded_ns: u64) -> u64 {
    MAX_GAP_NS.max(recorded_ns * 3 / 2)
}

/// The longest time between two poses of a robot of which none is missing between them, in
/// nanoseconds.
pub fn most_step_ns(recorded_ns: u64) -> u64 {
    recorded_ns + recorded_ns / 2
}

/// Looks how completely a robot was seen, and refuses one that was not seen for too long.
fn see(robot: &RecordedRobot, recorded_ns: u64) -> Result<Seen<'_>, TrajectoryError> {
    let steps = || robot.poses.windows(2).map(|pair| pair[1].stamp_ns - pair[0].stamp_ns);
    let is_gap =
        |pair: &&[PoseSample]| pair[1].stamp_ns - pair[0].stamp_ns > most_gap_ns(recorded_ns);
    if let Some(pair) = robot.poses.windows(2).find(is_gap) {
        return Err(TrajectoryError::Gap {
            robot: robot.name.clone(),
            time_s: seconds(pair[1].stamp_ns),
            distance_s: seconds(pair[1].stamp_ns - pair[0].stamp_ns),
            period_s: seconds(recorded_ns),
        });
    }
    let lacks = |step_ns: &u64| *step_ns > most_step_ns(recorded_ns);
    Ok(Seen {
        robot: &robot.name,
        span_ns: (robot.poses[0].stamp_ns, robot.poses[robot.poses.len() - 1].stamp_ns),
        longest_ns: steps().max().unwrap_or(0),
        missing_ns: steps().filter(lacks).map(|step_ns| step_ns - recorded_ns).sum(),
    })
}

/// Whether robots were seen well enough to be interpolated, and the finding about it.
///
/// # Returns
///
/// From when to when all of them were seen, in nanoseconds.
///
/// # Errors
///
/// [`TrajectoryError::TooManyMissing`] and [`TrajectoryError::Span`].
fn check(
    seen: &[Seen],
    times: Times,
    findings: &mut Vec<Finding>,
) -> Result<(u64, u64), TrajectoryError> {
    for robot in seen {
        findings.extend(missing(robot)?);
    }
    let span_ns = common_span(seen, times, findings)?;
    findings.push(Finding::Resampled {
        recorded_s: seconds(times.recorded_ns),
        period_s: seconds(times.period_ns),
    });
    Ok(span_ns)
}

/// Refuses a robot that was not seen too often.
fn missing(seen: &Seen) -> Result<Option<Finding>, TrajectoryError> {
    let whole_ns = seen.span_ns.1 - seen.span_ns.0;
    let share = seen.missing_ns as f64 / whole_ns.max(1) as f64;
    let (robot, longest_s) = (seen.robot.to_owned(), seconds(seen.longest_ns));
    if share > MAX_MISSING {
        let limit = MAX_MISSING;
        return Err(TrajectoryError::TooManyMissing { robot, share, limit, longest_s });
    }
    Ok((seen.missing_ns > 0).then_some(Finding::Missing { robot, share, longest_s }))
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
        if late_ns > most_ns || early_ns > most_ns || start_ns >= end_ns {
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
