//! The chosen cell over the heat map, and where cells lie on it.

use rsrs_core::quantity::Cell;

use crate::palette::INK;
use crate::plot::Plot;
use crate::slice::is_same;
use crate::svg::{Element, rectangle};
use crate::track::Point;

/// The column and row of a cell of the grid, if the picture shows it.
pub fn grid_cell(plot: &Plot, cell: &Cell) -> Option<(usize, usize)> {
    let (x, y) = plot.slice.place(cell)?;
    let index = |values: &[f64], value| values.iter().position(|other| is_same(*other, value));
    Some((index(&plot.x.values, x)?, index(&plot.y.values, y)?))
}

/// Where a cell lies, in pixels, on the grid or between its points; `None` if it lies in another
/// slice or outside the axes.
pub fn position_px(plot: &Plot, cell: &Cell) -> Option<Point> {
    let (x, y) = plot.slice.place(cell)?;
    let is_inside = plot.x.contains(x) && plot.y.contains(y);
    is_inside.then(|| (plot.x.position_px(x), plot.y.position_px(y)))
}

/// How the chosen cell is marked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChosenShape {
    /// The cell is framed.
    Frame,
    /// A ring lies on it.
    Ring,
}

/// Draws a frame around the chosen cell, or a ring where it is too small or between the swept ones;
/// the legend needs to know which. `None` if the picture does not show the cell.
pub fn chosen(plot: &Plot, cell: &Cell) -> Option<(ChosenShape, Element)> {
    let (x_px, y_px) = position_px(plot, cell)?;
    let framed = grid_cell(plot, cell)
        .map(|(column, row)| plot.cell_px(column, row))
        .filter(|(_, _, width_px, height_px)| width_px.min(*height_px) >= 16.0);
    Some(match framed {
        Some((left_px, top_px, width_px, height_px)) => {
            let frame = double_stroke(|| {
                rectangle(left_px + 0.5, top_px + 0.5, width_px - 1.0, height_px - 1.0)
                    .with("stroke-linejoin", "round")
            });
            (ChosenShape::Frame, frame)
        }
        None => (ChosenShape::Ring, ring((x_px, y_px))),
    })
}

/// The ring around a chosen cell, here and in the legend.
pub fn ring((x_px, y_px): Point) -> Element {
    double_stroke(|| Element::circle((x_px, y_px), 8.0))
}

/// A dark outline with a white one around it, visible on every colour.
pub fn double_stroke(shape: impl Fn() -> Element) -> Element {
    let outline = |stroke: &str, width_px: f64| shape().outlined(stroke, width_px);
    Element::new("g")
        .fixed()
        .with("pointer-events", "none")
        .child(outline("#ffffff", 6.0))
        .child(outline(INK, 3.0))
}
