//! Pauses between new endpoints, without which the middleware loses some of them.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// Endpoints between two pauses.
const BURST: usize = 16;
/// A pause: at some 200 endpoints in a row the middleware's queue of commands overflows, and with
/// this pause it does not, at 1,200 of them.
const PAUSE: Duration = Duration::from_millis(4);

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
