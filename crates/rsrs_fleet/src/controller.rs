//! The controller node: one command for each detection.
//!
//! Where the robot has no gate of ours, the controller holds the lease: see `lease_gate`.

use std::collections::VecDeque;
use std::time::Duration;

use rsrs_core::draw::Key;
use rsrs_core::robot::controller::state_machine::{Memory, Program};
use rsrs_core::robot::controller::{self, Command, Reaction};
use rsrs_core::robot::sensor::Readings;
use rsrs_msgs::topics;

use crate::e_stop::Message;
use crate::epoch;
use crate::heartbeat::Heartbeat;
use crate::message::{Lease, LeaseState, RobotState, Status, StopCause, armed_reason};
use crate::robot::Robot;
use crate::timing::{DEAD_PROCESS_TIMEOUT, LEASE_DURATION, SENSOR_TIMEOUT};

mod lease_gate;

use lease_gate::LeaseGate;

/// What happens to a controller.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// A reading of the sensor: whether it detects something.
    Detection(bool),
    /// A reading of a further sensor.
    Reading {
        /// Which, by its place among the readings of the controller; above 0.
        reading: usize,
        /// Whether it is true.
        is_true: bool,
    },
    /// This step begins by the simulator's clock, in nanoseconds of simulated time.
    Clock(u64),
    /// A lease arrived.
    Lease(Lease),
    /// Parameters were set, from the fleet file or by a client.
    Parameters(Settings),
    /// A message on one of the e-stop's topics; only the holder of the lease needs it.
    EStop(Message),
    /// Time passed.
    Tick,
}

/// What a controller is set to.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// What decides.
    pub controller: controller::Controller,
    /// Key of the draws of its transitions, if it has states.
    pub transition_key: Key,
    /// Where it starts in a run, if it has states.
    pub start: Memory,
    /// Whether commands carry the stamp of the simulator's clock (lockstep) or wall-clock time.
    pub stamp: Stamp,
    /// Whether it decides, or is being measured; in the digest of its parameters.
    pub reaction: Reaction,
}

/// Which time a command carries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stamp {
    /// The time at which it is sent.
    Wall,
    /// The simulated time of the step whose detection it answers.
    Clock,
}

/// What a controller does.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// Publish a command.
    Command {
        /// The command.
        command: Command,
        /// Its stamp in nanoseconds of simulated time; `None` is the time of sending.
        stamp_ns: Option<u64>,
    },
    /// Publish a status.
    Status(Status),
    /// Publish a status in place of the gate that the robot does not have.
    GateStatus(Status),
}

/// The controller of one robot.
#[derive(Clone, Debug)]
pub struct Controller {
    robot: String,
    settings: Settings,
    /// What decides, ready to run, and its name in leases and statuses.
    program: Program,
    digest: u64,
    /// Where it is in this run.
    memory: Memory,
    bound: Option<Binding>,
    /// Detections that wait for their step's clock, and clocks that wait for their detection.
    detections: VecDeque<bool>,
    clocks: VecDeque<u64>,
    /// Of the readings that it needs besides.
    further: Vec<Further>,
    beat: Heartbeat<RobotState>,
    silence: Silence,
    /// The lease, if no gate in front of the wheels holds it.
    lease_gate: Option<LeaseGate>,
}

/// A reading besides `detection`, as it came.
#[derive(Clone, Debug, Default)]
struct Further {
    /// Those that wait for the detection of their step, in lockstep.
    waiting: VecDeque<bool>,
    /// The newest, elsewhere.
    newest: Option<bool>,
    /// Detections since that came.
    n_behind: u32,
    /// When the first detection came without any.
    missed_since: Option<Duration>,
}

/// Why a robot is not commanded of which a further sensor is silent.
pub fn nothing_on(reading: &str) -> String {
    format!("nothing on `{}/{reading}`: no command", topics::DETECTION.name)
}

/// A further sensor that was silent for so many detections is silent: its robot is not commanded any more.
pub const MOST_BEHIND: u32 = 3;

