//! The core material of glTF 2.0.
//!
//! ```text
//! f_r = (1 − F_d) ρ_d / π  +  F D G₂ / (4 c_o c_i)          (sr⁻¹)
//! F = F₀ + (1 − F₀)(1 − ω_i·h)⁵,    F_d the same with the dielectric's own F₀
//! ```
//!
//! (glTF 2.0 specification, appendix B, Khronos 2021: a metal and a dielectric mixed by
//! `metallic`). A loader sets `ρ_d = base · (1 − metallic)` and `α = roughness²`. It sets `F₀` to
//! the mean of the dielectric's (0.04) and `base`, weighted by `metallic`.
//!
//! # Limits
//! As the appendix states, the factor `1 − F_d` does not conserve energy. At grazing angles the
//! facets reflect all light, and the diffuse part should vanish for all `ω_i`. But the factor is
//! small only where `ω_i·h` is, near the mirror direction, so that the diffuse part stays bright
//! elsewhere. Each part alone reflects at most all light. Together, a white base under a dielectric
//! reflects at most 1.003 for `cos θ_o ≥ 0.7`, 1.03 for `cos θ_o ≥ 0.5`, 1.16 at 0.3, and nearly 2
//! at the horizon if `α` is small.
//!
//! # Difference from the appendix
//! * `G₂` is height-correlated, which the appendix's discussion prefers to its separable form.
//!
//! Tested by `bsdf::tests`.

use super::{Lobe, Model, diffuse_brdf, fresnel, lobes, microfacet, validate};
use crate::color::Rgb;
use crate::math::simd::each;
use crate::math::{Real, Vec3};
use microfacet::{HalfVector, Microfacets};

/// Diffuse and GGX reflection coupled by Schlick's `F`: the core material of glTF 2.0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetallicRoughness {
    /// Reflectance of the diffuse part, `base · (1 − metallic)`; each channel in `[0, 1]`.
    pub diffuse: Rgb,
    /// Reflectance of a facet at normal incidence; each channel in `[0, 1]`.
    pub f0: Rgb,
    /// Reflectance at normal incidence of the layer over the diffuse part; each channel in
    /// `[0, 1]`.
    pub dielectric_f0: Rgb,
    /// Facets of the specular part; glTF sets `α = roughness²`.
    pub facets: Microfacets,
}

impl Model for MetallicRoughness {
    #[inline(always)]
    fn eval<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> [R; 3] {
        let half = HalfVector::between(wo, wi);
        let facets = self.facets.reflection(half, wo, wi);
        let f = fresnel::schlick(self.f0, half.cos_incidence());
        let over_diffuse = fresnel::schlick(self.dielectric_f0, half.cos_incidence());
        let diffuse = diffuse_brdf(self.diffuse).to_array();
        each!(|channel| {
            R::splat(diffuse[channel]) * (R::splat(1.0) - over_diffuse[channel]) + f[channel] * facets
        })
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
        validate::fraction("dielectric f0", self.dielectric_f0)?;
        validate::facets(self.facets)
    }
}

impl MetallicRoughness {
    /// Albedo of the diffuse part for light at cosine `cos_o`.
    pub(super) fn diffuse_albedo(&self, cos_o: f32) -> Rgb {
        self.diffuse * (Rgb::WHITE - self.dielectric_f0) * (1.0 - fresnel::schlick_hemisphere(cos_o))
    }

    fn facet_probability(&self, cos_o: f32) -> f32 {
        lobes::facet_probability(fresnel::schlick(self.f0, cos_o), self.diffuse_albedo(cos_o))
    }
}
