//! Leaving a network in time.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use tokio::sync::oneshot;

use crate::logging;

/// How long the middleware may take to end its threads. They can wait for each other for ever when
/// many participants come at once; a service that stops a node waits for 5 s.
const DEADLINE: Duration = Duration::from_secs(4);

/// Whether a session of this process could not be left.
static IS_STUCK: AtomicBool = AtomicBool::new(false);

/// Whether a session of this process could not be left in time.
pub(crate) fn is_stuck() -> bool {
    IS_STUCK.load(Ordering::Relaxed)
}

/// Runs `leave` in a thread of its own, for which nobody waits longer than the deadline.
///
/// # Panics
///
/// If `leave` panics.
pub(super) async fn within_deadline(leave: impl FnOnce() + Send + 'static) {
    within(DEADLINE, leave).await;
    logging::flush();
}

async fn within(deadline: Duration, leave: impl FnOnce() + Send + 'static) {
    let (left, has_left) = oneshot::channel();
    // No thread of the runtime, which would wait for it at its own end.
    std::thread::spawn(move || {
        leave();
        // Nobody waits any more if it took too long.
        left.send(()).ok();
    });
    match tokio::time::timeout(deadline, has_left).await {
        Ok(left) => left.expect("dropping handles does not panic"),
        Err(_elapsed) => {
            IS_STUCK.store(true, Ordering::Relaxed);
            log::warn!(
                "the middleware has not ended within {:.0} s and is left behind: others take this \
                 program for alive for the better part of a minute",
                deadline.as_secs_f64()
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(flavor = "current_thread")]
    async fn who_does_not_leave_in_time_is_left_behind() {
        within(Duration::from_secs(60), || {}).await;
        let before = is_stuck();

        within(Duration::from_millis(10), || std::thread::sleep(Duration::from_secs(3600))).await;

        assert!(!before && is_stuck());
    }
}
