//! Both distributions compared with their definitions and textbook formulas, by quadrature.

use std::f64::consts::PI;

use super::*;
use crate::math::elementary::erfc;
use crate::rng::{Purpose, Stream};

const ALPHAS: [f32; 5] = [MIN_ALPHA, 0.01, 0.1, 0.5, 1.0];
const MODELS: [FacetModel; 2] = [FacetModel::Ggx, FacetModel::Beckmann];

fn distribution(model: FacetModel, half: HalfVector<f32>, alpha: f32) -> f64 {
    f64::from(match model {
        FacetModel::Ggx | FacetModel::GgxIndependent => ggx::distribution(half, half.tangential2, alpha),
        FacetModel::Beckmann => beckmann::distribution(half, half.tangential2, alpha),
    })
}

fn visible_area(model: FacetModel, cos: f64, alpha: f32) -> f64 {
    let w = Vec3::new((1.0 - cos * cos).sqrt() as f32, 0.0, cos as f32);
    f64::from(Microfacets::even(alpha, model).visible_area(w))
}

/// Integrates `D f(tan²θ, cos θ) · 2π sin θ dθ` in the variable `x` with `tan θ = α x / (1 − x)`,
/// which resolves lobes of all widths.
fn integrate_normals(model: FacetModel, alpha: f32, f: impl Fn(f64, f64) -> f64) -> f64 {
    let n = 20_000;
    let width = f64::from(alpha);
    let normals = (0..n).map(|i| {
        let x = (f64::from(i) + 0.5) / f64::from(n);
        let tan = width * x / (1.0 - x);
        let cos = 1.0 / (1.0 + tan * tan).sqrt();
        let dtheta = cos * cos * width / (1.0 - x).powi(2) / f64::from(n);
        let half = HalfVector { tangential2: (tan * tan) as f32, axial2: 1.0 };
        distribution(model, half, alpha) * f(tan * tan, cos) * 2.0 * PI * tan * cos * dtheta
    });
    normals.sum()
}

#[test]
fn the_projected_area_of_all_facets_is_one() {
    for model in MODELS {
        for alpha in ALPHAS {
            let area = integrate_normals(model, alpha, |_, cos| cos);
            assert!((area - 1.0).abs() < 1e-5, "{model:?} alpha {alpha}: {area}");
        }
    }
}

/// The visible area agrees with quadrature of `∫ (ω_o·h)⁺ D dh`, whose inner integral
/// `∫ (ω_o·h)⁺ dφ / 2π` is known in closed form.
#[test]
fn visible_areas_are_those_of_the_facets() {
    for model in MODELS {
        for alpha in ALPHAS {
            for cos_o in [1.0_f64, 0.7, 0.2, 0.02] {
                let sin_o = (1.0 - cos_o * cos_o).sqrt();
                let facing = |t: f64, cos: f64| {
                    let (a, b) = (cos_o * cos, sin_o * cos * t.sqrt());
                    if a >= b {
                        return a;
                    }
                    let phi = (-a / b).acos();
                    (a * phi + b * phi.sin()) / PI
                };
                let seen = integrate_normals(model, alpha, facing);
                let area = visible_area(model, cos_o, alpha);
                assert!((area / seen - 1.0).abs() < 2e-5, "{model:?} {alpha}, {cos_o}: {area} for {seen}");
            }
        }
    }
}

/// Random pairs of directions near the lobe's peak. Values for the directions rounded to `f32`
/// agree with the textbook formula for the unrounded directions in `f64`.
#[test]
fn rounding_is_harmless_down_to_min_alpha() {
    let mut stream = Stream::new(5, Purpose::Test, 0);
    for (cos_o, allowed) in [(1.0_f64, 1e-3), (0.5, 3e-3), (0.1, 0.01), (0.01, 0.1)] {
        let mut worst = [0.0_f64; MODELS.len()];
        for _ in 0..20_000 {
            let sin_o = (1.0 - cos_o * cos_o).sqrt();
            let phi = 6.3 * stream.uniform_f64();
            let wo = glam::DVec3::new(sin_o * phi.cos(), sin_o * phi.sin(), cos_o);
            let tan = f64::from(MIN_ALPHA) * 1.5 * stream.uniform_f64();
            let psi = 6.3 * stream.uniform_f64();
            let h = glam::DVec3::new(tan * psi.cos(), tan * psi.sin(), 1.0).normalize();
            let wi = h * (2.0 * wo.dot(h)) - wo;
            if wi.z < 0.5 * cos_o {
                continue;
            }
            let a2 = f64::from(MIN_ALPHA).powi(2);
            let half = HalfVector::between(wo.as_vec3(), wi.as_vec3().to_array());
            for (model, worst) in MODELS.into_iter().zip(&mut worst) {
                let exact = match model {
                    FacetModel::Beckmann => (-tan * tan / a2).exp() / (PI * a2 * h.z.powi(4)),
                    _ => a2 / (PI * (h.z * h.z * (a2 - 1.0) + 1.0).powi(2)),
                };
                *worst = worst.max((distribution(model, half, MIN_ALPHA) / exact - 1.0).abs());
            }
            assert!((f64::from(half.cos_incidence()) - wo.dot(h)).abs() < 2e-7);
        }
        assert!(worst.iter().all(|worst| *worst < allowed), "cos {cos_o}: {worst:?}");
    }
}

/// `G₂ / 4 c_o c_i` from Smith's `Λ`: `(√(1 + α² tan²θ) − 1) / 2` for GGX,
/// `(e^(−a²)/(a √π) − erfc a) / 2` for Beckmann.
#[test]
fn masking_is_smiths() {
    for alpha in ALPHAS {
        for (cos_o, cos_i) in [(1.0_f64, 1.0_f64), (0.9, 0.3), (0.2, 0.05), (0.01, 0.8)] {
            for model in FacetModel::ALL {
                let lambda = |c: f64| {
                    let width = f64::from(alpha) * (1.0 / (c * c) - 1.0).sqrt();
                    if model == FacetModel::Beckmann {
                        let a = 1.0 / width;
                        0.5 * ((-a * a).exp() / (a * PI.sqrt()) - erfc(a)).max(0.0)
                    } else {
                        0.5 * ((1.0 + width * width).sqrt() - 1.0)
                    }
                };
                let (of_o, of_i) = (lambda(cos_o), lambda(cos_i));
                let (together, tolerance) = match model {
                    FacetModel::Ggx => (1.0 + of_o + of_i, 1e-5),
                    FacetModel::GgxIndependent => ((1.0 + of_o) * (1.0 + of_i), 1e-5),
                    FacetModel::Beckmann => ((1.0 + of_o) * (1.0 + of_i), 0.007),
                };
                let exact = 1.0 / together / (4.0 * cos_o * cos_i);
                let half = HalfVector { tangential2: 0.0, axial2: 1.0 };
                let [wo, wi] = [cos_o, cos_i].map(|cos| Vec3::new(0.0, 0.0, cos as f32));
                let facets = Microfacets::even(alpha, model);
                let all = f64::from(facets.reflection(half, wo, wi.to_array()));
                let got = all / distribution(model, half, alpha);
                assert!((got / exact - 1.0).abs() < tolerance, "{model:?} {alpha}: {got} against {exact}");
            }
        }
    }
}
