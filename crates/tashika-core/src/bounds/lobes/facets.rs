//! Upper bounds of reflection at facets, `F D G₂ / (4 c_o c_i)`, over ranges of angles and of
//! roughness.
//!
//! The factors are those of [`ggx`] and [`beckmann`]: for all models `D` is largest at a known
//! angle and roughness, `V = G₂ / (4 c_o c_i)` falls with `α`, `c_o` and `c_i`, and `V c_i` grows
//! with `c_i`.
//!
//! Ashikhmin and Shirley have `V = 1 / (4 c_d max(c_o, c_i))` with the cosine `c_d = ω_i·h` of
//! incidence, `‖ω_o + ω_i‖/2 ≥ (c_o + c_i)/2`. With `m` at least that and at most `c_d`,
//! `1 / (4 m max(c_o, c_i))` falls with all cosines; times `c_i` it grows up to `c_i = c_o`, and
//! falls from there on.
//!
//! # Brushed surfaces
//! Let `α_n ≤ α_w` be the roughnesses along the two axes. With `q = h_x²/α_u² + h_y²/α_v²`, GGX has
//! `D = 1 / (π α_n α_w (q + h_z²)²)`, Beckmann's `D = e^(−q/h_z²) / (π α_n α_w h_z⁴)`. Both fall
//! with `q`, and `q ≥ (h_x² + h_y²)/α_w²`; so
//!
//! ```text
//! D ≤ (α_w/α_n) D(α_w)      in all directions, and equal along the axis of α_w
//! V ≤ V(α_n)                since α_u² ω_x² + α_v² ω_y² ≥ α_n² sin²θ
//! ```
//!
//! where `D(α)` and `V(α)` are those of a surface of roughness `α` in all directions.
//!
//! The product of the largest factors is far above the largest product where a wide cone of lights
//! holds both the mirror direction, at which `D` is large, and grazing ones, at which `F` is large;
//! so [`upper_reflection`] multiplies them ring by ring.
//!
//! # Guarantee
//! Each function bounds its factor over the whole range, except for roundings of `f32` that are
//! relative to it.
//!
//! # Held to this by
//! The tests below, `bounds::tests::reflector`, `bounds::tests::analytic`.

use super::{beckmann, ggx};
use crate::bounds::angle::Angle;
use crate::bounds::spans::LENGTHS;
use crate::bsdf::{FacetModel, Microfacets};

/// Model of the reflection at facets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::bounds) enum FacetKind {
    /// `D` and `G₂` of a microfacet model.
    Model(FacetModel),
    /// GGX's `D`, and `V = 1 / (4 ω_i·h max(c_o, c_i))`.
    AshikhminShirley,
}

impl FacetKind {
    /// All kinds, in the order in which ranges over kinds are stored.
    pub(in crate::bounds) const ALL: [Self; 4] = [
        Self::Model(FacetModel::ALL[0]),
        Self::Model(FacetModel::ALL[1]),
        Self::Model(FacetModel::ALL[2]),
        Self::AshikhminShirley,
    ];
}

/// Tangents of the angle of the half vector, in units of the largest `α`, between which the factors
/// are bounded one by one. At these, `D` of GGX is `4`, `10²` and `10⁴` times below its peak.
/// Chosen.
const CUTS: [f64; 3] = [1.0, 3.0, 10.0];

/// Value of `c_o` below which the factors are bounded all at once: rounding may turn the half
/// vectors of nearly opposite directions anywhere.
const MIN_COS_O: f64 = 0.01;

/// Roughnesses of a set of facets of one model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::bounds) struct Widths {
    /// Least and largest of the larger roughnesses `α_w`.
    pub(in crate::bounds) widest: [f32; 2],
    /// Least of the smaller roughnesses `α_n`.
    pub(in crate::bounds) narrowest: f32,
    /// Upper bound of `α_w/α_n`.
    pub(in crate::bounds) ratio: f32,
}

