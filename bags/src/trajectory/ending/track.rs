//! One robot of a run of which only the ending is kept.

use std::collections::VecDeque;

use super::steps::Steps;
use super::{NotClean, Outcome};
use crate::trajectory::command::{self, CommandSample};
use crate::trajectory::jumps;
use crate::trajectory::pose::PoseSample;
use crate::trajectory::resample;
use rsrs_core::controller::Command;

/// Poses of the beginning that are kept.
pub const N_FIRST: usize = 8;

/// Commands before and behind the first pose that are kept.
const N_EARLY: usize = 64;

/// More samples than this are not kept.
const MOST: usize = 200_000;

/// One robot, as it is heard.
#[derive(Default)]
pub struct Track {
    /// The stamp of the last pose, in nanoseconds.
    last_stamp_ns: Option<u64>,
    /// Poses of which it is not known yet whether they are part of the run.
    pub waiting: VecDeque<PoseSample>,
    /// Poses of the run so far.
    pub n_poses: usize,
    /// The first ones.
    pub first: Vec<PoseSample>,
    /// The last ones.
    pub recent: VecDeque<PoseSample>,
    /// The least and the most between two poses of the run, in nanoseconds.
    pub steps_ns: Option<(u64, u64)>,
    /// Those of them that may be gaps.
    pub gaps: Steps,
    /// How fast the robot came further than a tracker's noise, in metres per second.
    fastest_m_s: f64,
    commands: Commands,
}

/// What a robot was told.
#[derive(Default)]
struct Commands {
    n_all: usize,
    n_stamped: usize,
    last_log_ns: u64,
    last_stamp_ns: u64,
    told_m_s: f64,
    /// Around the first pose of the run.
    early: VecDeque<CommandSample>,
    n_before_early: usize,
    n_behind_first: usize,
    recent: VecDeque<CommandSample>,
    n_before_recent: usize,
}

impl Track {
    /// Hears of a pose.
    ///
    /// # Returns
    ///
    /// The time since the one before, in nanoseconds.
    pub fn step(&mut self, pose: &PoseSample) -> Outcome<Option<u64>> {
        let before_ns = self.last_stamp_ns.replace(pose.stamp_ns);
        match before_ns {
            Some(before_ns) if before_ns >= pose.stamp_ns => Err(NotClean),
            _ => Ok(before_ns.map(|before_ns| pose.stamp_ns - before_ns)),
        }
    }

    /// Takes a pose that is part of the run.
    ///
    /// # Arguments
    ///
    /// * `keep_ns` — how much of the end is kept, in nanoseconds.
    /// * `n_compared` — so many poses were held against those of the others, or need not be.
    pub fn admit(&mut self, pose: PoseSample, keep_ns: u64, n_compared: usize) -> Outcome<()> {
        if let Some(before) = self.recent.back() {
            let step_ns = pose.stamp_ns - before.stamp_ns;
            let (least_ns, most_ns) = self.steps_ns.unwrap_or((step_ns, step_ns));
            self.steps_ns = Some((least_ns.min(step_ns), most_ns.max(step_ns)));
            self.gaps.add(step_ns);
            self.fastest_m_s = self.fastest_m_s.max(jumps::beyond_noise_m_s(before, &pose));
        }
        if self.first.len() < N_FIRST {
            self.first.push(pose);
        }
        self.recent.push_back(pose);
        self.n_poses += 1;
        while let Some(oldest) = self.recent.front() {
            let is_old = pose.stamp_ns - oldest.stamp_ns > keep_ns;
            if !is_old || self.n_gone() >= n_compared {
                break;
            }
            self.recent.pop_front();
        }
        if self.recent.len() > MOST { Err(NotClean) } else { Ok(()) }
    }

    /// Keeps a pose until it is known whether it is part of the run.
    pub fn wait(&mut self, pose: PoseSample) -> Outcome<()> {
        self.waiting.push_back(pose);
        if self.waiting.len() > MOST { Err(NotClean) } else { Ok(()) }
    }

    /// Poses of the run that are no longer kept.
    pub fn n_gone(&self) -> usize {
        self.n_poses - self.recent.len()
    }

    /// A pose of the run that is still kept.
    pub fn pose(&self, index: usize) -> Option<&PoseSample> {
        self.recent.get(index.checked_sub(self.n_gone())?)
    }

