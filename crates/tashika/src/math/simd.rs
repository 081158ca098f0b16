//! One number or eight at once, on several instruction sets.
//!
//! [`Real`] has the operations that formulas are written in, once for a single number and for vectors; [`F32x8`] adds what vectors
//! are made of. All are single IEEE operations, selections, or exact changes of bits, so that every implementation gives the same
//! bits. [`Portable`] is the scalar twin of the others; `tests` holds them to it.
//!
//! Code for vectors is generic over [`F32x8`] and has one entry a level, `on_level`.
//!
//! # Safety
//! Implementations for an instruction set may be named only below such an entry.

use std::ops::{Add, Div, Mul, Sub};
use std::sync::OnceLock;

/// An array of an expression for 0, 1 and 2. Unlike a closure it is never a function of its own, which would not be compiled for
/// the instruction set of its caller.
macro_rules! each {
    (|$axis:ident| $value:expr) => {
        [
            {
                let $axis = 0;
                $value
            },
            {
                let $axis = 1;
                $value
            },
            {
                let $axis = 2;
                $value
            },
        ]
    };
}
pub(crate) use each;

/// Runs a block for each bit that is set, from the lowest; `below` is a power of two that says how many bits there are. No closure, for
/// the reason of [`each`].
macro_rules! for_bits {
    ($bits:expr, below $below:expr, |$bit:ident| $body:block) => {
        let mut rest: u32 = $bits;
        while rest != 0 {
            let $bit = rest.trailing_zeros() as usize & ($below - 1);
            rest &= rest - 1;
            $body
        }
    };
}
pub(crate) use for_bits;

/// Numbers that are worked on together.
pub(crate) const WIDTH: usize = 8;

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
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask;
    /// Whether it holds anywhere.
    fn any(mask: Self::Mask) -> bool;
    /// `a` where the mask holds, otherwise `b`.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// `2ⁿ` of an integer `n` in [−126, 127].
    fn exp2_of_integer(self) -> Self;
    /// `(m, e)` with `x = m 2ᵉ` and `m` in `[√½, √2)`, of a positive normal number.
    fn mantissa_and_exponent(self) -> (Self, Self);
}

/// Eight numbers.
pub(crate) trait F32x8: Real {
    /// Those of an array.
    fn load(x: &[f32; WIDTH]) -> Self;
    /// As an array.
    fn array(self) -> [f32; WIDTH];
    /// With the sign flipped where that of `other` is set.
    fn flipped_by(self, other: Self) -> Self;
    /// Bits of the places where it holds.
    fn bits(mask: Self::Mask) -> u32;
    /// The mask of these bits.
    fn mask(bits: u32) -> Self::Mask;
    /// Says that something will be read soon.
    #[inline(always)]
    fn announce<T>(_: &T) {}
}

/// Bits of `√½`, rounded, as [`Real::mantissa_and_exponent`] takes it.
const ROOT_HALF: u32 = 0x3f35_04f3;
/// Bits of 1.
const ONE: u32 = 0x3f80_0000;
/// Bits of the mantissa.
const MANTISSA: u32 = 0x007f_ffff;

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
    fn both(a: bool, b: bool) -> bool {
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

/// An instruction set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Level {
    /// What every machine has.
    Portable,
    /// AVX2, and what else every machine has that has it: see `for_avx2`.
    #[cfg(target_arch = "x86_64")]
    Avx2,
}

impl Level {
    /// The best that this machine has, looked for once.
    pub fn best() -> Self {
        static BEST: OnceLock<Level> = OnceLock::new();
        *BEST.get_or_init(|| Self::all()[0])
    }

    /// All that this machine has, the best first.
    pub fn all() -> Vec<Self> {
        let mut levels = Vec::new();
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2")
            && std::arch::is_x86_feature_detected!("bmi1")
            && std::arch::is_x86_feature_detected!("bmi2")
            && std::arch::is_x86_feature_detected!("lzcnt")
            && std::arch::is_x86_feature_detected!("popcnt")
        {
            levels.push(Self::Avx2);
        }
        levels.push(Self::Portable);
        levels
    }
}

