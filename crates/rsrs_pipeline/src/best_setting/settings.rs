//! Lists of settings.

use rsrs_core::quantity::Cell;

use super::search::{Changes, Tried};

/// Settings of each robot that are promising for others.
const MOST_PROMISING: usize = 20;

/// Settings that were good for one robot or another.
pub fn promising(robots: &[&[Tried]]) -> Vec<Cell> {
    first_of_each(robots, MOST_PROMISING)
}

pub(super) fn first_of_each(robots: &[&[Tried]], n: usize) -> Vec<Cell> {
    let mut cells: Vec<Cell> = Vec::new();
    for tried in robots.iter().flat_map(|tried| tried.iter().take(n)) {
        if !cells.contains(&tried.cell) {
            cells.push(tried.cell.clone());
        }
    }
    cells
}

/// Cells with the settings that are among some changes, each once.
pub(super) fn with_settings(cells: &[Cell], changes: &Changes) -> Vec<Cell> {
    let mut changed: Vec<Cell> = Vec::new();
    for cell in cells {
        let value = |(axis, value)| {
            let change = changes.iter().find(|(other, _)| *other == axis);
            (axis, change.map_or(value, |(_, value)| *value))
        };
        let cell = Cell::new(cell.iter().map(value)).expect("the axes are those of a cell");
        if !changed.contains(&cell) {
            changed.push(cell);
        }
    }
    changed
}
