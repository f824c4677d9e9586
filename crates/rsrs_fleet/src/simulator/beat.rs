//! What the simulator says of itself: on every change, and ten times a second.

use std::time::Duration;

use crate::message::{RobotState, Status};
use crate::timing::BEAT;

/// How it stands with the simulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Standing<'a> {
    pub state: RobotState,
    /// Names the placed world; 0 is none.
    pub digest: u64,
    /// Why it does not move; empty while it does.
    pub reason: &'a str,
}

/// The statuses said so far.
#[derive(Clone, Debug, Default)]
pub(super) struct Beat {
    last: Option<(Status, Duration)>,
}

impl Beat {
    /// The status to say now, if one is due.
    pub fn due(&mut self, standing: Standing<'_>, now: Duration) -> Option<Status> {
        let counter = match &self.last {
            None => 1,
            Some((said, at)) => {
                let is_news = standing
                    != Standing {
                        state: said.state,
                        digest: said.parameter_digest,
                        reason: &said.stop_reason,
                    };
                if !is_news && now.saturating_sub(*at) < BEAT {
                    return None;
                }
                said.counter + 1
            }
        };
        let status = Status {
            counter,
            epoch: 0,
            parameter_digest: standing.digest,
            state: standing.state,
            stop_reason: standing.reason.to_owned(),
            battery_v: f32::NAN,
        };
        self.last = Some((status.clone(), now));
        Some(status)
    }
}
