//! Reflected energy: no more than arrives, and equal to closed forms where these exist.

use std::f64::consts::LN_2;

use super::super::{Bsdf, CoatModel, ConductorFresnel, MAX_GTR1_ALPHA, MIN_ALPHA, UnderLayers};
use super::cases::{self, Case};
use super::quadrature::{PolarGrid, hemisphere};
use super::{OUTGOING, outgoing, stream};
use crate::color::Rgb;
use crate::math::Vec3;

/// Mean and standard error of the weight in the brightest channel; a path that ends has weight 0.
fn mean_weight(bsdf: &Bsdf, wo: Vec3, draws: u32, index: u64) -> (f64, f64) {
    let mut stream = stream(index);
    let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
    for _ in 0..draws {
        let weight = bsdf.sample(wo, stream.uniform_3()).map_or(Rgb::BLACK, |s| s.weight);
        for (channel, w) in weight.to_array().into_iter().enumerate() {
            sum[channel] += f64::from(w);
            squares[channel] += f64::from(w).powi(2);
        }
    }
    let n = f64::from(draws);
    let brightest = (0..3).max_by(|&a, &b| sum[a].total_cmp(&sum[b])).expect("three channels");
    let mean = sum[brightest] / n;
    (mean, ((squares[brightest] / n - mean * mean).max(0.0) / n).sqrt())
}

/// Largest albedo that the documentation of each model allows.
fn largest_albedo(bsdf: &Bsdf, cos: f32) -> f64 {
    match bsdf {
        Bsdf::Lambert(_)
        | Bsdf::Phong(_)
        | Bsdf::Plastic(_)
        | Bsdf::Conductor(_)
        | Bsdf::AshikhminShirley(_)
        | Bsdf::Mirror(_)
        | Bsdf::Glass(_)
        | Bsdf::ThinGlass(_) => 1.0,
        Bsdf::Coated(_) => 1.001,
        Bsdf::MetallicRoughness(_) if cos >= 0.7 => 1.003,
        Bsdf::MetallicRoughness(_) if cos >= 0.5 => 1.03,
        Bsdf::MetallicRoughness(_) => 2.0,
        Bsdf::Principled(b) => 2.6 + 0.1 * f64::from(b.sheen.max_channel()),
        Bsdf::Layered(b) => {
            // Covers the error of the sheen's table, and the excess of its model at grazing angles.
            let fibres = if b.sheen.is_there() { if cos > 0.2 { 0.01 } else { 2.0 } } else { 0.0 };
            let below = largest_albedo(&b.base.into(), cos).max(1.0) + fibres;
            let amount = f64::from(b.coat.amount);
            match b.coat.model {
                CoatModel::Disney => below + 0.05 * amount,
                CoatModel::Mitsuba => below + 0.04 * amount,
                CoatModel::Layer => below,
            }
        }
    }
}

/// The mean of 20,000 weights is at most the largest albedo plus 5 standard errors, for every case.
#[test]
fn no_surface_reflects_more_than_it_receives() {
    for (index, Case { name, bsdf }) in cases::all().iter().enumerate() {
        for cos in OUTGOING {
            let (mean, error) = mean_weight(bsdf, outgoing(cos), 20_000, 9000 + index as u64);
            let limit = largest_albedo(bsdf, cos) + 5.0 * error + 1e-5;
            assert!(mean <= limit, "{name} at {cos}: reflects {mean} ± {error}");
        }
    }
}

/// `∫ M dω_i`, with a grid for a lobe of versine `width` around the mirror direction.
fn albedo(bsdf: &Bsdf, wo: Vec3, width: f64) -> f64 {
    let grid = PolarGrid::about(Vec3::new(-wo.x, -wo.y, wo.z), width, 20, 16);
    grid.integrate(1e-7, &|wi| f64::from(bsdf.eval_cos(wo, wi).g))
}

