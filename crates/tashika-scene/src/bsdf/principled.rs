//! The principled material of Disney, as in Mitsuba 3 and version 3 of pbrt.
//!
//! ```text
//! f_r = ρ_d/π · ((1 − f) b + f e)  +  s w_d  +  F(c_d) D G₂ / (4 c_o c_i)          (sr⁻¹)
//!
//! b = (1 − w_o/2)(1 − w_i/2) + R (w_o + w_i + w_o w_i (R − 1)),    R = 2 r c_d²
//! e = 5/4 · (E (1 / (c_o + c_i) − ½) + ½),    E = (1 + (R/2 − 1) w_o)(1 + (R/2 − 1) w_i)
//! F = t (F₀ + (1 − F₀) w_d) + (1 − t) F_dielectric(c_d, η)
//! ```
//!
//! with `w = (1 − c)⁵` of a cosine, `c_d = ω_i·h`, the roughness `r` and `α = r²`. The diffuse part
//! is darker at grazing angles if `r` is small and brighter if `r` is large. With the flatness `f`
//! it resembles light scattered below the surface (after Hanrahan, Krueger 1993). The sheen `s` of
//! cloth and the reflection of facets are added to it (Burley 2012, section 5.3; 2015, equation 4).
//! A loader sets `ρ_d = base · (1 − metallic)`. It sets `t`, the share of Schlick's `F`, to the sum
//! of the shares of metal and of tinted reflection.
//!
//! # Limits
//! The parts are added without any coupling, so that at grazing angles the sum exceeds 1. The
//! albedo of the diffuse part of a white, rough surface is up to 1.56 there, that of the facets up
//! to 1, and that of a sheen of 1 up to 0.09. At such angles `e` is unbounded, but `e c_i` is
//! bounded.
//!
//! # Held to this by
//! `bsdf::tests`, and the suite's `mitsuba_materials` against Mitsuba 3.

use super::{Lobe, Model, diffuse_brdf, fresnel, lobes, microfacet, validate};
use crate::color::Rgb;
use crate::math::elementary::ln_f64;
use crate::math::simd::each;
use crate::math::{Real, Vec3};
use fresnel::schlick_weight;
use microfacet::{HalfVector, Microfacets};

/// Integrals `∫ w c dω / π`, `∫ w c² dω / π` and `∫ w c³ dω / π` over the hemisphere.
const MOMENTS: [f32; 3] = [1.0 / 21.0, 1.0 / 84.0, 1.0 / 252.0];

/// Largest sheen (sr⁻¹): the channel of a pure blue of luminance 1.
pub const MAX_SHEEN: f32 = 14.0;

/// Approximate albedo of a sheen of 1.
const IMPORTANCE_SHEEN: f32 = 0.1;

/// A rough diffuse surface with sheen, under facets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled {
    /// Reflectance `ρ_d` of the diffuse part, without its factor `(1 − f) b + f e`; each channel in
    /// `[0, 1]`.
    pub diffuse: Rgb,
    /// Roughness `r` of the diffuse part, in `[0, 1]`.
    pub roughness: f32,
    /// Flatness `f` of the diffuse part, in `[0, 1]`.
    pub flatness: f32,
    /// Sheen `s` (sr⁻¹); each channel from 0 to [`MAX_SHEEN`].
    pub sheen: Rgb,
    /// Fresnel reflectance of a facet.
    pub fresnel: TintedFresnel,
    /// Roughness and distribution of the facets.
    pub facets: Microfacets,
}

/// Weighted mean of Schlick's approximation and of the Fresnel reflectance of a dielectric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TintedFresnel {
    /// Share `t` of Schlick's approximation, in `[0, 1]`.
    pub schlick: f32,
    /// Reflectance `F₀` at normal incidence in Schlick's approximation; each channel in `[0, 1]`.
    pub f0: Rgb,
    /// Index of refraction `η` of the dielectric relative to the outside, from 1.0001 to 5.
    pub ior: f32,
}

