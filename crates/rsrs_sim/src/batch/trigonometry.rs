//! Headings in lanes, with the bits of `libm`.
//!
//! The judge knows a robot's heading as the angle that `libm::atan2` gives, and takes its sine and
//! cosine by `libm::sincos`. These are the same operations in the same order, with selections in
//! place of branches; a lane that would take a rare branch is done by `libm` itself.
//!
//! # Source
//!
//! `s_atan.c`, `e_atan2.c`, `k_sin.c`, `k_cos.c` and `e_rem_pio2.c` of the Sun library, as in the
//! crate `libm` 0.2.

use std::f64::consts::{FRAC_PI_4, PI};

use super::simd::{Mask, Number, Simd};

/// What π is more than its double.
const PI_REST: f64 = 1.224_646_799_147_353_2e-16;

/// Where the arctangent's ranges end, and for each range the angle that is split off, high and low
/// part: 0, atan(1/2), atan(1), atan(3/2), atan(∞).
const RANGE_ENDS: [f64; 4] = [0.4375, 0.6875, 1.1875, 2.4375];
const SPLIT_HIGH: [f64; 4] = [
    f64::from_bits(0x3fdd_ac67_0561_bb4f),
    f64::from_bits(0x3fe9_21fb_5444_2d18),
    f64::from_bits(0x3fef_730b_d281_f69b),
    f64::from_bits(0x3ff9_21fb_5444_2d18),
];
const SPLIT_LOW: [f64; 4] = [
    f64::from_bits(0x3c7a_2b7f_222f_65e2),
    f64::from_bits(0x3c81_a626_3314_5c07),
    f64::from_bits(0x3c70_0788_7af0_cbbd),
    f64::from_bits(0x3c91_a626_3314_5c07),
];
const ARCTANGENT: [f64; 11] = [
    f64::from_bits(0x3fd5_5555_5555_550d),
    f64::from_bits(0xbfc9_9999_9998_ebc4),
    f64::from_bits(0x3fc2_4924_9200_83ff),
    f64::from_bits(0xbfbc_71c6_fe23_1671),
    f64::from_bits(0x3fb7_45cd_c54c_206e),
    f64::from_bits(0xbfb3_b0f2_af74_9a6d),
    f64::from_bits(0x3fb1_0d66_a0d0_3d51),
    f64::from_bits(0xbfad_de2d_52de_fd9a),
    f64::from_bits(0x3fa9_7b4b_2476_0deb),
    f64::from_bits(0xbfa2_b444_2c6a_6c2f),
    f64::from_bits(0x3f90_ad3a_e322_da11),
];
const SINE: [f64; 6] = [
    f64::from_bits(0xbfc5_5555_5555_5549),
    f64::from_bits(0x3f81_1111_1110_f8a6),
    f64::from_bits(0xbf2a_01a0_19c1_61d5),
    f64::from_bits(0x3ec7_1de3_57b1_fe7d),
    f64::from_bits(0xbe5a_e5e6_8a2b_9ceb),
    f64::from_bits(0x3de5_d93a_5acf_d57c),
];
const COSINE: [f64; 6] = [
    f64::from_bits(0x3fa5_5555_5555_554c),
    f64::from_bits(0xbf56_c16c_16c1_5177),
    f64::from_bits(0x3efa_01a0_19cb_1590),
    f64::from_bits(0xbe92_7e4f_809c_52ad),
    f64::from_bits(0x3e21_ee9e_bdb4_b1c4),
    f64::from_bits(0xbda8_fae9_be88_38d4),
];
/// The first 33 bits of π/2, and the rest.
const HALF_PI: f64 = f64::from_bits(0x3ff9_21fb_5440_0000);
const HALF_PI_REST: f64 = f64::from_bits(0x3dd0_b461_1a62_6331);
/// Angles up to here, and beyond π/4, are reduced by π/2; those up to the end by π.
const REDUCED_ONCE: f64 = f64::from_bits(0x4002_d97d_0000_0000);
/// As far as the sine and cosine are taken without reduction: just above π/4.
const NOT_REDUCED: f64 = f64::from_bits(0x3fe9_21fc_0000_0000);
/// Angles so near to π/2 or π are reduced with more care.
const NEAR_HALF_PI: (f64, f64) =
    (f64::from_bits(0x3ff9_21fb_0000_0000), f64::from_bits(0x3ff9_21fc_0000_0000));
const NEAR_PI: f64 = f64::from_bits(0x4009_21fb_0000_0000);
/// Angles and ratios below this or above its inverse are left to `libm`.
const TINY: f64 = 1e-7;

