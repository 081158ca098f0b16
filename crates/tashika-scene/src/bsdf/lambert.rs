//! Ideal diffuse reflection.
//!
//! `f_r = ρ / π` (sr⁻¹) for a reflectance `ρ` in `[0, 1]`: exactly the fraction `ρ` of the light
//! from any direction is reflected. Directions are drawn with density `cos θ / π`, so that the
//! weight is `ρ`. Tested by `bsdf::tests::energy::lambert_reflects_exactly_its_reflectance`.

use super::{Lobe, diffuse_brdf, validate};
use crate::color::Rgb;
use crate::math::{Real, Vec3};
use crate::warp;

/// Ideal diffuse reflection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// Fraction of the light that is reflected; each channel in `[0, 1]`.
    pub reflectance: Rgb,
}

impl Lambert {
    #[inline(always)]
    pub(super) fn eval<R: Real>(&self) -> [R; 3] {
        let f = diffuse_brdf(self.reflectance);
        [R::splat(f.r), R::splat(f.g), R::splat(f.b)]
    }

    #[inline]
    pub(super) fn pdf(&self, wi: Vec3) -> f32 {
        warp::cosine_hemisphere_pdf(wi.z)
    }

    pub(super) fn draw(&self, u: [f32; 3]) -> (Vec3, Lobe) {
        (warp::cosine_hemisphere([u[1], u[2]]), Lobe::Diffuse)
    }

    pub(super) fn validate(&self) -> Result<(), String> {
        validate::fraction("reflectance", self.reflectance)
    }
}
