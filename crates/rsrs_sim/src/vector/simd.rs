//! Vectors of numbers, one lane for each world, and what may be done with them.
//!
//! Only operations whose result IEEE 754 fixes to the bit: so a lane holds what a scalar would,
//! however wide the vector is. There is no fused multiply-add and no sum across lanes.

use std::ops::{Add, BitAnd, BitOr, BitXor, Mul};

use rsrs_core::judge::number::{Mask, Number};

/// A vector unit: the proof that this machine has it, and the maker of its vectors.
///
/// A value exists only where the unit was found, which is what makes the operations of its vectors
/// sound.
pub trait Simd: Copy + Send + Sync + 'static {
    /// Lanes of single precision: worlds that are simulated at once. Double precision has half.
    const LANES: usize = <Self::F as Number>::LANES;
    /// A vector of single precision.
    type F: Number<Scalar = f32, Mask = Self::M> + Sync;
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
    /// One word in all lanes.
    fn word(self, word: u32) -> Self::U;
    /// No in all lanes.
    fn no(self) -> Self::M;
    /// A number for each lane.
    #[inline(always)]
    fn singles(self, number: impl FnMut(usize) -> f32) -> Self::F {
        self.single(0.0).by_lane(number)
    }
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
