//! All machines of a fleet in one process, over the fake network, judged by safety oracles.

use std::collections::BTreeMap;
use std::time::Duration;

use rsrs_core::draw::Key;
use rsrs_core::robot::controller::state_machine::Memory;
use rsrs_core::robot::controller::{Command, ControllerParameters, Reaction};
use rsrs_fleet::controller::{Controller, Settings, Stamp};
use rsrs_fleet::e_stop::Locks;
use rsrs_fleet::runner::Outcome;
use rsrs_fleet::stopper::{self, StopCommand, Stopper};

use crate::network::{Delivery, Item, Message, Network, Node};
use crate::safety_oracle::{FASTEST, GLANCE_MS, SafetyOracle, WHEELS_TIMEOUT_MS};
use crate::scenario::{Body, N_BUTTONS, Scenario};

mod controlling;
mod e_stop;
mod robots;
mod runners;
mod scenario_events;
mod simulating;
mod stopping;
mod wheels;

use robots::RobotHost;
use runners::RunnerHost;
use simulating::SimulatorHost;
pub use stopping::Stop;

/// What all runs set.
const WANTED: ControllerParameters =
    ControllerParameters::mirrored(FASTEST.speed_m_s, FASTEST.turn_rate_rad_s);
/// What controllers have before they are set.
const DEFAULTS: ControllerParameters = ControllerParameters::mirrored(0.05, 0.25);
/// As for a period of 130 ms.
const COMMAND_TIMEOUT: Duration = Duration::from_millis(325);
/// The run that is made when all is healed.
pub const LAST_RUNNER: usize = 2;
const N_RUNNERS: usize = LAST_RUNNER + 1;
/// No story takes so much longer than its runs, in milliseconds.
const TOO_LONG_MS: u64 = 60_000;
/// After all is over, for late messages to do their harm, in milliseconds.
const AFTERMATH_MS: u64 = 700;
/// Nodes that are of no robot: room for every one of [`Fleet::slot`].
const N_OTHER_NODES: usize = N_RUNNERS + 3 + N_BUTTONS;

/// How a scenario went.
#[derive(Debug, Default)]
pub struct Story {
    /// How often a gate let a command through.
    pub movements: u64,
    /// How often robots stood because their leases had run out, and went on, by the runners.
    pub n_pauses: usize,
    /// By runner, how it ended; runners that crashed have none.
    pub outcomes: BTreeMap<usize, Outcome>,
    /// How each stop and release ended, when, and what came of it for each robot.
    pub stops: Vec<Stop>,
    /// Attempts to set a parameter, and how many of them were refused.
    pub meddled: (u64, u64),
    /// Runs whose world a person took away after it was confirmed, and which heard of it.
    pub n_without_world: u64,
    /// What happened, line by line, if it is to be printed.
    pub narrative: Vec<String>,
}

/// Whether what happened is to be printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verbosity {
    Nothing,
    Everything,
}

/// A process.
#[derive(Clone, Copy, Debug, Default)]
struct Process {
    is_up: bool,
    incarnation: u32,
    /// Until then it gets no time from its machine.
    stalled_until_ms: u64,
}

struct Fleet {
    scenario: Scenario,
    verbosity: Verbosity,
    now_ms: u64,
    network: Network,
    processes: Vec<Process>,
    robots: Vec<RobotHost>,
    oracles: Vec<SafetyOracle>,
    controllers: Vec<Controller>,
    /// What each controller published on `cmd_vel` last; `None` if its process has not yet.
    mouths: Vec<Option<Command>>,
    /// Until when the last lease of its run that each controller received holds its parameters.
    held_until_ms: Vec<u64>,
    /// Epoch and name of that run.
    held_by: Vec<(u64, String)>,
    runners: BTreeMap<usize, RunnerHost>,
    simulator: Option<SimulatorHost>,
    /// Who stops or releases now, which of it, and since when.
    stopper: Option<(Stopper, StopCommand, u64)>,
    /// What each button publishes; `None` if it is silent.
    buttons: [Option<bool>; N_BUTTONS],
    /// What each gate last published that the e-stop has locked on it; late subscribers receive it
    /// again.
    locks: Vec<Locks>,
    is_healed: bool,
    /// Whether anything was ever published on the e-stop topic.
    e_stop_was_used: bool,
    is_released: bool,
    /// Since when nothing happens any more.
    quiet_ms: Option<u64>,
    story: Story,
}

