//! Progress of an experiment on standard error.

use std::cell::{Cell, RefCell};
use std::pin::Pin;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use rsrs_experiment_runner::Progress;
use rsrs_operate::run::operator::{Operator, Verbosity};
use rsrs_render::operator_event::{self, OperatorEvent};
use rsrs_ros::printing::{Printed, Printer};

use crate::interrupt::asked_to_stop;
use crate::notes::print_note;
use crate::output::{Detail, detail};
use crate::progress::{Shown, shown};
use crate::progress_log::ProgressLog;

/// What is being prepared, and then a bar that counts steps, or seconds in real time.
struct ExperimentBar {
    bar: ProgressBar,
    counts: Cell<bool>,
    verbosity: Verbosity,
    shown: Shown,
    /// When lines are printed instead; `None` before the first step.
    log: RefCell<Option<ProgressLog>>,
}

/// The person at the terminal, as operator of runs, who is shown them by a thread of its own: a terminal
/// that is stopped (Ctrl-S) must not hold up leases.
pub struct TerminalOperator;

impl Operator for TerminalOperator {
    fn inform(&self, event: &OperatorEvent<'_>) {
        above_bars(|| print_note(operator_event::text(event)));
    }

    fn watch_run(&self, name: &str, verbosity: Verbosity) -> Box<dyn FnMut(Progress) + '_> {
        let verbosity = if detail() == Detail::Steps { Verbosity::Verbose } else { verbosity };
        let (name, shown) = (name.to_owned(), shown());
        let make = move || {
            let bar = ExperimentBar::new(&name, verbosity, shown);
            move |progress| bar.print(&progress)
        };
        // Without a thread nothing is shown; it is no reason not to run.
        let printer = Printer::start(ROOM, make).ok();
        Box::new(move |progress| {
            let Some(printer) = &printer else { return };
            match progress {
                Progress::Note(_) => printer.print(progress),
                Progress::Done { .. } => printer.print_if_there_is_room(progress),
            }
        })
    }

    fn stop_requested(&self) -> Pin<Box<dyn Future<Output = String> + '_>> {
        Box::pin(asked_to_stop())
    }
}

/// The bars of all runs that go on, one below the other.
static BARS: LazyLock<MultiProgress> = LazyLock::new(MultiProgress::new);

/// Prints while bars are drawn: what is printed stands above them.
pub fn above_bars<T>(print: impl FnOnce() -> T) -> T {
    BARS.suspend(print)
}

/// Notes that wait for the terminal, at most.
const ROOM: usize = 1000;

impl ExperimentBar {
    fn print(&self, printed: &Printed<Progress>) {
        match printed {
            Printed::This(progress) => self.show(progress),
            Printed::LeftOut(n_notes) => {
                self.show(&Progress::Note(operator_event::not_shown(*n_notes)));
            }
        }
    }

    /// Shows the name of the experiment.
    fn new(name: &str, verbosity: Verbosity, shown: Shown) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden());
        let bar = if shown == Shown::Bar { BARS.add(bar) } else { bar };
        bar.set_style(style("{msg}: {prefix}"));
        bar.set_message(name.to_owned());
        bar.set_prefix("looking for the robots");
        bar.enable_steady_tick(Duration::from_millis(100));
        Self { bar, counts: Cell::new(false), verbosity, shown, log: RefCell::new(None) }
    }

    fn show(&self, progress: &Progress) {
        match progress {
            Progress::Note(text) => {
                if self.verbosity == Verbosity::Verbose {
                    self.bar.suspend(|| print_note(text));
                }
                self.bar.set_prefix(text.clone());
            }
            Progress::Done { done, of } => {
                if !self.counts.replace(true) {
                    self.bar.set_length(*of);
                    self.bar.set_style(style(
                        "{msg}: {prefix} {bar:30} {human_pos}/{human_len}  {eta} left",
                    ));
                    // What came before the first step does not count towards the pace.
                    self.bar.reset_eta();
                }
                if self.verbosity == Verbosity::Verbose {
                    // The last note stands on a line of its own.
                    self.bar.set_prefix("running");
                }
                self.bar.set_position(*done);
                if self.shown == Shown::Lines {
                    self.print_line(*done as f64 / (*of).max(1) as f64);
                }
            }
        }
    }

    fn print_line(&self, share: f64) {
        let now = Instant::now();
        let mut log = self.log.borrow_mut();
        let log = log.get_or_insert_with(|| ProgressLog::begin(now, share));
        if let Some(line) = log.line_if_due(now, share) {
            print_note(format!("{}: {line}", self.bar.message()));
        }
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).expect("the template is well-formed")
}

impl Drop for ExperimentBar {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beside_robots_the_bar_shows_what_they_do_now() {
        let bar = ExperimentBar::new("milling", Verbosity::Verbose, Shown::Nothing);
        let note = |text: &str| bar.show(&Progress::Note(text.to_owned()));
        let mut prefixes = vec![bar.bar.prefix()];

        note("all 9 robots are armed");
        prefixes.push(bar.bar.prefix());
        bar.show(&Progress::Done { done: 0, of: 60 });
        note("robot_3: detections come too rarely");
        bar.show(&Progress::Done { done: 1, of: 60 });
        prefixes.push(bar.bar.prefix());
        note("stopping every robot");
        prefixes.push(bar.bar.prefix());

        let expected =
            ["looking for the robots", "all 9 robots are armed", "running", "stopping every robot"];
        assert_eq!(prefixes, expected);
    }
}
