//! What is left of a run when all was heard.

use rsrs_core::controller::Command;
use rsrs_core::phase::samples_in;
use rsrs_core::trajectory::Trajectory;

use super::{Run, State, n_before};
use crate::Bag;
use crate::trajectory::align::{MIN_COMMANDS, is_rarer};
use crate::trajectory::ending::rows::{Rows, first_row};
use crate::trajectory::ending::track::Track;
use crate::trajectory::ending::{NotClean, Outcome};
use crate::trajectory::pose::PoseSample;
use crate::trajectory::resample::{Times, most_step_ns};
use crate::trajectory::{Finding, PoseSource, RecordedTrajectory, RunningWindow, WindowSource};

/// What is kept of a run.
pub(super) struct Ending {
    /// The first sample and the last ones.
    pub trajectory: Trajectory,
    /// Samples between them.
    pub n_left_out: usize,
    /// Time of the first sample, in nanoseconds.
    pub start_ns: u64,
    /// What was mended.
    pub findings: Vec<Finding>,
}

impl Run {
    /// The trajectory, now that all was heard.
    pub fn finish(mut self, bag: &Bag, poses: PoseSource) -> Outcome<RecordedTrajectory> {
        let recorded_ns = self.period_ns()?;
        let period_ns = self.trajectory_period_ns(recorded_ns)?;
        let window = self.close(period_ns)?;
        let is_member = |name: &String| self.members.is_empty() || self.members.contains(name);
        let n_members = if self.members.is_empty() { self.names.len() } else { self.members.len() };
        if n_members != self.names.len() || !self.names.iter().all(is_member) {
            return Err(NotClean);
        }
        if !self.tracks.iter().all(|track| track.is_smooth() && track.has_commands()) {
            return Err(NotClean);
        }
        let ending = if period_ns == recorded_ns && self.has_no_gaps(period_ns) {
            self.side_by_side(period_ns, bag)?
        } else {
            let breaks_off = !bag.damage().is_empty();
            self.resampled(Times { recorded_ns, period_ns, breaks_off })?
        };
        Ok(RecordedTrajectory {
            trajectory: ending.trajectory,
            n_left_out: ending.n_left_out,
            start_ns: ending.start_ns,
            robots: self.names,
            poses,
            window,
            findings: ending.findings,
            damage: bag.damage(),
        })
    }

    /// The period of the trajectory, as [`crate::trajectory::align::period_ns`] finds it.
    fn trajectory_period_ns(&mut self, recorded_ns: u64) -> Outcome<u64> {
        let n_commands = self.command_steps_ns.len();
        if n_commands < MIN_COMMANDS * self.tracks.len() {
            return Ok(recorded_ns);
        }
        let place = |percent: usize| (n_commands - 1) * percent / 100;
        let middle_ns = self.command_steps_ns.at(place(50)).ok_or(NotClean)?;
        if !is_rarer(middle_ns, recorded_ns) {
            return Ok(recorded_ns);
        }
        // The twentieth part from either end is within a factor of 1.5 of the middle.
        let n_above = |limit_ns: u64| {
            let above = self.command_steps.above(limit_ns).ok_or(NotClean)?;
            usize::try_from(above.n).map_err(|_too_many| NotClean)
        };
        let n_low = n_commands - n_above(middle_ns * 2 / 3)?;
        let n_below_high = n_commands - n_above(middle_ns * 3 / 2 - 1)?;
        let is_regular = n_low <= place(5) && n_below_high > place(95);
        Ok(if is_regular { middle_ns } else { recorded_ns })
    }

    /// Whether there is one pose of each robot in every period.
    fn has_no_gaps(&self, period_ns: u64) -> bool {
        let (least_ns, most_ns) = (period_ns / 2, most_step_ns(period_ns));
        let is_regular = |(least, most)| least >= least_ns && most <= most_ns;
        self.tracks.iter().all(|track| track.steps_ns.is_some_and(is_regular))
    }

    /// The ending of robots that stand side by side.
    fn side_by_side(&mut self, period_ns: u64, bag: &Bag) -> Outcome<Ending> {
        if self.is_loose {
            return Err(NotClean);
        }
        if self.rows.is_none() {
            self.rows = Some(Rows::new(&self.tracks, period_ns).ok_or(NotClean)?);
        }
        let rows = self.rows.as_mut().expect("it was just made");
        rows.complete(&self.tracks)?;
        let start_ns = self.tracks[0].first[rows.from[0]].stamp_ns;
        let n_samples = self.n_samples(period_ns, bag)?;
        let (trajectory, n_left_out) = self.ending(n_samples, period_ns)?;
        Ok(Ending { trajectory, n_left_out, start_ns, findings: Vec::new() })
    }