/// As `libm::atan2`.
#[inline(always)]
pub fn atan2<S: Simd>(simd: S, y: S::D, x: S::D) -> S::D {
    let one = |number| simd.double(number);
    let zero = one(0.0);
    let ratio = (y / x).abs();
    // Written so that a ratio that is not a number is rare, too.
    let is_usual = one(TINY).lt(ratio) & ratio.lt(one(1.0 / TINY));
    let angle = arctangent(simd, ratio);
    let is_behind = x.lt(zero);
    let angle = S::D::select(is_behind, one(PI) - (angle - one(PI_REST)), angle);
    // Below: `(z - PI_REST) - PI` is exactly minus `PI - (z - PI_REST)`.
    let angle = S::D::select(y.lt(zero), one(-0.0) - angle, angle);
    if is_usual.bits() == all::<S>() {
        return angle;
    }
    rare(simd, (is_usual, angle), |lane| libm::atan2(y.lane(lane), x.lane(lane)))
}

/// As `libm::sincos`, of angles from -π to π: the sine and the cosine.
#[inline(always)]
pub fn sincos<S: Simd>(simd: S, angle: S::D) -> (S::D, S::D) {
    let one = |number| simd.double(number);
    let (zero, size) = (one(0.0), angle.abs());
    let is_usual = one(TINY).lt(size)
        & size.lt(one(NEAR_PI))
        & (size.lt(one(NEAR_HALF_PI.0)) | one(NEAR_HALF_PI.1).le(size));
    let is_whole = size.lt(one(NOT_REDUCED));
    let is_once = size.lt(one(REDUCED_ONCE));
    // How many quarters of a turn are taken off: 0, 1 or 2; their products are exact.
    let quarters = S::D::select(is_once, one(1.0), one(2.0)).unless(is_whole);
    let reduced = size - quarters * one(HALF_PI);
    let rest = quarters * one(HALF_PI_REST);
    let high = reduced - rest;
    let low = (reduced - high) - rest;
    let (sine, cosine) = series(simd, (high, low), is_whole);
    let quarter = S::D::select(is_once, cosine, zero - sine);
    let sine_of_size = S::D::select(is_whole, sine, quarter);
    let quarter = S::D::select(is_once, zero - sine, zero - cosine);
    let cosine_of_size = S::D::select(is_whole, cosine, quarter);
    let sine = S::D::select(angle.lt(zero), zero - sine_of_size, sine_of_size);
    if is_usual.bits() == all::<S>() {
        return (sine, cosine_of_size);
    }
    let exact = |lane| libm::sincos(angle.lane(lane));
    (
        rare(simd, (is_usual, sine), |lane| exact(lane).0),
        rare(simd, (is_usual, cosine_of_size), |lane| exact(lane).1),
    )
}

/// The arctangent of positive numbers that are neither tiny nor huge.
#[inline(always)]
fn arctangent<S: Simd>(simd: S, x: S::D) -> S::D {
    let one = |number| simd.double(number);
    let ends = RANGE_ENDS.map(|end| x.lt(one(end)));
    // From the last range to the first, each where its end is not passed.
    let choose = |of: [S::D; 5]| {
        let far = S::D::select(ends[3], of[3], of[4]);
        let middle = S::D::select(ends[2], of[2], far);
        let near = S::D::select(ends[1], of[1], middle);
        S::D::select(ends[0], of[0], near)
    };
    let one_half = one(1.5);
    let over = choose([x, one(2.0) * x - one(1.0), x - one(1.0), x - one_half, one(-1.0)]);
    let under = choose([one(1.0), one(2.0) + x, x + one(1.0), one(1.0) + one_half * x, x]);
    let reduced = over / under;
    let square = reduced * reduced;
    let fourth = square * square;
    let at = ARCTANGENT.map(one);
    let odd = square
        * (at[0]
            + fourth
                * (at[2]
                    + fourth * (at[4] + fourth * (at[6] + fourth * (at[8] + fourth * at[10])))));
    let even =
        fourth * (at[1] + fourth * (at[3] + fourth * (at[5] + fourth * (at[7] + fourth * at[9]))));
    let split =
        |part: [f64; 4]| choose([one(0.0), one(part[0]), one(part[1]), one(part[2]), one(part[3])]);
    split(SPLIT_HIGH) - (reduced * (odd + even) - split(SPLIT_LOW) - reduced)
}