impl Widths {
    /// Roughnesses of an empty set.
    pub(in crate::bounds) const NONE: Self =
        Self { widest: [f32::INFINITY, f32::NEG_INFINITY], narrowest: f32::INFINITY, ratio: 1.0 };

    /// Roughnesses of the facets of one surface.
    pub(in crate::bounds) fn of(facets: &Microfacets) -> Self {
        let (narrowest, widest) = (facets.narrowest(), facets.widest());
        let ratio = if facets.is_even() { 1.0 } else { (widest / narrowest).next_up() };
        Self { widest: [widest; 2], narrowest, ratio }
    }

    /// Tangents of the angle of the half vector at which the bound of reflection is cut in rings.
    pub(in crate::bounds) fn cuts(self) -> [f64; 3] {
        CUTS.map(|cut| cut * f64::from(self.widest[1]))
    }

    /// Ranges that hold those of both sets.
    pub(in crate::bounds) fn union(self, other: Self) -> Self {
        let ([low, high], [other_low, other_high]) = (self.widest, other.widest);
        Self {
            widest: [low.min(other_low), high.max(other_high)],
            narrowest: self.narrowest.min(other.narrowest),
            ratio: self.ratio.max(other.ratio),
        }
    }
}

/// Bounds of cosines where the half vector is within a range of angles from the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::bounds) struct Ring {
    /// Least cosine of the angle of incidence on a facet.
    pub(in crate::bounds) cos_incidence: f64,
    /// Least cosine of the angle between light and normal.
    pub(in crate::bounds) cos_light: f64,
}

/// Upper bound of `D · others` for all half vectors from `least` on.
///
/// * `distribution`: upper bound of `D` from an angle on.
/// * `cuts`: tangents of the angle of the half vector between which the factors are bounded one by
///   one, in ascending order.
/// * `viewer`: upper bound of the angle between any normal and its viewer.
/// * `all`: bounds of the cosines for all directions.
/// * `others`: upper bound of the other factors within a ring; it may grow as the ring's cosines
///   fall.
///
/// `D` is largest for facets that face the normal, where the other factors are those of the mirror
/// direction. So the range of `θ_h` is cut in rings; within one that ends at `θ`, the angle of
/// incidence is at most `θ_o + θ`, and that of the light `θ_o + 2θ`.
pub(in crate::bounds) fn upper_reflection(
    distribution: impl Fn(Angle) -> f64,
    cuts: impl IntoIterator<Item = f64>,
    mut least: Angle,
    viewer: Angle,
    all: Ring,
    others: impl Fn(Ring) -> f64,
) -> f64 {
    let mut largest = 0.0_f64;
    if viewer.cos >= MIN_COS_O {
        // ‖ω_o + ω_i‖ > c_o. Where the lengths of the two differ by ε, their sum is ε / ‖ω_o + ω_i‖
        // nearer to one of them.
        let slack = LENGTHS * (1.0 + 1.0 / viewer.cos);
        for tan in cuts {
            if least.sin >= tan * least.cos {
                continue;
            }
            let cos = 1.0 / (1.0 + tan * tan).sqrt();
            let end = Angle { sin: tan * cos, cos };
            let incidence = viewer.plus(end);
            let ring = Ring {
                cos_incidence: (incidence.cos - slack).max(all.cos_incidence),
                cos_light: (incidence.plus(end).cos - slack).max(all.cos_light),
            };
            if ring == all {
                break;
            }
            largest = largest.max(distribution(least) * others(ring));
            least = end;
        }
    }
    largest.max(distribution(least) * others(all))
}

/// Upper bound of `D` (sr⁻¹) for all roughnesses and all angles of the half vector from `least` on.
pub(in crate::bounds) fn upper_distribution(kind: FacetKind, widths: Widths, least: Angle) -> f64 {
    let alphas = widths.widest.map(f64::from);
    let even = match kind {
        FacetKind::Model(FacetModel::Beckmann) => beckmann::upper_distribution(alphas, least),
        FacetKind::Model(FacetModel::Ggx | FacetModel::GgxIndependent) | FacetKind::AshikhminShirley => {
            ggx::upper_distribution(alphas, least)
        }
    };
    even * f64::from(widths.ratio)
}

