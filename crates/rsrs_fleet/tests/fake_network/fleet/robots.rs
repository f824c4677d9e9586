//! Robots: the gate, the limits and the ramp, wired as the robot's driver wires them, and wheels
//! with a timeout of their own.

use std::time::Duration;

use rsrs_core::robot::controller::Command;
use rsrs_fleet::e_stop::{self, Source};
use rsrs_fleet::message::{Lease, RobotState, Status, StopCause};
use rsrs_fleet::robot::limits::{Limits, Ramp};
use rsrs_fleet::robot::{Event, Lapse, Robot, RobotOptions};

use super::{COMMAND_TIMEOUT, Fleet, N_RUNNERS, name, run_id};
use crate::network::{Message, Node, Sent};
use crate::scenario::Body;

const LIMITS: Limits = Limits {
    speed_m_s: 0.3,
    wheels: None,
    turn_rate_rad_s: 2.5,
    acceleration_m_s2: 1.0,
    turn_acceleration_rad_s2: 10.0,
};
const PERIOD_MS: u64 = 130;
const WHEELS_TIMEOUT_MS: u64 = 250;
const WHEEL_BEAT_MS: u64 = 50;

/// What a lease is for one robot: empty, if it does not name it.
pub(super) fn for_robot(robot: usize, lease: &Lease) -> Lease {
    let name = name(robot);
    match lease.robots.iter().find(|echo| echo.robot == name) {
        Some(echo) => lease.with_only(echo),
        None => Lease { run_id: lease.run_id.clone(), robots: Vec::new(), ..*lease },
    }
}

/// A robot, or its place in the simulator.
pub(super) struct RobotHost {
    pub gate: Robot,
    pub options: RobotOptions,
    ramp: Ramp,
    /// What the wheels were commanded last, and when.
    wheels: Option<(Command, u64)>,
    sensed_ms: u64,
}

pub(super) fn options(robot: usize, lapse: Lapse) -> RobotOptions {
    RobotOptions { name: name(robot), command_timeout: COMMAND_TIMEOUT, lapse }
}

impl RobotHost {
    /// A robot whose process starts now.
    pub fn new(robot: usize, now_ms: u64) -> Self {
        let options = options(robot, Lapse::Stops);
        Self {
            gate: {
                let gate = Robot::new(options.clone()).counting_from(now_ms);
                // At the beginning of a story the fleet has been there for a while.
                if now_ms == 0 { gate } else { gate.of_a_new_process() }
            },
            options,
            ramp: Ramp::standing(Duration::ZERO),
            wheels: None,
            sensed_ms: 0,
        }
    }

    /// What the wheels do, if they turn: the microcontroller stops them when no command comes.
    pub fn turning(&self, now_ms: u64) -> Option<Command> {
        self.wheels
            .filter(|(command_sent, at_ms)| {
                *command_sent != Command::STOP && now_ms <= at_ms + WHEELS_TIMEOUT_MS
            })
            .map(|(command_sent, _)| command_sent)
    }
}

impl Fleet {
    /// The robot's process looks at the time.
    pub(super) fn robot_ticks(&mut self, robot: usize) -> Result<(), String> {
        if self.now_ms >= self.robots[robot].sensed_ms + PERIOD_MS {
            self.robots[robot].sensed_ms = self.now_ms;
            let detected = (self.now_ms / PERIOD_MS + robot as u64).is_multiple_of(3);
            self.send(Node::Robot(robot), Node::Controller(robot), Message::Detection(detected));
        }
        // What is no gate of ours has no more to do.
        if self.scenario.controller_only[robot] {
            return Ok(());
        }
        self.deliver_to_robot(robot, Event::Tick)
    }

    pub(super) fn robot_receives(&mut self, robot: usize, message: Message) -> Result<(), String> {
        if self.scenario.controller_only[robot] {
            return Ok(());
        }
        let now_ms = self.now_ms;
        let oracle = &mut self.oracles[robot];
        match message {
            Message::Lease(lease, echoes) => {
                self.observe_lease(robot, echoes[robot], &lease);
                self.deliver_to_robot(robot, Event::Lease(for_robot(robot, &lease)))
            }
            Message::ControllerStatus(status, sent) => {
                oracle.controller(status.parameter_digest, sent.at_ms, now_ms);
                self.deliver_to_robot(robot, Event::Controller((*status).clone()))
            }
            Message::EStop(source, engaged) => {
                self.observe_e_stop(robot, (source, engaged));
                self.deliver_to_robot(
                    robot,
                    Event::EStop(e_stop::Message::State { source, engaged }),
                )
            }
            Message::Release(sources) => {
                self.oracles[robot].e_stop_is_released(&sources);
                self.deliver_to_robot(
                    robot,
                    Event::EStop(e_stop::Message::Release((*sources).clone())),
                )
            }
            Message::Locks(locks) => {
                self.deliver_to_robot(
                    robot,
                    Event::EStop(e_stop::Message::Locks {
                        reporter: Source([0; 16]),
                        locks: (*locks).clone(),
                    }),
                )?;
                self.observe_adoption(robot);
                Ok(())
            }
            Message::Command(command, stamp_ns) if self.simulator.is_some() => {
                self.simulator_is_commanded(robot, command, stamp_ns)
            }
            Message::Command(command, _) => match LIMITS.check(command) {
                Ok(()) => {
                    oracle.command(now_ms);
                    self.deliver_to_robot(robot, Event::Command(command))
                }
                Err(_beyond) => {
                    oracle.refused();
                    self.deliver_to_robot(robot, Event::CommandRefused)
                }
            },
            other => panic!("a robot receives {other:?}"),
        }
    }