/// So long a process that has just started publishes no command, unless a run arms it.
#[derive(Clone, Copy, Debug, Default)]
struct Silence {
    length: Duration,
    began: Option<Duration>,
}

#[derive(Clone, Debug)]
struct Binding {
    run_id: String,
    epoch: u64,
    state: LeaseState,
    received: Duration,
}

impl Controller {
    /// A controller that belongs to no run.
    pub fn new(robot: &str, settings: Settings) -> Self {
        Self {
            robot: robot.to_owned(),
            program: settings.controller.program(),
            digest: settings.controller.digest_with(settings.reaction),
            further: further(&settings),
            memory: settings.start,
            settings,
            bound: None,
            detections: VecDeque::new(),
            clocks: VecDeque::new(),
            beat: Heartbeat::default(),
            silence: Silence::default(),
            lease_gate: None,
        }
    }

    /// A controller that belongs to no run, of a robot without a gate: it holds the lease itself,
    /// and its last decision is stale at the age of `command_timeout`.
    pub fn holding_lease(robot: &str, settings: Settings, command_timeout: Duration) -> Self {
        let lease_gate = Some(LeaseGate::new(robot, command_timeout));
        Self { lease_gate, ..Self::new(robot, settings) }
    }

    /// The same controller, that counts its statuses up from another number, as
    /// [`Robot::counting_from`] does.
    #[must_use]
    pub fn counting_from(mut self, counter: u64) -> Self {
        self.beat = Heartbeat::from(counter);
        self.lease_gate = self.lease_gate.map(|lease_gate| lease_gate.counting_from(counter));
        self
    }

    /// The same controller, in a process that has just started: until a run arms it, or [`DEAD_PROCESS_TIMEOUT`]
    /// has passed since the first event, it publishes no command. A gate may still trust what an
    /// earlier process reported of its parameters, and these have others.
    #[must_use]
    pub fn of_a_new_process(self) -> Self {
        let silence = Silence { length: DEAD_PROCESS_TIMEOUT, began: None };
        Self { silence, lease_gate: self.lease_gate.map(LeaseGate::of_a_new_process), ..self }
    }

    /// The gate in the controller; `None` where the robot has one of its own.
    pub fn gate(&self) -> Option<&Robot> {
        self.lease_gate.as_ref().map(LeaseGate::gate)
    }

    /// What the controller is set to.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Whether parameters may change: not while a run holds them.
    pub fn is_armed(&self, now: Duration) -> bool {
        self.bound.as_ref().is_some_and(|bound| {
            matches!(bound.state, LeaseState::Armed | LeaseState::Running)
                && now.saturating_sub(bound.received) <= LEASE_DURATION
        })
    }

    /// Takes an event.
    pub fn on_event(&mut self, event: Event, now: Duration) -> Vec<Action> {
        let Some(mut lease_gate) = self.lease_gate.take() else { return self.react(event, now) };
        let wanted = self.react(event.clone(), now);
        let actions = lease_gate.hold(&event, self.status(now), wanted, now);
        self.lease_gate = Some(lease_gate);
        actions
    }

    fn react(&mut self, event: Event, now: Duration) -> Vec<Action> {
        let mut actions = Vec::new();
        self.silence.began.get_or_insert(now);
        match event {
            Event::Detection(detected) => {
                self.detections.push_back(detected);
                self.answer(&mut actions, now);
            }
            Event::Reading { reading, is_true } => {
                let (place, stamp) = (reading.checked_sub(1), self.settings.stamp);
                if let Some(further) = place.and_then(|place| self.further.get_mut(place)) {
                    further.take(is_true, stamp);
                    self.answer(&mut actions, now);
                }
            }
            Event::Clock(stamp_ns) => {
                if self.settings.stamp == Stamp::Clock {
                    self.clocks.push_back(stamp_ns);
                    self.answer(&mut actions, now);
                }
            }
            Event::Lease(lease) => self.on_lease(&lease, now),
            Event::Parameters(settings) => {
                self.program = settings.controller.program();
                self.digest = settings.controller.digest_with(settings.reaction);
                self.settings = settings;
                self.begin();
                self.beat.hurry();
            }
            // What waited for the end of its silence.
            Event::Tick => self.answer(&mut actions, now),
            Event::EStop(_) => {}
        }
        actions.extend(self.status_due(now).map(Action::Status));
        actions
    }

