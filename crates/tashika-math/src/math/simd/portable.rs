//! Vectors that every machine has: plain arrays, the scalar twin of all others.

use super::real::{Real, Vector, Vectors, operators, slices};

/// Plain arrays.
#[derive(Clone, Copy, Debug)]
pub struct Portable<const N: usize>([f32; N]);

/// The vectors of [`Level::PORTABLE`](super::Level::PORTABLE).
pub(crate) struct PortableVectors;

impl Vectors for PortableVectors {
    type Eight = Portable<8>;
    type Sixteen = Portable<16>;
    type Widest = Portable<8>;
}

impl<const N: usize> Portable<N> {
    #[inline(always)]
    fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self(self.0.map(f))
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

operators! { [const N: usize] Portable<N>:
    Add add |a, b| a.zip(b, |a, b| a + b);
    Sub sub |a, b| a.zip(b, |a, b| a - b);
    Mul mul |a, b| a.zip(b, |a, b| a * b);
    Div div |a, b| a.zip(b, |a, b| a / b);
}

impl<const N: usize> Real for Portable<N> {
    type Mask = [bool; N];

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; N])
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, Real::min)
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, Real::max)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f32::abs)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f32::sqrt)
    }

    #[inline(always)]
    fn le(self, other: Self) -> Self::Mask {
        std::array::from_fn(|i| self.0[i] <= other.0[i])
    }

    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        std::array::from_fn(|i| self.0[i] > other.0[i])
    }

    #[inline(always)]
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        std::array::from_fn(|i| a[i] & b[i])
    }

    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        mask.contains(&true)
    }

    #[inline(always)]
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self {
        Self(std::array::from_fn(|i| if mask[i] { a.0[i] } else { b.0[i] }))
    }

    #[inline(always)]
    fn exp2_of_integer(self) -> Self {
        self.map(Real::exp2_of_integer)
    }

    #[inline(always)]
    fn mantissa_and_exponent(self) -> (Self, Self) {
        let both = self.0.map(Real::mantissa_and_exponent);
        (Self(both.map(|(m, _)| m)), Self(both.map(|(_, e)| e)))
    }
}

/// [`Vector`] for arrays of one length.
macro_rules! vector {
    ($lanes:literal) => {
        impl Vector for Portable<$lanes> {
            slices!($lanes);

            #[inline(always)]
            fn load(x: &[f32; $lanes]) -> Self {
                Self(*x)
            }

            #[inline(always)]
            fn array(self) -> [f32; $lanes] {
                self.0
            }

            #[inline(always)]
            fn flipped_by(self, other: Self) -> Self {
                self.zip(other, |a, b| f32::from_bits(a.to_bits() ^ (b.to_bits() & 1 << 31)))
            }

            #[inline(always)]
            fn bits(mask: Self::Mask) -> u32 {
                (0..$lanes).fold(0, |bits, i| bits | u32::from(mask[i]) << i)
            }

            #[inline(always)]
            fn mask(bits: u32) -> Self::Mask {
                std::array::from_fn(|i| bits >> i & 1 != 0)
            }
        }
    };
}
vector!(8);
vector!(16);
