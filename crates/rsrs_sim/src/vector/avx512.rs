//! Sixteen worlds at a time: AVX-512.

#![expect(unsafe_code, reason = "instructions that a processor may lack")]

// Tests may import so, and there the lint is silent.
#[cfg_attr(not(test), expect(clippy::wildcard_imports, reason = "some sixty instructions"))]
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Sub};

use rsrs_core::judge::number::{Mask, Number};

use super::simd::{LaneU32, Simd, Work};
use super::x86::{bit_operator, number, operator};

/// The proof that this machine has AVX-512.
#[derive(Clone, Copy)]
pub struct Avx512(());

/// Sixteen numbers in single precision.
#[derive(Clone, Copy)]
pub struct Singles(__m512);
/// A mask of sixteen lanes.
#[derive(Clone, Copy)]
pub struct SinglesMask(__mmask16);
/// Sixteen words.
#[derive(Clone, Copy)]
pub struct LanesU32(__m512i);
/// Eight numbers in double precision.
#[derive(Clone, Copy)]
pub struct Doubles(__m512d);
/// A mask of eight lanes.
#[derive(Clone, Copy)]
pub struct DoublesMask(__mmask8);

impl Avx512 {
    /// The unit, if this machine has it.
    pub fn find() -> Option<Self> {
        (is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq"))
            .then_some(Self(()))
    }
}

operator!(Singles, Add, add, _mm512_add_ps);
operator!(Singles, Sub, sub, _mm512_sub_ps);
operator!(Singles, Mul, mul, _mm512_mul_ps);
operator!(Singles, Div, div, _mm512_div_ps);
operator!(Doubles, Add, add, _mm512_add_pd);
operator!(Doubles, Sub, sub, _mm512_sub_pd);
operator!(Doubles, Mul, mul, _mm512_mul_pd);
operator!(Doubles, Div, div, _mm512_div_pd);
bit_operator!(SinglesMask, BitAnd, bitand, &);
bit_operator!(SinglesMask, BitOr, bitor, |);
bit_operator!(DoublesMask, BitAnd, bitand, &);
bit_operator!(DoublesMask, BitOr, bitor, |);
operator!(LanesU32, Add, add, _mm512_add_epi32);
operator!(LanesU32, Mul, mul, _mm512_mullo_epi32);
operator!(LanesU32, BitXor, bitxor, _mm512_xor_si512);
operator!(LanesU32, BitAnd, bitand, _mm512_and_si512);
operator!(LanesU32, BitOr, bitor, _mm512_or_si512);

number!(
    Singles, __m512, SinglesMask, f32, 16,
    _mm512_set1_ps, _mm512_sqrt_ps, _mm512_min_ps, _mm512_max_ps, _mm512_cmp_ps_mask,
    abs: |number| _mm512_abs_ps(number),
    select: |which, yes, no| _mm512_mask_blend_ps(which, no, yes),
    unless: |kept, dropped| _mm512_maskz_mov_ps(!dropped, kept),
);
number!(
    Doubles, __m512d, DoublesMask, f64, 8,
    _mm512_set1_pd, _mm512_sqrt_pd, _mm512_min_pd, _mm512_max_pd, _mm512_cmp_pd_mask,
    abs: |number| _mm512_abs_pd(number),
    select: |which, yes, no| _mm512_mask_blend_pd(which, no, yes),
    unless: |kept, dropped| _mm512_maskz_mov_pd(!dropped, kept),
);

impl Mask for SinglesMask {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
}

impl Mask for DoublesMask {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
}

impl LaneU32 for LanesU32 {
    #[inline(always)]
    fn shr(self, bits: u32) -> Self {
        // SAFETY: vectors come from a unit that was found on this machine.
        Self(unsafe { _mm512_srlv_epi32(self.0, _mm512_set1_epi32(bits.cast_signed())) })
    }
    #[inline(always)]
    fn shl(self, bits: u32) -> Self {
        // SAFETY: as above.
        Self(unsafe { _mm512_sllv_epi32(self.0, _mm512_set1_epi32(bits.cast_signed())) })
    }
}

impl Simd for Avx512 {
    type F = Singles;
    type M = SinglesMask;
    type U = LanesU32;
    type D = Doubles;
    type N = DoublesMask;

    #[inline(always)]
    fn single(self, number: f32) -> Singles {
        // SAFETY: `self` is the proof that this machine has the unit; so below.
        Singles(unsafe { _mm512_set1_ps(number) })
    }
    #[inline(always)]
    fn word(self, word: u32) -> LanesU32 {
        // SAFETY: as above.
        LanesU32(unsafe { _mm512_set1_epi32(word.cast_signed()) })
    }
    #[inline(always)]
    fn no(self) -> SinglesMask {
        SinglesMask(0)
    }
    #[inline(always)]
    fn words(self, word: impl FnMut(usize) -> u32) -> LanesU32 {
        let words: [u32; 16] = std::array::from_fn(word);
        // SAFETY: both are the same number of plain words.
        LanesU32(unsafe { std::mem::transmute::<[u32; 16], __m512i>(words) })
    }
    #[inline(always)]
    fn half<const HALF: usize>(self, numbers: Singles) -> Doubles {
        // SAFETY: as above.
        Doubles(unsafe {
            _mm512_cvtps_pd(if HALF == 0 {
                _mm512_castps512_ps256(numbers.0)
            } else {
                _mm512_extractf32x8_ps::<1>(numbers.0)
            })
        })
    }
    #[inline(always)]
    fn bits(self, numbers: Singles) -> LanesU32 {
        // SAFETY: as above.
        LanesU32(unsafe { _mm512_castps_si512(numbers.0) })
    }
    #[inline(always)]
    fn with_bits(self, words: LanesU32) -> Singles {
        // SAFETY: as above.
        Singles(unsafe { _mm512_castsi512_ps(words.0) })
    }
    #[inline(always)]
    fn to_singles(self, words: LanesU32) -> Singles {
        // SAFETY: as above.
        Singles(unsafe { _mm512_cvtepi32_ps(words.0) })
    }
    #[inline(always)]
    fn to_words(self, numbers: Singles) -> LanesU32 {
        // SAFETY: as above.
        LanesU32(unsafe { _mm512_cvttps_epi32(numbers.0) })
    }
    #[inline(always)]
    fn less(self, words: LanesU32, than: LanesU32) -> SinglesMask {
        // SAFETY: as above.
        SinglesMask(unsafe { _mm512_cmplt_epi32_mask(words.0, than.0) })
    }
    #[inline(always)]
    fn select(self, mask: SinglesMask, yes: LanesU32, no: LanesU32) -> LanesU32 {
        // SAFETY: as above.
        LanesU32(unsafe { _mm512_mask_blend_epi32(mask.0, no.0, yes.0) })
    }
    #[inline]
    fn vectorize<W: Work>(self, work: W) -> W::Output {
        #[target_feature(enable = "avx512f,avx512dq")]
        fn with_unit<W: Work>(work: W) -> W::Output {
            work.run()
        }
        // SAFETY: as above.
        unsafe { with_unit(work) }
    }
}
