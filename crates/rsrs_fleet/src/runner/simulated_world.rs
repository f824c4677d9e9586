//! Whether the simulator still has the world of the run.

use crate::message::{RobotState, Status};

/// What the simulator has reported of the world that was placed for a run.
///
/// A simulator that is only the sensors and wheels of robot nodes holds its world while one of them
/// moves, and not in a countdown or a pause: then, somebody else may place another one.
#[derive(Clone, Debug, Default)]
pub(super) struct SimulatedWorld {
    /// Of its newest status that named this world: its number, and whether the run's time goes on in it.
    newest: Option<(u64, bool)>,
}

impl SimulatedWorld {
    /// Takes a status that may be of the world with this digest, and returns whether this world has
    /// gone since one named it. After the run `has_started`, one that waits for its start is another.
    pub fn is_replaced(&mut self, status: &Status, digest: u64, has_started: bool) -> bool {
        let is_it = status.parameter_digest == digest;
        let goes_on = has_started && status.state != RobotState::Armed;
        match self.newest {
            // An old status that comes late is no news.
            Some((counter, _)) if status.counter <= counter => false,
            Some((_, went_on)) if !is_it || went_on && !goes_on => true,
            _ => {
                if is_it {
                    self.newest = Some((status.counter, goes_on));
                }
                false
            }
        }
    }
}
