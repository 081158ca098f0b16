//! For random pairs of directions, every model agrees with its formula as printed in the sources,
//! evaluated in `f64`.
//!
//! The formulas here share no code with the library: a normalised half vector, `D` in `cos θ_h`,
//! `G₂` from `Λ`, the Fresnel equations with Snell's angles, and `F_int` by quadrature.

use std::f64::consts::PI;

use glam::DVec3;

use super::super::boundary::Boundary;
use super::super::{
    Bsdf, CoatModel, Coated, ConductorFresnel, FacetModel, Layered, MetallicRoughness, Microfacets, Phong,
};
use super::cases::{self, Case};
use super::{direction_above, stream};
use crate::math::Vec3;

/// A pair of directions above the horizon, with the quantities of the formulas.
struct Pair {
    /// Both directions, and the half vector.
    o: DVec3,
    i: DVec3,
    h: DVec3,
    cos_o: f64,
    cos_i: f64,
    /// Cosine between the mirror direction of `o` and `i`.
    cos_mirror: f64,
    cos_h: f64,
    /// Cosine between `o` and the half vector.
    cos_d: f64,
}

impl Pair {
    fn new(wo: Vec3, wi: Vec3) -> Self {
        let (o, i) = (wo.as_dvec3().normalize(), wi.as_dvec3().normalize());
        let h = (o + i).normalize();
        let mirror = DVec3::new(-o.x, -o.y, o.z);
        Self { o, i, h, cos_o: o.z, cos_i: i.z, cos_mirror: mirror.dot(i), cos_h: h.z, cos_d: o.dot(h) }
    }

    /// Distribution `D` of brushed GGX facets (Heitz 2014, section 5).
    fn distribution(&self, Microfacets { alpha, .. }: Microfacets) -> f64 {
        let [u, v] = alpha.map(f64::from);
        let h = self.h;
        let slope = (h.x * h.x / (u * u) + h.y * h.y / (v * v)) / (h.z * h.z);
        1.0 / (PI * u * v * self.cos_h.powi(4) * (1.0 + slope).powi(2))
    }

    /// Facet term `D G₂ / (4 c_o c_i)` for brushed facets (Heitz 2014, section 5).
    fn facets(&self, Microfacets { alpha, model }: Microfacets) -> f64 {
        let [u, v] = alpha.map(f64::from);
        // `tan²θ (cos²φ/α_u² + sin²φ/α_v²)`, and `α² tan²θ` with the roughness `α` along the
        // direction's azimuth.
        let slope = |w: DVec3| (w.x * w.x / (u * u) + w.y * w.y / (v * v)) / (w.z * w.z);
        let seen = |w: DVec3| (w.x * w.x * u * u + w.y * w.y * v * v) / (w.z * w.z);
        let ggx = || self.distribution(Microfacets { alpha, model });
        let lambda = |w: DVec3| ((1.0 + seen(w)).sqrt() - 1.0) / 2.0;
        let (of_o, of_i) = (lambda(self.o), lambda(self.i));
        let facets = match model {
            FacetModel::Ggx => ggx() / (1.0 + of_o + of_i),
            FacetModel::GgxIndependent => ggx() / ((1.0 + of_o) * (1.0 + of_i)),
            FacetModel::Beckmann => {
                // The printed formula is 1.00005 at the end of its range.
                let g1 = |w: DVec3| match 1.0 / seen(w).sqrt() {
                    a if a < 1.6 => {
                        ((3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a)).min(1.0)
                    }
                    _ => 1.0,
                };
                let exponential = (-slope(self.h)).exp();
                exponential / (PI * u * v * self.cos_h.powi(4)) * g1(self.o) * g1(self.i)
            }
        };
        facets / (4.0 * self.cos_o * self.cos_i)
    }
}

fn dielectric(cos: f64, eta: f64) -> f64 {
    let sin_t = (1.0 - cos * cos).sqrt() / eta;
    let cos_t = (1.0 - sin_t * sin_t).sqrt();
    let s = (cos - eta * cos_t) / (cos + eta * cos_t);
    let p = (eta * cos - cos_t) / (eta * cos + cos_t);
    (s * s + p * p) / 2.0
}

/// Reflectance of the inside for diffuse light, by quadrature over directions inside, including
/// total reflection.
fn internal(eta: f64) -> f64 {
    let critical = (1.0 - 1.0 / (eta * eta)).sqrt();
    let n = 20_000;
    // Below the critical cosine all light is reflected. Above it, the substitution c = √(critical²
    // + x²) removes the square root of the integrand.
    let transmitted: f64 = (0..n)
        .map(|i| {
            let span = (1.0 - critical * critical).sqrt();
            let x = (f64::from(i) + 0.5) / f64::from(n) * span;
            let cos = (critical * critical + x * x).sqrt();
            (1.0 - dielectric(cos, 1.0 / eta)) * 2.0 * x * span / f64::from(n)
        })
        .sum();
    1.0 - transmitted
}

fn schlick(f0: f32, cos: f64) -> f64 {
    f64::from(f0) + (1.0 - f64::from(f0)) * (1.0 - cos).powi(5)
}

