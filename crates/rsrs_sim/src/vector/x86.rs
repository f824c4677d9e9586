//! What the vectors of both x86-64 units share: the shape of their operators and numbers.

/// An operator of two vectors by one instruction.
macro_rules! operator {
    ($vector:ty, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for $vector {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: vectors come from a unit that was found on this machine.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}

/// An operator of two masks that are whole numbers.
macro_rules! bit_operator {
    ($mask:ty, $trait:ident, $method:ident, $operator:tt) => {
        impl $trait for $mask {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0 $operator other.0)
            }
        }
    };
}

/// The numbers of a unit: a register, its mask, and the instructions for them; the three that differ in
/// more than their names are given as expressions of what they take.
macro_rules! number {
    (
        $vector:ident, $register:ident, $mask:ident, $scalar:ty, $n:literal,
        $set:ident, $sqrt:ident, $min:ident, $max:ident, $cmp:ident,
        abs: |$number:ident| $abs:expr,
        select: |$which:ident, $yes:ident, $no:ident| $select:expr,
        unless: |$kept:ident, $dropped:ident| $unless:expr $(,)?
    ) => {
        impl Number for $vector {
            type Scalar = $scalar;
            type Mask = $mask;
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
                let $number = self.0;
                // SAFETY: as above.
                Self(unsafe { $abs })
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
                $mask(unsafe { $cmp::<_CMP_LT_OQ>(self.0, other.0) })
            }
            #[inline(always)]
            fn le(self, other: Self) -> Self::Mask {
                // SAFETY: as above.
                $mask(unsafe { $cmp::<_CMP_LE_OQ>(self.0, other.0) })
            }
            #[inline(always)]
            fn gt(self, other: Self) -> Self::Mask {
                // SAFETY: as above.
                $mask(unsafe { $cmp::<_CMP_GT_OQ>(self.0, other.0) })
            }
            #[inline(always)]
            fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
                let ($which, $yes, $no) = (mask.0, yes.0, no.0);
                // SAFETY: as above.
                Self(unsafe { $select })
            }
            #[inline(always)]
            fn unless(self, mask: Self::Mask) -> Self {
                let ($kept, $dropped) = (self.0, mask.0);
                // SAFETY: as above.
                Self(unsafe { $unless })
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

pub(super) use {bit_operator, number, operator};
