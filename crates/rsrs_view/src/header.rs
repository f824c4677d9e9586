//! The lines above a picture: what it shows.

use crate::palette::{INK, QUIET_INK};
use crate::svg::{Element, line_of_text};
use crate::text::{Weight, wrap};
use crate::theme::Theme;

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
        for line in wrap(subtitle.as_ref(), SUBTITLE_PX, Weight::Regular, room_px) {
            y_px += SUBTITLE_PX * 1.45;
            let text = line_of_text(left_px, y_px, &line).lettered(SUBTITLE_PX, QUIET_INK);
            texts.push(text);
        }
    }
    (texts, y_px + 4.0)
}
