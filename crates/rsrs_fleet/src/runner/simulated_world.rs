//! Whether the simulator still has the world of the run.

use crate::message::Status;
use crate::robot::WORLD_REPLACED;

/// Why a run is void whose world has gone.
pub(crate) fn world_replaced() -> String {
    format!("simulator: {WORLD_REPLACED}")
}

/// What the simulator has reported of the world that was placed for a run.
///
/// It refuses to replace a world while a run binds one of its robots, or, where it is only the sensors and
/// wheels of robot nodes, while one of them moves. At other times (before the start, in a pause, when leases
/// have lapsed, while all commands are zero) somebody else may place another one, or the same anew.
#[derive(Clone, Debug, Default)]
pub(super) struct SimulatedWorld {
    /// Of the newest status that named this world: its number, and the world's.
    newest: Option<(u64, u64)>,
    has_started: bool,
}

impl SimulatedWorld {
    /// The robots may move: until now, the same world placed once more is as good as the first.
    pub fn start(&mut self) {
        self.has_started = true;
    }

    /// Takes a status of the simulator, and returns whether the world with this digest, once a status
    /// has named it, is still there.
    pub fn goes_on(&mut self, status: &Status, digest: u64) -> bool {
        let is_it = status.parameter_digest == digest;
        match self.newest {
            // An old status that comes late is no news.
            Some((counter, _)) if status.counter <= counter => return true,
            Some((_, world)) if !is_it || self.has_started && status.epoch != world => {
                return false;
            }
            _ => {}
        }
        if is_it {
            self.newest = Some((status.counter, status.epoch));
        }
        true
    }
}
