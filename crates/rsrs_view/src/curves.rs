//! Shares along one quantity with their 95 % bands: one curve, or a page of them.

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::quantity::Axis;
use rsrs_core::statistics::share::Share;

use crate::arrangement::NARROW_MARGIN_PX;
use crate::boundary::{Side, dashes};
use crate::chart::{BELOW_PX, Chart, LEFT_PX, NAME_PX, legend, stroke_mark};
use crate::header::{HEADING_PX, Heading, MARGIN_PX, header};
use crate::palette::{BLUE, GREEN, INK, QUIET_INK, VERMILION};
use crate::scale::{ends, label, labels};
use crate::svg::{Element, number, rectangle, through};
use crate::text::{Weight, width_px};
use crate::theme::Theme;

/// The narrowest curve beside another one on a page whose width is given, in pixels.
const LEAST_PX: f64 = 100.0;
/// Left of a curve that has another one beside it: the numbers of its y-axis, without the name.
const INNER_LEFT_PX: f64 = 34.0;
/// Width and height of a curve that is alone.
const LARGE_PX: (f64, f64) = (560.0, 320.0);
/// Width and height of one of several.
const SMALL_PX: (f64, f64) = (236.0, 150.0);
/// Curves side by side.
const COLUMNS: usize = 3;
/// Between curves, besides their axes.
const BETWEEN_PX: f64 = 14.0;
/// A curve of at most so many values shows each as a dot.
const MOST_DOTS: usize = 40;

/// Curves, and the text about them.
#[derive(Clone, Debug)]
pub struct CurvesPicture {
    /// The title; any text.
    pub title: String,
    /// Under the title; any texts.
    pub subtitles: Vec<String>,
    /// What else it takes to repeat the picture, in the file and not on it; any text.
    pub details: String,
    /// Where it is looked at.
    pub theme: Theme,
    /// The curves, side by side if there are several.
    pub curves: Vec<Curve>,
    /// What marked values are.
    pub marked: &'static str,
    /// A share to be drawn across all of them, with what it is; any text.
    pub wanted: Option<(f64, String)>,
    /// Width of the page, in pixels of 1/96 inch; as wide as it takes if not given.
    pub width_px: Option<f64>,
}

/// How a share depends on one quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Above the curve; any text, which may be empty.
    pub heading: String,
    /// The quantity.
    pub axis: Axis,
    /// What the runs were judged for.
    pub behaviour: Behaviour,
    /// Values, ascending, and the runs with each that ended in the wanted phase.
    pub points: Vec<(f64, Share)>,
    /// Values between which the background is shaded.
    pub range: Option<[f64; 2]>,
    /// A value to be marked.
    pub marked: Option<f64>,
    /// Lines of theory.
    pub boundaries: Vec<UprightBoundary>,
    /// The same of other robots, in words, and their values and runs, ascending.
    pub compared: Option<(String, Vec<(f64, Share)>)>,
    /// Real runs.
    pub real: Vec<(f64, Share)>,
}

/// A value at which a condition of theory begins or ceases to hold.
#[derive(Clone, Debug, PartialEq)]
pub struct UprightBoundary {
    /// The value.
    pub value: f64,
    /// What the line is called; any text.
    pub label: String,
    /// On which side the condition holds: left or right.
    pub holds: Side,
}

/// Why there is no picture of curves.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CurvesPictureError {
    /// There is nothing to draw.
    #[error("no curves, expected 1 or more")]
    Empty,
    /// A curve has no point.
    #[error("the curve over {0} has no points")]
    NoPoints(Axis),
    /// A value is no number.
    #[error("the curve over {axis} has the value {value}, expected finite numbers")]
    NotFinite {
        /// Its quantity.
        axis: Axis,
        /// The value.
        value: f64,
    },
}

/// Draws shares as lines with their exact 95 % intervals as bands; hovering a point shows its
/// counts.
///
/// The SVG document is self-contained, and the same text for the same picture on every machine.
pub fn svg(picture: &CurvesPicture) -> Result<String, CurvesPictureError> {
    Ok(drawn(picture)?.svg)
}

