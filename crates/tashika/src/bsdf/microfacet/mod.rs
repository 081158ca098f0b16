//! Microfacets: which normals the facets of a rough surface have, and how they hide each other.
//!
//! ```text
//! D G₂ / (4 c_o c_i)                       what facets that reflect all light reflect (sr⁻¹)
//! D_v / (4 ω_o·h),  D_v = (ω_o·h)⁺ D / ∫ (ω_o·m)⁺ D dm        density of ω_i by visible normals (sr⁻¹)
//! ```
//!
//! (Cook and Torrance 1982; Walter et al. 2007, equation 20; Heitz 2014, equation 2.) `D` and what
//! one direction sees are those of `ggx` or `beckmann`; `G₂` is by [`FacetModel`], since formats
//! mean different things by the same roughness.
//!
//! # Precision
//! The half vector is never normalised: its angles come from `ω_o + ω_i` as it is, which cannot be
//! zero for two directions above the horizon. What remains is the rounding of the directions: it
//! turns the half vector by about `10⁻⁷ / 2 ω_o·h`, to be compared with `α`. Hence [`MIN_ALPHA`].
//!
//! # Held to this by
//! The tests of `ggx` and `beckmann`, the `χ²` tests of `bsdf::tests`, and the suite's
//! `mitsuba_materials` against Mitsuba 3.

pub(crate) mod beckmann;
pub(crate) mod ggx;

use crate::math::{Real, Vec3};

/// Smallest roughness `α` for which `f32` directions determine the value.
///
/// There, the lobe is 0.06° wide and its peak at normal incidence `D = 1 / (π α²) = 3.2·10⁵` sr⁻¹.
/// Rounding the directions changes values by less than 1 % for cosines above 0.1 and by less than
/// 10 % above 0.01 (test `rounding_is_harmless_down_to_min_alpha`). Smoother surfaces are a
/// [`Mirror`](super::Mirror) or [`Glass`](super::Glass), or are given this value.
pub const MIN_ALPHA: f32 = 1e-3;

/// The distribution of the normals of facets, and how masking and shadowing go together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FacetModel {
    /// GGX; `G₂ = 1 / (1 + Λ_o + Λ_i)`, masking and shadowing correlated by height (Heitz 2014,
    /// equation 99). glTF and pbrt mean this.
    #[default]
    Ggx,
    /// GGX; `G₂ = G₁(o) G₁(i)`, masking and shadowing independent (Walter et al. 2007, equation
    /// 23). Mitsuba's `ggx`.
    GgxIndependent,
    /// Beckmann's distribution; `G₂ = G₁(o) G₁(i)`. Mitsuba's `beckmann`, its default.
    Beckmann,
}

impl FacetModel {
    /// All of them.
    pub(crate) const ALL: [Self; 3] = [Self::Ggx, Self::GgxIndependent, Self::Beckmann];
}

/// The facets of a rough surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microfacets {
    /// Roughness `α` in [[`MIN_ALPHA`], 1]. Higher values make the lobe wider.
    pub alpha: f32,
    /// What they are distributed by.
    pub model: FacetModel,
}

impl Microfacets {
    /// GGX facets, correlated by height.
    pub const fn ggx(alpha: f32) -> Self {
        Self { alpha, model: FacetModel::Ggx }
    }

    /// `D G₂ / (4 c_o c_i)` (sr⁻¹) of directions above the horizon.
    #[inline(always)]
    pub fn reflection<R: Real>(&self, half: HalfVector<R>, cos_o: f32, cos_i: R) -> R {
        let alpha = self.alpha;
        match self.model {
            FacetModel::Ggx => ggx::distribution(half, alpha) * ggx::visibility(cos_o, cos_i, alpha),
            FacetModel::GgxIndependent => {
                ggx::distribution(half, alpha) * ggx::independent_visibility(cos_o, cos_i, alpha)
            }
            FacetModel::Beckmann => {
                beckmann::distribution(half, alpha) * beckmann::visibility(cos_o, cos_i, alpha)
            }
        }
    }

    /// Density (sr⁻¹) of the reflections drawn by [`Microfacets::sample_reflection`].
    #[inline]
    pub fn reflection_pdf(&self, cos_o: f32, half: HalfVector<f32>) -> f32 {
        match self.model {
            FacetModel::Ggx | FacetModel::GgxIndependent => {
                ggx::distribution(half, self.alpha) / (4.0 * ggx::visible_area(cos_o, self.alpha))
            }
            FacetModel::Beckmann => {
                beckmann::distribution(half, self.alpha) / (4.0 * beckmann::visible_area(cos_o, self.alpha))
            }
        }
    }

    /// `G₂ / G₁(o)`: how much of what facets seen from one side send to the other is not in shadow,
    /// of the cosines of both with the normal, without sign.
    pub(super) fn unshadowed(&self, cos_o: f32, cos_i: f32) -> f32 {
        let alpha = self.alpha;
        match self.model {
            FacetModel::Ggx => {
                4.0 * cos_i * ggx::visible_area(cos_o, alpha) * ggx::visibility(cos_o, cos_i, alpha)
            }
            FacetModel::GgxIndependent => cos_i / ggx::visible_area(cos_i, alpha),
            FacetModel::Beckmann => cos_i / beckmann::visible_area(cos_i, alpha),
        }
    }

    /// Reflects `wo` (`z > 0`) at a facet drawn from those that it sees.
    ///
    /// The result may lie below the horizon; such paths end in the single-scattering model.
    pub fn sample_reflection(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        let h = self.sample_visible_normal(wo, u);
        (h * (2.0 * wo.dot(h)) - wo).normalize()
    }

    /// Draws a normal with the density `D_v` of those that `wo` (`z > 0`) sees.
    ///
    /// A surface stretched to `α = 1` has facets of the same kind, of which `wo`, stretched, sees
    /// the same ones (Heitz and d'Eon 2014).
    pub fn sample_visible_normal(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        let alpha = self.alpha;
        let w = Vec3::new(alpha * wo.x, alpha * wo.y, wo.z).normalize();
        let h = match self.model {
            FacetModel::Ggx | FacetModel::GgxIndependent => ggx::sample_visible_normal(w, u),
            FacetModel::Beckmann => beckmann::sample_visible_normal(w, u),
        };
        Vec3::new(alpha * h.x, alpha * h.y, h.z).normalize()
    }
}

impl From<f32> for Microfacets {
    /// GGX facets, correlated by height.
    fn from(alpha: f32) -> Self {
        Self::ggx(alpha)
    }
}

/// The half vector of two directions above the horizon, as far as the model needs it, not
/// normalised.
#[derive(Clone, Copy, Debug)]
pub struct HalfVector<R> {
    /// Squared length of the part in the surface.
    pub tangential2: R,
    /// Squared length of the part along the normal.
    pub axial2: R,
}

impl<R: Real> HalfVector<R> {
    /// `ω_o + ω_i` of unit vectors with positive `z`.
    #[inline(always)]
    pub fn between(wo: Vec3, wi: [R; 3]) -> Self {
        let [x, y, z] = [R::splat(wo.x) + wi[0], R::splat(wo.y) + wi[1], R::splat(wo.z) + wi[2]];
        Self { tangential2: x * x + y * y, axial2: z * z }
    }

    /// `ω_o·h = ω_i·h = ‖ω_o + ω_i‖ / 2`, in `[0, 1]`.
    #[inline(always)]
    pub fn cos_incidence(self) -> R {
        (R::splat(0.5) * (self.tangential2 + self.axial2).sqrt()).min(R::splat(1.0))
    }
}

#[cfg(test)]
mod tests;
