//! A number of each cell in the place of its phases: an order parameter, a time, or a difference.

use crate::palette::{Colour, between};
use crate::scale::{ends, labels};

/// A number for each cell.
#[derive(Clone, Debug, PartialEq)]
pub struct CellValues {
    /// What it is, with its unit; any text.
    pub name: String,
    /// How it becomes a colour.
    pub scale: ValueScale,
    /// The numbers of each panel, in the order of its diagram; `None` where a cell has none.
    pub of_panels: Vec<Vec<Option<f64>>>,
    /// Cells to be framed, in the same shape, and what the frame means; any text.
    pub framed: Option<(String, Vec<Vec<bool>>)>,
}

/// Which colours numbers have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ValueScale {
    /// From light to dark between two finite numbers, of which the first is smaller.
    Sequential {
        /// The lightest.
        low: f64,
        /// The darkest.
        high: f64,
    },
    /// From one hue over white, at 0, to another.
    Diverging {
        /// The greatest amount; positive and finite.
        most: f64,
    },
}

const LIGHT: Colour = Colour { rgb: [0xf4, 0xf1, 0xde] };
const DARK: Colour = Colour { rgb: [0x0b, 0x3c, 0x5d] };
const LESS: Colour = Colour { rgb: [0xd5, 0x5e, 0x00] };
const NONE: Colour = Colour { rgb: [0xf7, 0xf7, 0xf7] };
const MORE: Colour = Colour { rgb: [0x00, 0x72, 0xb2] };

impl ValueScale {
    /// Around numbers that are there; from 0 to 1 if there are none.
    pub fn around(values: impl Iterator<Item = f64>) -> Self {
        let [low, high] = ends(values);
        if low < high {
            Self::Sequential { low, high }
        } else if low.is_finite() {
            Self::Sequential { low: low - 0.5, high: high + 0.5 }
        } else {
            Self::Sequential { low: 0.0, high: 1.0 }
        }
    }

    /// The colour of a number; one beyond the ends has that of the end.
    pub fn colour(self, value: f64) -> Colour {
        match self {
            Self::Sequential { low, high } => {
                between(LIGHT, DARK, ((value - low) / (high - low)).clamp(0.0, 1.0))
            }
            Self::Diverging { most } if value < 0.0 => {
                between(NONE, LESS, (-value / most).min(1.0))
            }
            Self::Diverging { most } => between(NONE, MORE, (value / most).min(1.0)),
        }
    }

    /// The least and the greatest number.
    pub fn ends(self) -> [f64; 2] {
        match self {
            Self::Sequential { low, high } => [low, high],
            Self::Diverging { most } => [-most, most],
        }
    }

    /// So many colours from the least number to the greatest, for a legend.
    pub fn ramp(self, n: usize) -> impl Iterator<Item = Colour> {
        let [low, high] = self.ends();
        (0..n).map(move |step| self.colour(low + (high - low) * (step as f64 + 0.5) / n as f64))
    }

    /// A number in the cells: as many decimals in all of them, and a sign where it is a difference.
    pub fn text(self, value: f64) -> String {
        let [low, high] = self.ends();
        let decimals = match high - low {
            span if span < 0.05 => 3,
            span if span < 10.0 => 2,
            span if span < 100.0 => 1,
            _ => 0,
        };
        let text = match self {
            Self::Sequential { .. } => format!("{value:.decimals$}"),
            Self::Diverging { .. } => format!("{value:+.decimals$}"),
        };
        let is_nothing = text.chars().all(|it| "+-0.".contains(it));
        let text = if is_nothing { text.trim_start_matches(['+', '-']).to_owned() } else { text };
        text.replace('-', "\u{2212}")
    }

    /// The ends in words, for a legend.
    pub fn end_labels(self) -> [String; 2] {
        let [low, high] = self.ends().map(|end| (end * 1000.0).round() / 1000.0);
        let texts = labels(&[low, high]);
        let signed = |text: &str| match self {
            Self::Diverging { .. } if !text.starts_with('\u{2212}') => format!("+{text}"),
            _ => text.to_owned(),
        };
        [signed(&texts[0]), signed(&texts[1])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_have_signs_and_nothing_has_none() {
        let scale = ValueScale::Diverging { most: 0.4 };

        assert_eq!(
            [0.123, -0.2, 0.0, -0.001].map(|it| scale.text(it)),
            ["+0.12", "\u{2212}0.20", "0.00", "0.00"]
        );
        assert_eq!(scale.end_labels(), ["\u{2212}0.4", "+0.4"]);
        assert_eq!((scale.colour(0.0), scale.colour(-0.4), scale.colour(9.0)), (NONE, LESS, MORE));
    }

    #[test]
    fn a_scale_goes_around_the_numbers_that_are_there() {
        let scale = ValueScale::around([0.2, 0.8, 0.5].into_iter());

        let ends = |scale: ValueScale| scale.ends().map(|end| end.to_string());
        assert_eq!(ends(scale), ["0.2", "0.8"]);
        assert_eq!((scale.colour(0.2), scale.colour(0.8)), (LIGHT, DARK));
        assert_eq!(ends(ValueScale::around([3.0].into_iter())), ["2.5", "3.5"]);
        assert_eq!(ends(ValueScale::around(std::iter::empty())), ["0", "1"]);
    }
}
