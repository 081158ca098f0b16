//! Ideal diffuse reflection.
//!
//! `f_r = ρ / π` (sr⁻¹) for a reflectance `ρ` in `[0, 1]`: exactly the fraction `ρ` of the light
//! from any direction is reflected. Directions are drawn with density `cos θ / π`, so that the
//! weight is `ρ`. Tested by `bsdf::tests::energy::lambert_reflects_exactly_its_reflectance`.

use super::{Lobe, Model, diffuse_brdf, validate};
use crate::color::Rgb;
use crate::math::{Real, Vec3};
use crate::warp;

/// Ideal diffuse reflection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// Fraction of the light that is reflected; each channel in `[0, 1]`.
    pub reflectance: Rgb,
}

impl Model for Lambert {
    #[inline(always)]
    fn eval<R: Real>(&self, _: Vec3, _: [R; 3]) -> [R; 3] {
        let f = diffuse_brdf(self.reflectance);
        [R::splat(f.r), R::splat(f.g), R::splat(f.b)]
    }

    #[inline]
    fn pdf(&self, _: Vec3, wi: Vec3) -> f32 {
        warp::cosine_hemisphere_pdf(wi.z)
    }

    fn draw(&self, _: Vec3, u: [f32; 3]) -> Option<(Vec3, Lobe)> {
        Some((warp::cosine_hemisphere([u[1], u[2]]), Lobe::Diffuse))
    }

    fn vpl_reflectance(&self, _: Vec3) -> Rgb {
        self.reflectance
    }

    fn scale_diffuse(&mut self, factor: f32) {
        self.reflectance *= factor;
    }

    fn importance_gloss(&self, _: Vec3) -> f32 {
        0.0
    }

    fn albedo(&self) -> Rgb {
        self.reflectance
    }

    fn validate(&self) -> Result<(), String> {
        validate::fraction("reflectance", self.reflectance)
    }
}