/// Sine and cosine of `high + low`, at most π/4 and a little; `is_whole` where there is no low part.
#[inline(always)]
fn series<S: Simd>(simd: S, (high, low): (S::D, S::D), is_whole: S::N) -> (S::D, S::D) {
    let one = |number| simd.double(number);
    let [s1, s2, s3, s4, s5, s6] = SINE.map(one);
    let [c1, c2, c3, c4, c5, c6] = COSINE.map(one);
    let square = high * high;
    let fourth = square * square;
    let cube = square * high;
    let tail = s2 + square * (s3 + square * s4) + square * fourth * (s5 + square * s6);
    let whole = high + cube * (s1 + square * tail);
    let parted = high - ((square * (one(0.5) * low - cube * tail) - low) - cube * s1);
    let sine = S::D::select(is_whole, whole, parted);
    let tail = square * (c1 + square * (c2 + square * c3))
        + fourth * fourth * (c4 + square * (c5 + square * c6));
    let half = one(0.5) * square;
    let about = one(1.0) - half;
    let cosine = about + (((one(1.0) - about) - half) + (square * tail - high * low));
    (sine, cosine)
}

/// The bits of an answer that is yes in all lanes.
fn all<S: Simd>() -> u32 {
    (1 << (S::LANES / 2)) - 1
}

/// The lanes that are not usual, done one by one.
#[cold]
#[inline(never)]
fn rare<S: Simd>(simd: S, (is_usual, usual): (S::N, S::D), exact: impl Fn(usize) -> f64) -> S::D {
    let is_usual = is_usual.bits();
    simd.doubles(|lane| if is_usual >> lane & 1 == 1 { usual.lane(lane) } else { exact(lane) })
}

const _: () = assert!(NOT_REDUCED > FRAC_PI_4 && NEAR_PI < PI);

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_8, TAU};

    use super::*;
    use crate::batch::portable::Portable;

    /// Angles all around, and next to every place where a rule changes.
    fn angles() -> Vec<f64> {
        let around = (0..40_000).map(|step| TAU * (f64::from(step) / 40_000.0 - 0.5));
        let places = (-8..=8).map(|eighths| f64::from(eighths) * FRAC_PI_8);
        let edges = [NOT_REDUCED, REDUCED_ONCE, NEAR_HALF_PI.0, NEAR_HALF_PI.1, NEAR_PI, TINY];
        let steps = [0.0, 1e-300, 1e-17, 1e-12, 1e-9, 1e-7, 3e-7, 1e-6, 1e-4];
        let near = places
            .chain(edges.into_iter().flat_map(|edge| [edge, -edge]))
            .flat_map(|place| steps.iter().flat_map(move |step| [place - step, place + step]));
        around.chain(near).filter(|angle| angle.abs() <= PI).collect()
    }

    fn check<S: Simd>(simd: S) {
        let angles = angles();
        for chunk in angles.chunks(S::LANES / 2) {
            let angle = |lane: usize| chunk[lane.min(chunk.len() - 1)];

            let (sine, cosine) = sincos(simd, simd.doubles(angle));

            for lane in 0..chunk.len() {
                let found = (sine.lane(lane).to_bits(), cosine.lane(lane).to_bits());
                let (sine, cosine) = libm::sincos(angle(lane));
                assert_eq!(found, (sine.to_bits(), cosine.to_bits()), "{}", angle(lane));
            }
        }
        for chunk in angles.chunks(S::LANES / 2) {
            // Of any length, as of headings in single precision.
            let point = |lane: usize| {
                let (sine, cosine) = libm::sincos(chunk[lane.min(chunk.len() - 1)]);
                let length = 1.0 + 1e-7 * lane as f64;
                (f64::from((sine * length) as f32), f64::from((cosine * length) as f32))
            };

            let y = simd.doubles(|lane| point(lane).0);
            let x = simd.doubles(|lane| point(lane).1);
            let angle = atan2(simd, y, x);

            for lane in 0..chunk.len() {
                let (y, x) = point(lane);
                assert_eq!(angle.lane(lane).to_bits(), libm::atan2(y, x).to_bits(), "{y} {x}");
            }
        }
    }

    #[test]
    fn headings_have_the_bits_of_libm() {
        check(Portable);
        #[cfg(target_arch = "x86_64")]
        {
            if let Some(unit) = crate::batch::avx2::Avx2::find() {
                check(unit);
            }
            if let Some(unit) = crate::batch::avx512::Avx512::find() {
                check(unit);
            }
        }
    }

    #[test]
    fn axes_and_zeros_have_the_bits_of_libm() {
        let numbers = [0.0, -0.0, 1.0, -1.0, 1e-30, -1e-30, 0.5, -FRAC_PI_2, 1e300];
        for y in numbers {
            for x in numbers {
                let found = atan2(Portable, Portable.double(y), Portable.double(x)).lane(0);
                assert_eq!(found.to_bits(), libm::atan2(y, x).to_bits(), "{y} {x}");
            }
        }
    }
}
