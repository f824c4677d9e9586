//! Real runs on the heat map: each by the symbol of its phase.

use rsrs_core::judge::phase::Phase;
use rsrs_core::quantity::Cell;

use crate::overlay::{grid_cell, position_px};
use crate::palette::INK;
use crate::plot::Plot;
use crate::svg::{Element, line_of_text};
use crate::symbol::{Filling, MARK_PX, mark};
use crate::text::{Weight, width_px};
use crate::track::Point;

const COUNT_PX: f64 = 10.0;
/// Sizes that symbols may have where each run has its own, in pixels, the best first.
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

/// Draws the real runs of every cell: each with its name if all have one and there is room, else those
/// of a phase together with their number.
///
/// # Returns
///
/// The symbols, and how many runs lie in cells that the picture does not show.
pub fn experiments(plot: &Plot, marks: &[ExperimentMark]) -> (Vec<Element>, u64) {
    let mut places: Vec<(Point, Vec<&ExperimentMark>)> = Vec::new();
    let mut n_elsewhere = 0;
    for run in marks.iter().filter(|run| run.n > 0) {
        let Some(place) = position_px(plot, &run.cell) else {
            n_elsewhere += run.n;
            continue;
        };
        let is_here = |(x, y): Point| (x - place.0).abs() < 0.5 && (y - place.1).abs() < 0.5;
        match places.iter_mut().find(|(other, _)| is_here(*other)) {
            Some((_, runs)) => runs.push(run),
            None => places.push((place, vec![run])),
        }
    }
    let drawn = |(place, runs): &(Point, Vec<&ExperimentMark>)| {
        one_by_one(plot, *place, runs)
            .or_else(|| stacked(plot, *place, runs))
            .unwrap_or_else(|| side_by_side(*place, runs))
    };
    (places.iter().flat_map(drawn).collect(), n_elsewhere)
}

/// A symbol for each run, in rows within the cell; `None` if they have no names or no room.
fn one_by_one(plot: &Plot, place: Point, runs: &[&ExperimentMark]) -> Option<Vec<Element>> {
    let has_names = |run: &&ExperimentMark| run.names.len() as u64 == run.n;
    if !runs.iter().all(has_names) {
        return None;
    }
    let (column, row) = grid_cell(plot, &runs.first()?.cell)?;
    let (_, _, width_px, height_px) = plot.cell_px(column, row);
    let named: Vec<(&ExperimentMark, &String)> =
        runs.iter().flat_map(|run| run.names.iter().map(|name| (*run, name))).collect();
    let (radius_px, n_columns) = SIZES_PX.into_iter().find_map(|radius_px| {
        let fitting = |room_px: f64| {
            (1..=named.len())
                .take_while(|n| *n as f64 * pitch_px(radius_px) <= room_px - 2.0)
                .count()
        };
        let (columns, rows) = (fitting(width_px), fitting(height_px));
        (columns * rows >= named.len()).then_some((radius_px, columns))
    })?;
    let n_rows = named.len().div_ceil(n_columns);
    let n_columns = named.len().div_ceil(n_rows);
    let pitch_px = pitch_px(radius_px);
    let symbol = |(index, (run, name)): (usize, &(&ExperimentMark, &String))| {
        let row = index / n_columns;
        let n_in_row = (named.len() - row * n_columns).min(n_columns);
        let middle = |n: usize| (n as f64 - 1.0) / 2.0;
        let x_px = place.0 + pitch_px * ((index % n_columns) as f64 - middle(n_in_row));
        let y_px = place.1 + pitch_px * (row as f64 - middle(n_rows));
        run.symbol((x_px, y_px), radius_px).child(title(&format!("{name}: {}", run.label())))
    };
    Some(named.iter().enumerate().map(symbol).collect())
}

