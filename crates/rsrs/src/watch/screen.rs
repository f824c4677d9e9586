//! The whole screen: what is where at which size.

use ratatui::buffer::Buffer;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::Style;

use super::view::{Banner, View};
use super::writing::write;
use super::{arena, bottom, help, order, table, top};

/// A narrower screen has the table alone.
const LEAST_FOR_BOTH: u16 = 52;
/// The arena and the order parameters need as many columns.
const LEAST_RIGHT: u16 = 26;
/// Nothing can be read on less.
const LEAST: (u16, u16) = (24, 6);

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