/// Curves as SVG, and where they lie.
pub(crate) struct DrawnCurves {
    pub svg: String,
    /// Width and height, in pixels.
    pub size_px: (f64, f64),
    /// The frame of each curve, in their order.
    pub charts: Vec<Chart>,
}

pub(crate) fn drawn(picture: &CurvesPicture) -> Result<DrawnCurves, CurvesPictureError> {
    check(picture)?;
    let Page { margin_px, columns, curve_px: (width_px, height_px), width_px: page_px } =
        Page::new(picture);
    let pitch_px = INNER_LEFT_PX + width_px + BETWEEN_PX;
    let room_px = page_px - 2.0 * margin_px;
    let (texts, header_px) =
        header(picture.theme, &picture.title, &picture.subtitles, margin_px, room_px);
    let (mut panels, mut charts) = (Vec::new(), Vec::new());
    let mut top_px = header_px + 10.0;
    for row in picture.curves.chunks(columns) {
        let heights_px = row.iter().map(|curve| Heading::new(&curve.heading, width_px).height_px());
        let above_px = heights_px.fold(HEADING_PX, f64::max) + 10.0;
        for (column, curve) in row.iter().enumerate() {
            let left_px = margin_px + LEFT_PX + column as f64 * pitch_px;
            let chart = chart(curve, (left_px, top_px + above_px), (width_px, height_px));
            let y_name = if column == 0 { y_name(curve, height_px) } else { String::new() };
            let wanted = picture.wanted.as_ref().map(|(share, _)| *share);
            panels.push(panel(curve, &chart, wanted).child(chart.y_axis(&y_name)));
            charts.push(chart);
        }
        top_px += above_px + height_px + BELOW_PX + BETWEEN_PX;
    }
    let place = (margin_px + LEFT_PX, top_px - BETWEEN_PX);
    let (legend, bottom_px) = legend(&entries(picture), place, room_px - LEFT_PX);
    let size_px = (page_px, bottom_px + 12.0);
    let page = Element::picture(size_px.0, size_px.1, &picture.title)
        .described(
            &picture
                .theme
                .description(picture.subtitles.iter().map(String::as_str), &picture.details),
        )
        .children(texts)
        .children(panels)
        .children(legend);
    Ok(DrawnCurves { svg: format!("{page}\n"), size_px, charts })
}

/// Where a curve is drawn, from its upper left corner on, in pixels.
fn chart(curve: &Curve, (left_px, top_px): (f64, f64), (width_px, height_px): (f64, f64)) -> Chart {
    Chart { left_px, top_px, width_px, height_px, x: span(curve), y: [0.0, 1.0] }
}

/// How curves share a page, in pixels.
struct Page {
    margin_px: f64,
    /// Curves side by side.
    columns: usize,
    /// Width and height of each.
    curve_px: (f64, f64),
    width_px: f64,
}

impl Page {
    fn new(picture: &CurvesPicture) -> Self {
        let n = picture.curves.len();
        let curve_px = if n == 1 { LARGE_PX } else { SMALL_PX };
        let axes_px =
            |columns: usize| LEFT_PX + (columns - 1) as f64 * (BETWEEN_PX + INNER_LEFT_PX);
        let free =
            |columns: usize| 2.0 * MARGIN_PX + axes_px(columns) + columns as f64 * curve_px.0;
        let Some(page_px) = picture.width_px else {
            let columns = n.min(COLUMNS);
            return Self { margin_px: MARGIN_PX, columns, curve_px, width_px: free(columns) };
        };
        let room_px = page_px - 2.0 * NARROW_MARGIN_PX;
        let each_px = |columns: usize| (room_px - axes_px(columns)) / columns as f64;
        let fits = |columns: &usize| each_px(*columns) >= LEAST_PX;
        let columns = (1..=n.min(COLUMNS)).rev().find(fits).unwrap_or(1);
        // As the numbers below are those of the narrower curves, the last may leave its room by a hair.
        let overhang_px = |curve| chart(curve, (0.0, 0.0), (each_px(columns), 0.0)).overhang_px();
        let overhangs_px = picture.curves.iter().map(overhang_px);
        let width_px = each_px(columns) - overhangs_px.fold(0.0, f64::max) / columns as f64;
        let curve_px = (width_px, width_px * curve_px.1 / curve_px.0);
        Self { margin_px: NARROW_MARGIN_PX, columns, curve_px, width_px: page_px }
    }
}

