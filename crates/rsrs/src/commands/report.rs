//! `rsrs report`: a sweep and the runs that were held against it, as one HTML file.

use std::path::PathBuf;

use rsrs_pipeline::compare::report::Report as Comparison;
use rsrs_pipeline::error::with_help;
use rsrs_pipeline::files::write_file;
use rsrs_pipeline::report::html;
use rsrs_pipeline::wording::{counted, size};
use serde::Serialize;

use crate::bag_arguments::BagArguments;
use crate::commands::{Format, report};
use crate::failure::Outcome;

/// Write one HTML file with the diagram, the comparison, and every run in motion.
///
/// The cells of the diagram respond to pointer, tap and arrow keys: they show how their runs ended, and
/// one of them, simulated again. Runs are played from their bags beside their order parameters.
/// The file needs no other and asks for nothing from the network: it can be mailed, printed and kept.
/// Runs are labelled and compared as `rsrs compare` does it. Exit code 3 means that the claim is
/// violated.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs report results/flockbot --bags runs/monday_* -o monday.html
  rsrs report results/flockbot --bags runs/monday_* --labels human:ana -o monday.html")]
pub struct Arguments {
    /// Folder of a sweep; with `choice.json` in it, the chosen cell is shown, too.
    folder: PathBuf,
    #[command(flatten)]
    runs: BagArguments,
    /// File to write; one that exists is replaced.
    #[arg(short, long, value_name = "FILE.html")]
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
    comparison: Comparison,
}

/// Runs the command.
///
/// # Errors
///
/// As [`compare`](rsrs_pipeline::compare::compare), and if the report cannot be written.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let output = &arguments.output;
    if output.extension().is_none_or(|ending| ending != "html") {
        return Err(with_help(
            format!("{} does not end in .html", output.display()),
            "name the report `-o report.html`",
        ));
    }
    let (html, comparison) = html(&arguments.folder, &arguments.runs.clone().into())?;
    write_file(output, html.as_bytes())?;
    let n_bytes = html.len() as u64;
    let runs = counted(comparison.bags.len() as u64, "run");
    let text = format!("{}: {runs}, {}", output.display(), size(n_bytes));
    let summary = Summary { report: output.clone(), n_bytes, comparison };
    report(arguments.format, &summary, &text)?;
    Ok(Outcome::from(&summary.comparison))
}
