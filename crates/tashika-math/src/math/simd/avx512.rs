//! Vectors of AVX-512: eight or sixteen numbers a register, and masks of one bit a number.
//!
//! The set consists of AVX2 and the extensions F, BW, CD, DQ and VL of AVX-512. Every server
//! processor with AVX-512 has all of these.
//!
//! # Safety
//! The types are private to `simd`. Other code receives them only from [`Token::run`], so the
//! instructions run only where all of these were detected.

#![allow(unsafe_code, reason = "vector instructions")]

use std::arch::x86_64::*;

use super::level::token;
use super::real::{MANTISSA, ONE, ROOT_HALF, Real, Vector, Vectors, operators, slices};

token!(
    Avx512Vectors, is_x86_feature_detected:
    "avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl", "avx2", "bmi1", "bmi2", "lzcnt", "popcnt"
);

/// The vectors of this set.
struct Avx512Vectors;

impl Vectors for Avx512Vectors {
    type Eight = Eight;
    type Sixteen = Sixteen;
    type Widest = Sixteen;
}

/// An instruction, with its arguments.
macro_rules! instruction {
    ($name:ident$(::<$constant:tt>)?($($argument:expr),*)) => {
        // SAFETY: AVX-512 was found, see the module.
        unsafe { $name$(::<$constant>)?($($argument),*) }
    };
}

/// Implements a register, from its number of lanes, its type, the type of its masks, and its
/// instructions.
macro_rules! register {
    ($name:ident: $lanes:literal of $register:ty, $mask:ty;
     $add:ident $sub:ident $mul:ident $div:ident $min:ident $max:ident $sqrt:ident $set:ident
     $and:ident $andnot:ident $xor:ident $compare:ident $blend:ident $load:ident $store:ident;
     $set_int:ident $add_int:ident $sub_int:ident $and_int:ident $left:ident $right:ident
     $to_int:ident $from_int:ident $as_int:ident $from_bits:ident) => {
        #[doc = concat!(stringify!($lanes), " numbers.")]
        #[derive(Clone, Copy)]
        struct $name($register);

        operators! { [] $name:
            Add add |a, b| Self(instruction!($add(a.0, b.0)));
            Sub sub |a, b| Self(instruction!($sub(a.0, b.0)));
            Mul mul |a, b| Self(instruction!($mul(a.0, b.0)));
            Div div |a, b| Self(instruction!($div(a.0, b.0)));
        }

        impl Real for $name {
            type Mask = $mask;

            #[inline(always)]
            fn splat(x: f32) -> Self {
                Self(instruction!($set(x)))
            }

            #[inline(always)]
            fn min(self, other: Self) -> Self {
                Self(instruction!($min(self.0, other.0)))
            }

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                Self(instruction!($max(self.0, other.0)))
            }

            #[inline(always)]
            fn abs(self) -> Self {
                Self(instruction!($andnot(Self::splat(-0.0).0, self.0)))
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(instruction!($sqrt(self.0)))
            }

            #[inline(always)]
            fn le(self, other: Self) -> $mask {
                instruction!($compare::<_CMP_LE_OQ>(self.0, other.0))
            }

            #[inline(always)]
            fn gt(self, other: Self) -> $mask {
                instruction!($compare::<_CMP_GT_OQ>(self.0, other.0))
            }

            #[inline(always)]
            fn and(a: $mask, b: $mask) -> $mask {
                a & b
            }

            #[inline(always)]
            fn any(mask: $mask) -> bool {
                mask != 0
            }

            #[inline(always)]
            fn select(mask: $mask, a: Self, b: Self) -> Self {
                Self(instruction!($blend(mask, b.0, a.0)))
            }

            #[inline(always)]
            fn exp2_of_integer(self) -> Self {
                let (n, bias) = (instruction!($to_int(self.0)), instruction!($set_int(127)));
                let biased = instruction!($add_int(n, bias));
                let bits = instruction!($left::<23>(biased));
                Self(instruction!($from_bits(bits)))
            }

            #[inline(always)]
            fn mantissa_and_exponent(self) -> (Self, Self) {
                let splat = |x: u32| instruction!($set_int(x.cast_signed()));
                let bits = instruction!($as_int(self.0));
                let bits = instruction!($add_int(bits, splat(ONE - ROOT_HALF)));
                let exponent = instruction!($right::<23>(bits));
                let exponent = instruction!($sub_int(exponent, splat(127)));
                let mantissa = instruction!($and_int(bits, splat(MANTISSA)));
                let mantissa = instruction!($add_int(mantissa, splat(ROOT_HALF)));
                let mantissa = instruction!($from_bits(mantissa));
                (Self(mantissa), Self(instruction!($from_int(exponent))))
            }
        }

        impl Vector for $name {
            slices!($lanes);

            #[inline(always)]
            fn load(x: &[f32; $lanes]) -> Self {
                // The instruction reads exactly the numbers of the array.
                Self(instruction!($load(x.as_ptr())))
            }

            #[inline(always)]
            fn array(self) -> [f32; $lanes] {
                let mut array = [0.0; $lanes];
                // The instruction writes exactly the numbers of the array.
                instruction!($store(array.as_mut_ptr(), self.0));
                array
            }

            #[inline(always)]
            fn flipped_by(self, other: Self) -> Self {
                let signs = instruction!($and(Self::splat(-0.0).0, other.0));
                Self(instruction!($xor(self.0, signs)))
            }

            #[inline(always)]
            fn bits(mask: $mask) -> u32 {
                u32::from(mask)
            }

            #[inline(always)]
            fn mask(bits: u32) -> $mask {
                bits as $mask
            }
        }
    };
}

register! { Eight: 8 of __m256, __mmask8;
    _mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps _mm256_min_ps _mm256_max_ps _mm256_sqrt_ps
    _mm256_set1_ps _mm256_and_ps _mm256_andnot_ps _mm256_xor_ps _mm256_cmp_ps_mask _mm256_mask_blend_ps
    _mm256_loadu_ps _mm256_storeu_ps;
    _mm256_set1_epi32 _mm256_add_epi32 _mm256_sub_epi32 _mm256_and_si256 _mm256_slli_epi32
    _mm256_srli_epi32 _mm256_cvttps_epi32 _mm256_cvtepi32_ps _mm256_castps_si256 _mm256_castsi256_ps
}

register! { Sixteen: 16 of __m512, __mmask16;
    _mm512_add_ps _mm512_sub_ps _mm512_mul_ps _mm512_div_ps _mm512_min_ps _mm512_max_ps _mm512_sqrt_ps
    _mm512_set1_ps _mm512_and_ps _mm512_andnot_ps _mm512_xor_ps _mm512_cmp_ps_mask _mm512_mask_blend_ps
    _mm512_loadu_ps _mm512_storeu_ps;
    _mm512_set1_epi32 _mm512_add_epi32 _mm512_sub_epi32 _mm512_and_si512 _mm512_slli_epi32
    _mm512_srli_epi32 _mm512_cvttps_epi32 _mm512_cvtepi32_ps _mm512_castps_si512 _mm512_castsi512_ps
}
