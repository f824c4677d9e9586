//! `rsrs diff`: two sweeps, cell by cell.

use std::path::PathBuf;

use rsrs_pipeline::diff::diff;
use rsrs_pipeline::sweep::result::World;
use rsrs_render::difference::{svg, text};
use rsrs_render::picture::DiagramOptions;

use crate::commands::{Format, report, report_written};
use crate::failure::Outcome;
use crate::page_arguments::PageArguments;

/// Compare two sweeps cell by cell: a map of the differences, and which cells moved.
///
/// A cell has moved if the 95 % intervals of its share in the two sweeps do not overlap. For sweeps
/// whose robots, floors or factors differ it shows what that changes; for two versions of a profile,
/// whether the diagram has to be drawn anew. Cells that only one sweep has are counted.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  rsrs diff results/before results/after
  rsrs diff results/before results/after -o difference.svg
  rsrs diff results/before results/after --world as-measured --format json")]
pub struct Arguments {
    /// Folder of the first sweep.
    from: PathBuf,
    /// Folder of the second sweep, from which the first is subtracted.
    to: PathBuf,
    /// Map of the differences to write; its extension selects the format: svg, png or pdf.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// The robots: made worse by the sweeps' factors, or as measured (default: harsher).
    #[arg(long, value_enum, default_value = "harsher", hide_default_value = true)]
    world: Robots,
    #[command(flatten)]
    page: PageArguments,
    /// How to report.
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// Which robots are compared.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Robots {
    /// The robots are made worse than measured.
    Harsher,
    /// The robots are as measured.
    AsMeasured,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let picture = arguments.page.file_if(arguments.output.as_deref())?;
    let world = match arguments.world {
        Robots::Harsher => World::Harsher,
        Robots::AsMeasured => World::AsMeasured,
    };
    let (difference, common) = diff(&arguments.from, &arguments.to, world)?;
    if let Some(picture) = picture {
        let options = DiagramOptions { style: picture.style(), ..DiagramOptions::default() };
        picture.write(&svg(&difference, &common, world, options)?)?;
    }
    report(arguments.format, &difference, text(&difference))?;
    if let Some(path) = &arguments.output {
        report_written(arguments.format, path)?;
    }
    Ok(Outcome::Done)
}
