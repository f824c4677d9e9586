//! Manual control of a world outside of any run: it is played, paused, stepped, and its robots are
//! moved. The words are those of `simulation_interfaces`.

use std::time::Duration;

use super::{Action, Event, Placed, Progress, Run, Simulator, Turn, WorldState};
use crate::experiment::Time;

/// A command of manual control, to a world that no run holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ManualCommand {
    /// It goes on at wall-clock speed, each robot as its conditions' controller decides.
    Play,
    /// It pauses.
    Pause,
    /// It makes so many steps, as fast as it can, and pauses again.
    Step {
        /// How many; at least 1.
        steps: u64,
    },
    /// An entity in it was moved, so that it senses anew.
    EntityMoved,
}

/// Why manual control is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ManualControlRefused {
    /// There is none.
    #[error("no world is placed")]
    NoWorld,
    /// It is an experiment's.
    #[error("an experiment holds the robots: it must end first")]
    Held,
    /// Single steps are made by a paused world.
    #[error("the world is not paused")]
    NotPaused,
}

/// Whether the world plays, as `simulation_interfaces` puts it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaybackState {
    /// There is no world.
    NoWorld,
    /// It is at its start.
    Stopped,
    /// It goes on.
    Playing,
    /// It pauses where it is.
    Paused,
}

impl Simulator {
    /// Whether its world plays.
    pub fn playback_state(&self) -> PlaybackState {
        match &self.world {
            WorldState::Empty | WorldState::Refused(_) => PlaybackState::NoWorld,
            WorldState::Placed(Run { manual: Some(manual), .. }) => manual.playback_state(),
            WorldState::Placed(Run { progress, .. }) => match progress {
                Progress::Waiting => PlaybackState::Stopped,
                Progress::Started => PlaybackState::Playing,
                Progress::Complete(_) | Progress::Void(_) => PlaybackState::Paused,
            },
        }
    }

    /// Whether the world may be controlled manually: not while a run holds its robots.
    pub fn check_manual_control(&self) -> Result<(), ManualControlRefused> {
        match &self.world {
            WorldState::Empty | WorldState::Refused(_) => Err(ManualControlRefused::NoWorld),
            WorldState::Placed(run) if run.is_held || run.progress == Progress::Started => {
                Err(ManualControlRefused::Held)
            }
            WorldState::Placed(_) => Ok(()),
        }
    }

    /// Applies a command of manual control, and returns what to do, in order. From then on the
    /// status names no world, so that no run uses this one; placing it again gives it back.
    pub fn apply_manual(
        &mut self,
        command: ManualCommand,
        now: Duration,
    ) -> Result<Vec<Action>, ManualControlRefused> {
        self.check_manual_control()?;
        let (step, state) = (self.step(), self.playback_state());
        if matches!(command, ManualCommand::Step { .. }) && state != PlaybackState::Paused {
            return Err(ManualControlRefused::NotPaused);
        }
        let WorldState::Placed(run) = &mut self.world else {
            return Err(ManualControlRefused::NoWorld);
        };
        let mut actions = Vec::new();
        let Run { placed, progress, manual, .. } = run;
        let manual = manual.get_or_insert_with(|| ManualControl::at(step, placed, now));
        manual.apply(command, &mut Turn { placed, progress, now, actions: &mut actions });
        actions.extend(self.status_due(now).map(Action::Status));
        Ok(actions)
    }
}

/// The manual control of a world. Such a world is none that a seed leads to, so no run may use it.
#[derive(Clone, Copy, Debug)]
pub(super) struct ManualControl {
    mode: Mode,
    /// The step that has been sensed last.
    step: u64,
}

#[derive(Clone, Copy, Debug)]
enum Mode {
    /// Time stands, and with it the sensors: in lockstep it is the world's own.
    Paused,
    /// The world stands and its sensors work on, as in real time before a run.
    Standing {
        due: Duration,
    },
    Playing {
        due: Duration,
    },
    Stepping {
        left: u64,
    },
}

impl Mode {
    /// Paused, having sensed just now.
    fn paused(placed: &Placed, now: Duration) -> Self {
        match placed.time {
            Time::Lockstep => Self::Paused,
            Time::RealTime => Self::Standing { due: now + Duration::from_nanos(placed.period_ns) },
        }
    }

    fn is_paused(self) -> bool {
        matches!(self, Self::Paused | Self::Standing { .. })
    }
}

impl ManualControl {
    /// Takes control of a world at this step.
    pub fn at(step: u64, placed: &Placed, now: Duration) -> Self {
        Self { mode: Mode::paused(placed, now), step: step.max(1) }
    }

    pub fn step(&self) -> u64 {
        self.step
    }

    pub fn due(&self) -> Option<Duration> {
        match self.mode {
            Mode::Paused => None,
            Mode::Standing { due } | Mode::Playing { due } => Some(due),
            Mode::Stepping { .. } => Some(Duration::ZERO),
        }
    }

    pub fn playback_state(&self) -> PlaybackState {
        match self.mode {
            // Until its steps are made, it is not paused.
            Mode::Playing { .. } | Mode::Stepping { .. } => PlaybackState::Playing,
            Mode::Paused | Mode::Standing { .. } => PlaybackState::Paused,
        }
    }

    /// Applies a command.
    pub fn apply(&mut self, command: ManualCommand, turn: &mut Turn<'_>) {
        match command {
            ManualCommand::Play => self.mode = Mode::Playing { due: turn.now },
            ManualCommand::Pause => self.pause(turn),
            ManualCommand::Step { steps } => self.mode = Mode::Stepping { left: steps },
            ManualCommand::EntityMoved => turn.actions.push(self.sense(turn.placed)),
        }
    }

    /// Pauses; a request for steps is answered: no more are made.
    pub fn pause(&mut self, turn: &mut Turn<'_>) {
        if let Mode::Stepping { left } = self.mode {
            turn.actions.push(Action::Stepped { left });
        }
        if !self.mode.is_paused() {
            self.mode = Mode::paused(turn.placed, turn.now);
        }
    }

    pub fn on_event(&mut self, event: &Event, turn: &mut Turn<'_>) {
        let (placed, now) = (turn.placed, turn.now);
        if !matches!(event, Event::Gates(_)) || self.due().is_none_or(|due| now < due) {
            return;
        }
        if self.mode.is_paused() {
            self.mode = Mode::paused(placed, now);
            turn.actions.push(self.sense(placed));
            return;
        }
        self.step += 1;
        turn.actions.extend([Action::AdvanceFreely, self.sense(placed)]);
        match &mut self.mode {
            Mode::Paused | Mode::Standing { .. } => {}
            Mode::Playing { due } => {
                // What was missed is left out: a burst would be faster than real time.
                *due = now.max(*due + Duration::from_nanos(placed.period_ns));
            }
            Mode::Stepping { left } => {
                *left -= 1;
                if *left == 0 {
                    self.pause(turn);
                }
            }
        }
    }

    fn sense(&self, placed: &Placed) -> Action {
        let stamp_ns = match placed.time {
            Time::Lockstep => Some(self.step * placed.period_ns),
            Time::RealTime => None,
        };
        Action::Sense { step: self.step, stamp_ns }
    }
}
