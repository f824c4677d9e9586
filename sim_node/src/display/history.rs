//! The last minute of a run, for the judge.

use rsrs_core::judge::phase::{self, WINDOW_S};
use rsrs_core::judge::trajectory::Trajectory;
use rsrs_core::robot::controller::Command;
use rsrs_core::robot::unicycle::Pose;

/// Poses and commands of the last steps: at least a window of the judge, once so many were made.
pub struct History {
    trajectory: Trajectory,
    n_window: usize,
}

impl History {
    /// Of a world that has made no step.
    pub fn new(period_s: f64, n_robots: usize) -> Self {
        let n_window = phase::samples_in(WINDOW_S, period_s);
        Self { trajectory: Trajectory::new(period_s, n_robots), n_window }
    }

    /// Adds a step: what was sensed, and the commands that answered it.
    pub fn step(&mut self, poses: impl Iterator<Item = Pose>, commands: &[Command]) {
        let Self { trajectory, n_window } = self;
        trajectory.poses.extend(poses);
        trajectory.commands.extend(commands);
        if trajectory.n_samples() >= 2 * *n_window {
            let n_old = (trajectory.n_samples() - *n_window) * trajectory.n_robots;
            trajectory.poses.drain(..n_old);
            trajectory.commands.drain(..n_old);
        }
    }

    /// What the judge wants to see; `None` while there is too little of it.
    pub fn window(&self) -> Option<Trajectory> {
        (self.trajectory.n_samples() >= self.n_window).then(|| self.trajectory.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_keeps_a_window_and_not_the_whole_run() {
        let mut history = History::new(0.5, 2);

        for step in 0..1000 {
            assert_eq!(history.window().is_some(), step >= 120, "{step}");
            let pose = Pose { x_m: f64::from(step), ..Pose::default() };
            history.step([pose; 2].into_iter(), &[Command::STOP; 2]);
        }

        let window = history.window().expect("it is long enough");
        assert!((120..240).contains(&window.n_samples()), "{}", window.n_samples());
        let last = window.poses_at(window.n_samples() - 1)[1];
        assert_eq!(last.x_m.to_bits(), 999_f64.to_bits());
        assert_eq!(window.commands.len(), window.poses.len());
    }
}
