//! Changes of robots in words that a laboratory uses.

use rsrs_core::quantity::Axis;

use crate::wording::quantity::quantity;

/// What is to be changed: `range 0.45 m → at least 0.66 m`.
pub fn change(axis: Axis, now: f64, needed: f64) -> String {
    match axis {
        Axis::SensorBearing => format!("aim the sensor {}", turn(needed)),
        Axis::Speed | Axis::TurnRate => format!(
            "allow a {} of {} (the limit is {})",
            axis.name(),
            quantity(axis, needed),
            quantity(axis, now)
        ),
        Axis::SpeedGain | Axis::TurnGain => {
            format!("{} {} → {}", axis.name(), quantity(axis, now), quantity(axis, needed))
        }
        _ => format!(
            "{} {} → {} {}",
            axis.name(),
            quantity(axis, now),
            if needed > now { "at least" } else { "at most" },
            quantity(axis, needed)
        ),
    }
}

/// What would do as well: `range 0.75 m, 0.52 m would do`.
pub fn spare(axis: Axis, now: f64, enough: f64) -> String {
    format!("{} {}, {} would do", axis.name(), quantity(axis, now), quantity(axis, enough))
}

fn turn(by_rad: f64) -> String {
    let side = if by_rad < 0.0 { "right" } else { "left" };
    format!("{:.1}° to the {side}", by_rad.abs().to_degrees())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_what_a_laboratory_would_do() {
        let sentences = [
            change(Axis::SensorBearing, 0.0, -0.0698),
            change(Axis::Range, 0.45, 0.66),
            change(Axis::FalsePositive, 0.145, 0.062),
            change(Axis::LatencySteps, 6.0, 1.0),
            change(Axis::HalfAngle, 0.6, 0.35),
            change(Axis::Speed, 0.05, 0.12),
            spare(Axis::Range, 0.75, 0.52),
        ];

        assert_eq!(
            sentences,
            [
                "aim the sensor 4.0° to the right",
                "range of the sensor 0.45 m → at least 0.66 m",
                "false positive rate 0.145 → at most 0.062",
                "latency of the sensor 6 steps → at most 1 step",
                "half-angle of the sensor 0.6 rad (34.4°) → at most 0.35 rad (20.1°)",
                "allow a speed of 0.12 m/s (the limit is 0.05 m/s)",
                "range of the sensor 0.75 m, 0.52 m would do",
            ]
        );
    }
}
