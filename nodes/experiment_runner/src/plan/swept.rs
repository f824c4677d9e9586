//! The cell of a sweep that a run holds against its prediction.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use rsrs_core::conditions::controller_table::ControllerTable;
use rsrs_core::conditions::operator::{OperatorConditions, controller_values};
use rsrs_core::diagram::choice::Choice;
use rsrs_core::diagram::folder::{self, CHOICE, SWEEP, SweptSource, UNFINISHED, UnfinishedSweep};
use rsrs_core::diagram::sweep_file::{OtherSweep, SweepFile};
use rsrs_core::diagram::{DiagramCell, PhaseDiagram};
use rsrs_core::help::{Help, Helpful};
use rsrs_core::judge::counts::PhaseCounts;
use rsrs_core::quantity::{Axis, Cell};
use rsrs_core::robot::harsher::HarsherFactors;
use rsrs_core::robot::profile::RobotProfile;
use rsrs_files::quoted;

use super::read;

/// Why a cell of a sweep cannot be run.
#[derive(Debug, thiserror::Error)]
pub enum SweptCellError {
    /// The cell fixes capabilities of its robots, and those of the run differ.
    #[error(
        "cell `{cell}` of {} is one of robots with {axis}={value}, a capability, and the run moves \
         the robots as measured",
        folder.display()
    )]
    Capability {
        /// The cell.
        cell: Cell,
        /// Folder of the sweep.
        folder: PathBuf,
        /// The capability.
        axis: Axis,
        /// Its value in the cell.
        value: f64,
    },
    /// The choice beside the sweep is another one's.
    #[error("{} {source}", path.display())]
    OtherSweep {
        /// The choice.
        path: PathBuf,
        /// Folder of the sweep.
        folder: PathBuf,
        /// Whose it is.
        source: OtherSweep,
    },
}

impl Help for SweptCellError {
    fn help(&self) -> Option<String> {
        Some(match self {
            Self::Capability { .. } => "`simulator: {profile: harsher}` in the experiment file \
                 simulates the robots of the cell; for real robots, sweep what can be set on them"
                .to_owned(),
            Self::OtherSweep { path, folder, .. } => {
                format!("choose again: `rsrs choose {} -o {}`", folder.display(), path.display())
            }
        })
    }
}

/// A swept cell, with what a run must keep to be compared with it.
#[derive(Clone, Debug)]
pub struct SweptCell {
    /// Speed, turning rate and number of robots.
    pub cell: Cell,
    /// What must be the same.
    pub operator_conditions: OperatorConditions,
    /// The table of its controller, if that has states.
    pub table: Option<ControllerTable>,
    /// How the sweep's robots are worse than the measured ones.
    pub factors: HarsherFactors,
    /// Capabilities of the sweep's robots in this cell, where the sweep fixes or varies them.
    pub capabilities: Vec<(Axis, f64)>,
    /// Digest of the profile of the measured robots.
    pub profile_digest: String,
    /// Folder of the sweep.
    folder: PathBuf,
    /// The cell on all axes of the sweep.
    swept: Cell,
    /// The first capability that differs between the cells of the sweep.
    varied: Option<Axis>,
}

impl SweptCell {
    /// Finds a cell in the folder of a sweep that is finished; the chosen one if none is asked for. If
    /// it was not swept, the nearest one that was is named.
    pub fn find(folder: &Path, asked: Option<&Cell>) -> anyhow::Result<Self> {
        let path = folder.join(SWEEP);
        if !path.exists() {
            let folder = folder.display();
            bail!(
                "{folder} is not the folder of a sweep: it has no {SWEEP}; make it with `rsrs sweep \
                 SWEEP.yaml -o {folder}`"
            );
        }
        if folder.join(UNFINISHED).exists() {
            let finish = folder::finish(&quoted(&path), &quoted(folder));
            let folder = folder.display().to_string();
            return Err(Helpful::from(UnfinishedSweep { folder, finish }).into());
        }
        let (name, text) = read(&path)?;
        let SweptSource { sweep, profile, .. } = SweptSource::parse(&name, &text)?;
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
            None => chosen(folder, &sweep, &profile)?,
        };
        let index = diagram.locate(&asked).with_context(|| folder.display().to_string())?;
        let (swept, conditions) = &cells[index];
        let robots = (Axis::Robots, conditions.robots as f64);
        let cell =
            Cell::new(controller_values(&conditions.controller).into_iter().chain([robots]))?;
        let operator_conditions = OperatorConditions::new(conditions, sweep.duration_s);
        // Where the table is two commands, the cell has them.
        let table = sweep.table().filter(|_| conditions.controller.parameters().is_none()).cloned();
        let values = sweep.fixed.values.iter().copied().chain(swept.iter());
        let mut axes = diagram.axes.iter().copied();
        Ok(Self {
            cell,
            operator_conditions,
            table,
            factors: sweep.factors(&profile),
            capabilities: values.filter(|(axis, _)| axis.is_capability()).collect(),
            profile_digest: profile.digest(),
            folder: folder.to_owned(),
            swept: swept.clone(),
            varied: axes.find(|axis| axis.is_capability() && diagram.values(*axis).len() > 1),
        })
    }

    /// Refuses to run this cell with robots as measured where the cells of the sweep differ in what
    /// robots can do: that cannot be set.
    pub fn check_measured(&self) -> Result<(), SweptCellError> {
        let Some((axis, value)) = self.varied.and_then(|axis| Some((axis, self.swept.get(axis)?)))
        else {
            return Ok(());
        };
        let (cell, folder) = (self.swept.clone(), self.folder.clone());
        Err(SweptCellError::Capability { cell, folder, axis, value })
    }
}

fn chosen(folder: &Path, sweep: &SweepFile, profile: &RobotProfile) -> anyhow::Result<Cell> {
    let path = folder.join(CHOICE);
    if !path.exists() {
        let folder = folder.display();
        bail!(
            "{folder} has no {CHOICE}; make it with `rsrs choose {folder} -o {}`, or name a cell",
            path.display()
        );
    }
    let (name, text) = read(&path)?;
    let choice: Choice =
        serde_json::from_str(&text).with_context(|| format!("{name} is not a choice"))?;
    sweep.check_choice(profile, choice.sweep_digest.as_deref()).map_err(|source| {
        let (path, folder) = (path.clone(), folder.to_owned());
        Helpful::from(SweptCellError::OtherSweep { path, folder, source })
    })?;
    Ok(choice.cell)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_that_is_unfinished_predicts_no_run() {
        let place = tempfile::tempdir().expect("the disk has room");
        let folder = place.path();
        std::fs::write(folder.join(SWEEP), "").expect("the disk has room");
        std::fs::create_dir(folder.join(UNFINISHED)).expect("the disk has room");

        let error = SweptCell::find(folder, None).expect_err("it is unfinished");

        let folder = folder.display();
        assert_eq!(error.to_string(), format!("the sweep in {folder} is unfinished"));
        let help =
            error.downcast_ref::<Helpful>().and_then(Helpful::help).expect("it can be finished");
        assert!(help.contains(&format!("rsrs sweep {folder}/{SWEEP} -o {folder}`")), "{help}");
    }
}
