//! `rsrs draw`: a recorded run as a picture.

use std::path::PathBuf;

use rsrs_pipeline::draw::svg;
use rsrs_pipeline::label::{CutRun, LabelOptions};
use rsrs_pipeline::picture::PictureFile;

use crate::commands::{Format, report_written};
use crate::failure::Outcome;

/// Draw a recorded run: from above, and its order parameters over time.
///
/// Dots are where robots started; the last 60 s, which are judged, are strong, and a mill gets its ring.
/// Beside it are rotation, orbit, circliness, blocked and lost of every 10 s with the bounds of stable
/// milling, and below them the label and why it is that one.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs draw runs/monday -o monday.png
  rsrs draw runs/monday -o monday.svg --part")]
pub struct Arguments {
    /// Bag of a run: rosbag2 folder or single `.mcap` file.
    bag: PathBuf,
    /// Picture to write; its extension selects the format: svg, png or pdf.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Draw what there is of a run whose end was not recorded.
    #[arg(long)]
    part: bool,
}

/// Runs the command.
///
/// # Errors
///
/// If the bag cannot be read or judged, or the picture cannot be written.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let picture = PictureFile::new(&arguments.output)?;
    let cut = if arguments.part { CutRun::Judged } else { CutRun::Refused };
    picture.write(&svg(&arguments.bag, LabelOptions { cut, ..LabelOptions::default() })?)?;
    report_written(Format::Text, &arguments.output)?;
    Ok(Outcome::Done)
}
