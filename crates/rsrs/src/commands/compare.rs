//! `rsrs compare`: reality against the simulator.

use std::path::PathBuf;

use crate::commands::{Format, report};
use crate::comparing::compare;
use crate::failure::Outcome;
use crate::labelled_bags::LabelledBags;

/// Hold recorded runs against the sweep that predicts them: do robots mill as often as simulated?
///
/// Every bag is labelled by the judge, or by the person that `--labels` names, and belongs to the
/// swept cell whose speed, turning rate and other settings it was run with. A bag of another
/// experiment is refused: another number of robots, placement, arena, duration, or a cell that was
/// not swept. A run that did not complete is listed with its cause and does not count.
///
/// The claim is that real robots mill at least as often as simulated ones, because those are
/// deliberately worse. It is `violated` if so few real mills would be improbable (below 0.05) if it
/// held, `supported` if it holds with a probability of 0.95 or more, give or take 10 percentage
/// points, and else `undecided`. Exit code 3 says that it is violated.
///
/// The last line says what to do next: the experiment that would tell most, or, where real robots
/// mill less often, back to measuring them.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs compare results/flockbot --bags runs/monday_*
  rsrs compare results/flockbot --bags runs/one runs/two --format json")]
pub struct Arguments {
    /// Folder of a sweep; with `choice.json` in it, the chosen cell is compared with its fresh runs.
    folder: PathBuf,
    #[command(flatten)]
    runs: LabelledBags,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// Runs the command.
///
/// # Errors
///
/// As [`compare`].
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let result = compare(&arguments.folder, &arguments.runs)?;
    report(arguments.format, &result, &result.to_string())?;
    Ok(result.outcome())
}
