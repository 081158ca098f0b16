//! Sheen: light that the fibres of cloth reflect, mostly at grazing angles.
//!
//! ```text
//! f_s = c D V,      D = (2 + 1/α) sin^{1/α} θ_h / 2π,      V = 1 / ((1 + Λ(c_o) + Λ(c_i)) 4 c_o c_i)
//! ```
//!
//! in sr⁻¹, with the colour `c` and `α = r²` for the roughness `r`. `Λ(x)` is `exp l(x)` at cosines
//! `x` below ½ and `exp(2 l(½) − l(1 − x))` above, with `l(x) = a / (1 + b x^γ) + d x + e`. The
//! parameters `a`, `b`, `γ`, `d`, `e` are functions of `α` (Kulla 2017; `KHR_materials_sheen`,
//! Khronos). `Λ` falls as the cosine grows.
//!
//! The factor on the base is `1 − max c · E(c_o)`, where `E` is the albedo of white sheen seen at
//! `c_o`. The extension specifies two forms of this factor; the one used here depends only on the
//! direction of view. `E` is read from a table over roughness and cosine, with an error of at most
//! 0.01 at cosines above 0.2 and at most 0.03 above 0.02.
//!
//! Directions are drawn uniformly from the hemisphere.
//!
//! # Limits
//! Roughness is at least [`MIN_SHEEN_ROUGHNESS`]. At cosines below about 0.05 fine fibres reflect
//! more light than they receive, up to 2.7 times as much, and the factor on the base is 0.
//!
//! # Held to this by
//! The tests below, `bsdf::tests`, and the suite's `formula_materials`.

mod table;

use std::f32::consts::{FRAC_1_PI, LOG2_E};

use super::microfacet::HalfVector;
use super::validate;
use crate::color::Rgb;
use crate::math::elementary::{exp2_of, log2_of};
use crate::math::{Real, Vec3};
use crate::warp;
use table::{ALBEDOS, ROUGHNESSES};

/// Smallest roughness. At smaller values, sheen is visible only within 6° of the surface.
pub const MIN_SHEEN_ROUGHNESS: f32 = 0.1;

/// Upper bound on `V` divided by `1 / 4 c_o`, for all roughnesses.
///
/// `Λ(c) ≥ 0`, and `c (1 + Λ(c)) ≥ 0.163` at cosines from [`MIN_COSINE`](super::MIN_COSINE) on.
pub const UPPER_SHEEN_VISIBILITY: f64 = 1.0 / 0.16;

/// Exponent of two below which powers are negligible: the limit of `exp2_of`.
const NEGLIGIBLE_POWER: f32 = -125.0;

/// Light reflected by fibres on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheen {
    /// Colour `c`, each channel in `[0, 1]`; black without sheen.
    pub color: Rgb,
    /// Roughness `r`, from [`MIN_SHEEN_ROUGHNESS`] to 1. Higher values extend the sheen from the
    /// horizon upwards.
    pub roughness: f32,
}

impl Sheen {
    /// Sheen of a surface without fibres.
    pub const NONE: Self = Self { color: Rgb::BLACK, roughness: 1.0 };

    /// Returns true if the colour is not black.
    #[inline]
    pub fn is_there(&self) -> bool {
        !self.color.is_black()
    }

    /// Value of white sheen, `D V` (sr⁻¹).
    #[inline(always)]
    pub(super) fn white<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> R {
        let HalfVector { tangential2, axial2 } = HalfVector::between(wo, wi);
        let inverse = 1.0 / (self.roughness * self.roughness);
        let sine2 = (tangential2 / (tangential2 + axial2)).max(R::splat(f32::MIN_POSITIVE));
        let power = (R::splat(0.5 * inverse) * log2_of(sine2)).max(R::splat(NEGLIGIBLE_POWER));
        let distribution = R::splat(0.5 * FRAC_1_PI * (2.0 + inverse)) * exp2_of(power);
        let fibres = Fibres::of(self.roughness);
        let hidden = R::splat(1.0 + fibres.hidden(wo.z)) + fibres.hidden(wi[2]);
        distribution / (hidden * R::splat(4.0 * wo.z) * wi[2])
    }

    /// Factor on the base, seen at the cosine `cos_o`.
    #[inline]
    pub fn left(&self, cos_o: f32) -> f32 {
        if self.is_there() {
            (1.0 - self.color.max_channel() * self.white_albedo(cos_o)).max(0.0)
        } else {
            1.0
        }
    }

    /// Albedo `c E`, seen at the cosine `cos_o`.
    pub(super) fn albedo(&self, cos_o: f32) -> Rgb {
        if self.is_there() { self.color * self.white_albedo(cos_o) } else { Rgb::BLACK }
    }

    /// Albedo `E` of white sheen, from the table.
    fn white_albedo(&self, cos_o: f32) -> f32 {
        let last = ALBEDOS[0].len() - 1;
        let column = cos_o.clamp(0.0, 1.0).sqrt() * last as f32;
        let (first, along) = ((column as usize).min(last - 1), column);
        let along = along - first as f32;
        let row = ROUGHNESSES.partition_point(|r| *r <= self.roughness).clamp(1, ROUGHNESSES.len() - 1) - 1;
        let across = (self.roughness - ROUGHNESSES[row]) / (ROUGHNESSES[row + 1] - ROUGHNESSES[row]);
        let of = |row: &[f32; 17]| row[first] + along * (row[first + 1] - row[first]);
        let [near, far] = [of(&ALBEDOS[row]), of(&ALBEDOS[row + 1])];
        near + across.clamp(0.0, 1.0) * (far - near)
    }

