//! The stopper of the fleet, on the network with all other nodes.

use rsrs_fleet::stopper::{self, RobotAcknowledgement, StopCommand, StopOutcome};

use super::{Fleet, name};
use crate::network::{Message, Node};

/// What came of a stop or release.
#[derive(Debug)]
pub struct Stop {
    pub ending: StopOutcome,
    pub took_ms: u64,
    pub answers: Vec<RobotAcknowledgement>,
}

impl Fleet {
    pub(super) fn deliver_to_stopper(&mut self, event: stopper::Event) {
        let now = self.local(Node::Stopper);
        let Some((machine, _, since_ms)) = &mut self.stopper else { return };
        let (actions, took_ms) = (machine.on_event(event, now), self.now_ms - *since_ms);
        let answers = machine.answers();
        for action in actions {
            match action {
                stopper::Action::Publish(engaged) => {
                    self.publish_e_stop((Node::Stopper, engaged));
                }
                stopper::Action::Release(sources) => {
                    self.command_all(Node::Stopper, &Message::Release(sources.into()));
                }
                stopper::Action::Finish(ending) => {
                    self.note(|| format!("stopper: {ending:?}"));
                    self.story.stops.push(Stop { ending, took_ms, answers: answers.clone() });
                    self.stopper = None;
                    let slot = self.slot(Node::Stopper);
                    self.processes[slot].is_up = false;
                }
            }
        }
    }

    /// A robot that is reported to have acknowledged a stop has received it.
    pub(super) fn judge_stop(&self) -> Result<(), String> {
        let Some((stopper, StopCommand::Engage, _)) = &self.stopper else { return Ok(()) };
        // It may have received statuses of some robots only.
        for (robot, oracle) in self.oracles.iter().enumerate() {
            let Some(answer) = stopper.answers().into_iter().find(|it| it.robot == name(robot))
            else {
                continue;
            };
            if answer.acknowledged_after.is_some() && !oracle.was_locked(self.now_ms) {
                return Err(format!("{answer:?}, and has not received the e-stop"));
            }
        }
        Ok(())
    }
}
