//! `rsrs bag info`: what is in a bag.

use std::path::PathBuf;

use crate::commands::{Format, report};
use crate::failure::Outcome;
use rsrs_pipeline::label::human_labels;
use rsrs_pipeline::recorded_run;
use rsrs_render::bag_contents::{BagContents, text};

/// Print what is in a bag: topics, times, the experiment, labels, and where it breaks off.
///
/// Every file is read through, against the checksums in it, as far as its first damage; the rest is for
/// `rsrs bag recover`. Exit code 3 means that the recording breaks off or is damaged, or was recovered
/// from one that was, so that data are lost.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs bag info results/run_1
  rsrs bag info results/run_1 --format json")]
pub struct Arguments {
    /// Bag: a rosbag2 folder or a single .mcap file.
    bag: PathBuf,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let bag = recorded_run::open_damaged(&arguments.bag)?;
    let record = recorded_run::record_in(&bag)?;
    let ending = recorded_run::ending_in(&bag)?;
    let contents = BagContents::new(&bag, record, ending, human_labels::read(&arguments.bag)?);
    report(arguments.format, &contents, text(&contents))?;
    Ok(if contents.is_whole() { Outcome::Done } else { Outcome::NegativeAnswer })
}
