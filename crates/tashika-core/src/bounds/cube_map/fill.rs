//! Fills the texels of one gather point with upper bounds of its BRDF over each texel's bounding
//! cone.
//!
//! ```text
//! f_r        ≤ diffuse + ρ (n + 2)/2π cosⁿα     or   diffuse + F D G₂ / (4 c_o c_i), each factor at its largest      (sr⁻¹)
//! lobe · c_i ≤           ρ (n + 2)/2π cosⁿα c_i or             F D G₂ / (4 c_o)
//! ```
//!
//! The bound of a coat is added to each.
//!
//! These are the bounds of [`Reflector::upper_brdf`] and [`Reflector::upper_brdf_cos`], adapted to
//! hundreds of cones at once: the angles of a row of texels are computed together
//! ([`spans`](super::spans)), and quantities that depend only on the point are computed once. This
//! is many times faster, and the bounds are hardly larger. They would be much larger where half
//! vectors are near the normal, at the peak of facet lobes; these texels are bounded one by one.
//!
//! # Guarantee
//! A texel is at least the largest channel as `contribution` computes it, for every direction of
//! the texel. It is zero if the texel is certainly below the plane of either normal.
//!
//! # Held to this by
//! The tests below, `bounds::tests::cube_map`.

use std::f32::consts::FRAC_1_PI;

use super::faces::Faces;
use super::spans::{Directions, Horizon, Spans};
use super::texel::Texel;
use crate::bounds::Reflector;
use crate::bounds::angle::Angle;
use crate::bounds::lobes::clearcoat::{Coats, Light};
use crate::bounds::lobes::facets::{
    FacetKind, Seen, Widths, upper_distribution, upper_visibility, upper_visibility_cos,
};
use crate::bounds::lobes::{Lobe, Parts, phong, round_up};
use crate::bsdf::{FacetModel, MIN_COSINE, Microfacets};
use crate::math::Cone;

/// Reflectances are stored at the cosines of incidence `(k / KNOTS)²`. With more of them `F` is
/// tighter and filling takes longer. Chosen so that the ratio of neighbouring values is below 1.25
/// for dielectrics of an index above 1.3 and for Schlick's `F` with `F₀` above 0.04.
const KNOTS: usize = 32;

/// The diffuse part is bounded separately for this many upper limits of the cosine with the normal,
/// `(k + 1) / STEPS`. This matters for coated surfaces, whose coats transmit less light at grazing
/// angles.
const STEPS: usize = 8;

/// Negated exponent of a limit: a Phong lobe that is fainter than `e⁻²⁴` of its peak is bounded by
/// that value. Thus most texels of a sharp lobe need no logarithm.
const FAINT_POWER: f64 = 24.0;

/// Upper bound of `e⁻²⁴`.
const FAINT: f64 = 3.8e-11;

/// A texel's half vectors are near the peak of the lobe if they are within `α` of the normal, or
/// within this angle (rad) if `α` is larger. Chosen: a larger angle costs time, and beyond this one
/// the product of separate maxima is hardly larger than the maximum of the product.
const WIDEST_PEAK: f32 = 0.1;

/// Quantity of which the texels are upper bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bounded {
    /// `f_r`.
    Brdf,
    /// The lobe times the cosine, without the diffuse part.
    LobeCosine,
}

/// Quantities of one point from which its texels are computed.
struct Source {
    bounded: Bounded,
    /// Gather point whose texels are filled.
    point: Reflector,
    cos_o: f32,
    /// Upper bounds of the diffuse part (sr⁻¹).
    diffuse: [f64; STEPS],
    lobe: Lobe,
    coat: Option<Coats>,
    /// Upper bounds of `F` at the knots; zeros if there are no facets.
    reflected: [f64; KNOTS + 1],
    /// Model of reflection at the facets.
    kind: FacetKind,
    /// Distribution and roughness of the facets; GGX of roughness 1 if there are none.
    facets: Microfacets,
}

