//! The legend to the right of a phase diagram: only what the picture shows.

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::phase::Phase;

use crate::boundary::{dashes, tag};
use crate::cell_values::ValueScale;
use crate::overlay::{ChosenShape, double_stroke, ring};
use crate::palette::{Colour, INK, LEAST_SHARE, NOT_SWEPT, QUIET_INK, shade};
use crate::svg::{Element, line_of_text, rectangle};
use crate::symbol::{Filling, MARK_PX, mark};
use crate::text::{Weight, width_px, wrap};

/// Width of the legend where there is room, in pixels.
pub const WIDTH_PX: f64 = 250.0;

const TEXT_PX: f64 = 11.5;
const SMALL_PX: f64 = 9.5;
const ROW_PX: f64 = 19.0;
const RAMP_STEPS: usize = 5;
const STEP_PX: f64 = 14.0;
const VALUE_STEPS: usize = 15;
/// From the left edge of the keys to that of the texts.
const KEY_PX: f64 = RAMP_STEPS as f64 * STEP_PX + 10.0;

/// What a legend has to explain.
#[derive(Clone, Debug, Default)]
pub struct Contents {
    /// The behaviour whose phases are shown.
    pub behaviour: Behaviour,
    /// What the cells show in the place of phases, how it becomes a colour, and what a frame means.
    pub values: Option<(String, ValueScale, Option<String>)>,
    /// The phases that some cell shows.
    pub phases: Vec<Phase>,
    /// Font size of the numbers in the cells, in pixels, if there are any.
    pub number_px: Option<f64>,
    /// The chosen cell if the picture shows it, a line per axis, and its mark.
    pub chosen: Option<(Vec<String>, ChosenShape)>,
    /// Numbers and labels of the boundaries that the picture shows.
    pub boundaries: Vec<(usize, String)>,
    /// Real runs per phase, settled or not, without those that did not occur.
    pub experiments: Vec<(Phase, Filling, u64)>,
    /// Real runs that the picture does not show.
    pub n_experiments_elsewhere: u64,
    /// What all of those are, in words.
    pub experiments_are: &'static str,
    /// Whether the numbers in the cells are `B_s`.
    pub has_b_s: bool,
    /// Whether some cells have nothing to show.
    pub has_holes: bool,
}

impl Contents {
    /// What a cell with nothing to show means.
    fn blank(&self) -> &'static str {
        if self.values.is_some() { "no such run" } else { "no result" }
    }
}

struct Legend {
    left_px: f64,
    width_px: f64,
    y_px: f64,
    elements: Vec<Element>,
}

/// Draws the legend from its upper left corner, no wider than asked for, and finds where it ends below,
/// in pixels.
pub fn legend(
    contents: &Contents,
    (left_px, top_px): (f64, f64),
    width_px: f64,
) -> (Vec<Element>, f64) {
    let mut legend = Legend { left_px, width_px, y_px: top_px, elements: Vec::new() };
    if let Some((name, scale, framed)) = &contents.values {
        legend.values(name, *scale, framed.as_deref());
    } else {
        legend.phases(contents.behaviour);
        if let Some(size_px) = contents.number_px {
            legend.number(contents, size_px);
        }
    }
    if contents.has_holes {
        let swatch = rectangle(left_px + KEY_PX - 38.0, legend.y_px + 3.0, 28.0, 13.0)
            .with("fill", NOT_SWEPT)
            .with("stroke", "#cccccc");
        legend.row(Some(swatch), contents.blank());
    }
    if let Some((values, shape)) = &contents.chosen {
        legend.chosen(values, *shape);
    }
    if !contents.boundaries.is_empty() {
        legend.heading("Theory");
        for (index, label) in &contents.boundaries {
            legend.boundary(*index, label);
        }
    }
    if !contents.experiments.is_empty() || contents.n_experiments_elsewhere > 0 {
        legend.experiments(contents);
    }
    (legend.elements, legend.y_px)
}

/// One entry of a legend of few lines: its key around the origin, the key's width, and its text.
struct Entry {
    key: Element,
    key_px: f64,
    text: String,
}

