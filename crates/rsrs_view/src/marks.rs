//! Real runs on the heat map: the symbol of their phase, and how many ended as wanted.

use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::Cell;

use crate::overlay::{grid_cell, position_px};
use crate::palette::INK;
use crate::plot::{Kept, NumberPlace, Plot};
use crate::svg::{Element, line_of_text};
use crate::symbol::{Filling, MARK_PX, mark};
use crate::text::{Weight, width_px};
use crate::track::Point;

const COUNT_PX: f64 = 10.0;
/// Sizes that symbols may have, in pixels, the best first.
const SIZES_PX: [f64; 5] = [MARK_PX, 4.6, 3.8, 3.2, 2.7];

/// How often real runs at one cell ended in one phase, surely or not.
#[derive(Clone, Debug, PartialEq)]
pub struct ExperimentMark {
    /// Where they ran; swept or not.
    pub cell: Cell,
    /// What the judge found.
    pub phase: Phase,
    /// Whether that is settled; else the label is near another one, and somebody should look again.
    pub is_settled: bool,
    /// Whether a simulator moved some of the robots, so that it is no evidence about reality.
    pub is_simulated: bool,
    /// Number of runs.
    pub n: u64,
    /// Their names, as many as there are runs; empty if they have none. Any texts.
    pub names: Vec<String>,
}

impl ExperimentMark {
    /// The symbol of its runs, of which it has one.
    pub(crate) fn symbol(&self, at_px: Point, radius_px: f64) -> Element {
        mark(self.phase, self.filling(), (at_px, radius_px))
    }

    /// How its symbol is filled.
    pub(crate) fn filling(&self) -> Filling {
        if self.is_settled { Filling::Full } else { Filling::Hollow }
    }

    /// The phase in words, with a warning where it is near another one.
    pub(crate) fn label(&self) -> String {
        let warning = if self.is_settled { "" } else { " (not settled: look again)" };
        format!("{}{warning}", self.phase)
    }
}

/// Real runs at one place: the symbol of their most frequent phase, and how many of all ended in the
/// wanted one.
pub struct MarkPlace<'a> {
    /// The cell of the grid, if they are on one.
    pub grid_cell: Option<(usize, usize)>,
    /// Where the cell's number stands beside them.
    pub number: NumberPlace,
    runs: Vec<&'a ExperimentMark>,
    centre_px: Point,
    size: MarkSize,
}

/// What a place has room for, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
struct MarkSize {
    /// Radius of the symbol, if there is one.
    radius_px: Option<f64>,
    /// Font size of the text, if there is one.
    text_px: Option<f64>,
}

impl MarkSize {
    /// All that may be, the best first: symbol and text, the text alone, the symbol alone.
    fn all() -> impl Iterator<Item = Self> {
        let both = TEXTS_PX.into_iter().flat_map(|text_px| {
            let fitting =
                SIZES_PX.into_iter().filter(move |radius_px| 2.0 * radius_px <= 1.2 * text_px);
            fitting
                .map(move |radius_px| Self { radius_px: Some(radius_px), text_px: Some(text_px) })
        });
        let text = TEXTS_PX.map(|text_px| Self { radius_px: None, text_px: Some(text_px) });
        let symbol = SIZES_PX.map(|radius_px| Self { radius_px: Some(radius_px), text_px: None });
        both.chain(text).chain(symbol)
    }

    fn height_px(self) -> f64 {
        (2.5 * self.radius_px.unwrap_or(0.0)).max(0.8 * self.text_px.unwrap_or(0.0))
    }
}

/// Sizes of the text behind a symbol, in pixels, the best first.
const TEXTS_PX: [f64; 4] = [COUNT_PX, 9.0, 8.0, 7.0];
/// So far the frame of a chosen cell reaches into it, in pixels.
const FRAME_PX: f64 = 3.0;
/// Between a symbol and its text, in pixels.
const GAP_PX: f64 = 2.0;

/// Where the real runs of a picture are drawn, given the font size of the numbers in its cells, if
/// it has some.
pub fn places<'a>(
    plot: &Plot,
    marks: &'a [ExperimentMark],
    number_px: Option<f64>,
) -> Vec<MarkPlace<'a>> {
    let mut places: Vec<(Point, Vec<&ExperimentMark>)> = Vec::new();
    for run in marks.iter().filter(|run| run.n > 0) {
        let Some(place) = position_px(plot, &run.cell) else { continue };
        let is_here = |(x, y): Point| (x - place.0).abs() < 0.5 && (y - place.1).abs() < 0.5;
        match places.iter_mut().find(|(other, _)| is_here(*other)) {
            Some((_, runs)) => runs.push(run),
            None => places.push((place, vec![run])),
        }
    }
    let place = |(at_px, runs)| MarkPlace::new(plot, at_px, runs, number_px);
    places.into_iter().map(place).collect()
}

