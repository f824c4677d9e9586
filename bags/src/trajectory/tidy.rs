//! Poses of one robot in the order of their stamps.

use super::TrajectoryError;
use super::collect::RecordedRobot;

/// Stamps may go back by so much: a tracker's jitter, not another clock. In nanoseconds.
const MAX_BACK_NS: u64 = 200_000_000;

/// More poses of one robot with equal stamps than this share come from two publishers.
const MAX_EQUAL_SHARE: f64 = 0.05;

/// Sorts a robot's poses by stamp and keeps one for each stamp; refuses a clock that went back, and
/// many stamps that are equal.
pub fn tidy(robot: &mut RecordedRobot) -> Result<(), TrajectoryError> {
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
                period_s: median_s(robot),
            })
        }
        _ => Ok(()),
    }
}

fn median_s(robot: &RecordedRobot) -> f64 {
    let mut distances_ns: Vec<u64> =
        robot.poses.windows(2).map(|pair| pair[1].stamp_ns - pair[0].stamp_ns).collect();
    distances_ns.sort_unstable();
    distances_ns.get(distances_ns.len() / 2).map_or(0.0, |distance_ns| *distance_ns as f64 / 1e9)
}
