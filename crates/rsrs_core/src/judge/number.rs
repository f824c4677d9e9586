//! Numbers of one world, or of several worlds at once with a lane for each.
//!
//! What is written over [`Number`] is written once: the judge of a bag computes with `f64`, that of
//! a sweep with the vectors of a processor. Only operations whose result IEEE 754 fixes to the bit
//! are offered, so a lane holds what a scalar would.

#![expect(
    clippy::inline_always,
    reason = "what is not inlined into the function of a vector unit does without its instructions"
)]

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// A number, or a vector with a number in each lane.
#[expect(clippy::return_self_not_must_use, reason = "they are used like operators")]
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
    /// How many lanes there are.
    const LANES: usize;

    /// A constant in all lanes. The number that it is called on does not matter: a caller that has
    /// one may make others.
    fn all(self, constant: Self::Scalar) -> Self;
    /// A number for each lane, whatever this one is.
    fn by_lane(self, number: impl FnMut(usize) -> Self::Scalar) -> Self;
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
    /// The number where the mask is false, and plus zero elsewhere.
    fn unless(self, mask: Self::Mask) -> Self;
    /// The number in one lane.
    fn lane(self, lane: usize) -> Self::Scalar;
}

/// Yes or no for each lane.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Send + 'static {
    /// The answers as bits, that of the first lane lowest.
    fn bits(self) -> u32;

    /// Whether it is yes in any lane.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
}

impl Mask for bool {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self)
    }
}

impl Number for f64 {
    type Scalar = Self;
    type Mask = bool;
    const LANES: usize = 1;

    #[inline(always)]
    fn all(self, constant: Self) -> Self {
        constant
    }
    #[inline(always)]
    fn by_lane(self, mut number: impl FnMut(usize) -> Self) -> Self {
        number(0)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn least(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    #[inline(always)]
    fn most(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self <= other
    }
    #[inline(always)]
    fn gt(self, other: Self) -> bool {
        self > other
    }
    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn unless(self, mask: bool) -> Self {
        if mask { 0.0 } else { self }
    }
    #[inline(always)]
    fn lane(self, _: usize) -> Self {
        self
    }
}
