//! What a sweep is once it is finished, wherever it is kept.

use std::collections::BTreeSet;

use rsrs_core::diagram::PhaseDiagram;
use rsrs_core::diagram::choice::Worlds;
use rsrs_core::diagram::sweep_file::Axes;
use rsrs_core::quantity::Cell;

use crate::error::with_help;
use crate::sweep::source::ResolvedSweep;

/// A finished sweep.
#[derive(Clone, Debug)]
pub struct SweepResult {
    /// What was swept.
    pub source: ResolvedSweep,
    /// What came out, with the robots that the sweep makes worse.
    pub diagram: PhaseDiagram,
    /// What came out with the robots as measured; `None` if they are not made worse, or in a folder
    /// that was made before sweeps held both worlds.
    pub as_measured: Option<PhaseDiagram>,
}

/// One of the two worlds of a sweep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum World {
    /// The robots are made worse than measured, by the sweep's `harsher`.
    #[default]
    Harsher,
    /// The robots are as measured.
    AsMeasured,
}

impl World {
    /// Its name in tables.
    pub fn key(self) -> &'static str {
        match self {
            Self::Harsher => "harsher",
            Self::AsMeasured => "as_measured",
        }
    }
}

impl SweepResult {
    /// Both worlds; an error for a folder from before sweeps held both.
    pub fn worlds(&self) -> anyhow::Result<Worlds<'_>> {
        let is_one = self.source.as_measured().is_none();
        if self.as_measured.is_none() && !is_one {
            return Err(with_help(
                "this sweep holds only robots made worse: it was made before \
                 sweeps held the robots as measured, too",
                "sweep it again into another folder, and go on there: `rsrs sweep DIR/sweep.yaml -o \
                 NEW_DIR`",
            ));
        }
        Ok(Worlds { simulated: &self.diagram, as_measured: self.as_measured.as_ref() })
    }

    /// The cells of so many robots, of which there must be one; all of them where no number is
    /// given.
    pub fn of_robots(mut self, robots: Option<usize>) -> anyhow::Result<Self> {
        let Some(robots) = robots else { return Ok(self) };
        let cells = self.source.cells("sweep.yaml")?;
        let kept: Vec<Cell> = cells
            .iter()
            .filter(|(_, it)| it.robots == robots)
            .map(|(cell, _)| cell.clone())
            .collect();
        if kept.is_empty() {
            let numbers: BTreeSet<usize> = cells.iter().map(|(_, it)| it.robots).collect();
            let numbers: Vec<String> = numbers.iter().map(ToString::to_string).collect();
            return Err(with_help(
                format!("no cell has {robots} robots, but {}", numbers.join(", ")),
                "sweep that number: `robots` is an axis, or under `fixed`",
            ));
        }
        for diagram in std::iter::once(&mut self.diagram).chain(&mut self.as_measured) {
            diagram.cells.retain(|entry| kept.contains(&entry.cell));
        }
        self.source.sweep.axes = Axes::default();
        self.source.sweep.cells = Some(kept);
        Ok(self)
    }

    /// The diagram of one world.
    pub fn of_world(&self, world: World) -> anyhow::Result<&PhaseDiagram> {
        match world {
            World::Harsher => Ok(&self.diagram),
            World::AsMeasured => {
                let worlds = self.worlds()?;
                Ok(worlds.as_measured.unwrap_or(worlds.simulated))
            }
        }
    }
}
