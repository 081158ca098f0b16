//! Surfaces whose directions can only be sampled: a perfect mirror, glass, and a pane of glass.
//!
//! Except for rough glass, their BSDFs are Dirac distributions. Rough glass is treated in the same
//! way: a path continues in one drawn direction, and no light is gathered on the surface. Therefore
//! [`Bsdf::eval`](super::Bsdf::eval) and [`Bsdf::pdf`](super::Bsdf::pdf) are zero for all surfaces
//! of this module.
//!
//! Rough glass is that of Walter et al. 2007, with single scattering. A facet is drawn from the
//! visible ones. There, light is reflected with a probability equal to the Fresnel reflectance, and
//! otherwise refracted. Its weight is `G₂ / G₁(o)` ([`microfacet`](super::microfacet)). Light is
//! lost if reflection leads to the far side of the surface, or refraction to the near side.
//!
//! # Radiance across a boundary
//! Light that enters a medium of index `η` is refracted into a smaller solid angle, so that its
//! radiance is multiplied by `η²`; the flux of a light path is not. [`Glass`] omits the factor in
//! both directions. Paths from the camera then carry *basic* radiance `L / η²` (Nicodemus 1963),
//! and paths from lights carry flux. The weights of both are equal, so that one function serves
//! both.
//!
//! For a path that enters and leaves a closed object, the two factors cancel: `η² · 1 / η² = 1`.
//! Basic radiance is therefore radiance wherever camera and lights are in the outer medium. Light
//! paths inside the glass deposit flux divided by `η²`, so that camera paths find basic radiance at
//! surfaces and in media there too. If an end of a path is inside, the factor is applied there
//! (Veach 1997, section 5.2): an emitter in a medium of index `n` emits `1/n²` of its radiance, and
//! a camera in such a medium sees `n²` times the radiance that its paths carry.
//!
//! # Held to this by
//! The tests below.

use super::{BsdfSample, Lobe, MIN_COSINE, Microfacets, Model, fresnel, mirror_direction, validate};
use crate::color::Rgb;
use crate::math::{Frame, Vec3};

/// Perfect mirror; both sides reflect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// Fraction of the light that is reflected; each channel in `[0, 1]`.
    pub reflectance: Rgb,
}

impl Model for Mirror {
    const IS_SPECULAR: bool = true;

    fn sample(&self, wo: Vec3, _: [f32; 3]) -> Option<BsdfSample> {
        let (wi, weight) = (mirror_direction(wo), self.reflectance);
        Some(BsdfSample { wi, weight, pdf: 1.0, lobe: Lobe::SpecularReflection })
    }

    fn albedo(&self) -> Rgb {
        self.reflectance
    }

    fn validate(&self) -> Result<(), String> {
        validate::fraction("reflectance", self.reflectance)
    }
}

/// Boundary of a dielectric, smooth or rough: the glass is at negative `z`.
///
/// Reflects with probability `F` and weight `reflectance`, else refracts with weight
/// `transmittance`. Rough glass does so at a drawn facet. Refraction has no factor `η²` in either
/// direction; the documentation of this file gives the reason.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glass {
    /// Index of refraction of the inside (`z < 0`) relative to the outside, from 1.0001 to 5.
    pub ior: f32,
    /// Factor on the reflection, each channel in `[0, 1]`; 1 is physical.
    pub reflectance: Rgb,
    /// Factor on the refraction, each channel in `[0, 1]`; 1 is clear glass.
    pub transmittance: Rgb,
    /// Facets of rough glass; `None` if it is smooth.
    pub facets: Option<Microfacets>,
}

impl Model for Glass {
    const IS_SPECULAR: bool = true;

    /// Reflects if `u[0]` in `[0, 1)` is below `F`, else refracts; `u[1]` and `u[2]` draw the
    /// facet. `None` if reflection leads to the far side of the surface, or refraction to the near
    /// side. This never happens at smooth glass.
    fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        let Some(facets) = self.facets else { return Some(self.sample_smooth(wo, u[0])) };
        // The normal is drawn for `wo` mirrored to above the surface, and mirrored back.
        let side = 1.0_f32.copysign(wo.z);
        let up = Vec3::new(wo.x, wo.y, wo.z * side);
        let normal = facets.sample_visible_normal(up, [u[1], u[2]]);
        let frame = Frame::about(Vec3::new(normal.x, normal.y, normal.z * side));
        let at_facet = frame.to_local(wo);
        if at_facet.z <= MIN_COSINE {
            return None;
        }
        // In the facet's frame `wo` has a positive `z`. The sign is restored, so that the glass is
        // again at negative `z`.
        let turned = Vec3::new(at_facet.x, at_facet.y, at_facet.z * side);
        let BsdfSample { wi, weight, pdf, lobe } = self.sample_smooth(turned, u[0]);
        let wi = frame.to_world(Vec3::new(wi.x, wi.y, wi.z * side)).normalize();
        let stays = wi.z * side > MIN_COSINE;
        let crosses = wi.z * side < -MIN_COSINE;
        let arrives = if lobe == Lobe::SpecularReflection { stays } else { crosses };
        let leaving = Vec3::new(wi.x, wi.y, wi.z.abs());
        let weight = weight * facets.unshadowed(up, leaving);
        arrives.then_some(BsdfSample { wi, weight, pdf, lobe })
    }

    fn albedo(&self) -> Rgb {
        self.transmittance.lerp(self.reflectance, fresnel::dielectric(1.0, self.ior))
    }

    fn validate(&self) -> Result<(), String> {
        validate::ior(self.ior)?;
        validate::fraction("reflectance", self.reflectance)?;
        validate::fraction("transmittance", self.transmittance)?;
        self.facets.map_or(Ok(()), validate::facets)
    }
}

