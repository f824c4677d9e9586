//! The simulator: gates of all robots and the pace of their world, wired as its driver wires them.

use rsrs_core::robot::controller::{Command, decide};
use rsrs_fleet::experiment::Time;
use rsrs_fleet::robot::{self, Lapse};
use rsrs_fleet::runner::Target;
use rsrs_fleet::simulator::{Action, Event, Gate, Gates, Placed, Simulator};

use super::robots::{RobotHost, options};
use super::{Fleet, N_RUNNERS, WANTED, name};
use crate::network::{Message, Node};
use crate::scenario::Body;

const PERIOD_NS: u64 = 130_000_000;
/// Steps of a run in lockstep.
pub(super) const STEPS: u64 = 40;
/// Names the world that runs ask for.
pub(super) const PLACED: u64 = 7;
/// Names a world that a person asks for.
pub(super) const ANOTHER: u64 = 8;

/// The simulator's process.
#[derive(Default)]
pub(super) struct SimulatorHost {
    machine: Simulator,
    placed: u64,
    /// The step that was sensed last, and how often the world has moved.
    step: u64,
    moved: u64,
}

/// What a robot senses in a step.
fn detected(robot: usize, step: u64) -> bool {
    (step + robot as u64).is_multiple_of(3)
}

impl Fleet {
    pub(super) fn simulator_ticks(&mut self) -> Result<(), String> {
        for robot in self.all_robots() {
            self.step_gate(robot, robot::Event::Tick)?;
        }
        self.look_at_gates()
    }

    /// Shows the machine its gates, as its driver does whenever it wakes up.
    pub(super) fn look_at_gates(&mut self) -> Result<(), String> {
        let Some(host) = &self.simulator else { return Ok(()) };
        if host.machine.due().is_some() {
            for robot in self.all_robots() {
                self.step_gate(robot, robot::Event::Tick)?;
            }
        }
        let now = self.local(Node::Simulator);
        let is_placed = self.simulator.as_ref().is_some_and(|host| host.placed != 0);
        let robots = if is_placed { &self.robots[..] } else { &[] };
        let gate = |host: &RobotHost| Gate {
            state: host.gate.state(now),
            drive: host.gate.drive(now),
            is_in_run: host.gate.is_in_run(now),
        };
        let gates = robots.iter().map(gate).collect();
        self.deliver_to_simulator(Event::Gates(gates))
    }

    pub(super) fn simulator_receives(
        &mut self,
        from: Node,
        message: Message,
    ) -> Result<(), String> {
        match message {
            Message::Recorded(step) => self.deliver_to_simulator(Event::Recorded { step })?,
            Message::Set(_) => {
                let result = self.place(PLACED)?;
                self.send(Node::Simulator, from, Message::SetAnswer(Target::Simulator, result));
            }
            other => panic!("the simulator receives {other:?}"),
        }
        self.look_at_gates()
    }

    pub(super) fn simulator_is_commanded(
        &mut self,
        robot: usize,
        command: Command,
        stamp_ns: Option<u64>,
    ) -> Result<(), String> {
        self.deliver_to_simulator(Event::Command { robot, stamp_ns, command })?;
        self.look_at_gates()
    }

    /// Places a world, unless a run holds the one that is there.
    pub(super) fn place(&mut self, world: u64) -> Result<Result<(), String>, String> {
        let now = self.local(Node::Simulator);
        let is_bound = |host: &RobotHost| host.gate.is_in_run(now);
        if self.robots.iter().any(is_bound) {
            return Ok(Err("read-only while armed".to_owned()));
        }
        let (time, lapse) = match self.scenario.body {
            Body::Lockstep => (Time::Lockstep, Lapse::Freezes),
            Body::Real | Body::Simulated => (Time::RealTime, Lapse::Stops),
        };
        for robot in self.all_robots() {
            self.step_gate(robot, robot::Event::WithoutWorld(false))?;
            self.oracles[robot].world_is_replaced(self.now_ms);
            let options = options(robot, lapse);
            if options != self.robots[robot].options {
                // A robot that has to change is switched off and on again, and keeps the e-stop: its
                // locks, and whose silence would lock.
                let before = self.robots[robot].gate.clone();
                let oracle = self.oracles[robot].clone();
                self.robots_start([robot]);
                self.oracles[robot].keeps_e_stop_of(&oracle);
                self.robots[robot].gate = before.anew(options.clone()).counting_from(self.now_ms);
                self.robots[robot].options = options;
            }
        }
        let host = self.simulator.as_mut().expect("only a simulator receives this");
        (host.placed, host.step, host.moved) = (world, 0, 0);
        self.deliver_to_simulator(Event::Placed(Placed {
            digest: world,
            robots: self.all_robots().map(name).collect(),
            steps: STEPS,
            period_ns: PERIOD_NS,
            time,
            gates: Gates::Here,
        }))?;
        Ok(Ok(()))
    }

