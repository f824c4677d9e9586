//! Controllers, with the parameters that runs set and meddlers try to.

use rsrs_core::controller::{ControllerParameters, Reaction};
use rsrs_fleet::controller::{Action, Event, Settings};
use rsrs_fleet::runner::Target;

use super::{Fleet, N_RUNNERS, WANTED, name, stamp};
use crate::network::{Message, Node};

impl Fleet {
    pub(super) fn controller_hears(&mut self, robot: usize, from: Node, message: Message) {
        let target = Target::Robot(name(robot));
        let is_liar = self.scenario.liar == Some(robot);
        match message {
            Message::Lease(lease, _) => {
                self.witness_hold(robot, &lease);
                self.tell_controller(robot, Event::Lease((*lease).clone()));
            }
            Message::Detection(detected) => self.tell_controller(robot, Event::Detection(detected)),
            Message::Clock(stamp_ns) => self.tell_controller(robot, Event::Clock(stamp_ns)),
            Message::Set(settings) => {
                let result = self.set(robot, settings);
                self.send(Node::Controller(robot), from, Message::SetAnswer(target, result));
            }
            Message::Get => {
                let parameters = self.controllers[robot].settings().parameters;
                let digest = if is_liar { WANTED.digest() } else { parameters.digest() };
                self.send(Node::Controller(robot), from, Message::GetAnswer(target, digest));
            }
            other => panic!("a controller hears {other:?}"),
        }
    }

    fn set(&mut self, robot: usize, settings: Settings) -> Result<(), String> {
        if self.scenario.liar == Some(robot) {
            return Ok(());
        }
        if self.controllers[robot].is_armed(self.local(Node::Controller(robot))) {
            return Err("read-only while armed".to_owned());
        }
        self.tell_controller(robot, Event::Parameters(settings));
        Ok(())
    }

    pub(super) fn tell_controller(&mut self, robot: usize, event: Event) {
        let node = Node::Controller(robot);
        let now = self.local(node);
        for action in self.controllers[robot].on_event(event, now) {
            match action {
                Action::Command { command, stamp_ns } => {
                    self.send(node, Node::Robot(robot), Message::Command(command, stamp_ns));
                }
                Action::Status(status) => {
                    let message = Message::ControllerStatus(status.into());
                    self.send(node, Node::Robot(robot), message.clone());
                    for runner in 0..N_RUNNERS {
                        self.send(node, Node::Runner(runner), message.clone());
                    }
                }
            }
        }
    }

    /// Somebody tries a parameter of a controller; none is to change while a run holds it.
    pub(super) fn meddle(&mut self, robot: usize) -> Result<(), String> {
        let process = self.processes[self.slot(Node::Controller(robot))];
        let is_awake = process.is_up && self.now_ms >= process.stalled_until_ms;
        if !is_awake || self.scenario.liar == Some(robot) {
            return Ok(());
        }
        let parameters = ControllerParameters { speed_m_s: 0.1, ..WANTED };
        let settings = Settings {
            parameters,
            stamp: stamp(self.scenario.body),
            reaction: Reaction::ToDetections,
        };
        self.story.meddled.0 += 1;
        let result = self.set(robot, settings);
        self.story.meddled.1 += u64::from(result.is_err());
        if result.is_ok() && self.now_ms < self.held_until_ms[robot] {
            return Err(format!("parameters of {} changed while a run held them", name(robot)));
        }
        Ok(())
    }
}
