//! Rows out of robots that were recorded in step: the same instant of all robots in one sample.

use rsrs_core::controller::Command;
use rsrs_core::trajectory::Trajectory;

use super::TrajectoryError;
use super::collect::{Collected, RecordedRobot};
use super::command;
use super::pose::PoseSample;

/// Fewer commands than this do not show how regular they are.
const MIN_COMMANDS: usize = 10;

/// Poses and commands are of one rate if their periods differ by less than one in so many.
const SAME_RATE: u64 = 4;

/// A robot with the commands that answered its poses.
struct Row {
    poses: Vec<PoseSample>,
    commands: Vec<Command>,
}

impl Row {
    /// Time of its first pose, in nanoseconds.
    fn first_ns(&self) -> u64 {
        self.poses[0].stamp_ns
    }

    /// Time of its last pose, in nanoseconds.
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
    if is_regular && middle_ns > recorded_ns + recorded_ns / SAME_RATE {
        middle_ns
    } else {
        recorded_ns
    }
}

/// Puts the robots' samples side by side.
///
/// The edge of the window may fall between the robots of one sample, so the first and the last
/// sample are dropped where a robot lacks them; a bag that breaks off may lack more at its end.
///
/// # Returns
///
/// The trajectory and the time of its first sample, in nanoseconds; `None` if the robots were not
/// recorded in step.
pub fn align(collected: &Collected, period_ns: u64) -> Option<(Trajectory, u64)> {
    let mut rows: Vec<Row> = collected
        .robots
        .iter()
        .map(|robot| Row {
            poses: robot.poses.clone(),
            commands: command::answers(&robot.poses, &robot.commands, period_ns),
        })
        .collect();
    let is_regular = rows.iter().all(|row| has_no_gaps(row, period_ns));
    if !is_regular || comes_or_leaves(&rows, period_ns, collected) {
        return None;
    }
    trim_to_common_span(&mut rows, period_ns)?;
    if !are_side_by_side(&rows, period_ns) {
        return None;
    }

    let n_samples = rows[0].poses.len();
    let mut trajectory = Trajectory::new(period_ns as f64 / 1e9, rows.len());
    for sample in 0..n_samples {
        for row in &rows {
            trajectory.poses.push(row.poses[sample].pose);
            trajectory.commands.push(row.commands[sample]);
        }
    }
    Some((trajectory, rows[0].first_ns()))
}

/// Whether there is one pose in every period.
fn has_no_gaps(row: &Row, period_ns: u64) -> bool {
    row.poses.windows(2).all(|pair| {
        let distance_ns = pair[1].stamp_ns.saturating_sub(pair[0].stamp_ns);
        (period_ns / 2..=period_ns + period_ns / 2).contains(&distance_ns)
    })
}

/// Whether a robot came or left more than one sample apart from the others.
fn comes_or_leaves(rows: &[Row], period_ns: u64, collected: &Collected) -> bool {
    let earliest_ns = rows.iter().map(Row::first_ns).min().unwrap_or(0);
    let latest_ns = rows.iter().map(Row::last_ns).max().unwrap_or(0);
    let most_ns = period_ns + period_ns / 2;
    rows.iter().any(|row| {
        let late = row.first_ns() - earliest_ns > most_ns;
        late || (latest_ns - row.last_ns() > most_ns && !collected.breaks_off)
    })
}

/// Drops what some robots have before the first or after the last pose of another; `None` if less
/// than two poses are left of one.
fn trim_to_common_span(rows: &mut [Row], period_ns: u64) -> Option<()> {
    let half_ns = period_ns / 2;
    let start_ns = rows.iter().map(Row::first_ns).max().unwrap_or(0);
    let end_ns = rows.iter().map(Row::last_ns).min().unwrap_or(0);
    for row in rows {
        let common = |pose: &PoseSample| {
            pose.stamp_ns + half_ns >= start_ns && pose.stamp_ns <= end_ns + half_ns
        };
        let from = row.poses.iter().position(common).unwrap_or(row.poses.len());
        let n_common = row.poses[from..].iter().take_while(|pose| common(pose)).count();
        if n_common < 2 {
            return None;
        }
        row.poses = row.poses[from..from + n_common].to_vec();
        row.commands = row.commands[from..from + n_common].to_vec();
    }
    Some(())
}

/// Whether the robots' nth poses are of one time.
fn are_side_by_side(rows: &[Row], period_ns: u64) -> bool {
    let reference = &rows[0];
    rows[1..].iter().all(|row| {
        let mut pairs = row.poses.iter().zip(&reference.poses);
        let near = |(one, other): (&PoseSample, &PoseSample)| {
            one.stamp_ns.abs_diff(other.stamp_ns) <= period_ns / 2
        };
        row.poses.len() == reference.poses.len() && pairs.all(near)
    })
}

fn seconds(time_ns: u64) -> f64 {
    time_ns as f64 / 1e9
}