/// Range for which the visibility of facets is bounded: the least value of each quantity, except
/// that [`upper_visibility_cos`] takes the largest cosine of light.
#[derive(Clone, Copy, Debug)]
pub(in crate::bounds) struct Seen {
    /// The smaller roughness.
    pub(in crate::bounds) alpha: f64,
    /// Cosine between viewer and normal.
    pub(in crate::bounds) cos_o: f64,
    /// Cosine between light and normal.
    pub(in crate::bounds) cos_i: f64,
    /// Cosine of the angle of incidence on a facet.
    pub(in crate::bounds) cos_incidence: f64,
}

impl Seen {
    /// Upper bound of Ashikhmin and Shirley's `V`.
    fn unmasked(&self) -> f64 {
        let Self { cos_o, cos_i, cos_incidence, .. } = *self;
        0.25 / (cos_incidence.max(0.5 * (cos_o + cos_i)) * cos_o.max(cos_i))
    }
}

/// Upper bound of `V` where no quantity is below its value in `seen`.
pub(in crate::bounds) fn upper_visibility(kind: FacetKind, seen: &Seen) -> f64 {
    let Seen { alpha, cos_o, cos_i, .. } = *seen;
    match kind {
        FacetKind::Model(FacetModel::Ggx) => ggx::upper_visibility(alpha, cos_o, cos_i),
        FacetKind::Model(FacetModel::GgxIndependent) => {
            ggx::upper_visible(alpha, cos_o) * ggx::upper_visible(alpha, cos_i)
        }
        FacetKind::Model(FacetModel::Beckmann) => {
            beckmann::upper_visible(alpha, cos_o) * beckmann::upper_visible(alpha, cos_i)
        }
        FacetKind::AshikhminShirley => seen.unmasked(),
    }
}

