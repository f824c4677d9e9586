//! Where in a sweep a cell lies, and which swept cell is nearest where it lies nowhere.

use crate::diagram::PhaseDiagram;
use crate::numerals::SAME;
use crate::quantity::{Axis, Cell};

/// Why values are not those of a swept cell.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NotSwept {
    /// They lie beside or between the swept values.
    #[error("cell {found} is not on the swept grid; the nearest swept cell is {nearest}")]
    OffTheGrid {
        /// The cell, on the swept axes.
        found: Cell,
        /// The swept cell that is nearest, in steps of the grid.
        nearest: Cell,
    },
    /// A swept axis has no value in the cell.
    #[error("no value for {0}, which the sweep varies")]
    NoValue(Axis),
}

impl PhaseDiagram {
    /// Finds the swept cell with these values: its index in [`PhaseDiagram::cells`].
    ///
    /// It takes a value on every swept axis, in any order; further axes do not matter. Numbers that
    /// differ by less than a billionth were the same before they were written to a file. Of equally
    /// near cells the first one counts as the nearest, which [`NotSwept`] names.
    ///
    /// # Panics
    ///
    /// If the diagram has no cells; no sweep makes one.
    pub fn locate(&self, values: &Cell) -> Result<usize, NotSwept> {
        let axes: Vec<SweptAxis> = self
            .axes
            .iter()
            .map(|axis| {
                let sought = values.get(*axis).ok_or(NotSwept::NoValue(*axis))?;
                Ok(SweptAxis { axis: *axis, sought, step: step(&self.values(*axis)) })
            })
            .collect::<Result<_, NotSwept>>()?;
        if let Some(index) =
            self.cells.iter().position(|entry| axes.iter().all(|axis| axis.holds(&entry.cell)))
        {
            return Ok(index);
        }
        let steps2 = |cell: &Cell| axes.iter().map(|axis| axis.steps(cell).powi(2)).sum::<f64>();
        let nearest = self
            .cells
            .iter()
            .map(|entry| &entry.cell)
            .min_by(|one, other| steps2(one).total_cmp(&steps2(other)))
            .expect("a sweep has cells");
        let found = Cell::new(axes.iter().map(|axis| (axis.axis, axis.sought)))
            .expect("the axes of a sweep are distinct, and values of a cell finite");
        Err(NotSwept::OffTheGrid { found, nearest: nearest.clone() })
    }
}

/// A swept axis, and what is sought on it.
struct SweptAxis {
    axis: Axis,
    sought: f64,
    /// Mean distance of neighbouring values; 1 for an axis with a single one.
    step: f64,
}

impl SweptAxis {
    fn value(&self, cell: &Cell) -> f64 {
        cell.get(self.axis).expect("a cell has a value on every swept axis")
    }

    fn holds(&self, cell: &Cell) -> bool {
        let value = self.value(cell);
        (value - self.sought).abs() <= SAME * value.abs()
    }

    fn steps(&self, cell: &Cell) -> f64 {
        (self.value(cell) - self.sought) / self.step
    }
}

/// Mean distance of neighbouring ones among ascending values.
fn step(values: &[f64]) -> f64 {
    match values {
        [first, .., last] => (last - first) / (values.len() - 1) as f64,
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagram::DiagramCell;
    use crate::judge::counts::PhaseCounts;

    fn cell(text: &str) -> Cell {
        text.parse().unwrap()
    }

    fn diagram(cells: &[&str]) -> PhaseDiagram {
        let entry = |text: &&str| DiagramCell { cell: cell(text), counts: PhaseCounts::default() };
        PhaseDiagram {
            axes: vec![Axis::Speed, Axis::TurnRate],
            cells: cells.iter().map(entry).collect(),
        }
    }

    #[test]
    fn a_swept_cell_is_found_whatever_else_the_cell_contains() {
        let diagram =
            diagram(&["speed_m_s=0.05,turn_rate_rad_s=0.5", "speed_m_s=0.1,turn_rate_rad_s=0.5"]);

        let found = diagram.locate(&cell("robots=9,turn_rate_rad_s=0.5,speed_m_s=0.1"));

        assert_eq!(found, Ok(1));
    }

    #[test]
    fn the_nearest_cell_is_so_in_steps_of_the_grid() {
        let diagram =
            diagram(&["speed_m_s=0.05,turn_rate_rad_s=0.75", "speed_m_s=0.15,turn_rate_rad_s=0.5"]);

        let error = diagram.locate(&cell("speed_m_s=0.14,turn_rate_rad_s=0.7")).unwrap_err();

        // As plain numbers the first would be nearer: 0.10 away, not 0.20; in steps the second is.
        assert_eq!(
            error.to_string(),
            "cell speed_m_s=0.14,turn_rate_rad_s=0.7 is not on the swept grid; the nearest swept \
             cell is speed_m_s=0.15,turn_rate_rad_s=0.5"
        );
    }

    #[test]
    fn a_cell_without_a_swept_axis_is_nowhere() {
        let diagram = diagram(&["speed_m_s=0.05,turn_rate_rad_s=0.75"]);

        let error = diagram.locate(&cell("speed_m_s=0.05")).unwrap_err();

        assert_eq!(error, NotSwept::NoValue(Axis::TurnRate));
    }
}
