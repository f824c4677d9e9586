//! A run of which only the ending is kept, as it is heard.

mod finish;
mod resampled;

use std::collections::BTreeSet;

use rsrs_msgs::rsrs::RunLease;

use super::middle::Middle;
use super::rows::Rows;
use super::steps::Steps;
use super::track::{N_FIRST, Track};
use super::{NotClean, Outcome};
use crate::trajectory::command::CommandSample;
use crate::trajectory::pose::PoseSample;

/// Kept on top of the ending, in nanoseconds: robots do not end at the same moment.
const SPARE_NS: u64 = 10_000_000_000;

/// Poses before the first command of which some may belong to the run.
const N_BEFORE: usize = 8;

/// So many steps of each robot are enough to tell the period, but for its last digits.
const N_STEPS: usize = 8;

/// A run, as it is heard.
pub struct Run {
    names: Vec<String>,
    tracks: Vec<Track>,
    seconds: u32,
    state: State,
    members: BTreeSet<String>,
    log_ns: u64,
    /// Between poses of one robot, in nanoseconds.
    steps_ns: Middle,
    /// Between commands of one robot, in nanoseconds.
    command_steps_ns: Middle,
    command_steps: Steps,
    rows: Option<Rows>,
    /// Whether robots do not stand side by side any more, as far as can be told before the end; then
    /// their rows are no longer looked at.
    is_loose: bool,
}

/// Whether poses belong to the run, in nanoseconds of log time.
#[derive(Clone, Debug, PartialEq)]
enum State {
    /// There is a lease, which did not say RUNNING yet.
    NotRunning,
    Running {
        start_ns: u64,
    },
    Over {
        start_ns: u64,
        end_ns: u64,
    },
    /// There is no lease, and nobody was told to move yet.
    Still,
    /// Commands moved robots from there to here; of each robot the poses shortly before, of which
    /// all are there if it says so.
    Moved {
        first_ns: u64,
        last_ns: u64,
        before: Vec<(Vec<PoseSample>, bool)>,
        /// How many of them belong to the run, once it is known.
        n_taken: Option<Vec<usize>>,
    },
}

impl Run {
    /// Nothing was heard yet.
    pub fn new(names: Vec<String>, (seconds, has_lease): (u32, bool)) -> Self {
        Self {
            tracks: names.iter().map(|_| Track::default()).collect(),
            names,
            seconds,
            state: if has_lease { State::NotRunning } else { State::Still },
            members: BTreeSet::new(),
            log_ns: 0,
            steps_ns: Middle::default(),
            command_steps_ns: Middle::default(),
            command_steps: Steps::default(),
            rows: None,
            is_loose: false,
        }
    }

    /// The robots, in order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    /// Goes on to a log time.
    pub fn is_in_order(&mut self, log_ns: u64) -> Outcome<()> {
        let before_ns = std::mem::replace(&mut self.log_ns, log_ns);
        if log_ns < before_ns { Err(NotClean) } else { Ok(()) }
    }

    /// Hears the lease.
    pub fn lease(&mut self, log_ns: u64, lease: RunLease) -> Outcome<()> {
        let is_running = lease.state == RunLease::RUNNING;
        if is_running {
            self.members.extend(lease.robots);
        }
        match (&self.state, is_running) {
            (State::NotRunning, true) => {
                self.state = State::Running { start_ns: log_ns };
                for robot in 0..self.tracks.len() {
                    for pose in std::mem::take(&mut self.tracks[robot].waiting) {
                        if pose.log_ns >= log_ns {
                            self.admit(robot, pose)?;
                        }
                    }
                }
                Ok(())
            }
            (State::Running { start_ns }, false) => {
                self.state = State::Over { start_ns: *start_ns, end_ns: log_ns };
                Ok(())
            }
            // Which of two runs counts is told at the end of the second.
            (State::Over { .. }, true) => Err(NotClean),
            _ => Ok(()),
        }
    }

    /// Hears a command.
    pub fn command(&mut self, robot: usize, sample: CommandSample) -> Outcome<()> {
        let keep_ns = self.keep_ns();
        if let Some(step_ns) = self.tracks[robot].command(sample, keep_ns)? {
            self.command_steps_ns.add(step_ns);
            self.command_steps.add(step_ns);
        }
        if !sample.moves() {
            return Ok(());
        }
        match &mut self.state {
            State::Still => {
                let before = self.tracks.iter_mut().map(|track| {
                    let is_whole = track.waiting.len() < N_BEFORE;
                    (std::mem::take(&mut track.waiting).into(), is_whole)
                });
                self.state = State::Moved {
                    first_ns: sample.log_ns,
                    last_ns: sample.log_ns,
                    before: before.collect(),
                    n_taken: None,
                };
            }
            State::Moved { last_ns, .. } => *last_ns = sample.log_ns,
            _ => {}
        }
        Ok(())
    }