/// Fills the texels of a point. All of them must be zero before.
pub fn fill<const N: usize>(texels: &mut [[[Texel; N]; N]; 6], point: &Reflector, bounded: Bounded) {
    const { assert!(N >= 2 && N <= 16, "half-angles of texels are not between 1/20 and a right angle") };
    let Some(source) = Source::of(point, bounded) else { return };
    let directions = Directions::of(point);
    for (face, rows) in texels.iter_mut().enumerate() {
        let directions = directions.turned::<N>(face);
        for (v, (row, values)) in Faces::<N>::ROWS.iter().zip(rows).enumerate() {
            let horizon = directions.horizon(row);
            let spans = if source.is_diffuse() { Spans::NONE } else { directions.spans(row) };
            let lobes = source.lobes(&horizon, &spans);
            for (u, value) in values.iter_mut().enumerate().filter(|(u, _)| horizon.above[*u]) {
                let step = ((horizon.max_cos_i[u] * STEPS as f32) as usize).min(STEPS - 1);
                let coat = source.coat.map_or(0.0, |coat| source.upper_coat(&coat, &horizon, &spans, u));
                let upper = round_up(source.diffuse[step] + lobes[u] + coat);
                *value = Texel::at_least(if source.near_peak(spans.half_sin[u]) {
                    upper.min(source.upper_alone(&Faces::<N>::cone(face, v, u)))
                } else {
                    upper
                });
            }
        }
    }
}

impl Source {
    /// Prepares the data of a point; `None` if all texels are zero.
    fn of(point: &Reflector, bounded: Bounded) -> Option<Self> {
        let cos_o = point.wo.z.abs();
        let parts = Parts::of(&point.bsdf, cos_o, 1.0);
        if cos_o <= MIN_COSINE || parts.is_diffuse() && bounded == Bounded::LobeCosine {
            return None;
        }
        let Parts { lobe, coat, .. } = parts;
        let (kind, facets, reflected) = match lobe {
            Lobe::None | Lobe::Phong { .. } => {
                (FacetKind::Model(FacetModel::Ggx), Microfacets::ggx(1.0), [0.0; KNOTS + 1])
            }
            Lobe::Facets { kind, facets, reflected } => {
                let root = |k: usize| k as f64 / KNOTS as f64;
                (kind, facets, std::array::from_fn(|k| reflected.upper(root(k) * root(k))))
            }
        };
        let diffuse = match bounded {
            Bounded::Brdf => {
                let at = |k: usize| Parts::of(&point.bsdf, cos_o, (k + 1) as f64 / STEPS as f64).diffuse;
                std::array::from_fn(at)
            }
            Bounded::LobeCosine => [0.0; STEPS],
        };
        Some(Self { bounded, point: *point, cos_o, diffuse, lobe, coat, reflected, kind, facets })
    }

    fn is_diffuse(&self) -> bool {
        matches!(self.lobe, Lobe::None) && self.coat.is_none()
    }

    /// Upper bound of the coat over a texel that is partly above the horizon.
    fn upper_coat<const N: usize>(
        &self,
        coat: &Coats,
        horizon: &Horizon<N>,
        spans: &Spans<N>,
        u: usize,
    ) -> f64 {
        let light = match self.bounded {
            Bounded::Brdf => Light::From(spans.min_cos_i[u].into()),
            Bounded::LobeCosine => Light::UpTo(horizon.max_cos_i[u].into()),
        };
        coat.upper_at_once(half(spans, u), spans.cos_incidence[u].into(), self.cos_o.into(), light)
    }

    /// Upper bounds of the lobe over the texels of a row. Texels entirely below the horizon get
    /// zero.
    fn lobes<const N: usize>(&self, horizon: &Horizon<N>, spans: &Spans<N>) -> [f64; N] {
        let facets = match self.lobe {
            Lobe::None => return [0.0; N],
            Lobe::Phong { .. } => [0.0; N],
            Lobe::Facets { .. } => self.facets(horizon, spans),
        };
        std::array::from_fn(|u| match self.lobe {
            _ if !horizon.above[u] => 0.0,
            Lobe::None => 0.0,
            Lobe::Phong { scale, exponent } => {
                let [sin, cos] = spans.from_mirror.map(|lanes| f64::from(lanes[u]));
                // cosⁿ ≤ exp(−n (1 − cos)). The slack of the angle is larger than the rounding
                // error of 1 − cos.
                let faint = exponent * (1.0 - cos) > FAINT_POWER && cos > 0.01;
                let power = if faint {
                    (exponent + 2.0) * FAINT
                } else {
                    phong::upper_power([exponent; 2], Angle { sin, cos })
                };
                match self.bounded {
                    Bounded::Brdf => scale * power,
                    Bounded::LobeCosine => scale * power * f64::from(horizon.max_cos_i[u]),
                }
            }
            Lobe::Facets { .. } => {
                let knot = ((spans.cos_incidence[u].sqrt() * KNOTS as f32) as usize).min(KNOTS);
                self.reflected[knot] * facets[u]
            }
        })
    }

