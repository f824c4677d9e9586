//! `rsrs merge`: the shards of a sweep, put together.

use std::path::PathBuf;

use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::notes::print_always;
use crate::threads_argument::ThreadsArgument;
use rsrs_pipeline::sweep::merge::merge;
use rsrs_render::picture;
use rsrs_render::sweep::{SweepReport, text};

/// Put the shards of a sweep together.
///
/// The folder is the same byte for byte as if one machine had made it with `rsrs sweep`. The shards
/// stay as they are.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs sweep sweep.yaml -o part_1 --shard 1/2      on one machine
  rsrs sweep sweep.yaml -o part_2 --shard 2/2      on another one
  rsrs merge part_1 part_2 -o results/flockbot")]
pub struct Arguments {
    /// Folders of all shards, in any order.
    #[arg(required = true, value_name = "DIR")]
    shards: Vec<PathBuf>,
    /// Folder to make; it must not exist, unless this very command was interrupted.
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    #[command(flatten)]
    threads: ThreadsArgument,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let Arguments { shards, output, .. } = arguments;
    let execution = arguments.threads.execution()?;
    let result = merge(shards, output, execution, picture::into_folder)?;
    let summary = SweepReport::new(output, &result, execution)?;
    if let Some(warning) = summary.warning() {
        print_always(format!("warning: {warning}"));
    }
    report(arguments.format, &summary, text(&summary))?;
    Ok(Outcome::Done)
}
