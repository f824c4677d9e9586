//! Progress on standard error: a bar for people, nothing for pipes.

use std::sync::Once;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use rsrs_sim::sweep::{Progress, Swept, Watch};

use crate::failure::with_help;
use crate::interrupt;

/// A bar that counts replicates, with their rate and the time left.
pub struct ReplicateBar {
    bar: ProgressBar,
    /// There is nothing to show before it is known how much there is to do.
    shown: Once,
}

fn write_rate(state: &ProgressState, writer: &mut dyn std::fmt::Write) {
    write!(writer, "{:.0}", state.per_sec()).expect("a string takes any text");
}

impl ReplicateBar {
    /// Shows a bar with what is being done in front.
    pub fn new(doing: &str) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        let style = "{msg} {bar:30} {human_pos}/{human_len} runs  {rate} a second  {eta} left";
        let style = ProgressStyle::with_template(style).expect("the template is well-formed");
        bar.set_style(style.with_key("rate", write_rate));
        bar.set_message(doing.to_owned());
        Self { bar, shown: Once::new() }
    }

    /// Shows how much was done before, and how much there is in all; what was done before does not
    /// count towards the rate.
    pub fn begin(&self, doing: &str, start: Progress) {
        self.bar.set_message(doing.to_owned());
        self.bar.set_length(start.total as u64);
        self.bar.set_position(start.done as u64);
        self.bar.reset_eta();
        self.reveal();
    }

    /// Shows how far the work has come.
    pub fn show(&self, progress: Progress) {
        self.bar.set_length(progress.total as u64);
        self.reveal();
        self.bar.set_position(progress.done as u64);
    }

    fn reveal(&self) {
        self.shown.call_once(|| {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
            self.bar.enable_steady_tick(Duration::from_millis(100));
        });
    }
}

impl Drop for ReplicateBar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Threads to use where none are asked for: as many as the machine runs at once.
pub fn threads(asked: Option<usize>) -> usize {
    asked.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from))
}

/// Runs simulations under a progress bar and Ctrl-C.
///
/// # Errors
///
/// That of the simulations, or that they were called off.
pub fn watched<E: std::error::Error + Send + Sync + 'static>(
    doing: &str,
    work: impl FnOnce(Watch<'_>) -> Result<Swept, E>,
) -> anyhow::Result<Swept> {
    let bar = ReplicateBar::new(doing);
    let cancel = interrupt::listen()?;
    let swept = work(Watch { progress: &|progress| bar.show(progress), cancel })?;
    if swept.is_cancelled {
        return Err(with_help("called off; nothing was written", "run the same command again"));
    }
    Ok(swept)
}
