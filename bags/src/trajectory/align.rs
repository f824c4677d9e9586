//! Rows out of robots: the same instant of all robots in one sample.

use rsrs_core::controller::Command;
use rsrs_core::trajectory::Trajectory;

use super::TrajectoryError;
use super::collect::{Collected, RecordedRobot};
use super::command;
use super::pose::PoseSample;
use super::window::RunningWindow;

/// A robot whose share of the window was cut out.
struct Row<'a> {
    robot: &'a RecordedRobot,
    poses: Vec<PoseSample>,
    commands: Vec<Command>,
}

impl Row<'_> {
    fn check_length(&self) -> Result<(), TrajectoryError> {
        if self.poses.len() < 2 {
            let (robot, n_samples) = (self.robot.name.clone(), self.poses.len());
            return Err(TrajectoryError::TooFewPoses { robot, n_samples });
        }
        Ok(())
    }

    /// Time of its first pose, in nanoseconds; its length was checked.
    fn first_ns(&self) -> u64 {
        self.poses[0].stamp_ns
    }

    /// Time of its last pose, in nanoseconds; its length was checked.
    fn last_ns(&self) -> u64 {
        self.poses[self.poses.len() - 1].stamp_ns
    }
}

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

/// Puts the robots' samples within the window side by side.
///
/// The edge of the window may fall between the robots of one sample, so the first and the last
/// sample are dropped where a robot lacks them; a bag that breaks off may lack more at its end.
///
/// # Returns
///
/// The trajectory and the time of its first sample, in nanoseconds.
///
/// # Errors
///
/// [`TrajectoryError::TooFewPoses`], [`TrajectoryError::TooClose`], [`TrajectoryError::Gap`],
/// [`TrajectoryError::Span`] and [`TrajectoryError::OutOfStep`].
pub fn align(
    collected: &Collected,
    window: &RunningWindow,
    period_ns: u64,
) -> Result<(Trajectory, u64), TrajectoryError> {
    let mut rows: Vec<Row> = collected
        .robots
        .iter()
        .map(|robot| {
            let commands = command::answers(&robot.poses, &robot.commands, period_ns);
            let inside = robot.poses.iter().zip(commands);
            let inside = inside.filter(|(pose, _)| window.contains(pose.log_ns));
            let (poses, commands) = inside.unzip();
            Row { robot, poses, commands }
        })
        .collect();
    for row in &rows {
        check_steps(row, period_ns)?;
    }
    refuse_late_and_early(&rows, period_ns, collected)?;
    trim_to_common_span(&mut rows, period_ns)?;
    check_side_by_side(&rows, period_ns)?;

    let n_samples = rows[0].poses.len();
    let mut trajectory = Trajectory::new(seconds(period_ns), rows.len());
    for sample in 0..n_samples {
        for row in &rows {
            trajectory.poses.push(row.poses[sample].pose);
            trajectory.commands.push(row.commands[sample]);
        }
    }
    Ok((trajectory, rows[0].poses[0].stamp_ns))
}

/// Refuses a robot with gaps, or with two poses in one period.
fn check_steps(row: &Row, period_ns: u64) -> Result<(), TrajectoryError> {
    row.check_length()?;
    let period_s = seconds(period_ns);
    for pair in row.poses.windows(2) {
        let distance_s = seconds(pair[1].stamp_ns) - seconds(pair[0].stamp_ns);
        let distance_ns = pair[1].stamp_ns.saturating_sub(pair[0].stamp_ns);
        if (period_ns / 2..=period_ns + period_ns / 2).contains(&distance_ns) {
            continue;
        }
        let (robot, time_s) = (row.robot.name.clone(), seconds(pair[1].stamp_ns));
        if distance_ns < period_ns / 2 {
            return Err(TrajectoryError::TooClose { robot, time_s, distance_s, period_s });
        }
        return Err(TrajectoryError::Gap { robot, time_s, distance_s, period_s });
    }
    Ok(())
}

/// Refuses a robot that came or left more than one sample apart from the others.
fn refuse_late_and_early(
    rows: &[Row],
    period_ns: u64,
    collected: &Collected,
) -> Result<(), TrajectoryError> {
    let earliest_ns = rows.iter().map(Row::first_ns).min().unwrap_or(0);
    let latest_ns = rows.iter().map(Row::last_ns).max().unwrap_or(0);
    let most_ns = period_ns + period_ns / 2;
    for row in rows {
        let late = row.first_ns() - earliest_ns > most_ns;
        let early = latest_ns - row.last_ns() > most_ns && !collected.breaks_off;
        if late || early {
            return Err(TrajectoryError::Span {
                robot: row.robot.name.clone(),
                first_s: seconds(row.first_ns()),
                last_s: seconds(row.last_ns()),
                expected_first_s: seconds(earliest_ns),
                expected_last_s: seconds(latest_ns),
            });
        }
    }
    Ok(())
}

/// Drops what some robots have before the first or after the last pose of another.
fn trim_to_common_span(rows: &mut [Row], period_ns: u64) -> Result<(), TrajectoryError> {
    let half_ns = period_ns / 2;
    let start_ns = rows.iter().map(Row::first_ns).max().unwrap_or(0);
    let end_ns = rows.iter().map(Row::last_ns).min().unwrap_or(0);
    for row in rows {
        let common = |pose: &PoseSample| {
            pose.stamp_ns + half_ns >= start_ns && pose.stamp_ns <= end_ns + half_ns
        };
        let from = row.poses.iter().position(common).unwrap_or(row.poses.len());
        let n_common = row.poses[from..].iter().take_while(|pose| common(pose)).count();
        row.poses = row.poses[from..from + n_common].to_vec();
        row.commands = row.commands[from..from + n_common].to_vec();
        row.check_length()?;
    }
    Ok(())
}

/// Refuses robots whose nth poses are not of one time.
fn check_side_by_side(rows: &[Row], period_ns: u64) -> Result<(), TrajectoryError> {
    let reference = &rows[0];
    for row in &rows[1..] {
        for (pose, expected) in row.poses.iter().zip(&reference.poses) {
            if pose.stamp_ns.abs_diff(expected.stamp_ns) > period_ns / 2 {
                return Err(TrajectoryError::OutOfStep {
                    robot: row.robot.name.clone(),
                    time_s: seconds(pose.stamp_ns),
                    reference: reference.robot.name.clone(),
                    expected_s: seconds(expected.stamp_ns),
                });
            }
        }
        if row.poses.len() != reference.poses.len() {
            let n_both = row.poses.len().min(reference.poses.len());
            let (longer, shorter) =
                if row.poses.len() > n_both { (row, reference) } else { (reference, row) };
            return Err(TrajectoryError::OutOfStep {
                robot: longer.robot.name.clone(),
                time_s: seconds(longer.poses[n_both].stamp_ns),
                reference: shorter.robot.name.clone(),
                expected_s: seconds(shorter.poses[n_both - 1].stamp_ns),
            });
        }
    }
    Ok(())
}

fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 / 1e9
}
