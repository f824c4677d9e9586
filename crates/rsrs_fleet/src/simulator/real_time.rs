//! Real time: one step in every control period, with what the gates let through.

use std::time::Duration;

use super::{Action, Event, Gate, Gates, Progress, Turn, check};
use crate::message::RobotState;

/// Least time between two warnings that the world does not keep up.
const WARN_EVERY: Duration = Duration::from_secs(1);

/// The world goes by the wall clock.
///
/// Sensors work from the placement on, as a real robot's do; the world's own time starts with the
/// first robot that may move, so that a run starts from the start poses however long it took to arm.
#[derive(Clone, Debug)]
pub(super) struct RealTime {
    /// The step that has been sensed last.
    step: u64,
    /// When the next period ends.
    due: Duration,
    missed: u64,
    warned: Option<Duration>,
}

impl RealTime {
    pub fn new(now: Duration) -> Self {
        Self { step: 0, due: now, missed: 0, warned: None }
    }

    pub fn step(&self) -> u64 {
        self.step
    }

    pub fn due(&self) -> Duration {
        self.due
    }

    pub fn on_event(&mut self, event: &Event, turn: &mut Turn<'_>) {
        match event {
            Event::Gates(gates) => {
                assert_eq!(gates.len(), turn.placed.robots.len(), "one gate for each robot");
                pass(gates, turn);
                if turn.now >= self.due {
                    self.tick(gates, turn);
                }
            }
            Event::Command { robot, command, .. } => {
                let (robot, command) = (*robot, *command);
                turn.actions.push(match check(turn.placed, robot, command) {
                    Ok(()) => Action::Obey { robot, command },
                    Err(reason) => Action::Refuse { robot, reason },
                });
            }
            Event::Recorded { .. }
            | Event::Placed(_)
            | Event::Removed
            | Event::NotPlaced { .. } => {}
        }
    }

    /// Makes one step, however many periods have passed: a burst would move robots faster than
    /// their commands.
    fn tick(&mut self, gates: &[Gate], turn: &mut Turn<'_>) {
        let (now, period_ns) = (turn.now, u128::from(turn.placed.period_ns));
        let late_ns = now.saturating_sub(self.due).as_nanos();
        let missed = u64::try_from(late_ns / period_ns).unwrap_or(u64::MAX);
        let ahead_ns = u64::try_from(period_ns - late_ns % period_ns);
        self.due =
            now + Duration::from_nanos(ahead_ns.expect("it is at most a period, which fits"));
        let is_running = *turn.progress == Progress::Started;
        if self.step == 0 {
            self.step = 1;
        } else if is_running {
            self.step += 1;
            let commands = gates.iter().map(|gate| gate.drive).collect();
            turn.actions.push(Action::Advance { commands });
        }
        turn.actions.push(Action::Sense { step: self.step, stamp_ns: None });
        if is_running && missed > 0 {
            self.missed = self.missed.saturating_add(missed);
            if self.warned.is_none_or(|at| now.saturating_sub(at) >= WARN_EVERY) {
                self.warned = Some(now);
                turn.actions.push(Action::Overrun { missed: self.missed });
            }
        }
    }
}

/// The run starts with the first robot that moves, and is over when no robot can move any more.
fn pass(gates: &[Gate], turn: &mut Turn<'_>) {
    match turn.progress {
        Progress::Waiting if gates.iter().any(|gate| gate.state == RobotState::Moving) => {
            *turn.progress = Progress::Started;
        }
        Progress::Started if turn.placed.gates == Gates::Elsewhere => {}
        Progress::Started if !gates.iter().any(|gate| gate.is_in_run) => {
            turn.complete("every robot has stopped");
        }
        _ => {}
    }
}
