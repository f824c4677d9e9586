//! The floor from above: where robots are, where they head, and the way they came; and the walls of an arena that is no
//! plain square.

use std::collections::{BTreeMap, BTreeSet};

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use rsrs_core::conditions::Conditions;
use rsrs_core::robot::unicycle::Pose;
use rsrs_fleet::observation::{Condition, ObservedRobot};
use rsrs_fleet::timing::POSE_TIMEOUT;

use super::look::Signs;
use super::view::View;
use super::writing::{titled, write};

/// The way that robots came in so many seconds is shown.
const TRAIL_S: f64 = 6.0;
/// What is shown grows and shrinks by steps of this, so that it does not tremble, in metres.
const STEP_M: f64 = 0.5;
/// The least that is shown, in metres.
const LEAST_M: f64 = 1.0;
/// Letters are about twice as high as wide.
const ASPECT: f64 = 2.0;
/// Lengths of the scale, in metres.
const LENGTHS_M: [f64; 9] = [0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0];
/// The eight dots of a sign, by column and row.
const DOTS: [[u32; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];
/// Dots along one side of a wall; more are never shown.
const MOST_DOTS: f64 = 10_000.0;
/// The sign without a dot.
const NO_DOT: u32 = 0x2800;

/// Which part of the floor is shown, and how large.
struct Scale {
    /// The middle of what is shown, in metres.
    middle_m: (f64, f64),
    /// Height of a letter, in metres.
    row_m: f64,
    n_columns: f64,
    n_rows: f64,
}

impl Scale {
    /// All of these places in so many letters.
    fn new(places_m: &[(f64, f64)], n_columns: u16, n_rows: u16) -> Self {
        let bounds = |of: fn(&(f64, f64)) -> f64| {
            let least = places_m.iter().map(of).fold(f64::INFINITY, f64::min);
            let most = places_m.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
            let (low, high) = ((least / STEP_M).floor() * STEP_M, (most / STEP_M).ceil() * STEP_M);
            (f64::midpoint(low, high), (high - low).max(LEAST_M))
        };
        let ((x_m, width_m), (y_m, height_m)) = (bounds(|it| it.0), bounds(|it| it.1));
        let (n_columns, n_rows) = (f64::from(n_columns), f64::from(n_rows));
        // A letter at each side is left for what stands on the edge.
        let row_m =
            (height_m / (n_rows - 1.0).max(1.0)).max(width_m * ASPECT / (n_columns - 1.0).max(1.0));
        Self { middle_m: (x_m, y_m), row_m, n_columns, n_rows }
    }

    /// Where a place is, in letters from the upper left corner.
    fn at(&self, x_m: f64, y_m: f64) -> (f64, f64) {
        let column_m = self.row_m / ASPECT;
        (
            (x_m - self.middle_m.0) / column_m + self.n_columns / 2.0,
            (self.middle_m.1 - y_m) / self.row_m + self.n_rows / 2.0,
        )
    }

    /// The letter in which a place is, if it is shown.
    fn letter(&self, x_m: f64, y_m: f64) -> Option<(u16, u16)> {
        let (x, y) = self.at(x_m, y_m);
        Some((within(x, self.n_columns)?, within(y, self.n_rows)?))
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "it is between 0 and a number of letters"
)]
fn within(at: f64, n: f64) -> Option<u16> {
    (at >= 0.0 && at < n).then_some(at as u16)
}

pub fn draw(view: &View<'_>, area: Rect, buffer: &mut Buffer) {
    let area = titled(view.look, "from above", area, buffer);
    if area.height < 3 || area.width < 8 {
        return;
    }
    let robots: Vec<(&str, &ObservedRobot, Pose)> = view
        .observation
        .robots()
        .filter_map(|(name, robot)| {
            let pose = robot.pose(view.now).filter(|pose| pose.age(view.now) <= POSE_TIMEOUT)?;
            Some((name, robot, pose.value))
        })
        .collect();
    if robots.is_empty() {
        write(buffer, area, (1, 0), "no poses are received", view.look.quiet());
        return;
    }
    let trail = view.observation.trail(TRAIL_S);
    let poses = robots.iter().map(|(_, _, pose)| pose).chain(trail);
    let objects_m: Vec<[f64; 2]> = view.observation.objects_m().collect();
    let conditions = view.observation.conditions();
    let walls = conditions.map(Conditions::walls_drawn_m).unwrap_or_default();
    // A square around obstacles may be much wider than where robots are.
    let is_square = conditions.is_some_and(|conditions| conditions.world.arena.is_none());
    let around = walls.iter().skip(usize::from(is_square)).flatten().map(|[x, y]| (*x, *y));
    let around = around.chain(objects_m.iter().map(|[x, y]| (*x, *y)));
    let places_m: Vec<(f64, f64)> = poses.map(|pose| (pose.x_m, pose.y_m)).chain(around).collect();
    let floor = Rect { height: area.height - 1, ..area };
    let scale = Scale::new(&places_m, floor.width, floor.height);
    let on_walls = walls.iter().flat_map(|corners_m| along(corners_m, scale.row_m / 8.0));
    draw_dots(view, (&scale, on_walls), floor, buffer);
    if view.look.signs == Signs::Unicode {
        let trail = trail.iter().map(|pose| [pose.x_m, pose.y_m]);
        draw_dots(view, (&scale, trail), floor, buffer);
    }
    draw_objects(view, (&scale, &objects_m), floor, buffer);
    draw_robots(view, (&scale, &robots), floor, buffer);
    let bar = Rect { y: area.y + area.height - 1, height: 1, ..area };
    draw_bar(view, &scale, bar, buffer);
}

/// Places along the sides of a polygon, at most so far from each other, in metres.
fn along(corners_m: &[[f64; 2]], apart_m: f64) -> Vec<[f64; 2]> {
    let next = corners_m.iter().cycle().skip(1);
    let side = |([from_x, from_y], [to_x, to_y]): (&[f64; 2], &[f64; 2])| {
        let (x_m, y_m) = (to_x - from_x, to_y - from_y);
        let n = (libm::hypot(x_m, y_m) / apart_m).ceil().clamp(1.0, MOST_DOTS);
        let mut shares = Vec::new();
        let mut step = 0.0;
        while step < n {
            shares.push([from_x + x_m * step / n, from_y + y_m * step / n]);
            step += 1.0;
        }
        shares
    };
    corners_m.iter().zip(next).flat_map(side).collect()
}

/// The way that robots came, or walls, in dots.
fn draw_dots(
    view: &View<'_>,
    (scale, places_m): (&Scale, impl Iterator<Item = [f64; 2]>),
    area: Rect,
    buffer: &mut Buffer,
) {
    let mut letters: BTreeMap<(u16, u16), u32> = BTreeMap::new();
    for [x_m, y_m] in places_m {
        let (x, y) = scale.at(x_m, y_m);
        if let Some(letter) = scale.letter(x_m, y_m) {
            let column = usize::from(x.fract() >= 0.5);
            let row = usize::from(within(y.fract() * 4.0, 4.0).unwrap_or(3));
            *letters.entry(letter).or_default() |= DOTS[column][row];
        }
    }
    for (letter, dots) in letters {
        let sign = match view.look.signs {
            Signs::Unicode => char::from_u32(NO_DOT + dots).unwrap_or(' '),
            Signs::Ascii => '.',
        };
        write(buffer, area, letter, &sign.to_string(), view.look.quiet());
    }
}

/// Every object as a square.
fn draw_objects(
    view: &View<'_>,
    (scale, objects_m): (&Scale, &[[f64; 2]]),
    area: Rect,
    buffer: &mut Buffer,
) {
    let sign = match view.look.signs {
        Signs::Unicode => "▪",
        Signs::Ascii => "#",
    };
    for letter in objects_m.iter().filter_map(|[x_m, y_m]| scale.letter(*x_m, *y_m)) {
        write(buffer, area, letter, sign, Style::new());
    }
}

/// Every robot as an arrow, with its number where there is room.
fn draw_robots(
    view: &View<'_>,
    (scale, robots): (&Scale, &[(&str, &ObservedRobot, Pose)]),
    area: Rect,
    buffer: &mut Buffer,
) {
    let mut taken = BTreeSet::new();
    let mut drawn = Vec::new();
    for (name, robot, pose) in robots {
        let Some(letter) = scale.letter(pose.x_m, pose.y_m) else { continue };
        let style = style(view, robot);
        write(buffer, area, letter, arrow(view.look.signs, pose.heading_rad), style);
        taken.insert(letter);
        drawn.push((name, letter, style));
    }
    for (name, (x, y), style) in drawn {
        let number = number(name);
        let Ok(length) = u16::try_from(number.len()) else { continue };
        // To the right, or else to the left; with a letter between it and the next robot.
        let right = (x + 1 + length <= area.width).then_some(x + 1);
        let left = x.checked_sub(length);
        let is_free = |start: &u16| {
            let end = start + length;
            let beside = if *start > x { end } else { start.saturating_sub(1) };
            (*start..end).chain([beside]).filter(|at| *at != x).all(|at| !taken.contains(&(at, y)))
        };
        if let Some(start) = right.filter(is_free).or(left.filter(is_free)) {
            write(buffer, area, (start, y), number, style);
            taken.extend((start..start + length).map(|at| (at, y)));
        }
    }
}

/// The number at the end of a name, or else its last letter.
fn number(name: &str) -> &str {
    let letters = name.trim_end_matches(|sign: char| sign.is_ascii_digit());
    match &name[letters.len()..] {
        "" => name.char_indices().last().map_or("", |(at, _)| &name[at..]),
        number => number,
    }
}

fn style(view: &View<'_>, robot: &ObservedRobot) -> Style {
    let condition = robot.condition(view.now);
    if condition.is_alarming() {
        view.look.alarm()
    } else if robot.detects(view.now) == Some(true) {
        view.look.seeing()
    } else if condition == Condition::Moving {
        view.look.good()
    } else {
        Style::new()
    }
}

/// An arrow along a heading; in plain signs in one of four directions.
fn arrow(signs: Signs, heading_rad: f64) -> &'static str {
    let arrows: &[&str] = match signs {
        Signs::Unicode => &["→", "↗", "↑", "↖", "←", "↙", "↓", "↘"],
        Signs::Ascii => &[">", "^", "<", "v"],
    };
    let n = arrows.len() as f64;
    let turns = (heading_rad / std::f64::consts::TAU).rem_euclid(1.0);
    let index = within((turns * n + 0.5).rem_euclid(n), n).unwrap_or(0);
    arrows[usize::from(index)]
}