/// The quantity below its curve; where there is room for less, its unit alone, below a heading that names it.
fn x_name(curve: &Curve, room_px: f64) -> String {
    let name = curve.axis.label();
    let is_short = width_px(&name, NAME_PX, Weight::Regular) < room_px + INNER_LEFT_PX;
    if is_short || curve.heading.is_empty() { name } else { curve.axis.unit().to_owned() }
}

/// What a share is of; where there is room for less, the legend has it.
fn y_name(curve: &Curve, room_px: f64) -> String {
    let name = format!("share of {}", curve.behaviour.noun());
    let is_short = width_px(&name, NAME_PX, Weight::Regular) < room_px + BELOW_PX;
    if is_short { name } else { "share".to_owned() }
}

fn check(picture: &CurvesPicture) -> Result<(), CurvesPictureError> {
    if picture.curves.is_empty() {
        return Err(CurvesPictureError::Empty);
    }
    for curve in &picture.curves {
        let axis = curve.axis;
        if curve.points.is_empty() {
            return Err(CurvesPictureError::NoPoints(axis));
        }
        let points = curve.points.iter().chain(&curve.real).map(|(value, _)| *value);
        let lines = curve.boundaries.iter().map(|line| line.value);
        let marks = curve.range.into_iter().flatten().chain(curve.marked);
        if let Some(value) = points.chain(lines).chain(marks).find(|value| !value.is_finite()) {
            return Err(CurvesPictureError::NotFinite { axis, value });
        }
    }
    Ok(())
}

/// The values of a curve from left to right, with a little room.
fn span(curve: &Curve) -> [f64; 2] {
    let [low, high] = ends(curve.points.iter().chain(&curve.real).map(|(value, _)| *value));
    let spare = match curve.axis {
        // A bar has its width.
        Axis::Robots => 0.5,
        _ if high > low => 0.02 * (high - low),
        _ => 0.5,
    };
    [low - spare, high + spare]
}

fn panel(curve: &Curve, chart: &Chart, wanted: Option<f64>) -> Element {
    let heading = Heading::new(&curve.heading, chart.width_px);
    let is_counted = curve.axis == Axis::Robots;
    Element::new("g")
        .children(curve.range.map(|range| shade(chart, range)))
        .children(curve.compared.iter().map(|(_, points)| compared(chart, points, curve.axis)))
        .children(if is_counted {
            bars(chart, &curve.points)
        } else {
            vec![band(chart, &curve.points)]
        })
        .children(wanted.map(|share| across(chart, share)))
        .children(boundaries(chart, &curve.boundaries))
        .children((!is_counted).then(|| line(chart, &curve.points, BLUE)))
        .children(dots(curve, chart))
        .children(curve.real.iter().map(|run| real(chart, curve.behaviour, run)))
        .children(curve.marked.map(|value| pointer(chart, value)))
        .child(chart.frame(&x_name(curve, chart.width_px)))
        .children(heading.drawn(chart.left_px, chart.top_px - 8.0))
}

fn shade(chart: &Chart, [low, high]: [f64; 2]) -> Element {
    let (left_px, right_px) = (chart.x_px(low), chart.x_px(high));
    rectangle(left_px, chart.top_px, right_px - left_px, chart.height_px).filled(BLUE, "0.09")
}

