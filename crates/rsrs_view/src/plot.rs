//! The heat map: where its cells lie, their colours, numbers and tooltips.

use rsrs_core::diagram::PhaseDiagram;
use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::Axis;

use crate::cell_values::{CellValues, ValueScale};
use crate::palette::{Colour, INK, NOT_SWEPT, shade};
use crate::quantity::named;
use crate::scale::{Scale, label, widest_px};
use crate::slice::Slice;
use crate::svg::{Element, line_of_text, number, rectangle};
use crate::text::{Weight, width_px};

/// A box that no line enters: left, top, right and bottom, in pixels.
pub type Kept = [f64; 4];

/// The rectangle of cells on the page.
#[derive(Clone, Debug)]
pub struct Plot<'a> {
    /// What is drawn.
    pub slice: &'a Slice,
    /// Values to pixels from left to right.
    pub x: Scale,
    /// Values to pixels from bottom to top.
    pub y: Scale,
    /// Left edge, in pixels.
    pub left_px: f64,
    /// Right edge, in pixels.
    pub right_px: f64,
    /// Upper edge, in pixels.
    pub top_px: f64,
    /// Lower edge, in pixels.
    pub bottom_px: f64,
    /// Numbers in the place of phases.
    values: Option<PlotValues<'a>>,
}

/// The numbers of the cells of one plot.
#[derive(Clone, Debug)]
struct PlotValues<'a> {
    name: &'a str,
    scale: ValueScale,
    /// Row by row from the lowest, with whether the cell is framed.
    cells: Vec<(Option<f64>, bool)>,
}

/// Width and height of the cells, in pixels: large cells for small grids, within bounds that leave
/// room for the axes' labels.
pub fn size_px(slice: &Slice) -> (f64, f64) {
    let width_px = (slice.x_values.len() as f64 * 64.0).clamp(220.0, 528.0);
    let height_px = (slice.y_values.len() as f64 * 64.0).clamp(220.0, 400.0);
    (width_px, height_px)
}

impl<'a> Plot<'a> {
    /// Lays a slice out from its upper left corner, with a width and a height, in pixels.
    pub fn new(
        slice: &'a Slice,
        (left_px, top_px): (f64, f64),
        (width_px, height_px): (f64, f64),
    ) -> Self {
        let (right_px, bottom_px) = (left_px + width_px, top_px + height_px);
        Self {
            slice,
            x: Scale::new(slice.x_values.clone(), left_px, right_px),
            y: Scale::new(slice.y_values.clone(), bottom_px, top_px),
            left_px,
            right_px,
            top_px,
            bottom_px,
            values: None,
        }
    }

    /// The same with numbers in the place of its phases, as the `panel` of a picture with the
    /// values of all its panels.
    pub fn with_values(
        mut self,
        values: &'a CellValues,
        diagram: &PhaseDiagram,
        panel: usize,
    ) -> Self {
        let n_columns = self.slice.x_values.len();
        let mut cells = vec![(None, false); n_columns * self.slice.y_values.len()];
        for (column, row, index) in self.slice.places(diagram) {
            let is_framed = values.framed.as_ref().is_some_and(|(_, framed)| framed[panel][index]);
            cells[row * n_columns + column] = (values.of_panels[panel][index], is_framed);
        }
        self.values = Some(PlotValues { name: &values.name, scale: values.scale, cells });
        self
    }

    /// The number of a cell: none without numbers, or where it has none.
    fn value(&self, column: usize, row: usize) -> Option<(f64, &PlotValues<'a>)> {
        let values = self.values.as_ref()?;
        Some((values.cells[row * self.slice.x_values.len() + column].0?, values))
    }

    /// Whether some cell has nothing to show.
    pub fn has_blanks(&self) -> bool {
        let is_blank = |values: &PlotValues| values.cells.iter().any(|(value, _)| value.is_none());
        self.values.as_ref().map_or_else(|| self.slice.has_holes(), is_blank)
    }

    /// The colour of a cell; `None` where it has no result.
    fn colour(&self, column: usize, row: usize) -> Option<Colour> {
        if self.values.is_some() {
            return self.value(column, row).map(|(value, values)| values.scale.colour(value));
        }
        let counts = self.slice.counts(column, row)?;
        let phase = counts.majority()?;
        Some(shade(phase, counts.share(phase)))
    }

