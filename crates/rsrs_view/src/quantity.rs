//! A value with the unit and the name of its axis, the same on pictures and in sentences; how many digits its
//! number has is up to them.

use rsrs_core::quantity::Axis;

/// A `number`, which is that of a value, in the unit of its axis: `0.15 m/s`, `1 robot`.
pub fn with_unit(axis: Axis, value: f64, number: &str) -> String {
    match axis {
        Axis::LatencySteps if (value - 1.0).abs() < 1e-9 => "1 step".to_owned(),
        Axis::Robots if (value - 1.0).abs() < 1e-9 => "1 robot".to_owned(),
        _ if axis.unit().is_empty() => number.to_owned(),
        _ => format!("{number} {}", axis.unit()),
    }
}

/// The same, an angle in degrees beside it: `0.2 rad (11.5°)`.
pub fn with_degrees(axis: Axis, value: f64, number: &str) -> String {
    let text = with_unit(axis, value, number);
    if is_angle(axis) { format!("{text} ({:.1}°)", value.to_degrees()) } else { text }
}

/// The same with the name of its axis: `speed 0.15 m/s`, `9 robots`.
pub fn named(axis: Axis, value: f64, number: &str) -> String {
    let text = with_degrees(axis, value, number);
    if axis == Axis::Robots { text } else { format!("{} {text}", axis.name()) }
}

/// Whether the values of an axis are angles.
pub fn is_angle(axis: Axis) -> bool {
    axis.unit() == "rad"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_has_the_name_and_the_unit_of_its_axis_and_an_angle_degrees() {
        for (axis, value, number, expected) in [
            (Axis::Speed, 0.15, "0.15", "speed 0.15 m/s"),
            (Axis::Robots, 9.0, "9", "9 robots"),
            (Axis::Robots, 1.0, "1", "1 robot"),
            (Axis::LatencySteps, 1.0, "1", "latency of the sensor 1 step"),
            (Axis::HalfAngle, 0.2, "0.20", "half-angle of the sensor 0.20 rad (11.5°)"),
        ] {
            assert_eq!(named(axis, value, number), expected);
        }
    }
}
