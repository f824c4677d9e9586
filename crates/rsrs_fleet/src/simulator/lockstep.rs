//! Lockstep: which messages must have come before the world may step.

use std::collections::BTreeMap;
use std::time::Duration;

use rsrs_core::robot::controller::Command;

use super::{Action, Event, Placed, Progress, RECORDER_WINDOW, Refusal, Turn, check};
use crate::message::RobotState;
use crate::timing::{LEAST_STEP_TIMEOUT, LOCKSTEP_GRACE};

/// Why a world in lockstep is given up.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum VoidCause {
    /// A robot stands, and the world with it.
    #[error("frozen for {} s at step {step} of {steps}", LOCKSTEP_GRACE.as_secs())]
    Frozen {
        /// The last step.
        step: u64,
        /// Steps of the run.
        steps: u64,
    },
    /// All robots may move, and a message that the next step needs does not come.
    #[error("no step for {} s at step {step} of {steps}: {owed}", LEAST_STEP_TIMEOUT.as_secs())]
    Stalled {
        /// The last step.
        step: u64,
        /// Steps of the run.
        steps: u64,
        /// Who owes what.
        owed: String,
    },
}

/// The world steps when every robot has answered its detection; nothing sleeps, nothing is invented.
#[derive(Clone, Debug, Default)]
pub(super) struct Lockstep {
    /// The step that has been sensed last.
    step: u64,
    /// Commands that have come for it; `None` while no step waits.
    waiting: Option<BTreeMap<usize, Command>>,
    recorded: u64,
    permitted: bool,
    frozen_since: Option<Duration>,
    /// When it last sensed, or was permitted to; `None` before that.
    stepped: Option<Duration>,
    /// By robot: why its last command for this step was refused.
    refused: BTreeMap<usize, Refusal>,
}

impl Lockstep {
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Takes an event of a run that is not over.
    pub fn on_event(&mut self, event: &Event, turn: &mut Turn<'_>) {
        match event {
            Event::Gates(gates) => {
                assert_eq!(gates.len(), turn.placed.robots.len(), "one gate for each robot");
                self.permitted =
                    !gates.is_empty() && gates.iter().all(|gate| gate.state == RobotState::Moving);
            }
            Event::Command { robot, stamp_ns, command } => {
                if let Err(reason) = self.take(turn.placed, *robot, *command, *stamp_ns) {
                    self.refused.insert(*robot, reason.clone());
                    turn.actions.push(Action::Refuse { robot: *robot, reason });
                }
            }
            // What was not sensed cannot have been recorded: a late word about an earlier world.
            Event::Recorded { step } => self.recorded = self.recorded.max((*step).min(self.step)),
            Event::Placed(_) | Event::Removed | Event::NotPlaced { .. } => {}
        }
        if self.permitted {
            self.frozen_since = None;
            self.go_on(turn);
            self.judge_stall(turn);
        } else if *turn.progress == Progress::Started {
            self.freeze(turn);
        }
    }

    fn take(
        &mut self,
        placed: &Placed,
        robot: usize,
        command: Command,
        stamp_ns: Option<u64>,
    ) -> Result<(), Refusal> {
        let expected_ns = self.step * placed.period_ns;
        let found_ns = stamp_ns.ok_or(Refusal::Unstamped)?;
        let waiting = self.waiting.as_mut().ok_or(Refusal::NotWaiting)?;
        if found_ns != expected_ns {
            return Err(Refusal::OtherStep { found_ns, expected_ns });
        }
        check(placed, robot, command)?;
        if waiting.contains_key(&robot) {
            return Err(Refusal::Second);
        }
        waiting.insert(robot, command);
        Ok(())
    }

    /// A lapse freezes the world; if it lasts, the run is void: the world never steps with invented
    /// commands, so the bits hold.
    fn freeze(&mut self, turn: &mut Turn<'_>) {
        // What it waits for shows in the gates; the time does not count twice.
        self.stepped = None;
        let since = *self.frozen_since.get_or_insert(turn.now);
        if turn.now.saturating_sub(since) >= LOCKSTEP_GRACE {
            turn.void(&VoidCause::Frozen { step: self.step, steps: turn.placed.steps });
        }
    }

    /// Advances when all have answered, and senses when the recorder is close enough behind.
    fn go_on(&mut self, turn: &mut Turn<'_>) {
        let (placed, now) = (turn.placed, turn.now);
        *turn.progress = Progress::Started;
        self.stepped.get_or_insert(now);
        if self.waiting.as_ref().is_some_and(|commands| commands.len() == placed.robots.len()) {
            let commands = self.waiting.take().expect("checked in the line above");
            turn.actions.push(Action::Advance { commands: commands.into_values().collect() });
        }
        if self.waiting.is_some() {
            return;
        }
        if self.step >= placed.steps {
            turn.complete("all steps are made");
        } else if self.step < self.recorded + RECORDER_WINDOW {
            self.step += 1;
            self.stepped = Some(now);
            self.waiting = Some(BTreeMap::new());
            self.refused.clear();
            let stamp_ns = Some(self.step * placed.period_ns);
            turn.actions.push(Action::Sense { step: self.step, stamp_ns });
        }
    }

    /// All robots may move, and there is no step: what is lost does not come any more.
    fn judge_stall(&mut self, turn: &mut Turn<'_>) {
        let since = *self.stepped.get_or_insert(turn.now);
        let is_over = matches!(turn.progress, Progress::Complete(_));
        if !is_over && turn.now.saturating_sub(since) >= LEAST_STEP_TIMEOUT {
            let (step, steps, owed) = (self.step, turn.placed.steps, self.owed(turn.placed));
            turn.void(&VoidCause::Stalled { step, steps, owed });
        }
    }

    /// Who owes what.
    fn owed(&self, placed: &Placed) -> String {
        let Some(waiting) = &self.waiting else {
            let (recorded, step) = (self.recorded, self.step);
            return format!(
                "the recorder has confirmed step {recorded}, expected at least {}",
                (step + 1).saturating_sub(RECORDER_WINDOW)
            );
        };
        let names = placed.robots.iter().enumerate();
        let silent = names.filter(|(robot, _)| !waiting.contains_key(robot));
        let owed = silent.map(|(robot, name)| match self.refused.get(&robot) {
            Some(refusal) => format!("{name} ({refusal})"),
            None => name.clone(),
        });
        format!("no command from {}", owed.collect::<Vec<_>>().join(", "))
    }
}
