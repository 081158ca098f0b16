//! Scattering of light at surfaces: a closed family of BSDFs in the local shading frame.
//!
//! The renderer needs the material term `M = f_r(ω_o, ω_i) cos⁺θ_i` (sr⁻¹) of a pair of directions,
//! and paths need a direction `ω_i` drawn with a known density (sr⁻¹). With `c = cos θ`, `h` the
//! half vector, and `D` and `G₂` the distribution and the masking of [`Microfacets`]:
//!
//! | variant | `f_r` (sr⁻¹) |
//! |---|---|
//! | [`Lambert`] | `ρ / π` |
//! | [`Phong`] | `ρ_d / π + ρ_s (n + 2) / 2π · cosⁿ∠(mirror, ω_i)` |
//! | [`Plastic`] | `ρ_d / π + k_s F(ω_i·h) D G₂ / 4 c_i c_o` |
//! | [`Conductor`] | `k_s F(ω_i·h) D G₂ / 4 c_i c_o` |
//! | [`Coated`] | as [`Conductor`], dielectric `F`, over `ρ/π · T(c_i) T(c_o) / η²(1 − ρ F_int)` |
//! | [`MetallicRoughness`] | `(1 − F) ρ_d / π + F D G₂ / 4 c_i c_o` |
//! | [`AshikhminShirley`] | `28 ρ_d (1 − F₀)/23π · s(c_i) s(c_o) + F D / 4 ω_i·h max(c_i, c_o)` |
//! | [`Principled`] | `ρ_d/π · b + s (1 − ω_i·h)⁵ + F D G₂ / 4 c_i c_o` |
//! | [`Layered`] | one of these under [`Sheen`] and a [`Clearcoat`], each over the rest |
//! | [`Mirror`] | `ρ δ(mirror − ω_i) / c_i` |
//! | [`Glass`] | `F` on reflection, `1 − F` on refraction, at facets if it is rough |
//! | [`ThinGlass`] | `2F / (1 + F)` on reflection, the rest straight through |
//!
//! Directions are drawn with density `cos θ / π` ([`Lambert`]) or by visible normals
//! ([`Conductor`]). [`Mirror`] has a single direction. [`Glass`] and [`ThinGlass`] choose between
//! reflection and transmission with the probabilities of the table. All other variants draw from a
//! mixture of their lobes.
//!
//! Sources: Lambert 1760; Lafortune, Willems 1994 (Phong); Cook, Torrance 1982 (plastic); Walter et
//! al. 2007 (conductor, glass); Heitz 2014 (conductor); Saunderson 1942 (coated); glTF 2.0,
//! appendix B (metallic-roughness); Ashikhmin, Shirley 2000; Burley 2012 (principled, layers); glTF
//! (layers); Stokes 1862 (thin glass).
//!
//! # Conventions
//! * All directions are unit vectors that point *away* from the surface; the shading normal is
//!   `+z`.
//! * Opaque surfaces are two-sided: if `ω_o` is below the surface, both directions are mirrored to
//!   `+z` first. Light passes from one side to the other only in [`Glass`] and [`ThinGlass`].
//! * A direction within [`MIN_COSINE`] of the horizon neither receives nor sends light.
//! * Every opaque BSDF is reciprocal, `f_r(a, b) = f_r(b, a)`, except [`Layered`] ones: their
//!   layers reduce the light of the base by the share that they reflect to `ω_o`, the direction of
//!   the viewer. For refraction, see [`Glass`].
//!
//! # Guarantee
//! For parameters that [`Bsdf::validate`] accepts and unit directions, all results are finite and
//! not negative. [`Bsdf::sample`] draws exactly from [`Bsdf::pdf`]. No surface reflects more than
//! it receives, with these exceptions: [`Coated`] by a thousandth, [`MetallicRoughness`] at grazing
//! angles, [`Principled`], and [`Layered`] over these, with Disney's coats, or with sheen.
//!
//! # Held to this by
//! `bsdf::tests`: every property is tested for every case of a fixed list and of a random sweep.

use crate::color::Rgb;
use crate::math::simd::each;
use crate::math::{Real, Vec3};

