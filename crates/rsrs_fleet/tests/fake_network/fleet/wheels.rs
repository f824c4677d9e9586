//! Who is in front of the wheels of each robot, and whether they turn.

use rsrs_core::robot::controller::Command;
use rsrs_fleet::robot::Robot;

use super::Fleet;
use crate::network::Node;

impl Fleet {
    /// The node that stands between velocity commands and the wheels, or, for lack of one there, the
    /// node that they come from.
    pub(super) fn gatekeeper(&self, robot: usize) -> Node {
        if self.scenario.controller_only[robot] {
            Node::Controller(robot)
        } else {
            Node::Robot(robot)
        }
    }

    pub(super) fn gate(&self, robot: usize) -> &Robot {
        self.controllers[robot].gate().unwrap_or(&self.robots[robot].gate)
    }

    pub(super) fn is_awake(&self, node: Node) -> bool {
        let process = self.processes[self.slot(node)];
        process.is_up && self.now_ms > process.stalled_until_ms
    }

    /// What turns the wheels of a robot; of one without a gate, what its controller commands while
    /// it can publish: when it cannot, only the robot's own timeout helps.
    pub(super) fn turning(&self, robot: usize) -> Option<Command> {
        if !self.scenario.controller_only[robot] {
            return self.robots[robot].turning(self.now_ms);
        }
        let is_awake = self.is_awake(Node::Controller(robot));
        self.mouths[robot].filter(|command_sent| is_awake && *command_sent != Command::STOP)
    }
}
