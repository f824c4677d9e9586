//! The pace of a simulated fleet in lockstep: who must have spoken before the world may step.
//!
//! The machine owns no world. It says when to sense and when to advance; its driver does so.

use std::collections::BTreeMap;
use std::time::Duration;

use rsrs_core::conditions::Conditions;
use rsrs_core::controller::Command;
use rsrs_core::digest::Digest;

use crate::timing::LOCKSTEP_GRACE;

/// Steps that the simulator may be ahead of the recorder.
pub const RECORDER_WINDOW: u64 = 20;

/// Names a placed world: the simulator reports it in its status, and the runner expects it.
///
/// # Arguments
///
/// * `seed`, `replicate` — which run of the conditions.
/// * `steps` — how many steps the world is to make.
pub fn placement_digest(conditions: &Conditions, seed: u64, replicate: u64, steps: u64) -> u64 {
    let mut digest = Digest::new("placement");
    for word in [conditions.digest(), seed, replicate, steps] {
        digest.word(word);
    }
    digest.value()
}

/// What happens to the simulator.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The robots stand at their start poses and will make this many steps.
    Placed {
        /// Number of robots.
        n_robots: usize,
        /// Steps to make.
        steps: u64,
        /// Length of one step, in nanoseconds of simulated time.
        period_ns: u64,
    },
    /// Whether every robot of the run may move now.
    Permission(bool),
    /// A velocity command arrived.
    Command {
        /// Index of the robot.
        robot: usize,
        /// Simulated time that it is stamped with, in nanoseconds; `None` for an unstamped one.
        stamp_ns: Option<u64>,
        /// The command.
        command: Command,
    },
    /// The recorder has taken every topic up to this step.
    Recorded {
        /// The step.
        step: u64,
    },
    /// Time passed.
    Tick,
}

/// What the simulator does.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Sense, and publish the clock, the detections, the poses and the digest of this step.
    Sense {
        /// The step, from 1.
        step: u64,
        /// Its simulated time, in nanoseconds.
        stamp_ns: u64,
    },
    /// Move all robots by one step.
    Advance {
        /// One command for each robot; shape `[n_robots]`.
        commands: Vec<Command>,
    },
    /// Refuse a command, and say so in the log.
    Refuse {
        /// Index of the robot.
        robot: usize,
        /// Why.
        reason: Refusal,
    },
    /// All steps are made.
    Complete,
    /// The run cannot be completed and does not count.
    Void {
        /// Why.
        reason: String,
    },
}

/// Why a command was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// It carries no stamp, so that nobody can say which step it belongs to.
    #[error("unstamped command: lockstep needs geometry_msgs/TwistStamped")]
    Unstamped,
    /// It belongs to another step.
    #[error("command stamped {found_ns} ns, expected {expected_ns} ns")]
    OtherStep {
        /// Its stamp.
        found_ns: u64,
        /// The stamp of the step that waits.
        expected_ns: u64,
    },
    /// The robot has already answered this step.
    #[error("second command for one detection")]
    Second,
    /// It is not a finite velocity.
    #[error("command is not finite")]
    NotFinite,
    /// No step waits for commands.
    #[error("no step waits for a command")]
    NotWaiting,
}

/// The lockstep of one run.
#[derive(Clone, Debug, Default)]
pub struct Simulator {
    run: Option<Run>,
}

#[derive(Clone, Debug)]
struct Run {
    n_robots: usize,
    steps: u64,
    period_ns: u64,
    /// The step that has been sensed last.
    step: u64,
    /// Commands that have come for it; `None` while no step waits.
    waiting: Option<BTreeMap<usize, Command>>,
    recorded: u64,
    permitted: bool,
    started: bool,
    frozen_since: Option<Duration>,
    ended: bool,
}

impl Simulator {
    /// A simulator that waits to be placed.
    pub fn new() -> Self {
        Self::default()
    }

    /// The step that has been sensed last; 0 before the first.
    pub fn step(&self) -> u64 {
        self.run.as_ref().map_or(0, |run| run.step)
    }

    /// Takes an event.
    #[expect(clippy::needless_pass_by_value, reason = "every machine takes its events by value")]
    pub fn on_event(&mut self, event: Event, now: Duration) -> Vec<Action> {
        if let Event::Placed { n_robots, steps, period_ns } = event {
            self.run = Some(Run {
                n_robots,
                steps,
                period_ns,
                step: 0,
                waiting: None,
                recorded: 0,
                permitted: false,
                started: false,
                frozen_since: None,
                ended: false,
            });
            return Vec::new();
        }
        match &mut self.run {
            Some(run) if !run.ended => run.on_event(&event, now),
            _ => Vec::new(),
        }
    }
}

impl Run {
    fn on_event(&mut self, event: &Event, now: Duration) -> Vec<Action> {
        let mut actions = Vec::new();
        match *event {
            Event::Permission(permitted) => {
                self.permitted = permitted;
                self.started |= permitted;
            }
            Event::Command { robot, stamp_ns, command } => {
                if let Err(reason) = self.take(robot, stamp_ns, command) {
                    actions.push(Action::Refuse { robot, reason });
                }
            }
            Event::Recorded { step } => self.recorded = self.recorded.max(step),
            Event::Placed { .. } | Event::Tick => {}
        }
        self.freeze(now, &mut actions);
        self.go_on(&mut actions);
        actions
    }

