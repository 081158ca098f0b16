//! Elementary functions with the same bits on every machine.
//!
//! `f32::sin` and its like call the system's library, whose last bit differs between systems and even
//! between processors on one system. These call `libm`, which is plain Rust arithmetic, or are plain
//! arithmetic themselves ([`exp_of`], [`ln_of`], for one number or several). The lint `disallowed_methods`
//! (clippy.toml) keeps the others out of the workspace.

use glam::{Quat, Vec3};

use super::simd::Real;

/// `(sin x, cos x)`, `x` in radians.
pub fn sin_cos(x: f32) -> (f32, f32) {
    libm::sincosf(x)
}

/// The rotation by `angle` (radians) about the unit vector `axis`.
pub fn rotation(axis: Vec3, angle: f32) -> Quat {
    let (sin, cos) = sin_cos(0.5 * angle);
    let v = axis * sin;
    Quat::from_xyzw(v.x, v.y, v.z, cos)
}

/// `tan x`, `x` in radians.
pub fn tan(x: f32) -> f32 {
    libm::tanf(x)
}

/// `arccos x` in `[0, π]`; the argument is clamped to `[−1, 1]`.
pub fn acos(x: f32) -> f32 {
    libm::acosf(x.clamp(-1.0, 1.0))
}

/// Angle of the point `(x, y)` in `[−π, π]`.
pub fn atan2(y: f32, x: f32) -> f32 {
    libm::atan2f(y, x)
}

/// `x` to the power `y`.
pub fn powf(x: f32, y: f32) -> f32 {
    libm::powf(x, y)
}

/// `eˣ`.
pub fn exp(x: f32) -> f32 {
    libm::expf(x)
}

/// Natural logarithm.
pub fn ln(x: f32) -> f32 {
    libm::logf(x)
}

/// Halves of `ln 2`: the first has few enough bits that its products with exponents are exact.
const LN_2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];

/// `eˣ` of `x` in [−87, 88], of one number or several; within 2·10⁻⁷ of itself.
///
/// `2ⁿ eʳ` with the integer `n` next to `x / ln 2`, and seven terms of the series of `eʳ`, `|r| ≤ ½ ln 2`.
#[inline(always)]
pub fn exp_of<R: Real>(x: R) -> R {
    // Adding and taking away one and a half times 2²³ rounds to an integer.
    let magic = R::splat(12_582_912.0);
    let n = (x * R::splat(std::f32::consts::LOG2_E) + magic) - magic;
    let r = x - n * R::splat(LN_2[0]) - n * R::splat(LN_2[1]);
    let series = [1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0];
    polynomial(&series, r) * n.exp2_of_integer()
}

/// Natural logarithm of positive normal numbers, of one number or several; within 2·10⁻⁷ of itself.
///
/// `e ln 2 + ln m` with `m` in `[√½, √2)` and `ln m = 2 artanh s`, `s = (m − 1) / (m + 1)`, five terms of its series.
#[inline(always)]
pub fn ln_of<R: Real>(x: R) -> R {
    let (m, e) = x.mantissa_and_exponent();
    let f = m - R::splat(1.0);
    let s = f / (f + R::splat(2.0));
    let s2 = s * s;
    let series = [1.0 / 9.0, 1.0 / 7.0, 0.2, 1.0 / 3.0];
    let twice = s + s;
    e * R::splat(LN_2[0]) + (e * R::splat(LN_2[1]) + (twice + twice * s2 * polynomial(&series, s2)))
}

/// The polynomial with these coefficients, the highest first.
#[inline(always)]
fn polynomial<R: Real, const N: usize>(coefficients: &[f32; N], x: R) -> R {
    let mut sum = R::splat(coefficients[0]);
    for &c in &coefficients[1..] {
        sum = sum * x + R::splat(c);
    }
    sum
}

/// `eˣ` in double precision.
pub fn exp_f64(x: f64) -> f64 {
    libm::exp(x)
}

/// Natural logarithm in double precision.
pub fn ln_f64(x: f64) -> f64 {
    libm::log(x)
}

/// `x` to the power `y` in double precision.
pub fn powf_f64(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

/// `(sin x, cos x)` in double precision, `x` in radians.
pub fn sin_cos_f64(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// `tan x` in double precision, `x` in radians.
pub fn tan_f64(x: f64) -> f64 {
    libm::tan(x)
}

/// The complementary error function `2/√π ∫ₓ^∞ e^(−t²) dt`.
pub fn erfc(x: f64) -> f64 {
    libm::erfc(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponentials_and_logarithms_are_precise() {
        for step in 0..=200_000 {
            let x = -87.0 + 175.0 * step as f32 / 200_000.0;
            let exact = libm::exp(f64::from(x));
            assert!((f64::from(exp_of(x)) / exact - 1.0).abs() < 2e-7, "exp {x}");
            let y = f32::from_bits((1 << 23) + step * ((254 << 23) / 200_000));
            let exact = libm::log(f64::from(y));
            assert!((f64::from(ln_of(y)) - exact).abs() <= 2e-7 * exact.abs(), "ln {y:e}");
            let near = 1.0 + (step as f32 - 100_000.0) * f32::EPSILON;
            let exact = libm::log(f64::from(near));
            assert!((f64::from(ln_of(near)) - exact).abs() <= 2e-7 * exact.abs(), "ln {near}");
        }
    }

    #[test]
    fn rotations_turn_by_the_right_hand() {
        let quarter = rotation(Vec3::Y, std::f32::consts::FRAC_PI_2);
        assert!((quarter * Vec3::Z - Vec3::X).length() < 1e-6);
        let axis = Vec3::new(1.0, -2.0, 0.5).normalize();
        assert!((rotation(axis, 0.7) * axis - axis).length() < 1e-6);
        assert!((rotation(axis, 0.7).angle_between(Quat::IDENTITY) - 0.7).abs() < 1e-5);
    }
}
