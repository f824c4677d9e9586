//! The lease in the hands of a controller, for a robot without a gate of ours in front of its wheels.
//!
//! What a gate would let through is what is published; when that ends, a zero is published at once,
//! and again for a while: the base may have missed one, and may have no timeout of its own. If the
//! controller's process dies, no command is published any more, and only the base can stop its
//! wheels.

use std::time::Duration;

use rsrs_core::robot::controller::Command;

use super::{Action, Event};
use crate::message::Status;
use crate::robot::{self, Lapse, Robot, RobotOptions};
use crate::timing::{NODE_TIMEOUT, REPEAT_PERIOD, SENSOR_TIMEOUT};

/// A gate at the mouth of a controller.
#[derive(Clone, Debug)]
pub(super) struct LeaseGate {
    gate: Robot,
    /// What was published last; `None` before the first word, when the wheels may still turn as an
    /// earlier process commanded.
    sent: Option<Command>,
    /// Since when it stands, and when that was published last.
    stands: Option<(Duration, Duration)>,
    sensor: Sensor,
}

/// Whether the robot's sensor works, as far as a controller can observe that: if the robot dies, so
/// does its sensor, and no other node would report it.
#[derive(Clone, Copy, Debug, Default)]
struct Sensor {
    /// When its last detection came, or else the first event of all.
    since: Option<Duration>,
    is_silent: bool,
}

impl Sensor {
    /// What to report, if its state has changed.
    fn on_event(&mut self, event: &Event, now: Duration) -> Option<robot::Event> {
        if matches!(event, Event::Detection(_)) {
            self.since = Some(now);
        }
        let since = *self.since.get_or_insert(now);
        let is_silent = now.saturating_sub(since) > SENSOR_TIMEOUT;
        if std::mem::replace(&mut self.is_silent, is_silent) == is_silent {
            return None;
        }
        Some(if is_silent {
            let silence_s = SENSOR_TIMEOUT.as_secs();
            robot::Event::Fault(format!("no detection received for more than {silence_s} s"))
        } else {
            robot::Event::Repaired
        })
    }
}

impl LeaseGate {
    pub(super) fn new(robot: &str, command_timeout: Duration) -> Self {
        let lapse = Lapse::Stops;
        let options = RobotOptions { name: robot.to_owned(), command_timeout, lapse };
        Self { gate: Robot::new(options), sent: None, stands: None, sensor: Sensor::default() }
    }

    pub(super) fn counting_from(self, counter: u64) -> Self {
        Self { gate: self.gate.counting_from(counter), ..self }
    }

    pub(super) fn of_a_new_process(self) -> Self {
        Self { gate: self.gate.of_a_new_process(), ..self }
    }

    pub(super) fn gate(&self) -> &Robot {
        &self.gate
    }

    /// Lets through what may go out of what the controller wants to do after an event.
    ///
    /// The gate goes by `word`, the status that the controller would publish now.
    pub(super) fn hold(
        &mut self,
        event: &Event,
        word: Status,
        wanted: Vec<Action>,
        now: Duration,
    ) -> Vec<Action> {
        let mut actions = Vec::new();
        if let Some(news) = self.sensor.on_event(event, now) {
            self.step_gate(news, now, &mut actions);
        }
        match event {
            Event::Lease(lease) => {
                self.step_gate(robot::Event::Lease(lease.clone()), now, &mut actions);
            }
            Event::EStop(message) => {
                self.step_gate(robot::Event::EStop(message.clone()), now, &mut actions);
            }
            Event::Detection(_)
            | Event::Reading { .. }
            | Event::Clock(_)
            | Event::Parameters(_)
            | Event::Tick => {}
        }
        self.step_gate(robot::Event::Controller(word), now, &mut actions);
        for action in wanted {
            match action {
                Action::Command { command, stamp_ns } => {
                    self.step_gate(robot::Event::Command(command), now, &mut actions);
                    let command = self.gate.drive(now);
                    actions.push(self.publish(command, stamp_ns, now));
                }
                other => actions.push(other),
            }
        }
        actions.extend(self.zero_due(now));
        actions
    }

    fn step_gate(&mut self, event: robot::Event, now: Duration, actions: &mut Vec<Action>) {
        actions.extend(self.gate.on_event(event, now).map(Action::GateStatus));
    }

    fn publish(&mut self, command: Command, stamp_ns: Option<u64>, now: Duration) -> Action {
        self.sent = Some(command);
        self.stands =
            (command == Command::STOP).then(|| (self.stands.map_or(now, |(since, _)| since), now));
        Action::Command { command, stamp_ns }
    }

    /// A zero, if the wheels may turn and must not, or have just been stopped.
    fn zero_due(&mut self, now: Duration) -> Option<Action> {
        let is_due = match (self.sent, self.stands) {
            (None, _) => true,
            (Some(_), Some((since, published))) => {
                now.saturating_sub(published) >= REPEAT_PERIOD
                    && now.saturating_sub(since) <= NODE_TIMEOUT
            }
            (Some(_), None) => self.gate.drive(now) == Command::STOP,
        };
        is_due.then(|| self.publish(Command::STOP, None, now))
    }
}

#[cfg(test)]
mod tests {
    use rsrs_core::draw::Key;
    use rsrs_core::robot::controller::state_machine::Memory;
    use rsrs_core::robot::controller::{self, ControllerParameters, Reaction};

    use super::super::{Controller, Settings, Stamp};
    use super::*;
    use crate::message::{Echo, Lease, LeaseState, RobotState};
    use crate::timing::LEASE_DURATION;

