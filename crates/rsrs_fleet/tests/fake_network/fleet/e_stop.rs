//! Who engages the e-stop, who is locked by whom, and who asks for that.

use rsrs_fleet::e_stop::{self, Source};
use rsrs_fleet::stopper;

use super::{Fleet, N_RUNNERS, name};
use crate::network::{Message, Node};

impl Fleet {
    /// Publishes a value on the e-stop topic.
    pub(super) fn publish_e_stop(&mut self, (from, engaged): (Node, bool)) {
        let message = Message::EStop(self.source(from), engaged);
        self.command_all(from, &message);
        if from != Node::Stopper {
            self.send(from, Node::Stopper, message);
        }
    }

    pub(super) fn command_all(&mut self, from: Node, message: &Message) {
        self.e_stop_was_used = true;
        for robot in self.all_robots() {
            self.send(from, self.gatekeeper(robot), message.clone());
        }
        for runner in 0..N_RUNNERS {
            self.send(from, Node::Runner(runner), message.clone());
        }
    }

    /// Names the publisher of a node in this incarnation.
    pub(super) fn source(&self, node: Node) -> Source {
        let slot = self.slot(node);
        let mut guid = [0; 16];
        guid[0] = u8::try_from(slot).expect("there are few nodes");
        guid[4..8].copy_from_slice(&self.processes[slot].incarnation.to_be_bytes());
        Source(guid)
    }

    /// A gate publishes what the e-stop has locked on it, when that changes.
    pub(super) fn publish_locks(&mut self, robot: usize) {
        let locks = self.gate(robot).locks();
        if locks == self.locks[robot] {
            return;
        }
        self.locks[robot].clone_from(&locks);
        let from = self.gatekeeper(robot);
        let message = Message::Locks(locks.into());
        for other in (self.all_robots()).filter(|other| *other != robot) {
            self.send(from, self.gatekeeper(other), message.clone());
        }
        self.send(from, Node::Stopper, message);
    }

    /// A new subscriber receives what every gate that lives has last published of its locks.
    pub(super) fn ask_for_locks(&mut self, asking: Node) {
        for robot in self.all_robots() {
            let from = self.gatekeeper(robot);
            if from != asking && self.processes[self.slot(from)].is_up {
                let message = Message::Locks(self.locks[robot].clone().into());
                self.send(from, asking, message);
            }
        }
    }

    pub(super) fn stopper_receives(&mut self, from: Node, message: Message) {
        let event = match (message, from) {
            (Message::RobotStatus(status, _), Node::Robot(robot) | Node::Controller(robot)) => {
                stopper::Event::Status { robot: name(robot), status: (*status).clone() }
            }
            (Message::EStop(source, engaged), _) => {
                stopper::Event::EStop(e_stop::Message::State { source, engaged })
            }
            (Message::Locks(locks), Node::Robot(robot) | Node::Controller(robot)) => {
                // Robots of one process have one publisher, and here each its own.
                let Source(mut guid) = self.source(from);
                guid[15] = u8::try_from(robot).expect("there are few robots");
                let (reporter, locks) = (Source(guid), (*locks).clone());
                stopper::Event::EStop(e_stop::Message::Locks { reporter, locks })
            }
            (other, from) => panic!("a stopper receives {other:?} from {from:?}"),
        };
        self.deliver_to_stopper(event);
    }
}
