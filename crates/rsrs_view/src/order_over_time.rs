//! One run from above, and beside it its order parameters over time with the bounds of the wanted phase.

use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::rule::{Condition, Parameter, Rules};

use crate::chart::{BELOW_PX, Chart, LEFT_PX, legend, stroke_mark};
use crate::floor::PAGE_PX;
use crate::palette::{INK, QUIET_INK};
use crate::svg::{Element, line_of_text, number, rectangle};
use crate::trajectory::{TrajectoryPicture, TrajectoryPictureError, elements};

const CHART_PX: (f64, f64) = (430.0, 240.0);
const MARGIN_PX: f64 = 24.0;
const HEADING_PX: f64 = 12.5;

/// One run, and its order parameters.
#[derive(Clone, Debug)]
pub struct RunPicture<'a> {
    /// The run from above.
    pub run: TrajectoryPicture<'a>,
    /// Its order parameters.
    pub order: OrderPicture<'a>,
}

/// The order parameters of a run.
#[derive(Clone, Debug)]
pub struct OrderPicture<'a> {
    /// Those of each block: when it begins, in seconds from the start, and they.
    pub blocks: &'a [(f64, OrderParameters)],
    /// Length of a block, in seconds.
    pub block_s: f64,
    /// Length of the run, in seconds; positive.
    pub duration_s: f64,
    /// When the judged window begins, in seconds from the start.
    pub window_start_s: f64,
    /// The rules that it is judged by.
    pub rules: &'a Rules,
    /// Below the curves; any texts.
    pub notes: &'a [String],
}

/// The order parameters as SVG, with where the curves lie.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnOrder {
    /// The picture.
    pub svg: String,
    /// Its width and height, in pixels.
    pub size_px: (f64, f64),
    /// Left and upper edge of the curves, in pixels; the run starts at the left one.
    pub corner_px: (f64, f64),
    /// Width and height of the curves, in pixels; the run ends at their right edge.
    pub curves_px: (f64, f64),
}

/// An order parameter as a line.
struct Line {
    colour: &'static str,
    /// Where the wanted phase begins or ends.
    condition: Condition,
}

/// Draws a run from above and its order parameters beside it.
///
/// # Returns
///
/// A self-contained SVG document; the same text on every machine.
///
/// # Errors
///
/// As [`crate::trajectory::svg`].
pub fn svg(picture: &RunPicture) -> Result<String, TrajectoryPictureError> {
    let (run, run_height_px) = elements(&picture.run)?;
    let chart = chart(&picture.order, (PAGE_PX + LEFT_PX, 62.0));
    let (curves, curves_px) = curves(&picture.order, &chart);
    let width_px = chart.left_px + chart.width_px + MARGIN_PX;
    let page = Element::picture(width_px, run_height_px.max(curves_px), &picture.run.title)
        .children(run)
        .children(curves);
    Ok(format!("{page}\n"))
}

/// Draws order parameters without the run.
///
/// # Arguments
///
/// * `title` — for screen readers; any text.
pub fn order_svg(picture: &OrderPicture, title: &str) -> DrawnOrder {
    let chart = chart(picture, (LEFT_PX, 36.0));
    let (curves, height_px) = curves(picture, &chart);
    let width_px = chart.left_px + chart.width_px + MARGIN_PX;
    let page = Element::picture(width_px, height_px, title).children(curves);
    DrawnOrder {
        svg: format!("{page}\n"),
        size_px: (width_px, height_px),
        corner_px: (chart.left_px, chart.top_px),
        curves_px: (chart.width_px, chart.height_px),
    }
}

fn chart(picture: &OrderPicture, (left_px, top_px): (f64, f64)) -> Chart {
    let (width_px, height_px) = CHART_PX;
    Chart { left_px, top_px, width_px, height_px, x: [0.0, picture.duration_s], y: [0.0, 1.0] }
}