    /// Upper bounds of `D G₂ / (4 c_o c_i)`, or of `D G₂ / (4 c_o)`, as in `bounds::lobes::facets`.
    fn facets<const N: usize>(&self, horizon: &Horizon<N>, spans: &Spans<N>) -> [f64; N] {
        let kind = self.kind;
        if kind == FacetKind::Model(FacetModel::Ggx) && self.facets.is_even() {
            return self.correlated(horizon, spans).map(f64::from);
        }
        let widths = Widths::of(&self.facets);
        let (narrowest, cos_o) = (f64::from(widths.narrowest), f64::from(self.cos_o));
        std::array::from_fn(|u| {
            if !horizon.above[u] {
                return 0.0;
            }
            let cos_incidence = f64::from(spans.cos_incidence[u]);
            let seen = |cos_i: f32| Seen { alpha: narrowest, cos_o, cos_i: cos_i.into(), cos_incidence };
            let visibility = match self.bounded {
                Bounded::Brdf => upper_visibility(kind, &seen(spans.min_cos_i[u])),
                Bounded::LobeCosine => upper_visibility_cos(kind, &seen(horizon.max_cos_i[u])),
            };
            upper_distribution(kind, widths, half(spans, u)) * visibility
        })
    }

    /// [`Source::facets`] for a whole row at once, for GGX facets with height-correlated masking
    /// and equal roughness in all directions.
    fn correlated<const N: usize>(&self, horizon: &Horizon<N>, spans: &Spans<N>) -> [f32; N] {
        let alpha = self.facets.widest();
        let alpha2 = alpha * alpha;
        let stretch = |cos: f32| (alpha2 + (1.0 - alpha2) * cos * cos).sqrt();
        let stretch_o = stretch(self.cos_o);
        std::array::from_fn(|u| {
            let sin2 = spans.half_sin[u] * spans.half_sin[u];
            let root = alpha / (alpha2 * (1.0 - sin2) + sin2);
            let (min_cos_i, max_cos_i) = (spans.min_cos_i[u], horizon.max_cos_i[u]);
            let shadowed = match self.bounded {
                Bounded::Brdf => self.cos_o * stretch(min_cos_i) + min_cos_i * stretch_o,
                Bounded::LobeCosine => self.cos_o * stretch(max_cos_i) / max_cos_i + stretch_o,
            };
            root * root * FRAC_1_PI * 0.5 / shadowed
        })
    }

    /// Returns true if `D` is near its peak for the half vector closest to the normal.
    fn near_peak(&self, half_sin: f32) -> bool {
        let of_lobe = match self.lobe {
            Lobe::None | Lobe::Phong { .. } => 0.0,
            Lobe::Facets { .. } => self.facets.widest(),
        };
        let of_coat = self.coat.map_or(0.0, |coat| coat.widest());
        half_sin < of_lobe.max(of_coat).min(WIDEST_PEAK)
    }

    /// Bound over a single cone: slower, and tighter near the peak of facet lobes.
    fn upper_alone(&self, cone: &Cone) -> f32 {
        match self.bounded {
            Bounded::Brdf => self.point.upper_brdf(cone),
            Bounded::LobeCosine => self.point.upper_lobe_cos(cone),
        }
    }
}