/// Size of the letters of a legend of few lines, in pixels.
const COMPACT_PX: f64 = 10.0;
/// From one of its lines to the next, in pixels.
const COMPACT_LINE_PX: f64 = 17.0;
/// Between two of its entries, in pixels.
const COMPACT_GAP_PX: f64 = 13.0;

/// Draws a legend of few lines for a paper, entry beside entry, as wide as asked for, and finds where it
/// ends below, in pixels.
pub fn compact(
    contents: &Contents,
    (left_px, top_px): (f64, f64),
    room_px: f64,
) -> (Vec<Element>, f64) {
    let text_px = |line: &String| width_px(line, COMPACT_PX, Weight::Regular);
    let mut elements = Vec::new();
    let (mut x_px, mut y_px) = (left_px, top_px + 8.0);
    for Entry { key, key_px, text } in entries(contents) {
        let lines = wrap(&text, COMPACT_PX, Weight::Regular, room_px - key_px - 5.0);
        let widest_px = lines.iter().map(text_px).fold(0.0, f64::max);
        let entry_px = key_px + 5.0 + widest_px;
        if x_px > left_px && x_px + entry_px > left_px + room_px {
            (x_px, y_px) = (left_px, y_px + COMPACT_LINE_PX);
        }
        elements.push(Element::new("g").moved((x_px, y_px)).child(key));
        for (index, line) in lines.iter().enumerate() {
            let baseline_px = y_px + 3.6 + index as f64 * 13.0;
            let line = line_of_text(x_px + key_px + 5.0, baseline_px, line);
            elements.push(line.lettered(COMPACT_PX, INK));
        }
        x_px += entry_px + COMPACT_GAP_PX;
        if lines.len() > 1 {
            (x_px, y_px) = (left_px, y_px + COMPACT_LINE_PX + (lines.len() - 1) as f64 * 13.0);
        }
    }
    let end_px = if x_px > left_px { y_px + COMPACT_LINE_PX / 2.0 } else { y_px };
    (elements, end_px)
}

/// So many colours of a phase, from its least share to all runs; two or more.
fn phase_ramp(phase: Phase, n: usize) -> impl Iterator<Item = Colour> {
    let share = move |step: usize| LEAST_SHARE + (1.0 - LEAST_SHARE) * step as f64 / (n - 1) as f64;
    (0..n).map(move |step| shade(phase, share(step)))
}

fn entries(contents: &Contents) -> Vec<Entry> {
    let mut entries = Vec::new();
    let frame = |width_px: f64| rectangle(0.0, -5.0, 14.0, 10.0).outlined(INK, width_px);
    let words = |text: &str| {
        let size_px = COMPACT_PX - 1.0;
        let key = line_of_text(0.0, 3.4, text).lettered(size_px, INK);
        (key.with("font-weight", "bold"), width_px(text, size_px, Weight::Bold))
    };
    if let Some((name, scale, framed)) = &contents.values {
        let step = |(step, colour): (usize, Colour)| {
            rectangle(6.0 * step as f64, -5.0, 6.2, 10.0).with("fill", &colour.hex())
        };
        let key = Element::new("g").children(scale.ramp(VALUE_STEPS).enumerate().map(step));
        let [from, to] = scale.end_labels();
        let key_px = 6.0 * VALUE_STEPS as f64;
        entries.push(Entry { key, key_px, text: format!("{name}: {from} to {to}") });
        if let Some(words) = framed {
            entries.push(Entry { key: frame(2.0), key_px: 14.0, text: words.clone() });
        }
    } else {
        for phase in &contents.phases {
            let step = |(step, colour): (usize, Colour)| {
                rectangle(8.0 * step as f64, -5.0, 8.0, 10.0).with("fill", &colour.hex())
            };
            let key = Element::new("g").children(phase_ramp(*phase, 3).enumerate().map(step));
            entries.push(Entry { key, key_px: 24.0, text: phase.title().to_owned() });
        }
        if contents.number_px.is_some() {
            let (key, key_px) = words("0.xx");
            let text = format!("share of {}", contents.behaviour.noun());
            entries.push(Entry { key, key_px, text });
        }
    }
    if contents.has_holes {
        let key =
            rectangle(0.0, -5.0, 14.0, 10.0).with("fill", NOT_SWEPT).with("stroke", "#cccccc");
        entries.push(Entry { key, key_px: 14.0, text: contents.blank().to_owned() });
    }
    if contents.chosen.is_some() {
        entries.push(Entry { key: frame(3.0), key_px: 14.0, text: "chosen cell".to_owned() });
    }
    for (index, label) in &contents.boundaries {
        entries.push(Entry { key: tag((8.0, 0.0), *index), key_px: 17.0, text: label.clone() });
    }
    if !contents.experiments.is_empty() {
        let (key, key_px) = words("n/n");
        let verb = contents.behaviour.verb().plain;
        let text = format!("{}: those that {verb}, of all", contents.experiments_are);
        entries.push(Entry { key, key_px, text });
    }
    for (phase, filling, n) in &contents.experiments {
        let key = mark(*phase, *filling, ((6.0, 0.0), 4.6));
        entries.push(Entry { key, key_px: 12.0, text: format!("{phase}: {n}") });
    }
    entries
}

