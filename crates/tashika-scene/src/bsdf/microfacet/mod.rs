//! Microfacets: distribution of the normals of a rough surface, and mutual masking of its facets.
//!
//! ```text
//! D G₂ / (4 c_o c_i)                       what facets that reflect all light reflect (sr⁻¹)
//! D_v / (4 ω_o·h),  D_v = (ω_o·h)⁺ D / ∫ (ω_o·m)⁺ D dm        density of ω_i by visible normals (sr⁻¹)
//! ```
//!
//! (Cook and Torrance 1982; Walter et al. 2007, equation 20; Heitz 2014, equation 2.) `D` and the
//! visible area `∫ (ω_o·m)⁺ D dm` are those of `ggx` or `beckmann`. `G₂` depends on the
//! [`FacetModel`], since file formats combine the same `D` with different `G₂`.
//!
//! # Brushed surfaces
//! Facets of roughness `α_u` along the first axis of the shading frame and `α_v` along the second
//! are facets of roughness 1 after the surface's slopes along the two axes are multiplied by `α_u`
//! and `α_v` (Heitz 2014, section 5). With the mean `ᾱ = √(α_u α_v)`, `h` the half vector of any
//! length and `ω` a direction of cosine `c`,
//!
//! ```text
//! D(h)    is that of ᾱ with (α_v/α_u) h_x² + (α_u/α_v) h_y² in place of h_x² + h_y² in t, but for 1 + t
//! G₁(ω)   is that of the roughness α with α² sin²θ = α_u² ω_x² + α_v² ω_y²
//! ```
//!
//! Isotropic surfaces are evaluated without these sums.
//!
//! # Precision
//! The half vector is never normalised: its angles come directly from `ω_o + ω_i`, which cannot be
//! zero for two directions above the horizon. The remaining error is the rounding of the
//! directions. It turns the half vector by about `10⁻⁷ / 2 ω_o·h`, which must be small compared to
//! `α`: hence [`MIN_ALPHA`].
//!
//! # Held to this by
//! The tests of `ggx` and `beckmann`, the `χ²` tests of `bsdf::tests`, and the suite's
//! `mitsuba_materials` against Mitsuba 3.

pub(crate) mod beckmann;
pub(crate) mod ggx;

use crate::math::{Real, Vec3};

/// Smallest roughness `α` for which `f32` directions determine the value.
///
/// At this roughness, the lobe is 0.06° wide and its peak at normal incidence
/// `D = 1 / (π α²) = 3.2·10⁵` sr⁻¹. Rounding the directions changes values by less than 1 % for
/// cosines above 0.1 and by less than 10 % above 0.01 (test
/// `rounding_is_harmless_down_to_min_alpha`). Smoother surfaces are a [`Mirror`](super::Mirror) or
/// [`Glass`](super::Glass), or are given this value.
pub const MIN_ALPHA: f32 = 1e-3;

/// Largest roughness along an axis. The principled material reaches `√10`.
pub const MAX_ALPHA: f32 = 4.0;

/// Distribution of the normals of facets, and relation between masking and shadowing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FacetModel {
    /// GGX; `G₂ = 1 / (1 + Λ_o + Λ_i)`, masking and shadowing correlated by height (Heitz 2014,
    /// equation 99). Used by glTF and pbrt.
    #[default]
    Ggx,
    /// GGX; `G₂ = G₁(o) G₁(i)`, masking and shadowing independent (Walter et al. 2007, equation
    /// 23). Mitsuba's `ggx`.
    GgxIndependent,
    /// Beckmann's distribution; `G₂ = G₁(o) G₁(i)`. Mitsuba's `beckmann`, its default.
    Beckmann,
}

impl FacetModel {
    /// All variants, in the order of their declaration.
    pub const ALL: [Self; 3] = [Self::Ggx, Self::GgxIndependent, Self::Beckmann];
}

