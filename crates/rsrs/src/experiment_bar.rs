//! Progress of an experiment on standard error.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use rsrs_experiment_runner::Progress;

/// A bar that counts steps, or seconds.
pub struct ExperimentBar {
    bar: ProgressBar,
}

impl ExperimentBar {
    /// Shows a bar with the name of the experiment in front.
    pub fn new(name: &str) -> Self {
        let bar = ProgressBar::new(0).with_message(name.to_owned());
        let style = "{msg} {bar:30} {human_pos}/{human_len} {prefix}  {eta} left";
        bar.set_style(ProgressStyle::with_template(style).expect("the template is well-formed"));
        bar.enable_steady_tick(Duration::from_millis(100));
        Self { bar }
    }

    /// Shows how far the experiment has come.
    pub fn show(&self, progress: &Progress) {
        match progress {
            Progress::Say(text) => self.bar.set_prefix(text.clone()),
            Progress::Done { done, of } => {
                self.bar.set_length(*of);
                self.bar.set_position(*done);
            }
        }
    }
}

impl Drop for ExperimentBar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
