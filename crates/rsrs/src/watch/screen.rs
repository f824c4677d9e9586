//! The whole screen: what is where at which size.

use std::time::Duration;

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;
use rsrs_core::printable::one_line;
use rsrs_fleet::observation::{Observation, SwarmOrder};

use super::look::{BannerKind, Look, strong};
use super::{arena, bottom, help, order, table, top};

/// A narrower screen has the table alone.
const LEAST_FOR_BOTH: u16 = 52;
/// The arena and the order parameters need as many columns.
const LEAST_RIGHT: u16 = 26;
/// Nothing can be read on less.
const LEAST: (u16, u16) = (24, 6);

/// What is on the screen.
pub struct View<'a> {
    /// What is seen.
    pub observation: &'a Observation,
    /// The time of it.
    pub now: Duration,
    /// Order parameters and phase; `None` while nothing has moved.
    pub order: Option<SwarmOrder>,
    /// Where it comes from: an interface, or a bag.
    pub place: &'a str,
    /// How far a recording is; `None` for a fleet that runs.
    pub timeline: Option<Timeline>,
    /// A line that nobody should overlook.
    pub banner: Option<Banner>,
    /// The first row of the table, if it does not fit.
    pub first_row: usize,
    /// Whether the keys, and what the words mean, lie over all.
    pub shows_help: bool,
    pub look: Look,
}

/// How far a recording is.
#[derive(Clone, Copy, Debug)]
pub struct Timeline {
    /// From its beginning.
    pub at: Duration,
    /// All of it.
    pub duration: Duration,
    /// Seconds of it in one second.
    pub pace: f64,
    /// Whether it goes on.
    pub state: PlayState,
}

/// Whether a recording goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlayState {
    Plays,
    Paused,
    /// It is at its end.
    Over,
}

/// A line that nobody should overlook.
#[derive(Clone, Debug)]
pub struct Banner {
    pub text: String,
    /// What it is about.
    pub kind: BannerKind,
}

impl Banner {
    /// What robots say is wrong with them; `None` if none does.
    pub fn of_faults(observation: &Observation, now: Duration) -> Option<Self> {
        let mut faults = observation.faults(now);
        let (robot, part, message) = faults.next()?;
        let whose = if part.contains(robot) { String::new() } else { format!("{robot}: ") };
        let more = match faults.count() {
            0 => String::new(),
            n => format!(", and {n} more"),
        };
        let text = format!("{whose}{part}: {message}{more}");
        Some(Self { text: one_line(&text).into_owned(), kind: BannerKind::Alarm })
    }
}

/// Draws everything, and counts for how many robots the table has room, by which it is scrolled.
pub fn draw(view: &View<'_>, area: Rect, buffer: &mut Buffer) -> usize {
    if area.width < LEAST.0 || area.height < LEAST.1 {
        let text = format!("at least {} by {} letters are needed", LEAST.0, LEAST.1);
        write(buffer, area, (0, 0), &text, Style::new());
        return 0;
    }
    let banner_height = u16::from(view.banner.is_some());
    let bottom_height = if view.timeline.is_some() { 2 } else { 1 };
    let [head, banner, body, foot] = Layout::vertical([
        Constraint::Length(2),
        Constraint::Length(banner_height),
        Constraint::Min(1),
        Constraint::Length(bottom_height),
    ])
    .areas(area);
    top::draw(view, head, buffer);
    if let Some(Banner { text, kind }) = &view.banner {
        let style = view.look.banner(*kind);
        buffer.set_style(banner, style);
        write(buffer, banner, (1, 0), text, style);
    }
    let n_rows = draw_body(view, body, buffer);
    bottom::draw(view, foot, buffer);
    if view.shows_help {
        help::draw(view, area, buffer);
    }
    n_rows
}

fn draw_body(view: &View<'_>, body: Rect, buffer: &mut Buffer) -> usize {
    if body.width < LEAST_FOR_BOTH {
        return table::draw(view, body, buffer);
    }
    let most = (body.width * 6 / 10).min(body.width - LEAST_RIGHT - 1);
    let left_width = table::width(view, most);
    let [left, _, right] = Layout::horizontal([
        Constraint::Length(left_width),
        Constraint::Length(1),
        Constraint::Min(1),
    ])
    .areas(body);
    let order_height = order::height(view).min(right.height.saturating_sub(6));
    let [above, below] =
        Layout::vertical([Constraint::Min(1), Constraint::Length(order_height)]).areas(right);
    arena::draw(view, above, buffer);
    order::draw(view, below, buffer);
    table::draw(view, left, buffer)
}

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