/// Plays a scenario to its end, or to the first violation of an invariant, with the story so far.
pub fn play(scenario: Scenario, verbosity: Verbosity) -> Result<Story, Box<(String, Story)>> {
    let mut fleet = Fleet::new(scenario, verbosity);
    match fleet.live() {
        Ok(()) => Ok(fleet.story),
        Err(violation) => {
            Err(Box::new((format!("at {} ms: {violation}", fleet.now_ms), fleet.story)))
        }
    }
}

fn name(robot: usize) -> String {
    format!("robot_{}", robot + 1)
}

fn run_id(runner: usize) -> String {
    format!("run {runner}")
}

/// A controller whose process starts now.
fn new_controller(robot: usize, scenario: &Scenario, now_ms: u64) -> Controller {
    let settings = settings(DEFAULTS, scenario.body);
    let controller = if scenario.controller_only[robot] {
        Controller::holding_lease(&name(robot), settings, COMMAND_TIMEOUT)
    } else {
        Controller::new(&name(robot), settings)
    };
    let controller = controller.counting_from(now_ms);
    // At the beginning of a story the fleet has been there for a while.
    if now_ms == 0 { controller } else { controller.of_a_new_process() }
}

/// What a controller is set to in a fleet of such robots.
fn settings(controller: ControllerParameters, body: Body) -> Settings {
    Settings {
        controller: controller.into(),
        transition_key: Key::from_bits(0),
        start: Memory::default(),
        stamp: if body == Body::Lockstep { Stamp::Clock } else { Stamp::Wall },
        reaction: Reaction::ToDetections,
    }
}

impl Fleet {
    fn new(scenario: Scenario, verbosity: Verbosity) -> Self {
        let is_real = scenario.body == Body::Real;
        let n_robots = scenario.n_robots;
        let mut fleet = Self {
            now_ms: 0,
            verbosity,
            network: Network::new(scenario.seed, scenario.faults.clone()),
            processes: vec![Process::default(); 2 * n_robots + N_OTHER_NODES],
            robots: (0..n_robots).map(|robot| RobotHost::new(robot, 0)).collect(),
            oracles: vec![SafetyOracle::new(scenario.body); n_robots],
            controllers: (0..n_robots).map(|robot| new_controller(robot, &scenario, 0)).collect(),
            mouths: vec![None; n_robots],
            held_until_ms: vec![0; n_robots],
            held_by: vec![(0, String::new()); n_robots],
            runners: BTreeMap::new(),
            simulator: (!is_real).then(SimulatorHost::default),
            stopper: None,
            buttons: [None; N_BUTTONS],
            locks: vec![Locks::default(); n_robots],
            is_healed: false,
            e_stop_was_used: scenario.has_button.contains(&true),
            is_released: false,
            quiet_ms: None,
            story: Story::default(),
            scenario,
        };
        for robot in 0..n_robots {
            fleet.switch_on(Node::Controller(robot));
            if is_real {
                fleet.switch_on(Node::Robot(robot));
            }
        }
        if !is_real {
            fleet.switch_on(Node::Simulator);
        }
        for button in 0..N_BUTTONS {
            if fleet.scenario.has_button[button] {
                fleet.buttons[button] = Some(false);
                fleet.switch_on(Node::Button(button));
            }
        }
        for (at_ms, happening) in fleet.scenario.happenings.clone() {
            fleet.network.plan(at_ms.max(1), Item::Happening(happening));
        }
        fleet.start_runner(0);
        fleet
    }

    /// Lets time pass until all is over.
    fn live(&mut self) -> Result<(), String> {
        while !self.is_over() {
            self.now_ms += 1;
            if self.now_ms > self.scenario.run_ms + TOO_LONG_MS {
                let runners: Vec<_> = self.runners.keys().collect();
                return Err(format!("not over: runners {runners:?}"));
            }
            let items = self.network.due(self.now_ms);
            for item in items {
                self.take(item)?;
            }
            self.judge()?;
            self.go_on();
        }
        self.judge_end()
    }

    fn take(&mut self, item: Item) -> Result<(), String> {
        match item {
            Item::Arrival { from, to, message } => {
                let process = self.processes[self.slot(to)];
                if !process.is_up {
                    return Ok(());
                }
                if self.now_ms < process.stalled_until_ms {
                    let item = Item::Arrival { from, to, message };
                    self.network.plan(process.stalled_until_ms, item);
                    return Ok(());
                }
                self.deliver(from, to, message)
            }
            Item::Tick(node, incarnation) => {
                let process = self.processes[self.slot(node)];
                if !process.is_up || process.incarnation != incarnation {
                    return Ok(());
                }
                let again_ms = process.stalled_until_ms.max(self.now_ms + Self::beat_ms(node));
                self.network.plan(again_ms, Item::Tick(node, incarnation));
                if self.now_ms < process.stalled_until_ms { Ok(()) } else { self.tick(node) }
            }
            Item::Answer(runner, event) => self.give_runner(runner, event),
            Item::Happening(happening) => {
                self.note(|| format!("{happening:?}"));
                self.happen(happening)
            }
        }
    }