    /// Columns and rows of all cells, row by row.
    fn cells(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let n_columns = self.slice.x_values.len();
        (0..self.slice.y_values.len())
            .flat_map(move |row| (0..n_columns).map(move |column| (column, row)))
    }

    /// The most frequent phase of each cell that has one.
    pub fn majorities(&self) -> impl Iterator<Item = Phase> + '_ {
        self.cells().filter_map(|(column, row)| self.slice.counts(column, row)?.majority())
    }

    /// Left, top, width and height of a cell, in pixels.
    pub fn cell_px(&self, column: usize, row: usize) -> (f64, f64, f64, f64) {
        let (left_px, right_px) = self.x.span_px(column);
        let (top_px, bottom_px) = self.y.span_px(row);
        (left_px, top_px, right_px - left_px, bottom_px - top_px)
    }

    /// Font size at which `B_s` fits the cells, in pixels; `None` if they are too small for it.
    pub fn number_px(&self) -> Option<f64> {
        [11.0, 10.0, 9.0, 8.0, 7.0].into_iter().find(|size_px| {
            let n_fitting = self.cells().filter(|cell| self.fits(*cell, *size_px)).count();
            2 * n_fitting > self.cells().count()
        })
    }

    fn fits(&self, (column, row): (usize, usize), size_px: f64) -> bool {
        let (_, _, cell_width_px, cell_height_px) = self.cell_px(column, row);
        let widest = match &self.values {
            Some(values) => values.scale.ends().map(|end| values.scale.text(end)),
            None => ["0.00".to_owned(), String::new()],
        };
        widest_px(&widest, size_px) + 8.0 <= cell_width_px && size_px * 1.3 <= cell_height_px
    }
}

/// Draws every cell in its colour, with its counts as tooltip.
pub fn heat_map(plot: &Plot) -> Element {
    let smallest_px = plot
        .cells()
        .map(|(column, row)| plot.cell_px(column, row))
        .fold(f64::INFINITY, |least, (_, _, width_px, height_px)| {
            least.min(width_px).min(height_px)
        });
    let has_rims = smallest_px >= 14.0;
    let cells = plot.cells().map(|(column, row)| {
        let (x_px, y_px, width_px, height_px) = plot.cell_px(column, row);
        let colour = plot.colour(column, row);
        let fill = colour.map_or_else(|| NOT_SWEPT.to_owned(), Colour::hex);
        // Light rims around large cells; small ones overlap a little, else seams would show.
        let stroke = if has_rims { "#ffffff" } else { &fill };
        rectangle(x_px, y_px, width_px, height_px)
            .with("fill", &fill)
            .with("stroke", stroke)
            .titled(&tooltip(plot, column, row))
    });
    Element::new("g").fixed().at("stroke-width", 0.6).children(cells)
}

/// Where the number of a cell stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberPlace {
    /// In its middle.
    Middle,
    /// In its upper half: a mark lies below.
    Above,
    /// Nowhere: a mark takes all the room.
    Nowhere,
}

/// Writes `B_s` into every cell where it fits, at the place that a cell of a column and a row has
/// for it, and keeps the room that each number takes.
pub fn numbers(
    plot: &Plot,
    place: impl Fn(usize, usize) -> NumberPlace,
) -> (Option<Element>, Vec<Kept>) {
    let Some(size_px) = plot.number_px() else { return (None, Vec::new()) };
    let (texts, kept): (Vec<Element>, Vec<Kept>) = plot
        .cells()
        .filter_map(|(column, row)| {
            let fits = plot.fits((column, row), size_px);
            cell_number(plot, (column, row), place(column, row), size_px).filter(|_| fits)
        })
        .unzip();
    let group = Element::new("g")
        .fixed()
        .at("font-size", size_px)
        .with("text-anchor", "middle")
        .with("pointer-events", "none")
        .at("stroke-width", 4.0)
        .with("stroke-linejoin", "round")
        .with("paint-order", "stroke");
    (Some(group.children(texts)), kept)
}