/// An expression for each instruction set: the one of the level is evaluated.
///
/// What is called for a set has `#[target_feature]`, and is all that is compiled for it; functions that it is to be compiled with
/// have to be `#[inline(always)]`.
macro_rules! on_level {
    ($level:expr, portable: $portable:expr, avx2: $avx2:expr) => {
        match $level {
            $crate::math::simd::Level::Portable => $portable,
            #[cfg(target_arch = "x86_64")]
            #[allow(unsafe_code, reason = "the compiler cannot know what the machine has")]
            // SAFETY: a level is only made where the machine was found to have it.
            $crate::math::simd::Level::Avx2 => unsafe { $avx2 },
        }
    };
}
pub(crate) use on_level;

/// Functions that are compiled for [`Level::Avx2`], to be called by [`on_level`].
macro_rules! for_avx2 {
    ($(pub fn $name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $result:ty)? $body:block)*) => {$(
        #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
        pub fn $name($($argument: $type),*) $(-> $result)? $body
    )*};
}
#[cfg(target_arch = "x86_64")]
pub(crate) use for_avx2;

/// Plain arrays.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable([f32; WIDTH]);

impl Portable {
    #[inline(always)]
    fn map(self, f: impl Fn(f32) -> f32) -> Self {
        Self(self.0.map(f))
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

/// Operators of a vector.
macro_rules! operators {
    ($type:ty: $($trait:ident $method:ident |$a:ident, $b:ident| $value:expr;)*) => {$(
        impl $trait for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let ($a, $b) = (self, other);
                $value
            }
        }
    )*};
}

operators! { Portable:
    Add add |a, b| a.zip(b, |a, b| a + b);
    Sub sub |a, b| a.zip(b, |a, b| a - b);
    Mul mul |a, b| a.zip(b, |a, b| a * b);
    Div div |a, b| a.zip(b, |a, b| a / b);
}

impl Real for Portable {
    type Mask = [bool; WIDTH];

    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; WIDTH])
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
    fn both(a: Self::Mask, b: Self::Mask) -> Self::Mask {
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

impl F32x8 for Portable {
    #[inline(always)]
    fn load(x: &[f32; WIDTH]) -> Self {
        Self(*x)
    }

    #[inline(always)]
    fn array(self) -> [f32; WIDTH] {
        self.0
    }

    #[inline(always)]
    fn flipped_by(self, other: Self) -> Self {
        self.zip(other, |a, b| f32::from_bits(a.to_bits() ^ (b.to_bits() & 1 << 31)))
    }

    #[inline(always)]
    fn bits(mask: Self::Mask) -> u32 {
        (0..WIDTH).fold(0, |bits, i| bits | u32::from(mask[i]) << i)
    }

    #[inline(always)]
    fn mask(bits: u32) -> Self::Mask {
        std::array::from_fn(|i| bits >> i & 1 != 0)
    }
}

#[cfg(target_arch = "x86_64")]
pub(crate) use x86::Avx2;

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, reason = "vector instructions")]
mod x86 {
    use std::arch::x86_64::*;
    use std::ops::{Add, Div, Mul, Sub};

    use super::{F32x8, MANTISSA, ONE, ROOT_HALF, Real, WIDTH};

    /// Bytes that are fetched together.
    const CACHE_LINE: usize = 64;

    /// A register of 256 bits.
    #[derive(Clone, Copy)]
    pub(crate) struct Avx2(__m256);

    /// An instruction, with its arguments.
    macro_rules! instruction {
        ($name:ident$(::<$constant:tt>)?($($argument:expr),*)) => {
            // SAFETY: AVX2 was detected, see the module.
            unsafe { $name$(::<$constant>)?($($argument),*) }
        };
    }

