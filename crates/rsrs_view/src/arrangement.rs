//! How the panels of a diagram and its legend share a page.

use crate::axes::left_of_cells_px;
use crate::boundary::OUTSIDE_PX;
use crate::chart::BELOW_PX;
use crate::header::{Heading, MARGIN_PX};
use crate::legend;
use crate::panel::{Lines, above_px};
use crate::picture::{DiagramPicture, Panel};
use crate::plot::size_px;
use crate::slice::Slice;
use crate::theme::Theme;

/// From the cells to the legend beside them, in pixels.
pub const BETWEEN_PX: f64 = 26.0;

/// Around a page whose width is given: a journal has margins of its own.
pub const NARROW_MARGIN_PX: f64 = 8.0;
/// Panels side by side at most.
const MOST_COLUMNS: usize = 3;
/// The narrowest panel beside another one or beside the legend, in pixels.
const LEAST_PLOT_PX: f64 = 210.0;
/// Width of a cell in one of several panels, in pixels, and bounds of its plot.
const SMALL_CELL_PX: f64 = 34.0;
const SMALL_PLOT_PX: [f64; 2] = [150.0, 300.0];

/// Where the legend is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LegendPlace {
    /// Right of the panels.
    Right,
    /// Below them.
    Below,
}

/// Where everything is on the page, in pixels.
#[derive(Clone, Copy, Debug)]
pub struct Arrangement {
    /// Width of the page.
    pub page_px: f64,
    /// Around the page.
    pub margin_px: f64,
    /// Width and height of the cells of each panel.
    pub plot_px: (f64, f64),
    /// Where the legend is.
    pub legend: LegendPlace,
    n_columns: usize,
    /// From the margin, or from another panel's end, to the cells.
    axis_px: f64,
    /// What stands above the cells.
    above_px: f64,
    /// What may stand right of them.
    beside_px: f64,
}

impl Arrangement {
    /// Arranges a picture with one panel or more, of these slices.
    pub fn new(picture: &DiagramPicture, slices: &[Slice]) -> Self {
        let lines = Lines::new(picture);
        let natural_px = natural_px(slices);
        let axes_px = slices.iter().map(|slice| left_of_cells_px(slice, natural_px.1));
        let free = Self {
            page_px: 0.0,
            margin_px: MARGIN_PX,
            plot_px: natural_px,
            legend: LegendPlace::Right,
            n_columns: slices.len().min(if slices.len() == 4 { 2 } else { MOST_COLUMNS }),
            axis_px: axes_px.fold(0.0, f64::max),
            above_px: above_px(lines),
            beside_px: if lines == Lines::Drawn { 2.0 * OUTSIDE_PX + 9.0 } else { 10.0 },
        };
        let wide = match picture.width_px {
            None => free.as_wide_as_it_takes(),
            Some(width_px) => free.within(width_px, slices.len(), picture.theme),
        };
        wide.below_headings(picture)
    }

    fn as_wide_as_it_takes(mut self) -> Self {
        let n_columns = self.n_columns as f64;
        let panels_px =
            n_columns * (self.axis_px + self.plot_px.0) + (n_columns - 1.0) * self.beside_px;
        self.page_px = 2.0 * self.margin_px + panels_px + BETWEEN_PX + legend::WIDTH_PX;
        self
    }

    /// As many panels side by side as are legible, and the legend beside them where there is room.
    fn within(mut self, width_px: f64, n_panels: usize, theme: Theme) -> Self {
        self.page_px = width_px;
        self.margin_px = NARROW_MARGIN_PX;
        let room_px = width_px - 2.0 * self.margin_px;
        let plot_px = |room_px: f64, n_columns: usize| {
            let n_columns = n_columns as f64;
            (room_px - n_columns * (self.axis_px + self.beside_px)) / n_columns
        };
        let beside_legend_px = room_px - (BETWEEN_PX - self.beside_px) - legend::WIDTH_PX;
        let fitting = |room_px: f64| {
            (1..=n_panels.min(MOST_COLUMNS)).rev().find(|n| plot_px(room_px, *n) >= LEAST_PLOT_PX)
        };
        let (beside, below) = (fitting(beside_legend_px), fitting(room_px));
        let (legend, n_columns, room_px) = match beside {
            Some(n_columns) if beside >= below && theme == Theme::Screen => {
                (LegendPlace::Right, n_columns, beside_legend_px)
            }
            Some(_) | None => (LegendPlace::Below, below.unwrap_or(1), room_px),
        };
        let natural_px = self.plot_px;
        let plot_width_px = plot_px(room_px, n_columns);
        self.legend = legend;
        self.n_columns = n_columns;
        self.plot_px = (plot_width_px, plot_width_px * natural_px.1 / natural_px.0);
        self
    }

    /// With room above the cells for the highest heading.
    fn below_headings(mut self, picture: &DiagramPicture) -> Self {
        let height_px = |panel: &Panel| Heading::new(&panel.heading, self.plot_px.0).height_px();
        let highest_px = picture.panels.iter().map(height_px).fold(0.0, f64::max);
        self.above_px += if highest_px > 0.0 { highest_px + 5.0 } else { 0.0 };
        self
    }

    /// The upper left corner of the cells of one panel, below texts that end at `header_px`.
    pub fn corner_px(&self, index: usize, header_px: f64) -> (f64, f64) {
        let (column, row) = ((index % self.n_columns) as f64, (index / self.n_columns) as f64);
        let pitch_px = self.axis_px + self.plot_px.0 + self.beside_px;
        let row_px = self.above_px + self.plot_px.1 + BELOW_PX;
        let left_px = self.margin_px + self.axis_px + column * pitch_px;
        (left_px, header_px + self.above_px + row * row_px)
    }
}

/// Width and height of the cells, where they may be as large as they are best.
fn natural_px(slices: &[Slice]) -> (f64, f64) {
    if let [slice] = slices {
        return size_px(slice);
    }
    let most = |n: fn(&Slice) -> usize| slices.iter().map(n).max().unwrap_or(1) as f64;
    let [least_px, most_px] = SMALL_PLOT_PX;
    let side_px = |n: f64| (n * SMALL_CELL_PX).clamp(least_px, most_px);
    (side_px(most(|slice| slice.x_values.len())), side_px(most(|slice| slice.y_values.len())))
}
