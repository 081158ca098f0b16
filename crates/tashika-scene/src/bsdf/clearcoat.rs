//! Clear coat, as defined by three formats.
//!
//! With the amount `w`, `F(c) = 0.04 + 0.96 (1 − c)⁵`, `c_d = ω_i·h` and `v(c) = 1 / (c + S(c))`,
//! where `S` is that of GGX facets of roughness ¼ ([`microfacet`]):
//!
//! | [`CoatModel`] | `f_c` (sr⁻¹) | factor on the base |
//! |---|---|---|
//! | `Disney` | `¼ w F(c_d) D₁ v(c_o) v(c_i)` | 1 |
//! | `Mitsuba` | `w F(c_d) D₁ c_o v(c_o) c_i v(c_i)` | 1 |
//! | `Layer` | `w F(c_o) D G₂ / (4 c_o c_i)` | `1 − w F(c_o)` |
//!
//! ```text
//! D₁ = (1 − α²) / (−2π ln α) · (1 + t) / (α² + t),    t = tan²θ_h                (sr⁻¹)
//! ```
//!
//! (Burley 2012, appendix B.2, GTR with `γ = 1`, in a form without cancellation, and section 5.6;
//! `KHR_materials_clearcoat`, Khronos.) `c_o` is the cosine at which a surface is *seen*. The layer
//! is not reciprocal: light paths, too, evaluate it with the cosine of the direction towards the
//! viewer.
//!
//! Facets of `D₁` are drawn in proportion to `D₁ cos θ_h`, with
//!
//! ```text
//! sin²θ_h = α² (α^(−2u) − 1) / (1 − α²)          density of ω_i:   D₁ cos θ_h / 4 c_d
//! ```
//!
//! # Limits
//! The coats of Disney and of Mitsuba do not reduce the light of the base: they increase the albedo
//! by up to `0.05 w` and `0.04 w`.
//!
//! # Held to this by
//! `bsdf::tests`, and the suite's `mitsuba_materials` and `formula_materials`.

use std::f32::consts::{FRAC_1_PI, PI};

use super::{MIN_ALPHA, fresnel, microfacet, validate};
use crate::math::elementary::{exp, ln, sin_cos};
use crate::math::{Real, Vec3};
use microfacet::{HalfVector, Microfacets, ggx};

/// Reflectance of a coat at normal incidence: an index of 1.5.
pub(crate) const COAT_F0: f32 = 0.04;

/// Roughness of the facets that mask and shadow under `D₁`, for every `α`.
pub const MASKING_ALPHA: f32 = 0.25;

/// Largest `α` of `D₁`, for the widest highlight.
pub const MAX_GTR1_ALPHA: f32 = 0.1;

/// Reflection of a clear coat, and its effect on the base.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CoatModel {
    /// Disney's, as in pbrt-v3.
    Disney,
    /// Disney's, as in Mitsuba 3: with the further factor `4 c_o c_i`.
    Mitsuba,
    /// A layer of GGX facets, as in glTF. The light of the base is reduced by the share that the
    /// layer reflects.
    Layer,
}

impl CoatModel {
    /// All variants, in the order of their declaration.
    pub const ALL: [Self; 3] = [Self::Disney, Self::Mitsuba, Self::Layer];
}

/// Clear coat over an opaque surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearcoat {
    /// Amount `w` of the coat, from 0 (none) to 1.
    pub amount: f32,
    /// Roughness `α`, in [[`MIN_ALPHA`], [`MAX_GTR1_ALPHA`]], or in [[`MIN_ALPHA`], 1] for a layer.
    /// Higher values make the highlight wider.
    pub alpha: f32,
    /// Definition of the coat.
    pub model: CoatModel,
}

impl Clearcoat {
    /// No coat: its amount is 0.
    pub const NONE: Self = Self { amount: 0.0, alpha: 1.0, model: CoatModel::Layer };

    /// Factor on the base, seen at the cosine `cos_o`.
    #[inline]
    pub fn left(&self, cos_o: f32) -> f32 {
        match self.model {
            CoatModel::Disney | CoatModel::Mitsuba => 1.0,
            CoatModel::Layer => 1.0 - self.layer(cos_o),
        }
    }

