//! Whoever stands beside the robots: is shown how far a run is, and may stop it.

use std::pin::Pin;

use rsrs_experiment_runner::Progress;
use rsrs_render::operator_event::OperatorEvent;

/// Whoever started runs over ROS 2.
pub trait Operator {
    /// Is informed of something while a run goes on.
    fn inform(&self, event: &OperatorEvent<'_>);

    /// Is shown the run of this name; what is returned is called with each step of it.
    fn watch_run(&self, name: &str, verbosity: Verbosity) -> Box<dyn FnMut(Progress) + '_>;

    /// Completes when runs are to be stopped, with the reason.
    fn stop_requested(&self) -> Pin<Box<dyn Future<Output = String> + '_>>;
}

/// Nobody is there: nothing is shown, and runs go on to their end.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unattended;

impl Operator for Unattended {
    fn inform(&self, _event: &OperatorEvent<'_>) {}

    fn watch_run(&self, _name: &str, _verbosity: Verbosity) -> Box<dyn FnMut(Progress) + '_> {
        Box::new(|_progress| {})
    }

    fn stop_requested(&self) -> Pin<Box<dyn Future<Output = String> + '_>> {
        Box::pin(std::future::pending())
    }
}

/// How much of a run is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verbosity {
    /// The last note, beside the bar.
    Quiet,
    /// Every note on a line of its own, for an operator who stands beside robots.
    Verbose,
}
