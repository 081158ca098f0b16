//! Upper bounds of the reflection of clear coats, over ranges of angles and of roughness.
//!
//! Let `v(c) = 1 / (c + S(c))` for the masking roughness ¼, and `F(c) = 0.04 + 0.96 (1 − c)⁵`
//! ([`bsdf`](crate::bsdf), [`ggx`]). A coat is the product of a factor `s`, which depends only on
//! the viewer, with `F`, `V` and `D`:
//!
//! | model | `s` | `F` | `V` | `V` falls with | `V c_i` grows with |
//! |---|---|---|---|---|---|
//! | Disney | `¼ w v(c_o)` | `F(c_d)` | `v(c_i)` | `c_i` | `c_i` |
//! | Mitsuba | `w c_o v(c_o)` | `F(c_d)` | `c_i v(c_i) ≤ ½` | | `c_i` |
//! | layer | `w F(c_o)` | 1 | `G₂ / (4 c_o c_i)` | `α`, `c_o`, `c_i` | `c_i` |
//!
//! For layers `D` is that of GGX. For the other models it is
//!
//! ```text
//! D₁ = K(α) (1 + t) / (α² + t),    K = (1 − α²) / (−2π ln α)          falls with t = tan²θ_h
//! ```
//!
//! `K` grows with `α`: `∂ ln K/∂ ln α = 1/L − 2α²/(1 − α²)` with `L = −ln α`, and
//! `2L = ln (1 + (1 − α²)/α²) < (1 − α²)/α²`. Over `[a, b]`, therefore, `D₁` is at most
//! `K(b) (1 + t) / (a² + t)`. A range of roughness is divided into pieces of equal ratio; for a
//! single roughness the bound is exact.
//!
//! # Guarantee
//! At least the `f32` values except for relative roundings.
//!
//! # Held to this by
//! The tests below, `bounds::tests::reflector`, `bounds::tests::analytic`,
//! `bounds::tests::cube_map`.

use std::f64::consts::TAU;

use super::facets::{Ring, upper_reflection};
use super::ggx;
use crate::bounds::angle::Angle;
use crate::bsdf::{Clearcoat, CoatModel, MASKING_ALPHA, coat_reflectance};
use crate::math::elementary::{ln_f64, powf_f64};

/// Number of pieces into which a range of roughness is divided to bound `D₁`; their ratio is below
/// 1.8.
const PIECES: u32 = 8;

/// Tangents of the angle between half vector and normal, in units of the largest `α`, that separate
/// the rings in which factors are bounded one by one. `D₁` has longer tails than GGX, hence more
/// rings. Chosen.
const CUTS: [f64; 5] = [1.0, 3.0, 10.0, 30.0, 100.0];

/// Clear coats of one model, as ranges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::bounds) struct Coats {
    model: CoatModel,
    /// Smallest and largest `α`.
    alphas: [f32; 2],
    /// Upper bound of `s`; zero if there is no coat.
    scale: f32,
}

/// Quantity to bound, and the light directions over which it is bounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::bounds) enum Light {
    /// `f_r`, for light at cosines of at least this.
    From(f64),
    /// `f_r c_i`, for light at cosines of at most this, which must be positive.
    UpTo(f64),
}

impl Coats {
    /// An empty set of coats of a model.
    pub(in crate::bounds) const fn none(model: CoatModel) -> Self {
        Self { model, alphas: [f32::INFINITY, f32::NEG_INFINITY], scale: 0.0 }
    }

    /// Coat of one surface seen at the cosine `cos_o > 0`; `None` if there is no coat.
    pub(super) fn of(coat: &Clearcoat, cos_o: f32) -> Option<Self> {
        let (amount, cos) = (f64::from(coat.amount), f64::from(cos_o));
        let scale = match coat.model {
            CoatModel::Disney => 0.25 * amount * ggx::upper_visible(MASKING_ALPHA.into(), cos),
            CoatModel::Mitsuba => amount * cos * ggx::upper_visible(MASKING_ALPHA.into(), cos),
            CoatModel::Layer => coat.layer(cos_o).into(),
        };
        let scale = (scale as f32).next_up();
        (coat.amount > 0.0).then_some(Self { model: coat.model, alphas: [coat.alpha; 2], scale })
    }

    /// Model of all coats in the set.
    pub(in crate::bounds) fn model(&self) -> CoatModel {
        self.model
    }

    /// The largest `α`.
    pub(in crate::bounds) fn widest(&self) -> f32 {
        self.alphas[1]
    }