/// White sheen as printed in `KHR_materials_sheen`.
fn charlie(roughness: f64, pair: &Pair) -> f64 {
    let alpha = roughness * roughness;
    let mix = |rough: f64, fine: f64| rough + (fine - rough) * (1.0 - alpha) * (1.0 - alpha);
    let (a, b, c) = (mix(21.5473, 25.3245), mix(3.82987, 3.32435), mix(0.19823, 0.16801));
    let (d, e) = (mix(-1.97760, -1.27393), mix(-4.32054, -4.85967));
    let l = |x: f64| a / (1.0 + b * x.powf(c)) + d * x + e;
    let lambda = |x: f64| if x < 0.5 { l(x).exp() } else { (2.0 * l(0.5) - l(1.0 - x)).exp() };
    let sin2 = 1.0 - pair.cos_h * pair.cos_h;
    let distribution = (2.0 + 1.0 / alpha) * sin2.max(0.0).powf(0.5 / alpha) / (2.0 * PI);
    distribution / ((1.0 + lambda(pair.cos_o) + lambda(pair.cos_i)) * 4.0 * pair.cos_o * pair.cos_i)
}

/// Reference value of `f_r` in the green channel.
fn reference(bsdf: &Bsdf, internal: f64, pair: &Pair) -> f64 {
    match *bsdf {
        Bsdf::Lambert(b) => f64::from(b.reflectance.g) / PI,
        Bsdf::Phong(Phong { diffuse, specular, exponent }) => {
            let n = f64::from(exponent);
            let lobe = if pair.cos_mirror > 0.0 { pair.cos_mirror.powf(n) } else { 0.0 };
            f64::from(diffuse.g) / PI + f64::from(specular.g) * (n + 2.0) / (2.0 * PI) * lobe
        }
        Bsdf::Conductor(b) => {
            let f = match b.fresnel {
                ConductorFresnel::Schlick { f0 } => schlick(f0.g, pair.cos_d),
                ConductorFresnel::Passed { f0 } => 1.0 - schlick(f0.g, pair.cos_d),
                // The tests of `fresnel` compare this reflectance with complex arithmetic.
                ConductorFresnel::Exact { .. } => f64::from(b.fresnel.at(pair.cos_d as f32).g),
            };
            f * f64::from(b.specular.g) * pair.facets(b.facets)
        }
        Bsdf::Plastic(b) => {
            let f = dielectric(pair.cos_d, f64::from(b.ior));
            f64::from(b.diffuse.g) / PI + f64::from(b.specular.g) * f * pair.facets(b.facets)
        }
        Bsdf::Coated(Coated { reflectance, specular, ior, facets }) => {
            let (eta, rho) = (f64::from(ior), f64::from(reflectance.g));
            let coat = f64::from(specular.g) * dielectric(pair.cos_d, eta) * pair.facets(facets);
            // The tests of `boundary` compare rough boundaries with drawn facets.
            let boundary = Boundary::new(facets, ior);
            let passed = [pair.cos_o, pair.cos_i].map(|c| f64::from(boundary.transmittance(c as f32)));
            let passed = passed[0] * passed[1];
            coat + rho / PI * passed / (eta * eta * (1.0 - rho * internal))
        }
        Bsdf::MetallicRoughness(MetallicRoughness { diffuse, f0, dielectric_f0, facets }) => {
            let f = schlick(f0.g, pair.cos_d);
            (1.0 - schlick(dielectric_f0.g, pair.cos_d)) * f64::from(diffuse.g) / PI + f * pair.facets(facets)
        }
        // As printed for pbrt's `FresnelBlend`.
        Bsdf::AshikhminShirley(b) => {
            let fades = |cos: f64| 1.0 - (1.0 - cos / 2.0).powi(5);
            let diffuse = 28.0 * f64::from(b.diffuse.g) / (23.0 * PI) * (1.0 - f64::from(b.f0.g));
            let specular = pair.distribution(b.facets) / (4.0 * pair.cos_d * pair.cos_o.max(pair.cos_i));
            diffuse * fades(pair.cos_o) * fades(pair.cos_i) + schlick(b.f0.g, pair.cos_d) * specular
        }
        Bsdf::Principled(b) => {
            let (cos_d, grazing) = (pair.cos_d, |cos: f64| (1.0 - cos).powi(5));
            let (o, i) = (grazing(pair.cos_o), grazing(pair.cos_i));
            let back = 2.0 * f64::from(b.roughness) * cos_d * cos_d;
            let shape = (1.0 - 0.5 * o) * (1.0 - 0.5 * i) + back * (o + i + o * i * (back - 1.0));
            let lerp = |a: f64, b: f64, t: f64| (1.0 - t) * a + t * b;
            let f90 = f64::from(b.roughness) * cos_d * cos_d;
            let below = lerp(1.0, f90, o) * lerp(1.0, f90, i);
            let flat = 1.25 * (below * (1.0 / (pair.cos_o + pair.cos_i) - 0.5) + 0.5);
            let shape = lerp(shape, flat, f64::from(b.flatness));
            let t = f64::from(b.fresnel.schlick);
            let f =
                t * schlick(b.fresnel.f0.g, cos_d) + (1.0 - t) * dielectric(cos_d, f64::from(b.fresnel.ior));
            let sheen = f64::from(b.sheen.g) * grazing(cos_d);
            f64::from(b.diffuse.g) / PI * shape + sheen + f * pair.facets(b.facets)
        }
        Bsdf::Layered(Layered { base, sheen, coat: b }) => {
            let mut base = reference(&base.into(), internal, pair);
            if sheen.is_there() {
                // The tests of `sheen` compare the albedo with means over directions.
                let left = f64::from(sheen.left(pair.cos_o as f32));
                base = left * base + f64::from(sheen.color.g) * charlie(f64::from(sheen.roughness), pair);
            }
            let (w, a2) = (f64::from(b.amount), f64::from(b.alpha).powi(2));
            // As printed by Burley: in the cosine of the half vector.
            let gtr1 = (a2 - 1.0) / (PI * a2.ln() * (1.0 + (a2 - 1.0) * pair.cos_h * pair.cos_h));
            let g = |c: f64| 1.0 / (c + (0.0625 + c * c - 0.0625 * c * c).sqrt());
            let additive = w * schlick(0.04, pair.cos_d) * gtr1 * g(pair.cos_o) * g(pair.cos_i);
            let layer = w * schlick(0.04, pair.cos_o);
            match b.model {
                CoatModel::Disney => base + 0.25 * additive,
                CoatModel::Mitsuba => base + pair.cos_o * pair.cos_i * additive,
                CoatModel::Layer => (1.0 - layer) * base + layer * pair.facets(Microfacets::ggx(b.alpha)),
            }
        }
        Bsdf::Mirror(_) | Bsdf::Glass(_) | Bsdf::ThinGlass(_) => 0.0,
    }
}