/// Facets of a rough surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microfacets {
    /// Roughness `α` along the first and the second axis of the shading frame. Higher values make
    /// the lobe wider. The smaller is in [[`MIN_ALPHA`], 1]; the larger is at most [`MAX_ALPHA`],
    /// or 1 for Beckmann's facets.
    pub alpha: [f32; 2],
    /// Distribution and masking of the facets.
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

    /// Returns true if both roughnesses are equal.
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

    /// Geometric mean `ᾱ` of both roughnesses.
    #[inline(always)]
    pub fn mean(&self) -> f32 {
        let [u, v] = self.alpha;
        if u == v { u } else { (u * v).sqrt() }
    }

    /// Root mean square of both roughnesses.
    #[inline(always)]
    pub(super) fn root_mean_square(&self) -> f32 {
        let [u, v] = self.alpha;
        if u == v { u } else { (0.5 * (u * u + v * v)).sqrt() }
    }

    /// `D G₂ / (4 c_o c_i)` (sr⁻¹) for directions above the horizon.
    ///
    /// * `half`: half vector of `wo` and `wi`.
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

    /// Density `D` of normals at the half vector (sr⁻¹).
    ///
    /// * `half`: half vector of `wo` and `wi`.
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

    /// `G₂ / G₁(o)`: unshadowed share of the light that the facets visible along `wo` send along
    /// `wi`. Both directions are above the horizon; a direction of transmission is first mirrored
    /// there.
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

    /// Squared length of the tangential part of the half vector after each component is divided by
    /// its roughness, times `ᾱ²`.
    #[inline(always)]
    fn squeezed<R: Real>(&self, half: HalfVector<R>, wo: Vec3, wi: [R; 3]) -> R {
        let [u, v] = self.alpha;
        if u == v {
            return half.tangential2;
        }
        let (x, y) = (R::splat(wo.x) + wi[0], R::splat(wo.y) + wi[1]);
        R::splat(v / u) * x * x + R::splat(u / v) * y * y
    }

    /// `S`: length of a direction after the surface is stretched to a roughness of 1.
    #[inline(always)]
    fn stretch<R: Real>(&self, w: [R; 3]) -> R {
        let [u, v] = self.alpha;
        if u == v {
            return ggx::stretch(w[2], u);
        }
        let (x, y) = (R::splat(u) * w[0], R::splat(v) * w[1]);
        (x * x + y * y + w[2] * w[2]).sqrt()
    }

    /// Spread `α sin θ` of one direction or several.
    #[inline(always)]
    fn spread<R: Real>(&self, w: [R; 3]) -> R {
        let [u, v] = self.alpha;
        if u == v {
            return beckmann::spread(w[2], u);
        }
        let (x, y) = (R::splat(u) * w[0], R::splat(v) * w[1]);
        (x * x + y * y).max(R::splat(f32::MIN_POSITIVE)).sqrt()
    }

    /// Reflects `wo` (`z > 0`) at a facet drawn from those visible along it.
    ///
    /// The result may lie below the horizon; such paths end in the single-scattering model.
    pub fn sample_reflection(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        let h = self.sample_visible_normal(wo, u);
        (h * (2.0 * wo.dot(h)) - wo).normalize()
    }

    /// Draws a normal with the density `D_v` of those visible along `wo` (`z > 0`).
    ///
    /// The surface and `wo` are first stretched so that `α = 1`. The stretched facets have the same
    /// kind of distribution, and those visible along the stretched direction are the images of
    /// those visible along `wo` (Heitz and d'Eon 2014).
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

/// Half vector of two directions above the horizon, not normalised: the parts that the model needs.
#[derive(Clone, Copy, Debug)]
pub struct HalfVector<R> {
    /// Squared length of the tangential part.
    pub tangential2: R,
    /// Squared length of the part along the normal.
    pub axial2: R,
}

impl<R: Real> HalfVector<R> {
    /// Half vector `ω_o + ω_i` of unit vectors with positive `z`.
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
