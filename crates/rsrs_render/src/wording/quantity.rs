//! Axes and their values in words.

use rsrs_core::quantity::{Axis, Cell};
use rsrs_view::quantity;

/// A value in the unit of files and pictures, an angle in degrees beside it: `0.2 rad (11.5°)`.
pub fn quantity(axis: Axis, value: f64) -> String {
    quantity::with_degrees(axis, value, &digits(value))
}

/// A value in the unit of its axis, as beside the ticks of a picture.
pub fn as_on_an_axis(axis: Axis, value: f64) -> String {
    quantity::with_unit(axis, value, &digits(value))
}

/// A value with the name of its axis: `speed 0.15 m/s`, `9 robots`.
pub fn named(axis: Axis, value: f64) -> String {
    quantity::named(axis, value, &digits(value))
}

/// A cell in words: `speed 0.15 m/s, turning rate 0.75 rad/s`.
pub fn of_cell(cell: &Cell) -> String {
    let values: Vec<String> = cell.iter().map(|(axis, value)| named(axis, value)).collect();
    values.join(", ")
}

/// Two values with their unit once: `0.14 to 0.26 m/s`.
pub fn span(axis: Axis, low: f64, high: f64) -> String {
    let text = span_on_an_axis(axis, low, high);
    if quantity::is_angle(axis) {
        format!("{text} ({:.1} to {:.1}°)", low.to_degrees(), high.to_degrees())
    } else {
        text
    }
}

/// The same in the unit of their axis: `0.1 to 0.2 rad`.
pub fn span_on_an_axis(axis: Axis, low: f64, high: f64) -> String {
    let (low, high) = (as_on_an_axis(axis, low), as_on_an_axis(axis, high));
    format!("{} to {high}", without_unit(&low))
}

/// What is left of a value without its unit: `0.14` of `0.14 m/s`.
pub fn without_unit(value: &str) -> &str {
    let is_number = |character: char| character.is_ascii_digit() || "+-−.".contains(character);
    value.trim_end_matches(|character| !is_number(character))
}

/// A number in three significant digits, without zeros at its end.
fn digits(value: f64) -> String {
    let decimals = match value.abs() {
        100.0.. => 0,
        10.0..100.0 => 1,
        1.0..10.0 => 2,
        0.1..1.0 => 3,
        0.01..0.1 => 4,
        _ => 5,
    };
    let text = format!("{value:.decimals$}");
    if decimals == 0 {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_span_has_its_unit_once() {
        assert_eq!(span(Axis::Speed, 0.14, 0.26), "0.14 to 0.26 m/s");
        assert_eq!(span(Axis::Robots, 5.0, 9.0), "5 to 9 robots");
        assert_eq!(span(Axis::HalfAngle, 0.1, 0.2), "0.1 to 0.2 rad (5.7 to 11.5°)");
        assert_eq!(span_on_an_axis(Axis::HalfAngle, 0.1, 0.2), "0.1 to 0.2 rad");
        assert_eq!(span(Axis::TruePositive, 0.7, 1.0), "0.7 to 1");
        assert_eq!(span(Axis::LatencySteps, 0.0, 1.0), "0 to 1 step");
    }

    #[test]
    fn a_cell_names_its_axes_and_counts_its_robots() {
        let cell: Cell = "robots=9,speed_m_s=0.15".parse().unwrap();

        assert_eq!(of_cell(&cell), "9 robots, speed 0.15 m/s");
    }
}
