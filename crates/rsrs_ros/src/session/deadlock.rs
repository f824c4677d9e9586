//! A middleware whose threads wait for each other while an endpoint is made, for ever.
//!
//! Who makes an endpoint waits to write what is known of the network. `RustDDS` 0.15 reads it while it
//! hands on what it has found, of which another of its threads has room for a little; and that thread
//! waits to read it behind who wants to write. It takes a participant that comes at such a moment, and
//! so happens to programs that start beside many others, once in some hundred times: nothing fails, and
//! nobody ever finds their nodes. It cannot be mended from outside, but seen: none of these threads has
//! had a processor, or waited for one, while the endpoint was not made.

use std::collections::BTreeSet;
use std::os::unix::process::CommandExt;
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use nix::unistd::gettid;

use super::lock;
use crate::{kernel, logging};

/// How often to look.
const POLL_PERIOD: Duration = Duration::from_secs(1);
/// So many looks without any progress are a deadlock: whichever thread is not waiting for another one
/// wakes several times a second.
const LOOKS: usize = 3;

/// Whether this program starts again then, because nothing is lost with it.
static STARTS_AGAIN: AtomicBool = AtomicBool::new(false);

/// Has this program start again, as it was started, when the middleware is in a deadlock. Others end.
pub fn start_again_after_deadlock() {
    STARTS_AGAIN.store(true, Ordering::Relaxed);
}

/// Watches what is made in a session.
#[derive(Debug)]
pub(super) struct Watchdog {
    /// The thread that begins, and `None` when it is done.
    makes: Mutex<Sender<Option<u32>>>,
}

impl Watchdog {
    /// Begins to watch the threads of the middleware.
    pub(super) fn new(threads: BTreeSet<u32>) -> Self {
        Self::with(threads, (POLL_PERIOD, give_up))
    }

    fn with(threads: BTreeSet<u32>, (look, give_up): (Duration, fn())) -> Self {
        let (makes, begun) = channel();
        let watch = move || watch(&begun, &threads, look, give_up);
        // Without a thread nothing is watched, and nothing else is lost.
        drop(std::thread::Builder::new().name("watchdog".to_owned()).spawn(watch));
        Self { makes: Mutex::new(makes) }
    }

    /// Makes something, watched.
    pub(super) fn watching<T>(&self, make: impl FnOnce() -> T) -> T {
        let _watched = Watched::begin(self);
        make()
    }

    fn tell(&self, begun: Option<u32>) {
        // Without a thread nobody listens.
        lock(&self.makes).send(begun).ok();
    }
}

/// Something that is being made, whichever way it ends.
struct Watched<'a>(&'a Watchdog);

impl<'a> Watched<'a> {
    fn begin(watchdog: &'a Watchdog) -> Self {
        watchdog.tell(Some(gettid().as_raw().cast_unsigned()));
        Self(watchdog)
    }
}

impl Drop for Watched<'_> {
    fn drop(&mut self) {
        self.0.tell(None);
    }
}

fn watch(
    begun: &Receiver<Option<u32>>,
    threads: &BTreeSet<u32>,
    look: Duration,
    give_up: impl Fn(),
) {
    while let Ok(maker) = begun.recv() {
        let Some(maker) = maker else { continue };
        let progress = || -> Vec<Option<String>> {
            let all = threads.iter().chain([&maker]);
            all.map(|thread| kernel::scheduled(*thread)).collect()
        };
        let (mut before, mut looks) = (progress(), 0);
        while let Err(RecvTimeoutError::Timeout) = begun.recv_timeout(look) {
            let now = progress();
            looks = if now == before { looks + 1 } else { 0 };
            before = now;
            if looks == LOOKS {
                give_up();
                break;
            }
        }
    }
}

/// Ends this process, or starts it again.
fn give_up() {
    let starts_again = STARTS_AGAIN.load(Ordering::Relaxed);
    let what = if starts_again { "starting again" } else { "start this program again" };
    log::error!(
        "the threads of the middleware wait for each other, as they can when many programs start at \
         once: {what}"
    );
    logging::flush();
    if starts_again {
        let mut arguments = std::env::args_os();
        let name = arguments.next().unwrap_or_default();
        let error = Command::new("/proc/self/exe").arg0(name).args(arguments).exec();
        log::error!("it cannot be started: {error}");
        logging::flush();
    }
    kernel::exit_at_once(1);
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicUsize;

    use super::*;

    const POLL_PERIOD: Duration = Duration::from_millis(30);

    #[test]
    fn threads_that_do_nothing_while_something_is_not_made_are_a_deadlock() {
        static GIVEN_UP: AtomicUsize = AtomicUsize::new(0);
        let watchdog = Watchdog::with(
            BTreeSet::new(),
            (POLL_PERIOD, || {
                GIVEN_UP.fetch_add(1, Ordering::Relaxed);
            }),
        );

        watchdog.watching(|| std::thread::sleep(POLL_PERIOD));
        assert_eq!(GIVEN_UP.load(Ordering::Relaxed), 0, "it was made");
        watchdog.watching(|| {
            while GIVEN_UP.load(Ordering::Relaxed) == 0 {
                // It waits for another thread in one go.
                std::thread::sleep(POLL_PERIOD * 20);
            }
        });

        assert_eq!(GIVEN_UP.load(Ordering::Relaxed), 1);
    }

    #[test]
    fn who_works_is_in_no_deadlock_however_long_it_takes() {
        let watchdog =
            Watchdog::with(BTreeSet::new(), (POLL_PERIOD, || panic!("it works, if slowly")));

        watchdog.watching(|| {
            for _ in 0..40 {
                std::thread::sleep(POLL_PERIOD / 4);
            }
        });
    }
}
