//! Lines that theory predicts over the heat map: each with ticks towards the side on which its condition
//! holds, a letter at its end, and gaps where numbers stand.

use crate::palette::INK;
use crate::plot::{Kept, Plot};
use crate::svg::{Element, centred_text, through};
use crate::track::Point;

/// Radius of the circle around a letter, in pixels.
pub const TAG_PX: f64 = 8.0;
/// From the edge of a plot to the middle of a letter beside it, and as far again to its end, in pixels.
pub const OUTSIDE_PX: f64 = TAG_PX + 1.0;
/// Lines are followed in steps of this length, in pixels.
const STEP_PX: f64 = 0.5;
/// Pieces into which a segment is cut where it is bent on the page.
const BETWEEN: u32 = 50;
/// From one tick to the next along the line, in pixels.
const TICKS_PX: f64 = 24.0;
/// Length of a tick, in pixels.
const TICK_PX: f64 = 6.0;

/// A line in the plane of the picture that theory predicts.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    /// What begins or ceases to hold on it; any text.
    pub label: String,
    /// Its points `(x, y)`, in the units of the picture's axes; finite; without a y-axis, `y` from
    /// -0.5 to 0.5 spans the picture.
    pub points: Vec<(f64, f64)>,
    /// On which side it holds.
    pub holds: Side,
}

/// A side of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// At lower values on the x-axis.
    Left,
    /// At higher values on the x-axis.
    Right,
    /// At lower values on the y-axis.
    Below,
    /// At higher values on the y-axis.
    Above,
}

impl Side {
    /// The direction towards it on the page, of length 1.
    fn direction(self) -> Point {
        match self {
            Self::Left => (-1.0, 0.0),
            Self::Right => (1.0, 0.0),
            Self::Below => (0.0, 1.0),
            Self::Above => (0.0, -1.0),
        }
    }

    /// Where the condition of a line holds: `holds left of the line`.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Left => "holds left of the line",
            Self::Right => "holds right of the line",
            Self::Below => "holds below the line",
            Self::Above => "holds above the line",
        }
    }
}

/// Draws the boundaries, each clipped to the cells and tagged with a letter, and finds for each
/// whether any of it is visible.
///
/// Letters and dashes follow from the number beside each boundary. Lines leave out the numbers that are
/// kept in the cells.
pub fn boundaries(
    plot: &Plot,
    boundaries: &[(usize, &Boundary)],
    kept: &[Kept],
) -> (Vec<Element>, Vec<bool>) {
    let mut lines = Vec::new();
    let mut tags = Vec::new();
    let mut taken: Vec<Point> = Vec::new();
    let mut is_visible = Vec::new();
    for (index, boundary) in boundaries.iter().copied() {
        let whole = clipped(plot, boundary);
        is_visible.push(!whole.is_empty());
        if whole.is_empty() {
            continue;
        }
        let place = place_of_tag(plot, &whole, (&taken, kept));
        let pieces: Vec<Vec<Point>> =
            whole.iter().flat_map(|piece| with_gaps(&followed(piece), kept)).collect();
        lines.push(dashed(&pieces, &ticks(&whole, boundary.holds, kept), index));
        taken.push(place);
        tags.push(tag(place, index));
    }
    lines.extend(tags);
    (lines, is_visible)
}

/// A line in small steps.
fn followed(piece: &[Point]) -> Vec<Point> {
    let mut points = vec![piece[0]];
    for pair in piece.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let n_steps = (libm::hypot(dx, dy) / STEP_PX).ceil().max(1.0);
        let mut step = 1.0;
        while step <= n_steps {
            points.push((from.0 + dx * step / n_steps, from.1 + dy * step / n_steps));
            step += 1.0;
        }
    }
    points
}

/// The parts of a line outside the boxes; what is left between two of them must be longer than a dot.
fn with_gaps(points: &[Point], kept: &[Kept]) -> Vec<Vec<Point>> {
    let is_free = |point: &Point| kept.iter().all(|kept| !contains(kept, *point));
    let parts = points.chunk_by(|one, other| is_free(one) == is_free(other));
    parts.filter(|part| part.len() > 3 && is_free(&part[0])).map(simple).collect()
}

fn contains([left, top, right, bottom]: &Kept, (x, y): Point) -> bool {
    (*left..=*right).contains(&x) && (*top..=*bottom).contains(&y)
}

/// The same line by fewer points.
fn simple(points: &[Point]) -> Vec<Point> {
    crate::track::simplified(points, 0.05)
}

/// Short strokes across a line towards the side on which its condition holds.
fn ticks(whole: &[Vec<Point>], holds: Side, kept: &[Kept]) -> Vec<Vec<Point>> {
    let towards = holds.direction();
    let each = (TICKS_PX / STEP_PX).round();
    let mut ticks = Vec::new();
    for piece in whole {
        let points = followed(piece);
        let mut at = each / 2.0;
        while let Some(tick) = tick(&points, at as usize, towards) {
            let is_free = |share: f64| {
                let (dx, dy) = (tick[1].0 - tick[0].0, tick[1].1 - tick[0].1);
                let point = (tick[0].0 + share * dx, tick[0].1 + share * dy);
                kept.iter().all(|kept| !contains(kept, point))
            };
            if [0.0, 0.25, 0.5, 0.75, 1.0].into_iter().all(is_free) {
                ticks.push(tick.to_vec());
            }
            at += each;
        }
    }
    ticks
}