/// Every weight, and the integral of the BSDF, equal the reflectance to a few roundings.
#[test]
fn lambert_reflects_exactly_its_reflectance() {
    let reflectance = Rgb::new(0.9, 0.5, 0.1);
    let bsdf = cases::lambert(reflectance);
    let mut stream = stream(20);
    for cos in OUTGOING {
        let wo = outgoing(cos);
        for _ in 0..1000 {
            let weight = bsdf.sample(wo, stream.uniform_3()).expect("never below the horizon").weight;
            let difference = weight.zip(reflectance, |w, r| (w / r - 1.0).abs()).max_channel();
            assert!(difference <= 4.0 * f32::EPSILON, "{weight:?}");
        }
        let integral = hemisphere(&|wi| f64::from(bsdf.eval_cos(wo, wi).g));
        assert!((integral - 0.5).abs() < 1e-6, "{integral}");
    }
}

/// The lobe `(n + 2) / 2π cosⁿ` reflects exactly `ρ_s` at normal incidence, and less elsewhere.
#[test]
fn a_phong_lobe_reflects_its_reflectance_at_normal_incidence() {
    for exponent in [0.0, 1.0, 10.0, 1e3, 1e6] {
        let bsdf = cases::phong(Rgb::BLACK, Rgb::gray(0.8), exponent);
        let width = 1.0 / f64::from(exponent + 1.0);
        // The value is the exponential of −n (1 − cos α), which is up to 20. The rounding of
        // directions changes this exponent by √(40 n) · 6e-8.
        let tolerance = 1e-5 + 6e-8 * (40.0 * f64::from(exponent)).sqrt();
        let normal = albedo(&bsdf, Vec3::Z, width);
        assert!((normal - 0.8).abs() < tolerance, "n = {exponent}: {normal}");
        for cos in [0.8, 0.3, 0.01] {
            let tilted = albedo(&bsdf, outgoing(cos), width);
            assert!(tilted <= 0.8 + tolerance, "n = {exponent} at {cos}: {tilted}");
        }
    }
}

/// With `F = 1` and `α = 1`, `M = c / (2π (1 + c))` at normal incidence, and its integral is
/// `1 − ln 2`.
#[test]
fn the_roughest_metal_reflects_one_minus_ln_two() {
    let bsdf = cases::conductor(ConductorFresnel::Schlick { f0: Rgb::WHITE }, 1.0);
    let got = albedo(&bsdf, Vec3::Z, 1.0);
    assert!((got - (1.0 - LN_2)).abs() < 1e-5, "{got}");
}

/// A white metal and two white coats over white bases, all of the smallest roughness, reflect all
/// light: nothing is lost or counted twice.
///
/// The loss by masking at `α = 0.001` is below `α² tan²θ`.
#[test]
fn smooth_white_surfaces_return_all_light() {
    let white = [
        cases::conductor(ConductorFresnel::Schlick { f0: Rgb::WHITE }, MIN_ALPHA),
        cases::coated(Rgb::WHITE, Rgb::WHITE, 1.5, MIN_ALPHA),
        cases::coated(Rgb::WHITE, Rgb::WHITE, 4.0, MIN_ALPHA),
    ];
    for bsdf in &white {
        for cos in [1.0, 0.8, 0.5, 0.1] {
            let got = albedo(bsdf, outgoing(cos), f64::from(MIN_ALPHA * MIN_ALPHA));
            assert!((got - 1.0).abs() < 5e-4, "{bsdf:?} at {cos}: {got}");
        }
    }
}

/// Diffuse part alone: the BSDF minus the same BSDF without its diffuse part.
fn diffuse_part(bsdf: &Bsdf) -> impl Fn(Vec3, Vec3) -> Rgb {
    let mut without = *bsdf;
    without.scale_diffuse(0.0);
    let bsdf = *bsdf;
    move |wo, wi| bsdf.eval_cos(wo, wi) - without.eval_cos(wo, wi)
}

