//! Vectors of numbers, one lane for each world, and what may be done with them.
//!
//! Only operations whose result IEEE 754 fixes to the bit: so a lane holds what a scalar would,
//! however wide the vector is. There is no fused multiply-add and no sum across lanes.

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Sub};

/// A vector unit: the proof that this machine has it, and the maker of its vectors.
///
/// A value exists only where the unit was found, which is what makes the operations of its vectors
/// sound.
pub trait Simd: Copy + Send + Sync + 'static {
    /// Lanes of single precision: worlds that are simulated at once. Double precision has half.
    const LANES: usize;
    /// A vector of single precision.
    type F: Number<Scalar = f32, Mask = Self::M>;
    /// Yes or no for each lane of single precision.
    type M: Mask;
    /// A vector of words.
    type U: LaneU32;
    /// A vector of double precision, for half of the worlds.
    type D: Number<Scalar = f64, Mask = Self::N>;
    /// Yes or no for each lane of double precision.
    type N: Mask;

    /// One number in all lanes.
    fn single(self, number: f32) -> Self::F;
    /// One number in all lanes.
    fn double(self, number: f64) -> Self::D;
    /// One word in all lanes.
    fn word(self, word: u32) -> Self::U;
    /// No in all lanes.
    fn no(self) -> Self::M;
    /// A number for each lane.
    fn singles(self, number: impl FnMut(usize) -> f32) -> Self::F;
    /// A number for each lane.
    fn doubles(self, number: impl FnMut(usize) -> f64) -> Self::D;
    /// A word for each lane.
    fn words(self, word: impl FnMut(usize) -> u32) -> Self::U;

    /// The lower or the upper half of the lanes in double precision; `HALF` is 0 or 1.
    fn half<const HALF: usize>(self, numbers: Self::F) -> Self::D;
    /// The bits of numbers.
    fn bits(self, numbers: Self::F) -> Self::U;
    /// The numbers with these bits.
    fn with_bits(self, words: Self::U) -> Self::F;
    /// Words below 2^31, as numbers to the nearest.
    fn to_singles(self, words: Self::U) -> Self::F;
    /// Whole numbers of less than 2^31 as words, in two's complement.
    fn to_words(self, numbers: Self::F) -> Self::U;
    /// Whether words below 2^31 are less than others.
    fn less(self, words: Self::U, than: Self::U) -> Self::M;
    /// One word or the other.
    fn select(self, mask: Self::M, yes: Self::U, no: Self::U) -> Self::U;

    /// Does work with the instructions of this unit; all that it calls must be inlined into it.
    fn vectorize<W: Work>(self, work: W) -> W::Output;
}

/// Work for [`Simd::vectorize`].
pub trait Work {
    /// What comes out.
    type Output;
    /// Does it. To be marked `#[inline(always)]`.
    fn run(self) -> Self::Output;
}

/// A vector of numbers.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Send
    + 'static
{
    /// One lane.
    type Scalar;
    /// Yes or no for each lane.
    type Mask: Mask;

    /// Absolute values.
    fn abs(self) -> Self;
    /// Square roots.
    fn sqrt(self) -> Self;
    /// The lesser of two numbers, neither of them `NaN` nor both of them zero.
    fn least(self, other: Self) -> Self;
    /// The greater of two numbers, neither of them `NaN` nor both of them zero.
    fn most(self, other: Self) -> Self;
    /// `self < other`
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`
    fn le(self, other: Self) -> Self::Mask;
    /// `self > other`
    fn gt(self, other: Self) -> Self::Mask;
    /// One number or the other.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The number where the mask says no, and plus zero elsewhere.
    fn unless(self, mask: Self::Mask) -> Self;
    /// The number in one lane.
    fn lane(self, lane: usize) -> Self::Scalar;
}

/// A vector of answers.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Send + 'static {
    /// The answers as bits, that of the first lane lowest.
    fn bits(self) -> u32;

    /// Whether it is yes in any lane.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
}

/// A vector of words; arithmetic wraps.
pub trait LaneU32:
    Copy
    + Add<Output = Self>
    + Mul<Output = Self>
    + BitXor<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + Send
    + 'static
{
    /// Shifts to the right, filling with zeros.
    fn shr(self, bits: u32) -> Self;
    /// Shifts to the left.
    fn shl(self, bits: u32) -> Self;
}
