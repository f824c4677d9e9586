//! What the vectors of both x86-64 units share: the shape of their operators.

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

pub(super) use {bit_operator, operator};
