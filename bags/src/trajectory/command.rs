//! Commands out of the two messages that carry them, and which one holds at a time.

use rsrs_core::robot::controller::Command;
use rsrs_msgs::geometry_msgs::{Twist, TwistStamped};

use super::TrajectoryError;
use super::pose::PoseSample;

/// A robot obeys a command at least so long, in nanoseconds.
const MIN_TIMEOUT_NS: u64 = 300_000_000;

/// One robot's command at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CommandSample {
    /// The stamp in the message, in nanoseconds; `None` where there is none.
    pub stamp_ns: Option<u64>,
    /// When it was recorded, in nanoseconds.
    pub log_ns: u64,
    pub command: Command,
}

impl CommandSample {
    /// The command in a stamped message.
    pub fn of_stamped(
        robot: &str,
        message: &TwistStamped,
        log_ns: u64,
    ) -> Result<Self, TrajectoryError> {
        let stamp_ns = message.header.stamp.to_nanos();
        Ok(Self { stamp_ns, ..Self::of_unstamped(robot, message.twist, log_ns)? })
    }

    /// The command in a message without stamp.
    pub fn of_unstamped(robot: &str, twist: Twist, log_ns: u64) -> Result<Self, TrajectoryError> {
        let command = Command { speed_m_s: twist.linear.x, turn_rate_rad_s: twist.angular.z };
        if !command.speed_m_s.is_finite() || !command.turn_rate_rad_s.is_finite() {
            let (robot, time_s) = (robot.to_owned(), log_ns as f64 / 1e9);
            return Err(TrajectoryError::NotFinite { what: "command", robot, time_s });
        }
        Ok(Self { stamp_ns: None, log_ns, command })
    }

    /// Whether the robot was to do anything.
    pub fn moves(&self) -> bool {
        self.command != Command::STOP
    }
}

/// A time by a clock that was set back by so much, in nanoseconds.
pub fn set_back(time_ns: u64, by_ns: i128) -> u64 {
    u64::try_from((i128::from(time_ns) - by_ns).max(0)).unwrap_or(u64::MAX)
}

/// The command that answered each pose, in their order.
///
/// The latest one up to half a period after the pose, so that it may come a little before or after
/// it; by the stamps if every command has one (and not all of them zero), else by log time. No
/// command yet, or one that has run out, is a stop.
pub fn answers(poses: &[PoseSample], commands: &[CommandSample], period_ns: u64) -> Vec<Command> {
    let timeout_ns = (period_ns * 5 / 2).max(MIN_TIMEOUT_NS);
    let stamped: Option<Vec<(u64, Command)>> =
        commands.iter().map(|command| Some((command.stamp_ns?, command.command))).collect();
    let by_stamp = stamped.is_some();
    let mut timed = stamped.unwrap_or_else(|| {
        commands.iter().map(|command| (command.log_ns, command.command)).collect()
    });
    // Stable, so that of two commands at one time the later one in the bag holds.
    timed.sort_by_key(|(time_ns, _)| *time_ns);
    poses
        .iter()
        .map(|pose| {
            let time_ns = if by_stamp { pose.stamp_ns } else { pose.log_ns };
            let n_before =
                timed.partition_point(|(at_ns, _)| *at_ns <= time_ns.saturating_add(period_ns / 2));
            match timed[..n_before].last() {
                Some((at_ns, command)) if time_ns.saturating_sub(*at_ns) <= timeout_ns => *command,
                _ => Command::STOP,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use rsrs_core::robot::unicycle::Pose;

    use super::*;

    const PERIOD_NS: u64 = 130_000_000;

    fn poses(n_poses: u64) -> Vec<PoseSample> {
        let pose = Pose { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 };
        let at = |time_ns| PoseSample { stamp_ns: time_ns, log_ns: time_ns, pose };
        (0..n_poses).map(|sample| at(sample * PERIOD_NS)).collect()
    }

    fn command(time_ns: u64, speed_m_s: f64) -> CommandSample {
        let command = Command { speed_m_s, turn_rate_rad_s: 0.0 };
        CommandSample { stamp_ns: Some(time_ns), log_ns: time_ns, command }
    }

    fn speeds(commands: &[Command]) -> Vec<f64> {
        commands.iter().map(|command| command.speed_m_s).collect()
    }

    #[test]
    fn the_nearest_command_answers_a_pose_and_holds_until_it_runs_out() {
        let at_once = [command(0, 1.0), command(PERIOD_NS, 2.0), command(2 * PERIOD_NS, 3.0)];
        let near = [
            command(9, 1.0),
            command(PERIOD_NS - 7, 2.0),
            command(2 * PERIOD_NS + 50_000_000, 3.0),
        ];
        let early = [command(PERIOD_NS, 2.0)];
        for (commands, expected) in [
            (&at_once[..], &[1.0, 2.0, 3.0][..]),
            (&near, &[1.0, 2.0, 3.0]),
            // 2.5 periods are 325 ms: two more periods hold, the third does not.
            (&at_once[..1], &[1.0, 1.0, 1.0, 0.0, 0.0]),
            (&early, &[0.0, 2.0]),
        ] {
            let poses = poses(expected.len() as u64);

            assert_eq!(speeds(&answers(&poses, commands, PERIOD_NS)), expected, "{commands:?}");
        }
    }

    #[test]
    fn one_command_without_a_stamp_puts_all_on_log_time() {
        let mut late = command(PERIOD_NS, 2.0);
        late.stamp_ns = None;
        // By its stamp the other one would answer the first pose.
        let early = CommandSample { stamp_ns: Some(0), log_ns: 2 * PERIOD_NS, ..command(0, 3.0) };

        assert_eq!(speeds(&answers(&poses(3), &[late, early], PERIOD_NS)), [0.0, 2.0, 3.0]);
    }
}
