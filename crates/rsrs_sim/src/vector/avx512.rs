//! Sixteen worlds at a time: AVX-512.

// Tests may import so, and there the lint is silent.
#[cfg_attr(not(test), expect(clippy::wildcard_imports, reason = "some sixty instructions"))]
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Sub};

use rsrs_core::number::{Mask, Number};

use super::simd::{LaneU32, Simd, Work};
use super::x86::{bit_operator, operator};

/// The proof that this machine has AVX-512.
#[derive(Clone, Copy)]
pub struct Avx512(());

/// Sixteen numbers in single precision.
#[derive(Clone, Copy)]
pub struct Singles(__m512);
/// Sixteen answers.
#[derive(Clone, Copy)]
pub struct Answers(__mmask16);
/// Sixteen words.
#[derive(Clone, Copy)]
pub struct LanesU32(__m512i);
/// Eight numbers in double precision.
#[derive(Clone, Copy)]
pub struct Doubles(__m512d);
/// Eight answers.
#[derive(Clone, Copy)]
pub struct DoubleAnswers(__mmask8);

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
bit_operator!(Answers, BitAnd, bitand, &);
bit_operator!(Answers, BitOr, bitor, |);
bit_operator!(DoubleAnswers, BitAnd, bitand, &);
bit_operator!(DoubleAnswers, BitOr, bitor, |);
operator!(LanesU32, Add, add, _mm512_add_epi32);
operator!(LanesU32, Mul, mul, _mm512_mullo_epi32);
operator!(LanesU32, BitXor, bitxor, _mm512_xor_si512);
operator!(LanesU32, BitAnd, bitand, _mm512_and_si512);
operator!(LanesU32, BitOr, bitor, _mm512_or_si512);

macro_rules! number {
    ($vector:ident, $register:ident, $answers:ident, $scalar:ty, $n:literal, $set:ident, $abs:ident, $zeroing:ident, $sqrt:ident,
     $min:ident, $max:ident, $cmp:ident, $blend:ident) => {
        impl Mask for $answers {
            #[inline(always)]
            fn bits(self) -> u32 {
                u32::from(self.0)
            }
        }

        impl Number for $vector {
            type Scalar = $scalar;
            type Mask = $answers;
            const LANES: usize = $n;
            #[inline(always)]
            fn all(self, constant: $scalar) -> Self {
                // SAFETY: vectors come from a unit that was found on this machine; so below.
                Self(unsafe { $set(constant) })
            }
            #[inline(always)]
            fn by_lane(self, number: impl FnMut(usize) -> $scalar) -> Self {
                let numbers: [$scalar; $n] = std::array::from_fn(number);
                // SAFETY: both are the same number of plain numbers.
                Self(unsafe { std::mem::transmute::<[$scalar; $n], $register>(numbers) })
            }
            #[inline(always)]
            fn abs(self) -> Self {
                // SAFETY: vectors come from a unit that was found on this machine.
                Self(unsafe { $abs(self.0) })
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                // SAFETY: as above.
                Self(unsafe { $sqrt(self.0) })
            }
            #[inline(always)]
            fn least(self, other: Self) -> Self {
                // SAFETY: as above.
                Self(unsafe { $min(self.0, other.0) })
            }
            #[inline(always)]
            fn most(self, other: Self) -> Self {
                // SAFETY: as above.
                Self(unsafe { $max(self.0, other.0) })
            }
            #[inline(always)]
            fn lt(self, other: Self) -> Self::Mask {
                // SAFETY: as above.
                $answers(unsafe { $cmp::<_CMP_LT_OQ>(self.0, other.0) })
            }
            #[inline(always)]
            fn le(self, other: Self) -> Self::Mask {
                // SAFETY: as above.
                $answers(unsafe { $cmp::<_CMP_LE_OQ>(self.0, other.0) })
            }
            #[inline(always)]
            fn gt(self, other: Self) -> Self::Mask {
                // SAFETY: as above.
                $answers(unsafe { $cmp::<_CMP_GT_OQ>(self.0, other.0) })
            }
            #[inline(always)]
            fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
                // SAFETY: as above.
                Self(unsafe { $blend(mask.0, no.0, yes.0) })
            }
            #[inline(always)]
            fn unless(self, mask: Self::Mask) -> Self {
                // SAFETY: as above.
                Self(unsafe { $zeroing(!mask.0, self.0) })
            }
            #[inline(always)]
            fn lane(self, lane: usize) -> $scalar {
                // SAFETY: both are the same number of plain numbers.
                let numbers: [$scalar; $n] = unsafe { std::mem::transmute(self.0) };
                numbers[lane]
            }
        }
    };
}

number!(
    Singles,
    __m512,
    Answers,
    f32,
    16,
    _mm512_set1_ps,
    _mm512_abs_ps,
    _mm512_maskz_mov_ps,
    _mm512_sqrt_ps,
    _mm512_min_ps,
    _mm512_max_ps,
    _mm512_cmp_ps_mask,
    _mm512_mask_blend_ps
);
number!(
    Doubles,
    __m512d,
    DoubleAnswers,
    f64,
    8,
    _mm512_set1_pd,
    _mm512_abs_pd,
    _mm512_maskz_mov_pd,
    _mm512_sqrt_pd,
    _mm512_min_pd,
    _mm512_max_pd,
    _mm512_cmp_pd_mask,
    _mm512_mask_blend_pd
);

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
    type M = Answers;
    type U = LanesU32;
    type D = Doubles;
    type N = DoubleAnswers;

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
    fn no(self) -> Answers {
        Answers(0)
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
    fn less(self, words: LanesU32, than: LanesU32) -> Answers {
        // SAFETY: as above.
        Answers(unsafe { _mm512_cmplt_epi32_mask(words.0, than.0) })
    }
    #[inline(always)]
    fn select(self, mask: Answers, yes: LanesU32, no: LanesU32) -> LanesU32 {
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
