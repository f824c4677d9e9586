//! `rsrs bag recover`: a whole bag out of a damaged one.

use std::path::PathBuf;

use rsrs_bags::{Recovered, recover_into, recovered_name};
use serde::Serialize;

use crate::commands::{Format, report};
use crate::failure::Outcome;
use rsrs_pipeline::error::helped;
use rsrs_pipeline::label::human_labels;
use rsrs_render::recovered_bag::text;

/// Save what can be saved of a bag that was cut, damaged or never closed.
///
/// The damaged bag is left as it is; a new one is written. Nothing is made up: what fails its
/// checksum is left out and listed. Exit code 3 means that something was lost, or may have been.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs bag recover results/run_1
  rsrs bag recover crashed_0.mcap -o saved")]
pub struct Arguments {
    /// Bag: a rosbag2 folder or a single .mcap file.
    bag: PathBuf,
    /// Folder of the new bag; it must not exist (default: BAG with `_recovered` appended).
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// To how many bytes a file that was compressed as a whole may unpack (default: 64 times its
    /// size, and 64 MiB in any case).
    #[arg(long, value_name = "BYTES")]
    unpack_limit: Option<u64>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// What was saved, with the sums that a reader would make.
#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    recovered: &'a Recovered,
    /// Whether everything that was recorded is in the new bag.
    is_complete: bool,
    /// Messages that are certainly lost.
    n_messages_lost: u64,
    /// Bytes of the old bag of which nothing was saved.
    n_bytes_lost: u64,
    /// Labels of people that lay beside the old bag, and now lie beside the new one, too.
    n_labels: usize,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    // Labels that do not read are refused before anything is written.
    human_labels::read(&arguments.bag)?;
    let folder = match &arguments.output {
        Some(folder) => folder.clone(),
        None => recovered_name(&arguments.bag).map_err(helped)?,
    };
    let recovered =
        recover_into(&arguments.bag, &folder, arguments.unpack_limit).map_err(helped)?;
    let n_labels = human_labels::carry(&arguments.bag, &recovered.folder)?;
    let result = Report {
        is_complete: recovered.is_complete(),
        n_messages_lost: recovered.lost.total(),
        n_bytes_lost: recovered.n_bytes_lost(),
        n_labels,
        recovered: &recovered,
    };
    report(arguments.format, &result, text(&recovered, n_labels))?;
    Ok(if recovered.is_complete() { Outcome::Done } else { Outcome::NegativeAnswer })
}
