//! The cell of a sweep that a run holds against its prediction.

use std::path::Path;

use anyhow::{Context, bail};
use rsrs_core::axis::{Axis, Cell};
use rsrs_core::choice::Choice;
use rsrs_core::circumstances::Circumstances;
use rsrs_core::diagram::{DiagramCell, PhaseCounts, PhaseDiagram};
use rsrs_core::document;
use rsrs_core::harsher::HarsherFactors;
use rsrs_core::profile::RobotProfile;
use rsrs_core::sweep_file::SweepFile;
use serde::Deserialize;

use super::read;

/// A swept cell, with what a run must keep to be compared with it.
#[derive(Clone, Debug)]
pub struct SweptCell {
    /// Speed, turning rate and number of robots.
    pub cell: Cell,
    /// What must be the same.
    pub circumstances: Circumstances,
    /// How the sweep's robots are worse than the measured ones.
    pub factors: HarsherFactors,
}

/// The part of a result folder's `sweep.yaml` that says what was swept.
#[derive(Deserialize)]
struct Swept {
    sweep: SweepFile,
    profile: RobotProfile,
}

impl SweptCell {
    /// Finds a cell in the folder of a sweep.
    ///
    /// # Arguments
    ///
    /// * `asked` — the cell; the chosen one if none is asked for.
    ///
    /// # Errors
    ///
    /// If the folder is not a sweep's, nothing was chosen, or the cell was not swept: then the
    /// nearest one that was is named.
    pub fn find(folder: &Path, asked: Option<&Cell>) -> anyhow::Result<Self> {
        let path = folder.join("sweep.yaml");
        if !path.exists() {
            bail!("{} is not the folder of a sweep: it has no sweep.yaml", folder.display());
        }
        let (name, text) = read(&path)?;
        let Swept { sweep, profile } = document::parse(&name, &text)?;
        let cells = sweep.resolve(&name, &profile)?;
        let diagram = PhaseDiagram {
            axes: sweep.swept_axes(),
            cells: cells
                .iter()
                .map(|(cell, _)| DiagramCell { cell: cell.clone(), counts: PhaseCounts::default() })
                .collect(),
        };
        let asked = match asked {
            Some(cell) => cell.clone(),
            None => chosen(folder)?,
        };
        let index = diagram.locate(&asked).with_context(|| folder.display().to_string())?;
        let (_, conditions) = &cells[index];
        let cell = Cell::new([
            (Axis::Speed, conditions.controller.speed_m_s),
            (Axis::TurnRate, conditions.controller.turn_rate_rad_s),
            (Axis::Robots, conditions.robots as f64),
        ])?;
        let circumstances = Circumstances::of(conditions, sweep.duration_s);
        Ok(Self { cell, circumstances, factors: sweep.factors() })
    }
}

fn chosen(folder: &Path) -> anyhow::Result<Cell> {
    let path = folder.join("choice.json");
    if !path.exists() {
        let folder = folder.display();
        bail!(
            "{folder} has no choice.json; make it with `rsrs choose {folder} -o {}`, or name a cell",
            path.display()
        );
    }
    let (name, text) = read(&path)?;
    let choice: Choice =
        serde_json::from_str(&text).with_context(|| format!("{name} is not a choice"))?;
    Ok(choice.cell)
}