impl TintedFresnel {
    /// Reflectance at an angle of incidence of cosine `cos`, by channel.
    #[inline(always)]
    pub(crate) fn at<R: Real>(&self, cos: R) -> [R; 3] {
        let tinted = fresnel::schlick(self.f0, cos);
        let plain = R::splat(1.0 - self.schlick) * fresnel::dielectric(cos, self.ior);
        each!(|channel| R::splat(self.schlick) * tinted[channel] + plain)
    }
}

impl Model for Principled {
    #[inline(always)]
    fn eval<R: Real>(&self, wo: Vec3, wi: [R; 3]) -> [R; 3] {
        let half = HalfVector::between(wo, wi);
        let cos_d = half.cos_incidence();
        let facets = self.facets.reflection(half, wo, wi);
        let reflected = self.fresnel.at(cos_d);
        let shape = self.shape(wo.z, wi[2], cos_d);
        let grazing = schlick_weight(cos_d);
        let (diffuse, sheen) = (diffuse_brdf(self.diffuse).to_array(), self.sheen.to_array());
        each!(|channel| {
            R::splat(diffuse[channel]) * shape
                + R::splat(sheen[channel]) * grazing
                + reflected[channel] * facets
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

    /// Estimate of the albedo of sheen and facets, which [`Principled::diffuse_albedo`] does not
    /// include.
    fn importance_gloss(&self, wo: Vec3) -> f32 {
        (Rgb::from(self.fresnel.at(wo.z.abs())) + self.sheen * IMPORTANCE_SHEEN).max_channel()
    }

    fn roughness(&self) -> Option<f32> {
        Some(self.facets.mean())
    }

    fn albedo(&self) -> Rgb {
        self.diffuse_albedo(1.0) + self.fresnel.at(1.0).into()
    }

    fn validate(&self) -> Result<(), String> {
        validate::fraction("diffuse", self.diffuse)?;
        validate::in_range("roughness", self.roughness, 0.0, 1.0)?;
        validate::in_range("flatness", self.flatness, 0.0, 1.0)?;
        validate::channels_in_range("sheen", self.sheen, 0.0, MAX_SHEEN)?;
        validate::in_range("share of Schlick's", self.fresnel.schlick, 0.0, 1.0)?;
        validate::fraction("f0", self.fresnel.f0)?;
        validate::ior(self.fresnel.ior)?;
        validate::facets(self.facets)
    }
}

impl Principled {
    /// `(1 − f) b + f e`.
    #[inline(always)]
    fn shape<R: Real>(&self, cos_o: f32, cos_i: R, cos_d: R) -> R {
        let (one, o, i) = (R::splat(1.0), R::splat(schlick_weight(cos_o)), schlick_weight(cos_i));
        let half = R::splat(0.5);
        let r = R::splat(2.0 * self.roughness) * cos_d * cos_d;
        let rough = (one - half * o) * (one - half * i) + r * (o + i - o * i + o * i * r);
        if self.flatness == 0.0 {
            return rough;
        }
        let grazing = half * r - one;
        let even = (one + grazing * o) * (one + grazing * i);
        let flat = R::splat(1.25) * (even * (one / (R::splat(cos_o) + cos_i) - half) + half);
        R::splat(1.0 - self.flatness) * rough + R::splat(self.flatness) * flat
    }

    /// `ρ_d ∫ ((1 − f) b + f e) c_i dω_i / π` for light at cosine `cos_o`.
    pub(super) fn diffuse_albedo(&self, cos_o: f32) -> Rgb {
        let rough = self.rough_albedo(cos_o);
        if self.flatness == 0.0 {
            return self.diffuse * rough;
        }
        let flat = flat_albedo(f64::from(self.roughness), f64::from(cos_o)) as f32;
        self.diffuse * ((1.0 - self.flatness) * rough + self.flatness * flat)
    }

    /// `∫ b c_i dω_i / π` for light at cosine `cos_o`, `c`.
    ///
    /// `2 c_d² = 1 + ω_o·ω_i`, so that `b` is a polynomial in `w_i` and the components of `ω_i`:
    /// with `M` the moments of `w`, and `s` the sine,
    ///
    /// ```text
    /// (1 − w_o/2)(1 − M₀/2) + r w_o (1 + 2c/3) + r (1 − w_o)(M₀ + c M₁) + r² w_o (M₀ + 2c M₁ + c² M₂ + s² (M₀ − M₂)/2)
    /// ```
    fn rough_albedo(&self, cos_o: f32) -> f32 {
        let ([m0, m1, m2], c, r) = (MOMENTS, cos_o, self.roughness);
        let w = schlick_weight(c);
        let across = 0.5 * (1.0 - c) * (1.0 + c) * (m0 - m2);
        let once = w * (1.0 + 2.0 / 3.0 * c) + (1.0 - w) * (m0 + c * m1);
        let twice = w * (m0 + c * (2.0 * m1 + c * m2) + across);
        (1.0 - 0.5 * w) * (1.0 - 0.5 * m0) + r * (once + r * twice)
    }

    fn facet_probability(&self, cos_o: f32) -> f32 {
        let spread = self.diffuse_albedo(cos_o) + self.sheen * IMPORTANCE_SHEEN;
        lobes::facet_probability(self.fresnel.at(cos_o), spread)
    }
}

/// `∫ e c_i dω_i / π` for a roughness `r` and light at cosine `cos_o`.
///
/// Averaged over azimuths, `E` is a polynomial `P` of degree 7 in `c = c_i`: with
/// `R/2 = m + n cos φ`,
///
/// ```text
/// P = (1 − w_o)(1 − w_i) + m (w_o + w_i − 2 w_o w_i) + (m² + n²/2) w_o w_i
/// m = r (1 + c_o c) / 2,    n² = r² (1 − c_o²)(1 − c²) / 4
/// ```
///
/// `∫₀¹ 2c P / (c + c_o) dc` is computed by polynomial division of `2c P` by `c + c_o`: it is the
/// integral of the quotient, plus the remainder times `ln ((1 + c_o) / c_o)`.
fn flat_albedo(r: f64, cos_o: f64) -> f64 {
    /// Coefficients of `w_i = (1 − c)⁵`, from the constant on.
    const GRAZING: [f64; 6] = [1.0, -5.0, 10.0, -10.0, 5.0, -1.0];
    let cos_o = cos_o.max(f64::MIN_POSITIVE);
    let w = GRAZING.into_iter().rev().fold(0.0, |sum, coefficient| sum * cos_o + coefficient);
    let (half, sin2) = (0.5 * r, (1.0 - cos_o) * (1.0 + cos_o));
    // m² + n²/2.
    let square = [
        half * half * (1.0 + 0.5 * sin2),
        half * half * 2.0 * cos_o,
        half * half * (cos_o * cos_o - 0.5 * sin2),
    ];
    // The terms without w_i, and those multiplied by w_i.
    let alone = [1.0 - w + half * w, half * w * cos_o];
    let by_grazing = [
        w - 1.0 + half * (1.0 - 2.0 * w) + w * square[0],
        half * (1.0 - 2.0 * w) * cos_o + w * square[1],
        w * square[2],
    ];
    let mut p = [0.0; 8];
    p[..2].copy_from_slice(&alone);
    for (i, a) in by_grazing.into_iter().enumerate() {
        for (j, b) in GRAZING.into_iter().enumerate() {
            p[i + j] += a * b;
        }
    }
    // Division of c P by c + c_o, from the highest power down.
    let (mut quotient, mut remainder) = (0.0, 0.0);
    for (power, coefficient) in p.into_iter().enumerate().rev() {
        remainder = coefficient - cos_o * remainder;
        quotient += remainder / (power + 1) as f64;
    }
    let over_sum = quotient - cos_o * remainder * ln_f64((1.0 + cos_o) / cos_o);
    let plain: f64 = p.into_iter().enumerate().map(|(power, c)| c / (power + 2) as f64).sum();
    1.25 * (2.0 * over_sum - plain + 0.5)
}
