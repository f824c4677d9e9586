//! All machines of a fleet in one process, over the fake network, under the eyes of witnesses.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use rsrs_core::controller::{Command, ControllerParameters};
use rsrs_fleet::controller::{self, Controller, Settings, Stamp};
use rsrs_fleet::preflight::Expected;
use rsrs_fleet::robot::{self, Robot, RobotOptions};
use rsrs_fleet::runner::{self, Outcome, Pace, Runner, RunnerOptions, Target};
use rsrs_fleet::stopper::{self, Stopper, Word};

use crate::network::{Message, Network, Node};
use crate::scenario::{LAST_HAPPENING_MS, N_ROBOTS, Scenario};
use crate::witness::Witness;

mod stopping;

pub use stopping::Stop;

const WANTED: ControllerParameters =
    ControllerParameters { speed_m_s: 0.15, turn_rate_rad_s: 0.75 };
const DEFAULTS: ControllerParameters =
    ControllerParameters { speed_m_s: 0.05, turn_rate_rad_s: 0.25 };
const STEP_MS: u64 = 5;
const PERIOD_MS: u64 = 130;
const LEASE_MS: u64 = 500;

/// How a scenario went.
#[derive(Debug, Default)]
pub struct Story {
    /// Control steps in which some robot moved.
    pub moving_steps: u64,
    /// By runner, how it ended; runners that crashed have none.
    pub outcomes: BTreeMap<usize, Outcome>,
    /// How each stop and release ended, when, and what came of it for each robot.
    pub stops: Vec<Stop>,
}

struct Fleet {
    scenario: Scenario,
    now_ms: u64,
    network: Network,
    robots: Vec<Robot>,
    witnesses: Vec<Witness>,
    controllers: Vec<Controller>,
    runners: BTreeMap<usize, Runner>,
    /// Who stops or releases now, and since when.
    stopper: Option<(Stopper, u64)>,
    /// Answers of the machinery around each runner, which is on its own host.
    answers: VecDeque<(usize, runner::Event)>,
    open_bags: BTreeMap<usize, bool>,
    /// When the last runner died or finished.
    orphaned_ms: Option<u64>,
    story: Story,
}

/// Plays a scenario to its end.
pub fn play(scenario: Scenario) -> Result<Story, String> {
    let mut fleet = Fleet::new(scenario);
    for step in 0..30_000 / STEP_MS {
        fleet.now_ms = step * STEP_MS;
        fleet.step();
        fleet.judge()?;
        if fleet.is_over() {
            break;
        }
    }
    if let Some(runner) = fleet.runners.keys().next() {
        return Err(format!("runner {runner} has not finished after 30 s"));
    }
    match fleet.open_bags.iter().find(|(_, open)| **open) {
        Some((runner, _)) => Err(format!("the bag of runner {runner} is still open")),
        None => Ok(fleet.story),
    }
}

fn name(robot: usize) -> String {
    format!("robot_{}", robot + 1)
}

fn new_robot(robot: usize) -> Robot {
    Robot::new(RobotOptions {
        name: name(robot),
        command_timeout: Duration::from_millis(325),
        lapse_grace: Duration::ZERO,
    })
}

fn new_controller(robot: usize) -> Controller {
    Controller::new(&name(robot), Settings { parameters: DEFAULTS, stamp: Stamp::Wall })
}

impl Fleet {
    fn new(scenario: Scenario) -> Self {
        let mut fleet = Self {
            now_ms: 0,
            network: Network::new(scenario.seed, scenario.faults.clone()),
            robots: (0..N_ROBOTS).map(new_robot).collect(),
            witnesses: vec![Witness::default(); N_ROBOTS],
            controllers: (0..N_ROBOTS).map(new_controller).collect(),
            runners: BTreeMap::new(),
            stopper: None,
            answers: VecDeque::new(),
            open_bags: BTreeMap::new(),
            orphaned_ms: None,
            story: Story::default(),
            scenario,
        };
        fleet.start_runner(0);
        fleet
    }

