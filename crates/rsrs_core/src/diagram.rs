//! The phase diagram: how often each cell of a sweep ended in each phase.

pub mod adaptive;
pub mod choice;
mod locate;
pub mod settling;
pub mod sweep_file;
pub mod theory;

use crate::judge::behaviour::Behaviour;
use crate::judge::counts::PhaseCounts;
use crate::judge::phase::Phase;
use crate::quantity::{Axis, Cell};

pub use locate::NotSwept;

/// One swept cell and what became of its replicates.
#[derive(Clone, Debug, PartialEq)]
pub struct DiagramCell {
    /// The values on the swept axes.
    pub cell: Cell,
    /// How its replicates ended.
    pub counts: PhaseCounts,
}

/// The result of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseDiagram {
    /// The swept axes, in the order of the sweep file.
    pub axes: Vec<Axis>,
    /// Every swept cell, the first axis varying slowest.
    pub cells: Vec<DiagramCell>,
}

impl PhaseDiagram {
    /// The values of one axis that occur, ascending.
    pub fn values(&self, axis: Axis) -> Vec<f64> {
        let mut values: Vec<f64> =
            self.cells.iter().filter_map(|entry| entry.cell.get(axis)).collect();
        values.sort_by(f64::total_cmp);
        values.dedup_by(|left, right| left.to_bits() == right.to_bits());
        values
    }

    /// The entry of exactly this cell.
    pub fn find(&self, cell: &Cell) -> Option<&DiagramCell> {
        self.cells.iter().find(|entry| entry.cell == *cell)
    }

    /// The behaviour whose phases it shows.
    pub fn behaviour(&self) -> Behaviour {
        let mut counted = self.cells.iter().filter(|entry| entry.counts.total() > 0);
        counted.next().map_or(Behaviour::default(), |entry| entry.counts.behaviour())
    }

    /// How many cells have which phase as their most frequent one.
    pub fn majorities(&self) -> Vec<(Phase, usize)> {
        let n = |phase| {
            self.cells.iter().filter(|entry| entry.counts.majority() == Some(phase)).count()
        };
        self.behaviour().phases().iter().map(|phase| (*phase, n(*phase))).collect()
    }
}