    /// The further reading that keeps it from commanding, by its place among all: elsewhere than in lockstep one
    /// that did not come with the last detections, or, where none came so far, for [`SENSOR_TIMEOUT`].
    pub fn silent_reading(&self, now: Duration) -> Option<usize> {
        let is_free = self.settings.stamp == Stamp::Wall;
        self.further.iter().position(|it| is_free && it.is_missing(now)).map(|place| place + 1)
    }

    /// One command for each detection; in lockstep the nth detection belongs to the nth clock, and the nth of each
    /// further reading.
    fn answer(&mut self, actions: &mut Vec<Action>, now: Duration) {
        if self.is_silent(now) {
            // In lockstep the world waits for each answer; elsewhere an old one is useless.
            if self.settings.stamp == Stamp::Wall {
                self.detections.clear();
            }
            return;
        }
        while let Some(detected) = self.detections.front().copied() {
            let stamp_ns = match self.settings.stamp {
                Stamp::Wall => None,
                Stamp::Clock if self.further.iter().any(|it| it.waiting.is_empty()) => return,
                Stamp::Clock => match self.clocks.pop_front() {
                    Some(stamp_ns) => Some(stamp_ns),
                    None => return,
                },
            };
            self.detections.pop_front();
            let Some(found) = self.reported(detected, now) else { continue };
            let command = self.decide(found, now);
            actions.push(Action::Command { command, stamp_ns });
        }
    }

    /// What all sensors report with a detection; `None` where one of them is silent.
    #[expect(clippy::fn_params_excessive_bools, reason = "binary is what a reading is")]
    fn reported(&mut self, detected: bool, now: Duration) -> Option<Readings> {
        let mut found = Readings::from(detected);
        let mut is_whole = true;
        for (place, further) in self.further.iter_mut().enumerate() {
            let reading = match self.settings.stamp {
                Stamp::Clock => further.waiting.pop_front(),
                Stamp::Wall => {
                    further.n_behind = further.n_behind.saturating_add(1);
                    further.missed_since.get_or_insert(now);
                    further.newest.filter(|_| !further.is_silent())
                }
            };
            found.set(place + 1, reading.unwrap_or_default());
            is_whole &= reading.is_some();
        }
        is_whole.then_some(found)
    }

    /// The command for what is reported. In lockstep each step is one of the run; elsewhere a robot that does not
    /// move yet stays at the start.
    fn decide(&mut self, found: Readings, now: Duration) -> Command {
        let is_of_run =
            self.settings.stamp == Stamp::Clock || self.state(now) == RobotState::Moving;
        let mut start = self.settings.start;
        let memory = if is_of_run { &mut self.memory } else { &mut start };
        self.program.decide(found, memory, self.settings.transition_key)
    }

    fn is_silent(&self, now: Duration) -> bool {
        let Silence { length, began } = self.silence;
        self.bound.is_none() && began.is_some_and(|began| now.saturating_sub(began) < length)
    }

    fn on_lease(&mut self, lease: &Lease, now: Duration) {
        if lease.echo(&self.robot).is_none() {
            return;
        }
        let highest = self.bound.as_ref().map_or(0, |bound| bound.epoch);
        let new_run = lease.epoch > highest
            && lease.state == LeaseState::Armed
            && epoch::check(lease.epoch, highest).is_ok();
        let same_run = self
            .bound
            .as_ref()
            .is_some_and(|bound| bound.epoch == lease.epoch && bound.run_id == lease.run_id);
        if new_run {
            self.begin();
        }
        if new_run || same_run {
            self.bound = Some(Binding {
                run_id: lease.run_id.clone(),
                epoch: lease.epoch,
                state: lease.state,
                received: now,
            });
        }
    }

    /// Steps and states of an earlier run are none of the next.
    fn begin(&mut self) {
        self.detections.clear();
        self.clocks.clear();
        self.further = further(&self.settings);
        self.memory = self.settings.start;
    }