/// `ρ(ω_o)` compared with quadrature of the diffuse part, for every case.
///
/// The lobes of the cases are first widened, to `α = 1` and `n = 1`: next to a sharp peak, `f32`
/// could not resolve the diffuse part, which does not depend on the width. The fits are accurate to
/// `2·10⁻⁵` of the light that enters, of which no less than 0.56 passes at the first attempt.
#[test]
fn vpl_reflectance_is_the_albedo_of_the_diffuse_part() {
    for Case { name, mut bsdf } in cases::all() {
        match &mut bsdf {
            Bsdf::Phong(b) => b.exponent = 1.0,
            Bsdf::Plastic(b) => b.facets.alpha = [1.0; 2],
            Bsdf::Coated(b) => b.facets.alpha = [1.0; 2],
            Bsdf::MetallicRoughness(b) => b.facets.alpha = [1.0; 2],
            Bsdf::AshikhminShirley(b) => b.facets.alpha = [1.0; 2],
            Bsdf::Principled(b) => b.facets.alpha = [1.0; 2],
            Bsdf::Layered(b) => {
                b.coat.alpha = if b.coat.model == CoatModel::Layer { 1.0 } else { MAX_GTR1_ALPHA };
                match &mut b.base {
                    UnderLayers::Lambert(_) => {}
                    UnderLayers::MetallicRoughness(b) => b.facets.alpha = [1.0; 2],
                    UnderLayers::Principled(b) => b.facets.alpha = [1.0; 2],
                }
            }
            Bsdf::Lambert(_) | Bsdf::Conductor(_) | Bsdf::Mirror(_) | Bsdf::Glass(_) | Bsdf::ThinGlass(_) => {
            }
        }
        let part = diffuse_part(&bsdf);
        for (direction, cos) in OUTGOING.into_iter().enumerate() {
            let wo = outgoing(cos);
            let stated = bsdf.vpl_reflectance(wo);
            assert_eq!(stated, bsdf.vpl_reflectance(-wo), "{name}: two-sided");
            let channel = direction % 3;
            let integral = hemisphere(&|wi| f64::from(part(wo, wi)[channel]));
            let difference = (f64::from(stated[channel]) - integral).abs();
            assert!(difference < 5e-5, "{name} at {cos}: {stated:?} against {integral}");
        }
    }
}

/// At normal incidence, the albedo for denoisers is near the mean weight of samples, for all cases
/// with little masking.
#[test]
fn the_rough_albedo_is_near_the_true_one() {
    for (index, Case { name, bsdf }) in cases::all().iter().enumerate() {
        let stated = bsdf.albedo();
        assert!(stated.is_valid() && stated.max_channel() <= 1.0, "{name}: {stated:?}");
        let wide = is_wide(bsdf, stated);
        let (mean, error) = mean_weight(bsdf, Vec3::Z, 4000, 20_000 + index as u64);
        let difference = (f64::from(stated.max_channel()) - mean).abs();
        assert!(wide || difference < 0.02 + 5.0 * error, "{name}: {stated:?} against {mean} ± {error}");
    }
}

/// Returns true if masking is strong at normal incidence, or if the reflectance exceeds the limit
/// of the albedo for denoisers.
fn is_wide(bsdf: &Bsdf, stated: Rgb) -> bool {
    match bsdf {
        Bsdf::Plastic(b) => b.facets.widest() > 0.1,
        Bsdf::Conductor(b) => b.facets.widest() > 0.1,
        Bsdf::Coated(b) => b.facets.widest() > 0.1,
        Bsdf::MetallicRoughness(b) => b.facets.widest() > 0.1,
        Bsdf::AshikhminShirley(b) => b.facets.widest() > 0.1,
        // Values above 1 are clamped.
        Bsdf::Principled(b) => b.facets.widest() > 0.1 || stated.max_channel() == 1.0,
        // Additive coats on white bases reflect more than arrives.
        Bsdf::Layered(b) => {
            b.coat.alpha > 0.1 || stated.max_channel() == 1.0 || is_wide(&b.base.into(), stated)
        }
        Bsdf::Lambert(_) | Bsdf::Phong(_) | Bsdf::Mirror(_) | Bsdf::Glass(_) | Bsdf::ThinGlass(_) => false,
    }
}
