//! Eight worlds at a time: AVX2.

#![expect(unsafe_code, reason = "instructions that a processor may lack")]

// Tests may import so, and there the lint is silent.
#[cfg_attr(not(test), expect(clippy::wildcard_imports, reason = "some sixty instructions"))]
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Sub};

use rsrs_core::judge::number::{Mask, Number};

use super::simd::{LaneU32, Simd, Work};
use super::x86::{number, operator};

/// The proof that this machine has AVX2.
#[derive(Clone, Copy)]
pub struct Avx2(());

/// Eight numbers in single precision.
#[derive(Clone, Copy)]
pub struct Singles(__m256);
/// A mask of eight lanes: all bits of a lane, or none.
#[derive(Clone, Copy)]
pub struct SinglesMask(__m256);
/// Eight words.
#[derive(Clone, Copy)]
pub struct LanesU32(__m256i);
/// Four numbers in double precision.
#[derive(Clone, Copy)]
pub struct Doubles(__m256d);
/// A mask of four lanes: all bits of a lane, or none.
#[derive(Clone, Copy)]
pub struct DoublesMask(__m256d);

impl Avx2 {
    /// The unit, if this machine has it.
    pub fn find() -> Option<Self> {
        is_x86_feature_detected!("avx2").then_some(Self(()))
    }
}

operator!(Singles, Add, add, _mm256_add_ps);
operator!(Singles, Sub, sub, _mm256_sub_ps);
operator!(Singles, Mul, mul, _mm256_mul_ps);
operator!(Singles, Div, div, _mm256_div_ps);
operator!(Doubles, Add, add, _mm256_add_pd);
operator!(Doubles, Sub, sub, _mm256_sub_pd);
operator!(Doubles, Mul, mul, _mm256_mul_pd);
operator!(Doubles, Div, div, _mm256_div_pd);
operator!(SinglesMask, BitAnd, bitand, _mm256_and_ps);
operator!(SinglesMask, BitOr, bitor, _mm256_or_ps);
operator!(DoublesMask, BitAnd, bitand, _mm256_and_pd);
operator!(DoublesMask, BitOr, bitor, _mm256_or_pd);
operator!(LanesU32, Add, add, _mm256_add_epi32);
operator!(LanesU32, Mul, mul, _mm256_mullo_epi32);
operator!(LanesU32, BitXor, bitxor, _mm256_xor_si256);
operator!(LanesU32, BitAnd, bitand, _mm256_and_si256);
operator!(LanesU32, BitOr, bitor, _mm256_or_si256);

number!(
    Singles, __m256, SinglesMask, f32, 8,
    _mm256_set1_ps, _mm256_sqrt_ps, _mm256_min_ps, _mm256_max_ps, _mm256_cmp_ps,
    abs: |number| _mm256_andnot_ps(_mm256_set1_ps(-0.0), number),
    select: |which, yes, no| _mm256_blendv_ps(no, yes, which),
    unless: |kept, dropped| _mm256_andnot_ps(dropped, kept),
);
number!(
    Doubles, __m256d, DoublesMask, f64, 4,
    _mm256_set1_pd, _mm256_sqrt_pd, _mm256_min_pd, _mm256_max_pd, _mm256_cmp_pd,
    abs: |number| _mm256_andnot_pd(_mm256_set1_pd(-0.0), number),
    select: |which, yes, no| _mm256_blendv_pd(no, yes, which),
    unless: |kept, dropped| _mm256_andnot_pd(dropped, kept),
);

impl Mask for SinglesMask {
    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: vectors come from a unit that was found on this machine.
        unsafe { _mm256_movemask_ps(self.0) }.cast_unsigned()
    }
}

impl Mask for DoublesMask {
    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: as above.
        unsafe { _mm256_movemask_pd(self.0) }.cast_unsigned()
    }
}

impl LaneU32 for LanesU32 {
    #[inline(always)]
    fn shr(self, bits: u32) -> Self {
        // SAFETY: vectors come from a unit that was found on this machine.
        Self(unsafe { _mm256_srlv_epi32(self.0, _mm256_set1_epi32(bits.cast_signed())) })
    }
    #[inline(always)]
    fn shl(self, bits: u32) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm256_sllv_epi32(self.0, _mm256_set1_epi32(bits.cast_signed())) })
    }
}

impl Simd for Avx2 {
    type F = Singles;
    type M = SinglesMask;
    type U = LanesU32;
    type D = Doubles;
    type N = DoublesMask;

    #[inline(always)]
    fn single(self, number: f32) -> Singles {
        // SAFETY: `self` is the proof that this machine has the unit; so below.
        Singles(unsafe { _mm256_set1_ps(number) })
    }
    #[inline(always)]
    fn word(self, word: u32) -> LanesU32 {
        // SAFETY: as above.
        LanesU32(unsafe { _mm256_set1_epi32(word.cast_signed()) })
    }
    #[inline(always)]
    fn no(self) -> SinglesMask {
        // SAFETY: as above.
        SinglesMask(unsafe { _mm256_setzero_ps() })
    }
    #[inline(always)]
    fn words(self, word: impl FnMut(usize) -> u32) -> LanesU32 {
        let words: [u32; 8] = std::array::from_fn(word);
        // SAFETY: both are the same number of plain words.
        LanesU32(unsafe { std::mem::transmute::<[u32; 8], __m256i>(words) })
    }
    #[inline(always)]
    fn half<const HALF: usize>(self, numbers: Singles) -> Doubles {
        // SAFETY: as above.
        Doubles(unsafe {
            _mm256_cvtps_pd(if HALF == 0 {
                _mm256_castps256_ps128(numbers.0)
            } else {
                _mm256_extractf128_ps::<1>(numbers.0)
            })
        })
    }
    #[inline(always)]
    fn bits(self, numbers: Singles) -> LanesU32 {
        // SAFETY: as above.
        LanesU32(unsafe { _mm256_castps_si256(numbers.0) })
    }
    #[inline(always)]
    fn with_bits(self, words: LanesU32) -> Singles {
        // SAFETY: as above.
        Singles(unsafe { _mm256_castsi256_ps(words.0) })
    }
    #[inline(always)]
    fn to_singles(self, words: LanesU32) -> Singles {
        // SAFETY: as above.
        Singles(unsafe { _mm256_cvtepi32_ps(words.0) })
    }
    #[inline(always)]
    fn to_words(self, numbers: Singles) -> LanesU32 {
        // SAFETY: as above.
        LanesU32(unsafe { _mm256_cvttps_epi32(numbers.0) })
    }
    #[inline(always)]
    fn less(self, words: LanesU32, than: LanesU32) -> SinglesMask {
        // SAFETY: as above.
        SinglesMask(unsafe { _mm256_castsi256_ps(_mm256_cmpgt_epi32(than.0, words.0)) })
    }
    #[inline(always)]
    fn select(self, mask: SinglesMask, yes: LanesU32, no: LanesU32) -> LanesU32 {
        // SAFETY: as above.
        LanesU32(unsafe { _mm256_blendv_epi8(no.0, yes.0, _mm256_castps_si256(mask.0)) })
    }
    #[inline]
    fn vectorize<W: Work>(self, work: W) -> W::Output {
        #[target_feature(enable = "avx2")]
        fn with_unit<W: Work>(work: W) -> W::Output {
            work.run()
        }
        // SAFETY: as above.
        unsafe { with_unit(work) }
    }
}