    fn take(
        &mut self,
        robot: usize,
        stamp_ns: Option<u64>,
        command: Command,
    ) -> Result<(), Refusal> {
        let expected_ns = self.step * self.period_ns;
        let found_ns = stamp_ns.ok_or(Refusal::Unstamped)?;
        let waiting = self.waiting.as_mut().ok_or(Refusal::NotWaiting)?;
        if found_ns != expected_ns {
            return Err(Refusal::OtherStep { found_ns, expected_ns });
        }
        if !(command.speed_m_s.is_finite() && command.turn_rate_rad_s.is_finite()) {
            return Err(Refusal::NotFinite);
        }
        if waiting.contains_key(&robot) {
            return Err(Refusal::Second);
        }
        waiting.insert(robot, command);
        Ok(())
    }

    /// A lapse freezes the world; if it lasts, the run is void: the world never steps with invented
    /// commands, so the bits hold.
    fn freeze(&mut self, now: Duration, actions: &mut Vec<Action>) {
        if !self.started || self.permitted {
            self.frozen_since = None;
            return;
        }
        let since = *self.frozen_since.get_or_insert(now);
        if now.saturating_sub(since) >= LOCKSTEP_GRACE {
            self.ended = true;
            let reason = format!(
                "frozen for {} s at step {} of {}",
                LOCKSTEP_GRACE.as_secs(),
                self.step,
                self.steps
            );
            actions.push(Action::Void { reason });
        }
    }

    /// Advances when all have answered, and senses when the recorder is close enough behind.
    fn go_on(&mut self, actions: &mut Vec<Action>) {
        if !self.permitted || self.ended {
            return;
        }
        if self.waiting.as_ref().is_some_and(|commands| commands.len() == self.n_robots) {
            let commands = self.waiting.take().expect("checked in the line above");
            actions.push(Action::Advance { commands: commands.into_values().collect() });
            if self.step == self.steps {
                self.ended = true;
                actions.push(Action::Complete);
                return;
            }
        }
        if self.waiting.is_none() && self.step < self.recorded + RECORDER_WINDOW {
            self.step += 1;
            self.waiting = Some(BTreeMap::new());
            actions.push(Action::Sense { step: self.step, stamp_ns: self.step * self.period_ns });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORWARD: Command = Command { speed_m_s: 0.15, turn_rate_rad_s: 0.75 };

    fn command(robot: usize, stamp_ns: Option<u64>) -> Event {
        Event::Command { robot, stamp_ns, command: FORWARD }
    }

    fn placed(n_robots: usize, steps: u64) -> Simulator {
        let mut simulator = Simulator::new();
        simulator.on_event(Event::Placed { n_robots, steps, period_ns: 130 }, Duration::ZERO);
        simulator
    }

    #[test]
    fn the_world_steps_when_every_robot_has_answered_once() {
        let mut simulator = placed(2, 2);

        let start = simulator.on_event(Event::Permission(true), Duration::ZERO);
        let one = simulator.on_event(command(1, Some(130)), Duration::ZERO);
        let both = simulator.on_event(command(0, Some(130)), Duration::ZERO);

        assert_eq!(start, [Action::Sense { step: 1, stamp_ns: 130 }]);
        assert_eq!(one, []);
        assert_eq!(
            both,
            [
                Action::Advance { commands: vec![FORWARD; 2] },
                Action::Sense { step: 2, stamp_ns: 260 }
            ]
        );
    }

    #[test]
    fn a_command_that_is_unstamped_late_or_a_second_one_is_refused() {
        let mut simulator = placed(2, 2);
        simulator.on_event(Event::Permission(true), Duration::ZERO);

        let refusal = |simulator: &mut Simulator, event| simulator.on_event(event, Duration::ZERO);

        assert_eq!(
            refusal(&mut simulator, command(0, None)),
            [Action::Refuse { robot: 0, reason: Refusal::Unstamped }]
        );
        assert_eq!(
            refusal(&mut simulator, command(0, Some(0))),
            [Action::Refuse {
                robot: 0,
                reason: Refusal::OtherStep { found_ns: 0, expected_ns: 130 }
            }]
        );
        assert_eq!(refusal(&mut simulator, command(0, Some(130))), []);
        assert_eq!(
            refusal(&mut simulator, command(0, Some(130))),
            [Action::Refuse { robot: 0, reason: Refusal::Second }]
        );
    }

    #[test]
    fn the_world_waits_for_a_recorder_that_is_too_far_behind() {
        let mut simulator = placed(1, 100);
        simulator.on_event(Event::Permission(true), Duration::ZERO);
        for step in 1..=RECORDER_WINDOW {
            simulator.on_event(command(0, Some(step * 130)), Duration::ZERO);
        }

        assert_eq!(simulator.step(), RECORDER_WINDOW);
        simulator.on_event(Event::Recorded { step: 1 }, Duration::ZERO);
        assert_eq!(simulator.step(), RECORDER_WINDOW + 1);
    }

    #[test]
    fn a_freeze_that_lasts_voids_the_run() {
        let mut simulator = placed(1, 100);
        simulator.on_event(Event::Permission(true), Duration::ZERO);
        simulator.on_event(Event::Permission(false), Duration::from_secs(1));

        assert_eq!(simulator.on_event(Event::Tick, Duration::from_millis(5900)), []);
        let end = simulator.on_event(Event::Tick, Duration::from_secs(6));

        assert!(matches!(end[..], [Action::Void { .. }]), "{end:?}");
    }

    #[test]
    fn the_last_step_completes_the_run() {
        let mut simulator = placed(1, 1);
        simulator.on_event(Event::Permission(true), Duration::ZERO);

        let end = simulator.on_event(command(0, Some(130)), Duration::ZERO);

        assert_eq!(end, [Action::Advance { commands: vec![FORWARD] }, Action::Complete]);
    }
}
