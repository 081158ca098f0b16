//! Functions shared by BSDFs of several lobes.

use std::f32::consts::FRAC_1_PI;

use super::Lobe;
use super::microfacet::{HalfVector, Microfacets};
use crate::color::Rgb;
use crate::math::simd::each;
use crate::math::{Real, Vec3};
use crate::warp;

/// Smallest probability of drawing from either of two reflecting lobes. However wrong the estimates
/// of their shares are, the weights are then increased at most tenfold. Chosen.
const MIN_LOBE_PROBABILITY: f32 = 0.1;

/// Probability of drawing from the glossy of two lobes, given estimates of their reflectances.
///
/// `None` if neither reflects anything.
#[inline]
pub fn glossy_probability(glossy: f32, diffuse: f32) -> Option<f32> {
    match (glossy > 0.0, diffuse > 0.0) {
        (true, true) => {
            Some((glossy / (glossy + diffuse)).clamp(MIN_LOBE_PROBABILITY, 1.0 - MIN_LOBE_PROBABILITY))
        }
        (true, false) => Some(1.0),
        (false, true) => Some(0.0),
        (false, false) => None,
    }
}

/// Probability of drawing from facets over a diffuse part. The facets always reflect: `F` is 1 at
/// grazing angles even if `F₀ = 0`.
///
/// * `reflected`: reflectance of a facet for light from the direction of the viewer; `diffuse`:
///   albedo of the diffuse part.
#[inline]
pub(super) fn facet_probability(reflected: [f32; 3], diffuse: Rgb) -> f32 {
    let facets = Rgb::from(reflected).max_channel().max(f32::MIN_POSITIVE);
    glossy_probability(facets, diffuse.max_channel()).unwrap_or(1.0)
}

/// Density (sr⁻¹) of [`draw`].
///
/// * `p`: probability of drawing from the facets.
#[inline]
pub(super) fn pdf(p: f32, facets: &Microfacets, wo: Vec3, wi: Vec3) -> f32 {
    let reflection = facets.reflection_pdf(HalfVector::between(wo, wi.to_array()), wo, wi);
    (1.0 - p) * warp::cosine_hemisphere_pdf(wi.z) + p * reflection
}

/// Draws from the facets with probability `p`, else in proportion to the cosine.
pub(super) fn draw(p: f32, facets: &Microfacets, wo: Vec3, u: [f32; 3]) -> (Vec3, Lobe) {
    let direction = [u[1], u[2]];
    if u[0] < p {
        (facets.sample_reflection(wo, direction), Lobe::Glossy)
    } else {
        (warp::cosine_hemisphere(direction), Lobe::Diffuse)
    }
}

/// `a x + b y`, channel by channel.
#[inline(always)]
pub(super) fn sum_of_lobes<R: Real>(a: Rgb, x: R, b: Rgb, y: R) -> [R; 3] {
    let (a, b) = (a.to_array(), b.to_array());
    each!(|channel| R::splat(a[channel]) * x + R::splat(b[channel]) * y)
}

/// Value `f_r` of an ideal diffuse surface (sr⁻¹).
#[inline]
pub(super) fn diffuse_brdf(reflectance: Rgb) -> Rgb {
    reflectance * FRAC_1_PI
}