    /// Share of the light that a layer reflects, `w F(c_o)`.
    #[inline]
    pub fn layer(&self, cos_o: f32) -> f32 {
        self.amount * reflectance(cos_o)
    }

    /// Value `f_c` of the coat (sr⁻¹).
    #[inline(always)]
    pub(super) fn eval<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> R {
        let half = HalfVector::between(wo, wi);
        let (cos_o, cos_i) = (wo.z, wi[2]);
        let strength = match self.model {
            CoatModel::Layer => {
                return Microfacets::ggx(self.alpha).reflection(half, wo, wi) * R::splat(self.layer(cos_o));
            }
            CoatModel::Disney => R::splat(0.25 * self.amount),
            CoatModel::Mitsuba => R::splat(self.amount) * (R::splat(cos_o) * cos_i),
        };
        let stretch_o = ggx::stretch(cos_o, MASKING_ALPHA);
        let stretch_i = ggx::stretch(cos_i, MASKING_ALPHA);
        let visibility = ggx::independent_visibility(cos_o, stretch_o, cos_i, stretch_i);
        let HalfVector { tangential2, axial2 } = half;
        let peak = R::splat(self.alpha * self.alpha) * axial2 + tangential2;
        let distribution = R::splat(gtr1_scale(self.alpha)) * (tangential2 + axial2) / peak;
        strength * reflectance(half.cos_incidence()) * distribution * visibility
    }

    /// Density of [`Clearcoat::draw`] (sr⁻¹).
    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        let half = HalfVector::between(wo, wi.to_array());
        match self.model {
            CoatModel::Layer => Microfacets::ggx(self.alpha).reflection_pdf(half, wo, wi),
            CoatModel::Disney | CoatModel::Mitsuba => {
                let peak = self.alpha * self.alpha * half.axial2 + half.tangential2;
                0.5 * gtr1_scale(self.alpha) * half.axial2.sqrt() / peak
            }
        }
    }

    pub(super) fn draw(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        match self.model {
            CoatModel::Layer => Microfacets::ggx(self.alpha).sample_reflection(wo, u),
            CoatModel::Disney | CoatModel::Mitsuba => {
                let alpha2 = self.alpha * self.alpha;
                let sin2 = alpha2 * (exp(-2.0 * u[0] * ln(self.alpha)) - 1.0) / (1.0 - alpha2);
                let (sin, cos) = (sin2.min(1.0).sqrt(), (1.0 - sin2).max(0.0).sqrt());
                let (sin_phi, cos_phi) = sin_cos(2.0 * PI * u[1]);
                let h = Vec3::new(sin * cos_phi, sin * sin_phi, cos);
                (h * (2.0 * wo.dot(h)) - wo).normalize()
            }
        }
    }

    /// Estimate of the albedo of the coat, with the Fresnel reflectance and the masking of flat
    /// facets.
    pub(super) fn importance(&self, cos_o: f32) -> f32 {
        let unmasked = cos_o / (cos_o + ggx::stretch(cos_o, MASKING_ALPHA));
        match self.model {
            CoatModel::Disney => self.layer(cos_o) * unmasked * unmasked,
            CoatModel::Mitsuba => self.layer(cos_o) * (2.0 * cos_o * unmasked) * (2.0 * cos_o * unmasked),
            CoatModel::Layer => self.layer(cos_o),
        }
    }

    pub(super) fn validate(&self) -> Result<(), String> {
        let largest = if self.model == CoatModel::Layer { 1.0 } else { MAX_GTR1_ALPHA };
        validate::in_range("amount of the coat", self.amount, 0.0, 1.0)?;
        validate::in_range("alpha of the coat", self.alpha, MIN_ALPHA, largest)
    }
}

/// Reflectance `F` of a coat at the cosine `cos` of the angle of incidence.
#[inline(always)]
pub fn reflectance<R: Real>(cos: R) -> R {
    R::splat(COAT_F0) + R::splat(1.0 - COAT_F0) * fresnel::schlick_weight(cos)
}

/// Factor `(1 − α²) / (−2π ln α)` of `D₁`, which makes `∫ D₁ cos θ_h dω_h` one.
#[inline]
fn gtr1_scale(alpha: f32) -> f32 {
    0.5 * FRAC_1_PI * (1.0 - alpha * alpha) / -ln(alpha)
}