    /// Admits the last poses of the run, and says when it was.
    fn close(&mut self, period_ns: u64) -> Outcome<RunningWindow> {
        let (start_ns, end_ns) = match &self.state {
            State::Running { start_ns } => (*start_ns, u64::MAX),
            State::Over { start_ns, end_ns } => (*start_ns, *end_ns),
            State::NotRunning | State::Still => return Err(NotClean),
            State::Moved { first_ns, last_ns, .. } => {
                (first_ns.saturating_sub(period_ns / 2), last_ns.saturating_add(period_ns / 2))
            }
        };
        let mut source = WindowSource::Lease;
        if matches!(self.state, State::Moved { .. }) {
            source = WindowSource::Commands;
            if matches!(self.state, State::Moved { n_taken: None, .. }) {
                self.begin(period_ns)?;
            }
            for robot in 0..self.tracks.len() {
                self.release_to(robot, end_ns)?;
            }
        }
        if let State::Moved { before, n_taken, .. } = &self.state {
            // The period is known to its last digits only now.
            let is_whole = |(poses, is_whole): &(Vec<PoseSample>, bool)| {
                *is_whole || poses.first().is_some_and(|pose| pose.log_ns < start_ns)
            };
            let counts = n_before(before, start_ns);
            if n_taken.as_ref() != Some(&counts) || !before.iter().all(is_whole) {
                return Err(NotClean);
            }
        }
        Ok(RunningWindow { start_ns, end_ns, source })
    }

    /// How many rows the trajectory has, if the robots stand side by side through all of it.
    fn n_samples(&self, period_ns: u64, bag: &Bag) -> Outcome<usize> {
        let rows = self.rows.as_ref().ok_or(NotClean)?;
        let (half_ns, most_ns) = (period_ns / 2, most_step_ns(period_ns));
        if rows.apart_ns > half_ns {
            return Err(NotClean);
        }
        if first_row(&self.tracks, period_ns).as_ref() != Some(&rows.from) {
            return Err(NotClean);
        }
        let end_ns = self.common_end_ns(most_ns, bag)?;
        let count = |(track, from): (&Track, &usize)| {
            let is_common = |pose: &PoseSample| pose.stamp_ns <= end_ns + half_ns;
            let last = track.recent.iter().rposition(is_common)?;
            (track.n_gone() + last + 1).checked_sub(*from)
        };
        let mut counts = self.tracks.iter().zip(&rows.from).map(count);
        let n_samples = counts.next().flatten().ok_or(NotClean)?;
        let are_equal = counts.all(|count| count == Some(n_samples));
        if are_equal && (2..=rows.n_whole).contains(&n_samples) {
            Ok(n_samples)
        } else {
            Err(NotClean)
        }
    }

    /// When the first robot ends, by its stamps, if none comes much later or leaves much earlier
    /// than the others.
    fn common_end_ns(&self, most_ns: u64, bag: &Bag) -> Outcome<u64> {
        let firsts = self.tracks.iter().filter_map(|track| track.first.first());
        let lasts = self.tracks.iter().filter_map(|track| track.recent.back());
        let (earliest_ns, latest_start_ns) = range(firsts.map(|pose| pose.stamp_ns));
        let (end_ns, latest_ns) = range(lasts.map(|pose| pose.stamp_ns));
        let comes_late = latest_start_ns - earliest_ns > most_ns;
        let leaves_early = latest_ns - end_ns > most_ns && bag.damage().is_empty();
        if comes_late || leaves_early { Err(NotClean) } else { Ok(end_ns) }
    }

    /// The first sample and the last ones, and how many lie between them.
    fn ending(&self, n_samples: usize, period_ns: u64) -> Outcome<(Trajectory, usize)> {
        let from = &self.rows.as_ref().ok_or(NotClean)?.from;
        let period_s = period_ns as f64 / 1e9;
        let n_kept = samples_in(f64::from(self.seconds), period_s).min(n_samples);
        let mut trajectory = Trajectory::new(period_s, self.tracks.len());
        if n_kept < n_samples {
            for (track, from) in self.tracks.iter().zip(from) {
                trajectory.poses.push(track.first[*from].pose);
                trajectory.commands.push(track.first_answer(&track.first[*from], period_ns)?);
            }
        }
        let mut kept: Vec<(Vec<PoseSample>, Vec<Command>)> = Vec::new();
        for (track, from) in self.tracks.iter().zip(from) {
            let indexes = from + n_samples - n_kept..from + n_samples;
            let poses: Option<Vec<PoseSample>> =
                indexes.map(|index| track.pose(index).copied()).collect();
            let poses = poses.ok_or(NotClean)?;
            let answers = track.last_answers(&poses, period_ns)?;
            kept.push((poses, answers));
        }
        for sample in 0..n_kept {
            trajectory.poses.extend(kept.iter().map(|(poses, _)| poses[sample].pose));
            trajectory.commands.extend(kept.iter().map(|(_, answers)| answers[sample]));
        }
        Ok((trajectory, (n_samples - n_kept).saturating_sub(1)))
    }
}

/// The least and the most of some times, of which there is one at least.
fn range(times_ns: impl Iterator<Item = u64>) -> (u64, u64) {
    times_ns.fold((u64::MAX, 0), |(least, most), time_ns| (least.min(time_ns), most.max(time_ns)))
}