fn band(chart: &Chart, points: &[(f64, Share)]) -> Element {
    let lows = points.iter().map(|(value, share)| [*value, share.interval().low]);
    let highs = points.iter().rev().map(|(value, share)| [*value, share.interval().high]);
    let outline: Vec<[f64; 2]> = lows.chain(highs).collect();
    Element::path(&chart.polygon(&outline)).filled(BLUE, "0.22")
}

/// A bar for each value, with the interval of its share: there is nothing between 5 and 6 robots.
fn bars(chart: &Chart, points: &[(f64, Share)]) -> Vec<Element> {
    let gap = points.windows(2).map(|pair| pair[1].0 - pair[0].0).fold(1.0, f64::min);
    let half_px = (0.35 * gap * chart.width_px / (chart.x[1] - chart.x[0])).max(1.0);
    let bar = |(value, share): &(f64, Share)| {
        let (x_px, interval) = (chart.x_px(*value), share.interval());
        let top_px = chart.y_px(share.value());
        let body = rectangle(x_px - half_px, top_px, 2.0 * half_px, chart.bottom_px() - top_px)
            .filled(BLUE, "0.22");
        let (low, high) = (number(chart.y_px(interval.low)), number(chart.y_px(interval.high)));
        let whisker = stroke(&format!("M{} {high}V{low}", number(x_px)), BLUE, 1.6);
        Element::new("g").child(body).child(whisker)
    };
    points.iter().map(bar).collect()
}

fn line(chart: &Chart, points: &[(f64, Share)], colour: &str) -> Element {
    let place = |(value, share): &(f64, Share)| (chart.x_px(*value), chart.y_px(share.value()));
    stroke(&through(points.iter().map(place)), colour, 1.8)
}

/// The same of other robots: a line, or a short stroke for each number of robots.
fn compared(chart: &Chart, points: &[(f64, Share)], axis: Axis) -> Element {
    if axis != Axis::Robots {
        return line(chart, points, GREEN);
    }
    let dash = |(value, share): &(f64, Share)| {
        format!("M{} {}h18", number(chart.x_px(*value) - 9.0), number(chart.y_px(share.value())))
    };
    stroke(&points.iter().map(dash).collect::<String>(), GREEN, 2.2)
}

fn stroke(path: &str, colour: &str, width_px: f64) -> Element {
    Element::path(path).outlined(colour, width_px).with("stroke-linejoin", "round")
}

fn dots(curve: &Curve, chart: &Chart) -> Vec<Element> {
    if curve.points.len() > MOST_DOTS {
        return Vec::new();
    }
    let values: Vec<f64> = curve.points.iter().map(|(value, _)| *value).collect();
    let dot = |((value, share), text): (&(f64, Share), String)| {
        Element::circle((chart.x_px(*value), chart.y_px(share.value())), 2.4)
            .with("fill", BLUE)
            .titled(&tooltip(&text, curve.behaviour, *share))
    };
    curve.points.iter().zip(labels(&values)).map(dot).collect()
}

fn tooltip(value: &str, behaviour: Behaviour, share: Share) -> String {
    let interval = share.interval();
    format!(
        "{value}: {} of {} {}, {:.1} % (95 % interval {:.1} to {:.1} %)",
        share.hits,
        share.n,
        behaviour.verb().plain,
        100.0 * share.value(),
        100.0 * interval.low,
        100.0 * interval.high
    )
}

fn across(chart: &Chart, share: f64) -> Element {
    let (left, y) = (number(chart.left_px), number(chart.y_px(share)));
    let path = format!("M{left} {y}h{}", number(chart.width_px));
    stroke(&path, QUIET_INK, 1.0).with("stroke-dasharray", "2 3")
}

fn upright(chart: &Chart, value: f64) -> String {
    let (x, top) = (number(chart.x_px(value)), number(chart.top_px));
    format!("M{x} {top}v{}", number(chart.height_px))
}