    fn deliver_to_simulator(&mut self, event: Event) -> Result<(), String> {
        let now = self.local(Node::Simulator);
        let Some(host) = &mut self.simulator else { return Ok(()) };
        for action in host.machine.on_event(event, now) {
            match action {
                Action::Sense { step, stamp_ns } => self.sense(step, stamp_ns),
                Action::Advance { commands } => self.advance(&commands)?,
                Action::Obey { robot, command } => {
                    self.oracles[robot].command(self.now_ms);
                    self.step_gate(robot, robot::Event::Command(command))?;
                }
                Action::Refuse { robot, reason } => {
                    self.note(|| format!("command for {} refused: {reason}", name(robot)));
                }
                Action::Status(mut status) => {
                    let incarnation = self.processes[self.slot(Node::Simulator)].incarnation;
                    let run_id = self.robots.iter().find_map(|host| host.gate.run_id());
                    run_id.unwrap_or_default().clone_into(&mut status.run_id);
                    self.note(|| format!("simulator {}: {}", status.state, status.stop_reason));
                    let message = Message::SimulatorStatus(status.into(), incarnation);
                    for runner in 0..N_RUNNERS {
                        self.send(Node::Simulator, Node::Runner(runner), message.clone());
                    }
                }
                Action::Overrun { .. } | Action::Complete { .. } | Action::Void { .. } => {}
                Action::AdvanceFreely | Action::Stepped { .. } => {
                    return Err(format!("{action:?}, and no steps were requested"));
                }
            }
        }
        Ok(())
    }

    fn sense(&mut self, step: u64, stamp_ns: Option<u64>) {
        self.simulator.as_mut().expect("it is running").step = step;
        for robot in self.all_robots() {
            let to = Node::Controller(robot);
            if let Some(stamp_ns) = stamp_ns {
                self.send(Node::Simulator, to, Message::Clock(stamp_ns));
            }
            self.send(Node::Simulator, to, Message::Detection(detected(robot, step)));
        }
        for runner in 0..N_RUNNERS {
            self.send(Node::Simulator, Node::Runner(runner), Message::Sensed(step));
        }
    }

    /// The world moves, and with it the wheels of its robots.
    fn advance(&mut self, commands: &[Command]) -> Result<(), String> {
        let is_lockstep = self.scenario.body == Body::Lockstep;
        let host = self.simulator.as_mut().expect("it is running");
        host.moved += 1;
        let (step, moved) = (host.step, host.moved);
        if is_lockstep && step != moved {
            return Err(format!("step {step} was sensed when the world moved {moved} times"));
        }
        let mut epochs = Vec::new();
        for (robot, command) in commands.iter().enumerate() {
            if *command == Command::STOP {
                continue;
            }
            self.check_movement(robot)?;
            if is_lockstep {
                let expected = decide(detected(robot, step), WANTED);
                if *command != expected {
                    return Err(format!(
                        "{} moves by {command:?} in step {step}, expected {expected:?}",
                        name(robot)
                    ));
                }
            } else {
                self.oracles[robot]
                    .obeys_command(self.now_ms)
                    .map_err(|violation| format!("{}: {violation}", name(robot)))?;
            }
            epochs.push(self.robots[robot].gate.epoch());
        }
        if epochs.iter().any(|epoch| *epoch != epochs[0]) {
            return Err(format!("robots move in several epochs at once: {epochs:?}"));
        }
        Ok(())
    }
}
