//! The colours: one hue per phase, lightness for the share of the replicates that ended in it.

use rsrs_core::judge::phase::{MOST_PHASES, Phase};

/// A colour, in sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour {
    /// Red, green and blue, 0 to 255.
    pub rgb: [u8; 3],
}

/// A colour of lines and marks.
pub const BLUE: &str = "#0072b2";
/// A colour of lines and marks.
pub const GREEN: &str = "#009e73";
/// A colour of lines and marks.
pub const ORANGE: &str = "#e69f00";
/// A colour of lines and marks.
pub const RED: &str = "#c1121f";
/// A colour of lines and marks.
pub const VERMILION: &str = "#d55e00";
/// Lines and letters.
pub const INK: &str = "#1a1a1a";
/// Letters of less weight.
pub const QUIET_INK: &str = "#555555";
/// A cell that was not swept.
pub const NOT_SWEPT: &str = "#f2f0ea";

/// The smallest share that a majority of five phases can have.
pub const LEAST_SHARE: f64 = 0.2;

/// How much of the hue is left at [`LEAST_SHARE`]; the rest is white.
///
/// More of the dark grey, so that its palest shade is still darker than the light grey.
pub(crate) fn least_hue(phase: Phase) -> f64 {
    if hue(phase).rgb == DARK_GREY { 0.6 } else { 0.3 }
}

/// The full colour of a phase: that of its behaviour's file, or a hue for each place that a phase has in its
/// behaviour, so that the wanted phase is blue in every picture.
///
/// Blue, yellow and vermilion are those of Okabe and Ito's palette for the colour-blind; the two
/// phases that mean the absence of a pattern are greys, far apart in lightness. The test below
/// holds the distances for normal sight, deuteranopia and protanopia, also between paler shades.
///
/// # Source
///
/// M. Okabe and K. Ito, "Color Universal Design", 2008.
pub fn hue(phase: Phase) -> Colour {
    Colour { rgb: phase.entry().rgb().unwrap_or(HUES[phase.place()]) }
}

const DARK_GREY: [u8; 3] = [0x33, 0x33, 0x33];

/// By place.
const HUES: [[u8; 3]; MOST_PHASES] =
    [[0x00, 0x72, 0xb2], [0xf0, 0xe4, 0x42], DARK_GREY, [0xbb, 0xbb, 0xbb], [0xd5, 0x5e, 0x00]];

/// The colour of a cell: the phase's hue, paler the smaller the share of replicates that ended in
/// it; shares below [`LEAST_SHARE`] look like it.
pub fn shade(phase: Phase, share: f64) -> Colour {
    let beyond_least = ((share - LEAST_SHARE) / (1.0 - LEAST_SHARE)).clamp(0.0, 1.0);
    let least_hue = least_hue(phase);
    let amount = least_hue + (1.0 - least_hue) * beyond_least;
    let full = oklab(linear(hue(phase)));
    let [lightness, a, b] = full.map(|coordinate| coordinate * amount);
    Colour::from_linear(linear_of_oklab([lightness + (1.0 - amount), a, b]))
}

/// The lids of robots of a class, by its place; those of more classes than there are colours have them again.
///
/// # Source
///
/// The first three as those of [`hue`]; all are light enough for black letters.
pub fn lid(class: usize) -> Colour {
    Colour { rgb: LIDS[class % LIDS.len()] }
}

const LIDS: [[u8; 3]; 5] = [
    [0x56, 0xb4, 0xe9],
    [0xf0, 0xe4, 0x42],
    [0xd5, 0x5e, 0x00],
    [0xff, 0xff, 0xff],
    [0x88, 0x88, 0x88],
];

/// A colour between two others, as far from the first as a share states.
pub fn between(from: Colour, to: Colour, share: f64) -> Colour {
    let (one, other) = (oklab(linear(from)), oklab(linear(to)));
    let mixed = [0, 1, 2].map(|at| one[at] + share * (other[at] - one[at]));
    if share <= 0.0 {
        from
    } else if share >= 1.0 {
        to
    } else {
        Colour::from_linear(linear_of_oklab(mixed))
    }
}

impl Colour {
    /// The colour as SVG has it: `#0072b2`.
    pub fn hex(self) -> String {
        let [red, green, blue] = self.rgb;
        format!("#{red:02x}{green:02x}{blue:02x}")
    }

    /// The colour of letters on this one: white on dark and on saturated colours.
    pub fn ink(self) -> &'static str {
        let [red, green, blue] = linear(self);
        let luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
        // Contrast of WCAG 2 with white is 3.5 here; its formula favours black on blue, eyes do not.
        if luminance < 0.25 { "#ffffff" } else { INK }
    }

    fn from_linear(linear: [f64; 3]) -> Self {
        let rgb = linear.map(|channel| {
            let channel = channel.clamp(0.0, 1.0);
            let encoded = if channel <= 0.003_130_8 {
                12.92 * channel
            } else {
                1.055 * libm::pow(channel, 1.0 / 2.4) - 0.055
            };
            to_byte(encoded)
        });
        Self { rgb }
    }
}

fn to_byte(channel: f64) -> u8 {
    (channel.clamp(0.0, 1.0) * 255.0).round() as u8
}