    /// Masking and shadowing `Λ` of the fibres at a cosine.
    pub fn hidden(&self, cos: f32) -> f32 {
        Fibres::of(self.roughness).hidden(cos)
    }

    /// Density of the drawn directions (sr⁻¹).
    pub(super) const PDF: f32 = 0.5 * FRAC_1_PI;

    pub(super) fn draw(u: [f32; 2]) -> Vec3 {
        warp::cone(u, 0.0)
    }

    pub(super) fn validate(&self) -> Result<(), String> {
        validate::fraction("colour of the sheen", self.color)?;
        validate::in_range("roughness of the sheen", self.roughness, MIN_SHEEN_ROUGHNESS, 1.0)
    }
}

/// Parameters of `l` for one roughness.
#[derive(Clone, Copy)]
struct Fibres {
    /// `a`, `b`, `γ`, `d`, `e`.
    numbers: [f32; 5],
}

impl Fibres {
    /// Parameters for `α = 1`, and for `α = 0`.
    const ENDS: [[f32; 5]; 2] =
        [[21.5473, 3.82987, 0.19823, -1.97760, -4.32054], [25.3245, 3.32435, 0.16801, -1.27393, -4.85967]];

    #[inline]
    fn of(roughness: f32) -> Self {
        let share = (1.0 - roughness * roughness) * (1.0 - roughness * roughness);
        let [rough, fine] = Self::ENDS;
        Self { numbers: std::array::from_fn(|k| rough[k] + share * (fine[k] - rough[k])) }
    }

    /// Exponent `l(x)` of `Λ`.
    #[inline(always)]
    fn curve<R: Real>(&self, x: R) -> R {
        let [a, b, exponent, d, e] = self.numbers.map(R::splat);
        let power = exp2_of(exponent * log2_of(x.max(R::splat(f32::MIN_POSITIVE))));
        a / (R::splat(1.0) + b * power) + d * x + e
    }

    /// Masking and shadowing `Λ`.
    #[inline(always)]
    fn hidden<R: Real>(&self, cos: R) -> R {
        let half = R::splat(0.5);
        let steep = half.gt(cos);
        let curve = self.curve(R::select(steep, cos, (R::splat(1.0) - cos).max(R::splat(0.0))));
        let flat = R::splat(2.0 * self.curve(0.5)) - curve;
        exp2_of(R::select(steep, curve, flat) * R::splat(LOG2_E))
    }
}

#[cfg(test)]
mod tests {
    use super::super::MIN_COSINE;
    use super::*;
    use crate::math::elementary::powf;
    use crate::rng::{Purpose, Stream};

    /// The table agrees with means over uniform directions. The table was not made from such means.
    #[test]
    fn the_table_is_the_albedo() {
        let mut s = Stream::new(91, Purpose::Test, 0);
        for round in 0..60 {
            let roughness = MIN_SHEEN_ROUGHNESS + (1.0 - MIN_SHEEN_ROUGHNESS) * s.uniform();
            let cos = if round % 3 == 0 { 0.02 + 0.18 * s.uniform() } else { 0.2 + 0.8 * s.uniform() };
            let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
            let sheen = Sheen { color: Rgb::WHITE, roughness };
            let (mut sum, mut squares) = (0.0_f64, 0.0_f64);
            const DRAWS: u32 = 100_000;
            for _ in 0..DRAWS {
                let wi = Sheen::draw(s.uniform_2());
                let value = f64::from(sheen.white(wo, wi.to_array()) * wi.z / Sheen::PDF);
                sum += value;
                squares += value * value;
            }
            let mean = sum / f64::from(DRAWS);
            let error = ((squares / f64::from(DRAWS) - mean * mean) / f64::from(DRAWS)).sqrt();
            let off = (mean - f64::from(sheen.white_albedo(cos))).abs();
            let limit = if cos > 0.2 { 0.01 } else { 0.03 };
            assert!(off < limit + 4.0 * error, "{roughness} {cos}: {mean} ± {error}, off by {off}");
        }
    }

    /// `Λ` is not negative, falls as the cosine grows, and is as large near the horizon as
    /// [`UPPER_SHEEN_VISIBILITY`] assumes.
    #[test]
    fn what_fibres_hide_is_bounded() {
        for step in 0..=90 {
            let roughness = MIN_SHEEN_ROUGHNESS + 0.01 * step as f32;
            let fibres = Fibres::of(roughness);
            let mut before = f32::INFINITY;
            for step in 0..=4000 {
                let cos = MIN_COSINE * powf(1.0 / MIN_COSINE, step as f32 / 4000.0);
                let hidden = fibres.hidden(cos);
                assert!(hidden >= 0.0 && hidden <= before * (1.0 + 1e-5), "{roughness} {cos}: {hidden}");
                let visible = f64::from(cos) * (1.0 + f64::from(hidden));
                assert!(visible * UPPER_SHEEN_VISIBILITY > 1.005, "{roughness} {cos}: {visible}");
                before = hidden;
            }
        }
    }
}
