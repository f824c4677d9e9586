//! `rsrs episode`: one replicate of a sweep as a bag.

use std::path::PathBuf;

use rsrs_core::quantity::Cell;
use rsrs_pipeline::compare::prediction::nothing_chosen;
use rsrs_pipeline::episode::replicate::{only_cell, replay};
use rsrs_pipeline::execution::n_threads;
use rsrs_pipeline::sweep::folder::read_choice;
use rsrs_render::episode::text;

use crate::commands::{Format, report};
use crate::failure::Outcome;
use crate::progress::execution;

/// Write one replicate of a sweep as a bag: the very run, with all its topics.
///
/// The bag has the topics of a run over ROS 2 in lockstep, so that every tool for bags shows what the
/// sweep has only counted: play it in a viewer, label it, or replay it into the controller.
/// Its label is that replicate's phase in `replicates.parquet`.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs episode results/flockbot --cell speed_m_s=0.15,turn_rate_rad_s=0.75 --replicate 3 -o mill
  rsrs label mill")]
pub struct Arguments {
    /// Folder of a sweep.
    folder: PathBuf,
    /// Cell of the sweep, as AXIS=VALUE,… (default: the chosen one, or the only one).
    #[arg(long)]
    cell: Option<Cell>,
    /// Which replicate of the cell, from 0.
    #[arg(long, value_name = "K")]
    replicate: u64,
    /// Folder of the bag; it must not exist.
    #[arg(short, long, value_name = "BAG")]
    output: PathBuf,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let Arguments { folder, cell, replicate, output, .. } = arguments;
    let cell = match cell {
        Some(cell) => cell.clone(),
        None => match read_choice(folder)? {
            Some(choice) => choice.cell,
            None => only_cell(folder)?.ok_or_else(|| nothing_chosen(folder))?,
        },
    };
    let episode = replay(folder, &cell, *replicate, output, execution(n_threads())?)?;
    report(arguments.format, &episode, text(&episode))?;
    Ok(Outcome::Done)
}