    const SETTINGS: Settings = Settings {
        controller: controller::Controller::Parameters(ControllerParameters::mirrored(0.15, 0.75)),
        transition_key: Key { low: 0, high: 0 },
        start: Memory { state: 0, periods: 0, count: 0 },
        stamp: Stamp::Wall,
        reaction: Reaction::ToDetections,
    };
    const LEFT: (f64, f64) = (0.15, 0.75);
    const ZERO: (f64, f64) = (0.0, 0.0);

    /// A controller, and what came out of it last.
    struct Robot1 {
        controller: Controller,
        counter: u64,
        now: Duration,
    }

    impl Robot1 {
        fn new() -> Self {
            let timeout = Duration::from_millis(325);
            let controller = Controller::holding_lease("robot_1", SETTINGS, timeout);
            Self { controller, counter: 0, now: Duration::from_secs(9) }
        }

        /// What it publishes as velocity commands when this happens, so long after the last event.
        fn after(&mut self, milliseconds: u64, event: Event) -> Vec<(f64, f64)> {
            self.now += Duration::from_millis(milliseconds);
            let mut commands = Vec::new();
            for action in self.controller.on_event(event, self.now) {
                match action {
                    Action::Command { command, .. } => {
                        commands.push((command.speed_m_s, command.turn_rate_rad_s));
                    }
                    Action::GateStatus(status) => self.counter = status.counter,
                    Action::Status(_) => {}
                }
            }
            commands
        }

        fn lease(&self, state: LeaseState) -> Event {
            let echo = Echo { robot: "robot_1".to_owned(), counter: self.counter };
            Event::Lease(Lease {
                run_id: "run".to_owned(),
                epoch: 1,
                state,
                parameter_digest: SETTINGS.controller.digest(),
                robots: vec![echo],
            })
        }

        fn drive(&mut self) {
            self.after(0, Event::Tick);
            self.after(1_200, Event::Tick);
            self.after(10, Event::Detection(false));
            let armed = self.lease(LeaseState::Armed);
            self.after(10, armed);
            let running = self.lease(LeaseState::Running);
            self.after(10, running);
            assert_eq!(self.after(10, Event::Detection(true)), [LEFT]);
        }
    }

    #[test]
    fn without_a_lease_detections_are_answered_with_zeros() {
        let mut robot = Robot1::new();

        assert_eq!(
            robot.after(0, Event::Tick),
            [ZERO],
            "an earlier process may have left it driving"
        );
        assert_eq!(robot.after(10, Event::Detection(true)), [ZERO]);
        assert_eq!(robot.after(5_000, Event::Tick), [], "no other robot is disturbed for long");
    }

    #[test]
    fn a_lease_that_runs_out_ends_in_zeros_that_are_repeated_for_a_second() {
        let mut robot = Robot1::new();
        robot.drive();
        assert_eq!(robot.after(130, Event::Detection(true)), [LEFT]);

        let mut zeros = Vec::new();
        for beat in 0..30 {
            let published = robot.after(100, Event::Detection(true));
            zeros.extend(published.iter().filter(|published| **published == ZERO).map(|_| beat));
            assert!(published != [LEFT] || beat < 5, "{beat}");
        }

        let within = usize::try_from(LEASE_DURATION.as_millis() / 100).unwrap();
        assert!(zeros[0] <= within && zeros.len() > 20, "{zeros:?}");
        let state = robot.controller.gate().unwrap().state(robot.now);
        assert_eq!(state, RobotState::Stopped);
    }

    #[test]
    fn a_sensor_that_falls_silent_ends_in_zeros_that_end() {
        let mut robot = Robot1::new();
        robot.drive();

        let mut published = Vec::new();
        for _ in 0..150 {
            let running = robot.lease(LeaseState::Running);
            published.extend(robot.after(10, running));
            published.extend(robot.after(10, Event::Tick));
        }

        assert!(
            published.iter().all(|published| *published == ZERO)
                && (9..=12).contains(&published.len()),
            "{published:?}"
        );
    }

    #[test]
    fn a_sensor_that_falls_silent_is_a_fault_that_its_return_does_not_undo_in_the_run() {
        let mut robot = Robot1::new();
        robot.drive();

        for _ in 0..11 {
            let running = robot.lease(LeaseState::Running);
            robot.after(100, running);
        }
        let gate = robot.controller.gate().unwrap();
        assert_eq!(gate.state(robot.now), RobotState::Fault);
        assert_eq!(gate.latched(), Some("hardware fault: no detection received for more than 1 s"));

        let running = robot.lease(LeaseState::Running);
        robot.after(10, running);
        assert_eq!(robot.after(10, Event::Detection(true)), [ZERO]);
        assert_eq!(robot.controller.gate().unwrap().state(robot.now), RobotState::Stopped);
    }

    #[test]
    fn a_robot_that_never_detected_anything_is_in_fault_until_it_does() {
        let mut robot = Robot1::new();
        robot.after(0, Event::Tick);
        robot.after(1_001, Event::Tick);
        assert_eq!(robot.controller.gate().unwrap().state(robot.now), RobotState::Fault);

        robot.after(10, Event::Detection(false));

        assert_eq!(robot.controller.gate().unwrap().state(robot.now), RobotState::Idle);
    }

    #[test]
    fn parameters_that_are_changed_end_in_zeros() {
        let mut robot = Robot1::new();
        robot.drive();

        let controller = ControllerParameters::mirrored(0.1, 0.75).into();
        let settings = Settings { controller, ..SETTINGS };

        assert_eq!(robot.after(5, Event::Parameters(settings)), [ZERO]);
        assert_eq!(robot.after(5, Event::Detection(true)), [ZERO]);
    }
}
