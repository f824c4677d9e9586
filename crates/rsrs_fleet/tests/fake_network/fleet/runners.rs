//! Runners, with the recorder and the requests that are around each of them on its own host.

use std::collections::{BTreeMap, BTreeSet};

use rsrs_core::robot::controller::Reaction;
use rsrs_fleet::e_stop;
use rsrs_fleet::message::{LeaseState, RobotState};
use rsrs_fleet::placement::PlaceCheck;
use rsrs_fleet::preflight::{Expected, Graph};
use rsrs_fleet::runner::{Action, Event, RunLength, Runner, RunnerOptions, Target};

use super::simulating::{PLACED, STEPS};
use super::{Fleet, N_RUNNERS, WANTED, name, run_id, settings};
use crate::network::{Item, Message, Node, Sent};
use crate::scenario::Body;

/// How long a runner looks for others before it goes on, less what clocks may be wrong.
const LISTENS_MS: u64 = 998;
/// A disk needs so long to open or close a bag.
const DISK_MS: u64 = 15;
/// How often a runner looks at the discovery database, in milliseconds.
const POLL_PERIOD_MS: u64 = 100;

/// Statuses of which it is known when they were sent.
const REMEMBERED: usize = 1_000;

/// What has become of a bag.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Bag {
    #[default]
    None,
    Open,
    Closed,
}

/// A runner's process.
pub(super) struct RunnerHost {
    machine: Runner,
    bag: Bag,
    looked_ms: u64,
    /// By robot and counter: when the statuses were sent that it has received.
    received: Vec<BTreeMap<u64, Sent>>,
    asks_simulator: bool,
    /// Which process of the simulator has answered last, and its newest status with the run's world.
    answered_by: Option<(u32, u64)>,
    /// Whether it had the world of the run.
    has_confirmed: bool,
    has_configured: bool,
    /// When it last received another runner.
    other_ms: Option<u64>,
    /// Why it must not arm or run any more.
    must_stop: Option<String>,
}

impl RunnerHost {
    pub fn records(&self) -> bool {
        self.bag == Bag::Open
    }
}

impl Fleet {
    pub(super) fn start_runner(&mut self, runner: usize) {
        let run_ms = self.scenario.run_ms;
        let length = match self.scenario.body {
            Body::Lockstep => RunLength::Lockstep { steps: STEPS },
            Body::Real | Body::Simulated => {
                RunLength::RealTime { duration: std::time::Duration::from_millis(run_ms) }
            }
        };
        let options = RunnerOptions {
            run_id: run_id(runner),
            expected: Expected {
                robots: self.scenario.robots_of(runner).into_iter().map(name).collect(),
                simulator: self.simulator.is_some(),
                controller_only: self.controller_only(),
                ..Expected::default()
            },
            controller: WANTED.into(),
            reaction: Reaction::ToDetections,
            simulator_digest: PLACED,
            length,
            robot_lost: self.scenario.robot_lost,
            judged: rsrs_core::judge::window::Window::default(),
            countdown: std::time::Duration::from_millis(self.scenario.countdown_ms),
            start: None,
            place_check: PlaceCheck::On,
            samples: BTreeSet::new(),
            motion: None,
        };
        let host = RunnerHost {
            machine: Runner::new(options),
            bag: Bag::None,
            looked_ms: 0,
            received: vec![BTreeMap::new(); self.scenario.n_robots],
            asks_simulator: false,
            answered_by: None,
            has_confirmed: false,
            has_configured: false,
            other_ms: None,
            must_stop: None,
        };
        self.runners.insert(runner, host);
        self.switch_on(Node::Runner(runner));
    }

    pub(super) fn runner_ticks(&mut self, runner: usize) -> Result<(), String> {
        let simulator = Node::Simulator;
        let is_up = self.simulator.is_some() && self.processes[self.slot(simulator)].is_up;
        let now_ms = self.now_ms;
        let Some(host) = self.runners.get_mut(&runner) else { return Ok(()) };
        if now_ms >= host.looked_ms + POLL_PERIOD_MS {
            host.looked_ms = now_ms;
            let graph = Graph { simulator: is_up, ..Graph::default() };
            self.give_runner(runner, Event::Seen(graph))?;
        }
        self.give_runner(runner, Event::Tick)
    }