fn boundaries(chart: &Chart, boundaries: &[UprightBoundary]) -> Vec<Element> {
    let line = |(index, line): (usize, &UprightBoundary)| {
        let dashed =
            stroke(&upright(chart, line.value), INK, 1.4).with("stroke-dasharray", dashes(index));
        Element::new("g").child(dashed).child(stroke(&ticks(chart, line), INK, 1.2))
    };
    boundaries.iter().enumerate().map(line).collect()
}

/// Short strokes towards the side on which a condition holds.
fn ticks(chart: &Chart, line: &UprightBoundary) -> String {
    let x = number(chart.x_px(line.value));
    let length = if line.holds == Side::Left { "-6" } else { "6" };
    let tick =
        |share: f64| format!("M{x} {}h{length}", number(chart.top_px + share * chart.height_px));
    [0.1, 0.3, 0.5, 0.7, 0.9].map(tick).concat()
}

/// A small triangle on the axis, and a thin line up from it.
fn pointer(chart: &Chart, value: f64) -> Element {
    let (x, bottom) = (number(chart.x_px(value)), number(chart.bottom_px()));
    let triangle = Element::path(&format!("M{x} {bottom}l-5 -9h10z")).with("fill", VERMILION);
    let line = stroke(&upright(chart, value), VERMILION, 1.2);
    Element::new("g").child(line).child(triangle)
}

/// Real runs: their share and its interval.
fn real(chart: &Chart, behaviour: Behaviour, (value, share): &(f64, Share)) -> Element {
    let interval = share.interval();
    let (x_px, y_px) = (chart.x_px(*value), chart.y_px(share.value()));
    let (top_px, bottom_px) = (chart.y_px(interval.high), chart.y_px(interval.low));
    let bar = format!("M{} {}V{}", number(x_px), number(top_px), number(bottom_px));
    let dot = Element::circle((x_px, y_px), 4.0).with("fill", "#ffffff").stroked(INK, 1.8);
    Element::new("g").child(stroke(&bar, INK, 1.6)).child(dot).titled(&tooltip(
        &format!("real, {}", label(*value)),
        behaviour,
        *share,
    ))
}

fn entries(picture: &CurvesPicture) -> Vec<(Element, String)> {
    let some = |has: fn(&Curve) -> bool| picture.curves.iter().any(has);
    let first = picture.curves.first();
    let verb = first.map_or(Behaviour::default(), |curve| curve.behaviour).verb();
    let mut entries = vec![(
        Element::new("g")
            .child(stroke_mark(BLUE, 9.0).with("stroke-opacity", "0.22"))
            .child(stroke_mark(BLUE, 1.8)),
        format!("simulated: the share of runs that {}, and its 95 % interval", verb.plain),
    )];
    if let Some((words, _)) = picture.curves.iter().find_map(|curve| curve.compared.as_ref()) {
        entries.push((stroke_mark(GREEN, 1.6), format!("the same, {words}")));
    }
    if let Some((_, text)) = &picture.wanted {
        let mark = stroke_mark(QUIET_INK, 1.0).with("stroke-dasharray", "2 3");
        entries.push((mark, text.clone()));
    }
    if some(|curve| curve.range.is_some()) {
        let mark = stroke_mark(BLUE, 11.0).with("stroke-opacity", "0.09");
        entries.push((mark, "the range around the recommendation".to_owned()));
    }
    if some(|curve| curve.marked.is_some()) {
        let triangle = Element::path("M11 5l-5 -9h10z").with("fill", VERMILION);
        entries.push((triangle, picture.marked.to_owned()));
    }
    if some(|curve| !curve.real.is_empty()) {
        entries.push((stroke_mark(INK, 1.8), "real runs, with the 95 % interval".to_owned()));
    }
    for curve in &picture.curves {
        for (index, line) in curve.boundaries.iter().enumerate() {
            let mark = stroke_mark(INK, 1.4).with("stroke-dasharray", dashes(index));
            let entry = (mark, format!("{}, {}", line.label, line.holds.in_words()));
            if entries.iter().all(|(_, text)| *text != entry.1) {
                entries.push(entry);
            }
        }
    }
    entries
}