/// Upper bound of `V c_i` for light at cosines up to `seen.cos_i`, which is above zero, where no
/// other quantity is below its value in `seen`.
pub(in crate::bounds) fn upper_visibility_cos(kind: FacetKind, seen: &Seen) -> f64 {
    match kind {
        FacetKind::Model(FacetModel::Ggx) => ggx::upper_visibility_cos(seen.alpha, seen.cos_o, seen.cos_i),
        FacetKind::AshikhminShirley => {
            let brightest = Seen { cos_i: seen.cos_i.min(seen.cos_o), ..*seen };
            brightest.unmasked() * brightest.cos_i
        }
        FacetKind::Model(_) => upper_visibility(kind, seen) * seen.cos_i,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::microfacet::HalfVector;
    use crate::math::Vec3;

    const EVERYTHING: Ring = Ring { cos_incidence: 0.0, cos_light: 0.0 };
    const UPRIGHT: HalfVector<f32> = HalfVector { tangential2: 0.0, axial2: 1.0 };

    /// Each of the pairs with each model.
    fn models_of<const N: usize>(alphas: [[f64; 2]; N]) -> impl Iterator<Item = (FacetModel, [f64; 2])> {
        FacetModel::ALL.into_iter().flat_map(move |model| alphas.map(|alphas| (model, alphas)))
    }

    fn distribution(model: FacetModel, half: HalfVector<f32>, alpha: f32) -> f64 {
        let facets = Microfacets::even(alpha, model);
        // Seen from the normal nothing is masked.
        4.0 * f64::from(facets.reflection(half, Vec3::Z, [0.0, 0.0, 1.0]))
    }

    fn visibility(model: FacetModel, cos_o: f32, cos_i: f32, alpha: f32) -> f64 {
        let wo = Vec3::new(0.0, 0.0, cos_o);
        let all = Microfacets::even(alpha, model).reflection(UPRIGHT, wo, [0.0, 0.0, cos_i]);
        f64::from(all) / distribution(model, UPRIGHT, alpha)
    }

    fn seen(alpha: f64, cos_o: f64, cos_i: f64) -> Seen {
        Seen { alpha, cos_o, cos_i, cos_incidence: 0.0 }
    }

    /// `[low, high]` in steps of equal ratio.
    fn between([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
        (0..=200).map(move |i| low * (high / low).powf(f64::from(i) / 200.0))
    }

    /// The bound uses the least angle and the roughness of largest `D`: steps of 5 % miss less than
    /// `(1 + 0.05²)²` of it.
    #[test]
    fn ranges_of_roughness_hold_and_are_tight() {
        let of = |model, alphas: [f64; 2], least: Angle| {
            let widths = Widths { widest: alphas.map(|a| a as f32), narrowest: alphas[0] as f32, ratio: 1.0 };
            let distribution = |least| upper_distribution(FacetKind::Model(model), widths, least);
            upper_reflection(distribution, widths.cuts(), least, Angle::ZERO, EVERYTHING, |_| 1.0)
        };
        for (model, alphas) in models_of([[1e-3, 1e-3], [1e-3, 1e-2], [0.05, 0.4], [1e-3, 1.0], [1.0, 1.0]]) {
            for tan in [0.0, 1e-4, 1e-3, 3e-3, 0.03, 0.2, 0.9, 4.0, 100.0] {
                let cos = 1.0 / f64::sqrt(1.0 + tan * tan);
                let bound = of(model, alphas, Angle { sin: tan * cos, cos });
                let mut largest = 0.0_f64;
                for alpha in between(alphas) {
                    // Beckmann's `D` of a roughness near 1 is largest off the normal.
                    let widest = (2.0 * alpha * alpha - 1.0).max(0.0) / (tan * tan).max(1e-12);
                    for wider in [1.0, 1.01, 1.5, 10.0, widest.max(1.0)] {
                        let half =
                            HalfVector { tangential2: ((tan * tan).max(1e-12) * wider) as f32, axial2: 1.0 };
                        let value = distribution(model, half, alpha as f32);
                        assert!(
                            value <= bound * (1.0 + 1e-6),
                            "{model:?} {alphas:?} tan {tan}: {value} above {bound}"
                        );
                        largest = largest.max(value);
                    }
                }
                assert!(
                    bound < largest * 1.006 + 1e-30,
                    "{model:?} {alphas:?} tan {tan}: {bound} for {largest}"
                );
            }
        }
    }

    /// Products of `D` with a steep function of the angle of incidence, against all angles of the
    /// half vector beyond the least.
    #[test]
    fn rings_hold() {
        let angle = |radians: f64| Angle { sin: radians.sin(), cos: radians.cos() };
        for (model, [alpha, _]) in models_of([1e-3, 0.02, 0.1, 0.5, 1.0].map(|alpha| [alpha; 2])) {
            for viewer in [0.0, 0.3, 1.0, 1.5, 1.565] {
                for least in [0.0, 0.5, 2.0, 5.0, 20.0].map(|k| f64::atan(k * alpha)) {
                    for steep in [1.0, 5.0, 60.0] {
                        let widest = (viewer + std::f64::consts::FRAC_PI_2) / 2.0;
                        let others = |incidence: f64| 1e-6 + (1.0 - incidence.cos()).powf(steep);
                        let all = Ring { cos_incidence: widest.cos(), cos_light: 1.0 };
                        let widths = Widths::of(&Microfacets::even(alpha as f32, model));
                        let upper = |least| upper_distribution(FacetKind::Model(model), widths, least);
                        let others_within = |ring: Ring| others(ring.cos_incidence.acos());
                        let [least_angle, viewer_angle] = [least, viewer].map(angle);
                        let bound = upper_reflection(
                            upper,
                            widths.cuts(),
                            least_angle,
                            viewer_angle,
                            all,
                            others_within,
                        );
                        let mut largest = 0.0_f64;
                        for step in 0..=2000 {
                            let half = least + (1.57 - least) * (f64::from(step) / 2000.0).powi(3);
                            let half_vector =
                                HalfVector { tangential2: half.tan().powi(2) as f32, axial2: 1.0 };
                            let d = distribution(model, half_vector, alpha as f32) * (1.0 - 1e-5);
                            largest = largest.max(d * others((viewer + half).min(widest)));
                        }
                        assert!(
                            largest <= bound,
                            "{model:?} {alpha} {viewer} {least} {steep}: {largest} above {bound}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn visibilities_are_bounded_by_the_ends_that_are_named() {
        let values = [1e-4_f64, 1e-3, 0.03, 0.2, 0.7, 1.0];
        for (model, [_, alpha]) in models_of([1e-3_f64, 0.03, 0.2, 0.7, 1.0].map(|alpha| [alpha; 2])) {
            for cos_o in values {
                for cos_i in values {
                    let value = visibility(model, cos_o as f32, cos_i as f32, alpha as f32);
                    for (a, o, i) in [(1.0, 1.0, 1.0), (0.5, 1.0, 1.0), (1.0, 0.5, 1.0), (1.0, 1.0, 0.5)] {
                        let bound =
                            upper_visibility(FacetKind::Model(model), &seen(alpha * a, cos_o * o, cos_i * i));
                        assert!(value <= bound * (1.0 + 1e-6));
                        let bound = upper_visibility_cos(
                            FacetKind::Model(model),
                            &seen(alpha * a, cos_o * o, cos_i / i),
                        );
                        assert!(value * cos_i <= bound * (1.0 + 1e-6));
                    }
                    assert!(
                        value * (1.0 + 1e-6)
                            >= upper_visibility(FacetKind::Model(model), &seen(alpha, cos_o, cos_i))
                    );
                    assert!(
                        value * cos_i * (1.0 + 1e-6)
                            >= upper_visibility_cos(FacetKind::Model(model), &seen(alpha, cos_o, cos_i))
                    );
                }
            }
        }
    }

    /// Ashikhmin and Shirley's visibility, over all azimuths: the bounds hold, and a single
    /// direction reaches them.
    #[test]
    fn unmasked_visibilities_are_bounded_by_the_ends_that_are_named() {
        const KIND: FacetKind = FacetKind::AshikhminShirley;
        let values = [1e-4_f64, 1e-3, 0.03, 0.2, 0.7, 1.0];
        let sine = |cos: f64| (1.0 - cos * cos).sqrt();
        for (cos_o, cos_i) in values.into_iter().flat_map(|o| values.map(|i| (o, i))) {
            for step in 0..=40 {
                let azimuth = std::f64::consts::PI * f64::from(step) / 40.0;
                let along = cos_o * cos_i + sine(cos_o) * sine(cos_i) * azimuth.cos();
                let cos_d = (0.5 + 0.5 * along).max(0.0).sqrt();
                let value = 0.25 / (cos_d * cos_o.max(cos_i));
                for (o, i, d) in [(1.0, 1.0, 1.0), (0.5, 1.0, 1.0), (1.0, 0.5, 0.9), (0.1, 0.1, 0.0)] {
                    let at = |cos_i: f64| Seen { cos_incidence: cos_d * d, ..seen(1.0, cos_o * o, cos_i) };
                    let bound = upper_visibility(KIND, &at(cos_i * i));
                    assert!(value <= bound * (1.0 + 1e-6), "{cos_o} {cos_i} {o} {i}");
                    let bound = upper_visibility_cos(KIND, &at((cos_i / i).min(1.0)));
                    assert!(value * cos_i <= bound * (1.0 + 1e-6), "{cos_o} {cos_i} {o} {i}");
                }
                let one = Seen { cos_incidence: cos_d, ..seen(1.0, cos_o, cos_i) };
                assert!(value * (1.0 + 1e-6) >= upper_visibility(KIND, &one));
                assert!(cos_i > cos_o || value * cos_i * (1.0 + 1e-6) >= upper_visibility_cos(KIND, &one));
            }
        }
    }
}
