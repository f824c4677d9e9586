//! Four worlds at a time in plain Rust: what every machine has, and what compilers turn into SSE2
//! or NEON.

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Sub};

use rsrs_core::judge::number::{Mask, Number};

use super::simd::{LaneU32, Simd, Work};

/// The unit that every machine has.
#[derive(Clone, Copy)]
pub struct Portable;

/// A lane for each world.
#[derive(Clone, Copy)]
#[repr(align(16))]
pub struct Lanes<T, const N: usize>([T; N]);

/// All bits of a lane, or none.
#[derive(Clone, Copy)]
#[repr(align(16))]
pub struct LanesMask<T, const N: usize>([T; N]);

/// Arrays that are written out lane by lane: of a loop, a compiler that looks at a function once makes vectors
/// only by halves.
trait Unrolled<T> {
    /// What `of` gives for each lane, from 0.
    fn lanes(of: impl FnMut(usize) -> T) -> Self;
}

impl<T> Unrolled<T> for [T; 2] {
    #[inline(always)]
    fn lanes(mut of: impl FnMut(usize) -> T) -> Self {
        [of(0), of(1)]
    }
}

impl<T> Unrolled<T> for [T; 4] {
    #[inline(always)]
    fn lanes(mut of: impl FnMut(usize) -> T) -> Self {
        [of(0), of(1), of(2), of(3)]
    }
}

#[inline(always)]
fn zip<T: Copy, R, const N: usize>(left: [T; N], right: [T; N], f: impl Fn(T, T) -> R) -> [R; N]
where
    [R; N]: Unrolled<R>,
{
    Unrolled::lanes(|lane| f(left[lane], right[lane]))
}

#[inline(always)]
fn map<T: Copy, R, const N: usize>(numbers: [T; N], f: impl Fn(T) -> R) -> [R; N]
where
    [R; N]: Unrolled<R>,
{
    Unrolled::lanes(|lane| f(numbers[lane]))
}

macro_rules! operator {
    ($wrapper:ident<$scalar:ty, $n:literal>, $trait:ident, $method:ident, $scalar_method:expr) => {
        impl $trait for $wrapper<$scalar, $n> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(zip(self.0, other.0, $scalar_method))
            }
        }
    };
}

macro_rules! number {
    ($scalar:ty, $bits:ty, $n:literal) => {
        operator!(Lanes<$scalar, $n>, Add, add, |a, b| a + b);
        operator!(Lanes<$scalar, $n>, Sub, sub, |a, b| a - b);
        operator!(Lanes<$scalar, $n>, Mul, mul, |a, b| a * b);
        operator!(Lanes<$scalar, $n>, Div, div, |a, b| a / b);
        operator!(LanesMask<$bits, $n>, BitAnd, bitand, |a, b| a & b);
        operator!(LanesMask<$bits, $n>, BitOr, bitor, |a, b| a | b);

        impl Mask for LanesMask<$bits, $n> {
            #[inline(always)]
            fn bits(self) -> u32 {
                (0..$n).fold(0, |bits, lane| bits | ((self.0[lane] & 1) as u32) << lane)
            }
        }

        impl Number for Lanes<$scalar, $n> {
            type Scalar = $scalar;
            type Mask = LanesMask<$bits, $n>;
            const LANES: usize = $n;
            #[inline(always)]
            fn all(self, constant: $scalar) -> Self {
                Self([constant; $n])
            }
            #[inline(always)]
            fn by_lane(self, number: impl FnMut(usize) -> $scalar) -> Self {
                Self(Unrolled::lanes(number))
            }
            #[inline(always)]
            fn abs(self) -> Self {
                Self(map(self.0, <$scalar>::abs))
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(map(self.0, <$scalar>::sqrt))
            }
            #[inline(always)]
            fn least(self, other: Self) -> Self {
                Self(zip(self.0, other.0, |a, b| if a < b { a } else { b }))
            }
            #[inline(always)]
            fn most(self, other: Self) -> Self {
                Self(zip(self.0, other.0, |a, b| if a > b { a } else { b }))
            }
            #[inline(always)]
            fn lt(self, other: Self) -> Self::Mask {
                LanesMask(zip(self.0, other.0, |a, b| (0 as $bits).wrapping_sub((a < b) as $bits)))
            }
            #[inline(always)]
            fn le(self, other: Self) -> Self::Mask {
                LanesMask(zip(self.0, other.0, |a, b| (0 as $bits).wrapping_sub((a <= b) as $bits)))
            }
            #[inline(always)]
            fn gt(self, other: Self) -> Self::Mask {
                LanesMask(zip(self.0, other.0, |a, b| (0 as $bits).wrapping_sub((a > b) as $bits)))
            }
            #[inline(always)]
            fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
                Self(Unrolled::lanes(|lane| {
                    let (yes, no) = (yes.0[lane].to_bits(), no.0[lane].to_bits());
                    <$scalar>::from_bits((yes & mask.0[lane]) | (no & !mask.0[lane]))
                }))
            }
            #[inline(always)]
            fn unless(self, mask: Self::Mask) -> Self {
                Self(Unrolled::lanes(|lane| {
                    <$scalar>::from_bits(self.0[lane].to_bits() & !mask.0[lane])
                }))
            }
            #[inline(always)]
            fn lane(self, lane: usize) -> $scalar {
                self.0[lane]
            }
        }
    };
}

