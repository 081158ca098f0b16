//! Rough metal, and the transmission of a rough pane ([`ConductorFresnel::Passed`]). Directions of
//! both are drawn in the same way, and the values have the same bounds.
//!
//! ```text
//! f_r = s F(ω_i·h) D(h) G₂(ω_o, ω_i) / (4 c_o c_i)          (sr⁻¹)
//! ```
//!
//! (Cook and Torrance 1982; Walter et al. 2007, equation 20) with `D` and `G₂` of [`microfacet`]
//! and `F` either from the complex index of refraction or, by Schlick's approximation, from `F₀`.
//! Light that meets a second facet is lost (single scattering), so that rough metals reflect less
//! than `F`. For example, GGX facets with `F = 1` and `α = 1` reflect only `1 − ln 2 = 0.31` at
//! normal incidence. Directions are drawn by visible normals, so that the weight is
//! `s F G₂ / G₁ ≤ 1`. Tested by `bsdf::tests`.

use super::{Lobe, Model, fresnel, microfacet, validate};
use crate::color::Rgb;
use crate::math::simd::each;
use crate::math::{Real, Vec3};
use microfacet::{HalfVector, Microfacets};

/// Largest component of a complex index of refraction; metals reach about 10 in visible light.
const MAX_INDEX: f32 = 100.0;

/// Smallest real part of the index of refraction. Silver has 0.05.
const MIN_ETA: f32 = 1e-3;

/// Rough metal, or the transmission of a rough pane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    /// Fresnel reflectance of a facet.
    pub fresnel: ConductorFresnel,
    /// Factor `s` on the Fresnel reflectance, each channel in `[0, 1]`; 1 is physical.
    pub specular: Rgb,
    /// Roughness and distribution of the facets.
    pub facets: Microfacets,
}

/// Fresnel reflectance of the facets of a metal, or transmittance of those of a pane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ConductorFresnel {
    /// Schlick's approximation.
    Schlick {
        /// Reflectance at normal incidence; each channel in `[0, 1]`.
        f0: Rgb,
    },
    /// The Fresnel equations for the complex index `η + i k`, relative to the medium outside.
    Exact {
        /// Real part `η`, from 0.001 to 100.
        eta: Rgb,
        /// Imaginary part `k`, from 0 to 100.
        k: Rgb,
    },
    /// Transmission instead of metal: the light that a dielectric does not reflect by Schlick's
    /// approximation, `(1 − F₀)(1 − (1 − ω_i·h)⁵)`. Behind a rough pane, this light leaves in the
    /// directions of the mirror lobe, mirrored to the far side.
    Passed {
        /// Reflectance at normal incidence; each channel in `[0, 1]`.
        f0: Rgb,
    },
}

impl ConductorFresnel {
    /// Reflectance at an angle of incidence of cosine `cos` in `[0, 1]`.
    #[inline]
    pub fn at(&self, cos: f32) -> Rgb {
        Rgb::from(self.of(cos))
    }

    /// Reflectance for one or several cosines.
    #[inline(always)]
    pub(super) fn of<R: Real>(&self, cos: R) -> [R; 3] {
        match *self {
            Self::Schlick { f0 } => fresnel::schlick(f0, cos),
            Self::Exact { eta, k } => fresnel::conductor(cos, eta, k),
            Self::Passed { f0 } => {
                let reflected = fresnel::schlick(f0, cos);
                each!(|channel| R::splat(1.0) - reflected[channel])
            }
        }
    }
}

impl Model for Conductor {
    #[inline(always)]
    fn eval<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> [R; 3] {
        let half = HalfVector::between(wo, wi);
        let facets = self.facets.reflection(half, wo, wi);
        let (f, specular) = (self.fresnel.of(half.cos_incidence()), self.specular.to_array());
        each!(|channel| f[channel] * R::splat(specular[channel]) * facets)
    }

    #[inline]
    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        self.facets.reflection_pdf(HalfVector::between(wo, wi.to_array()), wo, wi)
    }

    fn draw(&self, wo: Vec3, u: [f32; 3]) -> Option<(Vec3, Lobe)> {
        Some((self.facets.sample_reflection(wo, [u[1], u[2]]), Lobe::Glossy))
    }

    fn roughness(&self) -> Option<f32> {
        Some(self.facets.mean())
    }

    fn albedo(&self) -> Rgb {
        self.fresnel.at(1.0) * self.specular
    }

    fn validate(&self) -> Result<(), String> {
        match self.fresnel {
            ConductorFresnel::Schlick { f0 } | ConductorFresnel::Passed { f0 } => {
                validate::fraction("f0", f0)?
            }
            ConductorFresnel::Exact { eta, k } => {
                validate::channels_in_range("eta", eta, MIN_ETA, MAX_INDEX)?;
                validate::channels_in_range("k", k, 0.0, MAX_INDEX)?;
            }
        }
        validate::fraction("specular", self.specular)?;
        validate::facets(self.facets)
    }
}