    operators! { Avx2:
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
        fn both(a: __m256, b: __m256) -> __m256 {
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

    impl F32x8 for Avx2 {
        #[inline(always)]
        fn load(x: &[f32; WIDTH]) -> Self {
            // Eight numbers are read from an array of eight.
            Self(instruction!(_mm256_loadu_ps(x.as_ptr())))
        }

        #[inline(always)]
        fn array(self) -> [f32; WIDTH] {
            let mut array = [0.0; WIDTH];
            // Eight numbers are written to an array of eight.
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

        #[inline(always)]
        fn announce<T>(what: &T) {
            let begin = std::ptr::from_ref(what).cast::<i8>();
            for line in 0..size_of::<T>().div_ceil(CACHE_LINE) {
                // A prefetch changes nothing, wherever it points.
                instruction!(_mm_prefetch::<_MM_HINT_T0>(begin.wrapping_add(line * CACHE_LINE)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, Stream};

    /// Numbers of all kinds: zeros of both signs, infinities, NaN, and ordinary ones, some of them equal.
    fn numbers(s: &mut Stream) -> [f32; WIDTH] {
        let special = [0.0, -0.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN, 1.0, -1.0, f32::MIN_POSITIVE];
        std::array::from_fn(|_| match s.below(3) {
            0 => special[s.below(special.len() as u64) as usize],
            _ => (s.uniform() - 0.5) * 4.0,
        })
    }

    fn results<F: F32x8>(a: &[f32; WIDTH], b: &[f32; WIDTH]) -> (Vec<[u32; WIDTH]>, [(u32, bool); 4]) {
        let (a, b) = (F::load(a), F::load(b));
        let (le, gt) = (a.le(b), a.gt(b));
        let arithmetic = [a + b, a - b, a * b, a / b, a.min(b), a.max(b), a.abs(), a.sqrt(), a.flipped_by(b)];
        let (m, e) = (a.abs() + F::splat(f32::MIN_POSITIVE)).mantissa_and_exponent();
        let power = (b.flipped_by(a) * F::splat(60.0)).max(F::splat(-126.0)).min(F::splat(127.0));
        let others = [F::splat(2.5), F::select(le, a, b), m, e, power.exp2_of_integer()];
        // NaN is NaN, whatever its payload.
        let bits = |x: f32| if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() };
        let all = arithmetic.into_iter().chain(others).map(|v| v.array().map(bits)).collect();
        let both = F::both(le, F::splat(0.5).gt(a));
        let masks = [le, gt, both, F::mask(a.array()[0].to_bits() & 0xff)];
        (all, masks.map(|mask| (F::bits(mask), F::any(mask))))
    }

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn vectors_are_their_scalar_twins() {
        if !Level::all().contains(&Level::Avx2) {
            return;
        }
        let mut s = Stream::new(1, Purpose::Test, 0);
        for _ in 0..10_000 {
            let (a, b) = (numbers(&mut s), numbers(&mut s));
            let finite = a.map(|x| if x.is_finite() { x } else { 3.0 });
            assert_eq!(
                results::<Portable>(&finite, &b),
                results::<Avx2>(&finite, &b),
                "{finite:?} and {b:?}"
            );
        }
    }

    #[test]
    fn a_number_is_its_mantissa_times_a_power_of_two() {
        let mut s = Stream::new(2, Purpose::Test, 0);
        for _ in 0..10_000 {
            let x = f32::from_bits(1 << 23 | s.below(254 << 23) as u32);
            let (m, e) = x.mantissa_and_exponent();
            assert!((0.707..1.4143).contains(&m), "{x:e}: {m}");
            assert_eq!(
                f64::from(m)
                    * f64::from((e * 0.5).floor().exp2_of_integer())
                    * f64::from((e - (e * 0.5).floor()).exp2_of_integer()),
                f64::from(x)
            );
        }
    }
}
