//! Upper bounds of reflection at facets, `F D G₂ / (4 c_o c_i)`, over ranges of angles and of
//! roughness.
//!
//! The factors are those of [`ggx`] and [`beckmann`]. For all models the angle and the roughness at
//! which `D` is largest are known, `V = G₂ / (4 c_o c_i)` falls with `α`, `c_o` and `c_i`, and
//! `V c_i` grows with `c_i`.
//!
//! Ashikhmin and Shirley use `V = 1 / (4 c_d max(c_o, c_i))`, where `c_d = ω_i·h` is the cosine of
//! incidence and `c_d = ‖ω_o + ω_i‖/2 ≥ (c_o + c_i)/2`. Let `m` be any number between
//! `(c_o + c_i)/2` and `c_d`. Then `1 / (4 m max(c_o, c_i))` falls with all cosines. Its product
//! with `c_i` grows up to `c_i = c_o` and falls beyond.
//!
//! # Brushed surfaces
//! Let `α_n ≤ α_w` be the roughnesses along the two axes and `q = h_x²/α_u² + h_y²/α_v²`. The
//! distribution of GGX is `D = 1 / (π α_n α_w (q + h_z²)²)`, that of Beckmann
//! `D = e^(−q/h_z²) / (π α_n α_w h_z⁴)`. Both fall with `q`, and `q ≥ (h_x² + h_y²)/α_w²`.
//! Therefore
//!
//! ```text
//! D ≤ (α_w/α_n) D(α_w)      in all directions, and equal along the axis of α_w
//! V ≤ V(α_n)                since α_u² ω_x² + α_v² ω_y² ≥ α_n² sin²θ
//! ```
//!
//! where `D(α)` and `V(α)` are those of a surface with roughness `α` in all directions.
//!
//! A wide cone of lights can contain both the mirror direction, at which `D` is large, and grazing
//! directions, at which `F` is large. The product of the separate maxima is then far above the
//! maximum of the product. Therefore [`upper_reflection`] multiplies the factors ring by ring.
//!
//! # Guarantee
//! Each function bounds its factor over the whole range, up to relative roundings of `f32`.
//!
//! # Held to this by
//! The tests below, `bounds::tests::reflector`, `bounds::tests::analytic`.

use super::{beckmann, ggx};
use crate::bounds::angle::Angle;
use crate::bounds::spans::LENGTHS;
use crate::bsdf::{FacetModel, Microfacets};

/// Model of reflection at facets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::bounds) enum FacetKind {
    /// `D` and `G₂` of a microfacet model.
    Model(FacetModel),
    /// GGX's `D`, and `V = 1 / (4 ω_i·h max(c_o, c_i))`.
    AshikhminShirley,
}

impl FacetKind {
    /// All kinds, in the order in which ranges by kind are stored.
    pub(in crate::bounds) const ALL: [Self; 4] = [
        Self::Model(FacetModel::ALL[0]),
        Self::Model(FacetModel::ALL[1]),
        Self::Model(FacetModel::ALL[2]),
        Self::AshikhminShirley,
    ];
}

/// Tangents of the angle between half vector and normal, in units of the largest `α`, that separate
/// the rings in which factors are bounded one by one. At these tangents, `D` of GGX is `4`, `10²`
/// and `10⁴` times below its peak. Chosen.
const CUTS: [f64; 3] = [1.0, 3.0, 10.0];

/// For `c_o` below this value the factors are bounded without rings: the half vectors of nearly
/// opposite directions may point anywhere because of rounding.
const MIN_COS_O: f64 = 0.01;

/// Roughnesses of a set of facets of one model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::bounds) struct Widths {
    /// Least and largest value of the larger roughness `α_w`.
    pub(in crate::bounds) widest: [f32; 2],
    /// Least value of the smaller roughness `α_n`.
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

    /// Tangents of the angles between half vector and normal at which the range is divided into
    /// rings.
    pub(in crate::bounds) fn cuts(self) -> [f64; 3] {
        CUTS.map(|cut| cut * f64::from(self.widest[1]))
    }

    /// Ranges that contain those of both sets.
    pub(in crate::bounds) fn union(self, other: Self) -> Self {
        let ([low, high], [other_low, other_high]) = (self.widest, other.widest);
        Self {
            widest: [low.min(other_low), high.max(other_high)],
            narrowest: self.narrowest.min(other.narrowest),
            ratio: self.ratio.max(other.ratio),
        }
    }
}

/// Bounds of cosines for half vectors in a range of angles from the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::bounds) struct Ring {
    /// Least cosine of the angle of incidence on a facet.
    pub(in crate::bounds) cos_incidence: f64,
    /// Least cosine of the angle between light and normal.
    pub(in crate::bounds) cos_light: f64,
}

/// Upper bound of `D · others` for all half vectors at an angle of at least `least` from the
/// normal.
///
/// * `distribution`: upper bound of `D` for half vectors at an angle of at least its argument.
/// * `cuts`: tangents of the angles between half vector and normal that separate the rings, in
///   ascending order.
/// * `viewer`: upper bound of the angle between any normal and its viewer.
/// * `all`: bounds of the cosines for all directions.
/// * `others`: upper bound of the product of the other factors within a ring. It must not grow with
///   the ring's cosines.
///
/// `D` is largest if the half vector is the normal; the other factors are then those of the mirror
/// direction. The range of `θ_h` is therefore divided into rings. In a ring that ends at `θ`, the
/// angle of incidence is at most `θ_o + θ`, and the angle between light and normal at most
/// `θ_o + 2θ`.
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
        // ‖ω_o + ω_i‖ > c_o. If the lengths of the two vectors differ by ε, their sum is rotated by
        // ε / ‖ω_o + ω_i‖ towards the longer one.
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

/// Upper bound of `D` (sr⁻¹) for all roughnesses and all half vectors at an angle of at least
/// `least`.
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

/// Bounds of the quantities that the visibility of facets depends on. Each is the least value,
/// except that [`upper_visibility_cos`] expects the largest cosine of light in `cos_i`.
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

/// Upper bound of `V` if every quantity is at least its value in `seen`.
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

/// Upper bound of `V c_i` for light at cosines of at most `seen.cos_i`, which must be positive, if
/// every other quantity is at least its value in `seen`.
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

    /// All combinations of a model and a pair.
    fn models_of<const N: usize>(alphas: [[f64; 2]; N]) -> impl Iterator<Item = (FacetModel, [f64; 2])> {
        FacetModel::ALL.into_iter().flat_map(move |model| alphas.map(|alphas| (model, alphas)))
    }

    fn distribution(model: FacetModel, half: HalfVector<f32>, alpha: f32) -> f64 {
        let facets = Microfacets::even(alpha, model);
        // Seen along the normal, no facet is masked.
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

    /// Values of `[low, high]` in steps of equal ratio.
    fn between([low, high]: [f64; 2]) -> impl Iterator<Item = f64> {
        (0..=200).map(move |i| low * (high / low).powf(f64::from(i) / 200.0))
    }

    /// Compares the bound of a range with roughnesses in steps of equal ratio. The bound uses the
    /// least angle and the roughness of largest `D`; steps of 5 % miss less than `(1 + 0.05²)²` of
    /// it.
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
                    // For Beckmann facets of roughness near 1, `D` is largest off the normal.
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

    /// `D` is multiplied by a steep function of the angle of incidence. The bound holds for all
    /// half vectors beyond the least angle.
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

    /// Ashikhmin and Shirley's visibility, over all azimuths. The bounds hold, and a single
    /// direction attains them.
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
