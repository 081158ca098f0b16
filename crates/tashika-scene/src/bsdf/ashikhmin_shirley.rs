//! Rough specular reflection over a diffuse base: the model of Ashikhmin and Shirley.
//!
//! ```text
//! f_r = 28 ρ_d (1 − F₀) / 23π · s(c_i) s(c_o)  +  F D / (4 ω_i·h max(c_i, c_o))          (sr⁻¹)
//! s(c) = 1 − (1 − c/2)⁵,    F = F₀ + (1 − F₀)(1 − ω_i·h)⁵
//! ```
//!
//! (Ashikhmin, Shirley 2000, equations 4 and 5, with the distribution `D` of GGX facets as in
//! pbrt's `substrate`.) The diffuse part fades where the facets reflect. The factor `28/23π` gives
//! the diffuse part the albedo `ρ_d (1 − F₀) s(c_o)`. The model has no masking of facets; instead,
//! the denominator `max(c_i, c_o)` keeps them from reflecting more than they receive.
//!
//! Tested by `bsdf::tests`, and by the suite's `formula_materials`.

use super::{Lobe, Model, diffuse_brdf, fresnel, lobes, microfacet, validate};
use crate::color::Rgb;
use crate::math::simd::each;
use crate::math::{Real, Vec3};
use microfacet::{FacetModel, HalfVector, Microfacets};

/// Facets over a diffuse base that fades where the facets reflect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AshikhminShirley {
    /// Reflectance of the base, `ρ_d`; each channel in `[0, 1]`.
    pub diffuse: Rgb,
    /// Reflectance of a facet at normal incidence; each channel in `[0, 1]`.
    pub f0: Rgb,
    /// Facets of [`FacetModel::Ggx`]; the BSDF uses their distribution `D`, without masking.
    pub facets: Microfacets,
}

impl Model for AshikhminShirley {
    #[inline(always)]
    fn eval<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> [R; 3] {
        let half = HalfVector::between(wo, wi);
        let cos_d = half.cos_incidence();
        let facets =
            self.facets.distribution(half, wo, wi) / (R::splat(4.0) * cos_d * wi[2].max(R::splat(wo.z)));
        let f = fresnel::schlick(self.f0, cos_d);
        let shape = R::splat(Self::SCALE) * Self::shape(wi[2]);
        let diffuse = diffuse_brdf(self.diffuse_albedo(wo.z)).to_array();
        each!(|channel| R::splat(diffuse[channel]) * shape + f[channel] * facets)
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        lobes::pdf(self.facet_probability(wo.z), &self.facets, wo, wi)
    }

    fn draw(&self, wo: Vec3, u: [f32; 3]) -> Option<(Vec3, Lobe)> {
        Some(lobes::draw(self.facet_probability(wo.z), &self.facets, wo, u))
    }

    fn vpl_reflectance(&self, wo: Vec3) -> Rgb {
        self.diffuse_albedo(wo.z.abs())
    }

    fn scale_diffuse(&mut self, factor: f32) {
        self.diffuse *= factor;
    }

    fn importance_gloss(&self, wo: Vec3) -> f32 {
        Rgb::from(fresnel::schlick(self.f0, wo.z.abs())).max_channel()
    }

    fn roughness(&self) -> Option<f32> {
        Some(self.facets.mean())
    }

    fn albedo(&self) -> Rgb {
        self.diffuse_albedo(1.0) + self.f0
    }

    fn validate(&self) -> Result<(), String> {
        validate::fraction("diffuse", self.diffuse)?;
        validate::fraction("f0", self.f0)?;
        if self.facets.model != FacetModel::Ggx {
            return Err(format!("facets of {:?}; expected {:?}", self.facets.model, FacetModel::Ggx));
        }
        validate::facets(self.facets)
    }
}

impl AshikhminShirley {
    /// Normalisation `28/23` of the diffuse part, whose BRDF is `SCALE · albedo · s(c_i) / π`.
    pub const SCALE: f32 = 28.0 / 23.0;

    /// `s(c)`; increases with the cosine.
    #[inline(always)]
    pub fn shape<R: Real>(cos: R) -> R {
        // Expanded as a polynomial: for small cosines, the difference `1 − (1 − c/2)⁵` would lose
        // digits.
        let x = R::splat(0.5) * cos;
        let sum = R::splat(-10.0) + x * (R::splat(10.0) + x * (R::splat(-5.0) + x));
        x * (R::splat(5.0) + x * sum)
    }

    /// Directional albedo of the diffuse part at cosine `cos_o`: `ρ_d (1 − F₀) s(cos_o)`.
    pub fn diffuse_albedo(&self, cos_o: f32) -> Rgb {
        self.diffuse * (Rgb::WHITE - self.f0) * Self::shape(cos_o)
    }

    fn facet_probability(&self, cos_o: f32) -> f32 {
        lobes::facet_probability(fresnel::schlick(self.f0, cos_o), self.diffuse_albedo(cos_o))
    }
}
