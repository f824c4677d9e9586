//! How many threads simulate, on the command line.

use clap::builder::RangedU64ValueParser;
use rsrs_pipeline::execution::{Execution, MOST_THREADS, n_threads};

use crate::progress::execution;

/// The same of all commands that simulate much.
#[derive(Clone, Copy, clap::Args)]
pub struct ThreadsArgument {
    /// Threads (default: as many as the machine runs at once).
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=MOST_THREADS))]
    threads: Option<usize>,
}

impl ThreadsArgument {
    pub fn number(self) -> usize {
        self.threads.unwrap_or_else(n_threads)
    }

    /// Simulations in so many threads, as [`execution`] watches them.
    pub fn execution(self) -> anyhow::Result<Execution<'static>> {
        execution(self.number())
    }
}
