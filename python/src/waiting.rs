//! Long work beside a Python that goes on: other threads run, progress is shown, Ctrl-C is obeyed.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use pyo3::prelude::*;
use pyo3::types::PyBool;
use rsrs_pipeline::execution::{Execution, MOST_THREADS, Observer, RunCounter, n_threads};
use rsrs_sim::sweep::Progress as Done;

use crate::error::{panicked, raised, refused};

/// How often progress is shown and signals are looked for: nobody notices the delay, and it costs nothing.
const POLL_PERIOD: Duration = Duration::from_millis(20);

/// Who is told how far work has come.
pub enum Progress {
    /// Nobody.
    None,
    /// A line on the standard error of Python.
    Line,
    /// A function of what is being done, what of it is done, and how much there is.
    Call(Py<PyAny>),
}

impl Progress {
    /// `None`, `False`, `True`, or a function.
    pub fn new(value: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let Some(value) = value else { return Ok(Self::None) };
        if let Ok(is_line) = value.cast::<PyBool>() {
            return Ok(if is_line.is_true() { Self::Line } else { Self::None });
        }
        if !value.is_callable() {
            return Err(refused(
                "progress is neither True or False nor a function of (doing, done, total)",
            ));
        }
        Ok(Self::Call(value.clone().unbind()))
    }

    fn show(&self, py: Python<'_>, doing: &str, done: Done) -> PyResult<()> {
        match self {
            Self::None => {}
            Self::Line => {
                let line = format!("\r{doing}: {} of {} runs", done.done, done.total);
                let end = if done.done == done.total { "\n" } else { "" };
                let stderr = py.import("sys")?.getattr("stderr")?;
                stderr.call_method1("write", (line + end,))?;
                stderr.call_method0("flush")?;
            }
            Self::Call(function) => {
                function.call1(py, (doing, done.done, done.total))?;
            }
        }
        Ok(())
    }
}

/// How far work has come, as the last thread to report it has it.
#[derive(Default)]
struct Latest {
    shown: Mutex<Option<(String, Done)>>,
    cancel: AtomicBool,
}

impl Latest {
    fn take(&self) -> Option<(String, Done)> {
        self.shown.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

impl Observer for Latest {
    fn count(&self, doing: &str, _what: &'static str) -> Box<dyn RunCounter + '_> {
        Box::new(Counter { latest: self, doing: Mutex::new(doing.to_owned()) })
    }

    fn cancel(&self) -> &AtomicBool {
        &self.cancel
    }
}

struct Counter<'a> {
    latest: &'a Latest,
    doing: Mutex<String>,
}

impl RunCounter for Counter<'_> {
    fn begin(&self, doing: &str, start: Done) {
        doing.clone_into(&mut self.doing.lock().unwrap_or_else(PoisonError::into_inner));
        self.show(start);
    }

    fn show(&self, progress: Done) {
        let doing = self.doing.lock().unwrap_or_else(PoisonError::into_inner).clone();
        *self.latest.shown.lock().unwrap_or_else(PoisonError::into_inner) = Some((doing, progress));
    }
}

/// Checks a number of threads; none is as many as the machine runs at once.
fn threads(wanted: Option<usize>) -> PyResult<usize> {
    match wanted {
        None => Ok(n_threads()),
        Some(n) if (1..=MOST_THREADS).contains(&(n as u64)) => Ok(n),
        Some(n) => Err(refused(format!("threads is {n}, expected from 1 to {MOST_THREADS}"))),
    }
}

/// Works without the interpreter's lock until it is done, or a signal or `progress` raises: the work is
/// called off then, and what it raised is what the caller gets.
pub fn work<T: Send>(
    py: Python<'_>,
    wanted: Option<usize>,
    progress: &Progress,
    work: impl FnOnce(Execution<'_>) -> anyhow::Result<T> + Send,
) -> PyResult<T> {
    let n_threads = threads(wanted)?;
    let latest = Latest::default();
    let (outcome, interrupt) = py.detach(|| {
        std::thread::scope(|scope| {
            let (send, receive) = channel();
            let observer = &latest;
            scope.spawn(move || {
                let execution = Execution { n_threads, observer };
                let outcome = catch_unwind(AssertUnwindSafe(|| work(execution)));
                // The other side waits for it.
                drop(send.send(outcome));
            });
            let mut interrupt = None;
            loop {
                match receive.recv_timeout(POLL_PERIOD) {
                    Ok(outcome) => return (outcome, interrupt),
                    Err(RecvTimeoutError::Disconnected) => {
                        unreachable!("the thread sends before it ends")
                    }
                    Err(RecvTimeoutError::Timeout) if interrupt.is_some() => {}
                    Err(RecvTimeoutError::Timeout) => {
                        interrupt = Python::attach(|py| look(py, &latest, progress)).err();
                        latest.cancel.store(interrupt.is_some(), Ordering::Relaxed);
                    }
                }
            }
        })
    });
    if let Some(interrupt) = interrupt {
        return Err(interrupt);
    }
    let value = of_thread(outcome)?;
    if let Some((doing, done)) = latest.take() {
        progress.show(py, &doing, done)?;
    }
    Ok(value)
}

fn of_thread<T>(outcome: std::thread::Result<anyhow::Result<T>>) -> PyResult<T> {
    outcome.map_err(|panic| panicked(&*panic))?.map_err(raised)
}

fn look(py: Python<'_>, latest: &Latest, progress: &Progress) -> PyResult<()> {
    py.check_signals()?;
    match latest.take() {
        Some((doing, done)) => progress.show(py, &doing, done),
        None => Ok(()),
    }
}

/// What a signal raises.
fn signals(py: Python<'_>) -> PyResult<()> {
    py.check_signals()
}

/// As [`work`], for what cannot be called off: after Ctrl-C a thread of its own ends it unheard.
pub fn work_to_end<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> anyhow::Result<T> + Send + 'static,
) -> PyResult<T> {
    let (send, receive) = channel();
    std::thread::spawn(move || {
        let outcome = catch_unwind(AssertUnwindSafe(work));
        // Nobody may be there any more.
        drop(send.send(outcome));
    });
    py.detach(move || {
        loop {
            match receive.recv_timeout(POLL_PERIOD) {
                Ok(outcome) => return of_thread(outcome),
                Err(RecvTimeoutError::Disconnected) => {
                    unreachable!("the thread sends before it ends")
                }
                Err(RecvTimeoutError::Timeout) => Python::attach(signals)?,
            }
        }
    })
}
