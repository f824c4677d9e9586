//! The middleware's own threads, and whether they still run.
//!
//! A thread that waits for packets ends for good when a signal interrupts its wait, as happens when a
//! process is stopped (`SIGSTOP`, Ctrl-Z) and continued: from then on nothing is sent or received,
//! and no call fails. That a thread is gone can be seen for certain and without any network
//! traffic, while a heartbeat that is late may as well be late because the machine is busy.

use std::collections::BTreeSet;
use std::io;
use std::sync::Mutex;

use super::{SessionEnded, SessionError, lock};
use crate::kernel;

/// Start of the names that the middleware gives its threads.
const NAME: &str = "RustDDS";
/// While a participant is made, its threads must not be mixed up with those of another.
static MAKING: Mutex<()> = Mutex::new(());

/// The threads of one participant.
#[derive(Debug)]
pub(super) struct Threads {
    ids: BTreeSet<u32>,
}

impl Threads {
    /// Makes a participant, and remembers which threads it started.
    pub(super) fn started_by<T>(
        make: impl FnOnce() -> Result<T, SessionError>,
    ) -> Result<(T, Self), SessionError> {
        let _alone = lock(&MAKING);
        let failed = |source| SessionError::Threads { source };
        let before = running().map_err(failed)?;
        // A signal that meets one of them ends its loop: it does not poll again.
        let made = kernel::without_signals(make).map_err(failed)??;
        let ids: BTreeSet<u32> = running().map_err(failed)?.difference(&before).copied().collect();
        assert!(!ids.is_empty(), "a participant has threads, and they have names");
        Ok((made, Self { ids }))
    }

    pub(super) fn ids(&self) -> BTreeSet<u32> {
        self.ids.clone()
    }

    /// Whether one of them has ended.
    pub(super) fn have_ended(&self) -> Option<SessionEnded> {
        let expected = self.ids.len();
        // A table that cannot be read now is read again.
        let found = running().map_or(expected, |now| self.ids.intersection(&now).count());
        (found < expected).then_some(SessionEnded::Middleware { found, expected })
    }

    /// Whether all of them wait, and so none is about to end.
    pub(super) fn are_asleep(&self) -> bool {
        self.ids.iter().all(|id| kernel::is_asleep(*id))
    }
}

/// Threads of the middleware in this process.
fn running() -> io::Result<BTreeSet<u32>> {
    kernel::threads_named(NAME)
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Sender, channel};
    use std::thread::JoinHandle;
    use std::time::Duration;

    use super::*;

    /// A thread as the middleware has them, which waits for its end.
    fn waiting_thread() -> (Sender<()>, JoinHandle<()>, Threads) {
        let (end, ends) = channel();
        let (started, given) = channel();
        let (thread, threads) = Threads::started_by(|| {
            let thread = std::thread::Builder::new().name(format!("{NAME} of a test"));
            let spawned = thread.spawn(move || {
                started.send(()).unwrap();
                ends.recv().unwrap();
            });
            given.recv().unwrap();
            Ok(spawned.unwrap())
        })
        .unwrap();
        (end, thread, threads)
    }

    #[test]
    fn no_thread_of_the_middleware_receives_a_signal() {
        let (end, thread, threads) = waiting_thread();

        for id in &threads.ids {
            let status = std::fs::read_to_string(format!("/proc/self/task/{id}/status")).unwrap();
            let blocked = status.lines().find_map(|line| line.strip_prefix("SigBlk:")).unwrap();
            let blocked = u64::from_str_radix(blocked.trim(), 16).unwrap();
            for signal in [libc::SIGINT, libc::SIGTERM, libc::SIGCHLD, libc::SIGWINCH] {
                assert!(blocked >> (signal - 1) & 1 == 1, "{signal} is not blocked: {blocked:x}");
            }
        }
        end.send(()).unwrap();
        thread.join().unwrap();
    }

    #[test]
    fn a_thread_that_waits_is_asleep_and_one_that_works_is_not() {
        let (end, thread, threads) = waiting_thread();
        let here = std::fs::read_link("/proc/thread-self").unwrap();
        let here = here.file_name().unwrap().to_str().unwrap().parse().unwrap();

        let waits = (0..100).any(|_| {
            std::thread::sleep(Duration::from_millis(20));
            threads.are_asleep()
        });
        let works = Threads { ids: BTreeSet::from([here]) };

        assert!(waits);
        assert!(!works.are_asleep());
        end.send(()).unwrap();
        thread.join().unwrap();
    }

    #[test]
    fn a_thread_that_ends_is_noticed_and_one_that_runs_is_not() {
        let (end, thread, threads) = waiting_thread();

        let early = threads.have_ended();
        end.send(()).unwrap();
        thread.join().unwrap();
        // The kernel removes a thread from its table a moment after its end.
        let ended = (0..100).find_map(|_| {
            std::thread::sleep(Duration::from_millis(20));
            threads.have_ended()
        });

        assert_eq!(early, None);
        assert_eq!(ended, Some(SessionEnded::Middleware { found: 0, expected: 1 }));
    }
}
