//! What a robot sees: what its own sensor detects, or what it would see of virtual robots.

use std::time::{Duration, Instant};

use rsrs_msgs::std_msgs::Bool;

/// The simulator publishes once per control period; after so long without a message there is none.
const FORGOTTEN_AFTER: Duration = Duration::from_millis(500);

/// The last message of the simulator on a robot in a mixed fleet; for other robots there is none.
#[derive(Clone, Copy, Debug, Default)]
pub struct VirtualDetection {
    seen: Option<Instant>,
}

impl VirtualDetection {
    /// Takes a message of the simulator at a time.
    pub fn receive(&mut self, detection: Bool, now: Instant) {
        self.seen = detection.data.then_some(now);
    }

    /// What the robot sees: its own detection, or that of a virtual robot.
    pub fn with(&self, detection: Bool, now: Instant) -> bool {
        let is_fresh = |at: Instant| now.saturating_duration_since(at) < FORGOTTEN_AFTER;
        detection.data || self.seen.is_some_and(is_fresh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEEN: Bool = Bool { data: true };
    const NOT_SEEN: Bool = Bool { data: false };

    #[test]
    fn a_virtual_robot_is_seen_beside_real_ones_until_the_simulator_falls_silent() {
        let mut detection = VirtualDetection::default();
        let start = Instant::now();
        assert!(!detection.with(NOT_SEEN, start));
        assert!(detection.with(SEEN, start));

        detection.receive(SEEN, start);

        assert!(detection.with(NOT_SEEN, start + Duration::from_millis(499)));
        assert!(!detection.with(NOT_SEEN, start + FORGOTTEN_AFTER), "it has gone");
        detection.receive(NOT_SEEN, start);
        assert!(!detection.with(NOT_SEEN, start));
        assert!(detection.with(SEEN, start), "the robot's own sensor counts whatever it reports");
    }
}