fn cell_number(
    plot: &Plot,
    (column, row): (usize, usize),
    place: NumberPlace,
    size_px: f64,
) -> Option<(Element, Kept)> {
    let colour = plot.colour(column, row)?;
    let (x_px, y_px, cell_width_px, height_px) = plot.cell_px(column, row);
    let text = match plot.value(column, row) {
        Some((value, values)) => values.scale.text(value),
        None => format!("{:.2}", plot.slice.counts(column, row)?.wanted_share()),
    };
    let middle_px = match place {
        NumberPlace::Middle => y_px + height_px / 2.0,
        NumberPlace::Above => y_px + 0.28 * height_px,
        NumberPlace::Nowhere => return None,
    };
    let centre_px = x_px + cell_width_px / 2.0;
    let half_px = width_px(&text, size_px, Weight::Regular) / 2.0 + 2.5;
    let kept = [
        centre_px - half_px,
        middle_px - 0.36 * size_px - 2.5,
        centre_px + half_px,
        middle_px + 0.36 * size_px + 2.5,
    ];
    let text = line_of_text(centre_px, middle_px + 0.36 * size_px, &text);
    // The stroke in the cell's colour keeps the rim of a small cell from its number.
    Some((text.with("fill", colour.ink()).with("stroke", &colour.hex()), kept))
}

/// What a cell is and how its replicates ended, most frequent phase first.
fn tooltip(plot: &Plot, column: usize, row: usize) -> String {
    let slice = plot.slice;
    let mut values = vec![quantity(slice.x, slice.x_values[column])];
    values.extend(slice.y.map(|y| quantity(y, slice.y_values[row])));
    let place = values.join(", ");
    let Some(counts) = slice.counts(column, row) else {
        return format!("{place}\nnot swept");
    };
    if plot.values.is_some() {
        let value = plot.value(column, row);
        let value = value.map(|(value, it)| format!("{}: {}", it.name, it.scale.text(value)));
        return format!("{place}\n{}", value.unwrap_or_else(|| "no value".to_owned()));
    }
    let mut phases = counts.behaviour().phases().to_vec();
    phases.retain(|phase| counts.get(*phase) > 0);
    phases.sort_by_key(|phase| std::cmp::Reverse(counts.get(*phase)));
    let endings: Vec<String> =
        phases.iter().map(|phase| format!("{} {phase}", counts.get(*phase))).collect();
    let plural = if counts.total() == 1 { "replicate" } else { "replicates" };
    let total = counts.total();
    if endings.is_empty() {
        return format!("{place}\nno {plural}");
    }
    format!("{place}\n{total} {plural}: {}", endings.join(", "))
}

/// A value with the name and the unit of its axis, in as many digits as tell it from others of a grid.
pub fn quantity(axis: Axis, value: f64) -> String {
    named(axis, value, &label(value))
}

/// Frames the cells that are to be framed.
pub fn frames(plot: &Plot) -> Vec<Element> {
    let Some(values) = &plot.values else { return Vec::new() };
    let n_columns = plot.slice.x_values.len();
    let framed = plot.cells().filter(|(column, row)| values.cells[row * n_columns + column].1);
    let frame = |(column, row): (usize, usize)| {
        let (x_px, y_px, width_px, height_px) = plot.cell_px(column, row);
        rectangle(x_px + 1.5, y_px + 1.5, width_px - 3.0, height_px - 3.0)
            .fixed()
            .outlined(INK, 2.0)
            .with("pointer-events", "none")
    };
    framed.map(frame).collect()
}

/// Draws a line wherever neighbouring cells end in different phases.
pub fn region_lines(plot: &Plot) -> Element {
    let majority = |column: usize, row: usize| {
        (column < plot.slice.x_values.len() && row < plot.slice.y_values.len())
            .then(|| plot.slice.counts(column, row).and_then(|counts| counts.majority()))
            .flatten()
    };
    let differ =
        |one: Option<Phase>, other: Option<Phase>| one.is_some() && other.is_some() && one != other;
    let mut path: Vec<String> = Vec::new();
    for (column, row) in plot.cells() {
        let here = majority(column, row);
        let (x_px, y_px, width_px, height_px) = plot.cell_px(column, row);
        let (right, bottom) = (number(x_px + width_px), number(y_px + height_px));
        if differ(here, majority(column + 1, row)) {
            path.push(format!("M{right} {}V{bottom}", number(y_px)));
        }
        if differ(here, majority(column, row + 1)) {
            path.push(format!("M{} {}H{right}", number(x_px), number(y_px)));
        }
    }
    Element::new("path")
        .fixed()
        .with("d", &path.concat())
        .outlined(INK, 1.2)
        .with("stroke-linecap", "square")
}