    /// Every host has its own clock; none is compared with another.
    fn local(&self, node: Node) -> Duration {
        let (offset_ms, ppm) = match self.home(node) {
            Node::Robot(robot) | Node::Controller(robot) => {
                (1_000_000 * (robot as u64 + 1), self.scenario.too_fast_ppm[robot])
            }
            Node::Simulator => (3_000, self.scenario.too_fast_ppm[0]),
            Node::Runner(runner) => (77_000 * runner as u64, 0),
            Node::Stopper | Node::Button(_) | Node::Stranger => (5, 0),
        };
        let ns_per_ms = 1_000_000_u64.checked_add_signed(ppm).expect("clocks are nearly right");
        Duration::from_nanos((offset_ms + self.now_ms) * ns_per_ms)
    }

    /// The process in which a node is.
    fn home(&self, node: Node) -> Node {
        match node {
            Node::Robot(_) if self.scenario.body != Body::Real => Node::Simulator,
            _ => node,
        }
    }

    fn slot(&self, node: Node) -> usize {
        let n_robots = self.scenario.n_robots;
        let others = 2 * n_robots;
        match self.home(node) {
            Node::Robot(robot) => robot,
            Node::Controller(robot) => n_robots + robot,
            Node::Runner(runner) => others + runner,
            Node::Simulator => others + N_RUNNERS,
            Node::Stopper => others + N_RUNNERS + 1,
            Node::Stranger => others + N_RUNNERS + 2,
            Node::Button(button) => others + N_RUNNERS + 3 + button,
        }
    }

    fn beat_ms(node: Node) -> u64 {
        match node {
            Node::Button(_) => 100,
            _ => 20,
        }
    }

    fn tick(&mut self, node: Node) -> Result<(), String> {
        match node {
            Node::Robot(robot) => self.robot_ticks(robot),
            Node::Controller(robot) => {
                self.deliver_to_controller(robot, rsrs_fleet::controller::Event::Tick)
            }
            Node::Runner(runner) => self.runner_ticks(runner),
            Node::Simulator => self.simulator_ticks(),
            Node::Stopper => {
                let present = (0..N_BUTTONS).filter(|button| self.buttons[*button].is_some());
                let present = present.map(|button| self.source(Node::Button(button))).collect();
                self.deliver_to_stopper(stopper::Event::Publishers(present));
                self.deliver_to_stopper(stopper::Event::Tick);
                self.judge_stop()
            }
            Node::Button(button) => {
                if let Some(engaged) = self.buttons[button] {
                    self.publish_e_stop((node, engaged));
                }
                Ok(())
            }
            Node::Stranger => Ok(()),
        }
    }

    fn send(&mut self, from: Node, to: Node, message: Message) {
        let ends = (self.home(from), self.home(to));
        if ends.0 == ends.1 && ends.0 == Node::Simulator {
            return;
        }
        let is_apart = matches!(ends, (Node::Runner(_), Node::Runner(_)))
            && self.scenario.are_runners_apart
            && !self.is_healed;
        if is_apart {
            return;
        }
        if let Node::Runner(runner) = to
            && !self.runners.contains_key(&runner)
        {
            return;
        }
        match self.delivery(&message) {
            Delivery::Reliable => {
                self.network.send_reliably(self.now_ms, from, to, message);
            }
            Delivery::BestEffort => self.network.send(self.now_ms, from, to, message),
            Delivery::Once => self.network.send_once(self.now_ms, from, to, message),
        }
    }

    /// As the table of topics has it: services always, data where a step waits for it.
    fn delivery(&self, message: &Message) -> Delivery {
        let is_lockstep = self.scenario.body == Body::Lockstep;
        match message {
            Message::Set(_) | Message::SetAnswer(..) | Message::Get | Message::GetAnswer(..) => {
                Delivery::Reliable
            }
            Message::Detection(_)
            | Message::Clock(_)
            | Message::Command(..)
            | Message::Sensed(_)
            | Message::Recorded(_)
                if is_lockstep =>
            {
                Delivery::Reliable
            }
            Message::EStop(..) | Message::Release(_) => Delivery::Once,
            // Latched: a node that was cut off receives it later.
            Message::Locks(_) => Delivery::Reliable,
            _ => Delivery::BestEffort,
        }
    }

