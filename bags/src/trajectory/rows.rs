//! The rows of a trajectory: all of them, or those that are kept.

use rsrs_core::controller::Command;
use rsrs_core::phase::samples_in;
use rsrs_core::trajectory::Trajectory;
use rsrs_core::unicycle::Pose;

use super::Keep;
use super::pose::PoseSample;

/// A trajectory that is filled robot by robot.
pub struct Rows {
    /// What is in it.
    pub trajectory: Trajectory,
    /// Samples of the run that it has, in order.
    pub samples: Vec<u64>,
    /// Samples that it does not have, all behind the first one.
    pub n_left_out: usize,
    /// Time of the first sample, in nanoseconds.
    pub start_ns: u64,
    period_ns: u64,
}

impl Rows {
    /// A trajectory in which no robot has done anything yet.
    ///
    /// # Arguments
    ///
    /// * `n_all`, `start_ns` — samples of the run, and the time of its first one.
    /// * `n_robots`, `period_ns` — of the trajectory.
    pub fn new(
        (n_all, start_ns): (u64, u64),
        (n_robots, period_ns): (usize, u64),
        keep: Keep,
    ) -> Self {
        let period_s = period_ns as f64 / 1e9;
        let n_last = match keep {
            Keep::All => n_all,
            Keep::Ending { seconds } => samples_in(f64::from(seconds), period_s) as u64,
        };
        let first_of_end = n_all.saturating_sub(n_last);
        let begin = 0..first_of_end.min(1);
        let samples: Vec<u64> = begin.chain(first_of_end..n_all).collect();
        let mut trajectory = Trajectory::new(period_s, n_robots);
        let n_cells = samples.len() * n_robots;
        trajectory.poses = vec![Pose { x_m: 0.0, y_m: 0.0, heading_rad: 0.0 }; n_cells];
        trajectory.commands = vec![Command::STOP; n_cells];
        let n_left_out = usize::try_from(n_all).unwrap_or(usize::MAX) - samples.len();
        Self { trajectory, samples, n_left_out, start_ns, period_ns }
    }

    /// The times of the samples, in nanoseconds.
    pub fn times_ns(&self) -> Vec<u64> {
        let time_ns = |sample: &u64| self.start_ns + sample * self.period_ns;
        self.samples.iter().map(time_ns).collect()
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
