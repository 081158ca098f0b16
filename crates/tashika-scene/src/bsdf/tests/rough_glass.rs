//! Rough glass compared with the formulas of Walter et al. 2007, by quadrature.

use glam::DVec3;

use super::super::{FacetModel, Glass, Lobe, Microfacets, Model};
use super::quadrature::PolarGrid;
use super::{outgoing, stream};
use crate::color::Rgb;
use crate::math::Vec3;

const IOR: f32 = 1.5;
/// Roughness along the two axes.
const ALPHA: [f32; 2] = [0.4, 0.2];

fn rough(model: FacetModel) -> Glass {
    let facets = Some(Microfacets { alpha: ALPHA, model });
    Glass { ior: IOR, reflectance: Rgb::WHITE, transmittance: Rgb::WHITE, facets }
}

/// `D(h)` and `G₂(o, i)` for unit directions, `h` above the surface.
fn facets(model: FacetModel, h: DVec3, o: DVec3, i: DVec3) -> (f64, f64) {
    let [u, v] = ALPHA.map(f64::from);
    let slope = (h.x * h.x / (u * u) + h.y * h.y / (v * v)) / (h.z * h.z);
    let normalised = std::f64::consts::PI * u * v * h.z.powi(4);
    let ggx = 1.0 / (normalised * (1.0 + slope).powi(2));
    let seen = |w: DVec3| (w.x * w.x * u * u + w.y * w.y * v * v) / (w.z * w.z);
    let lambda = |w: DVec3| ((1.0 + seen(w)).sqrt() - 1.0) / 2.0;
    match model {
        FacetModel::Ggx => (ggx, 1.0 / (1.0 + lambda(o) + lambda(i))),
        FacetModel::GgxIndependent => (ggx, 1.0 / ((1.0 + lambda(o)) * (1.0 + lambda(i)))),
        FacetModel::Beckmann => {
            let d = (-slope).exp() / normalised;
            let g1 = |w: DVec3| {
                let a = 1.0 / seen(w).sqrt();
                let lambda = 0.5
                    * ((-a * a).exp() / (a * std::f64::consts::PI.sqrt()) - crate::math::elementary::erfc(a));
                1.0 / (1.0 + lambda)
            };
            (d, g1(o) * g1(i))
        }
    }
}

fn fresnel(cos: f64, eta: f64) -> f64 {
    let sin2 = (1.0 - cos * cos) / (eta * eta);
    if sin2 >= 1.0 {
        return 1.0;
    }
    let cos_t = (1.0 - sin2).sqrt();
    let s = (cos - eta * cos_t) / (cos + eta * cos_t);
    let p = (eta * cos - cos_t) / (eta * cos + cos_t);
    (s * s + p * p) / 2.0
}

/// Equations 20 and 21 times the cosine of `i`: light from the direction `o` is scattered to `i`.
/// The medium on the side of `o` has the index 1, the other one `eta`.
fn scattered(model: FacetModel, o: DVec3, i: DVec3, eta: f64) -> f64 {
    let (cos_o, cos_i) = (o.z.abs(), i.z.abs());
    if cos_i < 1e-9 {
        return 0.0;
    }
    let up = o.z.signum();
    if o.z * i.z > 0.0 {
        let h = (o + i).normalize();
        let (d, g) = facets(model, h * up, o, i);
        return fresnel(o.dot(h), eta) * d * g / (4.0 * cos_o);
    }
    let mut h = -(o + i * eta).normalize();
    if h.z * up < 0.0 {
        h = -h;
    }
    let (o_h, i_h) = (o.dot(h), i.dot(h));
    if o_h <= 0.0 || i_h >= 0.0 {
        return 0.0;
    }
    let (d, g) = facets(model, h * up, o, i);
    let passed = eta * eta * (1.0 - fresnel(o_h, eta)) * d * g / (o_h + eta * i_h).powi(2);
    o_h * -i_h / cos_o * passed
}

/// For reflection and for refraction, the scattered flux and its mean direction agree with
/// quadrature of Walter's formulas, to within 5 standard errors in 144 comparisons.
#[test]
fn flux_goes_where_facets_send_it() {
    const DRAWS: u32 = 100_000;
    let grid = PolarGrid::about(Vec3::Z, 1e9, 24, 24);
    for (number, model) in FacetModel::ALL.into_iter().enumerate() {
        for (k, cos) in [0.9, 0.5, 0.15].into_iter().enumerate() {
            for side in [1.0_f32, -1.0] {
                let wo = outgoing(cos) * Vec3::new(1.0, 1.0, side);
                let glass = rough(model);
                let mut s = stream(7000 + (number * 6 + k * 2) as u64 + u64::from(side < 0.0));
                let mut sums = [[[0.0_f64; 2]; 4]; 2];
                for _ in 0..DRAWS {
                    let Some(sample) = glass.sample(wo, s.uniform_3()) else { continue };
                    let way = usize::from(sample.lobe == Lobe::SpecularTransmission);
                    assert_eq!(sample.wi.z * wo.z < 0.0, way == 1);
                    let weight = f64::from(sample.weight.g);
                    let values = [1.0, sample.wi.x, sample.wi.y, sample.wi.z].map(f64::from);
                    for (sum, value) in sums[way].iter_mut().zip(values) {
                        sum[0] += weight * value / f64::from(DRAWS);
                        sum[1] += (weight * value).powi(2) / f64::from(DRAWS);
                    }
                }
                let eta = f64::from(if side > 0.0 { IOR } else { 1.0 / IOR });
                for (way, sums) in sums.iter().enumerate() {
                    for (moment, [mean, square]) in sums.iter().enumerate() {
                        let expected = grid.integrate(1e-7, &|wi| {
                            if (wi.z * wo.z < 0.0) != (way == 1) {
                                return 0.0;
                            }
                            let value = [1.0, wi.x, wi.y, wi.z].map(f64::from)[moment];
                            value * scattered(model, wo.as_dvec3(), wi.as_dvec3(), eta)
                        });
                        let error = 5.0 * ((square - mean * mean).max(0.0) / f64::from(DRAWS)).sqrt() + 1e-4;
                        assert!(
                            (mean - expected).abs() < error,
                            "{model:?} {cos} {side} way {way} moment {moment}: {mean} for {expected} ± {error}"
                        );
                    }
                }
            }
        }
    }
}

/// With the same random numbers, glass of the smallest roughness draws nearly the same directions
/// as smooth glass.
#[test]
fn hardly_rough_glass_is_nearly_smooth() {
    let mut s = stream(7100);
    let rough = Glass { facets: Some(Microfacets::ggx(1e-3)), ..rough(FacetModel::Ggx) };
    let smooth = Glass { facets: None, ..rough };
    for side in [1.0, -1.0] {
        let wo = outgoing(0.8) * Vec3::new(1.0, 1.0, side);
        let mut far = 0;
        for _ in 0..1000 {
            let u = s.uniform_3();
            let (a, b) = (rough.sample(wo, u).unwrap(), smooth.sample(wo, u).unwrap());
            far += u32::from(a.lobe != b.lobe || (a.wi - b.wi).length() > 0.02);
        }
        assert!(far < 30, "{far}");
    }
}
