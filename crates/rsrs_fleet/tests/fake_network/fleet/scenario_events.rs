//! What happens to a fleet, and what its people do about it.

use rsrs_fleet::e_stop::Locks;
use rsrs_fleet::message::{Lease, LeaseState};
use rsrs_fleet::runner;
use rsrs_fleet::stopper::{self, StopCommand, Stopper};

use super::simulating::{ANOTHER, SimulatorHost};
use super::{AFTERMATH_MS, BEYOND, Fleet, LAST_RUNNER, N_RUNNERS, name, new_controller};
use crate::network::{Item, Message, Node};
use crate::scenario::{Body, Happening, N_BUTTONS};

/// A controller takes the run for gone when it has received nothing of it for so long, in milliseconds.
const HOLD_MS: u64 = 498;

impl Fleet {
    pub(super) fn happen(&mut self, happening: Happening) -> Result<(), String> {
        match happening {
            Happening::Crash(node) => self.crash(node),
            Happening::Restart(node) => self.restart(node),
            Happening::Stall(node, length_ms) => {
                let slot = self.slot(node);
                self.processes[slot].stalled_until_ms = self.now_ms + length_ms;
            }
            Happening::Start(runner) => self.start_runner(runner),
            Happening::Interrupt => return self.interrupt(0),
            Happening::Stop => self.start_stopper(StopCommand::Engage),
            Happening::Release => self.start_stopper(StopCommand::Release),
            Happening::Press(button) => {
                self.buttons[button] = self.buttons[button].map(|_| true);
            }
            Happening::Unpress(button) => {
                self.buttons[button] = self.buttons[button].map(|_| false);
            }
            Happening::ButtonFallsSilent(button) => self.buttons[button] = None,
            Happening::Meddle(robot) => return self.meddle(robot),
            Happening::PlaceAnother => {
                if self.simulator.is_some() && self.processes[self.slot(Node::Simulator)].is_up {
                    // It is not placed while a run holds its own.
                    drop(self.place(ANOTHER)?);
                    return self.look_at_gates();
                }
            }
            Happening::Beyond(robot) => {
                let command = BEYOND[robot % BEYOND.len()];
                let message = Message::Command(command, None);
                self.send(Node::Stranger, Node::Robot(robot), message);
            }
            Happening::DiskFull => {
                if self.runners.get(&0).is_some_and(super::RunnerHost::records) {
                    let reason = "no space left".to_owned();
                    return self.give_runner(0, runner::Event::RecorderFailed { reason });
                }
            }
            Happening::Heal => return self.heal(),
        }
        Ok(())
    }

    /// Starts the process of a node, with a first look at its clock.
    pub(super) fn switch_on(&mut self, node: Node) {
        let slot = self.slot(node);
        let process = &mut self.processes[slot];
        (process.is_up, process.stalled_until_ms) = (true, 0);
        process.incarnation += 1;
        let incarnation = process.incarnation;
        let phase_ms = 1 + slot as u64 % Self::beat_ms(node);
        self.network.plan(self.now_ms + phase_ms, Item::Tick(node, incarnation));
    }

    /// A process dies; wheels run on for as long as their own timeout, a bag stays as it is.
    fn crash(&mut self, node: Node) {
        let slot = self.slot(node);
        self.processes[slot].is_up = false;
        for oracle in &mut self.oracles {
            oracle.process_died(self.now_ms);
        }
        match node {
            Node::Runner(runner) => {
                self.runners.remove(&runner);
            }
            Node::Simulator => self.simulator = Some(SimulatorHost::default()),
            Node::Controller(robot) => self.mouths[robot] = None,
            _ => {}
        }
    }

