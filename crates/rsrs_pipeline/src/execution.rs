//! How simulations are executed: on how many threads, and watched by whom.

use std::sync::atomic::AtomicBool;

use rsrs_core::conditions::Conditions;
use rsrs_sim::sweep::{Progress, Runs, Swept, Watch, sweep};

use crate::error::with_help;

/// Shows how far work has come, and may call it off.
pub trait Observer: Sync {
    /// Begins to count `what`, such as `runs`, while doing something, such as `sweeping`; the
    /// counter lives as long as the work.
    fn count(&self, doing: &str, what: &'static str) -> Box<dyn RunCounter + '_>;

    /// Becomes true when work is to end early; nothing half-written is left then.
    fn cancel(&self) -> &AtomicBool;
}

/// Counts simulated runs, or what else takes long.
pub trait RunCounter: Sync {
    /// Shows how much was done before, and how much there is in all; what was done before does not
    /// count towards the rate.
    fn begin(&self, doing: &str, start: Progress);

    /// Shows how far the work has come.
    fn show(&self, progress: Progress);
}

/// Shows nothing, and never calls work off.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unobserved;

impl Observer for Unobserved {
    fn count(&self, _doing: &str, _what: &'static str) -> Box<dyn RunCounter + '_> {
        Box::new(*self)
    }

    fn cancel(&self) -> &AtomicBool {
        static NEVER: AtomicBool = AtomicBool::new(false);
        &NEVER
    }
}

impl RunCounter for Unobserved {
    fn begin(&self, _doing: &str, _start: Progress) {}

    fn show(&self, _progress: Progress) {}
}

/// How simulations are executed.
#[derive(Clone, Copy)]
pub struct Execution<'a> {
    /// Threads to run on; at least 1.
    pub n_threads: usize,
    /// Who watches.
    pub observer: &'a dyn Observer,
}

impl Execution<'static> {
    /// On as many threads as the machine runs at once, without an observer.
    pub fn unobserved() -> Self {
        Self { n_threads: n_threads(), observer: &Unobserved }
    }
}

impl Execution<'_> {
    /// Runs each of some conditions so often and so long, which is shown, and may be called off.
    pub fn simulate(
        self,
        doing: &str,
        conditions: &[Conditions],
        (seed, replicates): (u64, u64),
        duration_s: f64,
    ) -> anyhow::Result<Swept> {
        let counter = self.observer.count(doing, "runs");
        let cancel = self.observer.cancel();
        let runs = Runs { seed, replicates, duration_s, n_threads: self.n_threads };
        let watch = Watch { progress: &|progress| counter.show(progress), cancel };
        let swept = sweep(conditions, runs, watch)?;
        if swept.is_cancelled {
            return Err(with_help(
                "interrupted; nothing was written",
                "run the same command again",
            ));
        }
        Ok(swept)
    }
}

/// The most threads that somebody can mean.
pub const MOST_THREADS: u64 = 4096;

/// As many threads as the machine runs at once.
pub fn n_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
