//! `rsrs draw`: a recorded run as a picture.

use std::path::PathBuf;

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::robot::pose_source::PoseSource;
use rsrs_pipeline::label::{CutRun, LabelOptions};
use rsrs_pipeline::sweep::source::behaviour;
use rsrs_render::recorded_run::svg;

use crate::commands::{Format, report_written};
use crate::failure::Outcome;
use crate::page_arguments::PageArguments;

/// Draw a recorded run: from above, and its order parameters over time.
///
/// Dots are where robots started; what is judged, mostly the last 60 s, is drawn stronger, and a mill
/// gets its ring. Beside it are rotation, orbit, circliness, blocked and lost of every 10 s with the
/// bounds of stable milling, and below them the label and its reason. A run that is too short for a
/// label is drawn without one.
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
    #[command(flatten)]
    page: PageArguments,
    /// Label what there is of a run whose end was not recorded.
    #[arg(long)]
    part: bool,
    /// What to judge it for: milling, aggregation, dispersal, or the path of a file (default: what the
    /// bag's record has, else milling).
    #[arg(long, value_parser = behaviour)]
    behaviour: Option<Behaviour>,
    /// Where poses come from (default: what the run went by).
    #[arg(long, value_parser = crate::pose_arguments::pose_sources())]
    poses: Option<PoseSource>,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let picture = arguments.page.file(&arguments.output)?;
    let cut = if arguments.part { CutRun::Judged } else { CutRun::Refused };
    let Arguments { poses, behaviour, .. } = *arguments;
    let options = LabelOptions { cut, poses, behaviour, ..LabelOptions::default() };
    picture.write(&svg(&arguments.bag, options, picture.style().theme)?)?;
    report_written(Format::Text, &arguments.output)?;
    Ok(Outcome::Done)
}
