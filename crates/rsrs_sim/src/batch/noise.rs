//! Draws and turns in lanes: what [`crate::draw`] and [`crate::turn`] define.

use rsrs_core::judge::number::Number;

use crate::draw::Key;
use crate::turn::{self, HALF_PI, ROUNDER};

use crate::vector::simd::{LaneU32, Simd};

/// The keys of one robot's draws for one purpose, in every world.
#[derive(Clone, Copy)]
pub struct LaneKey<U> {
    low: U,
    high: U,
}

impl<U: LaneU32> LaneKey<U> {
    /// The keys of all lanes.
    pub fn new<S: Simd<U = U>>(simd: S, key: impl Fn(usize) -> Key) -> Self {
        Self { low: simd.words(|lane| key(lane).low), high: simd.words(|lane| key(lane).high) }
    }

    /// As [`Key::uniform24`].
    #[inline(always)]
    pub fn uniform24<S: Simd<U = U>>(self, simd: S, counter: U) -> U {
        let word = self.low + counter;
        let word = (word ^ word.shr(16)) * simd.word(0x21f0_aaad) + self.high;
        let word = (word ^ word.shr(15)) * simd.word(0xd35a_2d97);
        (word ^ word.shr(15)).shr(8)
    }

    /// As [`Key::normal`].
    #[inline(always)]
    pub fn normal<S: Simd<U = U>>(self, simd: S, counter: U) -> S::F {
        let first = self.above_zero(simd, counter.shl(1));
        let second = self.above_zero(simd, counter.shl(1) + simd.word(1));
        let (cosine, _) = turn(simd, second * simd.single(std::f32::consts::TAU));
        (simd.single(-2.0) * natural_logarithm(simd, first)).sqrt() * cosine
    }
}

impl<U: LaneU32> LaneKey<U> {
    /// A number above 0 and up to 1.
    #[inline(always)]
    fn above_zero<S: Simd<U = U>>(self, simd: S, counter: U) -> S::F {
        let above_zero = self.uniform24(simd, counter) + simd.word(1);
        simd.to_singles(above_zero) * simd.single(1.0 / 16_777_216.0)
    }

    /// A number with this noise in each step, if there is any.
    #[inline(always)]
    pub fn with_noise<S: Simd<U = U>>(
        self,
        simd: S,
        step: U,
        number: S::F,
        sd: Option<S::F>,
    ) -> S::F {
        match sd {
            Some(sd) => number + sd * self.normal(simd, step),
            None => number,
        }
    }
}

/// As [`turn::turn`], of angles below its [`turn::LIMIT_RAD`].
#[inline(always)]
pub fn turn<S: Simd>(simd: S, angle_rad: S::F) -> (S::F, S::F) {
    let one = |number| simd.single(number);
    let rounder = one(ROUNDER);
    let quarters = (angle_rad * one(std::f32::consts::FRAC_2_PI) + rounder) - rounder;
    let rest = ((angle_rad - quarters * one(HALF_PI[0])) - quarters * one(HALF_PI[1]))
        - quarters * one(HALF_PI[2]);
    let square = rest * rest;
    let [sine_1, sine_2, sine_3] = turn::SINE.map(one);
    let sine = rest + rest * square * (sine_1 + square * (sine_2 + square * sine_3));
    let [cosine_1, cosine_2, cosine_3] = turn::COSINE.map(one);
    let cosine = one(1.0) - one(0.5) * square
        + square * square * (cosine_1 + square * (cosine_2 + square * cosine_3));
    let quadrant = simd.to_words(quarters);
    let is_odd = simd.less(simd.word(0), quadrant & simd.word(1));
    let (cosine, sine) = (S::F::select(is_odd, sine, cosine), S::F::select(is_odd, cosine, sine));
    // A bit of the quadrant becomes the sign.
    let cosine_sign = ((quadrant + simd.word(1)) & simd.word(2)).shl(30);
    let sine_sign = (quadrant & simd.word(2)).shl(30);
    (simd.with_bits(simd.bits(cosine) ^ cosine_sign), simd.with_bits(simd.bits(sine) ^ sine_sign))
}

/// As the logarithm of [`crate::draw`].
#[inline(always)]
fn natural_logarithm<S: Simd>(simd: S, number: S::F) -> S::F {
    let one = |number| simd.single(number);
    let bits = simd.bits(number);
    let mantissa = simd.with_bits((bits & simd.word(0x007f_ffff)) | simd.word(0x3f80_0000));
    let above = mantissa.gt(one(std::f32::consts::SQRT_2));
    let mantissa = S::F::select(above, mantissa * one(0.5), mantissa);
    let bias = simd.select(above, simd.word(126), simd.word(127));
    // Exact: both are whole numbers below 256.
    let exponent = simd.to_singles(bits.shr(23)) - simd.to_singles(bias);
    let ratio = (mantissa - one(1.0)) / (mantissa + one(1.0));
    let square = ratio * ratio;
    let fourth = one(1.0 / 7.0) + square * one(1.0 / 9.0);
    let series = one(1.0) + square * (one(1.0 / 3.0) + square * (one(1.0 / 5.0) + square * fourth));
    exponent * one(std::f32::consts::LN_2) + one(2.0) * ratio * series
}
