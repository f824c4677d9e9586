//! Lockstep: who must have spoken before the world may step.

use std::collections::BTreeMap;
use std::time::Duration;

use rsrs_core::controller::Command;

use super::{Action, Event, Placed, Progress, RECORDER_WINDOW, Refusal, check};
use crate::message::RobotState;
use crate::timing::LOCKSTEP_GRACE;

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
}

impl Lockstep {
    pub fn step(&self) -> u64 {
        self.step
    }

    /// Takes an event of a run that is not over.
    pub fn on_event(
        &mut self,
        (placed, progress): (&Placed, &mut Progress),
        event: &Event,
        now: Duration,
        actions: &mut Vec<Action>,
    ) {
        match event {
            Event::Gates(gates) => {
                assert_eq!(gates.len(), placed.n_robots, "one gate for each robot");
                self.permitted =
                    !gates.is_empty() && gates.iter().all(|gate| gate.state == RobotState::Moving);
            }
            Event::Command { robot, stamp_ns, command } => {
                if let Err(reason) = self.take(placed, (*robot, *command), *stamp_ns) {
                    actions.push(Action::Refuse { robot: *robot, reason });
                }
            }
            // What was not sensed cannot have been recorded: a late word about an earlier world.
            Event::Recorded { step } => self.recorded = self.recorded.max((*step).min(self.step)),
            Event::Placed(_) | Event::Removed | Event::NotPlaced { .. } => {}
        }
        if self.permitted {
            self.frozen_since = None;
            self.go_on(placed, progress, actions);
        } else if *progress == Progress::Started {
            self.freeze(placed, progress, (now, actions));
        }
    }

    fn take(
        &mut self,
        placed: &Placed,
        (robot, command): (usize, Command),
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
    fn freeze(
        &mut self,
        placed: &Placed,
        progress: &mut Progress,
        (now, actions): (Duration, &mut Vec<Action>),
    ) {
        let since = *self.frozen_since.get_or_insert(now);
        if now.saturating_sub(since) < LOCKSTEP_GRACE {
            return;
        }
        let reason = format!(
            "frozen for {} s at step {} of {}",
            LOCKSTEP_GRACE.as_secs(),
            self.step,
            placed.steps
        );
        *progress = Progress::Void(reason.clone());
        actions.push(Action::Void { reason });
    }

    /// Advances when all have answered, and senses when the recorder is close enough behind.
    fn go_on(&mut self, placed: &Placed, progress: &mut Progress, actions: &mut Vec<Action>) {
        *progress = Progress::Started;
        if self.waiting.as_ref().is_some_and(|commands| commands.len() == placed.n_robots) {
            let commands = self.waiting.take().expect("checked in the line above");
            actions.push(Action::Advance { commands: commands.into_values().collect() });
        }
        if self.waiting.is_some() {
            return;
        }
        if self.step >= placed.steps {
            let reason = "all steps are made";
            *progress = Progress::Complete(reason);
            actions.push(Action::Complete { reason });
        } else if self.step < self.recorded + RECORDER_WINDOW {
            self.step += 1;
            self.waiting = Some(BTreeMap::new());
            let stamp_ns = Some(self.step * placed.period_ns);
            actions.push(Action::Sense { step: self.step, stamp_ns });
        }
    }
}
