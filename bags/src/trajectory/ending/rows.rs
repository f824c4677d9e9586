//! Whether the poses of all robots stand side by side, as they come.

use super::track::Track;
use super::{NotClean, Outcome};
use crate::trajectory::pose::PoseSample;

/// The rows of a run so far: one pose of each robot.
pub struct Rows {
    /// Which pose of each robot is in the first row.
    pub from: Vec<usize>,
    /// Whole rows.
    pub n_whole: usize,
    /// How far apart two poses in one row are at most, in nanoseconds of their stamps.
    pub apart_ns: u64,
    /// As far as the period was known when the first row was found, in nanoseconds.
    period_ns: u64,
}

impl Rows {
    /// Finds the first row, where the last robot begins, in the first poses of all robots.
    pub fn new(tracks: &[Track], period_ns: u64) -> Option<Self> {
        let from = first_row(tracks, period_ns)?;
        Some(Self { from, n_whole: 0, apart_ns: 0, period_ns })
    }

    /// Whether a robot does not stand beside the others any more: it may lack poses, or its rows have
    /// drifted apart.
    pub fn is_loose(&self, track: &Track) -> bool {
        let is_long = |(_, most_ns)| most_ns > self.period_ns * 7 / 4;
        track.steps_ns.is_some_and(is_long) || self.apart_ns > self.period_ns
    }

    /// Looks whether a pose has completed rows.
    pub fn advance(&mut self, tracks: &[Track], robot: usize) -> Outcome<()> {
        if tracks[robot].n_poses != self.n_whole + self.from[robot] + 1 {
            return Ok(());
        }
        self.complete(tracks)
    }

    /// Compares all rows that are whole.
    pub fn complete(&mut self, tracks: &[Track]) -> Outcome<()> {
        while tracks.iter().zip(&self.from).all(|(track, from)| track.n_poses > self.n_whole + from)
        {
            let stamp_ns = |robot: usize| {
                let pose = tracks[robot].pose(self.n_whole + self.from[robot]);
                pose.map(|pose| pose.stamp_ns).ok_or(NotClean)
            };
            let expected_ns = stamp_ns(0)?;
            for robot in 1..tracks.len() {
                self.apart_ns = self.apart_ns.max(stamp_ns(robot)?.abs_diff(expected_ns));
            }
            self.n_whole += 1;
        }
        Ok(())
    }
}

/// Which of its first poses each robot has in the first row.
pub fn first_row(tracks: &[Track], period_ns: u64) -> Option<Vec<usize>> {
    let start_ns = tracks.iter().filter_map(|track| track.first.first()).map(stamp_ns).max()?;
    let is_common = |pose: &PoseSample| pose.stamp_ns + period_ns / 2 >= start_ns;
    tracks.iter().map(|track| track.first.iter().position(is_common)).collect()
}

fn stamp_ns(pose: &PoseSample) -> u64 {
    pose.stamp_ns
}
