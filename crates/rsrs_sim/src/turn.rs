//! Cosine and sine in single precision, with the same bits on every machine.

/// An angle beyond this many radians is first brought into one turn by an exact remainder.
pub const LIMIT_RAD: f32 = 4096.0;

/// Adding and subtracting this rounds a small number to the nearest whole one, ties to even.
pub(crate) const ROUNDER: f32 = 12_582_912.0;

/// Pi/2 in three parts. The first two have so few bits that their products with a whole number
/// below 2^12 are exact.
pub(crate) const HALF_PI: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];

/// Coefficients of the sine's series, from the third power of the angle on.
pub(crate) const SINE: [f32; 3] = [-1.666_665_5e-1, 8.332_161e-3, -1.951_529_6e-4];

/// Coefficients of the cosine's series, from the fourth power of the angle on.
pub(crate) const COSINE: [f32; 3] = [4.166_664_6e-2, -1.388_731_6e-3, 2.443_315_7e-5];

/// The cosine and sine of a finite angle, each within 2e-7 of the exact value up to 100 rad.
///
/// The turn of a robot in one step is drawn from any distribution, so a table or a recurrence would
/// not do; the platform's own functions differ in their last bits. This one uses only `+ - *`,
/// compare and select (and, beyond 4096 rad, the exact remainder), so that a lane of a vector
/// gives the same bits as a scalar. It is exactly even in the cosine and odd in the sine: a robot
/// that turns left and then right by the same command has its mirror image's heading.
///
/// # Source
///
/// The polynomials are those of the Cephes library (S. L. Moshier), `sinf.c`.
#[inline]
pub fn turn(angle_rad: f32) -> (f32, f32) {
    let angle_rad =
        if angle_rad.abs() <= LIMIT_RAD { angle_rad } else { within_one_turn(angle_rad) };
    let quarters = (angle_rad * std::f32::consts::FRAC_2_PI + ROUNDER) - ROUNDER;
    let rest =
        ((angle_rad - quarters * HALF_PI[0]) - quarters * HALF_PI[1]) - quarters * HALF_PI[2];
    let square = rest * rest;
    let sine = rest + rest * square * (SINE[0] + square * (SINE[1] + square * SINE[2]));
    let cosine = 1.0 - 0.5 * square
        + square * square * (COSINE[0] + square * (COSINE[1] + square * COSINE[2]));
    // The cast is exact: `quarters` is a whole number of at most 13 bits.
    let quadrant = quarters as i32;
    let (cosine, sine) = if quadrant & 1 == 0 { (cosine, sine) } else { (sine, cosine) };
    let cosine = if (quadrant + 1) & 2 == 0 { cosine } else { -cosine };
    let sine = if quadrant & 2 == 0 { sine } else { -sine };
    (cosine, sine)
}

#[cold]
fn within_one_turn(angle_rad: f32) -> f32 {
    (f64::from(angle_rad) % std::f64::consts::TAU) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn angles() -> impl Iterator<Item = f32> {
        (0..200_001).map(|sample| sample as f32 * 5e-4)
    }

    #[test]
    fn the_error_against_libm_is_at_most_two_ten_millionths() {
        for angle in angles().flat_map(|angle| [angle, -angle]) {
            let (cosine, sine) = turn(angle);

            assert!((f64::from(cosine) - libm::cos(f64::from(angle))).abs() < 2e-7, "{angle}");
            assert!((f64::from(sine) - libm::sin(f64::from(angle))).abs() < 2e-7, "{angle}");
        }
    }

    #[test]
    fn the_cosine_is_even_and_the_sine_odd_to_the_bit() {
        // Without zero, whose sine is plus zero on both sides.
        for angle in angles().skip(1).chain([5_000.0, 1e9, f32::MAX]) {
            let (cosine, sine) = turn(angle);
            let (mirrored_cosine, mirrored_sine) = turn(-angle);

            assert_eq!(cosine.to_bits(), mirrored_cosine.to_bits(), "{angle}");
            assert_eq!((-sine).to_bits(), mirrored_sine.to_bits(), "{angle}");
        }
    }

    #[test]
    fn a_huge_angle_is_still_a_direction() {
        for angle in [4_097.0_f32, -1e6, 1e20, f32::MAX] {
            let (cosine, sine) = turn(angle);

            assert!((cosine * cosine + sine * sine - 1.0).abs() < 1e-6, "{angle}");
        }
    }
}