    fn start_runner(&mut self, runner: usize) {
        let options = RunnerOptions {
            run_id: format!("run {runner}"),
            expected: Expected { robots: (0..N_ROBOTS).map(name).collect(), ..Expected::default() },
            controller: WANTED,
            simulator_digest: 0,
            pace: Pace::RealTime { duration: Duration::from_secs(3) },
            robot_lost: self.scenario.robot_lost,
            countdown: Duration::from_millis(self.scenario.countdown_ms),
            start: None,
        };
        self.runners.insert(runner, Runner::new(options));
        self.orphaned_ms = None;
    }

    /// Every host has its own clock; none is compared with another.
    fn local(&self, node: Node) -> Duration {
        let offset_ms = match node {
            Node::Robot(robot) | Node::Controller(robot) => 1_000_000 * (robot as u64 + 1),
            Node::Runner(runner) => 77_000 * runner as u64,
            Node::Stopper => 5,
        };
        Duration::from_millis(self.now_ms + offset_ms)
    }

    fn step(&mut self) {
        self.happenings();
        for (from, to, message) in self.network.arrivals(self.now_ms) {
            self.deliver(from, to, message);
        }
        while let Some((runner, event)) = self.answers.pop_front() {
            self.tell_runner(runner, event);
        }
        for robot in 0..N_ROBOTS {
            self.tell_robot(robot, robot::Event::Tick);
            self.tell_controller(robot, controller::Event::Tick);
            if self.now_ms.is_multiple_of(PERIOD_MS) {
                let detected = (self.now_ms / PERIOD_MS + robot as u64).is_multiple_of(3);
                self.tell_controller(robot, controller::Event::Detection(detected));
            }
        }
        let runners: Vec<_> = self.runners.keys().copied().collect();
        for runner in runners {
            self.tell_runner(runner, runner::Event::Tick);
        }
        self.tell_stopper(stopper::Event::Tick);
    }

    fn happenings(&mut self) {
        let now = Some(self.now_ms / STEP_MS);
        let steps = |at_ms: Option<u64>| at_ms.map(|at_ms| at_ms / STEP_MS);
        let scenario = self.scenario.clone();
        if steps(scenario.crash_ms) == now && self.runners.remove(&0).is_some() {
            // Nobody closes a dead runner's bag; it is recovered later.
            self.open_bags.remove(&0);
            self.orphan();
        }
        if steps(scenario.second_runner_ms) == now {
            self.start_runner(1);
        }
        if let Some((robot, at_ms)) = scenario.controller_reboot_ms
            && steps(Some(at_ms)) == now
        {
            self.controllers[robot] = new_controller(robot);
        }
        if let Some((robot, at_ms)) = scenario.robot_reboot_ms
            && steps(Some(at_ms)) == now
        {
            self.robots[robot] = new_robot(robot);
            self.witnesses[robot].reboot();
        }
        if steps(scenario.interrupt_ms) == now {
            let reason = "interrupted".to_owned();
            self.tell_runner(0, runner::Event::Interrupt { reason });
        }
        for (at_ms, word) in
            [(scenario.stop_ms, Word::Engage), (scenario.release_ms, Word::Release)]
        {
            if steps(at_ms) == now {
                self.stopper = Some((Stopper::new(word), self.now_ms));
                // As from a fleet file: a robot that is out of reach should be named.
                for robot in 0..N_ROBOTS {
                    self.tell_stopper(stopper::Event::Found { robot: name(robot) });
                }
            }
        }
        if scenario.e_stop_ms.is_some_and(|at_ms| self.now_ms >= at_ms)
            && self.now_ms.is_multiple_of(100)
        {
            for robot in 0..N_ROBOTS {
                self.send(Node::Runner(1), Node::Robot(robot), &Message::EStop(true));
            }
            self.send(Node::Runner(1), Node::Runner(0), &Message::EStop(true));
        }
    }

