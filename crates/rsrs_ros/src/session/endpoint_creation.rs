//! Pauses between new endpoints, without which the middleware loses some of them.

use std::collections::BTreeSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use super::deadlock::Watchdog;
use super::{SessionError, lock};

/// Endpoints between two pauses.
const BURST: usize = 16;
/// The first pause: at some 200 endpoints in a row the middleware's queues overflow, and with this
/// pause they do not.
const PAUSE: Duration = Duration::from_millis(4);
/// So many endpoints make the pause longer by itself: the middleware compares each new one with all
/// others, and one that its discovery has no room for receives nothing without an error.
const SLOWER: usize = 500;

/// The middleware's error when its queue has overflown all the same, because its thread is busy:
/// dozens of participants that come at once keep it so for seconds.
const QUEUE_IS_FULL: &str = "sending on a full channel";
/// After so long the queue has had room for something.
const ROOM: Duration = Duration::from_millis(20);
/// How long to wait for room.
const TIMEOUT: Duration = Duration::from_secs(20);

/// Two threads that make endpoints at once can wait for each other for ever in a secured session: the
/// middleware locks participant and security plugins in both orders.
static CREATION: Mutex<()> = Mutex::new(());

#[derive(Debug)]
pub(super) struct EndpointCreation {
    n_endpoints: AtomicUsize,
    watchdog: Watchdog,
}

impl EndpointCreation {
    /// Nothing is made so far; `threads` are those of the middleware.
    pub(super) fn new(threads: BTreeSet<u32>) -> Self {
        Self { n_endpoints: AtomicUsize::new(0), watchdog: Watchdog::new(threads) }
    }

    /// Makes new endpoints, one caller at a time, and again while the middleware has no room for them.
    /// Blocks meanwhile, and for a few milliseconds now and then.
    pub(super) fn make<T>(
        &self,
        n_endpoints: usize,
        mut make: impl FnMut() -> Result<T, SessionError>,
    ) -> Result<T, SessionError> {
        self.wait(n_endpoints);
        persist(|| {
            let _alone = lock(&CREATION);
            self.watchdog.watching(&mut make)
        })
    }

    fn wait(&self, n_endpoints: usize) {
        let before = self.n_endpoints.fetch_add(n_endpoints, Ordering::Relaxed);
        if before / BURST != (before + n_endpoints) / BURST {
            std::thread::sleep(pause(before));
        }
    }
}

fn pause(n_endpoints: usize) -> Duration {
    let times = 1 + u32::try_from(n_endpoints / SLOWER).unwrap_or(u32::MAX - 1);
    PAUSE.saturating_mul(times)
}

/// Makes an endpoint, again and again while the middleware has no room for it. Blocks meanwhile.
fn persist<T>(mut make: impl FnMut() -> Result<T, SessionError>) -> Result<T, SessionError> {
    let start = Instant::now();
    loop {
        match make() {
            Err(SessionError::Endpoint { reason, .. })
                if reason.contains(QUEUE_IS_FULL) && start.elapsed() < TIMEOUT =>
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
    fn the_pause_grows_with_the_number_of_endpoints() {
        assert_eq!([0, 2_000].map(pause), [PAUSE, PAUSE * 5]);
    }

    #[test]
    fn no_two_threads_make_endpoints_at_once() {
        let (endpoint_creation, n_making) =
            (EndpointCreation::new(BTreeSet::new()), AtomicUsize::new(0));

        std::thread::scope(|scope| {
            for _ in 0..4 {
                scope.spawn(|| {
                    let made = endpoint_creation.make(1, || {
                        let others = n_making.fetch_add(1, Ordering::SeqCst);
                        std::thread::sleep(Duration::from_millis(5));
                        n_making.fetch_sub(1, Ordering::SeqCst);
                        Ok(others)
                    });
                    assert_eq!(made.ok(), Some(0));
                });
            }
        });
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
