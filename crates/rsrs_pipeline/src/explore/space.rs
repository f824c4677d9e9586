//! What a search goes through: the two commands of a binary controller, or the numbers of a table.

use rsrs_core::conditions::controller_table::{ControllerTable, NamedNumber};
use rsrs_core::conditions::operator::controller_values;
use rsrs_core::conditions::{Conditions, Settings};
use rsrs_core::quantity::{Axis, AxisValues};
use rsrs_core::robot::profile::RobotProfile;
use rsrs_sim::exploration::space::{ControllerSpace, N_NUMBERS, RESOLUTION};

/// The controllers that a search may try, as points of a box.
pub enum Space {
    /// Any two commands that the robots can carry out.
    Commands(ControllerSpace),
    /// A table with any of its numbers within their bounds.
    Table(ControllerTable),
}

/// Parts of the way from the numbers in the file to those of a point, the longest first.
const PARTS: [f64; 5] = [1.0, 0.75, 0.5, 0.25, 0.0];

impl Space {
    /// Coordinates of a point.
    pub fn n_numbers(&self) -> usize {
        match self {
            Self::Commands(_) => N_NUMBERS,
            Self::Table(table) => table.numbers.len(),
        }
    }

    /// The table, where the search has one.
    pub fn table(&self) -> Option<&ControllerTable> {
        match self {
            Self::Commands(_) => None,
            Self::Table(table) => Some(table),
        }
    }

    /// What is set at a point, in a world whose settings have a number of robots. Numbers with
    /// which these robots would be commanded too much are moved towards those in the file, with
    /// which they are not.
    pub fn values(
        &self,
        point: &[f64],
        (robot, settings): (&RobotProfile, &Settings),
    ) -> Vec<(Axis, f64)> {
        let table = match self {
            Self::Commands(space) => return controller_values(&space.controller(point).into()),
            Self::Table(table) => table,
        };
        let at = |part: f64| -> Vec<(Axis, f64)> {
            let numbers = table.axes().zip(table.numbers.values()).zip(point);
            numbers
                .map(|((axis, number), coordinate)| (axis, between(*number, *coordinate, part)))
                .collect()
        };
        let can = |values: &Vec<(Axis, f64)>| {
            let mut settings = settings.clone();
            settings.values.extend(values.iter().copied());
            let conditions = Conditions::resolve(robot, &settings);
            conditions.is_ok_and(|conditions| conditions.is_within_limits(robot))
        };
        let found = PARTS.into_iter().map(at).find(can);
        found.unwrap_or_else(|| {
            table.axes().zip(table.numbers.values().map(|it| it.value)).collect()
        })
    }

    /// Values around one on an axis, for a sweep, the value among them.
    pub fn around(&self, axis: Axis, value: f64) -> AxisValues {
        let rounded = |number: f64| (number * RESOLUTION).round() / RESOLUTION;
        let mut near: Vec<f64> = match (self, axis) {
            (Self::Table(table), Axis::Number(number)) => {
                let NamedNumber { from, to, .. } = table.numbers[number.name()];
                [-0.2, -0.1, 0.1, 0.2]
                    .map(|part| rounded(value + part * (to - from)).clamp(from, to))
                    .to_vec()
            }
            (Self::Commands(space), _) => {
                let [least, most] = match axis {
                    Axis::Speed | Axis::UndetectedSpeed => space.speed_m_s,
                    _ => space.turn_rate_rad_s,
                };
                let amount = |factor: f64| rounded((value.abs() * factor).clamp(least, most));
                [0.6, 0.8, 1.2, 1.4].map(|factor| amount(factor).copysign(value)).to_vec()
            }
            (Self::Table(_), _) => Vec::new(),
        };
        near.push(value);
        near.sort_by(f64::total_cmp);
        near.dedup();
        AxisValues(near)
    }
}

/// A part of the way from a number's value to that of a coordinate, which goes from -1 to 1 as the number
/// through its bounds.
fn between(number: NamedNumber, coordinate: f64, part: f64) -> f64 {
    let NamedNumber { value, from, to } = number;
    if part == 0.0 {
        return value;
    }
    let at = from + (to - from) * f64::midpoint(coordinate.clamp(-1.0, 1.0), 1.0);
    let moved = value + part * (at - value);
    ((moved * RESOLUTION).round() / RESOLUTION).clamp(from, to)
}

#[cfg(test)]
mod tests {
    use rsrs_testing::conditions::flockbot;

    use super::*;

    #[test]
    fn what_robots_must_not_be_commanded_is_moved_towards_the_file_until_they_may() {
        let robot = flockbot();
        let text = "numbers: {fast_m_s: {value: 0.1, from: 0, to: 0.6}}\nrows:\n  - {command: {speed_m_s: \
                    $fast_m_s, turn_rate_rad_s: 0.5}}\n";
        let table = ControllerTable::parse("table.yaml", text, &robot).unwrap();
        let settings = Settings {
            values: vec![(Axis::Robots, 9.0)],
            controller: Some(table.clone()),
            ..Settings::default()
        };
        let space = Space::Table(table);

        // From 0 to 0.6 m/s, of which these robots do nothing, or 0.02 to 0.3.
        for (coordinate, expected_m_s) in
            [(0.0, 0.3_f64), (-0.5, 0.15), (1.0, 0.225), (-1.0, 0.0), (-0.97, 0.032)]
        {
            let (_, found_m_s) = space.values(&[coordinate], (&robot, &settings))[0];
            assert_eq!(found_m_s.to_bits(), expected_m_s.to_bits(), "{coordinate}: {found_m_s}");
        }
    }
}
