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
//! # Brushed surfaces
//! Facets of roughness `α_u` along the first axis of the shading frame and `α_v` along the second
//! are those of roughness 1, squeezed by `α_u` and `α_v` (Heitz 2014, section 5). With the mean
//! `ᾱ = √(α_u α_v)`, `h` the half vector of any length and `ω` a direction of cosine `c`,
//!
//! ```text
//! D(h)    is that of ᾱ with (α_v/α_u) h_x² + (α_u/α_v) h_y² in place of h_x² + h_y² in t, but for 1 + t
//! G₁(ω)   is that of the roughness α with α² sin²θ = α_u² ω_x² + α_v² ω_y²
//! ```
//!
//! Surfaces that are as rough in all directions are evaluated without these sums.
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

/// Largest roughness along an axis. The principled material reaches `√10`.
pub const MAX_ALPHA: f32 = 4.0;

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
    pub const ALL: [Self; 3] = [Self::Ggx, Self::GgxIndependent, Self::Beckmann];
}

/// The facets of a rough surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microfacets {
    /// Roughness `α` along the first and the second axis of the shading frame. Higher values make
    /// the lobe wider. The smaller is in [[`MIN_ALPHA`], 1], the larger at most [`MAX_ALPHA`], of
    /// Beckmann's facets 1.
    pub alpha: [f32; 2],
    /// What they are distributed by.
    pub model: FacetModel,
}

impl Microfacets {
    /// Facets of roughness `alpha` in all directions.
    pub const fn even(alpha: f32, model: FacetModel) -> Self {
        Self { alpha: [alpha; 2], model }
    }

    /// GGX facets, correlated by height.
    pub const fn ggx(alpha: f32) -> Self {
        Self::even(alpha, FacetModel::Ggx)
    }

    /// Whether they are as rough in all directions.
    #[inline(always)]
    pub fn is_even(&self) -> bool {
        self.alpha[0] == self.alpha[1]
    }

    /// The smaller roughness.
    pub fn narrowest(&self) -> f32 {
        self.alpha[0].min(self.alpha[1])
    }

    /// The larger roughness.
    pub fn widest(&self) -> f32 {
        self.alpha[0].max(self.alpha[1])
    }

    /// The geometric mean `ᾱ` of both.
    #[inline(always)]
    pub fn mean(&self) -> f32 {
        let [u, v] = self.alpha;
        if u == v { u } else { (u * v).sqrt() }
    }

    /// The root mean square of both.
    #[inline(always)]
    pub(super) fn root_mean_square(&self) -> f32 {
        let [u, v] = self.alpha;
        if u == v { u } else { (0.5 * (u * u + v * v)).sqrt() }
    }

    /// `D G₂ / (4 c_o c_i)` (sr⁻¹) of directions above the horizon.
    ///
    /// * `half`: of both.
    #[inline(always)]
    pub fn reflection<R: Real>(&self, half: HalfVector<R>, wo: Vec3, wi: [R; 3]) -> R {
        let (slopes, alpha, cos_i) = (self.squeezed(half, wo, wi), self.mean(), wi[2]);
        match self.model {
            FacetModel::Ggx => {
                let [o, i] = [R::splat(self.stretch(wo.to_array())), self.stretch(wi)];
                ggx::distribution(half, slopes, alpha) * ggx::visibility(wo.z, o, cos_i, i)
            }
            FacetModel::GgxIndependent => {
                let (o, i) = (self.stretch(wo.to_array()), self.stretch(wi));
                ggx::distribution(half, slopes, alpha) * ggx::independent_visibility(wo.z, o, cos_i, i)
            }
            FacetModel::Beckmann => {
                let (o, i) = (self.spread(wo.to_array()), self.spread(wi));
                beckmann::distribution(half, slopes, alpha) * beckmann::visibility(wo.z, o, cos_i, i)
            }
        }
    }

