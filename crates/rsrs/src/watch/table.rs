//! The robots, one row each.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use rsrs_fleet::message::StopCause;
use rsrs_fleet::observation::{Condition, LeaseView, ObservedRobot, Seen};
use rsrs_fleet::timing::{NODE_TIMEOUT, SENSOR_TIMEOUT};

use super::look::strong;
use super::view::View;
use super::writing::{clipped, write};

/// A column; those that come first in the order of [`Column::ALL`] stay when there is less room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    Name,
    State,
    Sees,
    Detections,
    Commands,
    Poses,
    Command,
    Battery,
    Lease,
    Why,
}

/// The longest name that is written out.
const LONGEST_NAME: usize = 16;
/// The longest list of readings that is.
const LONGEST_SIGHT: usize = 16;

impl Column {
    const ALL: [Self; 10] = [
        Self::Name,
        Self::State,
        Self::Sees,
        Self::Detections,
        Self::Commands,
        Self::Poses,
        Self::Command,
        Self::Battery,
        Self::Lease,
        Self::Why,
    ];

    fn title(self) -> &'static str {
        match self {
            Self::Name => "robot",
            Self::State => "state",
            Self::Sees => "sees",
            Self::Detections => "det",
            Self::Commands => "cmd",
            Self::Poses => "pose",
            Self::Command => "m/s   rad/s",
            Self::Battery => "batt",
            Self::Lease => "lease",
            Self::Why => "why it stands",
        }
    }

    fn width(self, view: &View<'_>) -> usize {
        match self {
            Self::Name => {
                let names = view.observation.robots().map(|(name, _)| name.chars().count());
                names.max().unwrap_or(0).clamp(self.title().len(), LONGEST_NAME)
            }
            Self::State | Self::Lease => 8,
            Self::Sees => {
                let robots = view.observation.robots();
                let names = robots.map(|(_, robot)| longest_sight(view, robot));
                names.max().unwrap_or(0).clamp(self.title().len(), LONGEST_SIGHT)
            }
            Self::Detections | Self::Commands | Self::Poses => 5,
            Self::Command => 11,
            Self::Battery => 6,
            Self::Why => 30,
        }
    }

    fn is_right_aligned(self) -> bool {
        matches!(
            self,
            Self::Detections | Self::Commands | Self::Poses | Self::Command | Self::Battery
        )
    }
}

/// The columns for which there is room.
fn columns(view: &View<'_>, room: usize) -> Vec<(Column, usize)> {
    let has_battery = view.observation.robots().any(|(_, robot)| robot.battery_v().is_some());
    let mut left = room;
    let mut columns = Vec::new();
    for column in Column::ALL {
        if column == Column::Battery && !has_battery {
            continue;
        }
        let width = column.width(view);
        if width + 1 > left {
            break;
        }
        left -= width + 1;
        columns.push((column, width));
    }
    columns
}

/// How many columns of the screen it takes, of so many at most.
pub fn width(view: &View<'_>, most: u16) -> u16 {
    let columns = columns(view, usize::from(most));
    let all: usize = columns.iter().map(|(_, width)| width + 1).sum();
    u16::try_from(all).map_or(most, |all| all.min(most))
}

/// Draws the table, and counts for how many robots there is room.
pub fn draw(view: &View<'_>, area: Rect, buffer: &mut Buffer) -> usize {
    let columns = columns(view, usize::from(area.width));
    let head: Vec<Cell> =
        columns.iter().map(|(column, _)| (column.title().to_owned(), view.look.quiet())).collect();
    draw_row(view, area, 0, (&columns, head), buffer);

    let n_robots = view.observation.n_robots();
    let room = usize::from(area.height.saturating_sub(1));
    if n_robots == 0 && room > 0 {
        let text = clipped("looking for robots", usize::from(area.width) - 1, view.look);
        write(buffer, area, (0, 1), &text, view.look.waiting());
        return room;
    }
    let n_rows = if n_robots <= room { n_robots } else { room.saturating_sub(1) };
    let first = view.first_row.min(n_robots - n_rows);
    for (row, (name, robot)) in view.observation.robots().skip(first).take(n_rows).enumerate() {
        let cells = columns.iter().map(|(column, _)| cell(view, *column, name, robot)).collect();
        draw_row(view, area, row + 1, (&columns, cells), buffer);
    }
    if n_rows < n_robots {
        let more = n_robots - first - n_rows;
        let arrows = view.look.sign("↑↓", "up/down");
        let text = if more > 0 {
            format!("and {more} more: {arrows}")
        } else {
            format!("and {first} before: {arrows}")
        };
        let y = u16::try_from(room).unwrap_or(u16::MAX);
        write(buffer, area, (0, y), &text, view.look.waiting());
    }
    n_rows
}

type Cell = (String, Style);

