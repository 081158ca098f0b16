//! Traits for formulas that are evaluated for a single number or for a vector of several.
//!
//! Every operation is one IEEE operation, a selection, or an exact change of bits, so that each
//! implementation gives the same bits. Held to this by `simd::tests`.

use std::ops::{Add, Div, Mul, Sub};

/// A single number, or a vector whose numbers all undergo the same operations.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Result of a comparison, for each number.
    type Mask: Copy;
    /// The number `x` in each lane.
    fn splat(x: f32) -> Self;
    /// `a < b ? a : b`.
    fn min(self, other: Self) -> Self;
    /// `a > b ? a : b`.
    fn max(self, other: Self) -> Self;
    /// Absolute value of each number.
    fn abs(self) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// Mask of the lanes with `a <= b`.
    fn le(self, other: Self) -> Self::Mask;
    /// Mask of the lanes with `a > b`.
    fn gt(self, other: Self) -> Self::Mask;
    /// Mask of the lanes in which both masks hold.
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Returns true if the mask holds in any lane.
    fn any(mask: Self::Mask) -> bool;
    /// Selects `a` where the mask holds, otherwise `b`.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// Power `2ⁿ` of an integer `n` in [−126, 127].
    fn exp2_of_integer(self) -> Self;
    /// Returns `(m, e)` with `x = m 2ᵉ` and `m` in `[√½, √2)`, for a positive normal number.
    fn mantissa_and_exponent(self) -> (Self, Self);
}

/// A fixed count of numbers.
pub trait Vector: Real {
    /// Count of numbers in a vector.
    const LANES: usize;
    /// Array of the numbers, as stored in memory.
    type Array: Copy;
    /// Loads the numbers of an array.
    fn load(x: &Self::Array) -> Self;
    /// Loads the first [`Vector::LANES`] numbers of a slice, which must have at least that length.
    fn load_from(x: &[f32]) -> Self;
    /// Numbers of the vector, in an array.
    fn array(self) -> Self::Array;
    /// Stores the numbers at the start of a slice; only the first ones if the slice is shorter than
    /// the vector.
    fn store_to(self, x: &mut [f32]);
    /// Flips the sign of each number whose counterpart in `other` has its sign bit set.
    fn flipped_by(self, other: Self) -> Self;
    /// Bits of a mask; the lowest bit is that of the first lane.
    fn bits(mask: Self::Mask) -> u32;
    /// Mask of the lanes whose bits are set.
    fn mask(bits: u32) -> Self::Mask;
}

/// Vectors of eight numbers of single precision.
pub trait F32x8: Vector<Array = [f32; 8]> {}
impl<F: Vector<Array = [f32; 8]>> F32x8 for F {}

/// Vectors of sixteen numbers of single precision.
pub trait F32x16: Vector<Array = [f32; 16]> {}
impl<F: Vector<Array = [f32; 16]>> F32x16 for F {}

/// The vectors of an instruction set.
pub trait Vectors {
    /// Vector of eight numbers of single precision.
    type Eight: F32x8;
    /// Vector of sixteen numbers of single precision.
    type Sixteen: F32x16;
    /// Vector that fills one register, of at most [`MOST_LANES`](super::MOST_LANES) numbers.
    type Widest: Vector;
}

/// Methods of [`Vector`] that follow from `load` and `array`.
macro_rules! slices {
    ($lanes:expr) => {
        const LANES: usize = $lanes;
        type Array = [f32; $lanes];

        #[inline(always)]
        fn load_from(x: &[f32]) -> Self {
            Self::load(x.first_chunk().expect("a slice of as many numbers"))
        }

        #[inline(always)]
        fn store_to(self, x: &mut [f32]) {
            let array = self.array();
            match x.first_chunk_mut() {
                Some(whole) => *whole = array,
                None => x.copy_from_slice(&array[..x.len()]),
            }
        }
    };
}
pub(super) use slices;

/// Implements the operators of a vector, from its generic parameters, its type, and an expression
/// for each operator.
macro_rules! operators {
    (@ [$($generics:tt)*] $type:ty, $trait:ident $method:ident |$a:ident, $b:ident| $value:expr) => {
        impl<$($generics)*> std::ops::$trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let ($a, $b) = (self, other);
                $value
            }
        }
    };
    ($generics:tt $type:ty: $($trait:ident $method:ident |$a:ident, $b:ident| $value:expr;)*) => {
        $($crate::math::simd::real::operators!(
            @ $generics $type, $trait $method |$a, $b| $value
        );)*
    };
}
pub(super) use operators;

/// Bits of `√½`, rounded: the smallest mantissa of [`Real::mantissa_and_exponent`].
pub(super) const ROOT_HALF: u32 = 0x3f35_04f3;
/// Bits of 1.
pub(super) const ONE: u32 = 0x3f80_0000;
/// Mask of the 23 bits of the mantissa.
pub(super) const MANTISSA: u32 = 0x007f_ffff;

impl Real for f32 {
    type Mask = bool;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        x
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
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
    fn and(a: bool, b: bool) -> bool {
        a & b
    }

    #[inline(always)]
    fn any(mask: bool) -> bool {
        mask
    }

    #[inline(always)]
    fn select(mask: bool, a: Self, b: Self) -> Self {
        if mask { a } else { b }
    }

    #[inline(always)]
    fn exp2_of_integer(self) -> Self {
        f32::from_bits((self as i32).wrapping_add(127).cast_unsigned() << 23)
    }

    #[inline(always)]
    fn mantissa_and_exponent(self) -> (Self, Self) {
        let bits = self.to_bits().wrapping_add(ONE - ROOT_HALF);
        let exponent = (bits >> 23).cast_signed() - 127;
        (f32::from_bits((bits & MANTISSA) + ROOT_HALF), exponent as f32)
    }
}
