//! What lies over the heat map: analytic boundaries, the chosen cell, real experiments.

use rsrs_core::diagram::axis::Cell;
use rsrs_core::judge::phase::Phase;

use crate::palette::INK;
use crate::plot::Plot;
use crate::slice::is_same;
use crate::svg::{Element, line_of_text, number, rectangle};
use crate::symbol::mark;
use crate::text::{Weight, width_px};

/// Radius of a real run's symbol, in pixels.
pub const MARK_PX: f64 = 5.5;
const COUNT_PX: f64 = 10.0;
const TAG_PX: f64 = 8.0;

type Point = (f64, f64);

/// A line in the plane of the picture that theory predicts.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    /// What happens on it; any text.
    pub label: String,
    /// Its points `(x, y)`, in the units of the picture's axes; finite; without a y-axis, `y` from
    /// -0.5 to 0.5 spans the picture.
    pub points: Vec<(f64, f64)>,
}

/// How often real runs at one cell ended in one phase.
#[derive(Clone, Debug, PartialEq)]
pub struct ExperimentMark {
    /// Where they ran; swept or not.
    pub cell: Cell,
    /// What the judge said.
    pub phase: Phase,
    /// Number of runs.
    pub n: u64,
}

/// The column and row of a cell of the grid, if the picture shows it.
pub fn grid_cell(plot: &Plot, cell: &Cell) -> Option<(usize, usize)> {
    let (x, y) = plot.slice.place(cell)?;
    let index = |values: &[f64], value| values.iter().position(|other| is_same(*other, value));
    Some((index(&plot.x.values, x)?, index(&plot.y.values, y)?))
}

/// Where a cell lies, in pixels, on the grid or between its points.
///
/// # Returns
///
/// `None` if it lies in another slice or outside the axes.
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

/// Draws a frame around the chosen cell, or a ring where it is too small or between the swept ones.
///
/// # Returns
///
/// What was drawn, for the legend, and the drawing; `None` if the picture does not show the cell.
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
    double_stroke(|| Element::new("circle").at("cx", x_px).at("cy", y_px).at("r", 8.0))
}

/// A dark outline with a white one around it, visible on every colour.
pub fn double_stroke(shape: impl Fn() -> Element) -> Element {
    let outline = |stroke: &str, width_px: f64| {
        shape().with("fill", "none").with("stroke", stroke).at("stroke-width", width_px)
    };
    Element::new("g")
        .with("pointer-events", "none")
        .child(outline("#ffffff", 6.0))
        .child(outline(INK, 3.0))
}

/// Draws the real runs of every cell side by side, with their number where it is above one.
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
    (places.iter().flat_map(|(place, runs)| side_by_side(*place, runs)).collect(), n_elsewhere)
}

fn side_by_side((centre_px, y_px): Point, runs: &[&ExperimentMark]) -> Vec<Element> {
    let gap_px = 8.0;
    let count = |run: &ExperimentMark| if run.n > 1 { run.n.to_string() } else { String::new() };
    let room_px = |run: &ExperimentMark| {
        let count_px = width_px(&count(run), COUNT_PX, Weight::Bold);
        2.0 * MARK_PX + if run.n > 1 { count_px + 3.0 } else { 0.0 }
    };
    let total_px: f64 = runs.iter().map(|run| room_px(run) + gap_px).sum::<f64>() - gap_px;

    let mut x_px = centre_px - total_px / 2.0;
    let mut elements = Vec::new();
    for run in runs {
        elements.push(mark(run.phase, (x_px + MARK_PX, y_px), MARK_PX));
        if run.n > 1 {
            let count_x_px = x_px + 2.0 * MARK_PX + 3.0;
            elements.push(haloed(count_x_px, y_px + 0.36 * COUNT_PX, &count(run)));
        }
        x_px += room_px(run) + gap_px;
    }
    elements
}

fn haloed(x_px: f64, y_px: f64, text: &str) -> Element {
    line_of_text(x_px, y_px, text)
        .at("font-size", COUNT_PX)
        .with("font-weight", "bold")
        .with("fill", INK)
        .with("stroke", "#ffffff")
        .at("stroke-width", 3.0)
        .with("stroke-linejoin", "round")
        .with("paint-order", "stroke")
}

/// Draws the analytic boundaries, each clipped to the cells and tagged with a letter.
///
/// # Returns
///
/// The lines, and for each boundary whether any of it is visible.
pub fn boundaries(plot: &Plot, boundaries: &[Boundary]) -> (Vec<Element>, Vec<bool>) {
    let mut lines = Vec::new();
    let mut tags = Vec::new();
    let mut taken: Vec<Point> = Vec::new();
    let mut is_visible = Vec::new();
    for (index, boundary) in boundaries.iter().enumerate() {
        let pieces = clipped(plot, boundary);
        is_visible.push(!pieces.is_empty());
        if pieces.is_empty() {
            continue;
        }
        lines.push(dashed(&pieces, index));
        let place = place_of_tag(plot, &pieces, &taken);
        taken.push(place);
        tags.push(tag(place, index));
    }
    lines.extend(tags);
    (lines, is_visible)
}