    /// The pose at a time of the run, between two that are still kept.
    pub fn pose_at(&mut self, time_ns: u64) -> Option<PoseSample> {
        let is_recent = self.recent.front().is_some_and(|oldest| oldest.stamp_ns <= time_ns);
        if is_recent {
            return Some(resample::pose_at(self.recent.make_contiguous(), time_ns));
        }
        let is_early = self.first.last().is_some_and(|last| time_ns <= last.stamp_ns);
        is_early.then(|| resample::pose_at(&self.first, time_ns))
    }

    /// Takes a command.
    ///
    /// # Returns
    ///
    /// The time since the one before, in nanoseconds of log time.
    pub fn command(&mut self, sample: CommandSample, keep_ns: u64) -> Outcome<Option<u64>> {
        let has_begun = self.n_poses > 0;
        let commands = &mut self.commands;
        let step_ns =
            (commands.n_all > 0).then(|| sample.log_ns.saturating_sub(commands.last_log_ns));
        commands.n_all += 1;
        commands.last_log_ns = sample.log_ns;
        if let Some(stamp_ns) = sample.stamp_ns() {
            commands.n_stamped += 1;
            if stamp_ns < commands.last_stamp_ns {
                return Err(NotClean);
            }
            commands.last_stamp_ns = stamp_ns;
        }
        commands.told_m_s = commands.told_m_s.max(sample.command.speed_m_s.abs());
        if !has_begun {
            commands.early.push_back(sample);
            if commands.early.len() > N_EARLY {
                commands.early.pop_front();
                commands.n_before_early += 1;
            }
        } else if commands.n_behind_first < N_EARLY {
            commands.early.push_back(sample);
            commands.n_behind_first += 1;
        }
        commands.recent.push_back(sample);
        while commands.recent.front().is_some_and(|oldest| sample.log_ns - oldest.log_ns > keep_ns)
        {
            commands.recent.pop_front();
            commands.n_before_recent += 1;
        }
        if commands.recent.len() > MOST { Err(NotClean) } else { Ok(step_ns) }
    }

    /// Whether it was ever told anything.
    pub fn has_commands(&self) -> bool {
        self.commands.n_all > 0
    }

    /// Whether no pose of the run is out of reach from the one before.
    pub fn is_smooth(&self) -> bool {
        jumps::is_allowed_m_s(self.fastest_m_s, self.commands.told_m_s)
    }

    /// What answered the first pose of the run, or one of the next ones.
    pub fn first_answer(&self, pose: &PoseSample, period_ns: u64) -> Outcome<Command> {
        let commands = &self.commands;
        let early: Vec<CommandSample> = commands.early.iter().copied().collect();
        let latest_ns = commands.time_ns(pose) + period_ns / 2;
        let is_cut = commands.n_behind_first >= N_EARLY
            && early.last().is_none_or(|last| commands.at_ns(last) <= latest_ns);
        if is_cut {
            return Err(NotClean);
        }
        let answers = commands.answers(&[*pose], (&early, commands.n_before_early), period_ns)?;
        Ok(answers[0])
    }

    /// What answered some of the last poses of the run.
    pub fn last_answers(&self, poses: &[PoseSample], period_ns: u64) -> Outcome<Vec<Command>> {
        let recent: Vec<CommandSample> = self.commands.recent.iter().copied().collect();
        self.commands.answers(poses, (&recent, self.commands.n_before_recent), period_ns)
    }
}

impl Commands {
    /// By what commands are ordered: by their stamps if every one has one.
    fn is_by_stamp(&self) -> bool {
        self.n_stamped == self.n_all
    }

    fn at_ns(&self, command: &CommandSample) -> u64 {
        command.stamp_ns().filter(|_| self.is_by_stamp()).unwrap_or(command.log_ns)
    }

    fn time_ns(&self, pose: &PoseSample) -> u64 {
        if self.is_by_stamp() { pose.stamp_ns } else { pose.log_ns }
    }

    /// As [`command::answers`] with all commands, out of some in a row and the number of those
    /// before them.
    fn answers(
        &self,
        poses: &[PoseSample],
        (commands, n_before): (&[CommandSample], usize),
        period_ns: u64,
    ) -> Outcome<Vec<Command>> {
        let looks_stamped = commands.iter().all(|command| command.stamp_ns().is_some());
        if looks_stamped != self.is_by_stamp() {
            return Err(NotClean);
        }
        let (Some(first), Some(pose)) = (commands.first(), poses.first()) else {
            return Err(NotClean);
        };
        let is_first_known = n_before == 0 || self.at_ns(first) <= self.time_ns(pose);
        if !is_first_known {
            return Err(NotClean);
        }
        Ok(command::answers(poses, commands, period_ns))
    }
}
