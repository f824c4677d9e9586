//! Controllers, with the parameters that runs set and meddlers try to.

use rsrs_core::robot::controller::{Command, ControllerParameters};
use rsrs_fleet::controller::{Action, Event, Settings};
use rsrs_fleet::e_stop;
use rsrs_fleet::runner::Target;

use super::robots::for_robot;
use super::{Fleet, N_RUNNERS, WANTED, name, settings};
use crate::network::{Message, Node, Sent};

impl Fleet {
    pub(super) fn controller_receives(
        &mut self,
        robot: usize,
        from: Node,
        message: Message,
    ) -> Result<(), String> {
        let target = Target::Robot(name(robot));
        let is_liar = self.scenario.liar == Some(robot);
        match message {
            Message::Lease(lease, echoes) => {
                self.observe_hold(robot, &lease);
                if self.scenario.controller_only[robot] {
                    self.observe_lease(robot, echoes[robot], &lease);
                }
                self.deliver_to_controller(robot, Event::Lease(for_robot(robot, &lease)))
            }
            Message::EStop(source, engaged) => {
                self.observe_e_stop(robot, (source, engaged));
                self.deliver_to_controller(
                    robot,
                    Event::EStop(e_stop::Message::State { source, engaged }),
                )
            }
            Message::Release(sources) => {
                self.oracles[robot].e_stop_is_released(&sources);
                self.deliver_to_controller(
                    robot,
                    Event::EStop(e_stop::Message::Release((*sources).clone())),
                )
            }
            Message::Locks(locks) => {
                self.deliver_to_controller(
                    robot,
                    Event::EStop(e_stop::Message::Locks {
                        reporter: e_stop::Source([0; 16]),
                        locks: (*locks).clone(),
                    }),
                )?;
                self.observe_adoption(robot);
                Ok(())
            }
            Message::Detection(detected) => {
                self.deliver_to_controller(robot, Event::Detection(detected))
            }
            Message::Clock(stamp_ns) => self.deliver_to_controller(robot, Event::Clock(stamp_ns)),
            Message::Set(settings) => {
                let result = self.set(robot, settings)?;
                self.send(Node::Controller(robot), from, Message::SetAnswer(target, result));
                Ok(())
            }
            Message::Get => {
                let set = &self.controllers[robot].settings().controller;
                let digest = if is_liar { WANTED.digest() } else { set.digest() };
                self.send(Node::Controller(robot), from, Message::GetAnswer(target, digest));
                Ok(())
            }
            other => panic!("a controller receives {other:?}"),
        }
    }

    /// What it answers; the outer error is a violation.
    fn set(&mut self, robot: usize, settings: Settings) -> Result<Result<(), String>, String> {
        if self.scenario.liar == Some(robot) {
            return Ok(Ok(()));
        }
        if self.controllers[robot].is_armed(self.local(Node::Controller(robot))) {
            return Ok(Err("read-only while armed".to_owned()));
        }
        self.deliver_to_controller(robot, Event::Parameters(settings)).map(Ok)
    }

    pub(super) fn deliver_to_controller(
        &mut self,
        robot: usize,
        event: Event,
    ) -> Result<(), String> {
        let node = Node::Controller(robot);
        let now = self.local(node);
        let decides = matches!(event, Event::Detection(_));
        let actions = self.controllers[robot].on_event(event, now);
        let holds_lease = self.scenario.controller_only[robot];
        if holds_lease {
            self.check_controller(robot)?;
        }
        if holds_lease && decides {
            self.oracles[robot].command(self.now_ms);
        }
        for action in actions {
            match action {
                Action::Command { command, stamp_ns } => {
                    self.mouths[robot] = Some(command);
                    self.judge_mouth(robot)?;
                    self.send(node, Node::Robot(robot), Message::Command(command, stamp_ns));
                }
                Action::GateStatus(status) => self.publish_status(robot, status),
                Action::Status(status) => {
                    let sent = Sent {
                        incarnation: self.processes[self.slot(node)].incarnation,
                        at_ms: self.now_ms,
                        stands: false,
                    };
                    let message = Message::ControllerStatus(status.into(), sent);
                    self.send(node, Node::Robot(robot), message.clone());
                    for runner in 0..N_RUNNERS {
                        self.send(node, Node::Runner(runner), message.clone());
                    }
                }
            }
        }
        if holds_lease {
            self.publish_locks(robot);
        }
        self.judge_mouth(robot)
    }

    /// A controller that holds the lease has thought.
    fn check_controller(&mut self, robot: usize) -> Result<(), String> {
        let settings = self.controllers[robot].settings();
        let digest = settings.controller.digest_with(settings.reaction);
        let epoch = self.gate(robot).epoch();
        let (oracle, now_ms) = (&mut self.oracles[robot], self.now_ms);
        oracle.controller(digest, now_ms, now_ms);
        oracle.obeys(epoch, now_ms).map_err(|violation| format!("{}: {violation}", name(robot)))
    }

    /// May a controller that holds the lease publish what it does, and nothing else?
    fn judge_mouth(&mut self, robot: usize) -> Result<(), String> {
        let stands = self.mouths[robot].is_none_or(|command_sent| command_sent == Command::STOP);
        if stands || !self.scenario.controller_only[robot] {
            return Ok(());
        }
        self.check_movement(robot)?;
        self.oracles[robot]
            .obeys_command(self.now_ms)
            .map_err(|violation| format!("{}: {violation}", name(robot)))
    }

    /// A person tries a parameter of a controller; none is to change while a run holds it.
    pub(super) fn meddle(&mut self, robot: usize) -> Result<(), String> {
        let process = self.processes[self.slot(Node::Controller(robot))];
        let is_awake = process.is_up && self.now_ms >= process.stalled_until_ms;
        if !is_awake || self.scenario.liar == Some(robot) {
            return Ok(());
        }
        let parameters = ControllerParameters { speed_m_s: 0.1, ..WANTED };
        let settings = settings(parameters, self.scenario.body);
        self.story.meddled.0 += 1;
        let result = self.set(robot, settings)?;
        self.story.meddled.1 += u64::from(result.is_err());
        if result.is_ok() && self.now_ms < self.held_until_ms[robot] {
            return Err(format!("parameters of {} changed while a run held them", name(robot)));
        }
        Ok(())
    }
}
