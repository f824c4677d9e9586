//! Progress on standard error: a bar for people, nothing for pipes.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use rsrs_sim::sweep::Progress;

/// A bar that counts replicates, with their rate and the time left.
pub struct ReplicateBar {
    bar: ProgressBar,
}

impl ReplicateBar {
    /// Shows a bar with what is being done in front.
    pub fn new(doing: &str) -> Self {
        let bar = ProgressBar::new(0).with_message(doing.to_owned());
        let style = "{msg} {bar:30} {human_pos}/{human_len} runs  {per_sec}  {eta} left";
        bar.set_style(ProgressStyle::with_template(style).expect("the template is well-formed"));
        bar.enable_steady_tick(Duration::from_millis(100));
        Self { bar }
    }

    /// Shows how far the work has come.
    pub fn show(&self, progress: Progress) {
        self.bar.set_length(progress.total as u64);
        self.bar.set_position(progress.done as u64);
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