    /// Hears a pose.
    pub fn pose(&mut self, robot: usize, pose: PoseSample) -> Outcome<()> {
        if let Some(step_ns) = self.tracks[robot].step(&pose)? {
            self.steps_ns.add(step_ns);
        }
        let track = &mut self.tracks[robot];
        match self.state {
            State::Running { .. } => self.admit(robot, pose),
            State::Over { end_ns, .. } if pose.log_ns == end_ns => self.admit(robot, pose),
            State::Over { .. } => Ok(()),
            State::NotRunning => {
                track.waiting.retain(|before| before.log_ns == pose.log_ns);
                track.wait(pose)
            }
            State::Still => {
                if track.waiting.len() == N_BEFORE {
                    track.waiting.pop_front();
                }
                track.wait(pose)
            }
            State::Moved { .. } => {
                track.wait(pose)?;
                self.release(robot)
            }
        }
    }

    /// Admits what waited for commands that came.
    fn release(&mut self, robot: usize) -> Outcome<()> {
        if matches!(self.state, State::Moved { n_taken: None, .. }) {
            if self.steps_ns.len() < N_STEPS * self.tracks.len() {
                return Ok(());
            }
            let period_ns = self.period_ns()?;
            self.begin(period_ns)?;
        }
        let State::Moved { last_ns, .. } = self.state else { return Ok(()) };
        self.release_to(robot, last_ns)
    }

    fn release_to(&mut self, robot: usize, to_ns: u64) -> Outcome<()> {
        while let Some(pose) =
            self.tracks[robot].waiting.front().copied().filter(|pose| pose.log_ns <= to_ns)
        {
            self.tracks[robot].waiting.pop_front();
            self.admit(robot, pose)?;
        }
        Ok(())
    }

    /// Admits the poses shortly before the first command.
    fn begin(&mut self, period_ns: u64) -> Outcome<()> {
        let State::Moved { first_ns, before, n_taken, .. } = &mut self.state else {
            return Ok(());
        };
        let counts = n_before(before, first_ns.saturating_sub(period_ns / 2));
        *n_taken = Some(counts.clone());
        let before: Vec<Vec<PoseSample>> = before.iter().map(|(poses, _)| poses.clone()).collect();
        for (robot, (poses, n_taken)) in before.iter().zip(counts).enumerate() {
            for pose in &poses[poses.len() - n_taken..] {
                self.admit(robot, *pose)?;
            }
        }
        Ok(())
    }

    fn admit(&mut self, robot: usize, pose: PoseSample) -> Outcome<()> {
        let n_compared = match &self.rows {
            _ if self.is_loose => usize::MAX,
            Some(rows) => rows.n_whole + rows.from[robot],
            None => 0,
        };
        let keep_ns = self.keep_ns();
        self.tracks[robot].admit(pose, keep_ns, n_compared)?;
        if self.is_loose {
            return Ok(());
        }
        if let Some(rows) = &mut self.rows {
            rows.advance(&self.tracks, robot)?;
            self.is_loose = rows.is_loose(&self.tracks[robot]);
            return Ok(());
        }
        // Then the steps between them are known, too.
        if self.tracks.iter().all(|track| track.first.len() == N_FIRST) {
            let period_ns = self.period_ns()?;
            for track in &mut self.tracks {
                track.gaps.uncounted_ns = period_ns + period_ns / 4;
            }
            self.rows = Rows::new(&self.tracks, period_ns);
        }
        self.rows.as_mut().map_or(Ok(()), |rows| rows.complete(&self.tracks))
    }

    fn keep_ns(&self) -> u64 {
        u64::from(self.seconds) * 1_000_000_000 + SPARE_NS
    }

    /// The period of poses so far, in nanoseconds.
    fn period_ns(&mut self) -> Outcome<u64> {
        let middle = self.steps_ns.len() / 2;
        self.steps_ns.at(middle).filter(|period_ns| *period_ns > 0).ok_or(NotClean)
    }
}

/// How many of the poses before the first command are not before this time, by robot.
fn n_before(before: &[(Vec<PoseSample>, bool)], start_ns: u64) -> Vec<usize> {
    let count = |(poses, _): &(Vec<PoseSample>, bool)| {
        poses.iter().filter(|pose| pose.log_ns >= start_ns).count()
    };
    before.iter().map(count).collect()
}
