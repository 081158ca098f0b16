//! Vectors of AVX2: eight numbers a register.
//!
//! # Safety
//! The types are private to `simd`. Other code receives them only from [`Token::run`], so the
//! instructions run only where AVX2 was detected.

#![allow(unsafe_code, reason = "vector instructions")]

use std::arch::x86_64::*;

use super::level::token;
use super::pair::Pair;
use super::real::{MANTISSA, ONE, ROOT_HALF, Real, Vector, Vectors, operators, slices};

token!(Avx2Vectors, is_x86_feature_detected: "avx2", "bmi1", "bmi2", "lzcnt", "popcnt");

/// The vectors of this set.
struct Avx2Vectors;

impl Vectors for Avx2Vectors {
    type Eight = Avx2;
    type Sixteen = Pair<Avx2>;
    type Widest = Avx2;
}

/// A register of 256 bits.
#[derive(Clone, Copy)]
struct Avx2(__m256);

/// An instruction, with its arguments.
macro_rules! instruction {
    ($name:ident$(::<$constant:tt>)?($($argument:expr),*)) => {
        // SAFETY: AVX2 was found, see the module.
        unsafe { $name$(::<$constant>)?($($argument),*) }
    };
}

operators! { [] Avx2:
    Add add |a, b| Self(instruction!(_mm256_add_ps(a.0, b.0)));
    Sub sub |a, b| Self(instruction!(_mm256_sub_ps(a.0, b.0)));
    Mul mul |a, b| Self(instruction!(_mm256_mul_ps(a.0, b.0)));
    Div div |a, b| Self(instruction!(_mm256_div_ps(a.0, b.0)));
}

impl Real for Avx2 {
    type Mask = __m256;

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self(instruction!(_mm256_set1_ps(x)))
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self(instruction!(_mm256_min_ps(self.0, other.0)))
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self(instruction!(_mm256_max_ps(self.0, other.0)))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(instruction!(_mm256_andnot_ps(Self::splat(-0.0).0, self.0)))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(instruction!(_mm256_sqrt_ps(self.0)))
    }

    #[inline(always)]
    fn le(self, other: Self) -> __m256 {
        instruction!(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0))
    }

    #[inline(always)]
    fn gt(self, other: Self) -> __m256 {
        instruction!(_mm256_cmp_ps::<_CMP_GT_OQ>(self.0, other.0))
    }

    #[inline(always)]
    fn and(a: __m256, b: __m256) -> __m256 {
        instruction!(_mm256_and_ps(a, b))
    }

    #[inline(always)]
    fn any(mask: __m256) -> bool {
        Self::bits(mask) != 0
    }

    #[inline(always)]
    fn select(mask: __m256, a: Self, b: Self) -> Self {
        Self(instruction!(_mm256_blendv_ps(b.0, a.0, mask)))
    }

    #[inline(always)]
    fn exp2_of_integer(self) -> Self {
        let (n, bias) = (instruction!(_mm256_cvttps_epi32(self.0)), instruction!(_mm256_set1_epi32(127)));
        let biased = instruction!(_mm256_add_epi32(n, bias));
        let bits = instruction!(_mm256_slli_epi32::<23>(biased));
        Self(instruction!(_mm256_castsi256_ps(bits)))
    }

    #[inline(always)]
    fn mantissa_and_exponent(self) -> (Self, Self) {
        let splat = |x: u32| instruction!(_mm256_set1_epi32(x.cast_signed()));
        let bits = instruction!(_mm256_castps_si256(self.0));
        let bits = instruction!(_mm256_add_epi32(bits, splat(ONE - ROOT_HALF)));
        let exponent = instruction!(_mm256_srli_epi32::<23>(bits));
        let exponent = instruction!(_mm256_sub_epi32(exponent, splat(127)));
        let mantissa = instruction!(_mm256_and_si256(bits, splat(MANTISSA)));
        let mantissa = instruction!(_mm256_add_epi32(mantissa, splat(ROOT_HALF)));
        let mantissa = instruction!(_mm256_castsi256_ps(mantissa));
        (Self(mantissa), Self(instruction!(_mm256_cvtepi32_ps(exponent))))
    }
}

impl Vector for Avx2 {
    slices!(8);

    #[inline(always)]
    fn load(x: &[f32; 8]) -> Self {
        // The instruction reads eight numbers from an array of eight.
        Self(instruction!(_mm256_loadu_ps(x.as_ptr())))
    }

    #[inline(always)]
    fn array(self) -> [f32; 8] {
        let mut array = [0.0; 8];
        // The instruction writes eight numbers to an array of eight.
        instruction!(_mm256_storeu_ps(array.as_mut_ptr(), self.0));
        array
    }

    #[inline(always)]
    fn flipped_by(self, other: Self) -> Self {
        let signs = instruction!(_mm256_and_ps(Self::splat(-0.0).0, other.0));
        Self(instruction!(_mm256_xor_ps(self.0, signs)))
    }

    #[inline(always)]
    fn bits(mask: __m256) -> u32 {
        instruction!(_mm256_movemask_ps(mask)).cast_unsigned()
    }

    #[inline(always)]
    fn mask(bits: u32) -> __m256 {
        let places = instruction!(_mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128));
        let all = instruction!(_mm256_set1_epi32(bits.cast_signed()));
        let own = instruction!(_mm256_and_si256(all, places));
        let equal = instruction!(_mm256_cmpeq_epi32(own, places));
        instruction!(_mm256_castsi256_ps(equal))
    }
}