/// A stroke at one point of a line; `None` beyond its end.
fn tick(points: &[Point], at: usize, towards: Point) -> Option<[Point; 2]> {
    let (before, here, after) =
        (points.get(at.checked_sub(1)?)?, points.get(at)?, points.get(at + 1)?);
    let (dx, dy) = (after.0 - before.0, after.1 - before.1);
    let length = libm::hypot(dx, dy);
    let across = (-dy / length, dx / length);
    let sign = if across.0 * towards.0 + across.1 * towards.1 < 0.0 { -1.0 } else { 1.0 };
    let end = (here.0 + sign * TICK_PX * across.0, here.1 + sign * TICK_PX * across.1);
    Some([*here, end])
}

/// The parts of a boundary inside the plot, in pixels.
fn clipped(plot: &Plot, boundary: &Boundary) -> Vec<Vec<Point>> {
    let to_px = |(x, y): Point| (plot.x.position_px(x), plot.y.position_px(y));
    let mut pieces: Vec<Vec<Point>> = Vec::new();
    // What is straight in values is none on a logarithmic axis.
    let points: Vec<Point> = if plot.x.is_linear() && plot.y.is_linear() {
        boundary.points.clone()
    } else {
        finer(&boundary.points)
    };
    for pair in points.windows(2) {
        let Some((from, to)) = clip(plot, to_px(pair[0]), to_px(pair[1])) else { continue };
        match pieces.last_mut() {
            Some(piece) if piece.last() == Some(&from) => piece.push(to),
            _ => pieces.push(vec![from, to]),
        }
    }
    pieces
}

/// The same points with others between them.
fn finer(points: &[Point]) -> Vec<Point> {
    let between = |pair: &[Point]| {
        let (from, to) = (pair[0], pair[1]);
        let at = move |step: u32| {
            let share = f64::from(step) / f64::from(BETWEEN);
            (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1))
        };
        (0..BETWEEN).map(at).collect::<Vec<Point>>()
    };
    points.windows(2).flat_map(between).chain(points.last().copied()).collect()
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

/// Lines of an SVG path, one for each piece; in pixels.
pub(crate) fn path_of(pieces: &[Vec<Point>]) -> String {
    pieces.iter().map(|piece| through(piece.iter().copied())).collect()
}

fn dashed(pieces: &[Vec<Point>], ticks: &[Vec<Point>], index: usize) -> Element {
    let line = |pieces: &[Vec<Point>], stroke: &str, width_px: f64| {
        Element::path(&path_of(pieces)).outlined(stroke, width_px).with("stroke-linejoin", "round")
    };
    Element::new("g")
        .fixed()
        .with("pointer-events", "none")
        .child(line(pieces, "#ffffff", 4.0).with("stroke-opacity", "0.85"))
        .child(line(ticks, INK, 1.2))
        .child(line(pieces, INK, 1.8).with("stroke-dasharray", dashes(index)))
}

/// The dashes of one boundary, here and in the legend.
pub fn dashes(index: usize) -> &'static str {
    ["7 4", "2 3", "9 3 2 3", "14 4", "9 3 2 3 2 3"][index % 5]
}

/// Where a boundary's letter goes: beside the plot where the line leaves it at the right or at the top,
/// else at another end, else along it; never onto another letter or a number.
fn place_of_tag(plot: &Plot, pieces: &[Vec<Point>], (taken, kept): (&[Point], &[Kept])) -> Point {
    let ends: Vec<Point> =
        pieces.iter().flat_map(|piece| [piece[piece.len() - 1], piece[0]]).collect();
    let at_top = |place: &&Point| (place.1 - plot.top_px).abs() < 0.01;
    let at_right = |place: &&Point| (place.0 - plot.right_px).abs() < 0.01;
    let right = ends.iter().filter(at_right).map(|place| (place.0 + OUTSIDE_PX, place.1));
    let top = ends.iter().filter(at_top).map(|place| (place.0, place.1 - OUTSIDE_PX));
    let along = pieces.iter().flat_map(|piece| followed(piece)).rev();
    let candidates: Vec<Point> =
        right.chain(top).chain(ends.iter().copied()).chain(along).collect();
    let is_free = |place: &Point| {
        let is_apart =
            |other: &Point| libm::hypot(place.0 - other.0, place.1 - other.1) > 2.0 * TAG_PX + 2.0;
        let is_off = |[left, top, right, bottom]: &Kept| {
            let nearest = (place.0.clamp(*left, *right), place.1.clamp(*top, *bottom));
            libm::hypot(place.0 - nearest.0, place.1 - nearest.1) > TAG_PX + 1.0
        };
        taken.iter().all(is_apart) && kept.iter().all(is_off)
    };
    candidates.iter().copied().find(is_free).unwrap_or(candidates[0])
}

/// The letter of one boundary in a circle, here and in the legend.
pub fn tag((x_px, y_px): Point, index: usize) -> Element {
    let letter = char::from(b'a' + u8::try_from(index % 26).expect("below 26"));
    let circle = Element::circle((x_px, y_px), TAG_PX).with("fill", "#ffffff").stroked(INK, 1.2);
    let text = centred_text(x_px, y_px + 3.5, &letter.to_string()).bold(10.5, INK);
    Element::new("g").fixed().with("pointer-events", "none").child(circle).child(text)
}
