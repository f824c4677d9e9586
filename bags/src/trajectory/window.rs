//! When the swarm was running.

use super::TrajectoryError;
use super::collect::{Collected, LeaseSample, RecordedRobot};
use super::needed::Needed;

/// By what the running time was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WindowSource {
    /// The recorded run lease was RUNNING.
    Lease,
    /// There is no lease in the bag: some robot was commanded to move.
    Commands,
}

/// A span of log time, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunningWindow {
    /// Its start, in nanoseconds.
    pub start_ns: u64,
    /// Its end, in nanoseconds.
    pub end_ns: u64,
    /// By what it was found.
    pub source: WindowSource,
}

impl RunningWindow {
    /// Whether something that was recorded then belongs to the run.
    pub fn contains(&self, log_ns: u64) -> bool {
        (self.start_ns..=self.end_ns).contains(&log_ns)
    }
}

/// Finds the running time.
///
/// With a lease it is the longest time through which the lease was RUNNING: a run that was
/// interrupted has several, and its phases are not one phenomenon. Without one it goes from the
/// first to the last command that moves a robot, and half a period around them, because a command
/// comes after the pose that it answers.
pub fn running_window(
    collected: &Collected,
    period_ns: u64,
) -> Result<RunningWindow, TrajectoryError> {
    if let Some(lease) = &collected.lease {
        let (start_ns, end_ns) = longest_running(lease).ok_or(TrajectoryError::NeverRunning)?;
        let end_ns = end_ns.min(collected.end_ns);
        return Ok(RunningWindow { start_ns, end_ns, source: WindowSource::Lease });
    }
    let moving = || {
        let commands = collected.robots.iter().flat_map(|robot| &robot.commands);
        commands.filter(|command| command.moves()).map(|command| command.log_ns)
    };
    let (first_ns, last_ns) =
        moving().min().zip(moving().max()).ok_or(TrajectoryError::NeverCommanded)?;
    Ok(RunningWindow {
        start_ns: first_ns.saturating_sub(period_ns / 2),
        end_ns: last_ns.saturating_add(period_ns / 2),
        source: WindowSource::Commands,
    })
}

/// Keeps the poses of the running time, given the median distance of poses in nanoseconds, and what
/// must be known.
///
/// # Errors
///
/// [`TrajectoryError::TooFewPoses`] if a robot has less than two, and [`TrajectoryError::EndsEarly`] if
/// its poses end before the running time does: what it did then is not known, and the judge looks at
/// the end.
pub fn cut(
    collected: &mut Collected,
    window: &RunningWindow,
    (recorded_ns, needed): (u64, Needed),
) -> Result<(), TrajectoryError> {
    for robot in &mut collected.robots {
        robot.poses.retain(|pose| window.contains(pose.log_ns));
        if robot.poses.len() < 2 {
            let (robot, n_samples) = (robot.name.clone(), robot.poses.len());
            return Err(TrajectoryError::TooFewPoses { robot, n_samples });
        }
    }
    let since_start_s = |log_ns: u64| log_ns.saturating_sub(window.start_ns) as f64 / 1e9;
    let last_ns = |robot: &RecordedRobot| robot.poses[robot.poses.len() - 1].log_ns;
    let first_to_end = collected.robots.iter().min_by_key(|robot| last_ns(robot));
    if let Some(robot) = first_to_end {
        let last_ns = last_ns(robot);
        if window.end_ns.saturating_sub(last_ns) > needed.most_gap_ns(recorded_ns) {
            return Err(TrajectoryError::EndsEarly {
                robot: robot.name.clone(),
                last_s: since_start_s(last_ns),
                end_s: since_start_s(window.end_ns),
            });
        }
    }
    Ok(())
}

/// The longest span that starts with RUNNING and ends with something else, or with the bag.
fn longest_running(lease: &[LeaseSample]) -> Option<(u64, u64)> {
    let mut spans: Vec<(u64, u64)> = Vec::new();
    let mut open: Option<u64> = None;
    for sample in lease {
        match (open, sample.running) {
            (None, true) => open = Some(sample.log_ns),
            (Some(start_ns), false) => {
                spans.push((start_ns, sample.log_ns));
                open = None;
            }
            (None, false) | (Some(_), true) => {}
        }
    }
    spans.extend(open.map(|start_ns| (start_ns, u64::MAX)));
    spans.into_iter().max_by_key(|(start_ns, end_ns)| end_ns.saturating_sub(*start_ns))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lease(states: &[(u64, bool)]) -> Vec<LeaseSample> {
        states.iter().map(|&(log_ns, running)| LeaseSample { log_ns, running, run: 0 }).collect()
    }

    #[test]
    fn the_longest_time_in_which_the_lease_was_running_is_the_run() {
        for (states, expected) in [
            (&[(1, false), (5, true), (6, true), (9, false), (12, false)][..], Some((5, 9))),
            (&[(1, true), (3, false), (5, true), (9, false)], Some((5, 9))),
            (&[(5, true)], Some((5, u64::MAX))),
            (&[(1, false), (2, false)], None),
        ] {
            assert_eq!(longest_running(&lease(states)), expected, "{states:?}");
        }
    }
}
