//! Progress on standard error: a bar for people, nothing for pipes.

use std::sync::atomic::AtomicBool;
use std::sync::{Once, OnceLock};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use rsrs_pipeline::execution::{Execution, Observer, RunCounter, n_threads};
use rsrs_sim::sweep::Progress;

use crate::interrupt;

/// A bar that counts replicates, with their rate and the time left.
struct ReplicateBar {
    bar: ProgressBar,
    /// There is nothing to show before it is known how much there is to do.
    shown: Once,
}

fn write_rate(state: &ProgressState, writer: &mut dyn std::fmt::Write) {
    write!(writer, "{:.0}", state.per_sec()).expect("a string takes any text");
}

impl ReplicateBar {
    /// A bar with what is being done in front.
    fn new(doing: &str) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        let style = "{msg} {bar:30} {human_pos}/{human_len} runs  {rate} a second  {eta} left";
        let style = ProgressStyle::with_template(style).expect("the template is well-formed");
        bar.set_style(style.with_key("rate", write_rate));
        bar.set_message(doing.to_owned());
        Self { bar, shown: Once::new() }
    }

    fn reveal(&self) {
        self.shown.call_once(|| {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
            self.bar.enable_steady_tick(Duration::from_millis(100));
        });
    }
}

impl RunCounter for ReplicateBar {
    fn begin(&self, doing: &str, start: Progress) {
        self.bar.set_message(doing.to_owned());
        self.bar.set_length(start.total as u64);
        self.bar.set_position(start.done as u64);
        self.bar.reset_eta();
        self.reveal();
    }

    fn show(&self, progress: Progress) {
        self.bar.set_length(progress.total as u64);
        self.reveal();
        self.bar.set_position(progress.done as u64);
    }
}

impl Drop for ReplicateBar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Whoever types the command.
struct Terminal {
    cancel: &'static AtomicBool,
}

impl Observer for Terminal {
    fn count_runs(&self, doing: &str) -> Box<dyn RunCounter + '_> {
        Box::new(ReplicateBar::new(doing))
    }

    fn cancel(&self) -> &AtomicBool {
        self.cancel
    }
}

/// Simulations under a progress bar, which Ctrl-C calls off from now on.
///
/// This starts a thread: a process moves into another network before it.
///
/// # Arguments
///
/// * `threads` — as asked for; else as many as the machine runs at once.
///
/// # Errors
///
/// If signals cannot be received.
pub fn execution(threads: Option<usize>) -> anyhow::Result<Execution<'static>> {
    static TERMINAL: OnceLock<Terminal> = OnceLock::new();
    let cancel = interrupt::listen()?;
    let observer = TERMINAL.get_or_init(|| Terminal { cancel });
    Ok(Execution { n_threads: threads.unwrap_or_else(n_threads), observer })
}

/// A bar that counts frames of a film.
pub fn frames_bar() -> ProgressBar {
    let style = "{bar:30} {human_pos}/{human_len} frames  {eta} left";
    let style = ProgressStyle::with_template(style).expect("the template is well-formed");
    ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr()).with_style(style)
}