/// The parts of a boundary inside the plot, in pixels.
fn clipped(plot: &Plot, boundary: &Boundary) -> Vec<Vec<Point>> {
    let to_px = |(x, y): Point| (plot.x.position_px(x), plot.y.position_px(y));
    let mut pieces: Vec<Vec<Point>> = Vec::new();
    for pair in boundary.points.windows(2) {
        let Some((from, to)) = clip(plot, to_px(pair[0]), to_px(pair[1])) else { continue };
        match pieces.last_mut() {
            Some(piece) if piece.last() == Some(&from) => piece.push(to),
            _ => pieces.push(vec![from, to]),
        }
    }
    pieces
}

/// The part of a segment inside the plot.
///
/// # Source
///
/// Y.-D. Liang and B. A. Barsky, "A new concept and method for line clipping", 1984.
fn clip(plot: &Plot, from: Point, to: Point) -> Option<(Point, Point)> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for (towards, room) in [
        (-dx, from.0 - plot.left_px),
        (dx, plot.right_px - from.0),
        (-dy, from.1 - plot.top_px),
        (dy, plot.bottom_px - from.1),
    ] {
        if towards < 0.0 {
            enter = enter.max(room / towards);
        } else if towards > 0.0 {
            leave = leave.min(room / towards);
        } else if room < 0.0 {
            return None;
        }
    }
    let at = |share: f64| {
        // The ends themselves, to the bit, so that neighbouring segments join.
        if share <= 0.0 {
            from
        } else if share >= 1.0 {
            to
        } else {
            (from.0 + share * dx, from.1 + share * dy)
        }
    };
    (enter < leave).then(|| (at(enter), at(leave)))
}

fn path_of(pieces: &[Vec<Point>]) -> String {
    let piece_path = |piece: &Vec<Point>| {
        let points: Vec<String> =
            piece.iter().map(|(x, y)| format!("{} {}", number(*x), number(*y))).collect();
        format!("M{}", points.join("L"))
    };
    pieces.iter().map(piece_path).collect()
}

fn dashed(pieces: &[Vec<Point>], index: usize) -> Element {
    let path = path_of(pieces);
    let line = |stroke: &str, width_px: f64| {
        Element::new("path")
            .with("d", &path)
            .with("fill", "none")
            .with("stroke", stroke)
            .at("stroke-width", width_px)
            .with("stroke-linejoin", "round")
    };
    Element::new("g")
        .with("pointer-events", "none")
        .child(line("#ffffff", 4.0).with("stroke-opacity", "0.85"))
        .child(line(INK, 1.8).with("stroke-dasharray", dashes(index)))
}

/// The dashes of one boundary, here and in the legend.
pub fn dashes(index: usize) -> &'static str {
    ["7 4", "2 3", "9 3 2 3", "14 4", "9 3 2 3 2 3"][index % 5]
}

/// Where a boundary's letter goes: where the line leaves the plot at the top or the right, else at
/// another end, else along it; never onto another letter.
fn place_of_tag(plot: &Plot, pieces: &[Vec<Point>], taken: &[Point]) -> Point {
    let ends: Vec<Point> =
        pieces.iter().flat_map(|piece| [piece[piece.len() - 1], piece[0]]).collect();
    let at_top = |place: &Point| (place.1 - plot.top_px).abs() < 0.01;
    let at_right = |place: &Point| (place.0 - plot.right_px).abs() < 0.01;
    let along = pieces.iter().flatten().rev().copied();
    let candidates: Vec<Point> = ends
        .iter()
        .copied()
        .filter(at_top)
        .chain(ends.iter().copied().filter(at_right))
        .chain(ends.iter().copied())
        .chain(along)
        .collect();
    let is_free = |place: &Point| {
        taken
            .iter()
            .all(|other| libm::hypot(place.0 - other.0, place.1 - other.1) > 2.0 * TAG_PX + 2.0)
    };
    candidates.iter().copied().find(is_free).unwrap_or(candidates[0])
}

/// The letter of one boundary in a circle, here and in the legend.
pub fn tag((x_px, y_px): Point, index: usize) -> Element {
    let letter = char::from(b'a' + u8::try_from(index % 26).expect("below 26"));
    let circle = Element::new("circle")
        .at("cx", x_px)
        .at("cy", y_px)
        .at("r", TAG_PX)
        .with("fill", "#ffffff")
        .with("stroke", INK)
        .at("stroke-width", 1.2);
    let text = line_of_text(x_px, y_px + 3.5, &letter.to_string())
        .with("text-anchor", "middle")
        .at("font-size", 10.5)
        .with("font-weight", "bold")
        .with("fill", INK);
    Element::new("g").with("pointer-events", "none").child(circle).child(text)
}
