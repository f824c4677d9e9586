//! The width of a picture on paper.

use std::str::FromStr;

use rsrs_view::pdf::PX_PER_INCH;

const MM_PER_INCH: f64 = 25.4;
/// Dots of a printed PNG in an inch.
const DOTS_PER_INCH: f64 = 600.0;
/// Widths that a page can have, in millimetres.
const WIDTHS_MM: [f64; 2] = [60.0, 600.0];

/// A width on paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Length {
    mm: f64,
}

/// Why a text is no width.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LengthError {
    /// There is no unit, or no number before it.
    #[error("`{0}` is no width, expected a number and mm, cm or in, such as 88mm")]
    Format(String),
    /// It is too narrow or too wide.
    #[error("a width of {found_mm:.0} mm, expected {} to {} mm", WIDTHS_MM[0], WIDTHS_MM[1])]
    OutOfRange {
        /// The width, in millimetres.
        found_mm: f64,
    },
}

impl Length {
    /// In millimetres.
    pub fn mm(self) -> f64 {
        self.mm
    }

    /// In pixels of the picture, 96 to an inch.
    pub fn px(self) -> f64 {
        self.mm / MM_PER_INCH * f64::from(PX_PER_INCH)
    }

    /// In dots of a PNG for printing.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a width is positive, and casts from floats saturate"
    )]
    pub fn dots(self) -> u32 {
        (self.mm / MM_PER_INCH * DOTS_PER_INCH).round() as u32
    }
}

impl FromStr for Length {
    type Err = LengthError;

    fn from_str(text: &str) -> Result<Self, LengthError> {
        let error = || LengthError::Format(text.to_owned());
        let units = [("mm", 1.0), ("cm", 10.0), ("in", MM_PER_INCH)];
        let (number, mm) = units
            .into_iter()
            .find_map(|(unit, mm)| Some((text.strip_suffix(unit)?.trim_end(), mm)))
            .ok_or_else(error)?;
        let number: f64 = number.parse().map_err(|_number| error())?;
        let found_mm = number * mm;
        if !(WIDTHS_MM[0]..=WIDTHS_MM[1]).contains(&found_mm) {
            return Err(LengthError::OutOfRange { found_mm });
        }
        Ok(Self { mm: found_mm })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_have_a_unit() {
        let mm = |text: &str| text.parse().map(Length::mm);

        assert_eq!((mm("88mm"), mm("8.8 cm")), (Ok(88.0), Ok(88.0)));
        assert!((mm("3.5in").unwrap() - 88.9).abs() < 1e-9);
        assert_eq!("88mm".parse::<Length>().unwrap().dots(), 2079);
        for wrong in ["88", "wide", "mm", "20mm", "9000mm", "NaNmm", "-88mm"] {
            assert!(wrong.parse::<Length>().is_err(), "{wrong}");
        }
    }
}