/// One phase below the other, each with its number, where they would leave a narrow cell side by side;
/// `None` if they would not, or have no room below one another either.
fn stacked(plot: &Plot, place: Point, runs: &[&ExperimentMark]) -> Option<Vec<Element>> {
    let (column, row) = grid_cell(plot, &runs.first()?.cell)?;
    let (_, _, width_px, height_px) = plot.cell_px(column, row);
    if side_by_side_px(runs) <= width_px {
        return None;
    }
    let n_rows = runs.len() as f64;
    let count_px = |radius_px: f64| (2.2 * radius_px).min(COUNT_PX);
    let row_px = |run: &ExperimentMark, radius_px: f64| {
        let count_px = width_px_of(run, count_px(radius_px));
        2.5 * radius_px + if run.n > 1 { count_px + 1.5 } else { 0.0 }
    };
    let widest_px =
        |radius_px: f64| runs.iter().map(|run| row_px(run, radius_px)).fold(0.0, f64::max);
    let radius_px = SIZES_PX.into_iter().find(|radius_px| {
        widest_px(*radius_px) <= width_px && n_rows * pitch_px(*radius_px) <= height_px
    })?;
    let mut elements = Vec::new();
    for (index, run) in runs.iter().enumerate() {
        let y_px = place.1 + pitch_px(radius_px) * (index as f64 - (n_rows - 1.0) / 2.0);
        let left_px = place.0 - row_px(run, radius_px) / 2.0;
        elements.push(named(run, (left_px + 1.25 * radius_px, y_px), radius_px));
        if run.n > 1 {
            let size_px = count_px(radius_px);
            let at_px = (left_px + 2.5 * radius_px + 1.5, y_px + 0.36 * size_px);
            elements.push(haloed(at_px, &count(run)).at("font-size", size_px));
        }
    }
    Some(elements)
}

/// A symbol with the names of its runs.
fn named(run: &ExperimentMark, at_px: Point, radius_px: f64) -> Element {
    let names = (!run.names.is_empty()).then(|| title(&run.names.join(", ")));
    run.symbol(at_px, radius_px).children(names)
}

fn count(run: &ExperimentMark) -> String {
    if run.n > 1 { run.n.to_string() } else { String::new() }
}

fn width_px_of(run: &ExperimentMark, size_px: f64) -> f64 {
    width_px(&count(run), size_px, Weight::Bold)
}

/// Between phases that lie side by side, in pixels.
const GAP_PX: f64 = 8.0;

/// The room of one phase beside others.
fn room_px(run: &ExperimentMark) -> f64 {
    2.0 * MARK_PX + if run.n > 1 { width_px_of(run, COUNT_PX) + 3.0 } else { 0.0 }
}

fn side_by_side_px(runs: &[&ExperimentMark]) -> f64 {
    runs.iter().map(|run| room_px(run) + GAP_PX).sum::<f64>() - GAP_PX
}

/// From one symbol to the next: the widest ones reach a quarter beyond their radius.
fn pitch_px(radius_px: f64) -> f64 {
    2.5 * radius_px + 2.0
}

fn title(text: &str) -> Element {
    Element::new("title").text(text)
}

fn side_by_side((centre_px, y_px): Point, runs: &[&ExperimentMark]) -> Vec<Element> {
    let mut x_px = centre_px - side_by_side_px(runs) / 2.0;
    let mut elements = Vec::new();
    for run in runs {
        elements.push(named(run, (x_px + MARK_PX, y_px), MARK_PX));
        if run.n > 1 {
            let at_px = (x_px + 2.0 * MARK_PX + 3.0, y_px + 0.36 * COUNT_PX);
            elements.push(haloed(at_px, &count(run)).at("font-size", COUNT_PX));
        }
        x_px += room_px(run) + GAP_PX;
    }
    elements
}

fn haloed((x_px, y_px): Point, text: &str) -> Element {
    line_of_text(x_px, y_px, text)
        .fixed()
        .with("font-weight", "bold")
        .with("fill", INK)
        .with("stroke", "#ffffff")
        .at("stroke-width", 3.0)
        .with("stroke-linejoin", "round")
        .with("paint-order", "stroke")
}
