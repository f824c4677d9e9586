//! Pauses between new endpoints, without which the middleware loses some of them.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use super::SessionError;

/// Endpoints between two pauses.
const BURST: usize = 16;
/// A pause: at some 200 endpoints in a row the middleware's queue of commands overflows, and with
/// this pause it does not, at 1,200 of them.
const PAUSE: Duration = Duration::from_millis(4);

/// What the middleware says when its queue has overflown all the same, because its thread is busy:
/// dozens of participants that come at once keep it so for seconds.
const QUEUE_IS_FULL: &str = "sending on a full channel";
/// After so long the queue has had room for something.
const ROOM: Duration = Duration::from_millis(20);
/// How long to wait for room.
const PATIENCE: Duration = Duration::from_secs(20);

/// Counts new endpoints.
#[derive(Debug, Default)]
pub(super) struct Pace {
    n_endpoints: AtomicUsize,
}

impl Pace {
    /// Makes room for new endpoints. Blocks for a few milliseconds now and then.
    pub(super) fn wait(&self, n_endpoints: usize) {
        let before = self.n_endpoints.fetch_add(n_endpoints, Ordering::Relaxed);
        if before / BURST != (before + n_endpoints) / BURST {
            std::thread::sleep(PAUSE);
        }
    }
}

/// Makes an endpoint, again and again while the middleware has no room for it. Blocks meanwhile.
pub(super) fn persist<T>(
    mut make: impl FnMut() -> Result<T, SessionError>,
) -> Result<T, SessionError> {
    let start = Instant::now();
    loop {
        match make() {
            Err(SessionError::Endpoint { reason, .. })
                if reason.contains(QUEUE_IS_FULL) && start.elapsed() < PATIENCE =>
            {
                std::thread::sleep(ROOM);
            }
            made => return made,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn failed(reason: &str) -> Result<usize, SessionError> {
        Err(SessionError::endpoint("rt/clock", &reason))
    }

    #[test]
    fn a_full_queue_is_tried_again_and_other_failures_are_not() {
        let mut n_tries = 0;
        let made = persist(|| {
            n_tries += 1;
            if n_tries < 3 { failed("DataReader: sending on a full channel") } else { Ok(n_tries) }
        });
        assert_eq!(made.ok(), Some(3));

        let mut n_tries = 0;
        let made = persist(|| {
            n_tries += 1;
            failed("out of resources")
        });
        assert!(made.is_err());
        assert_eq!(n_tries, 1);
    }
}