fn draw_row(
    view: &View<'_>,
    area: Rect,
    row: usize,
    (columns, cells): (&[(Column, usize)], Vec<Cell>),
    buffer: &mut Buffer,
) {
    let Ok(y) = u16::try_from(row) else { return };
    let mut x = 0;
    for ((column, width), (text, style)) in columns.iter().zip(cells) {
        let text = clipped(&text, *width, view.look);
        let text = if column.is_right_aligned() {
            format!("{text:>width$}")
        } else {
            format!("{text:<width$}")
        };
        write(buffer, area, (x, y), &text, style);
        x += u16::try_from(*width).unwrap_or(u16::MAX).saturating_add(1);
    }
}

fn cell(view: &View<'_>, column: Column, name: &str, robot: &ObservedRobot) -> Cell {
    let (look, now) = (view.look, view.now);
    let condition = robot.condition(now);
    match column {
        Column::Name => (name.to_owned(), Style::new()),
        Column::State => (condition.label().to_owned(), state_style(view, condition)),
        Column::Sees => sees(view, robot),
        Column::Detections => rate(view, robot.detection_rate.hz(now)),
        Column::Commands => rate(view, robot.command_rate.hz(now)),
        Column::Poses => rate(view, robot.pose_hz(now)),
        Column::Command => match robot.command {
            None => (look.sign("–", "-").to_owned(), look.quiet()),
            Some(seen) => {
                let is_old = seen.age(now) > NODE_TIMEOUT;
                let (speed, turn) = (seen.value.speed_m_s, seen.value.turn_rate_rad_s);
                let style = if is_old { look.quiet() } else { Style::new() };
                // Without a minus in front of a zero.
                (format!("{:>5.2} {:>5.2}", speed + 0.0, turn + 0.0), style)
            }
        },
        Column::Battery => {
            let volts = robot.battery_v().map(|volts| format!("{volts:.1} V"));
            (volts.unwrap_or_else(|| look.sign("–", "-").to_owned()), Style::new())
        }
        Column::Lease => {
            let lease = view.observation.lease_of(robot, now);
            let style = match lease {
                LeaseView::Holds(_) => Style::new(),
                LeaseView::None | LeaseView::NotNamed | LeaseView::OtherEpoch => look.quiet(),
            };
            (lease.label().to_owned(), style)
        }
        Column::Why => (why(robot, condition), state_style(view, condition)),
    }
}

/// Why it stands, in its own words.
fn why(robot: &ObservedRobot, condition: Condition) -> String {
    match (&robot.status, condition) {
        (Some(seen), Condition::Silent) => {
            format!("no status; before: {}", seen.value.state)
        }
        (Some(seen), _) => seen.value.stop_reason.clone(),
        (None, _) => "no status received".to_owned(),
    }
}

fn state_style(view: &View<'_>, condition: Condition) -> Style {
    if condition.is_alarming() {
        return view.look.alarm();
    }
    match condition {
        Condition::Moving => view.look.good(),
        Condition::Armed => view.look.waiting(),
        Condition::Stopped(StopCause::Latched) => strong(),
        _ => Style::new(),
    }
}

/// The width of all of its readings, if each were true.
fn longest_sight(view: &View<'_>, robot: &ObservedRobot) -> usize {
    let sign = view.look.sign("●", "yes").chars().count();
    sign + robot.further_readings().map(|(name, _)| 1 + name.chars().count()).sum::<usize>()
}

/// Whether it sees another one and which of its further readings are true, or for how long a sensor has been silent.
fn sees(view: &View<'_>, robot: &ObservedRobot) -> Cell {
    let look = view.look;
    let Some(seen) = robot.detection else {
        return (look.sign("–", "-").to_owned(), look.quiet());
    };
    let silence = |seen: Seen<bool>| {
        let age = seen.age(view.now);
        (age > SENSOR_TIMEOUT).then(|| format!("{} s", age.as_secs().min(99)))
    };
    if let Some(silence) = silence(seen) {
        return (silence, look.alarm());
    }
    let mut silent =
        robot.further_readings().filter_map(|(name, seen)| Some((name, silence(seen)?)));
    if let Some((name, silence)) = silent.next() {
        return (format!("{name} {silence}"), look.alarm());
    }
    let further = robot.further_readings().filter(|(_, seen)| seen.value);
    let further: String = further.flat_map(|(name, _)| [" ", name]).collect();
    let (sign, word, style) = match (seen.value, further.is_empty()) {
        (true, _) => ("●", "yes", look.seeing()),
        (false, false) => ("○", "no", look.seeing()),
        (false, true) => ("○", "no", look.quiet()),
    };
    (format!("{}{further}", look.sign(sign, word)), style)
}

fn rate(view: &View<'_>, hz: Option<f64>) -> Cell {
    match hz {
        None => (view.look.sign("–", "-").to_owned(), view.look.quiet()),
        Some(hz) if hz < 0.05 => ("0".to_owned(), view.look.quiet()),
        Some(hz) if hz < 99.95 => (format!("{hz:.1}"), Style::new()),
        Some(hz) => (format!("{hz:.0}"), Style::new()),
    }
}
