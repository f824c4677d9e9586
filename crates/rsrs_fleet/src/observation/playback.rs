//! A recorded fleet, seen again: forward at any pace, and from any moment on.

use std::time::Duration;

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::trajectory::{Bodies, Trajectory};
use rsrs_core::judge::window::{WINDOW_S, samples_in};

use crate::experiment::Time;

use super::{Event, Observation, SwarmOrder, order_of};

/// Paces, as seconds of the recording in one second.
const PACES: [f64; 8] = [0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0];
/// Place of the recorded pace.
const RECORDED: usize = 2;
/// What does not last is forgotten after this: it fills the judge's window.
const MEMORY: Duration = Duration::from_secs(70);

/// What the swarm did, as the judge reads it out of a bag.
#[derive(Clone, Debug)]
pub struct RecordedSwarm {
    /// Poses and commands of the run.
    pub trajectory: Trajectory,
    /// When the first sample is, from the beginning of the recording.
    pub start: Duration,
    /// What is known of the robots.
    pub bodies: Bodies,
    /// What the run is judged for.
    pub behaviour: Behaviour,
}

impl RecordedSwarm {
    /// The order parameters that were those of the last minute at a time; `None` before the run.
    fn order(&self, at: Duration) -> Option<SwarmOrder> {
        let since_s = at.checked_sub(self.start)?.as_secs_f64();
        let n_samples = samples_in(since_s, self.trajectory.period_s);
        let n_samples = n_samples.min(self.trajectory.n_samples());
        order_of(&self.trajectory, n_samples, &self.bodies, self.behaviour)
    }
}

/// A recording that is played.
#[derive(Clone, Debug)]
pub struct Playback {
    /// By time from the beginning of the recording.
    events: Vec<(Duration, Event)>,
    swarm: Option<RecordedSwarm>,
    duration: Duration,
    at: Duration,
    /// The first event that was not taken yet.
    next: usize,
    observation: Observation,
    /// Whether times are simulated.
    is_lockstep: bool,
    pace: usize,
    is_paused: bool,
}

impl Playback {
    /// A recording at its beginning, which is played at the recorded pace.
    ///
    /// Events are in any order, with their times from the beginning of the recording, which lasts
    /// at least until the last of them. Without a `swarm` that the judge can read, poses are taken
    /// as they come.
    pub fn new(
        mut events: Vec<(Duration, Event)>,
        swarm: Option<RecordedSwarm>,
        duration: Duration,
    ) -> Self {
        events.sort_by_key(|(at, _)| *at);
        let is_lockstep = |(_, event): &(Duration, Event)| matches!(event, Event::Experiment(record) if record.time == Time::Lockstep);
        let is_lockstep = events.iter().any(is_lockstep);
        let last = events.last().map_or(Duration::ZERO, |(at, _)| *at);
        let mut playback = Self {
            events,
            swarm,
            duration: duration.max(last),
            at: Duration::ZERO,
            next: 0,
            observation: Observation::default(),
            is_lockstep,
            pace: RECORDED,
            is_paused: false,
        };
        playback.forget();
        playback.take_until_now();
        playback
    }

    fn forget(&mut self) {
        self.observation =
            if self.is_lockstep { Observation::of_lockstep() } else { Observation::default() };
    }

    /// Plays on for so much wall-clock time, unless it is paused.
    pub fn advance(&mut self, elapsed: Duration) {
        if !self.is_paused {
            let by = elapsed.mul_f64(self.pace());
            self.at = self.at.saturating_add(by).min(self.duration);
            self.take_until_now();
        }
    }

    /// Goes to a moment of the recording; beyond its end, to its end.
    pub fn seek(&mut self, to: Duration) {
        let to = to.min(self.duration);
        if to < self.at {
            self.forget();
            // What lasts is taken from the beginning on, all else as far as it is remembered.
            let from = to.saturating_sub(MEMORY);
            self.next = self.events.partition_point(|(at, _)| *at < from);
            for (at, event) in &self.events[..self.next] {
                if event.is_lasting() {
                    self.observation.on_event(event.clone(), *at);
                }
            }
        }
        self.at = to;
        self.take_until_now();
    }

    /// Goes back or forward, in seconds of the recording.
    pub fn skip(&mut self, by_s: f64) {
        let by = Duration::from_secs_f64(by_s.abs());
        let forward = self.at.saturating_add(by);
        self.seek(if by_s < 0.0 { self.at.saturating_sub(by) } else { forward });
    }

    /// Pauses, or goes on; from the end it goes on from the beginning.
    pub fn toggle_pause(&mut self) {
        if self.is_over() {
            self.seek(Duration::ZERO);
            self.is_paused = false;
        } else {
            self.is_paused = !self.is_paused;
        }
    }

    /// Plays faster, up to 50 times the recorded pace.
    pub fn play_faster(&mut self) {
        self.pace = (self.pace + 1).min(PACES.len() - 1);
    }

    /// Plays slower, down to a quarter of the recorded pace.
    pub fn play_slower(&mut self) {
        self.pace = self.pace.saturating_sub(1);
    }

    /// What is seen at this moment.
    pub fn observation(&self) -> &Observation {
        &self.observation
    }

    /// The order parameters at this moment: once the run is over, those of its last minute.
    pub fn order(&self) -> Option<SwarmOrder> {
        match &self.swarm {
            Some(swarm) => swarm.order(self.at),
            None => self.observation.order(),
        }
    }

    /// The moment, from the beginning of the recording.
    pub fn at(&self) -> Duration {
        self.at
    }

    /// How long the recording is.
    pub fn duration(&self) -> Duration {
        self.duration
    }

    /// Seconds of the recording in one second.
    pub fn pace(&self) -> f64 {
        PACES[self.pace]
    }

    /// Whether it is paused.
    pub fn is_paused(&self) -> bool {
        self.is_paused
    }

    /// Whether it is at its end.
    pub fn is_over(&self) -> bool {
        self.at >= self.duration
    }

    fn take_until_now(&mut self) {
        while let Some((at, event)) = self.events.get(self.next).filter(|(at, _)| *at <= self.at) {
            self.observation.on_event(event.clone(), *at);
            self.next += 1;
        }
    }
}

// Twice as long as the judge looks back would be kept for nothing.
const _: () = assert!(MEMORY.as_secs() as f64 >= WINDOW_S);
