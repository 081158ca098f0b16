//! Diffuse reflection and a dielectric's glossy lobe, side by side.
//!
//! ```text
//! f_r = ρ_d / π  +  k_s F(ω_i·h) D G₂ / (4 c_o c_i)          (sr⁻¹)
//! ```
//!
//! with `D` and `G₂` of [`microfacet`] and the Fresnel equations (Cook and Torrance 1982; Walter et
//! al. 2007). The two parts are independent, as in the plastics of older renderers: the diffuse
//! part is not reduced by the light that the lobe reflects. Each part alone reflects at most its
//! factor, so that with `ρ_d + k_s ≤ 1` the surface reflects no more light than arrives.
//! [`Coated`](super::Coated) is the physical form. Tested by `bsdf::tests`.

use super::{
    Lobe, Model, diffuse_brdf, fresnel, glossy_probability, lobes, microfacet, sum_of_lobes, validate,
};
use crate::color::Rgb;
use crate::math::{Real, Vec3};
use microfacet::{HalfVector, Microfacets};

/// Diffuse part plus a lobe of facets with the Fresnel reflectance of a dielectric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plastic {
    /// Diffuse reflectance `ρ_d`; each channel in `[0, 1]`.
    pub diffuse: Rgb,
    /// Factor `k_s` on the lobe; each channel in `[0, 1]`, at most 1 together with `diffuse`.
    pub specular: Rgb,
    /// Index of refraction relative to the outside, from 1.0001 to 5.
    pub ior: f32,
    /// Roughness and distribution of the lobe's facets.
    pub facets: Microfacets,
}

impl Model for Plastic {
    #[inline(always)]
    fn eval<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> [R; 3] {
        let half = HalfVector::between(wo, wi);
        let facets = self.facets.reflection(half, wo, wi);
        let glossy = facets * fresnel::dielectric(half.cos_incidence(), self.ior);
        sum_of_lobes(diffuse_brdf(self.diffuse), R::splat(1.0), self.specular, glossy)
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.lobe_probability(wo.z).map_or(0.0, |p| lobes::pdf(p, &self.facets, wo, wi))
    }

    fn draw(&self, wo: Vec3, u: [f32; 3]) -> Option<(Vec3, Lobe)> {
        Some(lobes::draw(self.lobe_probability(wo.z)?, &self.facets, wo, u))
    }

    fn vpl_reflectance(&self, _: Vec3) -> Rgb {
        self.diffuse
    }

    fn scale_diffuse(&mut self, factor: f32) {
        self.diffuse *= factor;
    }

    fn importance_gloss(&self, wo: Vec3) -> f32 {
        self.specular.max_channel() * fresnel::dielectric(wo.z.abs(), self.ior)
    }

    fn roughness(&self) -> Option<f32> {
        Some(self.facets.mean())
    }

    fn albedo(&self) -> Rgb {
        self.diffuse + self.specular * fresnel::dielectric(1.0, self.ior)
    }

    fn validate(&self) -> Result<(), String> {
        validate::fraction("diffuse", self.diffuse)?;
        validate::fraction("specular", self.specular)?;
        validate::fraction_of_sum("diffuse + specular", self.diffuse + self.specular)?;
        validate::ior(self.ior)?;
        validate::facets(self.facets)
    }
}

impl Plastic {
    /// Probability of drawing from the lobe; `None` if the surface is black.
    fn lobe_probability(&self, cos_o: f32) -> Option<f32> {
        let lobe = self.specular.max_channel() * fresnel::dielectric(cos_o, self.ior);
        glossy_probability(lobe, self.diffuse.max_channel())
    }
}
