//! `rsrs report`: a sweep, and the runs that were held against it, as one HTML file.

use std::path::PathBuf;

use rsrs_pipeline::error::with_help;
use rsrs_pipeline::files::write_file;
use rsrs_render::comparison::Report as Comparison;
use rsrs_render::report::{html, written};
use serde::Serialize;

use crate::bag_arguments::BagArguments;
use crate::commands::{Format, report};
use crate::failure::{Outcome, bad_arguments};

/// Write one HTML file with the diagram, its cells in motion, and the runs that were compared with it.
///
/// The cells of the diagram respond to pointer, tap and arrow keys: they show how their runs ended, and
/// one of them, simulated again; a button opens the cell in a simulator that lies in the file, to
/// change and watch it. Runs are played from their bags beside their order parameters. The file needs
/// no other file and no network: it can be mailed, printed and kept. Runs are labelled and compared as
/// by `rsrs compare`; without runs the report covers the sweep alone. Exit code 3 means that the claim
/// is violated.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs report results/flockbot -o flockbot.html
  rsrs report results/flockbot --bags runs/monday_* -o monday.html
  rsrs report results/flockbot --bags runs/monday_* --labels human:ana -o monday.html")]
pub struct Arguments {
    /// Folder of a sweep; with `choice.json` in it, the chosen cell is shown, too.
    folder: PathBuf,
    /// Bags of runs: rosbag2 folders or single .mcap files (default: none).
    #[arg(long, num_args = 1.., value_name = "BAG")]
    bags: Vec<PathBuf>,
    #[command(flatten)]
    runs: BagArguments,
    /// File to write; one that exists is replaced.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// What was written.
#[derive(Serialize)]
struct Summary {
    report: PathBuf,
    n_bytes: u64,
    /// What came of the runs, if there are some.
    comparison: Option<Comparison>,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let output = &arguments.output;
    if output.extension().is_none_or(|ending| ending != "html") {
        return Err(bad_arguments(with_help(
            format!("{} does not end in .html", output.display()),
            "name the report `-o report.html`",
        )));
    }
    let runs = (!arguments.bags.is_empty()).then(|| arguments.runs.options(&arguments.bags));
    let (html, comparison) = html(&arguments.folder, runs.as_ref())?;
    write_file(output, html.as_bytes())?;
    let n_bytes = html.len() as u64;
    let n_runs = comparison.as_ref().map_or(0, |comparison| comparison.bags.len() as u64);
    let text = written(output, n_runs, n_bytes);
    let summary = Summary { report: output.clone(), n_bytes, comparison };
    report(arguments.format, &summary, &text)?;
    Ok(summary.comparison.as_ref().map_or(Outcome::Done, Outcome::from))
}
