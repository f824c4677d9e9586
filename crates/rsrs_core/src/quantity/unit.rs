//! Values that were meant in another unit.

use super::Axis;

/// A value that is likely in another unit.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{axis} is {found}: this looks like {likely}, expected {}", axis.unit())]
pub struct OtherUnit {
    /// The axis.
    pub axis: Axis,
    /// The value.
    pub found: f64,
    /// The unit that it is likely in.
    pub likely: &'static str,
}

impl Axis {
    /// Refuses a value that looks like millimetres, milliseconds or degrees, by the bounds that hold
    /// for tables of trials as well.
    ///
    /// # Example
    ///
    /// ```
    /// use rsrs_core::quantity::Axis;
    ///
    /// let error = Axis::Speed.check_unit(150.0).unwrap_err();
    /// assert_eq!(error.to_string(), "speed_m_s is 150: this looks like mm/s, expected m/s");
    /// ```
    pub fn check_unit(self, found: f64) -> Result<(), OtherUnit> {
        let Some((most, likely)) = self.row().other_unit else { return Ok(()) };
        if found.abs() > most {
            return Err(OtherUnit { axis: self, found, likely });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::quantity::Cell;

    #[test]
    fn values_in_another_unit_are_refused_wherever_a_person_writes_a_cell() {
        for (text, expected) in [
            ("speed_m_s=150", "speed_m_s is 150: this looks like mm/s, expected m/s"),
            (
                "speed_m_s=0.15,turn_rate_rad_s=43",
                "turn_rate_rad_s is 43: this looks like degrees per second, expected rad/s",
            ),
            ("range_m=750", "range_m is 750: this looks like mm, expected m"),
            (
                "half_angle_rad=11.5",
                "half_angle_rad is 11.5: this looks like degrees, expected rad",
            ),
            (
                "sensor_bearing_rad=-4",
                "sensor_bearing_rad is -4: this looks like degrees, expected rad",
            ),
            ("period_s=130", "period_s is 130: this looks like ms, expected s"),
            ("placement_radius_m=825", "placement_radius_m is 825: this looks like mm, expected m"),
        ] {
            assert_eq!(text.parse::<Cell>().unwrap_err().to_string(), expected);

            let yaml = format!("{{{}}}", text.replace('=', ": "));
            let error = serde_saphyr::from_str::<Cell>(&yaml).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
        assert!("speed_m_s=0.15,turn_rate_rad_s=2.5,robots=300,arena_m=15".parse::<Cell>().is_ok());
    }
}
