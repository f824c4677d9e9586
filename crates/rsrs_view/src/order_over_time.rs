//! One run from above, and beside it its order parameters over time, a row for each with the bound of the
//! wanted phase.

use rsrs_core::judge::behaviour::condition::Condition;
use rsrs_core::judge::behaviour::rule::Rules;
use rsrs_core::judge::order::OrderParameters;
use rsrs_core::judge::order::Parameter;

use crate::boundary::path_of;
use crate::chart::{BELOW_PX, Chart, LEFT_PX, legend, stroke_mark};
use crate::floor::PAGE_PX;
use crate::header::MARGIN_PX;
use crate::palette::{BLUE, GREEN, INK, ORANGE, QUIET_INK, VERMILION};
use crate::svg::{Element, line_of_text, number, rectangle};
use crate::theme::Theme;
use crate::trajectory::{TrajectoryPicture, TrajectoryPictureError, elements};

const WIDTH_PX: f64 = 430.0;
/// Height of one row, and of its name above it.
const ROW_PX: f64 = 44.0;
const NAME_PX: f64 = 18.0;
/// From one row to the next.
const PITCH_PX: f64 = NAME_PX + ROW_PX + 4.0;
const ROW_NAME_PX: f64 = 11.0;
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
    /// When the judged window begins and ends, in seconds from the start; at the same time if nothing is judged.
    pub judged_s: [f64; 2],
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
    /// Where its row ends above.
    top: f64,
}

/// Draws a run from above and its order parameters beside it, as a self-contained SVG document: the
/// same text on every machine.
pub fn svg(picture: &RunPicture) -> Result<String, TrajectoryPictureError> {
    let (run, run_height_px) = elements(&picture.run)?;
    // In a column of a paper there is room for one of them.
    let (corner_px, width_px) = match picture.run.theme {
        Theme::Screen => ((PAGE_PX + LEFT_PX, 62.0), PAGE_PX + LEFT_PX + WIDTH_PX + MARGIN_PX),
        Theme::Paper => ((LEFT_PX, run_height_px + 20.0), LEFT_PX + WIDTH_PX + MARGIN_PX),
    };
    let rows = Rows::new(&picture.order, corner_px);
    let (curves, curves_px) = rows.drawn(&picture.order);
    let page = Element::picture(width_px, run_height_px.max(curves_px), &picture.run.title)
        .described(&picture.run.theme.description([picture.run.subtitle.as_str()], ""))
        .children(run)
        .children(curves);
    Ok(format!("{page}\n"))
}

/// Draws order parameters without the run, under a title for screen readers.
pub fn order_svg(picture: &OrderPicture, title: &str) -> DrawnOrder {
    let rows = Rows::new(picture, (LEFT_PX, 36.0));
    let (curves, height_px) = rows.drawn(picture);
    let width_px = LEFT_PX + WIDTH_PX + MARGIN_PX;
    let page = Element::picture(width_px, height_px, title).children(curves);
    let (first, last) = (rows.charts[0], rows.charts[rows.charts.len() - 1]);
    DrawnOrder {
        svg: format!("{page}\n"),
        size_px: (width_px, height_px),
        corner_px: (first.left_px, first.top_px),
        curves_px: (first.width_px, last.bottom_px() - first.top_px),
    }
}

/// A row for each order parameter, one below the other.
struct Rows {
    lines: Vec<Line>,
    charts: Vec<Chart>,
}

impl Rows {
    fn new(picture: &OrderPicture, (left_px, top_px): (f64, f64)) -> Self {
        let lines = lines(picture);
        let whole_s = end_s(picture.duration_s);
        let chart = |(row, line): (usize, &Line)| Chart {
            left_px,
            top_px: top_px + NAME_PX + row as f64 * PITCH_PX,
            width_px: WIDTH_PX,
            height_px: ROW_PX,
            x: [0.0, whole_s],
            // A line at 0 or 1 lies on no frame.
            y: [-0.08, 1.08].map(|share| share * line.top),
        };
        let charts = lines.iter().enumerate().map(chart).collect();
        Self { lines, charts }
    }

    /// The curves with heading, axes and legend, and where they end below, in pixels.
    fn drawn(&self, picture: &OrderPicture) -> (Vec<Element>, f64) {
        let (first, last) = (self.charts[0], self.charts[self.charts.len() - 1]);
        let heading_px = first.top_px - NAME_PX - 10.0;
        let heading =
            line_of_text(first.left_px, heading_px, "Order parameters").bold(HEADING_PX, INK);
        let mut elements = vec![heading];
        for (line, chart) in self.lines.iter().zip(&self.charts) {
            elements.push(name(line, chart, picture));
            elements.push(judged(chart, picture.judged_s));
            elements.push(bound(chart, line));
            elements.push(curve(chart, line, picture));
            elements.push(scale(chart, line.top));
        }
        elements.push(last.frame("time since the start (s)"));
        let corner_px = (last.left_px, last.bottom_px() + BELOW_PX - 6.0);
        let (legend, legend_px) = legend(&entries(picture), corner_px, last.width_px);
        elements.extend(legend);
        (elements, legend_px + 12.0)
    }
}

/// Where the axis of time ends: at a round time that the last sample has all but reached.
fn end_s(duration_s: f64) -> f64 {
    let round_s = (duration_s / 10.0).round() * 10.0;
    if round_s > duration_s && round_s - duration_s < 0.01 * duration_s {
        round_s
    } else {
        duration_s
    }
}