impl Glass {
    /// Returns `(n/n')²` for light that crosses the boundary from index `n` to index `n'`: `η²` out
    /// of the glass, `1/η²` into it.
    pub fn squared_ratio(&self, leaves_glass: bool) -> f64 {
        let squared = f64::from(self.ior) * f64::from(self.ior);
        if leaves_glass { squared } else { squared.recip() }
    }

    fn sample_smooth(&self, wo: Vec3, u: f32) -> BsdfSample {
        let eta = if wo.z > 0.0 { self.ior } else { self.ior.recip() };
        let reflected = fresnel::dielectric(wo.z.abs().min(1.0), eta);
        if u < reflected {
            let lobe = Lobe::SpecularReflection;
            return BsdfSample { wi: mirror_direction(wo), weight: self.reflectance, pdf: reflected, lobe };
        }
        BsdfSample {
            wi: refract(wo, eta),
            weight: self.transmittance,
            pdf: 1.0 - reflected,
            lobe: Lobe::SpecularTransmission,
        }
    }
}

/// A pane of glass so thin that light leaves where it entered: one surface represents both faces.
///
/// Let `F` be the reflectance of one face. With all reflections between the two faces, the pane
/// reflects `R = F + (1 − F)² F / (1 − F²) = 2F / (1 + F)` and transmits `1 − R` straight (Stokes
/// 1862).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinGlass {
    /// Index of refraction relative to the outside, from 1.0001 to 5.
    pub ior: f32,
    /// Factor on the reflection, each channel in `[0, 1]`; 1 is physical.
    pub reflectance: Rgb,
    /// Factor on the transmission, each channel in `[0, 1]`; 1 is clear glass.
    pub transmittance: Rgb,
}

impl Model for ThinGlass {
    const IS_SPECULAR: bool = true;

    /// Passes straight through if `u[0]` is below `1 − R`, else reflects.
    fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        let passed = Self::passed(wo.z.abs(), self.ior);
        Some(if u[0] < passed {
            let lobe = Lobe::SpecularTransmission;
            BsdfSample { wi: -wo, weight: self.transmittance, pdf: passed, lobe }
        } else {
            let (wi, lobe) = (mirror_direction(wo), Lobe::SpecularReflection);
            BsdfSample { wi, weight: self.reflectance, pdf: 1.0 - passed, lobe }
        })
    }

    fn albedo(&self) -> Rgb {
        self.reflectance.lerp(self.transmittance, Self::passed(1.0, self.ior))
    }

    fn validate(&self) -> Result<(), String> {
        validate::ior(self.ior)?;
        validate::fraction("reflectance", self.reflectance)?;
        validate::fraction("transmittance", self.transmittance)
    }
}

impl ThinGlass {
    /// A pane without effect: all light passes straight through.
    pub const NOTHING: Self = Self { ior: 1.0, reflectance: Rgb::BLACK, transmittance: Rgb::WHITE };

    /// Fraction `1 − R` of light that passes a clear pane of index `ior` at an angle of incidence
    /// of cosine `cos`.
    pub(crate) fn passed(cos: f32, ior: f32) -> f32 {
        if ior == 1.0 {
            return 1.0;
        }
        let face = fresnel::dielectric(cos.min(1.0), ior);
        (1.0 - face) / (1.0 + face)
    }
}