    /// Ranges that contain those of both sets, which must have the same model.
    pub(in crate::bounds) fn union(self, other: Self) -> Self {
        let ([low, high], [other_low, other_high]) = (self.alphas, other.alphas);
        Self {
            model: self.model,
            alphas: [low.min(other_low), high.max(other_high)],
            scale: self.scale.max(other.scale),
        }
    }

    /// Upper bound of the reflection of coats (sr⁻¹) for all half vectors at an angle of at least
    /// `least` from the normal.
    ///
    /// * `viewer`: upper bound of the angle between any normal and its viewer.
    /// * `cos_incidence`: lower bound of the cosine of incidence on a facet.
    /// * `cos_o`: lower bound of the cosine between any normal and its viewer.
    pub(in crate::bounds) fn upper(
        &self,
        least: Angle,
        viewer: Angle,
        cos_incidence: f64,
        cos_o: f64,
        light: Light,
    ) -> f64 {
        if self.scale <= 0.0 {
            return 0.0;
        }
        let cos_light = match light {
            Light::From(least) => least,
            // Lights of all cosines are in every ring.
            Light::UpTo(_) => 1.0,
        };
        let all = Ring { cos_incidence, cos_light };
        let widest = f64::from(self.alphas[1]);
        let distribution = |least| self.upper_distribution(least);
        upper_reflection(distribution, CUTS.map(|cut| cut * widest), least, viewer, all, |ring| {
            let light = match light {
                Light::From(_) => Light::From(ring.cos_light),
                light => light,
            };
            self.upper_others(ring.cos_incidence, cos_o, light)
        })
    }

    /// [`Coats::upper`] without rings of half vectors: faster, but larger near the peak.
    pub(in crate::bounds) fn upper_at_once(
        &self,
        least: Angle,
        cos_incidence: f64,
        cos_o: f64,
        light: Light,
    ) -> f64 {
        if self.scale <= 0.0 {
            return 0.0;
        }
        self.upper_distribution(least) * self.upper_others(cos_incidence, cos_o, light)
    }

    /// Upper bound of `D` (sr⁻¹) for all roughnesses and all half vectors at an angle of at least
    /// `least` from the normal.
    fn upper_distribution(&self, least: Angle) -> f64 {
        let [low, high] = self.alphas.map(f64::from);
        if self.model == CoatModel::Layer {
            return ggx::upper_distribution([low, high], least);
        }
        if least.cos <= 0.0 {
            return 0.0;
        }
        let tan = least.sin / least.cos;
        let t = tan * tan;
        let of_piece = |low: f64, high: f64| {
            let scale = (1.0 - high * high) / (-TAU * ln_f64(high));
            scale * (1.0 + t) / (low * low + t)
        };
        if low == high {
            return of_piece(low, high);
        }
        let ratio = powf_f64(high / low, 1.0 / f64::from(PIECES));
        let ends = |piece: u32| {
            let start = low * powf_f64(ratio, f64::from(piece));
            // The last piece must reach `high` despite rounding.
            (start, (start * ratio * (1.0 + 1e-12)).min(high))
        };
        (0..PIECES).map(ends).map(|(low, high)| of_piece(low, high)).fold(0.0, f64::max)
    }

    /// Upper bound of the product of the other factors.
    fn upper_others(&self, cos_incidence: f64, cos_o: f64, light: Light) -> f64 {
        let (layer, masking) = (f64::from(self.alphas[0]), f64::from(MASKING_ALPHA));
        let visible = |cos| ggx::upper_visible(masking, cos);
        let visibility = match (self.model, light) {
            (CoatModel::Layer, Light::From(cos)) => ggx::upper_visibility(layer, cos_o, cos),
            (CoatModel::Layer, Light::UpTo(cos)) => ggx::upper_visibility_cos(layer, cos_o, cos),
            (CoatModel::Disney, Light::From(cos)) => visible(cos),
            (CoatModel::Disney, Light::UpTo(cos)) => visible(cos) * cos,
            (CoatModel::Mitsuba, Light::From(_)) => 0.5,
            (CoatModel::Mitsuba, Light::UpTo(cos)) => visible(cos) * cos * cos,
        };
        let reflected = match self.model {
            CoatModel::Layer => 1.0,
            // Rounding down the cosine enlarges the angle.
            _ => coat_reflectance((cos_incidence as f32).next_down().max(0.0)).into(),
        };
        f64::from(self.scale) * reflected * visibility
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Bsdf, Lambert, Layered};
    use crate::color::Rgb;
    use crate::math::Vec3;
    use crate::math::elementary::powf;
    use crate::rng::{Purpose, Stream};

