//! Gains: what a robot delivers over what it is asked.

/// Why there is no gain.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum GainError {
    /// Nothing was measured.
    #[error("no trials, expected 1 or more")]
    NoTrials,
    /// At this command a gain is not defined.
    #[error("the command is {found}, expected above 0")]
    DesiredNotPositive {
        /// The command, in its own unit.
        found: f64,
    },
}

/// Estimates the speed gain `θᵃ₁` of one robot at one commanded speed: the mean of `measured_m_s`
/// (one mean speed per trial over the track) over `desired_m_s`, which is positive.
///
/// A robot that delivers exactly what it is asked has gain 1; the paper's Flockbots deliver 0.86 to
/// 0.97.
///
/// # Source
///
/// `eq:theta^a1`, §IV step 1; checked against `tab:speed1`.
///
/// # Example
///
/// The first row of `tab:speed1`: 25 mm/s commanded, 22.15 mm/s measured, gain 0.89.
///
/// ```
/// use rsrs_core::trials::gain::speed_gain;
///
/// let gain = speed_gain(0.025, &[0.02215])?;
/// assert_eq!(format!("{gain:.2}"), "0.89");
/// # Ok::<(), rsrs_core::trials::gain::GainError>(())
/// ```
pub fn speed_gain(desired_m_s: f64, measured_m_s: &[f64]) -> Result<f64, GainError> {
    gain(desired_m_s, measured_m_s)
}

/// Estimates the turn gain `θᵃ₂` of one robot at one commanded turning rate: the mean of
/// `measured_rad_s` (one mean turning rate per trial, positive in the command's sense) over
/// `desired_rad_s`, the size of the command, which is positive.
///
/// # Source
///
/// `eq:theta^a2`, §IV step 1.
pub fn turn_gain(desired_rad_s: f64, measured_rad_s: &[f64]) -> Result<f64, GainError> {
    gain(desired_rad_s, measured_rad_s)
}

fn gain(desired: f64, measured: &[f64]) -> Result<f64, GainError> {
    if measured.is_empty() {
        return Err(GainError::NoTrials);
    }
    if desired.is_nan() || desired <= 0.0 {
        return Err(GainError::DesiredNotPositive { found: desired });
    }
    Ok(crate::statistics::variance::mean(measured) / desired)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gains_are_those_of_the_papers_table_but_for_one_rounding() {
        // tab:speed1, in millimetres per second. 22.15 / 25 is 0.886 and 22.32 / 25 is 0.893.
        for (desired, measured, expected) in [
            (25.0, 22.15, "0.89"),
            (25.0, 21.48, "0.86"),
            (25.0, 22.32, "0.89"),
            (50.0, 48.47, "0.97"),
            (50.0, 48.66, "0.97"),
            (50.0, 48.54, "0.97"),
        ] {
            let found = speed_gain(desired / 1000.0, &[measured / 1000.0]).unwrap();

            assert_eq!(format!("{found:.2}"), expected);
        }
    }

    #[test]
    fn nothing_measured_and_nothing_asked_have_no_gain() {
        assert_eq!(speed_gain(0.1, &[]), Err(GainError::NoTrials));
        assert_eq!(turn_gain(0.0, &[0.1]), Err(GainError::DesiredNotPositive { found: 0.0 }));
    }
}
