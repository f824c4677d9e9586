//! `rsrs diagram`: the phase diagram as a picture.

use std::path::PathBuf;

use rsrs_core::axis::{Axis, Cell};

use crate::failure::{Outcome, with_help};
use crate::picture::{PNG_WIDTH_PX, Wish, of_sweep};
use crate::result_folder::{self, write_file};
use crate::validation_file;

/// Draw the phase diagram of a sweep.
///
/// Hue is the most frequent phase of a cell, lightness its share. The dashed line is the analytic
/// turn balance. With `choice.json` beside the sweep's files, the chosen cell is marked; with
/// `validation.json`, its answer is noted.
#[derive(clap::Args)]
pub struct Arguments {
    /// Folder of a sweep.
    folder: PathBuf,
    /// Picture to write; its ending says how: svg or png.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Horizontal axis (default: the first swept one).
    #[arg(long, value_name = "AXIS")]
    x: Option<Axis>,
    /// Vertical axis (default: the second swept one).
    #[arg(long, value_name = "AXIS")]
    y: Option<Axis>,
    /// Values on further axes, as AXIS=VALUE,…
    #[arg(long, value_name = "AXIS=V")]
    at: Option<Cell>,
}

/// Runs the command.
///
/// # Errors
///
/// If the folder is not a sweep's, an axis was not swept, or the picture cannot be written.
pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let ending = arguments.output.extension().and_then(|ending| ending.to_str()).unwrap_or("");
    if !matches!(ending, "svg" | "png") {
        return Err(with_help(
            format!("{} ends in neither .svg nor .png", arguments.output.display()),
            "name the picture `-o diagram.svg` or `-o diagram.png`",
        ));
    }
    let result = result_folder::read(&arguments.folder)?;
    let wish = Wish {
        x: arguments.x,
        y: arguments.y,
        at: arguments.at.iter().flat_map(Cell::iter).collect(),
        chosen: result_folder::read_choice(&arguments.folder)?.map(|choice| choice.cell),
        experiments: Vec::new(),
        validation: validation_file::note(&arguments.folder, &result.source)?,
    };
    let svg = of_sweep(&result, &wish)?;
    if ending == "svg" {
        write_file(&arguments.output, svg.as_bytes())?;
    } else {
        write_file(&arguments.output, &rsrs_view::raster::png(&svg, PNG_WIDTH_PX)?)?;
    }
    Ok(Outcome::Done)
}