/// A length to compare with.
fn draw_bar(view: &View<'_>, scale: &Scale, area: Rect, buffer: &mut Buffer) {
    let column_m = scale.row_m / ASPECT;
    let fits = |length_m: &&f64| *length_m / column_m <= scale.n_columns / 3.0;
    let Some(length_m) = LENGTHS_M.iter().rev().find(fits) else { return };
    let Some(n) = within((length_m / column_m).round(), scale.n_columns) else { return };
    let inner = usize::from(n.saturating_sub(1));
    let bar = match view.look.signs {
        Signs::Unicode => format!("├{}┤ {length_m} m", "─".repeat(inner)),
        Signs::Ascii => format!("|{}| {length_m} m", "-".repeat(inner)),
    };
    write(buffer, area, (0, 0), &bar, view.look.quiet());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrows_point_along_the_heading_counterclockwise_from_the_right() {
        use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
        let arrow = |heading_rad| arrow(Signs::Unicode, heading_rad);

        let found = [0.0, FRAC_PI_4, FRAC_PI_2, PI, -FRAC_PI_2, 2.0 * PI - 0.1].map(arrow);

        assert_eq!(found, ["→", "↗", "↑", "←", "↓", "→"]);
    }

    #[test]
    fn robots_have_their_numbers_or_their_last_letters() {
        assert_eq!(["robot_12", "anna", "7"].map(number), ["12", "a", "7"]);
    }

    #[test]
    fn all_places_are_shown_whatever_the_size_and_lengths_are_the_same_both_ways() {
        let places_m = [(-0.7, 0.1), (1.9, -3.2), (0.0, 2.6)];
        for (n_columns, n_rows) in [(8, 2), (26, 9), (90, 40), (200, 5)] {
            let scale = Scale::new(&places_m, n_columns, n_rows);

            for (x_m, y_m) in places_m {
                assert!(scale.letter(x_m, y_m).is_some(), "{n_columns} x {n_rows}: {x_m}, {y_m}");
            }
            let (origin, east) = (scale.at(0.0, 0.0), scale.at(1.0, 0.0));
            let north = scale.at(0.0, 1.0);
            let (columns, rows) = (east.0 - origin.0, origin.1 - north.1);
            assert!((columns - ASPECT * rows).abs() < 1e-9);
        }
    }
}
