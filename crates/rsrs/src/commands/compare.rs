//! `rsrs compare`: reality against the simulator.

use std::path::PathBuf;

use crate::bag_arguments::BagArguments;
use crate::commands::{Format, report, report_written};
use crate::failure::{Outcome, bad_arguments};
use rsrs_pipeline::compare::compare;
use rsrs_pipeline::files::write_file;
use rsrs_render::comparison::{Report, text};
use rsrs_render::latex;

/// Compare recorded runs with the sweep that predicts them: do robots mill as often as simulated?
///
/// Every bag is labelled by the judge, or by the person that `--labels` names, and belongs to the
/// swept cell whose speed, turning rate and other settings it was run with. A bag of another
/// experiment is refused: another number of robots, placement, arena, duration, or a cell that was
/// not swept. A run that did not complete, or cannot be labelled, is listed with its cause and does not count.
///
/// The claim is that real robots mill at least as often as simulated ones, because those are
/// deliberately worse. The verdict rests on all runs of all cells together. It is `violated` if they
/// show that in at least one of the cells real robots mill less often; the cells that show it by
/// themselves are named. It is `supported` if they show that real robots, averaged over the runs, mill
/// as often, or less often by at most the margin. Either verdict is wrong with a probability of at most
/// 0.05, however often you looked before: add runs and compare again as you like. Otherwise it is
/// `undecided`, or `no claim` where simulated robots hardly mill, so that nothing can fall short. Runs
/// that were left out for a cause after their start may have ended in any way: a verdict is given only
/// if none of these ends could change it. Exit code 3 means that the claim is violated, or that a run
/// cannot be labelled.
///
/// The last lines say what to do next: the most informative experiment (before the first run that
/// counts, the one that decides soonest), or to measure the robots again where real ones mill less
/// often.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs compare results/flockbot --bags runs/monday_*
  rsrs compare results/flockbot --bags runs/one runs/two --format json
  rsrs compare results/flockbot --bags runs/* --margin 0.2
  rsrs compare results/flockbot --bags runs/* -o verdict.tex")]
pub struct Arguments {
    /// Folder of a sweep; with `choice.json` in it, the chosen cell is compared with its fresh runs.
    folder: PathBuf,
    /// Bags of runs: rosbag2 folders or single .mcap files.
    #[arg(long, required = true, num_args = 1.., value_name = "BAG")]
    bags: Vec<PathBuf>,
    #[command(flatten)]
    runs: BagArguments,
    /// Table of the cells and the verdict to write, in LaTeX for a paper: a file that ends in .tex.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    if let Some(path) = &arguments.output {
        latex::check(path).map_err(bad_arguments)?;
    }
    let result = compare(&arguments.folder, &arguments.runs.options(&arguments.bags))?;
    let result = Report::new(result);
    report(arguments.format, &result, text(&result))?;
    if let Some(path) = &arguments.output {
        write_file(path, latex::verdict(&result).as_bytes())?;
        report_written(arguments.format, path)?;
    }
    Ok(Outcome::from(&result))
}
