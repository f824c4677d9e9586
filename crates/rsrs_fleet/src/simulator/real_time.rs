//! Real time: one step in every control period, with what the gates let through.

use std::time::Duration;

use super::{Action, Event, Gate, Gates, Placed, Progress, check};
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

    pub fn on_event(
        &mut self,
        placed: &Placed,
        progress: &mut Progress,
        event: &Event,
        now: Duration,
        actions: &mut Vec<Action>,
    ) {
        match event {
            Event::Gates(gates) => {
                assert_eq!(gates.len(), placed.robots.len(), "one gate for each robot");
                pass(placed, gates, progress, actions);
                if now >= self.due {
                    self.tick(placed, gates, progress, now, actions);
                }
            }
            Event::Command { robot, command, .. } => {
                let (robot, command) = (*robot, *command);
                actions.push(match check(placed, robot, command) {
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
    fn tick(
        &mut self,
        placed: &Placed,
        gates: &[Gate],
        progress: &Progress,
        now: Duration,
        actions: &mut Vec<Action>,
    ) {
        let late_ns = now.saturating_sub(self.due).as_nanos();
        let missed = u64::try_from(late_ns / u128::from(placed.period_ns)).unwrap_or(u64::MAX);
        let ahead_ns = u128::from(placed.period_ns) - late_ns % u128::from(placed.period_ns);
        self.due = now
            + Duration::from_nanos(
                u64::try_from(ahead_ns).expect("it is at most a period, which fits"),
            );
        let is_running = *progress == Progress::Started;
        if self.step == 0 {
            self.step = 1;
        } else if is_running {
            self.step += 1;
            actions
                .push(Action::Advance { commands: gates.iter().map(|gate| gate.drive).collect() });
        }
        actions.push(Action::Sense { step: self.step, stamp_ns: None });
        if is_running && missed > 0 {
            self.missed = self.missed.saturating_add(missed);
            if self.warned.is_none_or(|at| now.saturating_sub(at) >= WARN_EVERY) {
                self.warned = Some(now);
                actions.push(Action::Overrun { missed: self.missed });
            }
        }
    }
}

/// The run starts with the first robot that moves, and is over when no robot can move any more.
fn pass(placed: &Placed, gates: &[Gate], progress: &mut Progress, actions: &mut Vec<Action>) {
    match progress {
        Progress::Waiting if gates.iter().any(|gate| gate.state == RobotState::Moving) => {
            *progress = Progress::Started;
        }
        Progress::Started if placed.gates == Gates::Elsewhere => {}
        Progress::Started if !gates.iter().any(|gate| gate.is_in_run) => {
            let reason = "every robot has stopped";
            *progress = Progress::Complete(reason);
            actions.push(Action::Complete { reason });
        }
        _ => {}
    }
}