/// What a row shows, above it.
fn name(line: &Line, chart: &Chart, picture: &OrderPicture) -> Element {
    let Line { colour, condition, .. } = line;
    let text = format!("{} ({}: {condition})", condition.parameter.key(), picture.rules.wanted);
    let place_px = (chart.left_px, chart.top_px - 0.5 * NAME_PX + 1.0);
    let swatch = Element::new("g").moved(place_px).child(stroke_mark(colour, 1.8));
    let words = line_of_text(chart.left_px + 28.0, chart.top_px - 0.5 * NAME_PX + 5.0, &text)
        .lettered(ROW_NAME_PX, INK);
    Element::new("g").child(swatch).child(words)
}

/// The frame of a row with its numbers, up to `top`.
fn scale(chart: &Chart, top: f64) -> Element {
    let border =
        rectangle(chart.left_px, chart.top_px, chart.width_px, chart.height_px).outlined(INK, 1.0);
    let left = number(chart.left_px);
    let values = [0.0, top / 2.0, top];
    let tick = |value: &f64| format!("M{left} {}h-4", number(chart.y_px(*value)));
    let ticks = values.iter().map(tick).collect::<Vec<_>>().concat();
    let texts = values.map(|value| {
        line_of_text(chart.left_px - 8.0, chart.y_px(value) + 3.5, &value.to_string())
            .at("font-size", 10.0)
            .with("text-anchor", "end")
            .with("fill", QUIET_INK)
    });
    Element::new("g").child(border).child(Element::path(&ticks).stroked(INK, 1.0)).children(texts)
}

fn lines(picture: &OrderPicture) -> Vec<Line> {
    let rules = picture.rules;
    let conditions = rules.of(rules.wanted).flat_map(|rule| &rule.conditions);
    let line = |condition: &Condition| {
        let colour = colour(condition.parameter);
        Line { colour, condition: *condition, top: top(condition, picture) }
    };
    conditions.map(line).collect()
}

/// How far up a row goes: to 1, or what is no share, to a round number beyond its bound and its values.
fn top(condition: &Condition, picture: &OrderPicture) -> f64 {
    if condition.parameter.unit().is_empty() {
        return 1.0;
    }
    let values = picture.blocks.iter().map(|(_, order)| condition.parameter.of(order));
    let most = values.fold(1.25 * condition.bound, f64::max);
    let mut top = 0.01;
    for factor in [2.0, 2.5, 2.0].into_iter().cycle() {
        if top >= most {
            break;
        }
        top *= factor;
    }
    top
}

/// Of lines that have no colour of their own.
const OTHERS: [&str; 4] = [ORANGE, BLUE, GREEN, "#56b4e9"];

pub(crate) fn colour(parameter: Parameter) -> &'static str {
    match parameter {
        Parameter::ROTATION => BLUE,
        Parameter::ORBIT => GREEN,
        Parameter::CIRCLINESS | Parameter::CLUSTERED => VERMILION,
        Parameter::BLOCKED | Parameter::STUCK => "#555555",
        Parameter::LOST => "#cc79a7",
        other => {
            let place = Parameter::all().position(|it| it == other).unwrap_or(0);
            OTHERS[place % OTHERS.len()]
        }
    }
}

/// The window that the judge looks at.
fn judged(chart: &Chart, [start_s, end_s]: [f64; 2]) -> Element {
    let left_px = chart.x_px(start_s.max(chart.x[0]));
    let right_px = chart.x_px(end_s.min(chart.x[1]));
    rectangle(left_px, chart.top_px, (right_px - left_px).max(0.0), chart.height_px)
        .filled(BLUE, "0.07")
}

fn bound(chart: &Chart, line: &Line) -> Element {
    let (left, y) = (number(chart.left_px), number(chart.y_px(line.condition.bound)));
    Element::path(&format!("M{left} {y}h{}", number(chart.width_px)))
        .stroked(line.colour, 0.9)
        .with("stroke-dasharray", "2 4")
}

/// The order parameter of each block, at its middle; kept within the frame. Where it is not known, the line has a gap.
fn curve(chart: &Chart, line: &Line, picture: &OrderPicture) -> Element {
    let place = |(start_s, order): &(f64, OrderParameters)| {
        let value = line.condition.parameter.value(order)?.clamp(0.0, line.top);
        let time_s = start_s + picture.block_s / 2.0;
        Some((chart.x_px(time_s), chart.y_px(value)))
    };
    let places: Vec<Option<(f64, f64)>> = picture.blocks.iter().map(place).collect();
    let known = places.split(Option::is_none).filter(|piece| !piece.is_empty());
    let pieces: Vec<_> = known.map(|piece| piece.iter().flatten().copied().collect()).collect();
    let path = path_of(&pieces);
    Element::path(&path).outlined(line.colour, 1.8).with("stroke-linejoin", "round")
}

fn entries(picture: &OrderPicture) -> Vec<(Element, String)> {
    let bound = stroke_mark(QUIET_INK, 0.9).with("stroke-dasharray", "2 4");
    let shade = stroke_mark(BLUE, 11.0).with("stroke-opacity", "0.07");
    let mut entries = vec![(bound, format!("bound of {}", picture.rules.wanted))];
    if picture.judged_s[0] < picture.judged_s[1] {
        entries.push((shade, "the window that is judged".to_owned()));
    }
    let none = || stroke_mark(QUIET_INK, 0.0);
    entries.extend(picture.notes.iter().map(|note| (none(), note.clone())));
    entries
}
