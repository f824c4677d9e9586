//! What the keys do and what the words mean, over everything else.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;

use super::view::View;
use super::writing::write;

/// No line is longer than 54 letters, so that it fits on a screen of 60.
const LIVE: [&str; 3] = [
    "s          stop all robots, at once, as `rsrs stop`;",
    "           `rsrs stop --release` lets the next run start",
    "↑ ↓ PgUp PgDn   scroll the robots",
];
const RECORDED: [&str; 4] = [
    "space      pause, go on; at the end: from the beginning",
    "← →        5 s back, forward; Home, End: begin, end",
    "+ -        faster, slower",
    "↑ ↓ PgUp PgDn   scroll the robots",
];
const WORDS: [&str; 12] = [
    "q Esc      quit; robots go on as they are",
    "sees       whether it detects another one, and what",
    "           else it reports; seconds: a sensor is silent",
    "det cmd pose    samples in a second",
    "lease      what the runner lets it do; other: it obeys",
    "           another run, or none",
    "no lease, no ctrl    it stands because its lease, or",
    "           its controller, stays away",
    "the swarm  the judge's numbers over the last minute;",
    "           green as the wanted phase has them, the mark",
    "           is its bound; `rsrs label` decides",
    "any key closes this",
];

pub fn draw(view: &View<'_>, area: Rect, buffer: &mut Buffer) {
    let keys = if view.timeline.is_some() { &RECORDED[..] } else { &LIVE[..] };
    let lines: Vec<&str> = keys.iter().chain(&WORDS).copied().collect();
    let longest = lines.iter().map(|line| line.chars().count()).max().unwrap_or(0);
    let width = u16::try_from(longest + 4).unwrap_or(u16::MAX).min(area.width);
    let height = u16::try_from(lines.len() + 2).unwrap_or(u16::MAX).min(area.height);
    let frame = Rect {
        x: area.x + (area.width - width) / 2,
        y: area.y + (area.height - height) / 2,
        width,
        height,
    };
    let look = view.look;
    let [left, right] = [look.sign("│", "|"); 2];
    let edge = look.sign("─", "-").repeat(usize::from(width) - 2);
    let corners =
        [("╭", "╮"), ("╰", "╯")].map(|(left, right)| (look.sign(left, "+"), look.sign(right, "+")));
    for row in 0..height {
        let inside = " ".repeat(usize::from(width));
        write(buffer, frame, (0, row), &inside, Style::reset());
        let line = if row == 0 {
            format!("{}{edge}{}", corners[0].0, corners[0].1)
        } else if row == height - 1 {
            format!("{}{edge}{}", corners[1].0, corners[1].1)
        } else {
            format!("{left}{}{right}", " ".repeat(usize::from(width) - 2))
        };
        write(buffer, frame, (0, row), &line, look.quiet());
    }
    let inner = Rect { x: frame.x + 2, y: frame.y + 1, width: width - 4, height: height - 2 };
    for (row, line) in (0..).zip(lines) {
        let line = match look.signs {
            super::look::Signs::Unicode => line.to_owned(),
            super::look::Signs::Ascii => line
                .replace('↑', "up")
                .replace('↓', "down")
                .replace('←', "left")
                .replace('→', "right"),
        };
        write(buffer, inner, (0, row), &line, Style::new());
    }
}