number!(f32, u32, 4);
number!(f64, u64, 2);
operator!(Lanes<u32, 4>, Add, add, u32::wrapping_add);
operator!(Lanes<u32, 4>, Mul, mul, u32::wrapping_mul);
operator!(Lanes<u32, 4>, BitXor, bitxor, |a, b| a ^ b);
operator!(Lanes<u32, 4>, BitAnd, bitand, |a, b| a & b);
operator!(Lanes<u32, 4>, BitOr, bitor, |a, b| a | b);

impl LaneU32 for Lanes<u32, 4> {
    #[inline(always)]
    fn shr(self, bits: u32) -> Self {
        Self(map(self.0, |word| word >> bits))
    }
    #[inline(always)]
    fn shl(self, bits: u32) -> Self {
        Self(map(self.0, |word| word << bits))
    }
}

impl Simd for Portable {
    type F = Lanes<f32, 4>;
    type M = LanesMask<u32, 4>;
    type U = Lanes<u32, 4>;
    type D = Lanes<f64, 2>;
    type N = LanesMask<u64, 2>;

    #[inline(always)]
    fn single(self, number: f32) -> Self::F {
        Lanes([number; 4])
    }
    #[inline(always)]
    fn word(self, word: u32) -> Self::U {
        Lanes([word; 4])
    }
    #[inline(always)]
    fn no(self) -> Self::M {
        LanesMask([0; 4])
    }
    #[inline(always)]
    fn words(self, word: impl FnMut(usize) -> u32) -> Self::U {
        Lanes(Unrolled::lanes(word))
    }
    #[inline(always)]
    fn half<const HALF: usize>(self, numbers: Self::F) -> Self::D {
        Lanes(Unrolled::lanes(|lane| f64::from(numbers.0[2 * HALF + lane])))
    }
    #[inline(always)]
    fn bits(self, numbers: Self::F) -> Self::U {
        Lanes(map(numbers.0, f32::to_bits))
    }
    #[inline(always)]
    fn with_bits(self, words: Self::U) -> Self::F {
        Lanes(map(words.0, f32::from_bits))
    }
    #[inline(always)]
    fn to_singles(self, words: Self::U) -> Self::F {
        Lanes(map(words.0, |word| word.cast_signed() as f32))
    }
    #[inline(always)]
    fn to_words(self, numbers: Self::F) -> Self::U {
        Lanes(map(numbers.0, |number| (number as i32).cast_unsigned()))
    }
    #[inline(always)]
    fn less(self, words: Self::U, than: Self::U) -> Self::M {
        LanesMask(zip(words.0, than.0, |a, b| 0_u32.wrapping_sub(u32::from(a < b))))
    }
    #[inline(always)]
    fn select(self, mask: Self::M, yes: Self::U, no: Self::U) -> Self::U {
        Lanes(Unrolled::lanes(|lane| (yes.0[lane] & mask.0[lane]) | (no.0[lane] & !mask.0[lane])))
    }
    #[inline(always)]
    fn vectorize<W: Work>(self, work: W) -> W::Output {
        work.run()
    }
}