/// Values agree within `10⁻⁴`. This covers twice the error of the fit of the coat's average, and
/// the effect of rounded directions on facets of `α ≥ 0.05` and lobes of `n ≤ 1000` at cosines
/// above 0.02.
#[test]
fn values_are_those_of_the_sources() {
    let mut stream = stream(40);
    for Case { name, bsdf } in cases::all() {
        let (sharp, internal) = match bsdf {
            Bsdf::Layered(_) => (bsdf.roughness().is_some_and(|alpha| alpha < 0.05), 0.0),
            Bsdf::Phong(b) => (b.exponent > 1000.0, 0.0),
            Bsdf::Plastic(b) => (b.facets.narrowest() < 0.05, 0.0),
            Bsdf::Conductor(b) => (b.facets.narrowest() < 0.05, 0.0),
            Bsdf::Coated(b) => {
                (b.facets.narrowest() < 0.05, f64::from(Boundary::new(b.facets, b.ior).inside()))
            }
            Bsdf::MetallicRoughness(b) => (b.facets.narrowest() < 0.05, 0.0),
            Bsdf::AshikhminShirley(b) => (b.facets.narrowest() < 0.05, 0.0),
            Bsdf::Principled(b) => (b.facets.narrowest() < 0.05, 0.0),
            Bsdf::Lambert(_) | Bsdf::Mirror(_) | Bsdf::Glass(_) | Bsdf::ThinGlass(_) => (false, 0.0),
        };
        if sharp {
            continue;
        }
        for _ in 0..2000 {
            let wo = direction_above(&mut stream);
            let wi = match stream.below(2) {
                0 => direction_above(&mut stream),
                _ => (Vec3::new(-wo.x, -wo.y, wo.z) + 0.1 * direction_above(&mut stream)).normalize(),
            };
            if wo.z < 0.02 || wi.z < 0.02 {
                continue;
            }
            let expected = reference(&bsdf, internal, &Pair::new(wo, wi));
            let got = f64::from(bsdf.eval(wo, wi).g);
            let difference = (got - expected).abs();
            assert!(difference <= 1e-4 * expected + 1e-9, "{name}, {wo}, {wi}: {got}, not {expected}");
        }
    }
}

/// The coat relies on the relation `F_int = 1 − (1 − F_ext) / η²`, which quadrature over the inside
/// confirms.
#[test]
fn the_inside_reflects_what_the_balance_of_fluxes_says() {
    for eta in [1.01_f32, 1.33, 1.5, 2.5, 5.0] {
        let outside = f64::from(super::super::fresnel::dielectric_average(eta));
        let eta = f64::from(eta);
        let from_outside = 1.0 - (1.0 - outside) / (eta * eta);
        assert!((internal(eta) - from_outside).abs() < 3e-5, "eta {eta}");
    }
    // Value printed in many tables for an index of 1.5.
    assert!((internal(1.5) - 0.596).abs() < 1e-3);
}

#[test]
fn smooth_boundaries_reflect_from_the_inside_what_integrals_say() {
    for ior in [1.0001, 1.2, 1.5, 2.0, 3.0, 5.0] {
        let boundary = Boundary::new(Microfacets::ggx(0.0), ior);
        let difference = f64::from(boundary.inside()) - internal(f64::from(ior));
        assert!(difference.abs() < 1e-4, "{ior}: {difference}");
    }
}
