//! Tests of the bounds of single points over single cones.

use super::cases::*;
use super::many;
use crate::bounds::Reflector;
use crate::bsdf::{
    AshikhminShirley, Bsdf, CoatModel, Coated, FacetModel, Lambert, Layered, MIN_COSINE, MetallicRoughness,
    Microfacets, Mirror, Phong, Plastic, Principled, TintedFresnel, UnderLayers,
};
use crate::color::Rgb;
use crate::math::{Cone, Vec3};
use crate::rng::{Purpose, Stream};

/// A cone of lights, either random or near the mirror direction of the point, where its lobe is.
fn cone(point: &Reflector, s: &mut Stream) -> Cone {
    let wide = log_uniform(s, 1e-4, 3.2);
    let axis = match s.below(4) {
        0 => near(glam::DVec3::Z, 3.2, s),
        1 => near(mirror(point), f64::from(wide), s),
        2 => near(mirror(point), 3.0 * f64::from(wide), s),
        _ => near(point.frame.n.as_dvec3() * f64::from(point.wo.z.signum()), 1.6, s),
    };
    let cos = (f64::from(wide)).cos() as f32;
    Cone { axis: axis.as_vec3(), cos }
}

/// Searches the cone for the largest value of each quantity: at random directions, near the mirror
/// direction, and then by hill climbing.
fn climb(point: &Reflector, cone: &Cone, s: &mut Stream, mut look: impl FnMut([f32; 2])) -> [f32; 2] {
    let mut largest = [0.0_f32; 2];
    let mut best = [into_cone(cone, mirror(point)); 2];
    let wide = half_angle(cone).max(1e-7);
    for round in 0..160_i32 {
        let k = (round % 2) as usize;
        let d = match round {
            0..2 => best[k],
            2..40 => into_cone(cone, near(cone.axis.as_dvec3(), wide * 1.5, s)),
            40..60 => into_cone(cone, near(mirror(point), wide.min(0.3), s)),
            _ => {
                let reach = wide.min(1.0) * 0.5_f64.powi((round - 60) / 6);
                into_cone(cone, near(best[k], reach, s))
            }
        };
        let values = reflected(point, d.as_vec3());
        look(values);
        for k in 0..2 {
            if values[k] > largest[k] {
                (largest[k], best[k]) = (values[k], d);
            }
        }
    }
    largest
}

/// Compares bounds with the largest of 160 values each, for 3000 points of each kind, with
/// parameters and angles up to the ends of their ranges.
///
/// The limits are the measured median and ninth decile of the ratio plus a tenth. Larger ratios
/// come from cones of which only a sliver is above the horizon, and from smooth lobes at the edge
/// of a cone.
#[test]
fn bounds_hold_and_are_tight() {
    for (index, kind) in KINDS.into_iter().enumerate() {
        let mut s = Stream::new(31, Purpose::Test, index as u64);
        let mut ratios = [Vec::new(), Vec::new()];
        for round in 0..many(3000) {
            let point = random_point(kind, &mut s);
            let cone = cone(&point, &mut s);
            let bounds = [point.upper_brdf(&cone), point.upper_brdf_cos(&cone)];
            assert!(bounds.iter().all(|b| b.is_finite() && *b >= 0.0), "{bounds:?} {point:?} {cone:?}");
            let largest = climb(&point, &cone, &mut s, |values| {
                for (value, bound) in values.iter().zip(bounds) {
                    assert!(*value <= bound, "round {round}: {values:?} above {bounds:?} {point:?} {cone:?}");
                }
            });
            for (ratios, (bound, largest)) in ratios.iter_mut().zip(bounds.into_iter().zip(largest)) {
                if largest > 0.0 {
                    ratios.push(f64::from(bound) / f64::from(largest));
                }
            }
        }
        let limits = match kind {
            // The diffuse part and the sheen are bounded over many directions at once.
            Kind::Principled => [[1.42, 3.8], [1.42, 3.8]],
            // For a third of the coats the base is principled.
            Kind::Clearcoat => [[1.14, 2.7], [1.12, 2.4]],
            _ => [[1.3, 3.3], [1.2, 2.1]],
        };
        for (mut ratios, limits) in ratios.into_iter().zip(limits) {
            let (median, decile) = (quantile(&mut ratios, 0.5), quantile(&mut ratios, 0.9));
            assert!(
                ratios.len() > 2000 && median < limits[0] && decile < limits[1],
                "{kind:?}: {median} {decile}"
            );
        }
    }
}