impl<'a> MarkPlace<'a> {
    fn new(
        plot: &Plot,
        at_px: Point,
        runs: Vec<&'a ExperimentMark>,
        number_px: Option<f64>,
    ) -> Self {
        let grid_cell = grid_cell(plot, &runs[0].cell);
        let free = Self {
            grid_cell,
            number: NumberPlace::Nowhere,
            runs,
            centre_px: at_px,
            size: MarkSize { radius_px: Some(MARK_PX), text_px: Some(COUNT_PX) },
        };
        let Some((column, row)) = grid_cell else { return free };
        let (left_px, top_px, width_px, height_px) = plot.cell_px(column, row);
        let x_px = left_px + width_px / 2.0;
        // The upper part is the number's, if it stays clear of a frame there.
        let is_clear = |size_px: &f64| 0.28 * height_px - 0.36 * size_px >= FRAME_PX;
        let number_px = number_px.filter(is_clear);
        let above_px = number_px.map(|size_px| 0.28 * height_px + 0.36 * size_px + 2.5);
        let below_number = above_px.and_then(|above_px| {
            let size = free.fitting(width_px, height_px - above_px - 2.0)?;
            let y_px = top_px + f64::midpoint(above_px, height_px - 2.0);
            size.text_px.is_some().then_some((size, y_px))
        });
        if let Some((size, y_px)) = below_number {
            return Self { number: NumberPlace::Above, size, centre_px: (x_px, y_px), ..free };
        }
        let least = MarkSize { radius_px: Some(SIZES_PX[4]), text_px: None };
        let size = free.fitting(width_px, height_px).unwrap_or(least);
        Self { size, centre_px: (x_px, top_px + height_px / 2.0), ..free }
    }

    /// The best size in a room, in pixels.
    fn fitting(&self, width_px: f64, height_px: f64) -> Option<MarkSize> {
        let is_inside = |size: &MarkSize| {
            self.width_px(*size) + 2.0 * FRAME_PX <= width_px && size.height_px() <= height_px
        };
        MarkSize::all().find(is_inside)
    }

    fn width_px(&self, size: MarkSize) -> f64 {
        let symbol_px = size.radius_px.map(|radius_px| 2.5 * radius_px);
        let text_px = size.text_px.map(|size_px| width_px(&self.text(), size_px, Weight::Bold));
        let gap_px = if symbol_px.is_some() && text_px.is_some() { GAP_PX } else { 0.0 };
        symbol_px.unwrap_or(0.0) + gap_px + text_px.unwrap_or(0.0)
    }

    /// How many runs ended in the wanted phase, of all: `21/24`.
    fn text(&self) -> String {
        let is_wanted = |run: &&&ExperimentMark| run.phase == run.phase.behaviour().wanted();
        let n_wanted: u64 = self.runs.iter().filter(is_wanted).map(|run| run.n).sum();
        let n: u64 = self.runs.iter().map(|run| run.n).sum();
        format!("{n_wanted}/{n}")
    }

    /// The room that it takes, with the text's halo.
    pub fn kept(&self) -> Kept {
        let half_px = self.width_px(self.size) / 2.0 + 2.0;
        let high_px = self.size.height_px() / 2.0 + 2.0;
        let (x_px, y_px) = self.centre_px;
        [x_px - half_px, y_px - high_px, x_px + half_px, y_px + high_px]
    }

    /// Draws the symbol and the text; hovering shows the runs.
    pub fn drawn(&self) -> Element {
        let most = self.runs.iter().rev().max_by_key(|run| run.n).expect("a place has runs");
        let MarkSize { radius_px, text_px } = self.size;
        let (x_px, y_px) = self.centre_px;
        let (left_px, right_px) = {
            let half_px = self.width_px(self.size) / 2.0;
            (x_px - half_px, x_px + half_px)
        };
        let symbol =
            radius_px.map(|radius_px| most.symbol((left_px + 1.25 * radius_px, y_px), radius_px));
        let text = text_px.map(|size_px| {
            let at_px = right_px - width_px(&self.text(), size_px, Weight::Bold);
            haloed((at_px, y_px + 0.36 * size_px), &self.text()).at("font-size", size_px)
        });
        let hover = Element::new("title").text(&self.in_words());
        Element::new("g").child(hover).children(symbol).children(text)
    }

    /// A line for each phase, with the names of its runs: `21 stable milling: run_1, run_2`.
    fn in_words(&self) -> String {
        let line = |run: &&ExperimentMark| {
            let names = if run.names.is_empty() {
                String::new()
            } else {
                format!(": {}", run.names.join(", "))
            };
            format!("{} {}{names}", run.n, run.label())
        };
        self.runs.iter().map(line).collect::<Vec<_>>().join("\n")
    }
}

fn haloed((x_px, y_px): Point, text: &str) -> Element {
    line_of_text(x_px, y_px, text)
        .fixed()
        .with("font-weight", "bold")
        .with("fill", INK)
        .stroked("#ffffff", 3.0)
        .with("stroke-linejoin", "round")
        .with("paint-order", "stroke")
}
