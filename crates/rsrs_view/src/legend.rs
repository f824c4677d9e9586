//! The legend to the right of a phase diagram: only what the picture shows.

use rsrs_core::judge::behaviour::Behaviour;
use rsrs_core::judge::phase::Phase;

use crate::boundary::{dashes, tag};
use crate::overlay::{ChosenShape, double_stroke, ring};
use crate::palette::{INK, LEAST_SHARE, NOT_SWEPT, QUIET_INK, shade};
use crate::svg::{Element, line_of_text, rectangle};
use crate::symbol::{Filling, MARK_PX, mark};
use crate::text::{Weight, width_px, wrap};

/// Width of the legend where there is room, in pixels.
pub const WIDTH_PX: f64 = 250.0;

const OUTSIDE: &str = " (not shown)";
const TEXT_PX: f64 = 11.5;
const SMALL_PX: f64 = 9.5;
const ROW_PX: f64 = 19.0;
const RAMP_STEPS: usize = 5;
const STEP_PX: f64 = 14.0;
/// From the left edge of the keys to that of the texts.
const KEY_PX: f64 = RAMP_STEPS as f64 * STEP_PX + 10.0;

/// What a legend has to explain.
#[derive(Clone, Debug, Default)]
pub struct Contents {
    /// The behaviour whose phases are shown.
    pub behaviour: Behaviour,
    /// Font size of the numbers in the cells, in pixels, if there are any.
    pub number_px: Option<f64>,
    /// The chosen cell, a line per axis, and its mark if the picture shows it.
    pub chosen: Option<(Vec<String>, Option<ChosenShape>)>,
    /// Labels of the boundaries.
    pub boundaries: Vec<(String, Visibility)>,
    /// Real runs per phase, settled or not, without those that did not occur.
    pub experiments: Vec<(Phase, Filling, u64)>,
    /// Real runs that the picture does not show.
    pub n_experiments_elsewhere: u64,
    /// Whether some cells have no result.
    pub has_holes: bool,
}

/// Whether the picture shows something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Visibility {
    /// It is drawn.
    Shown,
    /// It lies outside the axes or in another slice.
    Outside,
}

struct Legend {
    left_px: f64,
    width_px: f64,
    y_px: f64,
    elements: Vec<Element>,
}

/// Draws the legend from its upper left corner, no wider than asked for, in pixels.
///
/// # Returns
///
/// The elements, and where they end below, in pixels.
pub fn legend(
    contents: &Contents,
    (left_px, top_px): (f64, f64),
    width_px: f64,
) -> (Vec<Element>, f64) {
    let mut legend = Legend { left_px, width_px, y_px: top_px, elements: Vec::new() };
    legend.phases(contents.behaviour);
    if let Some(size_px) = contents.number_px {
        legend.number(contents.behaviour, size_px);
    }
    if contents.has_holes {
        let swatch = rectangle(left_px + KEY_PX - 38.0, legend.y_px + 3.0, 28.0, 13.0)
            .with("fill", NOT_SWEPT)
            .with("stroke", "#cccccc");
        legend.row(Some(swatch), "no result");
    }
    if let Some((values, shape)) = &contents.chosen {
        legend.chosen(values, *shape);
    }
    if !contents.boundaries.is_empty() {
        legend.heading("Theory");
        for (index, (label, visibility)) in contents.boundaries.iter().enumerate() {
            legend.boundary(index, label, *visibility);
        }
    }
    if !contents.experiments.is_empty() || contents.n_experiments_elsewhere > 0 {
        legend.experiments(contents);
    }
    (legend.elements, legend.y_px)
}

impl Legend {
    fn heading(&mut self, text: &str) {
        self.y_px += 10.0;
        let line = line_of_text(self.left_px, self.y_px + 12.0, text)
            .at("font-size", TEXT_PX)
            .with("font-weight", "bold")
            .with("fill", INK);
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
            let line = line_of_text(self.left_px + KEY_PX, baseline_px, line)
                .at("font-size", TEXT_PX)
                .with("fill", INK);
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
            for step in 0..RAMP_STEPS {
                let share =
                    LEAST_SHARE + (1.0 - LEAST_SHARE) * step as f64 / (RAMP_STEPS - 1) as f64;
                let x_px = self.left_px + step as f64 * STEP_PX;
                let swatch = rectangle(x_px, self.y_px + 2.0, STEP_PX, 15.0)
                    .with("fill", &shade(phase, share).hex());
                self.elements.push(swatch);
            }
            self.row(None, phase.title());
        }
    }

    fn small(&mut self, text: Element) {
        self.elements.push(text.at("font-size", SMALL_PX).with("fill", QUIET_INK));
    }

    fn number(&mut self, behaviour: Behaviour, size_px: f64) {
        self.y_px += 6.0;
        let example = "0.86";
        let x_px = self.left_px + KEY_PX - 12.0 - width_px(example, size_px, Weight::Regular);
        let key = line_of_text(x_px, self.y_px + 13.5, example)
            .at("font-size", size_px)
            .with("fill", INK);
        let subscript = Element::new("tspan").at("dy", 2.5).at("font-size", 8.0).text("s");
        let text = Element::new("text")
            .at("x", self.left_px + KEY_PX)
            .at("y", self.y_px + 13.5)
            .at("font-size", TEXT_PX)
            .with("fill", INK)
            .text("B")
            .child(subscript)
            .child(
                Element::new("tspan")
                    .at("dy", -2.5)
                    .text(&format!(", share of {}", behaviour.noun())),
            );
        self.elements.extend([key, text]);
        self.y_px += ROW_PX;
    }

    fn chosen(&mut self, values: &[String], shape: Option<ChosenShape>) {
        self.y_px += 6.0;
        let centre_px = (self.left_px + KEY_PX - 24.0, self.y_px + 9.5);
        let key = shape.map(|shape| match shape {
            ChosenShape::Ring => ring(centre_px),
            ChosenShape::Frame => double_stroke(|| {
                rectangle(centre_px.0 - 10.0, centre_px.1 - 7.0, 20.0, 14.0)
                    .with("stroke-linejoin", "round")
            }),
        });
        let outside = if shape.is_none() { OUTSIDE } else { "" };
        self.row(key, &format!("chosen cell{outside}:"));
        for value in values {
            self.y_px -= 3.0;
            self.row(None, value);
        }
    }

    fn boundary(&mut self, index: usize, label: &str, visibility: Visibility) {
        let y_px = self.y_px + 9.5;
        let line = Element::new("line")
            .at("x1", self.left_px)
            .at("x2", self.left_px + KEY_PX - 28.0)
            .at("y1", y_px)
            .at("y2", y_px)
            .with("stroke", INK)
            .at("stroke-width", 1.8)
            .with("stroke-dasharray", dashes(index));
        self.elements.push(line);
        let outside = match visibility {
            Visibility::Shown => "",
            Visibility::Outside => OUTSIDE,
        };
        let key = tag((self.left_px + KEY_PX - 20.0, y_px), index);
        self.row(Some(key), &format!("{label}{outside}"));
        self.y_px += 3.0;
    }

    fn experiments(&mut self, contents: &Contents) {
        self.heading("Experiments");
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
            let text = format!("{} not shown", contents.n_experiments_elsewhere);
            self.row(None, &text);
        }
    }
}
