//! Vectors of sixteen numbers as two vectors of eight, for instruction sets without registers of
//! sixteen numbers.

use super::real::{F32x8, Real, Vector, operators, slices};

/// Two vectors, the first numbers first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair<F>(F, F);

operators! { [F: F32x8] Pair<F>:
    Add add |a, b| Self(a.0 + b.0, a.1 + b.1);
    Sub sub |a, b| Self(a.0 - b.0, a.1 - b.1);
    Mul mul |a, b| Self(a.0 * b.0, a.1 * b.1);
    Div div |a, b| Self(a.0 / b.0, a.1 / b.1);
}

impl<F: F32x8> Real for Pair<F> {
    type Mask = (F::Mask, F::Mask);

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(F::splat(x), F::splat(x))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0), self.1.min(other.1))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0), self.1.max(other.1))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs(), self.1.abs())
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt(), self.1.sqrt())
    }

    #[inline(always)]
    fn le(self, other: Self) -> Self::Mask {
        (self.0.le(other.0), self.1.le(other.1))
    }

    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        (self.0.gt(other.0), self.1.gt(other.1))
    }

    #[inline(always)]
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        (F::and(a.0, b.0), F::and(a.1, b.1))
    }

    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        F::any(mask.0) | F::any(mask.1)
    }

    #[inline(always)]
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self {
        Self(F::select(mask.0, a.0, b.0), F::select(mask.1, a.1, b.1))
    }

    #[inline(always)]
    fn exp2_of_integer(self) -> Self {
        Self(self.0.exp2_of_integer(), self.1.exp2_of_integer())
    }

    #[inline(always)]
    fn mantissa_and_exponent(self) -> (Self, Self) {
        let ((m0, e0), (m1, e1)) = (self.0.mantissa_and_exponent(), self.1.mantissa_and_exponent());
        (Self(m0, m1), Self(e0, e1))
    }
}

impl<F: F32x8> Vector for Pair<F> {
    slices!(16);

    #[inline(always)]
    fn load(x: &[f32; 16]) -> Self {
        Self(F::load_from(&x[..8]), F::load_from(&x[8..]))
    }

    #[inline(always)]
    fn array(self) -> [f32; 16] {
        let mut array = [0.0; 16];
        self.0.store_to(&mut array[..8]);
        self.1.store_to(&mut array[8..]);
        array
    }

    #[inline(always)]
    fn flipped_by(self, other: Self) -> Self {
        Self(self.0.flipped_by(other.0), self.1.flipped_by(other.1))
    }

    #[inline(always)]
    fn bits(mask: Self::Mask) -> u32 {
        F::bits(mask.0) | F::bits(mask.1) << 8
    }

    #[inline(always)]
    fn mask(bits: u32) -> Self::Mask {
        (F::mask(bits & 0xff), F::mask(bits >> 8))
    }
}