mod ashikhmin_shirley;
pub mod boundary;
mod clearcoat;
mod coated;
mod conductor;
pub mod fresnel;
mod lambert;
mod layered;
mod lobes;
mod metallic_roughness;
pub mod microfacet;
mod phase;
mod phong;
mod plastic;
mod principled;
mod sample;
mod sheen;
mod specular;
#[cfg(test)]
mod tests;
mod validate;

pub use ashikhmin_shirley::AshikhminShirley;
pub use clearcoat::{Clearcoat, CoatModel, MASKING_ALPHA, MAX_GTR1_ALPHA, reflectance as coat_reflectance};
pub use coated::Coated;
pub use conductor::{Conductor, ConductorFresnel};
pub use lambert::Lambert;
pub use layered::{Layered, UnderLayers};
pub use lobes::glossy_probability;
use lobes::{diffuse_brdf, sum_of_lobes};
pub use metallic_roughness::MetallicRoughness;
pub use microfacet::{FacetModel, MAX_ALPHA, MIN_ALPHA, Microfacets};
pub use phase::HenyeyGreenstein;
pub use phong::Phong;
pub use plastic::Plastic;
pub use principled::{MAX_SHEEN, Principled, TintedFresnel};
pub use sample::{BsdfSample, Lobe};
pub use sheen::{MIN_SHEEN_ROUGHNESS, Sheen, UPPER_SHEEN_VISIBILITY};
pub use specular::{Glass, Mirror, ThinGlass};

/// Largest cosine with the normal of directions that count as lying in the surface.
///
/// Components of a unit vector in `f32` are rounded by up to `6·10⁻⁸`, so the sign of a cosine
/// below that is meaningless.
pub const MIN_COSINE: f32 = 1e-7;

/// Scattering of light at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bsdf {
    /// Ideal diffuse reflection.
    Lambert(Lambert),
    /// Diffuse reflection and a lobe around the mirror direction.
    Phong(Phong),
    /// Diffuse reflection and a lobe with the Fresnel reflectance of a dielectric.
    Plastic(Plastic),
    /// Rough metal, or the transmission of a rough pane.
    Conductor(Conductor),
    /// Rough dielectric coat on a diffuse base.
    Coated(Coated),
    /// The core material of glTF 2.0.
    MetallicRoughness(MetallicRoughness),
    /// Facets over a diffuse base, which fades where the facets reflect.
    AshikhminShirley(AshikhminShirley),
    /// The principled material of Disney.
    Principled(Principled),
    /// Sheen and a clear coat over an opaque surface.
    Layered(Layered),
    /// Ideal specular reflection.
    Mirror(Mirror),
    /// Smooth or rough dielectric.
    Glass(Glass),
    /// Pane of glass.
    ThinGlass(ThinGlass),
}