    /// Whether nothing more will happen, and late messages have had the time to do their harm.
    fn is_over(&self) -> bool {
        let last_ms = self.scenario.second_runner_ms.max(self.scenario.release_ms);
        self.now_ms > LAST_HAPPENING_MS.max(last_ms.unwrap_or(0))
            && self.stopper.is_none()
            && self.orphaned_ms.is_some_and(|at_ms| self.now_ms > at_ms + 2_000)
    }

    fn orphan(&mut self) {
        if self.runners.is_empty() {
            self.orphaned_ms = Some(self.now_ms);
        }
    }

    fn send(&mut self, from: Node, to: Node, message: &Message) {
        self.network.send(self.now_ms, from, to, message);
    }

    fn deliver(&mut self, from: Node, to: Node, message: Message) {
        match (to, message, from) {
            (Node::Robot(robot), Message::Lease(lease), _) => {
                self.witnesses[robot].lease(&lease, &name(robot));
                self.tell_robot(robot, robot::Event::Lease(lease));
            }
            (Node::Robot(robot), Message::ControllerStatus(status), _) => {
                let parameter_digest = status.parameter_digest;
                self.witnesses[robot].controller(parameter_digest);
                self.tell_robot(robot, robot::Event::Controller { parameter_digest });
            }
            (Node::Robot(robot), Message::Command(command), _) => {
                self.tell_robot(robot, robot::Event::Command(command));
            }
            (Node::Robot(robot), Message::EStop(engaged), _) => {
                if engaged {
                    self.witnesses[robot].e_stop_engaged(self.now_ms);
                } else {
                    self.witnesses[robot].e_stop_released();
                }
                self.tell_robot(robot, robot::Event::EStop(engaged));
            }
            (Node::Controller(robot), Message::Lease(lease), _) => {
                self.tell_controller(robot, controller::Event::Lease(lease));
            }
            (Node::Runner(runner), Message::Lease(lease), _) => {
                self.tell_runner(runner, runner::Event::LeaseHeard(lease));
            }
            (Node::Runner(runner), Message::EStop(engaged), _) => {
                self.tell_runner(runner, runner::Event::EStop(engaged));
            }
            (Node::Runner(runner), Message::RobotStatus(status), Node::Robot(robot)) => {
                let robot = name(robot);
                self.tell_runner(runner, runner::Event::RobotStatus { robot, status });
            }
            (Node::Runner(runner), Message::ControllerStatus(status), Node::Controller(robot)) => {
                let robot = name(robot);
                self.tell_runner(runner, runner::Event::ControllerStatus { robot, status });
            }
            (Node::Stopper, Message::RobotStatus(status), Node::Robot(robot)) => {
                self.tell_stopper(stopper::Event::Status { robot: name(robot), status });
            }
            (to, message, from) => panic!("{message:?} from {from:?} to {to:?}"),
        }
    }

    fn tell_robot(&mut self, robot: usize, event: robot::Event) {
        let node = Node::Robot(robot);
        let now = self.local(node);
        if let Some(status) = self.robots[robot].on_event(event, now) {
            self.witnesses[robot].sent(&status, self.now_ms);
            let message = Message::RobotStatus(status);
            for to in [Node::Runner(0), Node::Runner(1), Node::Stopper] {
                self.send(node, to, &message);
            }
        }
    }

    fn tell_controller(&mut self, robot: usize, event: controller::Event) {
        let node = Node::Controller(robot);
        let now = self.local(node);
        for action in self.controllers[robot].on_event(event, now) {
            match action {
                controller::Action::Command { command, .. } => {
                    self.send(node, Node::Robot(robot), &Message::Command(command));
                }
                controller::Action::Status(status) => {
                    let message = Message::ControllerStatus(status);
                    for to in [Node::Robot(robot), Node::Runner(0), Node::Runner(1)] {
                        self.send(node, to, &message);
                    }
                }
            }
        }
    }

