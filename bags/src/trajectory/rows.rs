//! The rows of a trajectory, filled robot by robot.

use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::Pose;

use super::pose::PoseSample;

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