    fn coat(model: CoatModel, alpha: f32) -> Clearcoat {
        Clearcoat { amount: 1.0, alpha, model }
    }

    /// A BSDF that consists of the coat alone, over a black base.
    fn over_black(coat: Clearcoat) -> Bsdf {
        let black = Bsdf::Lambert(Lambert { reflectance: Rgb::BLACK });
        Bsdf::Layered(Layered { coat, ..Layered::over(&black).unwrap() })
    }

    fn coats(model: CoatModel, alphas: [f32; 2], cos_o: f32) -> Coats {
        let [low, high] = alphas.map(|alpha| Coats::of(&coat(model, alpha), cos_o).unwrap());
        low.union(high)
    }

    /// Compares the bound of a range with roughnesses in steps of equal ratio. Within a piece, `D₁`
    /// varies by at most the square of the piece's ratio; the bound of a single roughness is exact.
    #[test]
    fn ranges_of_roughness_hold_and_are_tight() {
        for [low, high] in [[1e-3_f32, 1e-3], [1e-3, 0.1], [0.01, 0.03], [0.1, 0.1]] {
            let bounded = coats(CoatModel::Disney, [low, high], 1.0);
            for tan in [0.0_f64, 1e-4, 1e-3, 0.01, 0.1, 1.0, 10.0] {
                let cos = 1.0 / (1.0 + tan * tan).sqrt();
                let bound = bounded.upper_distribution(Angle { sin: tan * cos, cos });
                let mut largest = 0.0_f64;
                for step in 0..=200 {
                    let alpha = f64::from(low) * f64::from(high / low).powf(f64::from(step) / 200.0);
                    let a2 = alpha * alpha;
                    let d = (a2 - 1.0) / (std::f64::consts::PI * a2.ln() * (1.0 + (a2 - 1.0) * cos * cos));
                    assert!(d <= bound * (1.0 + 1e-6), "{low} {high} {tan}: {d} above {bound}");
                    largest = largest.max(d);
                }
                let ratio = f64::from(high / low).powf(1.0 / f64::from(PIECES));
                let limit = ratio * ratio * (1.0 + 1e-6);
                assert!(bound <= limit * largest, "{low} {high} {tan}: {bound} for {largest}");
            }
        }
    }

    /// Random directions, each bounded by its own half vector and cosines. The bounds hold. They
    /// are equal to the value, except where a factor is replaced by a constant.
    #[test]
    fn coats_are_bounded_by_their_own_angles() {
        let mut s = Stream::new(81, Purpose::Test, 0);
        for round in 0..30_000 {
            let model = CoatModel::ALL[round % 3];
            let alpha = 1e-3 * powf(100.0, s.uniform());
            let upper_half = |s: &mut Stream| {
                let v = crate::warp::sphere(s.uniform_2());
                Vec3::new(v.x, v.y, v.z.abs().max(0.02)).normalize()
            };
            let wo = upper_half(&mut s);
            let other = upper_half(&mut s) * s.uniform() * s.uniform();
            let wi = (Vec3::new(-wo.x, -wo.y, wo.z) + other).normalize();
            let value = f64::from(over_black(coat(model, alpha)).eval(wo, wi).g);
            let h = (wo + wi).as_dvec3();
            let (tan, incidence) = (h.truncate().length() / h.z, 0.5 * h.length());
            let cos = 1.0 / (1.0 + tan * tan).sqrt();
            let least = Angle { sin: tan * cos, cos };
            let bounded = coats(model, [alpha; 2], wo.z);
            let viewer = Angle::of_cos(wo.z.into());
            let (cos_o, cos_i) = (f64::from(wo.z), f64::from(wi.z));
            // Directions are of length 1 to 10⁻⁷. This error rotates the half vector.
            let slack = 1.0 + 1e-5 + 1e-6 / f64::from(alpha) / incidence;
            for (light, value) in [(Light::From(cos_i), value), (Light::UpTo(cos_i), value * cos_i)] {
                let at_once = bounded.upper_at_once(least, incidence, cos_o, light);
                let ringed = bounded.upper(least, viewer, incidence, cos_o, light);
                assert!(value <= at_once * slack, "{model:?} {light:?}: {value} above {at_once}");
                assert!(value <= ringed * slack, "{model:?} {light:?}: {value} above {ringed}");
                assert!(ringed <= at_once * (1.0 + 1e-9), "{model:?} {light:?}: {ringed} above {at_once}");
                if model != CoatModel::Mitsuba || light == Light::UpTo(cos_i) {
                    assert!(at_once <= value * slack, "{model:?} {light:?}: {at_once} for {value}");
                }
            }
        }
    }
}
