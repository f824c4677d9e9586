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