impl Bsdf {
    /// `f_r(ω_o, ω_i)` (sr⁻¹), without the cosine.
    ///
    /// Zero for specular lobes and for directions on different sides.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> Rgb {
        match above_horizon(wo, wi) {
            Some((wo, wi)) => Rgb::from(self.eval_above(wo, wi.to_array())),
            None => Rgb::BLACK,
        }
    }

    /// The material term `M = f_r(ω_o, ω_i) cos⁺θ_i` (sr⁻¹).
    #[inline]
    pub fn eval_cos(&self, wo: Vec3, wi: Vec3) -> Rgb {
        match above_horizon(wo, wi) {
            Some((wo, wi)) => Rgb::from(self.eval_above(wo, wi.to_array())) * wi.z,
            None => Rgb::BLACK,
        }
    }

    /// [`Bsdf::eval_cos`] for one or several directions `wi`, with the same bits.
    #[inline(always)]
    pub fn eval_cos_of<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> [R; 3] {
        let zero = R::splat(0.0);
        let side = 1.0_f32.copysign(wo.z);
        let cos_o = wo.z * side;
        if cos_o.is_nan() || cos_o <= MIN_COSINE {
            return [zero; 3];
        }
        let cos_i = wi[2] * R::splat(side);
        let above = cos_i.gt(R::splat(MIN_COSINE));
        // Directions below the horizon are moved to just above it, so that their values are finite.
        // Their values are then replaced by zero.
        let wi = [wi[0], wi[1], cos_i.max(R::splat(MIN_COSINE))];
        let f = self.eval_above(Vec3::new(wo.x, wo.y, cos_o), wi);
        each!(|channel| R::select(above, f[channel] * wi[2], zero))
    }

    /// Density with which [`Bsdf::sample`] draws `wi` (sr⁻¹); zero for specular lobes.
    ///
    /// The density integrates to 1 minus the probability that a draw ends below the horizon.
    #[inline]
    pub fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        match above_horizon(wo, wi) {
            Some((wo, wi)) => self.pdf_above(wo, wi),
            None => 0.0,
        }
    }

    /// Draws `ω_i` for a path that arrives along `−ω_o`.
    ///
    /// * `u`: uniform in `[0, 1)³`; `u[0]` chooses the lobe, the others the direction.
    ///
    /// `None` if the path ends: the direction drawn is below the horizon, or its weight is zero.
    pub fn sample(&self, wo: Vec3, u: [f32; 3]) -> Option<BsdfSample> {
        let side = 1.0_f32.copysign(wo.z);
        let up = Vec3::new(wo.x, wo.y, wo.z * side);
        if up.z.is_nan() || up.z <= MIN_COSINE {
            return None;
        }
        let (wi, lobe) = match self {
            Self::Lambert(b) => b.draw(u),
            Self::Phong(b) => b.draw(up, u)?,
            Self::Plastic(b) => b.draw(up, u)?,
            Self::Conductor(b) => b.draw(up, u),
            Self::Coated(b) => b.draw(up, u)?,
            Self::MetallicRoughness(b) => b.draw(up, u),
            Self::AshikhminShirley(b) => b.draw(up, u),
            Self::Principled(b) => b.draw(up, u),
            Self::Layered(b) => b.draw(up, u),
            Self::Mirror(b) => return Some(b.sample(wo)).filter(carries_light),
            Self::Glass(b) => return b.sample(wo, u).filter(carries_light),
            Self::ThinGlass(b) => return Some(b.sample(wo, u[0])).filter(carries_light),
        };
        if wi.z <= MIN_COSINE {
            return None;
        }
        let pdf = self.pdf_above(up, wi);
        if pdf <= 0.0 {
            return None;
        }
        let weight = Rgb::from(self.eval_above(up, wi.to_array())) * (wi.z / pdf);
        let wi = Vec3::new(wi.x, wi.y, wi.z * side);
        Some(BsdfSample { wi, weight, pdf, lobe }).filter(carries_light)
    }

    /// Returns true if the BSDF has specular lobes only; rough glass counts as specular.
    pub fn is_specular(&self) -> bool {
        match self {
            Self::Lambert(_)
            | Self::Phong(_)
            | Self::Plastic(_)
            | Self::Conductor(_)
            | Self::Coated(_)
            | Self::MetallicRoughness(_)
            | Self::AshikhminShirley(_)
            | Self::Principled(_)
            | Self::Layered(_) => false,
            Self::Mirror(_) | Self::Glass(_) | Self::ThinGlass(_) => true,
        }
    }

    /// `ρ(ω_o) = ∫ f_d cos θ_i dω_i`, the directional albedo (unitless) of the diffuse part `f_d`.
    ///
    /// Light of flux `Φ` that arrives from `wo` is represented by a virtual point light whose
    /// intensity along the normal is `Φ ρ / π`. Zero for surfaces without a diffuse part.
    pub fn vpl_reflectance(&self, wo: Vec3) -> Rgb {
        match self {
            Self::Lambert(b) => b.reflectance,
            Self::Phong(b) => b.diffuse,
            Self::Plastic(b) => b.diffuse,
            Self::Coated(b) => b.diffuse_albedo(wo.z.abs()),
            Self::MetallicRoughness(b) => b.diffuse_albedo(wo.z.abs()),
            Self::AshikhminShirley(b) => b.diffuse_albedo(wo.z.abs()),
            Self::Principled(b) => b.diffuse_albedo(wo.z.abs()),
            Self::Layered(b) => b.diffuse_albedo(wo),
            Self::Conductor(_) | Self::Mirror(_) | Self::Glass(_) | Self::ThinGlass(_) => Rgb::BLACK,
        }
    }

    /// Returns the BSDF with its diffuse part times `10⁻³`, for drawing directions of the glossy
    /// lobes. It can draw every direction that the original BSDF can.
    pub fn mostly_gloss(&self) -> Self {
        const LEFT: f32 = 1e-3;
        let mut gloss = *self;
        match &mut gloss {
            Self::Phong(b) => b.diffuse *= LEFT,
            Self::Plastic(b) => b.diffuse *= LEFT,
            Self::Coated(b) => b.reflectance *= LEFT,
            Self::MetallicRoughness(b) => b.diffuse *= LEFT,
            Self::AshikhminShirley(b) => b.diffuse *= LEFT,
            Self::Principled(b) => b.diffuse *= LEFT,
            Self::Layered(b) => b.base = b.base.with_diffuse(LEFT),
            Self::Lambert(_) | Self::Conductor(_) | Self::Mirror(_) | Self::Glass(_) | Self::ThinGlass(_) => {
            }
        }
        gloss
    }

    /// Estimate of the share of uniform illumination that the glossy lobes reflect along `ω_o`.
    pub fn importance_gloss(&self, wo: Vec3) -> f32 {
        let cos = wo.z.abs();
        match self {
            Self::Lambert(_) => 0.0,
            Self::Phong(b) => b.specular.max_channel(),
            Self::Plastic(b) => b.specular.max_channel() * fresnel::dielectric(cos, b.ior),
            Self::Coated(b) => b.specular.max_channel() * fresnel::dielectric(cos, b.ior),
            Self::MetallicRoughness(b) => Rgb::from(fresnel::schlick(b.f0, cos)).max_channel(),
            Self::AshikhminShirley(b) => Rgb::from(fresnel::schlick(b.f0, cos)).max_channel(),
            Self::Principled(b) => b.importance_gloss(cos),
            Self::Layered(b) => b.importance_gloss(wo),
            Self::Conductor(_) | Self::Mirror(_) | Self::Glass(_) | Self::ThinGlass(_) => {
                self.albedo().max_channel()
            }
        }
    }

    /// GGX roughness `α` of the narrowest lobe; the geometric mean for brushed facets. A Phong lobe
    /// of exponent `n` counts as `√(2/(n + 2))` (Walter et al. 2007). `None` if the BSDF has no
    /// lobe of finite width.
    pub fn roughness(&self) -> Option<f32> {
        match self {
            Self::Phong(b) => (!b.specular.is_black()).then(|| (2.0 / (b.exponent + 2.0)).sqrt()),
            Self::Plastic(b) => Some(b.facets.mean()),
            Self::Conductor(b) => Some(b.facets.mean()),
            Self::Coated(b) => (!b.specular.is_black()).then_some(b.facets.mean()),
            Self::MetallicRoughness(b) => Some(b.facets.mean()),
            Self::AshikhminShirley(b) => Some(b.facets.mean()),
            Self::Principled(b) => Some(b.facets.mean()),
            Self::Layered(b) => b.roughness(),
            Self::Lambert(_) | Self::Mirror(_) | Self::Glass(_) | Self::ThinGlass(_) => None,
        }
    }

    /// Approximate overall reflectance, each channel in `[0, 1]`, for the albedo image of a
    /// denoiser.
    ///
    /// This is the albedo of a smooth surface of the same kind at normal incidence; for [`Glass`],
    /// reflection and transmission together.
    pub fn albedo(&self) -> Rgb {
        match self {
            Self::Lambert(b) => b.reflectance,
            Self::Phong(b) => b.diffuse + b.specular,
            Self::Plastic(b) => b.diffuse + b.specular * fresnel::dielectric(1.0, b.ior),
            Self::Conductor(b) => b.fresnel.at(1.0) * b.specular,
            Self::Coated(b) => b.diffuse_albedo(1.0) + b.specular * fresnel::dielectric(1.0, b.ior),
            Self::MetallicRoughness(b) => b.diffuse_albedo(1.0) + b.f0,
            Self::AshikhminShirley(b) => b.diffuse_albedo(1.0) + b.f0,
            Self::Principled(b) => b.diffuse_albedo(1.0) + b.fresnel.at(1.0).into(),
            Self::Layered(b) => b.albedo(),
            Self::Mirror(b) => b.reflectance,
            Self::Glass(b) => b.transmittance.lerp(b.reflectance, fresnel::dielectric(1.0, b.ior)),
            Self::ThinGlass(b) => {
                let passed = ThinGlass::passed(1.0, b.ior);
                b.reflectance.lerp(b.transmittance, passed)
            }
        }
        .map(|a| a.min(1.0))
    }

    /// Checks that all parameters are in range; the error names the parameter, its value, and the
    /// range.
    pub fn validate(&self) -> Result<(), String> {
        match self {
            Self::Lambert(b) => b.validate(),
            Self::Phong(b) => b.validate(),
            Self::Plastic(b) => b.validate(),
            Self::Conductor(b) => b.validate(),
            Self::Coated(b) => b.validate(),
            Self::MetallicRoughness(b) => b.validate(),
            Self::AshikhminShirley(b) => b.validate(),
            Self::Principled(b) => b.validate(),
            Self::Layered(b) => b.validate(),
            Self::Mirror(b) => b.validate(),
            Self::Glass(b) => b.validate(),
            Self::ThinGlass(b) => b.validate(),
        }
    }

    /// [`Bsdf::eval`] for two directions above the horizon.
    #[inline(always)]
    fn eval_above<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> [R; 3] {
        match self {
            Self::Lambert(b) => b.eval(),
            Self::Phong(b) => b.eval(wo, wi),
            Self::Plastic(b) => b.eval(wo, wi),
            Self::Conductor(b) => b.eval(wo, wi),
            Self::Coated(b) => b.eval(wo, wi),
            Self::MetallicRoughness(b) => b.eval(wo, wi),
            Self::AshikhminShirley(b) => b.eval(wo, wi),
            Self::Principled(b) => b.eval(wo, wi),
            Self::Layered(b) => b.eval(wo, wi),
            Self::Mirror(_) | Self::Glass(_) | Self::ThinGlass(_) => [R::splat(0.0); 3],
        }
    }

    /// [`Bsdf::pdf`] for two directions above the horizon.
    #[inline]
    fn pdf_above(&self, wo: Vec3, wi: Vec3) -> f32 {
        match self {
            Self::Lambert(b) => b.pdf(wi),
            Self::Phong(b) => b.pdf(wo, wi),
            Self::Plastic(b) => b.pdf(wo, wi),
            Self::Conductor(b) => b.pdf(wo, wi),
            Self::Coated(b) => b.pdf(wo, wi),
            Self::MetallicRoughness(b) => b.pdf(wo, wi),
            Self::AshikhminShirley(b) => b.pdf(wo, wi),
            Self::Principled(b) => b.pdf(wo, wi),
            Self::Layered(b) => b.pdf(wo, wi),
            Self::Mirror(_) | Self::Glass(_) | Self::ThinGlass(_) => 0.0,
        }
    }
}

/// Returns both directions with `wo` mirrored to `+z`; `None` unless they lie on the same side.
#[inline]
fn above_horizon(wo: Vec3, wi: Vec3) -> Option<(Vec3, Vec3)> {
    let side = 1.0_f32.copysign(wo.z);
    let (cos_o, cos_i) = (wo.z * side, wi.z * side);
    (cos_o > MIN_COSINE && cos_i > MIN_COSINE)
        .then(|| (Vec3::new(wo.x, wo.y, cos_o), Vec3::new(wi.x, wi.y, cos_i)))
}

/// Mirror direction of `w` with respect to the normal.
#[inline]
fn mirror_direction(w: Vec3) -> Vec3 {
    Vec3::new(-w.x, -w.y, w.z)
}

/// Returns true if the weight of a sample is not black.
fn carries_light(sample: &BsdfSample) -> bool {
    !sample.weight.is_black()
}
