//! A frame with two linear axes and round ticks.

use crate::palette::{INK, QUIET_INK};
use crate::scale::{labels, round_steps, widest_px};
use crate::svg::{Element, centred_text, line_of_text, number, rectangle, through};
use crate::text::{Weight, width_px, wrap};

/// Size of the numbers at the ticks, in pixels.
pub const TICK_PX: f64 = 11.0;
/// Size of the axes' names, in pixels.
pub const NAME_PX: f64 = 12.5;

/// Room for a mark of a legend, in pixels.
const MARK_PX: f64 = 30.0;
/// From one line of a text in a legend to the next, in pixels.
const LINE_PX: f64 = 14.0;

/// Room for the x-axis below a chart or the cells of a diagram, in pixels.
pub const BELOW_PX: f64 = 46.0;
/// Room for the y-axis left of a chart, in pixels.
pub const LEFT_PX: f64 = 64.0;

/// A rectangle on the page with values from left to right and from bottom to top.
#[derive(Clone, Copy, Debug)]
pub struct Chart {
    /// Left edge, in pixels.
    pub left_px: f64,
    /// Upper edge, in pixels.
    pub top_px: f64,
    /// Width, in pixels.
    pub width_px: f64,
    /// Height, in pixels.
    pub height_px: f64,
    /// Least and greatest value from left to right.
    pub x: [f64; 2],
    /// Least and greatest value from bottom to top.
    pub y: [f64; 2],
}

impl Chart {
    /// A chart that shows these values, in metres, as large as the room from its upper left corner
    /// on allows. A metre is as long to the right as upwards.
    pub fn to_scale(
        (left_px, top_px): (f64, f64),
        (widest_px, highest_px): (f64, f64),
        x: [f64; 2],
        y: [f64; 2],
    ) -> Self {
        let px_per_m = (widest_px / (x[1] - x[0])).min(highest_px / (y[1] - y[0]));
        let width_px = px_per_m * (x[1] - x[0]);
        let height_px = px_per_m * (y[1] - y[0]);
        Self { left_px, top_px, width_px, height_px, x, y }
    }

    /// Where a value lies from left to right, in pixels.
    pub fn x_px(&self, value: f64) -> f64 {
        self.left_px + self.width_px * (value - self.x[0]) / (self.x[1] - self.x[0])
    }

    /// Where a value lies from top to bottom, in pixels.
    pub fn y_px(&self, value: f64) -> f64 {
        self.top_px + self.height_px * (self.y[1] - value) / (self.y[1] - self.y[0])
    }

    /// Lower edge, in pixels.
    pub fn bottom_px(&self) -> f64 {
        self.top_px + self.height_px
    }

    /// A closed line through points, as an SVG path.
    pub fn polygon(&self, points: &[[f64; 2]]) -> String {
        format!("{}Z", through(points.iter().map(|[x, y]| (self.x_px(*x), self.y_px(*y)))))
    }

    /// The frame with ticks and name of the x-axis.
    pub fn frame(&self, x_name: &str) -> Element {
        let border =
            rectangle(self.left_px, self.top_px, self.width_px, self.height_px).outlined(INK, 1.0);
        let ticks = self.x_ticks();
        let bottom_px = self.bottom_px();
        let lines: String = ticks
            .iter()
            .map(|(value, _)| format!("M{} {}v5", number(self.x_px(*value)), number(bottom_px)))
            .collect::<Vec<_>>()
            .concat();
        let texts = ticks
            .iter()
            .map(|(value, text)| line_of_text(self.x_px(*value), bottom_px + 18.0, text));
        let name = centred_text(self.left_px + self.width_px / 2.0, bottom_px + 38.0, x_name)
            .lettered(NAME_PX, INK);
        Element::new("g")
            .child(border)
            .child(tick_lines(&lines))
            .child(tick_texts("middle").children(texts))
            .child(name)
    }

    fn x_ticks(&self) -> Vec<(f64, String)> {
        ticks(self.x, |texts| self.width_px / (widest_px(texts, TICK_PX) + 12.0))
    }

    /// How far the last number below reaches beyond the right edge, in pixels.
    pub fn overhang_px(&self) -> f64 {
        let Some((value, text)) = self.x_ticks().pop() else { return 0.0 };
        let right_px = self.x_px(value) + width_px(&text, TICK_PX, Weight::Regular) / 2.0;
        (right_px - self.left_px - self.width_px).max(0.0)
    }

