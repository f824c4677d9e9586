//! The foot of the screen: how far a recording is, and the keys.

use std::time::Duration;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;

use super::look::strong;
use super::view::{PlayState, Timeline, View};
use super::writing::write;

/// Keys and what they do, those first that stay where there is little room.
const LIVE: [(&str, &str); 4] =
    [("s", "stop all robots"), ("q", "quit"), ("?", "help"), ("up down", "scroll")];
const RECORDED: [(&str, &str); 6] = [
    ("space", "pause"),
    ("q", "quit"),
    ("left right", "5 s"),
    ("+ -", "pace"),
    ("?", "help"),
    ("up down", "scroll"),
];

pub fn draw(view: &View<'_>, area: Rect, buffer: &mut Buffer) {
    let keys = match &view.timeline {
        None => &LIVE[..],
        Some(timeline) => {
            draw_timeline(view, timeline, area, buffer);
            &RECORDED[..]
        }
    };
    let row = area.height - 1;
    let mut x = 1;
    for (key, what) in keys {
        let key = match *key {
            "up down" => view.look.sign("↑↓", "up down"),
            "left right" => view.look.sign("←→", "left right"),
            key => key,
        };
        let length = u16::try_from(key.chars().count() + 1 + what.len()).unwrap_or(u16::MAX);
        if x + length > area.width {
            break;
        }
        write(buffer, area, (x, row), key, strong());
        let after = x + length - u16::try_from(what.len()).unwrap_or(0);
        write(buffer, area, (after, row), what, view.look.quiet());
        x += length + 3;
    }
}

fn draw_timeline(view: &View<'_>, timeline: &Timeline, area: Rect, buffer: &mut Buffer) {
    let Timeline { at, duration, pace, state } = *timeline;
    let look = view.look;
    let sign = match state {
        PlayState::Plays => look.sign("▶", ">"),
        PlayState::Paused => look.sign("‖", "="),
        PlayState::Over => look.sign("■", "#"),
    };
    let left = format!("{sign} {}", minutes(at));
    let word = match state {
        PlayState::Plays => format!("x{pace}"),
        PlayState::Paused => "paused".to_owned(),
        PlayState::Over => "end".to_owned(),
    };
    let right = format!("{} {word:>6}", minutes(duration));
    let (n_left, n_right) = (left.chars().count(), right.chars().count());
    let width = usize::from(area.width).saturating_sub(n_left + n_right + 4);
    write(buffer, area, (1, 0), &left, strong());
    let share = if duration.is_zero() { 1.0 } else { at.as_secs_f64() / duration.as_secs_f64() };
    let n_done = (0..width).filter(|index| (*index as f64) < share * width as f64).count();
    let start = u16::try_from(n_left + 2).unwrap_or(0);
    let line = look.sign("─", "-").repeat(width);
    write(buffer, area, (start, 0), &line, look.quiet());
    let done = look.sign("━", "=").repeat(n_done);
    write(buffer, area, (start, 0), &done, look.waiting());
    let end = u16::try_from(n_left + width + 3).unwrap_or(0);
    write(buffer, area, (end, 0), &right, Style::new());
}

/// `1:02.3`.
fn minutes(time: Duration) -> String {
    let tenths = time.as_millis() / 100;
    format!("{}:{:02}.{}", tenths / 600, tenths / 10 % 60, tenths % 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_minutes_and_seconds() {
        let times = [0, 59_960, 62_300, 3_600_000].map(|ms| minutes(Duration::from_millis(ms)));

        assert_eq!(times, ["0:00.0", "0:59.9", "1:02.3", "60:00.0"]);
    }
}
