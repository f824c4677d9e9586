//! Progress on standard error: a bar on a terminal, elsewhere a line now and then.

use std::io::IsTerminal;
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, Once, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use rsrs_core::numerals::count;
use rsrs_pipeline::execution::{Execution, Observer, RunCounter};
use rsrs_sim::sweep::Progress;

use crate::interrupt;
use crate::notes::print_note;
use crate::output::{Detail, detail};
use crate::progress_log::ProgressLog;

/// How progress is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// As a bar that is drawn again and again.
    Bar,
    /// As a line now and then: no terminal is there, or other lines come between.
    Lines,
    Nothing,
}

/// How this process shows progress.
pub fn shown() -> Shown {
    match detail() {
        Detail::Needed => Shown::Nothing,
        Detail::Notes if std::io::stderr().is_terminal() => Shown::Bar,
        Detail::Notes | Detail::Steps => Shown::Lines,
    }
}

/// What counts how much of something is done.
pub struct Counter {
    bar: ProgressBar,
    /// There is nothing to show before it is known how much there is to do.
    revealed: Once,
    /// What is counted: `runs`, `frames`.
    what: &'static str,
    doing: Mutex<String>,
    /// When lines are printed, if not a bar; `None` before the first call.
    log: Mutex<Option<ProgressLog>>,
}

fn write_rate(state: &ProgressState, writer: &mut dyn std::fmt::Write) {
    write!(writer, "{:.0}", state.per_sec()).expect("a string takes any text");
}

impl Counter {
    /// Begins to count `what` (in the plural), with what one is `doing` in front.
    pub fn new(doing: &str, what: &'static str) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        let style = format!(
            "{{msg}} {{bar:30}} {{human_pos}}/{{human_len}} {what}  {{rate}} a second  {{eta}} left"
        );
        let style = ProgressStyle::with_template(&style).expect("the template is well-formed");
        bar.set_style(style.with_key("rate", write_rate));
        bar.set_message(doing.to_owned());
        let doing = Mutex::new(doing.to_owned());
        Self { bar, revealed: Once::new(), what, doing, log: Mutex::new(None) }
    }

    pub fn show(&self, Progress { done, total }: Progress) {
        match shown() {
            Shown::Nothing => {}
            Shown::Bar => {
                self.bar.set_length(total as u64);
                self.reveal();
                self.bar.set_position(done as u64);
            }
            Shown::Lines => self.print_line(done as u64, total as u64),
        }
    }

    fn reveal(&self) {
        self.revealed.call_once(|| {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
            self.bar.enable_steady_tick(Duration::from_millis(100));
        });
    }

    fn print_line(&self, done: u64, total: u64) {
        let share = done as f64 / total.max(1) as f64;
        let now = Instant::now();
        let mut log = self.log.lock().unwrap_or_else(PoisonError::into_inner);
        let Some(line) =
            log.get_or_insert_with(|| ProgressLog::begin(now, share)).line_if_due(now, share)
        else {
            return;
        };
        let doing = self.doing.lock().unwrap_or_else(PoisonError::into_inner);
        print_note(format!("{doing}: {} of {} {}, {line}", count(done), count(total), self.what));
    }
}

impl RunCounter for Counter {
    fn begin(&self, doing: &str, start: Progress) {
        doing.clone_into(&mut self.doing.lock().unwrap_or_else(PoisonError::into_inner));
        self.bar.set_message(doing.to_owned());
        self.bar.set_position(start.done as u64);
        self.bar.reset_eta();
        if let Some(log) = &mut *self.log.lock().unwrap_or_else(PoisonError::into_inner) {
            log.restart_estimate(Instant::now(), start.done as f64 / start.total.max(1) as f64);
        }
        Self::show(self, start);
    }

    fn show(&self, progress: Progress) {
        Self::show(self, progress);
    }
}

impl Drop for Counter {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Whoever types the command.
struct Terminal {
    cancel: &'static AtomicBool,
}

impl Observer for Terminal {
    fn count(&self, doing: &str, what: &'static str) -> Box<dyn RunCounter + '_> {
        Box::new(Counter::new(doing, what))
    }

    fn cancel(&self) -> &AtomicBool {
        self.cancel
    }
}

/// Simulations in so many threads whose progress is shown, and which Ctrl-C calls off from now on.
///
/// This starts a thread: a process moves into another network before it.
pub fn execution(n_threads: usize) -> anyhow::Result<Execution<'static>> {
    static TERMINAL: OnceLock<Terminal> = OnceLock::new();
    let cancel = interrupt::listen()?;
    let observer = TERMINAL.get_or_init(|| Terminal { cancel });
    Ok(Execution { n_threads, observer })
}
