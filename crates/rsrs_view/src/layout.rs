//! Where the cells of a diagram lie on its picture.

use rsrs_core::diagram::PhaseDiagram;

use crate::chart::Chart;
use crate::plot::Plot;
use crate::slice::Slice;

/// A diagram as SVG, with where its cells lie.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnDiagram {
    /// The picture.
    pub svg: String,
    /// Its width and height, in pixels.
    pub size_px: (f64, f64),
    /// The cells that it shows, row by row from the top, each from left to right.
    pub rows: Vec<Vec<CellBox>>,
}

/// Where one cell lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellBox {
    /// Which one, in the order of the diagram.
    pub index: usize,
    /// Its left edge, in pixels.
    pub left_px: f64,
    /// Its upper edge, in pixels.
    pub top_px: f64,
    /// Its width, in pixels.
    pub width_px: f64,
    /// Its height, in pixels.
    pub height_px: f64,
}

/// The cells of a heat map.
pub fn in_plot(diagram: &PhaseDiagram, plot: &Plot) -> Vec<Vec<CellBox>> {
    let slice = plot.slice;
    let mut rows: Vec<Vec<CellBox>> = vec![Vec::new(); slice.y_values.len()];
    let mut places = slice.places(diagram);
    places.sort_by_key(|(column, _, _)| *column);
    for (column, row, index) in places {
        let (left_px, top_px, width_px, height_px) = plot.cell_px(column, row);
        rows[row].push(CellBox { index, left_px, top_px, width_px, height_px });
    }
    rows.reverse();
    rows
}

/// The cells of a curve: from halfway to the value before to halfway to the one after.
pub fn along_curve(diagram: &PhaseDiagram, slice: &Slice, chart: &Chart) -> Vec<Vec<CellBox>> {
    let mut places = slice.places(diagram);
    places.sort_by_key(|(column, _, _)| *column);
    let x_px: Vec<f64> = slice.x_values.iter().map(|value| chart.x_px(*value)).collect();
    let middle_px = |one: usize, other: usize| f64::midpoint(x_px[one], x_px[other]);
    let boxed = |(column, _, index): (usize, usize, usize)| {
        let left_px = if column == 0 { chart.left_px } else { middle_px(column - 1, column) };
        let is_last = column + 1 == x_px.len();
        let right_px =
            if is_last { chart.left_px + chart.width_px } else { middle_px(column, column + 1) };
        CellBox {
            index,
            left_px,
            top_px: chart.top_px,
            width_px: right_px - left_px,
            height_px: chart.height_px,
        }
    };
    vec![places.into_iter().map(boxed).collect()]
}