    pub(super) fn runner_receives(
        &mut self,
        runner: usize,
        from: Node,
        message: Message,
    ) -> Result<(), String> {
        let Some(host) = self.runners.get_mut(&runner) else { return Ok(()) };
        match (message, from) {
            (Message::Lease(lease, _), _) => {
                let robots = self.scenario.robots_of(runner);
                let shares = robots.into_iter().any(|robot| lease.echo(&name(robot)).is_some());
                let own = host.machine.epoch();
                let goes_before = match (own, lease.epoch) {
                    // In this order they are started, and named.
                    (0, 0) => lease.run_id < run_id(runner),
                    _ => lease.epoch > 0 && lease.epoch >= own,
                };
                if shares && goes_before {
                    host.other_ms = Some(self.now_ms);
                    if host.has_configured {
                        host.must_stop.get_or_insert(format!("it has received {}", lease.run_id));
                    }
                }
                self.give_runner(runner, Event::LeaseReceived((*lease).clone()))
            }
            (Message::EStop(source, engaged), _) => {
                self.give_runner(runner, Event::EStop(e_stop::Message::State { source, engaged }))
            }
            (Message::Release(sources), _) => {
                self.give_runner(runner, Event::EStop(e_stop::Message::Release((*sources).clone())))
            }
            (Message::RobotStatus(status, sent), Node::Robot(robot) | Node::Controller(robot)) => {
                let received = &mut host.received[robot];
                received.insert(status.counter, sent);
                if received.len() > REMEMBERED {
                    received.pop_first();
                }
                let behind_ms = (self.now_ms - sent.at_ms).cast_signed();
                let ahead_ms = self.scenario.ahead_ms[robot] - behind_ms;
                let seconds = ahead_ms as f64 / 1000.0;
                let (robot, status) = (name(robot), (*status).clone());
                self.give_runner(runner, Event::ClockAhead { robot: robot.clone(), seconds })?;
                self.give_runner(runner, Event::RobotStatus { robot, status })
            }
            (Message::ControllerStatus(status, _), Node::Controller(robot)) => {
                let (robot, status) = (name(robot), (*status).clone());
                self.give_runner(runner, Event::ControllerStatus { robot, status })
            }
            (Message::SimulatorStatus(status, incarnation), _) => {
                if std::mem::take(&mut host.asks_simulator) {
                    host.answered_by = Some((incarnation, status.counter));
                    host.has_confirmed = status.parameter_digest == PLACED;
                    let result = if status.state == RobotState::Fault {
                        Err(status.stop_reason.clone())
                    } else {
                        Ok(status.parameter_digest)
                    };
                    self.give_runner(
                        runner,
                        Event::ReadBack { target: Target::Simulator, result },
                    )?;
                }
                let Some(host) = self.runners.get_mut(&runner) else { return Ok(()) };
                let Some((of_run, newest)) = &mut host.answered_by else { return Ok(()) };
                if incarnation != *of_run {
                    return Ok(());
                }
                // An old one that comes late is no news: a late request may have placed the run's world
                // again meanwhile.
                let is_news = *newest < status.counter;
                if is_news && status.parameter_digest == PLACED {
                    *newest = status.counter;
                } else if is_news && host.has_confirmed && host.machine.outcome().is_none() {
                    self.story.n_without_world += 1;
                    host.must_stop.get_or_insert("its world has gone".to_owned());
                }
                self.give_runner(runner, Event::SimulatorStatus((*status).clone()))
            }
            (Message::Sensed(step), _) if host.records() => {
                self.send(Node::Runner(runner), Node::Simulator, Message::Recorded(step));
                self.give_runner(runner, Event::Recorded { step })
            }
            (Message::Sensed(_), _) => Ok(()),
            (Message::SetAnswer(target, result), _) => {
                self.give_runner(runner, Event::ParametersSet { target, result })
            }
            (Message::GetAnswer(target, digest), _) => {
                self.give_runner(runner, Event::ReadBack { target, result: Ok(digest) })
            }
            (other, from) => panic!("a runner receives {other:?} from {from:?}"),
        }
    }

    pub(super) fn give_runner(&mut self, runner: usize, event: Event) -> Result<(), String> {
        let now = self.local(Node::Runner(runner));
        let Some(host) = self.runners.get_mut(&runner) else { return Ok(()) };
        for action in host.machine.on_event(event, now) {
            self.act(runner, action)?;
        }
        Ok(())
    }