/// Light transmitted by facets, and sheen, are within their bounds, and most values are close to
/// them.
#[test]
fn what_passes_and_sheen_are_bounded() {
    for (kind, limit) in [(Kind::Passed, 1.3), (Kind::Sheen, 2.0)] {
        let mut s = Stream::new(31, Purpose::Test, 90);
        let mut ratios = Vec::new();
        for _ in 0..many(3000) {
            let point = random_point(kind, &mut s);
            let cone = cone(&point, &mut s);
            let bounds = [point.upper_brdf(&cone), point.upper_brdf_cos(&cone)];
            let largest = climb(&point, &cone, &mut s, |values| {
                for (value, bound) in values.iter().zip(bounds) {
                    assert!(*value <= bound, "{values:?} above {bounds:?} {point:?} {cone:?}");
                }
            });
            if largest[1] > 0.0 {
                ratios.push(f64::from(bounds[1]) / f64::from(largest[1]));
            }
        }
        let median = quantile(&mut ratios, 0.5);
        assert!(ratios.len() > 2000 && median < limit, "{kind:?}: {median}");
    }
}

/// The BSDF without colours. Bounds take the largest channel of each part, which may differ between
/// parts.
fn gray(bsdf: Bsdf) -> Bsdf {
    let gray = |c: Rgb| Rgb::gray(c.g);
    match bsdf {
        Bsdf::Phong(b) => Bsdf::Phong(Phong { diffuse: gray(b.diffuse), specular: gray(b.specular), ..b }),
        Bsdf::Plastic(b) => {
            Bsdf::Plastic(Plastic { diffuse: gray(b.diffuse), specular: gray(b.specular), ..b })
        }
        Bsdf::Coated(b) => {
            Bsdf::Coated(Coated { reflectance: gray(b.reflectance), specular: gray(b.specular), ..b })
        }
        Bsdf::MetallicRoughness(b) => {
            let (f0, dielectric_f0) = (gray(b.f0), gray(b.dielectric_f0));
            Bsdf::MetallicRoughness(MetallicRoughness { diffuse: gray(b.diffuse), f0, dielectric_f0, ..b })
        }
        Bsdf::AshikhminShirley(b) => {
            Bsdf::AshikhminShirley(AshikhminShirley { diffuse: gray(b.diffuse), f0: gray(b.f0), ..b })
        }
        // The diffuse part and the sheen are bounded over many directions at once and have a
        // separate test.
        Bsdf::Principled(b) => {
            let fresnel = TintedFresnel { f0: gray(b.fresnel.f0), ..b.fresnel };
            Bsdf::Principled(Principled { diffuse: Rgb::BLACK, sheen: Rgb::BLACK, fresnel, ..b })
        }
        // The base has a separate test.
        Bsdf::Layered(b) => {
            let base = UnderLayers::Lambert(Lambert { reflectance: Rgb::gray(0.3) });
            Bsdf::Layered(Layered { base, ..b })
        }
        _ => bsdf,
    }
}

