//! The phase diagram: how often each cell of a sweep ended in each phase.

pub mod adaptive;
pub mod choice;
pub mod folder;
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
        values(self.cells.iter().map(|entry| &entry.cell), axis)
    }

    /// Where every cell is on the grid.
    fn points(&self) -> Vec<Point> {
        points(&self.axes, self.cells.iter().map(|entry| &entry.cell))
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

/// A cell as the positions of its values among those that occur, on each axis.
type Point = Vec<usize>;

/// Where cells that have values on some axes are on the grid of these.
fn points<'a>(axes: &[Axis], cells: impl Iterator<Item = &'a Cell> + Clone) -> Vec<Point> {
    let grid: Vec<(Axis, Vec<f64>)> =
        axes.iter().map(|axis| (*axis, values(cells.clone(), *axis))).collect();
    let point = |cell: &Cell| {
        let position = |(axis, values): &(Axis, Vec<f64>)| {
            let value = cell.get(*axis).expect("a cell has a value on every swept axis");
            values.partition_point(|other| *other < value)
        };
        grid.iter().map(position).collect()
    };
    cells.map(point).collect()
}

/// The values of an axis that occur, ascending.
fn values<'a>(cells: impl Iterator<Item = &'a Cell>, axis: Axis) -> Vec<f64> {
    let mut values: Vec<f64> = cells.filter_map(|cell| cell.get(axis)).collect();
    values.sort_by(f64::total_cmp);
    values.dedup_by(|left, right| left.to_bits() == right.to_bits());
    values
}

/// A point at another position on one axis.
fn moved(point: &[usize], axis: usize, position: usize) -> Point {
    let mut moved = point.to_vec();
    moved[axis] = position;
    moved
}