    fn act(&mut self, runner: usize, action: Action) -> Result<(), String> {
        let node = Node::Runner(runner);
        let host = self.runners.get_mut(&runner).expect("it acts");
        match action {
            Action::PublishLease(lease) => {
                let moves = matches!(lease.state, LeaseState::Armed | LeaseState::Running);
                if let Some(reason) = host.must_stop.as_ref().filter(|_| moves) {
                    return Err(format!(
                        "runner {runner} publishes {:?}, though {reason}",
                        lease.state
                    ));
                }
                let echoed =
                    |robot: usize| host.received[robot].get(&lease.echo(&name(robot))?).copied();
                let echoes = (0..host.received.len()).map(echoed).collect();
                let message = Message::Lease(lease.into(), echoes);
                for robot in self.all_robots() {
                    self.send(node, Node::Robot(robot), message.clone());
                    self.send(node, Node::Controller(robot), message.clone());
                }
                for other in (0..N_RUNNERS).filter(|other| *other != runner) {
                    self.send(node, Node::Runner(other), message.clone());
                }
            }
            Action::Configure(target) => {
                host.has_configured = true;
                if host.other_ms.is_some_and(|at_ms| self.now_ms < at_ms + LISTENS_MS)
                    && host.must_stop.is_none()
                    && host.machine.epoch() == 0
                {
                    return Err(format!(
                        "runner {runner} sets {target}, but has just received another"
                    ));
                }
                let settings = settings(WANTED, self.scenario.body);
                self.send(node, node_of(&target), Message::Set(settings));
            }
            Action::ReadBack(Target::Simulator) => host.asks_simulator = true,
            Action::ReadBack(target) => self.send(node, node_of(&target), Message::Get),
            // Its robots have no parameters, and are not expected to have any.
            Action::ReadGate(_) => {}
            Action::OpenRecorder => {
                host.bag = Bag::Open;
                self.answer(runner, Event::RecorderReady);
            }
            Action::CloseRecorder => {
                host.bag = Bag::Closed;
                self.answer(runner, Event::RecorderClosed);
            }
            Action::Note(text) => self.note(|| format!("runner {runner}: {text}")),
            Action::Finish { outcome, not_standing } => {
                if host.bag == Bag::Open {
                    return Err(format!("runner {runner} has finished, and its bag is open"));
                }
                self.note(|| format!("runner {runner}: {outcome:?}"));
                self.judge_account(runner)?;
                self.story.outcomes.insert(runner, outcome);
                self.runners.remove(&runner);
                let slot = self.slot(node);
                self.processes[slot].is_up = false;
                return self.judge_finish(runner, &not_standing);
            }
        }
        Ok(())
    }

    /// Who stood and went on in a run is in its account: nothing that robots did is left out.
    fn judge_account(&mut self, runner: usize) -> Result<(), String> {
        let host = &self.runners[&runner];
        let (epoch, paused, lost) =
            (host.machine.epoch(), host.machine.paused(), host.machine.lost());
        self.story.n_pauses += paused.len();
        for (robot, oracle) in self.oracles.iter().enumerate() {
            let name = name(robot);
            let is_named = paused.iter().any(|pause| pause.robot == name)
                || lost.iter().any(|lost| lost.robot == name);
            let is_its = self.gate(robot).run_id() == Some(&run_id(runner));
            if is_its && oracle.resumed(epoch) && !is_named {
                return Err(format!(
                    "{name} stood and went on, and runner {runner} has no word on it"
                ));
            }
        }
        Ok(())
    }

    /// As a fleet file has it.
    fn controller_only(&self) -> BTreeSet<String> {
        let is_alone = |robot: &usize| self.scenario.controller_only[*robot];
        (self.all_robots()).filter(is_alone).map(name).collect()
    }

    fn answer(&mut self, runner: usize, event: Event) {
        self.network.plan(self.now_ms + DISK_MS, Item::Answer(runner, event));
    }

    /// Whose wheels still turn must have been named.
    fn judge_finish(&self, runner: usize, not_standing: &[String]) -> Result<(), String> {
        for robot in self.all_robots() {
            let turns = self.turning(robot).is_some();
            let obeys = self.gate(robot).run_id() == Some(&run_id(runner));
            if turns && obeys && !not_standing.contains(&name(robot)) {
                return Err(format!("the run is over, {} moves and is not named", name(robot)));
            }
        }
        Ok(())
    }
}

fn node_of(target: &Target) -> Node {
    match target {
        Target::Simulator => Node::Simulator,
        Target::Robot(robot) => {
            let number =
                robot.strip_prefix("robot_").and_then(|number| number.parse::<usize>().ok());
            Node::Controller(number.expect("runners have these names only") - 1)
        }
    }
}
