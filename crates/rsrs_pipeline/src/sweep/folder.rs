//! The folder of a sweep: read back when it is finished.
//!
//! While a sweep is at work its folder holds `sweep.yaml` and the folder `unfinished`
//! (`unfinished`). When that is gone, the results are there, and whole.

mod block_file;
mod cells;
pub mod difference;
pub(crate) mod unfinished;

use std::path::Path;

use anyhow::{Context, bail};
use rsrs_core::diagram::PhaseDiagram;
use rsrs_core::diagram::choice::Choice;
use rsrs_core::diagram::folder::{CELLS, CHOICE, SWEEP, UnfinishedSweep};
use rsrs_core::quantity::Cell;
use rsrs_files::quoted;

use crate::error::{helped, with_help};
use crate::files::{read_json_if_there, read_text};
use crate::sweep::result::SweepResult;
use crate::sweep::source::ResolvedSweep;

/// Reads the folder of a sweep back; one that is unfinished, or in which a file was changed, is
/// refused.
pub fn read(folder: &Path) -> anyhow::Result<SweepResult> {
    let source = read_source(folder)?;
    if unfinished::is_unfinished(folder) {
        let finish = unfinished::command(folder);
        let folder = folder.display().to_string();
        return Err(helped(UnfinishedSweep { folder, finish }));
    }
    let path = folder.join(CELLS);
    let text = read_text(&path)?;
    let axes = source.sweep.swept_axes();
    let worlds = cells::from_csv(
        &text,
        &axes,
        (source.sweep.behaviour.known(), source.sweep.interval_kind()),
    )
    .with_context(|| path.display().to_string())?;
    let swept: Vec<Cell> = worlds.simulated.iter().map(|entry| entry.cell.clone()).collect();
    if swept != source.sweep.all_cells() {
        bail!("{} does not hold the cells of {SWEEP}", path.display());
    }
    let diagram = |cells| PhaseDiagram { axes: axes.clone(), cells };
    Ok(SweepResult {
        source,
        diagram: diagram(worlds.simulated),
        as_measured: worlds.as_measured.map(diagram),
    })
}

/// Reads the choice that lies beside a sweep's files; `None` if there is none.
pub fn read_choice(folder: &Path) -> anyhow::Result<Option<Choice>> {
    read_json_if_there(&folder.join(CHOICE), "no choice")
}

/// Reads what was swept into a folder, or is being swept.
pub fn read_source(folder: &Path) -> anyhow::Result<ResolvedSweep> {
    let path = folder.join(SWEEP);
    if !path.exists() {
        return Err(with_help(
            format!("{} is not the folder of a sweep: it has no {SWEEP}", folder.display()),
            "make one with `rsrs sweep SWEEP.yaml -o DIR`",
        ));
    }
    if !folder.join(CELLS).exists() && !unfinished::is_unfinished(folder) {
        return Err(with_help(
            format!("{} is not the folder of a sweep: it has no {CELLS}", folder.display()),
            format!(
                "sweep it first: `rsrs sweep {} -o {}`",
                quoted(&path),
                quoted(folder.join("results"))
            ),
        ));
    }
    let text = read_text(&path)?;
    Ok(ResolvedSweep::parse_result(&path.display().to_string(), &text)?)
}