    /// Ticks and name of the y-axis, which may be empty.
    pub fn y_axis(&self, y_name: &str) -> Element {
        let ticks = ticks(self.y, |_| self.height_px / 20.0);
        let lines: String = ticks
            .iter()
            .map(|(value, _)| format!("M{} {}h-5", number(self.left_px), number(self.y_px(*value))))
            .collect::<Vec<_>>()
            .concat();
        let texts = ticks.iter().map(|(value, text)| {
            line_of_text(self.left_px - 9.0, self.y_px(*value) + 0.36 * TICK_PX, text)
        });
        let (x_px, y_px) = (self.left_px - 46.0, self.top_px + self.height_px / 2.0);
        let name = centred_text(x_px, y_px, y_name)
            .lettered(NAME_PX, INK)
            .with("transform", &format!("rotate(-90 {} {})", number(x_px), number(y_px)));
        Element::new("g")
            .child(tick_lines(&lines))
            .child(tick_texts("end").children(texts))
            .children((!y_name.is_empty()).then_some(name))
    }
}

/// The strokes at the ticks of an axis.
pub fn tick_lines(path: &str) -> Element {
    Element::path(path).stroked(INK, 1.0)
}

/// The numbers at the ticks of an axis.
pub fn tick_texts(anchor: &str) -> Element {
    Element::new("g").at("font-size", TICK_PX).with("text-anchor", anchor).with("fill", QUIET_INK)
}

/// Multiples of the smallest 1, 2 or 5 times a power of ten of which there are few enough.
fn ticks([low, high]: [f64; 2], most: impl Fn(&[String]) -> f64) -> Vec<(f64, String)> {
    for step in round_steps([low, high]) {
        let first = libm::ceil(low / step - 1e-9);
        let values: Vec<f64> = (0..200)
            .map(|index| (first + f64::from(index)) * step)
            .take_while(|value| *value <= high + 1e-9 * step)
            .collect();
        let texts = labels(&values);
        if (values.len() as f64) <= most(&texts) {
            return values.into_iter().zip(texts).collect();
        }
    }
    Vec::new()
}

/// A mark and what it means, one below the other, each text wrapped so that mark and text are at
/// most `room_px` wide; and where they end below, in pixels.
pub fn legend(
    entries: &[(Element, String)],
    (left_px, top_px): (f64, f64),
    room_px: f64,
) -> (Vec<Element>, f64) {
    let mut elements = Vec::new();
    let mut y_px = top_px;
    for (mark, text) in entries {
        y_px += 17.0;
        elements.push(Element::new("g").moved((left_px, y_px)).child(mark.clone()));
        let lines = wrap(text, TICK_PX, Weight::Regular, room_px - MARK_PX);
        let texts = lines.iter().enumerate().map(|(index, line)| {
            let baseline_px = y_px + 4.0 + index as f64 * LINE_PX;
            line_of_text(left_px + MARK_PX, baseline_px, line).lettered(TICK_PX, INK)
        });
        elements.extend(texts);
        y_px += lines.len().saturating_sub(1) as f64 * LINE_PX;
    }
    (elements, y_px + 8.0)
}

/// A short stroke for a legend, from the left of its line.
pub fn stroke_mark(stroke: &str, width_px: f64) -> Element {
    Element::path("M0 0h22").stroked(stroke, width_px)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few_enough() {
        let ticks = ticks([-0.13, 0.42], |_| 6.0);

        let texts: Vec<&str> = ticks.iter().map(|(_, text)| text.as_str()).collect();
        assert_eq!(texts, ["\u{2212}0.1", "0.0", "0.1", "0.2", "0.3", "0.4"]);
    }

    #[test]
    fn a_chart_to_scale_has_one_scale() {
        let chart = Chart::to_scale((10.0, 20.0), (400.0, 300.0), [0.0, 2.0], [-1.0, 1.0]);

        assert!((chart.width_px - 300.0).abs() < 1e-9 && (chart.height_px - 300.0).abs() < 1e-9);
        assert!((chart.x_px(1.0) - 160.0).abs() < 1e-9 && (chart.y_px(1.0) - 20.0).abs() < 1e-9);
    }
}
