//! Printing from a thread of its own: a terminal that is stopped (Ctrl-S), or a pipe that nobody reads,
//! holds up nobody who has deadlines.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How long the end of a program waits for a terminal that takes nothing.
const PATIENCE: Duration = Duration::from_secs(1);
const POLL_PERIOD: Duration = Duration::from_millis(2);

/// What a printing thread is given.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Printed<T> {
    /// Something to print.
    This(T),
    /// So many things were left out before the next one, because the queue was full.
    LeftOut(u64),
}

/// A thread that prints, behind a queue with bounds.
#[derive(Debug)]
pub struct Printer<T> {
    /// `None` only while it is dropped.
    queue: Option<SyncSender<T>>,
    counts: Arc<Counts>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Counts {
    queued: AtomicU64,
    printed: AtomicU64,
    left_out: AtomicU64,
}

impl Counts {
    /// What was left out since the last call.
    fn take_left_out(&self) -> Option<u64> {
        let n_left_out = self.left_out.swap(0, Ordering::Relaxed);
        (n_left_out > 0).then_some(n_left_out)
    }
}

impl<T: Send + 'static> Printer<T> {
    /// Starts the thread, and in it calls `make` for what prints there. At most `room` things wait.
    pub fn start<P: FnMut(Printed<T>)>(
        room: usize,
        make: impl FnOnce() -> P + Send + 'static,
    ) -> io::Result<Self> {
        let (queue, things) = sync_channel(room);
        let counts = Arc::new(Counts::default());
        let of_thread = Arc::clone(&counts);
        let thread = std::thread::Builder::new().name("printer".to_owned()).spawn(move || {
            let mut print = make();
            for thing in things {
                if let Some(n_left_out) = of_thread.take_left_out() {
                    print(Printed::LeftOut(n_left_out));
                }
                print(Printed::This(thing));
                of_thread.printed.fetch_add(1, Ordering::Release);
            }
            if let Some(n_left_out) = of_thread.take_left_out() {
                print(Printed::LeftOut(n_left_out));
            }
        })?;
        Ok(Self { queue: Some(queue), counts, thread: Some(thread) })
    }

    /// Has something printed. It never waits; what finds the queue full is counted and left out.
    pub fn print(&self, thing: T) {
        if self.try_print(thing) {
            return;
        }
        self.counts.left_out.fetch_add(1, Ordering::Relaxed);
    }

    /// As [`Printer::print`], of what nobody misses if it is left out, such as how far a bar is.
    pub fn print_if_there_is_room(&self, thing: T) {
        self.try_print(thing);
    }

    fn try_print(&self, thing: T) -> bool {
        let queue = self.queue.as_ref().expect("it is taken only while this is dropped");
        match queue.try_send(thing) {
            Ok(()) => {
                self.counts.queued.fetch_add(1, Ordering::Relaxed);
                true
            }
            Err(TrySendError::Full(_)) => false,
            // The thread has panicked, which was reported; nothing is printed any more.
            Err(TrySendError::Disconnected(_)) => true,
        }
    }

    /// Waits until everything so far is printed, but not for a terminal that takes nothing.
    pub fn flush(&self) {
        let queued = self.counts.queued.load(Ordering::Relaxed);
        let has_ended = || self.thread.as_ref().is_none_or(JoinHandle::is_finished);
        let printed = || self.counts.printed.load(Ordering::Acquire);
        wait_while_it_prints(printed, || printed() >= queued || has_ended());
    }
}

/// Waits until something is so, or nothing was printed for a while.
fn wait_while_it_prints(printed: impl Fn() -> u64, is_done: impl Fn() -> bool) {
    let (mut last, mut since) = (printed(), Instant::now());
    while !is_done() && since.elapsed() < PATIENCE {
        std::thread::sleep(POLL_PERIOD);
        if printed() != last {
            (last, since) = (printed(), Instant::now());
        }
    }
}

impl<T> Drop for Printer<T> {
    /// Everything is printed, unless the terminal takes nothing.
    fn drop(&mut self) {
        self.queue = None;
        let Some(thread) = self.thread.take() else { return };
        let printed = || self.counts.printed.load(Ordering::Acquire);
        wait_while_it_prints(printed, || thread.is_finished());
        if thread.is_finished() {
            // A panic was reported as what it was.
            drop(thread.join());
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::sync::mpsc::channel;

    use super::*;

    #[test]
    fn everything_is_printed_in_order_before_the_end() {
        let printed = Arc::new(Mutex::new(Vec::new()));
        let to_test = Arc::clone(&printed);
        let printer =
            Printer::start(1000, || move |thing| to_test.lock().unwrap().push(thing)).unwrap();

        for number in 0..500 {
            printer.print(number);
        }
        printer.flush();
        let flushed = printed.lock().unwrap().len();
        drop(printer);

        assert_eq!(flushed, 500);
        assert_eq!(*printed.lock().unwrap(), (0..500).map(Printed::This).collect::<Vec<_>>());
    }

    #[test]
    fn a_terminal_that_takes_nothing_holds_up_nobody_and_what_was_left_out_is_counted() {
        let (go, gone) = channel::<()>();
        let (to_test, printed) = channel();
        let print = move |thing| {
            if thing == Printed::This(0) {
                gone.recv().expect("the test is there");
            }
            to_test.send(thing).expect("the test is there");
        };
        let printer = Printer::start(2, || print).unwrap();

        printer.print(0);
        // The first is taken from the queue at once, or in a moment; the terminal takes no second one
        // before all are handed over.
        for number in 1..=10_000 {
            printer.print(number);
        }
        go.send(()).unwrap();
        drop(printer);

        let printed: Vec<_> = printed.iter().collect();
        let (mut n_printed, mut n_left_out) = (0, 0);
        for thing in &printed {
            match thing {
                Printed::This(_) => n_printed += 1,
                Printed::LeftOut(more) => n_left_out += more,
            }
        }
        assert_eq!(n_printed + n_left_out, 10_001);
        assert!(n_printed <= 4, "{printed:?}");
    }

    #[test]
    fn the_end_does_not_wait_for_a_terminal_that_takes_nothing() {
        let (_go, gone) = channel::<()>();
        let printer =
            Printer::start(2, || move |_: Printed<u8>| gone.recv().unwrap_or_default()).unwrap();

        printer.print(0);
        let start = Instant::now();
        printer.flush();
        drop(printer);

        assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
    }
}
