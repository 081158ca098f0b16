//! What formulas are written in: a number, or several that are treated alike.
//!
//! Every operation is one IEEE operation, a selection, or an exact change of bits, so that each
//! implementation gives the same bits. Held to this by `simd::tests`.

use std::ops::{Add, Div, Mul, Sub};

/// A number, or several that are treated alike.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// What is true of each number.
    type Mask: Copy;
    /// Each is `x`.
    fn splat(x: f32) -> Self;
    /// `a < b ? a : b`.
    fn min(self, other: Self) -> Self;
    /// `a > b ? a : b`.
    fn max(self, other: Self) -> Self;
    /// Without the sign.
    fn abs(self) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// Where `a <= b`.
    fn le(self, other: Self) -> Self::Mask;
    /// Where `a > b`.
    fn gt(self, other: Self) -> Self::Mask;
    /// Where both hold.
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Whether it holds anywhere.
    fn any(mask: Self::Mask) -> bool;
    /// `a` where the mask holds, otherwise `b`.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// `2ⁿ` of an integer `n` in [−126, 127].
    fn exp2_of_integer(self) -> Self;
    /// `(m, e)` with `x = m 2ᵉ` and `m` in `[√½, √2)`, of a positive normal number.
    fn mantissa_and_exponent(self) -> (Self, Self);
}

/// A fixed count of numbers.
pub trait Vector: Real {
    /// How many.
    const LANES: usize;
    /// As they are stored.
    type Array: Copy;
    /// Those of an array.
    fn load(x: &Self::Array) -> Self;
    /// The first [`Vector::LANES`] of a slice, which must have as many.
    fn load_from(x: &[f32]) -> Self;
    /// As an array.
    fn array(self) -> Self::Array;
    /// The first of them, as many as there is room for.
    fn store_to(self, x: &mut [f32]);
    /// With the sign flipped where that of `other` is set.
    fn flipped_by(self, other: Self) -> Self;
    /// Bits of the places where it holds, the first in the lowest.
    fn bits(mask: Self::Mask) -> u32;
    /// The mask of these bits.
    fn mask(bits: u32) -> Self::Mask;
    /// Says that something will be read soon.
    #[inline(always)]
    fn prefetch<T>(_: &T) {}
}

/// Eight numbers.
pub trait F32x8: Vector<Array = [f32; 8]> {}
impl<F: Vector<Array = [f32; 8]>> F32x8 for F {}

/// Sixteen numbers.
pub trait F32x16: Vector<Array = [f32; 16]> {}
impl<F: Vector<Array = [f32; 16]>> F32x16 for F {}

/// The vectors of an instruction set.
pub trait Vectors {
    /// Eight numbers.
    type Eight: F32x8;
    /// Sixteen numbers.
    type Sixteen: F32x16;
    /// As many as one register holds, at most [`MOST_LANES`](super::MOST_LANES).
    type Widest: Vector;
}

/// What storing and loading have in common: methods of [`Vector`] that follow from `load` and
/// `array`.
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

/// Operators of a vector: its generic parameters, its type, and an expression for each.
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

/// Bits of `√½`, rounded, as [`Real::mantissa_and_exponent`] takes it.
pub(super) const ROOT_HALF: u32 = 0x3f35_04f3;
/// Bits of 1.
pub(super) const ONE: u32 = 0x3f80_0000;
/// Bits of the mantissa.
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
