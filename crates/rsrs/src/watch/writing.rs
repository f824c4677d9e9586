//! Texts in an area of the screen.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;

use super::look::{Look, strong};

/// Writes a line of text into an area; what does not fit is cut off.
pub fn write(buffer: &mut Buffer, area: Rect, (x, y): (u16, u16), text: &str, style: Style) {
    if x < area.width && y < area.height {
        let room = usize::from(area.width - x);
        buffer.set_stringn(area.x + x, area.y + y, text, room, style);
    }
}

/// A title with a line to the right edge, in the first row of an area, of which the rest is left.
pub fn titled(look: Look, title: &str, area: Rect, buffer: &mut Buffer) -> Rect {
    if area.height == 0 {
        return area;
    }
    let line = look.sign("─", "-").repeat(usize::from(area.width));
    write(buffer, area, (0, 0), &line, look.quiet());
    write(buffer, area, (1, 0), &format!(" {title} "), strong());
    Rect { y: area.y + 1, height: area.height - 1, ..area }
}

/// A text in so many letters at most; where it does not fit it ends in a sign of that.
pub fn clipped(text: &str, width: usize, look: Look) -> String {
    if text.chars().count() <= width {
        return text.to_owned();
    }
    let end = look.sign("…", "~");
    let kept: String = text.chars().take(width.saturating_sub(1)).collect();
    if width == 0 { String::new() } else { kept + end }
}