    /// `D` (sr⁻¹).
    ///
    /// * `half`: of both.
    #[inline(always)]
    pub(super) fn distribution<R: Real>(&self, half: HalfVector<R>, wo: Vec3, wi: [R; 3]) -> R {
        let (slopes, alpha) = (self.squeezed(half, wo, wi), self.mean());
        match self.model {
            FacetModel::Ggx | FacetModel::GgxIndependent => ggx::distribution(half, slopes, alpha),
            FacetModel::Beckmann => beckmann::distribution(half, slopes, alpha),
        }
    }

    /// Density (sr⁻¹) of the reflections drawn by [`Microfacets::sample_reflection`].
    #[inline]
    pub fn reflection_pdf(&self, half: HalfVector<f32>, wo: Vec3, wi: Vec3) -> f32 {
        self.distribution(half, wo, wi.to_array()) / (4.0 * self.visible_area(wo))
    }

    /// `G₂ / G₁(o)`: how much of what facets seen from one side send to the other is not in shadow,
    /// of directions above the horizon or mirrored to there.
    pub(super) fn unshadowed(&self, wo: Vec3, wi: Vec3) -> f32 {
        match self.model {
            FacetModel::Ggx => {
                let [o, i] = [wo, wi].map(|w| self.stretch(w.to_array()));
                4.0 * wi.z * self.visible_area(wo) * ggx::visibility(wo.z, o, wi.z, i)
            }
            FacetModel::GgxIndependent | FacetModel::Beckmann => wi.z / self.visible_area(wi),
        }
    }

    /// `∫ (ω·m)⁺ D dm = c / G₁`: projected area of the facets that face a direction above the
    /// horizon.
    #[inline]
    fn visible_area(&self, w: Vec3) -> f32 {
        match self.model {
            FacetModel::Ggx | FacetModel::GgxIndependent => {
                ggx::visible_area(w.z, self.stretch(w.to_array()))
            }
            FacetModel::Beckmann => {
                let [u, v] = self.alpha.map(f64::from);
                let [x, y, cos] = [w.x, w.y, w.z].map(f64::from);
                let spread = if u == v {
                    u * (1.0 - cos * cos).max(0.0).sqrt()
                } else {
                    (u * u * x * x + v * v * y * y).sqrt()
                };
                beckmann::visible_area(cos, spread)
            }
        }
    }

    /// Squared length of the part of the half vector in the surface, each component in units of its
    /// roughness, times `ᾱ²`.
    #[inline(always)]
    fn squeezed<R: Real>(&self, half: HalfVector<R>, wo: Vec3, wi: [R; 3]) -> R {
        let [u, v] = self.alpha;
        if u == v {
            return half.tangential2;
        }
        let (x, y) = (R::splat(wo.x) + wi[0], R::splat(wo.y) + wi[1]);
        R::splat(v / u) * x * x + R::splat(u / v) * y * y
    }

    /// `S`: length of a direction after stretching the surface to a roughness of 1.
    #[inline(always)]
    fn stretch<R: Real>(&self, w: [R; 3]) -> R {
        let [u, v] = self.alpha;
        if u == v {
            return ggx::stretch(w[2], u);
        }
        let (x, y) = (R::splat(u) * w[0], R::splat(v) * w[1]);
        (x * x + y * y + w[2] * w[2]).sqrt()
    }

    /// `α sin θ` of a direction.
    #[inline(always)]
    fn spread<R: Real>(&self, w: [R; 3]) -> R {
        let [u, v] = self.alpha;
        if u == v {
            return beckmann::spread(w[2], u);
        }
        let (x, y) = (R::splat(u) * w[0], R::splat(v) * w[1]);
        (x * x + y * y).max(R::splat(f32::MIN_POSITIVE)).sqrt()
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
        let [along, across] = self.alpha;
        let w = Vec3::new(along * wo.x, across * wo.y, wo.z).normalize();
        let h = match self.model {
            FacetModel::Ggx | FacetModel::GgxIndependent => ggx::sample_visible_normal(w, u),
            FacetModel::Beckmann => beckmann::sample_visible_normal(w, u),
        };
        Vec3::new(along * h.x, across * h.y, h.z).normalize()
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