    fn state(&self, now: Duration) -> RobotState {
        match &self.bound {
            None => RobotState::Idle,
            Some(bound) if bound.state == LeaseState::Stopped => RobotState::Stopped,
            Some(_) if !self.is_armed(now) => RobotState::Stopped,
            Some(bound) if bound.state == LeaseState::Running => RobotState::Moving,
            Some(_) => RobotState::Armed,
        }
    }

    fn status_due(&mut self, now: Duration) -> Option<Status> {
        self.beat.due(self.state(now), now)?;
        Some(self.status(now))
    }

    /// The status that it publishes.
    fn status(&self, now: Duration) -> Status {
        let state = self.state(now);
        let run_id = self.bound.as_ref().map_or_else(String::new, |bound| bound.run_id.clone());
        let (stop_cause, stop_reason) = match state {
            RobotState::Armed => (StopCause::Waiting, armed_reason(&run_id)),
            _ => (StopCause::None, String::new()),
        };
        Status {
            counter: self.beat.counter(),
            epoch: self.bound.as_ref().map_or(0, |bound| bound.epoch),
            run_id,
            parameter_digest: self.digest,
            state,
            stop_cause,
            stop_reason,
            battery_v: f32::NAN,
        }
    }
}

/// None has come of what a controller needs besides `detection`.
fn further(settings: &Settings) -> Vec<Further> {
    settings.controller.reading_names().further().map(|_| Further::default()).collect()
}

impl Further {
    #[expect(clippy::fn_params_excessive_bools, reason = "binary is what a reading is")]
    fn take(&mut self, is_true: bool, stamp: Stamp) {
        match stamp {
            Stamp::Clock => self.waiting.push_back(is_true),
            Stamp::Wall => (self.newest, self.n_behind) = (Some(is_true), 0),
        }
    }

    fn is_silent(&self) -> bool {
        self.newest.is_none() || self.n_behind > MOST_BEHIND
    }

    /// Whether it is silent, and not just about to come for the first time: until the two have found each other in
    /// the network, detections come without it.
    fn is_missing(&self, now: Duration) -> bool {
        let has_waited =
            self.missed_since.is_some_and(|since| now.saturating_sub(since) >= SENSOR_TIMEOUT);
        self.is_silent() && (self.newest.is_some() || has_waited)
    }
}

#[cfg(test)]
mod tests {
    use rsrs_core::robot::controller::ControllerParameters;
    use rsrs_core::robot::controller::state_machine::StateMachine;

    use super::*;
    use crate::message::Echo;

    fn controller(stamp: Stamp) -> Controller {
        let settings = Settings {
            controller: ControllerParameters::mirrored(0.15, 0.75).into(),
            transition_key: Key::from_bits(0),
            start: Memory::default(),
            stamp,
            reaction: Reaction::ToDetections,
        };
        Controller::new("robot_1", settings)
    }

    fn commands(actions: &[Action]) -> Vec<(f64, Option<u64>)> {
        actions
            .iter()
            .filter_map(|action| match action {
                Action::Command { command, stamp_ns } => Some((command.turn_rate_rad_s, *stamp_ns)),
                Action::Status(_) | Action::GateStatus(_) => None,
            })
            .collect()
    }

    #[test]
    fn a_controller_that_was_left_on_a_constant_command_has_another_digest() {
        let deciding = controller(Stamp::Wall).settings().clone();
        let constant = Settings { reaction: Reaction::Constant, ..deciding.clone() };

        let digest = |settings| {
            let actions =
                Controller::new("robot_1", settings).on_event(Event::Tick, Duration::ZERO);
            let [Action::Status(status)] = &actions[..] else { panic!("{actions:?}") };
            status.parameter_digest
        };

        assert_eq!(digest(deciding.clone()), deciding.controller.digest());
        assert_ne!(digest(constant), digest(deciding));
    }