/// The bound for a single direction is its value, except for `TURN` and `LENGTHS` of 3·10⁻⁶ each.
///
/// `ln D` changes by at most `2/α` per unit of `tan θ_h`, and the two constants together rotate the
/// half vector by `6·10⁻⁶ / 2 ω_o·h`. Where Phong lobes are above `e⁻⁸`, they change by
/// `n tan α ≤ √(16 n)` per unit of the angle. `1/c` changes by `1/c²` relative to its value. With
/// `α ≥ 0.05`, cosines above 0.1 and `n ≤ 10⁴` all this is below 2·10⁻³ together. Beckmann lobes
/// fall faster, and those with `α` above `√½` are largest off the normal. The reflectance of metals
/// is replaced by `R_s`. That of dielectrics with an index above `2 + √3` is replaced by the value
/// at normal incidence, if that is larger.
#[test]
fn single_directions_have_nearly_their_value() {
    for (index, kind) in KINDS.into_iter().enumerate().filter(|(_, kind)| *kind != Kind::Metal) {
        let mut s = Stream::new(35, Purpose::Test, index as u64);
        let mut compared = 0;
        while compared < 2000 {
            let mut point = random_point(kind, &mut s);
            point.bsdf = gray(point.bsdf);
            let d = near(mirror(&point), 0.3, &mut s).as_vec3().normalize();
            let (n, values) = (point.normal(), reflected(&point, d));
            let is_off = |facets: Microfacets| {
                let clear = if facets.model == FacetModel::Beckmann { 0.1..0.7 } else { 0.05..2.0 };
                !clear.contains(&facets.mean())
            };
            let is_left_out = match point.bsdf {
                Bsdf::Phong(b) => b.exponent > 1e4,
                Bsdf::Plastic(b) => is_off(b.facets) || !(1.1..3.7).contains(&b.ior),
                Bsdf::Coated(b) => is_off(b.facets) || !(1.1..3.7).contains(&b.ior),
                Bsdf::Conductor(b) => is_off(b.facets),
                Bsdf::MetallicRoughness(b) => is_off(b.facets),
                Bsdf::AshikhminShirley(b) => is_off(b.facets),
                Bsdf::Principled(b) => is_off(b.facets) || !(1.1..3.7).contains(&b.fresnel.ior),
                // Without the cosine, the factor `c_i v(c_i)` of Mitsuba's coats is replaced by its
                // bound ½.
                Bsdf::Layered(b) => b.coat.alpha < 0.05 || b.coat.model == CoatModel::Mitsuba,
                _ => false,
            };
            if is_left_out || point.wo.z.abs() < 0.1 || n.dot(d) < 0.1 || values[0] <= 0.0 {
                continue;
            }
            compared += 1;
            let bounds = [point.upper_brdf(&Cone::of(d)), point.upper_brdf_cos(&Cone::of(d))];
            let limit = match kind {
                // The bound of the diffuse part uses `1 − F` at normal incidence.
                Kind::MetallicRoughness => 1.5,
                // The bound of the transmittance of a rough boundary is over an eighth of the range
                // of cosines. Height-correlated facets transmit up to a fifth more at grazing
                // angles.
                Kind::Coated => 1.25,
                // Beckmann: `ln D` changes by up to `2 √80 / α`, and `α ≥ 0.1`.
                _ => 1.006,
            };
            for (value, bound) in values.into_iter().zip(bounds) {
                assert!(value <= bound && bound <= limit * value, "{value} {bound} {point:?} {d}");
            }
        }
    }
}

#[test]
fn what_is_certainly_dark_is_zero() {
    let mut s = Stream::new(36, Purpose::Test, 0);
    for kind in KINDS {
        for _ in 0..200 {
            let mut point = random_point(kind, &mut s);
            let zero = |point: &Reflector, cone: Cone| {
                assert_eq!(
                    [point.upper_brdf(&cone), point.upper_brdf_cos(&cone)],
                    [0.0; 2],
                    "{point:?} {cone:?}"
                );
            };
            let cos = s.uniform();
            let sin = (1.0 - cos * cos).sqrt();
            zero(&point, Cone { axis: -point.normal(), cos: (cos + 1e-5).min(1.0) });
            zero(&point, Cone { axis: -point.geometric_normal, cos: (cos + 1e-5).min(1.0) });
            // The axis is as far below the horizon as the cone is wide.
            let across = point.frame.t * sin - point.normal() * cos;
            zero(&point, Cone { axis: across, cos: (sin + 1e-5).min(1.0) });
            zero(&point, Cone::EMPTY);
            // Beckmann lobes are zero far from their peak, and the peak may be below the horizon of
            // a tilted normal.
            let brightest = point.upper_over_all();
            assert!(brightest.diffuse + brightest.lobe_cos + brightest.coat_cos > 0.0);
            point.wo = Vec3::new(1.0, 0.0, 0.5 * MIN_COSINE);
            zero(&point, Cone::ALL);
        }
    }
    let mut point = random_point(Kind::Lambert, &mut s);
    point.bsdf = Bsdf::Mirror(Mirror { reflectance: Rgb::WHITE });
    assert_eq!(point.upper_brdf(&Cone::ALL), 0.0);
}
