//! Vectors of NEON: eight numbers as two registers of four.
//!
//! # Safety
//! The types are private to `simd`. Other code receives them only from [`Token::run`], so the
//! instructions run only where NEON was detected.

#![allow(unsafe_code, reason = "vector instructions")]

use std::arch::aarch64::*;

use super::level::token;
use super::pair::Pair;
use super::real::{MANTISSA, ONE, ROOT_HALF, Real, Vector, Vectors, operators, slices};

token!(NeonVectors, is_aarch64_feature_detected: "neon");

/// The vectors of this set.
struct NeonVectors;

impl Vectors for NeonVectors {
    type Eight = Neon;
    type Sixteen = Pair<Neon>;
    type Widest = Neon;
}

/// Two registers of 128 bits.
#[derive(Clone, Copy)]
struct Neon([float32x4_t; 2]);

/// An instruction for each of the two registers, with its arguments.
macro_rules! instruction {
    (|$half:ident| $name:ident$(::<$constant:tt>)?($($argument:expr),*)) => {
        // SAFETY: NEON was found, see the module.
        unsafe {
            [
                { let $half = 0; $name$(::<$constant>)?($($argument),*) },
                { let $half = 1; $name$(::<$constant>)?($($argument),*) },
            ]
        }
    };
}

operators! { [] Neon:
    Add add |a, b| Self(instruction!(|h| vaddq_f32(a.0[h], b.0[h])));
    Sub sub |a, b| Self(instruction!(|h| vsubq_f32(a.0[h], b.0[h])));
    Mul mul |a, b| Self(instruction!(|h| vmulq_f32(a.0[h], b.0[h])));
    Div div |a, b| Self(instruction!(|h| vdivq_f32(a.0[h], b.0[h])));
}

impl Neon {
    /// Sign bit of each number.
    #[inline(always)]
    fn signs(self) -> [uint32x4_t; 2] {
        let bits = self.to_bits();
        let sign = splat(1 << 31);
        instruction!(|h| vandq_u32(bits[h], sign[h]))
    }

    #[inline(always)]
    fn to_bits(self) -> [uint32x4_t; 2] {
        instruction!(|h| vreinterpretq_u32_f32(self.0[h]))
    }

    #[inline(always)]
    fn from_bits(bits: [uint32x4_t; 2]) -> Self {
        Self(instruction!(|h| vreinterpretq_f32_u32(bits[h])))
    }
}

#[inline(always)]
fn splat(x: u32) -> [uint32x4_t; 2] {
    instruction!(|_h| vdupq_n_u32(x))
}

impl Real for Neon {
    type Mask = [uint32x4_t; 2];

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(instruction!(|_h| vdupq_n_f32(x)))
    }

    // The instructions of NEON for minimum and maximum treat zeros and NaN differently from `Real`.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(other.gt(self), self, other)
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(self.gt(other), self, other)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(instruction!(|h| vabsq_f32(self.0[h])))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(instruction!(|h| vsqrtq_f32(self.0[h])))
    }

    #[inline(always)]
    fn le(self, other: Self) -> Self::Mask {
        instruction!(|h| vcleq_f32(self.0[h], other.0[h]))
    }

    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        instruction!(|h| vcgtq_f32(self.0[h], other.0[h]))
    }

    #[inline(always)]
    fn and(a: Self::Mask, b: Self::Mask) -> Self::Mask {
        instruction!(|h| vandq_u32(a[h], b[h]))
    }

    #[inline(always)]
    fn any(mask: Self::Mask) -> bool {
        let most = instruction!(|h| vmaxvq_u32(mask[h]));
        most[0] | most[1] != 0
    }

    #[inline(always)]
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self {
        Self(instruction!(|h| vbslq_f32(mask[h], a.0[h], b.0[h])))
    }

    #[inline(always)]
    fn exp2_of_integer(self) -> Self {
        let n = instruction!(|h| vcvtq_s32_f32(self.0[h]));
        let bias = splat(127);
        let biased = instruction!(|h| vaddq_u32(vreinterpretq_u32_s32(n[h]), bias[h]));
        Self::from_bits(instruction!(|h| vshlq_n_u32::<23>(biased[h])))
    }

    #[inline(always)]
    fn mantissa_and_exponent(self) -> (Self, Self) {
        let (bits, offset) = (self.to_bits(), splat(ONE - ROOT_HALF));
        let bits = instruction!(|h| vaddq_u32(bits[h], offset[h]));
        let (bias, low, root) = (splat(127), splat(MANTISSA), splat(ROOT_HALF));
        let exponent = instruction!(|h| vsubq_u32(vshrq_n_u32::<23>(bits[h]), bias[h]));
        let exponent = instruction!(|h| vcvtq_f32_s32(vreinterpretq_s32_u32(exponent[h])));
        let mantissa = instruction!(|h| vaddq_u32(vandq_u32(bits[h], low[h]), root[h]));
        (Self::from_bits(mantissa), Self(exponent))
    }
}

impl Vector for Neon {
    slices!(8);

    #[inline(always)]
    fn load(x: &[f32; 8]) -> Self {
        // Four numbers are read from each half of an array of eight.
        Self(instruction!(|h| vld1q_f32(x[4 * h..].as_ptr())))
    }

    #[inline(always)]
    fn array(self) -> [f32; 8] {
        let mut array = [0.0; 8];
        // Four numbers are written to each half of an array of eight.
        instruction!(|h| vst1q_f32(array[4 * h..].as_mut_ptr(), self.0[h]));
        array
    }

    #[inline(always)]
    fn flipped_by(self, other: Self) -> Self {
        let (bits, signs) = (self.to_bits(), other.signs());
        Self::from_bits(instruction!(|h| veorq_u32(bits[h], signs[h])))
    }

    #[inline(always)]
    fn bits(mask: Self::Mask) -> u32 {
        let places = places();
        let bits = instruction!(|h| vaddvq_u32(vandq_u32(mask[h], places[h])));
        bits[0] | bits[1]
    }

    #[inline(always)]
    fn mask(bits: u32) -> Self::Mask {
        let (places, all) = (places(), splat(bits));
        instruction!(|h| vtstq_u32(all[h], places[h]))
    }
}

/// Bit `1 << i` in each lane `i`.
#[inline(always)]
fn places() -> [uint32x4_t; 2] {
    const PLACES: [u32; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
    // Four numbers are read from each half of an array of eight.
    instruction!(|h| vld1q_u32(PLACES[4 * h..].as_ptr()))
}
