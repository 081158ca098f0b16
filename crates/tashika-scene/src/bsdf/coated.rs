//! A rough dielectric coat over a diffuse base.
//!
//! ```text
//! f_r = s F(ω_i·h) D G₂ / (4 c_o c_i)  +  ρ/π · T(c_o) T(c_i) / (η² (1 − ρ F_int))          (sr⁻¹)
//! ```
//!
//! The first term is reflection at the coat (microfacets, Fresnel equations). The second is light
//! that enters through the coat, is scattered by the base, and leaves, after any number of
//! reflections at the coat's inside (Saunderson 1942, "Calculation of the color of pigmented
//! plastics"). `T` is the transmittance of the rough boundary for light that enters or leaves
//! ([`boundary`](super::boundary)). `F_int` is the reflectance of the boundary for diffuse light
//! from inside. The factor `1 / η²` is due to the refraction of the light that leaves, which
//! spreads it over a larger solid angle.
//!
//! For a smooth coat, `1 − F_int = (1 − F_ext) / η²`. The albedo of the second term for a white
//! base is then exactly `T(c_o)`, so that coat and base together reflect all light. Rough coats
//! lose the light that is scattered more than once among the facets.
//!
//! Tested by `bsdf::tests::energy` and by
//! `bsdf::tests::energy::vpl_reflectance_is_the_albedo_of_the_diffuse_part`.

use super::boundary::Boundary;
use super::{
    Lobe, Model, diffuse_brdf, fresnel, glossy_probability, lobes, microfacet, sum_of_lobes, validate,
};
use crate::color::Rgb;
use crate::math::{Real, Vec3};
use microfacet::{HalfVector, Microfacets};

/// A rough dielectric coat over a diffuse base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coated {
    /// Reflectance of the base, without the coat; each channel in `[0, 1]`.
    pub reflectance: Rgb,
    /// Factor on the reflection of the coat, each channel in `[0, 1]`; 1 is physical.
    pub specular: Rgb,
    /// Index of refraction of the coat relative to the outside, from 1.0001 to 5.
    pub ior: f32,
    /// Roughness and distribution of the coat's facets.
    pub facets: Microfacets,
}

impl Model for Coated {
    #[inline(always)]
    fn eval<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> [R; 3] {
        let half = HalfVector::between(wo, wi);
        let coat = self.facets.reflection(half, wo, wi) * fresnel::dielectric(half.cos_incidence(), self.ior);
        let boundary = self.boundary();
        let passed = R::splat(boundary.transmittance(wo.z)) * boundary.transmittance(wi[2]);
        sum_of_lobes(diffuse_brdf(self.base(&boundary)), passed, self.specular, coat)
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.coat_probability(wo.z).map_or(0.0, |p| lobes::pdf(p, &self.facets, wo, wi))
    }

    fn draw(&self, wo: Vec3, u: [f32; 3]) -> Option<(Vec3, Lobe)> {
        Some(lobes::draw(self.coat_probability(wo.z)?, &self.facets, wo, u))
    }

    fn vpl_reflectance(&self, wo: Vec3) -> Rgb {
        self.diffuse_albedo(wo.z.abs())
    }

    fn scale_diffuse(&mut self, factor: f32) {
        self.reflectance *= factor;
    }

    fn importance_gloss(&self, wo: Vec3) -> f32 {
        self.specular.max_channel() * fresnel::dielectric(wo.z.abs(), self.ior)
    }

    fn roughness(&self) -> Option<f32> {
        (!self.specular.is_black()).then_some(self.facets.mean())
    }

    fn albedo(&self) -> Rgb {
        self.diffuse_albedo(1.0) + self.specular * fresnel::dielectric(1.0, self.ior)
    }

    fn validate(&self) -> Result<(), String> {
        validate::fraction("reflectance", self.reflectance)?;
        validate::fraction("specular", self.specular)?;
        validate::ior(self.ior)?;
        validate::facets(self.facets)
    }
}

impl Coated {
    /// Returns the reflectance `ρ'` of a base with `ρ'/(1 − ρ' F_int) = ρ/(1 − F_int)`, where `ρ`
    /// is `reflectance`.
    pub(crate) fn saturating(reflectance: Rgb, ior: f32, facets: Microfacets) -> Rgb {
        let inside = Boundary::new(facets, ior).inside();
        reflectance.map(|r| r / (1.0 - inside + r * inside))
    }

    /// Returns the reflectance `ρ'` of a base with `ρ'/(1 − ρ' F_int) = ρ`, where `ρ` is
    /// `reflectance`: light that the inside of the coat reflects is lost.
    pub(crate) fn lossy(reflectance: Rgb, ior: f32, facets: Microfacets) -> Rgb {
        let inside = Boundary::new(facets, ior).inside();
        reflectance.map(|r| r / (1.0 + r * inside))
    }

    /// Boundary of the coat, rough or smooth.
    #[inline]
    pub fn boundary(&self) -> Boundary {
        Boundary::new(self.facets, self.ior)
    }

    /// Albedo of the diffuse part for light at cosine `cos_o`.
    pub(crate) fn diffuse_albedo(&self, cos_o: f32) -> Rgb {
        let boundary = self.boundary();
        self.base(&boundary) * (boundary.transmittance(cos_o) * boundary.mean_transmittance())
    }

    /// Diffuse part divided by `T(c_o) T(c_i)/π`: `ρ / (η² (1 − ρ F_int))`.
    #[inline]
    pub fn base(&self, boundary: &Boundary) -> Rgb {
        let (eta2, inside) = (self.ior * self.ior, boundary.inside());
        self.reflectance.map(|r| r / (eta2 * (1.0 - r * inside)))
    }

    /// Probability of drawing from the coat's lobe; `None` if the surface is black.
    fn coat_probability(&self, cos_o: f32) -> Option<f32> {
        let coat = self.specular.max_channel() * fresnel::dielectric(cos_o, self.ior);
        glossy_probability(coat, self.diffuse_albedo(cos_o).max_channel())
    }
}