impl Legend {
    fn heading(&mut self, text: &str) {
        self.y_px += 10.0;
        let line = line_of_text(self.left_px, self.y_px + 12.0, text).bold(TEXT_PX, INK);
        self.elements.push(line);
        self.y_px += 20.0;
    }

    /// A key and its text, wrapped; the key is drawn at the current height.
    fn row(&mut self, key: Option<Element>, text: &str) {
        self.elements.extend(key);
        let mut lines = wrap(text, TEXT_PX, Weight::Regular, self.width_px - KEY_PX);
        if lines.is_empty() {
            lines.push(String::new());
        }
        for (line_number, line) in lines.iter().enumerate() {
            let baseline_px = self.y_px + 13.5 + line_number as f64 * 15.0;
            let line =
                line_of_text(self.left_px + KEY_PX, baseline_px, line).lettered(TEXT_PX, INK);
            self.elements.push(line);
        }
        self.y_px += ROW_PX + (lines.len() - 1) as f64 * 15.0;
    }

    /// One ramp per phase: hue for the phase, lightness for its share.
    fn phases(&mut self, behaviour: Behaviour) {
        self.y_px -= 10.0;
        self.heading("Most frequent phase");
        for (share, step) in [(LEAST_SHARE, 0), (1.0, RAMP_STEPS - 1)] {
            let text = line_of_text(
                self.left_px + (step as f64 + 0.5) * STEP_PX,
                self.y_px + 10.0,
                &format!("{share}"),
            );
            self.small(text.with("text-anchor", "middle"));
        }
        let caption =
            line_of_text(self.left_px + KEY_PX, self.y_px + 10.0, "its share of the replicates");
        self.small(caption);
        self.y_px += 14.0;
        for phase in behaviour.phases().iter().copied() {
            for (step, colour) in phase_ramp(phase, RAMP_STEPS).enumerate() {
                let x_px = self.left_px + step as f64 * STEP_PX;
                let swatch =
                    rectangle(x_px, self.y_px + 2.0, STEP_PX, 15.0).with("fill", &colour.hex());
                self.elements.push(swatch);
            }
            self.row(None, phase.title());
        }
    }

    /// A ramp from the least number to the greatest.
    fn values(&mut self, name: &str, scale: ValueScale, framed: Option<&str>) {
        self.y_px -= 10.0;
        for line in wrap(name, TEXT_PX, Weight::Bold, self.width_px) {
            self.heading(&line);
            self.y_px -= 14.0;
        }
        self.y_px += 14.0;
        let width_px = self.width_px.min(180.0) / VALUE_STEPS as f64;
        for (step, colour) in scale.ramp(VALUE_STEPS).enumerate() {
            let x_px = self.left_px + step as f64 * width_px;
            let swatch = rectangle(x_px, self.y_px, width_px, 13.0).with("fill", &colour.hex());
            self.elements.push(swatch);
        }
        self.y_px += 26.0;
        let right_px = self.left_px + width_px * VALUE_STEPS as f64;
        let [from, to] = scale.end_labels();
        let from = line_of_text(self.left_px, self.y_px, &from);
        let to = line_of_text(right_px, self.y_px, &to).with("text-anchor", "end");
        for text in [from, to] {
            self.elements.push(text.lettered(TEXT_PX, INK));
        }
        self.y_px += 10.0;
        if let Some(words) = framed {
            let key = rectangle(self.left_px + KEY_PX - 34.0, self.y_px + 3.0, 20.0, 13.0)
                .outlined(INK, 2.0);
            self.row(Some(key), words);
        }
    }

