//! Who stops the fleet, on the network with everybody else.

use rsrs_fleet::stopper::{self, Answer, Ending};

use super::Fleet;
use crate::network::{Message, Node};
use crate::scenario::N_ROBOTS;

/// What came of a stop or release.
#[derive(Debug)]
pub struct Stop {
    pub ending: Ending,
    pub took_ms: u64,
    pub answers: Vec<Answer>,
}

impl Fleet {
    pub(super) fn tell_stopper(&mut self, event: stopper::Event) {
        let now = self.local(Node::Stopper);
        let Some((machine, since_ms)) = &mut self.stopper else { return };
        let (actions, took_ms) = (machine.on_event(event, now), self.now_ms - *since_ms);
        let answers = machine.answers();
        for action in actions {
            match action {
                stopper::Action::Say(engaged) => {
                    for robot in 0..N_ROBOTS {
                        self.send(Node::Stopper, Node::Robot(robot), &Message::EStop(engaged));
                    }
                    for runner in 0..2 {
                        self.send(Node::Stopper, Node::Runner(runner), &Message::EStop(engaged));
                    }
                }
                stopper::Action::Finish(ending) => {
                    self.story.stops.push(Stop { ending, took_ms, answers: answers.clone() });
                    self.stopper = None;
                }
            }
        }
    }

    /// Whoever is said to have acknowledged a stop has heard it, and whoever has not is named.
    pub(super) fn judge_stop(&self) -> Result<(), String> {
        let Some((stopper, _)) = &self.stopper else { return Ok(()) };
        if self.scenario.release_ms.is_some() {
            return Ok(());
        }
        for (answer, witness) in stopper.answers().iter().zip(&self.witnesses) {
            if answer.acknowledged_after.is_some() && !witness.has_heard_e_stop() {
                return Err(format!("{answer:?}, and has not heard the e-stop"));
            }
        }
        Ok(())
    }
}
