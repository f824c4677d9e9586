//! What a robot sees: what its own sensor detects, or what it would see of virtual robots.

use std::time::{Duration, Instant};

/// The simulator speaks once per control period; after so long it has gone, and nobody is there.
const FORGOTTEN_AFTER: Duration = Duration::from_millis(500);

/// The last word of the simulator on a robot in a mixed fleet; of other robots it never speaks.
#[derive(Clone, Copy, Debug, Default)]
pub struct VirtualSight {
    seen: Option<Instant>,
}

impl VirtualSight {
    /// Takes what the simulator says at a time.
    pub fn hear(&mut self, detected: bool, now: Instant) {
        self.seen = detected.then_some(now);
    }

    /// What the robot sees: its own detection, or that of a virtual robot.
    pub fn with(&self, detected: bool, now: Instant) -> bool {
        let is_fresh = |at: Instant| now.saturating_duration_since(at) < FORGOTTEN_AFTER;
        detected || self.seen.is_some_and(is_fresh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_virtual_robot_is_seen_beside_real_ones_until_the_simulator_falls_silent() {
        let mut sight = VirtualSight::default();
        let start = Instant::now();
        assert!(!sight.with(false, start));
        assert!(sight.with(true, start));

        sight.hear(true, start);

        assert!(sight.with(false, start + Duration::from_millis(499)));
        assert!(!sight.with(false, start + FORGOTTEN_AFTER), "it has gone");
        sight.hear(false, start);
        assert!(!sight.with(false, start));
        assert!(sight.with(true, start), "the robot's own sensor counts whatever it says");
    }
}