    /// A robot that drives for two periods, and then turns for one.
    fn with_states(stamp: Stamp) -> Controller {
        let json = r#"{"rows":[
            {"state":"drive","command":{"speed_m_s":0.2,"turn_rate_rad_s":0.0},
             "next":[{"state":"turn","probability":1.0,"after_periods":2}]},
            {"state":"turn","command":{"speed_m_s":0.0,"turn_rate_rad_s":1.0},
             "next":[{"state":"drive","probability":1.0,"after_periods":0}]}]}"#;
        of_machine(json, stamp)
    }

    fn of_machine(json: &str, stamp: Stamp) -> Controller {
        let machine = StateMachine::from_json(json).unwrap();
        let settings = controller(stamp).settings().clone();
        let controller = controller::Controller::Machine(machine);
        Controller::new("robot_1", Settings { controller, ..settings })
    }

    #[test]
    fn a_controller_with_states_begins_anew_with_each_run() {
        let mut controller = with_states(Stamp::Wall);
        let lease = |epoch, state| {
            Event::Lease(Lease {
                run_id: format!("run {epoch}"),
                epoch,
                state,
                parameter_digest: 0,
                robots: vec![Echo { robot: "robot_1".to_owned(), counter: 1 }],
            })
        };
        let now = Duration::ZERO;
        let turns = |controller: &mut Controller, n: usize| -> Vec<f64> {
            let answer = |_| commands(&controller.on_event(Event::Detection(false), now))[0].0;
            (0..n).map(answer).collect()
        };

        assert_eq!(turns(&mut controller, 4), [0.0; 4], "who belongs to no run stays at the start");
        controller.on_event(lease(1, LeaseState::Armed), now);
        assert_eq!(turns(&mut controller, 4), [0.0; 4], "nor does time pass before it moves");
        controller.on_event(lease(1, LeaseState::Running), now);
        assert_eq!(turns(&mut controller, 5), [0.0, 0.0, 1.0, 0.0, 0.0]);
        controller.on_event(lease(2, LeaseState::Armed), now);
        controller.on_event(lease(2, LeaseState::Running), now);
        assert_eq!(turns(&mut controller, 3), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn each_detection_has_one_command() {
        let mut controller = controller(Stamp::Wall);

        let left = controller.on_event(Event::Detection(true), Duration::ZERO);
        let right = controller.on_event(Event::Detection(false), Duration::ZERO);

        assert_eq!(commands(&left), [(0.75, None)]);
        assert_eq!(commands(&right), [(-0.75, None)]);
    }

    #[test]
    fn a_process_that_has_just_started_publishes_no_command_until_nobody_trusts_its_predecessor() {
        let early = DEAD_PROCESS_TIMEOUT / 2;

        let mut in_real_time = controller(Stamp::Wall).of_a_new_process();
        in_real_time.on_event(Event::Tick, Duration::ZERO);
        let silent = in_real_time.on_event(Event::Detection(true), early);
        let published = in_real_time.on_event(Event::Detection(false), DEAD_PROCESS_TIMEOUT);
        let mut in_lockstep = controller(Stamp::Clock).of_a_new_process();
        in_lockstep.on_event(Event::Detection(true), Duration::ZERO);
        let waiting = in_lockstep.on_event(Event::Clock(130), early);
        let answered = in_lockstep.on_event(Event::Tick, DEAD_PROCESS_TIMEOUT);

        assert_eq!((commands(&silent), commands(&published)), (vec![], vec![(-0.75, None)]));
        assert_eq!((commands(&waiting), commands(&answered)), (vec![], vec![(0.75, Some(130))]));
    }

    #[test]
    fn a_run_that_arms_a_process_that_has_just_started_gets_its_commands() {
        let mut controller = controller(Stamp::Wall).of_a_new_process();
        let lease = Lease {
            run_id: "run".to_owned(),
            epoch: 1,
            state: LeaseState::Armed,
            parameter_digest: 0,
            robots: vec![Echo { robot: "robot_1".to_owned(), counter: 0 }],
        };

        controller.on_event(Event::Lease(lease), Duration::ZERO);
        let published = controller.on_event(Event::Detection(true), Duration::ZERO);

        assert_eq!(commands(&published), [(0.75, None)]);
    }

    /// A robot that turns one way for a wall, and the other way for a robot; else it drives.
    fn with_two_sensors(stamp: Stamp) -> Controller {
        let json = r#"{"sensors":[["detection"],["wall"]],"rows":[
            {"state":"go","when":{"wall":true},"command":{"speed_m_s":0.0,"turn_rate_rad_s":2.0}},
            {"state":"go","when":{"detection":true},"command":{"speed_m_s":0.0,"turn_rate_rad_s":-1.0}},
            {"state":"go","command":{"speed_m_s":0.2,"turn_rate_rad_s":0.0}}]}"#;
        of_machine(json, stamp)
    }

    #[test]
    fn a_detection_is_answered_with_the_newest_of_each_further_sensor_and_none_that_is_silent() {
        let mut controller = with_two_sensors(Stamp::Wall);
        let now = Duration::ZERO;
        let wall = |is_true| Event::Reading { reading: 1, is_true };
        let mut turns = |event| -> Vec<f64> {
            commands(&controller.on_event(event, now)).into_iter().map(|(turn, _)| turn).collect()
        };

        let nothing: [f64; 0] = [];
        assert_eq!(turns(Event::Detection(true)), nothing, "no wall was reported yet");
        assert_eq!(turns(wall(true)), nothing, "a robot decides once for each detection");
        assert_eq!(turns(Event::Detection(true)), [2.0]);
        turns(wall(false));
        for _ in 0..MOST_BEHIND {
            assert_eq!(turns(Event::Detection(true)), [-1.0]);
        }
        assert_eq!(turns(Event::Detection(true)), nothing, "it is silent");
        assert_eq!(controller.silent_reading(now), Some(1));
        controller.on_event(wall(false), now);
        assert_eq!(controller.silent_reading(now), None);
    }

    #[test]
    fn a_further_sensor_is_missing_when_its_first_message_had_time_to_come() {
        let mut controller = with_two_sensors(Stamp::Wall);
        let first = Duration::from_secs(7);
        let late = first + SENSOR_TIMEOUT;
        let early = late.saturating_sub(Duration::from_millis(1));

        controller.on_event(Event::Tick, Duration::ZERO);
        assert_eq!(controller.silent_reading(first), None, "nothing was to be answered yet");
        controller.on_event(Event::Detection(true), first);
        assert_eq!(controller.silent_reading(early), None);
        assert_eq!(controller.silent_reading(late), Some(1));
        controller.on_event(Event::Reading { reading: 1, is_true: false }, late);
        assert_eq!(controller.silent_reading(late), None);
    }

    #[test]
    fn in_lockstep_the_nth_detection_is_answered_with_the_nth_of_each_further_sensor() {
        let mut controller = with_two_sensors(Stamp::Clock);
        let now = Duration::ZERO;
        let wall = |is_true| Event::Reading { reading: 1, is_true };
        let events = [
            Event::Detection(true),
            Event::Clock(130),
            Event::Detection(false),
            wall(false),
            Event::Clock(260),
            wall(true),
        ];

        let answers: Vec<_> =
            events.into_iter().map(|event| commands(&controller.on_event(event, now))).collect();

        let none = Vec::new;
        let [first, second] = [vec![(-1.0, Some(130))], vec![(2.0, Some(260))]];
        assert_eq!(answers, [none(), none(), none(), first, none(), second]);
    }

    #[test]
    fn in_lockstep_the_nth_detection_carries_the_nth_clock_in_whichever_order_they_come() {
        let mut controller = controller(Stamp::Clock);

        let early = controller.on_event(Event::Detection(true), Duration::ZERO);
        let first = controller.on_event(Event::Clock(130), Duration::ZERO);
        controller.on_event(Event::Clock(260), Duration::ZERO);
        let second = controller.on_event(Event::Detection(false), Duration::ZERO);

        assert_eq!(commands(&early), []);
        assert_eq!(commands(&first), [(0.75, Some(130))]);
        assert_eq!(commands(&second), [(-0.75, Some(260))]);
    }
}
