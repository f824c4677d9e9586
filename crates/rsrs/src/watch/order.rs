//! What the swarm does as a whole: its phase in words, and the order parameters behind it.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use rsrs_core::judge::behaviour::rule::Rules;
use rsrs_core::judge::order::Parameter;
use rsrs_fleet::observation::SwarmOrder;

use super::look::{Signs, strong};
use super::view::View;
use super::writing::{clipped, titled, write};

/// Those that are shown first, in this order.
const FIRST: [Parameter; 7] = [
    Parameter::CLUSTERED,
    Parameter::CIRCLINESS,
    Parameter::ROTATION,
    Parameter::ORBIT,
    Parameter::BLOCKED,
    Parameter::STUCK,
    Parameter::LOST,
];
/// Columns of a name, unless one is longer, and of a value after it.
const NAME: u16 = 11;
const VALUE: u16 = 5;
/// Eighths of a block, from none to all of it.
const BLOCKS: [&str; 9] = ["", "▏", "▎", "▍", "▌", "▋", "▊", "▉", "█"];

/// Those that the rules of its behaviour look at, and that are known.
fn parameters(order: &SwarmOrder) -> Vec<Parameter> {
    let rules = order.behaviour.rules();
    let others = Parameter::all().filter(|it| !FIRST.contains(it));
    let is_shown = |it: &Parameter| rules.ask_for(*it) && it.value(&order.evidence).is_some();
    FIRST.into_iter().chain(others).filter(is_shown).collect()
}

/// How many rows it takes.
pub fn height(view: &View<'_>) -> u16 {
    let n = view.order.as_ref().map_or(0, |order| parameters(order).len() + 1);
    2 + u16::try_from(n).unwrap_or(0)
}

pub fn draw(view: &View<'_>, area: Rect, buffer: &mut Buffer) {
    let area = titled(view.look, "the swarm", area, buffer);
    let Some(order) = &view.order else {
        let why = if view.observation.lacks_objects() {
            "is judged by objects that are not seen"
        } else {
            "has not moved yet"
        };
        write(buffer, area, (1, 0), why, view.look.quiet());
        return;
    };
    let rules = order.behaviour.rules();
    let phase_style = if order.phase == rules.wanted { view.look.good() } else { Style::new() };
    let phase = clipped(order.phase.title(), usize::from(area.width) - 1, view.look);
    write(buffer, area, (1, 0), &phase, phase_style.patch(strong()));
    let over = if order.is_whole() {
        format!("last {:.0} s", order.over_s)
    } else {
        format!("{:.0} of {:.0} s", order.over_s, order.behaviour.window().least_s())
    };
    let room = usize::from(area.width).saturating_sub(phase.chars().count() + 4);
    if over.chars().count() <= room {
        let at = area.width - u16::try_from(over.chars().count()).unwrap_or(0) - 1;
        write(buffer, area, (at, 0), &over, view.look.quiet());
    }
    let shown = parameters(order);
    let longest = shown.iter().map(|it| it.key().len()).max().unwrap_or(0);
    let name = NAME.max(u16::try_from(longest).unwrap_or(NAME));
    for (row, parameter) in (1..).zip(shown) {
        draw_parameter(view, (order, &rules, parameter), (area, row, name), buffer);
    }
    let radius = format!("mean radius {:.2} m", order.evidence.mean_radius_m);
    let below = u16::try_from(parameters(order).len()).unwrap_or(0) + 1;
    write(buffer, area, (1, below), &radius, view.look.quiet());
}

fn draw_parameter(
    view: &View<'_>,
    (order, rules, parameter): (&SwarmOrder, &Rules, Parameter),
    (area, row, name): (Rect, u16, u16),
    buffer: &mut Buffer,
) {
    let value = parameter.of(&order.evidence);
    let mut conditions = rules.of(rules.wanted).flat_map(|rule| &rule.conditions);
    let condition = conditions.find(|condition| condition.parameter == parameter);
    let style = match condition {
        Some(condition) if condition.holds(&order.evidence) => view.look.good(),
        _ => Style::new(),
    };
    write(buffer, area, (1, row), parameter.key(), Style::new());
    let value_at = (name + 1, row);
    if !parameter.unit().is_empty() {
        write(buffer, area, value_at, &parameter.with_unit(value), style);
        return;
    }
    write(buffer, area, value_at, &format!("{value:>4.2}"), style);
    let start = name + VALUE + 2;
    let width = area.width.saturating_sub(start + 1);
    if width < 4 || row >= area.height {
        return;
    }
    let bar = Rect { x: area.x + start, y: area.y + row, width, height: 1 };
    write(
        buffer,
        bar,
        (0, 0),
        &view.look.sign("·", ".").repeat(usize::from(width)),
        view.look.quiet(),
    );
    write(buffer, bar, (0, 0), &filled(view.look.signs, value, width), style);
    if let Some(bound) = rules.wanted_bound(parameter).filter(|bound| *bound > 0.005) {
        let at = eighths(bound, width) / 8;
        let at = u16::try_from(at).unwrap_or(0).min(width - 1);
        write(buffer, bar, (at, 0), view.look.sign("┃", "|"), strong());
    }
}

/// A share of so many letters, in eighths of one.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "it is clamped to a number of letters first"
)]
fn eighths(share: f64, width: u16) -> usize {
    // What is not a number fills nothing.
    (share.clamp(0.0, 1.0) * f64::from(width) * 8.0).round() as usize
}

fn filled(signs: Signs, share: f64, width: u16) -> String {
    let eighths = eighths(share, width);
    match signs {
        Signs::Unicode => BLOCKS[8].repeat(eighths / 8) + BLOCKS[eighths % 8],
        Signs::Ascii => "#".repeat((eighths + 4) / 8),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bar_is_as_long_as_its_share() {
        assert_eq!(filled(Signs::Unicode, 0.5, 8), "████");
        assert_eq!(filled(Signs::Unicode, 0.55, 8), "████▍");
        assert_eq!(filled(Signs::Ascii, 0.55, 8), "####");
        assert_eq!(filled(Signs::Unicode, 7.0, 4), "████");
        assert_eq!(filled(Signs::Unicode, f64::NAN, 4), "");
    }
}
