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
mod model;
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
use model::{Model, family};
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

family! {
    /// Ideal diffuse reflection.
    Lambert,
    /// Diffuse reflection and a lobe around the mirror direction.
    Phong,
    /// Diffuse reflection and a lobe with the Fresnel reflectance of a dielectric.
    Plastic,
    /// Rough metal, or the transmission of a rough pane.
    Conductor,
    /// Rough dielectric coat on a diffuse base.
    Coated,
    /// The core material of glTF 2.0.
    MetallicRoughness,
    /// Facets over a diffuse base, which fades where the facets reflect.
    AshikhminShirley,
    /// The principled material of Disney.
    Principled,
    /// Sheen and a clear coat over an opaque surface.
    Layered,
    /// Ideal specular reflection.
    Mirror,
    /// Smooth or rough dielectric.
    Glass,
    /// Pane of glass.
    ThinGlass,
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
        if wo.z.is_nan() || wo.z.abs() <= MIN_COSINE {
            return None;
        }
        self.sample_model(wo, u).filter(|sample| !sample.weight.is_black())
    }

    /// Returns the BSDF with its diffuse part times `10⁻³`, for drawing directions of the glossy
    /// lobes. It can draw every direction that the original BSDF can.
    pub fn mostly_gloss(&self) -> Self {
        const LEFT: f32 = 1e-3;
        let mut gloss = *self;
        gloss.scale_diffuse(LEFT);
        gloss
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
