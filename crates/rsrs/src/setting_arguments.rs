//! How the best setting of robots is looked for, on the command line.

use rsrs_pipeline::choose::{CONFIRM, SearchOptions};

use crate::threads_argument::ThreadsArgument;

/// The same of `choose`, `answer` and `diagnose`, which look for one setting.
#[derive(Clone, Copy, clap::Args)]
pub struct SettingArguments {
    /// Number of robots (default: any that a sweep has; for a profile as in `fleet.yaml` beside it, or
    /// else any of a few from 3 to 12).
    #[arg(long, value_name = "N")]
    pub robots: Option<usize>,
    /// Fresh runs that confirm a setting, in each world (default: 1000).
    #[arg(long, value_name = "N", default_value_t = CONFIRM, hide_default_value = true,
          value_parser = clap::value_parser!(u64).range(1..))]
    pub confirm: u64,
    #[command(flatten)]
    pub threads: ThreadsArgument,
}

impl SettingArguments {
    /// The same for the search.
    pub fn options(self, wanted: f64) -> anyhow::Result<SearchOptions<'static>> {
        let Self { robots, confirm, threads } = self;
        Ok(SearchOptions { robots, wanted, confirm, execution: threads.execution()? })
    }
}
