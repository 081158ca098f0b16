//! Elementary functions with the same bits on every machine.
//!
//! `f32::sin` and the like call the system's library, whose last bit differs between systems and
//! even between processors on one system. The functions here call `libm`, which is plain Rust
//! arithmetic. [`exp2_of`], [`log2_1m_of`] and [`log2_of`] are plain arithmetic themselves, for one
//! number or several. The lint `disallowed_methods` (clippy.toml) keeps the system's functions out
//! of the workspace.

use glam::{Quat, Vec3};

use super::simd::Real;

/// `(sin x, cos x)`, `x` in radians.
#[inline]
pub fn sin_cos(x: f32) -> (f32, f32) {
    libm::sincosf(x)
}

/// The rotation by `angle` (radians) around the unit vector `axis`.
#[inline]
pub fn rotation(axis: Vec3, angle: f32) -> Quat {
    let (sin, cos) = sin_cos(0.5 * angle);
    let v = axis * sin;
    Quat::from_xyzw(v.x, v.y, v.z, cos)
}

/// `tan x`, `x` in radians.
#[inline]
pub fn tan(x: f32) -> f32 {
    libm::tanf(x)
}

/// `arccos x` in `[0, π]`; the argument is clamped to `[−1, 1]`.
#[inline]
pub fn acos(x: f32) -> f32 {
    libm::acosf(x.clamp(-1.0, 1.0))
}

/// Angle of the point `(x, y)` in `[−π, π]`.
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    libm::atan2f(y, x)
}

/// `x` to the power `y`.
#[inline]
pub fn powf(x: f32, y: f32) -> f32 {
    libm::powf(x, y)
}

/// `eˣ`.
#[inline]
pub fn exp(x: f32) -> f32 {
    libm::expf(x)
}

/// Natural logarithm.
#[inline]
pub fn ln(x: f32) -> f32 {
    libm::logf(x)
}

/// `2ˣ` for `x` in [−126, 127], for one number or several; relative error below 3·10⁻⁷.
///
/// The product `2ⁿ 2ʳ` with the integer `n` nearest to `x`. `2ʳ` is approximated by the minimax
/// polynomial of degree 5, with a relative error of at most 7.5·10⁻⁸ over `|r| ≤ ½` (found by
/// Remez's exchange).
#[inline(always)]
pub fn exp2_of<R: Real>(x: R) -> R {
    const SERIES: [f32; 6] = [1.0, 0.693_146_94, 0.240_221_2, 0.055_507_13, 0.009_675_541, 0.001_327_647_2];
    // Adding and then subtracting 1.5 · 2²³ rounds `x` to an integer.
    let magic = R::splat(12_582_912.0);
    let n = (x + magic) - magic;
    let r = x - n;
    let r2 = r * r;
    let linear = |i: usize| R::splat(SERIES[i]) + R::splat(SERIES[i + 1]) * r;
    (linear(0) + (linear(2) + linear(4) * r2) * r2) * n.exp2_of_integer()
}

/// `log₂(1 − x)` for `x` in [0, 1), for one number or several; relative error at most 6·10⁻⁷, also
/// for small `x`.
///
/// The sum `e + log₂(1 + f)` with `1 − x = (1 + f) 2ᵉ` and `1 + f` in `[√½, √2)`, where `f` is
/// exactly `−x` if `e` is zero. `log₂(1 + f) / f` is approximated by the minimax polynomial of
/// degree 7, with a relative error of at most 1.7·10⁻⁷ over that range (found by Remez's exchange).
#[inline(always)]
pub fn log2_1m_of<R: Real>(x: R) -> R {
    let u = R::splat(1.0) - x;
    let (m, e) = u.mantissa_and_exponent();
    let near_one = R::splat(std::f32::consts::FRAC_1_SQRT_2).le(u);
    log2_of_sum(e, R::select(near_one, R::splat(0.0) - x, m - R::splat(1.0)))
}

/// `log₂ x` for a positive normal number, or several; relative error at most 6·10⁻⁷. Near 1, where
/// the logarithm vanishes, the absolute error is at most 10⁻⁷.
#[inline(always)]
pub fn log2_of<R: Real>(x: R) -> R {
    let (m, e) = x.mantissa_and_exponent();
    log2_of_sum(e, m - R::splat(1.0))
}

/// `e + log₂(1 + f)` for `1 + f` in `[√½, √2)`.
#[inline(always)]
fn log2_of_sum<R: Real>(e: R, f: R) -> R {
    const SERIES: [f32; 8] = [
        1.442_694_9,
        -0.721_352_8,
        0.480_923_24,
        -0.360_239_62,
        0.287_098_7,
        -0.248_876_87,
        0.234_042_38,
        -0.145_811_69,
    ];
    let f2 = f * f;
    let linear = |i: usize| R::splat(SERIES[i]) + R::splat(SERIES[i + 1]) * f;
    let (low, high) = (linear(0) + linear(2) * f2, linear(4) + linear(6) * f2);
    e + f * (low + high * (f2 * f2))
}

/// `eˣ` in double precision.
#[inline]
pub fn exp_f64(x: f64) -> f64 {
    libm::exp(x)
}

/// Natural logarithm in double precision.
#[inline]
pub fn ln_f64(x: f64) -> f64 {
    libm::log(x)
}

/// `x` to the power `y` in double precision.
#[inline]
pub fn powf_f64(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

/// `(sin x, cos x)` in double precision, `x` in radians.
#[inline]
pub fn sin_cos_f64(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// Angle of the point `(x, y)` in `[−π, π]`, in double precision.
#[inline]
pub fn atan2_f64(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// `tan x` in double precision, `x` in radians.
#[inline]
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
            let x = -126.0 + 253.0 * step as f32 / 200_000.0;
            let exact = libm::exp2(f64::from(x));
            assert!((f64::from(exp2_of(x)) / exact - 1.0).abs() < 3e-7, "exp2 {x}");
            let share = step as f32 / 200_001.0;
            for x in [
                share,
                share * share * share,
                share * 1e-6,
                1.0 - share * share * 0.3,
                1.0 - f32::EPSILON / 2.0,
            ] {
                let x = x.min(1.0 - f32::EPSILON / 2.0);
                let exact = libm::log1p(-f64::from(x)) * std::f64::consts::LOG2_E;
                assert!((f64::from(log2_1m_of(x)) - exact).abs() <= 6e-7 * exact.abs(), "log2(1 - {x:e})");
            }
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