    fn tell_runner(&mut self, runner: usize, event: runner::Event) {
        let node = Node::Runner(runner);
        let now = self.local(node);
        let Some(machine) = self.runners.get_mut(&runner) else { return };
        for action in machine.on_event(event, now) {
            self.act(runner, action);
        }
    }

    fn act(&mut self, runner: usize, action: runner::Action) {
        match action {
            runner::Action::PublishLease(lease) => {
                let message = Message::Lease(lease);
                for robot in 0..N_ROBOTS {
                    self.send(Node::Runner(runner), Node::Robot(robot), &message);
                    self.send(Node::Runner(runner), Node::Controller(robot), &message);
                }
                self.send(Node::Runner(runner), Node::Runner(1 - runner), &message);
            }
            runner::Action::Configure(target) => {
                let result = self.configure(&target);
                self.answers.push_back((runner, runner::Event::ParametersSet { target, result }));
            }
            runner::Action::ReadBack(target) => {
                let result = Ok(self.read_back(&target));
                self.answers.push_back((runner, runner::Event::ReadBack { target, result }));
            }
            runner::Action::OpenRecorder => {
                self.open_bags.insert(runner, true);
                self.answers.push_back((runner, runner::Event::RecorderReady));
            }
            runner::Action::CloseRecorder => {
                self.open_bags.insert(runner, false);
                self.answers.push_back((runner, runner::Event::RecorderClosed));
            }
            runner::Action::Say(_) => {}
            runner::Action::Finish { outcome, .. } => {
                self.story.outcomes.insert(runner, outcome);
                self.runners.remove(&runner);
                self.orphan();
            }
        }
    }

    fn index(target: &Target) -> usize {
        let is_target = |robot: &usize| *target == Target::Robot(name(*robot));
        (0..N_ROBOTS).find(is_target).expect("runners are given these names only")
    }

    fn configure(&mut self, target: &Target) -> Result<(), String> {
        let robot = Self::index(target);
        if self.scenario.liar == Some(robot) {
            return Ok(());
        }
        if self.controllers[robot].is_armed(self.local(Node::Controller(robot))) {
            return Err("read-only while armed".to_owned());
        }
        let settings = Settings { parameters: WANTED, stamp: Stamp::Wall };
        self.tell_controller(robot, controller::Event::Parameters(settings));
        Ok(())
    }

    fn read_back(&self, target: &Target) -> u64 {
        let robot = Self::index(target);
        if self.scenario.liar == Some(robot) {
            return WANTED.digest();
        }
        self.controllers[robot].settings().parameters.digest()
    }

    /// The invariants of the protocol.
    fn judge(&mut self) -> Result<(), String> {
        let mut epochs = Vec::new();
        for robot in 0..N_ROBOTS {
            if self.robots[robot].drive(self.local(Node::Robot(robot))) == Command::STOP {
                continue;
            }
            let epoch = self.robots[robot].epoch();
            epochs.push(epoch);
            self.witnesses[robot]
                .moves(epoch, self.now_ms)
                .map_err(|violation| format!("{}: {violation}", name(robot)))?;
            if self.orphaned_ms.is_some_and(|at_ms| self.now_ms > at_ms + LEASE_MS) {
                return Err(format!("{} moves without any runner alive", name(robot)));
            }
            if self.scenario.liar.is_some_and(|liar| liar == robot) {
                return Err(format!("{} moves with unconfirmed parameters", name(robot)));
            }
        }
        self.judge_stop()?;
        if epochs.iter().any(|epoch| *epoch != epochs[0]) {
            return Err(format!("robots move in several epochs at once: {epochs:?}"));
        }
        self.story.moving_steps += u64::from(!epochs.is_empty());
        Ok(())
    }
}
