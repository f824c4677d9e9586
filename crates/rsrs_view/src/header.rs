//! The lines above a picture: what it shows.

use crate::palette::{INK, QUIET_INK};
use crate::svg::{Element, line_of_text};
use crate::text::{Weight, wrap};
use crate::theme::Theme;

/// Around a page, in pixels; around one whose width is given for print it is [`NARROW_MARGIN_PX`].
///
/// [`NARROW_MARGIN_PX`]: crate::arrangement::NARROW_MARGIN_PX
pub const MARGIN_PX: f64 = 24.0;
const TITLE_PX: f64 = 16.0;
const SUBTITLE_PX: f64 = 11.5;
/// Height of the letters above one of several panels, in pixels.
pub const HEADING_PX: f64 = 12.5;
/// From one line of a heading to the next.
const HEADING_LINE_PX: f64 = 15.0;
/// Above a picture in a paper.
const PAPER_PX: f64 = 4.0;

/// Draws a title and smaller lines under it, each wrapped to the room there is, and finds where they end
/// below, in pixels; draws nothing in a paper.
pub fn header(
    theme: Theme,
    title: &str,
    subtitles: &[impl AsRef<str>],
    left_px: f64,
    room_px: f64,
) -> (Vec<Element>, f64) {
    if theme == Theme::Paper {
        return (Vec::new(), PAPER_PX);
    }
    let mut texts = Vec::new();
    let mut y_px = 14.0;
    for line in wrap(title, TITLE_PX, Weight::Bold, room_px) {
        y_px += TITLE_PX * 1.25;
        let text = line_of_text(left_px, y_px, &line).bold(TITLE_PX, INK);
        texts.push(text);
    }
    y_px += 2.0;
    for subtitle in subtitles {
        let (lines, end_px) = quiet_lines(subtitle.as_ref(), SUBTITLE_PX, (left_px, y_px), room_px);
        texts.extend(lines);
        y_px = end_px;
    }
    (texts, y_px + 4.0)
}

/// The heading of one of several panels, in lines that leave its room.
#[derive(Clone, Debug)]
pub struct Heading {
    lines: Vec<String>,
}

impl Heading {
    /// Wraps a heading to the room there is, in pixels; an empty one has no lines.
    pub fn new(text: &str, room_px: f64) -> Self {
        Self { lines: wrap(text, HEADING_PX, Weight::Bold, room_px) }
    }

    /// What it takes from the baseline of its last line upwards, in pixels; of an empty one 0.
    pub fn height_px(&self) -> f64 {
        match self.lines.len() {
            0 => 0.0,
            n => HEADING_PX + (n - 1) as f64 * HEADING_LINE_PX,
        }
    }

    /// Draws it from its left edge, its last line on a baseline, in pixels.
    pub fn drawn(&self, left_px: f64, baseline_px: f64) -> Vec<Element> {
        let line = |(below, line): (usize, &String)| {
            let y_px = baseline_px - below as f64 * HEADING_LINE_PX;
            line_of_text(left_px, y_px, line).bold(HEADING_PX, INK)
        };
        let mut lines: Vec<Element> = self.lines.iter().rev().enumerate().map(line).collect();
        lines.reverse();
        lines
    }
}

/// Draws a text of quiet letters below a place, wrapped to the room there is, and finds where it ends
/// below, in pixels.
pub fn quiet_lines(
    text: &str,
    size_px: f64,
    (left_px, top_px): (f64, f64),
    room_px: f64,
) -> (Vec<Element>, f64) {
    let mut y_px = top_px;
    let mut texts = Vec::new();
    for line in wrap(text, size_px, Weight::Regular, room_px) {
        y_px += size_px * 1.45;
        texts.push(line_of_text(left_px, y_px, &line).lettered(size_px, QUIET_INK));
    }
    (texts, y_px)
}