/// Light of the three primaries.
fn linear(colour: Colour) -> [f64; 3] {
    colour.rgb.map(|byte| {
        let channel = f64::from(byte) / 255.0;
        if channel <= 0.040_45 {
            channel / 12.92
        } else {
            libm::pow((channel + 0.055) / 1.055, 2.4)
        }
    })
}

/// Björn Ottosson's Oklab, in which equal distances look equal: lightness, green–red, blue–yellow.
fn oklab(linear: [f64; 3]) -> [f64; 3] {
    let cones = product(
        &[
            [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
            [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
            [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
        ],
        linear,
    );
    product(
        &[
            [0.210_454_255_3, 0.793_617_785_0, -0.004_072_046_8],
            [1.977_998_495_1, -2.428_592_205_0, 0.450_593_709_9],
            [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766_0],
        ],
        cones.map(libm::cbrt),
    )
}

fn linear_of_oklab(lab: [f64; 3]) -> [f64; 3] {
    let roots = product(
        &[
            [1.0, 0.396_337_777_4, 0.215_803_757_3],
            [1.0, -0.105_561_345_8, -0.063_854_172_8],
            [1.0, -0.089_484_177_5, -1.291_485_548_0],
        ],
        lab,
    );
    product(
        &[
            [4.076_741_662_1, -3.307_711_591_3, 0.230_969_929_2],
            [-1.268_438_004_6, 2.609_757_401_1, -0.341_319_396_5],
            [-0.004_196_086_3, -0.703_418_614_7, 1.707_614_701_0],
        ],
        roots.map(|root| root * root * root),
    )
}

fn product(matrix: &[[f64; 3]; 3], vector: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Machado, Oliveira and Fernandes 2009, severity 1, on linear light.
    const SIGHTS: [(&str, [[f64; 3]; 3]); 3] = [
        ("normal", [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]),
        (
            "protanopia",
            [
                [0.152_286, 1.052_583, -0.204_868],
                [0.114_503, 0.786_281, 0.099_216],
                [-0.003_882, -0.048_116, 1.051_998],
            ],
        ),
        (
            "deuteranopia",
            [
                [0.367_322, 0.860_646, -0.227_968],
                [0.280_085, 0.672_501, 0.047_413],
                [-0.011_820, 0.042_940, 0.968_881],
            ],
        ),
    ];

    /// The distance of the closest pair of phases, at any of these shares, as one eye sees them.
    fn closest(sight: &[[f64; 3]; 3], shares: &[f64]) -> f64 {
        let seen = |phase, share| {
            let light = product(sight, linear(shade(phase, share)));
            oklab(light.map(|channel| channel.clamp(0.0, 1.0)))
        };
        let mut least = f64::INFINITY;
        for left in Phase::BUILT_IN {
            let phases = left.behaviour().phases().iter().copied();
            for right in phases.filter(|right| *right > left) {
                for (left_share, right_share) in
                    shares.iter().flat_map(|one| shares.iter().map(move |other| (*one, *other)))
                {
                    let a = seen(left, left_share);
                    let b = seen(right, right_share);
                    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
                    least = least.min(squares.sqrt());
                }
            }
        }
        least
    }

    #[test]
    fn phases_are_far_apart_for_every_eye() {
        for (sight, matrix) in SIGHTS {
            // A just noticeable difference in Oklab is about 0.02.
            let full = closest(&matrix, &[1.0]);
            assert!(full > 0.19, "{sight}: {full}");

            let with_paler = closest(&matrix, &[1.0, 0.8, 0.6]);
            assert!(with_paler > 0.08, "{sight}: {with_paler}");
        }
    }

    #[test]
    fn lids_of_classes_are_far_apart_for_every_eye() {
        for (sight, matrix) in SIGHTS {
            let seen = |class| {
                let light = product(&matrix, linear(lid(class)));
                oklab(light.map(|channel| channel.clamp(0.0, 1.0)))
            };
            for (one, other) in (0..LIDS.len()).flat_map(|it| (0..it).map(move |other| (it, other)))
            {
                let pairs = seen(one).into_iter().zip(seen(other));
                let apart = pairs.map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
                assert!(apart > 0.12, "{sight}: {one} and {other} are {apart} apart");
            }
        }
        assert_eq!(lid(LIDS.len()), lid(0));
    }

    #[test]
    fn the_two_greys_never_meet() {
        let lightness = |phase, share| oklab(linear(shade(phase, share)))[0];

        let palest_dark = lightness(Phase::UNFORMED, LEAST_SHARE);
        let darkest_light = lightness(Phase::DISPERSION, 1.0);
        assert!(darkest_light - palest_dark > 0.15, "{palest_dark} {darkest_light}");
    }

    #[test]
    fn a_full_share_is_the_hue_and_smaller_shares_are_lighter() {
        for phase in Phase::BUILT_IN {
            assert_eq!(shade(phase, 1.0), hue(phase));
            let lightness = |share| oklab(linear(shade(phase, share)))[0];
            assert!(lightness(0.4) > lightness(0.6) && lightness(0.6) > lightness(0.9));
        }
    }

    #[test]
    fn letters_are_white_on_dark_and_black_on_light() {
        assert_eq!(hue(Phase::STABLE_MILLING).ink(), "#ffffff");
        assert_eq!(hue(Phase::SEMI_STABLE_MILLING).ink(), INK);
    }
}