    fn restart(&mut self, node: Node) {
        if self.processes[self.slot(node)].is_up {
            return;
        }
        match node {
            Node::Robot(robot) => self.robots_start([robot]),
            // All of its gates forget at once, and no process is left to ask.
            Node::Simulator => self.robots_start(self.all_robots()),
            Node::Controller(robot) => {
                self.controllers[robot] = new_controller(robot, &self.scenario, self.now_ms);
                if self.scenario.controller_only[robot] {
                    self.oracles[robot].starts();
                }
                self.held_until_ms[robot] = 0;
                self.held_by[robot] = (0, String::new());
            }
            _ => {}
        }
        self.switch_on(node);
        if let Node::Robot(robot) | Node::Controller(robot) = node
            && self.gatekeeper(robot) == node
        {
            self.locks[robot] = Locks::default();
            self.ask_for_locks(node);
        }
    }

    fn interrupt(&mut self, runner: usize) -> Result<(), String> {
        let reason = "interrupted".to_owned();
        self.give_runner(runner, runner::Event::Interrupt { reason })
    }

    fn start_stopper(&mut self, command: StopCommand) {
        if self.stopper.is_some() {
            return;
        }
        self.stopper = Some((Stopper::new(command), command, self.now_ms));
        self.switch_on(Node::Stopper);
        self.ask_for_locks(Node::Stopper);
        // As from a fleet file: a robot that is out of reach should be named.
        for robot in self.all_robots() {
            self.deliver_to_stopper(stopper::Event::Discovered { robot: name(robot) });
        }
    }

    /// Everything is put right that a person can put right; runs that still go on are ended.
    fn heal(&mut self) -> Result<(), String> {
        self.is_healed = true;
        self.network.heal();
        self.buttons = [None; N_BUTTONS];
        self.scenario.liar = None;
        self.scenario.ahead_ms.fill(0);
        for robot in self.all_robots() {
            self.restart(Node::Controller(robot));
            if self.scenario.body == Body::Real {
                self.restart(Node::Robot(robot));
            }
        }
        if self.scenario.body != Body::Real {
            self.restart(Node::Simulator);
        }
        for runner in 0..N_RUNNERS {
            self.interrupt(runner)?;
        }
        Ok(())
    }

    /// When all that went on has ended: releases who is held, and makes another run.
    pub(super) fn go_on(&mut self) {
        if self.stopper.is_some() || !self.runners.is_empty() {
            self.quiet_ms = None;
            return;
        }
        let since_ms = *self.quiet_ms.get_or_insert(self.now_ms);
        let is_left_to_do = self.is_healed && !self.story.outcomes.contains_key(&LAST_RUNNER);
        if !is_left_to_do || self.now_ms < since_ms + self.network.latest_ms() {
            return;
        }
        if self.e_stop_was_used && !self.is_released {
            self.is_released = true;
            self.start_stopper(StopCommand::Release);
        } else {
            self.start_runner(LAST_RUNNER);
        }
        self.quiet_ms = None;
    }

    /// Whether nothing more will happen, and late messages have had the time to do their harm.
    pub(super) fn is_over(&self) -> bool {
        let last_ms = self.scenario.happenings.iter().map(|(at_ms, _)| *at_ms).max().unwrap_or(0);
        let ends_with_a_run = !self.is_healed || self.story.outcomes.contains_key(&LAST_RUNNER);
        self.now_ms > last_ms
            && ends_with_a_run
            && self.quiet_ms.is_some_and(|since_ms| self.now_ms > since_ms + AFTERMATH_MS)
    }

    /// Keeps what a controller receives of its run.
    pub(super) fn observe_hold(&mut self, robot: usize, lease: &Lease) {
        if lease.echo(&name(robot)).is_none() {
            return;
        }
        let holds = matches!(lease.state, LeaseState::Armed | LeaseState::Running);
        let (epoch, run_id) = &mut self.held_by[robot];
        if lease.epoch > *epoch && lease.state == LeaseState::Armed {
            (*epoch, *run_id) = (lease.epoch, lease.run_id.clone());
        }
        if (lease.epoch, &lease.run_id) == (*epoch, run_id) {
            self.held_until_ms[robot] = if holds { self.now_ms + HOLD_MS } else { 0 };
        }
    }
}