/// The curves with heading, axes and legend, and where they end below, in pixels.
fn curves(picture: &OrderPicture, chart: &Chart) -> (Vec<Element>, f64) {
    let lines = lines(picture.rules);
    let heading = line_of_text(chart.left_px, chart.top_px - 10.0, "Order parameters")
        .at("font-size", HEADING_PX)
        .with("font-weight", "bold")
        .with("fill", INK);
    let (legend, legend_px) = legend(
        &entries(&lines, picture),
        (chart.left_px, chart.bottom_px() + BELOW_PX),
        chart.width_px,
    );
    let mut elements = vec![heading, judged(chart, picture.window_start_s)];
    elements.extend(lines.iter().map(|line| bound(chart, line)));
    elements.extend(lines.iter().map(|line| curve(chart, line, picture)));
    elements.extend([chart.frame("time since the start (s)"), chart.y_axis("order parameter")]);
    elements.extend(legend);
    (elements, legend_px + 12.0)
}

fn lines(rules: &Rules) -> Vec<Line> {
    let conditions = rules.of(rules.wanted).flat_map(|rule| &rule.conditions);
    let line = |condition: &Condition| {
        let colour = colour(condition.parameter);
        Line { colour, condition: *condition }
    };
    conditions.map(line).collect()
}

fn colour(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::Rotation => "#0072b2",
        Parameter::Orbit => "#009e73",
        Parameter::Circliness | Parameter::Clustered => "#d55e00",
        Parameter::Blocked | Parameter::Stuck => "#555555",
        Parameter::Lost => "#cc79a7",
    }
}

/// The window that the judge looks at.
fn judged(chart: &Chart, start_s: f64) -> Element {
    let left_px = chart.x_px(start_s.max(chart.x[0]));
    rectangle(left_px, chart.top_px, chart.left_px + chart.width_px - left_px, chart.height_px)
        .with("fill", "#0072b2")
        .with("fill-opacity", "0.07")
}

fn bound(chart: &Chart, line: &Line) -> Element {
    let (left, y) = (number(chart.left_px), number(chart.y_px(line.condition.bound)));
    Element::new("path")
        .with("d", &format!("M{left} {y}h{}", number(chart.width_px)))
        .with("stroke", line.colour)
        .at("stroke-width", 0.9)
        .with("stroke-dasharray", "2 4")
}

/// The order parameter of each block, at its middle; kept within the frame.
fn curve(chart: &Chart, line: &Line, picture: &OrderPicture) -> Element {
    let place = |(start_s, order): &(f64, OrderParameters)| {
        let value = line.condition.parameter.of(order).clamp(0.0, 1.0);
        let time_s = start_s + picture.block_s / 2.0;
        format!("{} {}", number(chart.x_px(time_s)), number(chart.y_px(value)))
    };
    let places: Vec<String> = picture.blocks.iter().map(place).collect();
    let path = if places.is_empty() { String::new() } else { format!("M{}", places.join("L")) };
    Element::new("path")
        .with("d", &path)
        .with("fill", "none")
        .with("stroke", line.colour)
        .at("stroke-width", 1.8)
        .with("stroke-linejoin", "round")
}

fn entries(lines: &[Line], picture: &OrderPicture) -> Vec<(Element, String)> {
    let wanted = picture.rules.wanted;
    let entry = |line: &Line| {
        let Line { colour, condition } = line;
        let text = format!("{} ({wanted}: {condition})", condition.parameter.key());
        (stroke_mark(colour, 1.8), text)
    };
    let mut entries: Vec<(Element, String)> = lines.iter().map(entry).collect();
    let shade = stroke_mark("#0072b2", 11.0).with("stroke-opacity", "0.07");
    entries.push((shade, "the window that is judged".to_owned()));
    let none = || stroke_mark(QUIET_INK, 0.0);
    entries.extend(picture.notes.iter().map(|note| (none(), note.clone())));
    entries
}