/// Least angle between half vector and normal over the texel.
fn half<const N: usize>(spans: &Spans<N>, u: usize) -> Angle {
    let sin = f64::from(spans.half_sin[u]);
    Angle { sin, cos: (1.0 - sin * sin).max(0.0).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::tests::cases::{KINDS, Kind, half_angle, mirror, near, random_point, reflected};
    use crate::bsdf::{Bsdf, UnderLayers};
    use crate::color::Rgb;
    use crate::rng::{Purpose, Stream};

    /// A BSDF with the same lobe and no diffuse part.
    fn without_diffuse(mut bsdf: Bsdf) -> Bsdf {
        match &mut bsdf {
            Bsdf::Lambert(b) => b.reflectance = Rgb::BLACK,
            Bsdf::Phong(b) => b.diffuse = Rgb::BLACK,
            Bsdf::Plastic(b) => b.diffuse = Rgb::BLACK,
            Bsdf::Coated(b) => b.reflectance = Rgb::BLACK,
            Bsdf::MetallicRoughness(b) => b.diffuse = Rgb::BLACK,
            Bsdf::AshikhminShirley(b) => b.diffuse = Rgb::BLACK,
            Bsdf::Principled(b) => (b.diffuse, b.sheen) = (Rgb::BLACK, Rgb::BLACK),
            Bsdf::Layered(b) => {
                let base = without_diffuse(b.base.into());
                b.base = UnderLayers::of(&base).unwrap_or(b.base);
            }
            Bsdf::Conductor(_) | Bsdf::Mirror(_) | Bsdf::Glass(_) | Bsdf::ThinGlass(_) => {}
        }
        bsdf
    }

    /// Checks that every texel bounds the values of its directions, for random points of these
    /// kinds. Returns the sorted ratios of each texel to the bound of its cone.
    fn texels_are_bounds<const N: usize>(
        kinds: &[Kind],
        bounded: Bounded,
        index: u64,
        points: u64,
    ) -> Vec<f64> {
        let mut quotients = Vec::new();
        for (number, kind) in kinds.iter().enumerate() {
            let mut s = Stream::new(51 + index, Purpose::Test, number as u64);
            for _ in 0..points {
                let whole = random_point(*kind, &mut s);
                let (part, channel) = match bounded {
                    Bounded::Brdf => (whole, 0),
                    // Sheen attenuates the lobe below it, and sheen counts as diffuse.
                    Bounded::LobeCosine if matches!(whole.bsdf, Bsdf::Layered(b) if b.sheen.is_there()) => {
                        continue;
                    }
                    Bounded::LobeCosine => (Reflector { bsdf: without_diffuse(whole.bsdf), ..whole }, 1),
                };
                let mut texels = [[[Texel::ZERO; N]; N]; 6];
                fill(&mut texels, &whole, bounded);
                for (k, texel) in texels.as_flattened().as_flattened().iter().enumerate() {
                    let bound = texel.value();
                    let cone = Faces::<N>::cone(k / (N * N), k / N % N, k % N);
                    let half_angle = half_angle(&cone);
                    for k in 0..8 {
                        let axis = if k % 2 == 0 { cone.axis.as_dvec3() } else { mirror(&part) };
                        let d = near(axis, half_angle, &mut s).as_vec3();
                        if cone.contains(d) {
                            let value = reflected(&part, d)[channel];
                            assert!(value <= bound, "{value:e} > {bound:e}: {d:?} in {cone:?} {part:?}");
                        }
                    }
                    let alone = [part.upper_brdf(&cone), part.upper_lobe_cos(&cone)][channel];
                    if alone > 0.0 {
                        quotients.push(f64::from(bound) / f64::from(alone));
                    }
                }
            }
        }
        quotients.sort_by(f64::total_cmp);
        quotients
    }

    /// Quantile of the sorted quotients.
    fn at(quotients: &[f64], share: f64) -> f64 {
        quotients[((quotients.len() - 1) as f64 * share) as usize]
    }

    // The limits are the measured values plus a tenth of their excess over 1. Storage in 16 bits
    // accounts for 0.2 %. The rest comes from steps of `F` and, at the borders of sharp lobes, from
    // the slack.

    #[test]
    fn texels_are_bounds_and_hardly_larger_than_those_of_single_cones() {
        // The diffuse part of the last kind falls steeply towards the horizon.
        let (others, fading) = KINDS.split_at(KINDS.len() - 1);
        assert_eq!(fading, [Kind::AshikhminShirley]);
        for (kinds, limits) in [(others, [1.003, 1.023]), (fading, [1.03, 1.26])] {
            let quotients = texels_are_bounds::<8>(kinds, Bounded::Brdf, 0, 60);
            let [median, decile] = [0.5, 0.9].map(|share| at(&quotients, share));
            assert!(median < limits[0] && decile < limits[1], "{kinds:?}: {median} {decile}");
        }
        texels_are_bounds::<16>(&KINDS, Bounded::Brdf, 1, 10);
        texels_are_bounds::<2>(&KINDS, Bounded::Brdf, 2, 100);
    }

    #[test]
    fn texels_with_the_cosine_are_bounds_and_hardly_larger_than_those_of_single_cones() {
        let quotients = texels_are_bounds::<8>(&KINDS, Bounded::LobeCosine, 3, 60);
        assert!(at(&quotients, 0.5) < 1.0065, "{}", at(&quotients, 0.5));
        assert!(at(&quotients, 0.9) < 1.11, "{}", at(&quotients, 0.9));
    }
}
