//! A world that a person moves by hand, outside of any run: played, paused, stepped, touched.

use std::time::Duration;

use super::{Action, Event, Placed, Progress, Run, Simulator, WorldState};
use crate::experiment::Time;

/// A request of a person to a world that no run holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hand {
    /// It goes on by the clock on the wall, each robot as its conditions' controller decides.
    Play,
    /// It stands.
    Pause,
    /// It makes so many steps, as fast as it can, and stands again.
    Step {
        /// How many; at least 1.
        steps: u64,
    },
    /// Something in it was moved.
    Touch,
}

/// Why a hand must not move the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum HandRefusal {
    /// There is none.
    #[error("no world is placed")]
    NoWorld,
    /// It is an experiment's.
    #[error("an experiment holds the robots: it must end first")]
    Held,
    /// Steps are made by a world that stands.
    #[error("the world is not paused")]
    NotPaused,
}

/// What a simulator does, in the words of those who only watch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Doing {
    /// There is no world.
    Nothing,
    /// The world stands at its start.
    AtTheStart,
    /// It goes on.
    Playing,
    /// It stands where it is.
    Standing,
}

impl Simulator {
    /// What it does, in the words of those who only watch.
    pub fn doing(&self) -> Doing {
        match &self.world {
            WorldState::Empty | WorldState::Refused(_) => Doing::Nothing,
            WorldState::Placed(Run { hand: Some(hand), .. }) => hand.doing(),
            WorldState::Placed(Run { progress, .. }) => match progress {
                Progress::Waiting => Doing::AtTheStart,
                Progress::Started => Doing::Playing,
                Progress::Complete(_) | Progress::Void(_) => Doing::Standing,
            },
        }
    }

    /// Whether a person may move, replace or touch the world: not while a run holds its robots.
    ///
    /// # Errors
    ///
    /// [`HandRefusal::NoWorld`] and [`HandRefusal::Held`].
    pub fn check_hand(&self) -> Result<(), HandRefusal> {
        match &self.world {
            WorldState::Empty | WorldState::Refused(_) => Err(HandRefusal::NoWorld),
            WorldState::Placed(run) if run.is_held || run.progress == Progress::Started => {
                Err(HandRefusal::Held)
            }
            WorldState::Placed(_) => Ok(()),
        }
    }

    /// Lets a hand move the world. From then on its status names no world, so that no run can take
    /// it for one that was placed; placing it anew gives it back.
    ///
    /// # Returns
    ///
    /// What to do, in order.
    ///
    /// # Errors
    ///
    /// [`HandRefusal`].
    pub fn by_hand(&mut self, hand: Hand, now: Duration) -> Result<Vec<Action>, HandRefusal> {
        self.check_hand()?;
        let (step, doing) = (self.step(), self.doing());
        if matches!(hand, Hand::Step { .. }) && doing != Doing::Standing {
            return Err(HandRefusal::NotPaused);
        }
        let WorldState::Placed(run) = &mut self.world else {
            return Err(HandRefusal::NoWorld);
        };
        let mut actions = Vec::new();
        let by_hand = run.hand.get_or_insert_with(|| ByHand::at(step));
        by_hand.take(&run.placed, hand, now, &mut actions);
        actions.extend(self.status_due(now).map(Action::Status));
        Ok(actions)
    }
}

/// A world that is moved by hand. It is none that a seed leads to, so no run may use it any more.
#[derive(Clone, Copy, Debug)]
pub(super) struct ByHand {
    mode: Mode,
    /// The step that has been sensed last.
    step: u64,
}

#[derive(Clone, Copy, Debug)]
enum Mode {
    Paused,
    Playing { due: Duration },
    Stepping { left: u64 },
}

impl ByHand {
    /// A world that was at this step when the hand took it.
    pub fn at(step: u64) -> Self {
        Self { mode: Mode::Paused, step: step.max(1) }
    }

    pub fn step(&self) -> u64 {
        self.step
    }

    pub fn due(&self) -> Option<Duration> {
        match self.mode {
            Mode::Paused => None,
            Mode::Playing { due } => Some(due),
            Mode::Stepping { .. } => Some(Duration::ZERO),
        }
    }

    pub fn doing(&self) -> Doing {
        match self.mode {
            // Until its steps are made, it is not paused.
            Mode::Playing { .. } | Mode::Stepping { .. } => Doing::Playing,
            Mode::Paused => Doing::Standing,
        }
    }

    /// Does what the hand wants.
    pub fn take(&mut self, placed: &Placed, hand: Hand, now: Duration, actions: &mut Vec<Action>) {
        match hand {
            Hand::Play => self.mode = Mode::Playing { due: now },
            Hand::Pause => self.stand(actions),
            Hand::Step { steps } => self.mode = Mode::Stepping { left: steps },
            Hand::Touch => actions.push(self.sense(placed)),
        }
    }

    /// Stands; a request for steps is answered: no more are made.
    pub fn stand(&mut self, actions: &mut Vec<Action>) {
        if let Mode::Stepping { left } = self.mode {
            actions.push(Action::Stepped { left });
        }
        self.mode = Mode::Paused;
    }

    pub fn on_event(
        &mut self,
        placed: &Placed,
        event: &Event,
        now: Duration,
        actions: &mut Vec<Action>,
    ) {
        if !matches!(event, Event::Gates(_)) || self.due().is_none_or(|due| now < due) {
            return;
        }
        self.step += 1;
        actions.extend([Action::AdvanceFreely, self.sense(placed)]);
        match &mut self.mode {
            Mode::Paused => {}
            Mode::Playing { due } => {
                // What was missed is left out: a burst would be faster than real time.
                *due = now.max(*due + Duration::from_nanos(placed.period_ns));
            }
            Mode::Stepping { left } => {
                *left -= 1;
                if *left == 0 {
                    self.stand(actions);
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
