//! The head of the screen: where this comes from, which run it is, and what is wrong.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use rsrs_fleet::message::LeaseState;
use rsrs_fleet::observation::{Condition, RunView};

use super::look::strong;
use super::view::View;
use super::writing::{clipped, write};

pub fn draw(view: &View<'_>, area: Rect, buffer: &mut Buffer) {
    let look = view.look;
    let name = " rsrs watch ";
    let (counts, style) = counts(view);
    let n_counts = counts.chars().count();
    let width = usize::from(area.width);
    let room = width.saturating_sub(name.len() + n_counts + 3);
    write(buffer, area, (0, 0), name, strong());
    write(buffer, area, (column(name.len()), 0), &clipped(view.place, room, look), Style::new());
    write(buffer, area, (column(width.saturating_sub(n_counts + 1)), 0), &counts, style);

    let (run, style) = run(view);
    let alarm = e_stop(view).unwrap_or_default();
    let room = width.saturating_sub(alarm.chars().count() + 3);
    write(buffer, area, (1, 1), &clipped(&run, room, look), style);
    let at = column(width.saturating_sub(alarm.chars().count() + 1));
    write(buffer, area, (at, 1), &alarm, look.alarm());
}

/// A column; screens are narrower than numbers can be.
fn column(at: usize) -> u16 {
    u16::try_from(at).unwrap_or(u16::MAX)
}

/// How many robots there are, and what most people want to see of them first.
fn counts(view: &View<'_>) -> (String, Style) {
    let conditions: Vec<Condition> =
        view.observation.robots().map(|(_, robot)| robot.condition(view.now)).collect();
    let count = |of: &dyn Fn(Condition) -> bool| conditions.iter().filter(|it| of(**it)).count();
    let n_moving = count(&|it| it == Condition::Moving);
    let n_silent = count(&|it| it == Condition::Silent);
    let n_faults = count(&|it| it == Condition::Fault);
    let robots = match conditions.len() {
        0 => "no robots yet".to_owned(),
        1 => "1 robot".to_owned(),
        n => format!("{n} robots"),
    };
    let parts = [(n_moving, "moving"), (n_silent, "silent"), (n_faults, "in fault")];
    let parts = parts.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}"));
    let text = [robots].into_iter().chain(parts).collect::<Vec<_>>().join(", ");
    let is_alarm = n_silent + n_faults > 0;
    (text, if is_alarm { view.look.alarm() } else { strong() })
}

/// The run in a sentence.
fn run(view: &View<'_>) -> (String, Style) {
    let look = view.look;
    let Some(run) = view.observation.run(view.now) else {
        return ("no run: no lease is received".to_owned(), look.quiet());
    };
    let RunView { run_id, state, is_fresh, running_for, ending } = run;
    if let Some(ending) = ending.filter(|_| state == LeaseState::Stopped || !is_fresh) {
        let reason = &ending.reason;
        let reason = if reason.is_empty() { String::new() } else { format!(": {reason}") };
        return (format!("{} {run_id}{reason}", ending.kind.key()), strong());
    }
    let for_s = running_for.map(|running_for| running_for.as_secs_f64());
    let of =
        view.observation.duration_s().map_or_else(String::new, |all_s| format!(" of {all_s:.0}"));
    let time = for_s.map_or_else(String::new, |for_s| format!(" {for_s:.1}{of} s"));
    if !is_fresh {
        return (format!("lease lost{time} {run_id}"), look.alarm());
    }
    match state {
        LeaseState::Idle => (format!("preparing {run_id}"), look.waiting()),
        LeaseState::Armed => (format!("armed {run_id}"), look.waiting()),
        LeaseState::Running => (format!("RUNNING{time} {run_id}"), look.good()),
        LeaseState::Stopped => (format!("stopped{time} {run_id}"), strong()),
    }
}

fn e_stop(view: &View<'_>) -> Option<String> {
    let (n_held, n_robots) = (view.observation.n_held_by_e_stop(), view.observation.n_robots());
    if n_held > 0 {
        return Some(format!("E-STOP holds {n_held} of {n_robots}"));
    }
    let n_sources = view.observation.e_stop().len();
    (n_sources > 0).then(|| "E-STOP engaged".to_owned())
}