/// Direction on the other side of a boundary of relative index `eta`, by Snell's law.
///
/// Must not be called beyond the critical angle.
fn refract(w: Vec3, eta: f32) -> Vec3 {
    let tangential = Vec3::new(-w.x, -w.y, 0.0) / eta;
    let cos = (1.0 - tangential.length_squared()).max(0.0).sqrt();
    Vec3::new(tangential.x, tangential.y, -cos.copysign(w.z)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::elementary::{acos, sin_cos};

    fn glass() -> Glass {
        Glass { ior: 1.5, reflectance: Rgb::gray(0.9), transmittance: Rgb::new(0.2, 0.4, 0.6), facets: None }
    }

    fn direction(angle: f32, side: f32) -> Vec3 {
        let (sin, cos) = sin_cos(angle);
        Vec3::new(sin * 0.6, sin * 0.8, cos * side)
    }

    /// Largest number below 1, which is the largest value that a stream can return.
    const LAST: f32 = 1.0 - f32::EPSILON / 2.0;

    #[test]
    fn the_two_ways_have_all_the_probability() {
        for (side, steps) in [(1.0, 15), (-1.0, 7)] {
            for step in 0..steps {
                let wo = direction(step as f32 * 0.1, side);
                let (reflected, refracted) =
                    (glass().sample_smooth(wo, 0.0), glass().sample_smooth(wo, LAST));
                assert_eq!(reflected.lobe, Lobe::SpecularReflection);
                assert_eq!(refracted.lobe, Lobe::SpecularTransmission);
                assert!((reflected.pdf + refracted.pdf - 1.0).abs() < 1e-6);
                assert_eq!(
                    (reflected.weight, refracted.weight),
                    (glass().reflectance, glass().transmittance)
                );
                assert_eq!(reflected.wi, Vec3::new(-wo.x, -wo.y, wo.z));
            }
        }
    }

    #[test]
    fn refraction_obeys_snell_in_the_plane_of_incidence() {
        for (side, eta, steps) in [(1.0, 1.5, 15), (-1.0, 1.0 / 1.5, 7)] {
            for step in 1..steps {
                let wo = direction(step as f32 * 0.1, side);
                let wi = glass().sample_smooth(wo, LAST).wi;
                assert!(wi.z * wo.z < 0.0 && (wi.length() - 1.0).abs() < 1e-6);
                let (sin_o, sin_i) = (wo.truncate().length(), wi.truncate().length());
                assert!((sin_o - eta * sin_i).abs() < 1e-6, "{sin_o} against {eta} · {sin_i}");
                assert!((wi.truncate() * sin_o + wo.truncate() * sin_i).length() < 1e-6, "turned aside");
            }
        }
    }

    /// A path that is refracted into the glass and sent back along the refracted direction leaves
    /// along the original direction, with the same probability.
    #[test]
    fn refraction_can_be_reversed() {
        for step in 0..15 {
            let wo = direction(step as f32 * 0.1, 1.0);
            let inward = glass().sample_smooth(wo, LAST);
            let outward = glass().sample_smooth(inward.wi, LAST);
            assert!((outward.wi - wo).length() < 2e-6, "{} against {wo}", outward.wi);
            assert!((outward.pdf - inward.pdf).abs() < 1e-5);
        }
    }

    #[test]
    fn inside_beyond_the_critical_angle_everything_is_reflected() {
        let critical = acos((1.0_f32 - 1.0 / 2.25).sqrt());
        let beyond = glass().sample_smooth(direction(critical + 1e-3, -1.0), LAST);
        assert_eq!((beyond.lobe, beyond.pdf), (Lobe::SpecularReflection, 1.0));
        assert!(beyond.wi.z < 0.0);
        let within = glass().sample_smooth(direction(critical - 1e-3, -1.0), LAST);
        assert_eq!(within.lobe, Lobe::SpecularTransmission);
    }

    /// The reflectance of a pane equals the sum, term by term, of all reflections between two
    /// faces.
    #[test]
    fn a_pane_sums_all_reflections_inside() {
        for step in 0..15 {
            let wo = direction(step as f32 * 0.1, if step % 2 == 0 { 1.0 } else { -1.0 });
            let face = f64::from(fresnel::dielectric(wo.z.abs(), 1.5));
            let reflected: f64 =
                face + (0..200).map(|k| (1.0 - face).powi(2) * face.powi(2 * k + 1)).sum::<f64>();
            let pane = ThinGlass { ior: 1.5, reflectance: Rgb::gray(0.9), transmittance: Rgb::gray(0.7) };
            let sample = |u| pane.sample(wo, [u, 0.0, 0.0]).unwrap();
            let (passes, reflects) = (sample(0.0), sample(LAST));
            assert!((f64::from(passes.pdf) - (1.0 - reflected)).abs() < 1e-5, "{step}");
            assert!((passes.pdf + reflects.pdf - 1.0).abs() < 1e-6);
            assert_eq!((passes.wi, reflects.wi), (-wo, Vec3::new(-wo.x, -wo.y, wo.z)));
            assert_eq!((passes.weight, reflects.weight), (Rgb::gray(0.7), Rgb::gray(0.9)));
        }
    }

    #[test]
    fn a_mirror_reflects_on_both_sides() {
        let mirror = Mirror { reflectance: Rgb::gray(0.8) };
        for side in [1.0, -1.0] {
            let wo = direction(0.5, side);
            let sample = mirror.sample(wo, [0.0; 3]).unwrap();
            assert_eq!(sample.wi, Vec3::new(-wo.x, -wo.y, wo.z));
            assert_eq!((sample.weight, sample.pdf), (Rgb::gray(0.8), 1.0));
        }
    }
}