    fn small(&mut self, text: Element) {
        self.elements.push(text.lettered(SMALL_PX, QUIET_INK));
    }

    fn number(&mut self, contents: &Contents, size_px: f64) {
        self.y_px += 6.0;
        let example = "0.xx";
        let x_px = self.left_px + KEY_PX - 12.0 - width_px(example, size_px, Weight::Regular);
        let key = line_of_text(x_px, self.y_px + 13.5, example).lettered(size_px, INK);
        self.elements.push(key);
        let share = format!("share of {}", contents.behaviour.noun());
        if !contents.has_b_s {
            self.row(None, &share);
            return;
        }
        let name = "Bs";
        let text = format!("{name}, {share}");
        let mut lines = wrap(&text, TEXT_PX, Weight::Regular, self.width_px - KEY_PX).into_iter();
        let first = lines.next().unwrap_or_default();
        let subscript = Element::new("tspan").at("dy", 2.5).at("font-size", 8.0).text("s");
        let text = Element::new("text")
            .at("x", self.left_px + KEY_PX)
            .at("y", self.y_px + 13.5)
            .lettered(TEXT_PX, INK)
            .text("B")
            .child(subscript)
            .child(Element::new("tspan").at("dy", -2.5).text(first.trim_start_matches(name)));
        self.elements.push(text);
        let others: Vec<String> = lines.collect();
        if others.is_empty() {
            self.y_px += ROW_PX;
        } else {
            self.y_px += 15.0;
            self.row(None, &others.join(" "));
        }
    }

    fn chosen(&mut self, values: &[String], shape: ChosenShape) {
        self.y_px += 6.0;
        let centre_px = (self.left_px + KEY_PX - 24.0, self.y_px + 9.5);
        let key = match shape {
            ChosenShape::Ring => ring(centre_px),
            ChosenShape::Frame => double_stroke(|| {
                rectangle(centre_px.0 - 10.0, centre_px.1 - 7.0, 20.0, 14.0)
                    .with("stroke-linejoin", "round")
            }),
        };
        self.row(Some(key), "chosen cell:");
        for value in values {
            self.y_px -= 3.0;
            self.row(None, value);
        }
    }

    fn boundary(&mut self, index: usize, label: &str) {
        let y_px = self.y_px + 9.5;
        let line = Element::new("line")
            .at("x1", self.left_px)
            .at("x2", self.left_px + KEY_PX - 28.0)
            .at("y1", y_px)
            .at("y2", y_px)
            .stroked(INK, 1.8)
            .with("stroke-dasharray", dashes(index));
        self.elements.push(line);
        let key = tag((self.left_px + KEY_PX - 20.0, y_px), index);
        self.row(Some(key), label);
        self.y_px += 3.0;
    }

    fn experiments(&mut self, contents: &Contents) {
        let (first, rest) = contents.experiments_are.split_at(1);
        self.heading(&format!("{}{rest}", first.to_uppercase()));
        if !contents.experiments.is_empty() {
            let text = format!("those that {}, of all", contents.behaviour.verb().plain);
            let key = line_of_text(self.left_px + KEY_PX - 34.0, self.y_px + 13.5, "n/n")
                .bold(TEXT_PX, INK);
            self.row(Some(key), &text);
        }
        for (phase, filling, n) in &contents.experiments {
            let at_px = (self.left_px + KEY_PX - 20.0, self.y_px + 9.5);
            let key = mark(*phase, *filling, (at_px, MARK_PX));
            let warning = match filling {
                Filling::Full => "",
                Filling::Hollow => ", not settled: look again",
            };
            self.row(Some(key), &format!("{phase}: {n}{warning}"));
        }
        if contents.n_experiments_elsewhere > 0 {
            // Where nobody reads this, runs would seem to be missing.
            let text = format!("{} not shown", contents.n_experiments_elsewhere);
            self.row(None, &text);
        }
    }
}