    pub(super) fn deliver_to_robot(&mut self, robot: usize, event: Event) -> Result<(), String> {
        self.step_gate(robot, event)?;
        if self.scenario.body == Body::Real {
            self.turn_wheels(robot)
        } else {
            self.look_at_gates()
        }
    }

    /// Lets a gate take an event, and publishes the status that follows.
    pub(super) fn step_gate(&mut self, robot: usize, event: Event) -> Result<(), String> {
        let node = Node::Robot(robot);
        let now = self.local(node);
        let was = self.robots[robot].gate.epoch();
        let status = self.robots[robot].gate.on_event(event, now);
        let epoch = self.robots[robot].gate.epoch();
        if epoch != was {
            self.note(|| format!("{} binds to epoch {epoch}", name(robot)));
        }
        self.oracles[robot]
            .obeys(epoch, self.now_ms)
            .map_err(|violation| format!("{}: {violation}", name(robot)))?;
        if let Some(status) = status {
            self.publish_status(robot, status);
        }
        self.publish_locks(robot);
        Ok(())
    }

    /// A gate publishes its status, wherever it is.
    pub(super) fn publish_status(&mut self, robot: usize, mut status: Status) {
        let node = self.gatekeeper(robot);
        self.note(|| format!("{} reports {}: {}", name(robot), status.state, status.stop_reason));
        // Texts are for people: a decision by them would be wrong here.
        status.stop_reason = match status.stop_cause {
            StopCause::Waiting => "armed for run run 9, waiting for the start".to_owned(),
            _ => format!("e-stop; {}", status.stop_reason),
        };
        let sent = Sent {
            incarnation: self.oracles[robot].incarnation(),
            at_ms: self.now_ms,
            stands: status.state == RobotState::Stopped,
        };
        let message = Message::RobotStatus(status.into(), sent);
        for runner in 0..N_RUNNERS {
            self.send(node, Node::Runner(runner), message.clone());
        }
        self.send(node, Node::Stopper, message);
    }

    /// A lease arrives, with what its runner has received from the robot last.
    pub(super) fn observe_lease(&mut self, robot: usize, echo: Option<Sent>, lease: &Lease) {
        if lease.echo(&name(robot)).is_none() {
            return;
        }
        let gate = self.gate(robot);
        // Of two runs of one epoch, the robot belongs to one.
        if gate.epoch() != lease.epoch || gate.run_id() == Some(&lease.run_id) {
            self.oracles[robot].lease(lease, echo, self.now_ms);
        }
    }

    pub(super) fn observe_e_stop(&mut self, robot: usize, (source, engaged): (Source, bool)) {
        self.oracles[robot].e_stop((source, engaged), self.now_ms);
        self.note(|| format!("{} receives the e-stop: {source} {engaged}", name(robot)));
    }

    /// What a gate takes over from others has locked it, as if it had received it itself.
    pub(super) fn observe_adoption(&mut self, robot: usize) {
        let locks = self.gate(robot).locks();
        self.oracles[robot].adopts(&locks);
    }

    /// Makes the wheels do what the gate lets through.
    fn turn_wheels(&mut self, robot: usize) -> Result<(), String> {
        let now = self.local(Node::Robot(robot));
        let let_through = self.robots[robot].gate.drive(now);
        if let_through != Command::STOP {
            self.check_movement(robot)?;
            self.oracles[robot]
                .obeys_command(self.now_ms)
                .map_err(|violation| format!("{}: {violation}", name(robot)))?;
        }
        let now_ms = self.now_ms;
        let host = &mut self.robots[robot];
        let command = host.ramp.toward(let_through, &LIMITS, now);
        let is_sent = host.wheels.is_some_and(|(command_sent, at_ms)| {
            command_sent == command && now_ms < at_ms + WHEEL_BEAT_MS
        });
        if !is_sent {
            host.wheels = Some((command, now_ms));
        }
        Ok(())
    }

    /// A gate lets something through: is that right?
    pub(super) fn check_movement(&mut self, robot: usize) -> Result<(), String> {
        self.story.movements += 1;
        let violation = |violation| format!("{}: {violation}", name(robot));
        self.oracles[robot].moves(self.now_ms).map_err(violation)?;
        if self.scenario.liar == Some(robot) {
            return Err(format!("{} moves with unconfirmed parameters", name(robot)));
        }
        let gate = self.gate(robot);
        let is_its = |runner: &usize| gate.run_id() == Some(&run_id(*runner));
        match self.runners.iter().find(|(runner, _)| is_its(runner)) {
            Some((runner, host)) if !host.records() => {
                Err(format!("{} moves for runner {runner}, which records nothing", name(robot)))
            }
            _ => Ok(()),
        }
    }

    /// The process of a robot, or of all robots of the simulator, has just started.
    pub(super) fn robots_start(&mut self, robots: impl IntoIterator<Item = usize>) {
        for robot in robots {
            self.robots[robot] = RobotHost::new(robot, self.now_ms);
            if !self.scenario.controller_only[robot] {
                self.oracles[robot].starts();
            }
        }
    }

    pub(super) fn all_robots(&self) -> std::ops::Range<usize> {
        0..self.scenario.n_robots
    }
}
