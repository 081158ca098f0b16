//! Elementary functions with the same bits on every machine.
//!
//! `f32::sin` and its like call the system's library, whose last bit differs between systems and even
//! between processors on one system. These call `libm`, which is plain Rust arithmetic. The lint
//! `disallowed_methods` (clippy.toml) keeps the others out of the workspace.

use glam::{Quat, Vec3};

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
    fn rotations_turn_by_the_right_hand() {
        let quarter = rotation(Vec3::Y, std::f32::consts::FRAC_PI_2);
        assert!((quarter * Vec3::Z - Vec3::X).length() < 1e-6);
        let axis = Vec3::new(1.0, -2.0, 0.5).normalize();
        assert!((rotation(axis, 0.7) * axis - axis).length() < 1e-6);
        assert!((rotation(axis, 0.7).angle_between(Quat::IDENTITY) - 0.7).abs() < 1e-5);
    }
}