    fn deliver(&mut self, from: Node, to: Node, message: Message) -> Result<(), String> {
        match (to, message) {
            (Node::Robot(robot), message) => self.robot_receives(robot, message),
            (Node::Controller(robot), message) => self.controller_receives(robot, from, message),
            (Node::Runner(runner), message) => self.runner_receives(runner, from, message),
            (Node::Simulator, message) => self.simulator_receives(from, message),
            (Node::Stopper, message) => {
                self.stopper_receives(from, message);
                Ok(())
            }
            (to, message) => panic!("{message:?} from {from:?} to {to:?}"),
        }
    }

    /// Keeps what happened, if it is to be printed.
    fn note(&mut self, text: impl FnOnce() -> String) {
        if self.verbosity == Verbosity::Everything {
            self.story.narrative.push(format!("{:>6} ms  {}", self.now_ms, text()));
        }
    }

    /// What must be true of the wheels at every instant.
    fn judge(&mut self) -> Result<(), String> {
        // Of each robot whose wheels turn: the epoch, and the run if that is known.
        let mut turning: Vec<(usize, u64, Option<usize>)> = Vec::new();
        for robot in self.all_robots() {
            let Some(command_sent) = self.turning(robot) else { continue };
            let is_awake = self.is_awake(self.gatekeeper(robot));
            let last_ms = if is_awake { GLANCE_MS } else { WHEELS_TIMEOUT_MS };
            let oracle = &self.oracles[robot];
            oracle
                .wheels(command_sent, last_ms, self.now_ms)
                .map_err(|violation| format!("{}: {violation}", name(robot)))?;
            let epoch = oracle.moved().0;
            // Wheels turn on for a moment after their gate was armed by another run.
            let run = self.gate(robot).run_id().filter(|_| self.gate(robot).epoch() == epoch);
            turning.push((robot, epoch, run.and_then(number_of_run)));
        }
        let Some((first, rest)) = turning.split_first() else { return Ok(()) };
        // Most of the time, all turn for one run.
        let is_odd =
            |other: &&(usize, u64, Option<usize>)| (first.1, first.2) != (other.1, other.2);
        if rest.iter().any(|other| is_odd(&other)) {
            return self.judge_runs(&turning);
        }
        Ok(())
    }

    /// No two robots move in two epochs at once, nor for two runs, unless these are runs of different
    /// robots.
    fn judge_runs(&self, turning: &[(usize, u64, Option<usize>)]) -> Result<(), String> {
        for (place, (one, epoch, run)) in turning.iter().enumerate() {
            for (other, other_epoch, other_run) in &turning[..place] {
                let (own, others) = match (run, other_run) {
                    (Some(run), Some(other_run)) => {
                        (self.scenario.robots_of(*run), self.scenario.robots_of(*other_run))
                    }
                    _ => (vec![*one], vec![*other]),
                };
                let is_one_floor = self.scenario.teams.is_empty()
                    || run == other_run
                    || own.iter().any(|robot| others.contains(robot));
                let differ = epoch != other_epoch
                    || (run.is_some() && other_run.is_some() && run != other_run);
                if is_one_floor && differ {
                    return Err(format!(
                        "{} moves for {run:?} in epoch {epoch} and {} for {other_run:?} in epoch \
                         {other_epoch}",
                        name(*one),
                        name(*other)
                    ));
                }
            }
        }
        Ok(())
    }
}

fn number_of_run(run_id: &str) -> Option<usize> {
    run_id.strip_prefix("run ")?.parse().ok()
}

/// What only the last lines of a story contain.
impl Fleet {
    /// Every bag is closed or can be recovered; and what is healed works.
    fn judge_end(&mut self) -> Result<(), String> {
        if !self.is_healed {
            return Ok(());
        }
        match self.story.outcomes.get(&LAST_RUNNER) {
            Some(Outcome::Completed) => {}
            other => return Err(format!("after all was healed, the next run was {other:?}")),
        }
        for (robot, oracle) in self.oracles.iter().enumerate() {
            if oracle.moved().1.is_none_or(|at_ms| at_ms + 10_000 < self.now_ms) {
                return Err(format!("after all was healed, {} did not move", name(robot)));
            }
        }
        Ok(())
    }
}

/// A command of no controller, that no robot can follow.
const BEYOND: [Command; 3] = [
    Command { speed_m_s: 1e6, turn_rate_rad_s: 0.0 },
    Command { speed_m_s: 0.1, turn_rate_rad_s: f64::NAN },
    Command { speed_m_s: -1e6, turn_rate_rad_s: 0.75 },
];
