//! Elementary functions with the same bits on every machine.
//!
//! `f32::sin` and its like call the system's library, whose last bit differs between systems and even
//! between processors on one system. These call `libm`, which is plain Rust arithmetic. The lint
//! `disallowed_methods` (clippy.toml) keeps the others out of the workspace.

/// `(sin x, cos x)`, `x` in radians.
pub fn sin_cos(x: f32) -> (f32, f32) {
    libm::sincosf(x)
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
