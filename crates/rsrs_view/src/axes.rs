//! The frame of a phase diagram, with ticks at the swept values and labels with units.

use rsrs_core::quantity::Axis;

use crate::chart::{BELOW_PX, NAME_PX, TICK_PX, tick_lines, tick_texts};
use crate::palette::INK;
use crate::plot::Plot;
use crate::scale::{Scale, widest_px};
use crate::slice::{Slice, is_same};
use crate::svg::{Element, centred_text, line_of_text, number, rectangle};

/// What the y-axis takes besides its numbers, in pixels.
const LABEL_ROOM_PX: f64 = 30.0;
/// From one label of the y-axis to the next at least.
const Y_ROOM_PX: f64 = 19.5;

/// Room for the y-axis left of cells that are `height_px` high together, in pixels.
pub fn left_of_cells_px(slice: &Slice, height_px: f64) -> f64 {
    let scale = Scale::new(slice.y_values.clone(), height_px, 0.0);
    let ticks = scale.ticks(|_| Y_ROOM_PX);
    let texts: Vec<String> = ticks.into_iter().map(|(_, text)| text).collect();
    LABEL_ROOM_PX + widest_px(&texts, TICK_PX)
}

/// Draws the frame, the ticks at the swept values and the labels of both axes.
pub fn axes(plot: &Plot, y: Axis) -> Element {
    let frame = rectangle(
        plot.left_px,
        plot.top_px,
        plot.right_px - plot.left_px,
        plot.bottom_px - plot.top_px,
    );
    let centre_px = f64::midpoint(plot.left_px, plot.right_px);
    let x_label = centred_text(centre_px, plot.bottom_px + BELOW_PX - 6.0, &plot.slice.x.label())
        .lettered(NAME_PX, INK);
    Element::new("g")
        .child(frame.outlined(INK, 1.0))
        .children(x_ticks(plot))
        .child(x_label)
        .children(y_ticks(plot))
        .child(y_label(plot, y))
}

fn y_label(plot: &Plot, y: Axis) -> Element {
    let height_px = plot.bottom_px - plot.top_px;
    let axis_px = left_of_cells_px(plot.slice, height_px);
    let x_px = plot.left_px - axis_px + 9.0;
    let y_px = f64::midpoint(plot.top_px, plot.bottom_px);
    centred_text(x_px, y_px, &y.label())
        .lettered(NAME_PX, INK)
        .with("transform", &format!("rotate(-90 {} {})", number(x_px), number(y_px)))
}

fn x_ticks(plot: &Plot) -> [Element; 2] {
    let ticks = plot.x.ticks(|labels| widest_px(labels, TICK_PX) + 8.0);
    let line = |value: f64, length_px: f64| {
        let x = number(plot.x.position_px(value));
        format!("M{x} {}v{}", number(plot.bottom_px), number(length_px))
    };
    let minor = unlabelled(&plot.x, &ticks).into_iter().map(|value| line(value, 3.0));
    let major = ticks.iter().map(|(value, _)| line(*value, 5.0));
    let texts = ticks
        .iter()
        .map(|(value, text)| line_of_text(plot.x.position_px(*value), plot.bottom_px + 18.0, text));
    let lines: Vec<String> = minor.chain(major).collect();
    [tick_lines(&lines.concat()), tick_texts("middle").children(texts)]
}

fn y_ticks(plot: &Plot) -> [Element; 2] {
    let ticks = plot.y.ticks(|_| Y_ROOM_PX);
    let line = |value: f64, length_px: f64| {
        let y = number(plot.y.position_px(value));
        format!("M{} {y}h{}", number(plot.left_px), number(-length_px))
    };
    let minor = unlabelled(&plot.y, &ticks).into_iter().map(|value| line(value, 3.0));
    let major = ticks.iter().map(|(value, _)| line(*value, 5.0));
    let texts = ticks.iter().map(|(value, text)| {
        let baseline_px = plot.y.position_px(*value) + 0.36 * TICK_PX;
        line_of_text(plot.left_px - 9.0, baseline_px, text)
    });
    let lines: Vec<String> = minor.chain(major).collect();
    [tick_lines(&lines.concat()), tick_texts("end").children(texts)]
}

/// The swept values without a label; none beside round numbers, which would fall between them.
fn unlabelled(scale: &Scale, ticks: &[(f64, String)]) -> Vec<f64> {
    let is_labelled = |value: f64| ticks.iter().any(|(tick, _)| is_same(*tick, value));
    let n_labelled = scale.values.iter().filter(|value| is_labelled(**value)).count();
    if n_labelled < ticks.len() {
        return Vec::new();
    }
    scale.values.iter().copied().filter(|value| !is_labelled(*value)).collect()
}
