//! Samples follow the density of `pdf`, and their weights are the BSDF over that density.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::super::{
    AshikhminShirley, Bsdf, BsdfSample, CoatModel, Coated, Conductor, ConductorFresnel, FacetModel, Lobe,
    MetallicRoughness, Plastic, Principled,
};
use super::cases::{self, Case};
use super::quadrature::PolarGrid;
use super::{OUTGOING, outgoing, stream};
use crate::color::Rgb;
use crate::math::Vec3;

/// Number of draws for each case and direction.
const DRAWS: u32 = 20_000;

/// Probability that at least one of the comparisons of a test fails by chance.
const FAMILY_LEVEL: f64 = 1e-4;

/// Smallest expected number of draws in a cell: its count is then nearly normal. Cells with fewer
/// expected draws are pooled.
const MIN_EXPECTED: f64 = 8.0;

/// Tolerance of one step of the quadrature.
const QUADRATURE_TOLERANCE: f64 = 2e-6;

/// Error allowed for the sum over the 320 cells of a grid: `2e-6` for each cell, ten times that for
/// cells that the horizon cuts.
const QUADRATURE_ERROR: f64 = 2e-3;

/// Grids that resolve a density: one around the mirror direction with the width of the lobe, and,
/// for wide lobes, one around the normal.
fn grids(bsdf: &Bsdf, wo: Vec3) -> Vec<PolarGrid> {
    let (width, is_line) = width(bsdf, wo);
    let (sectors, levels) = if is_line { (256, 2) } else { (16, 0) };
    let mirror = Vec3::new(-wo.x, -wo.y, wo.z);
    let mut grids = vec![PolarGrid::about(mirror, width, 20, sectors).refined(levels)];
    if width > 0.1 {
        grids.push(PolarGrid::about(Vec3::Z, 1e9, 20, 16));
    }
    grids
}

/// Returns the versine of the width of the narrowest lobe, and true if that lobe is much longer
/// than wide.
fn width(bsdf: &Bsdf, wo: Vec3) -> (f64, bool) {
    let mut is_line = false;
    let width = match bsdf {
        Bsdf::Lambert(_) | Bsdf::Mirror(_) | Bsdf::Glass(_) | Bsdf::ThinGlass(_) => 1.0,
        Bsdf::Layered(b) => {
            let (base, of_base) = width(&b.base.into(), wo);
            let is_thin = wo.z < 0.1 && b.coat.amount > 0.0;
            is_line = is_thin || of_base;
            let coat = if b.coat.amount > 0.0 { b.coat.alpha } else { 1.0 };
            base.min(f64::from(if is_thin { coat * wo.z } else { coat }).powi(2))
        }
        Bsdf::Phong(b) => 1.0 / f64::from(b.exponent + 1.0),
        Bsdf::Conductor(Conductor { facets, .. })
        | Bsdf::Plastic(Plastic { facets, .. })
        | Bsdf::Coated(Coated { facets, .. })
        | Bsdf::MetallicRoughness(MetallicRoughness { facets, .. })
        | Bsdf::AshikhminShirley(AshikhminShirley { facets, .. })
        | Bsdf::Principled(Principled { facets, .. }) => {
            // At grazing angles lobes are much longer than wide. Beckmann's lobes have no tails
            // that would lead the refinement of cells to the lobe.
            let alpha = facets.narrowest();
            is_line = facets.model == FacetModel::Beckmann && alpha < 0.3 && wo.z < 0.1;
            f64::from(if is_line { alpha * wo.z } else { alpha }).powi(2)
        }
    };
    (width, is_line)
}

/// Probability of a `χ²` statistic at least as large as that of the observed counts, if `expected`
/// are the true probabilities of the cells. The last cell counts paths that end.
fn p_value(observed: &[u32], expected: &[f64]) -> f64 {
    let total: u32 = observed.iter().sum();
    let (mut statistic, mut cells) = (0.0, 0_u32);
    let (mut pooled_observed, mut pooled_expected) = (0.0, 0.0);
    let mut count = |observed: f64, expected: f64| {
        statistic += (observed - expected).powi(2) / expected;
        cells += 1;
    };
    for (&o, &e) in observed.iter().zip(expected) {
        let (o, e) = (f64::from(o), e.max(0.0) * f64::from(total));
        if e >= MIN_EXPECTED {
            count(o, e);
        } else {
            pooled_observed += o;
            pooled_expected += e;
        }
    }
    // The pooled cell is ignored if too few draws are expected in it, unless far more draws are
    // found in it than can be.
    if pooled_expected >= MIN_EXPECTED || pooled_observed > 5.0 * MIN_EXPECTED {
        count(pooled_observed, pooled_expected.max(1.0));
    }
    if cells < 2 {
        return 1.0;
    }
    ChiSquared::new(f64::from(cells - 1)).expect("positive").sf(statistic)
}

/// Tests both guarantees of `pdf` for every case, direction, and grid.
///
/// Hypothesis: `sample` draws from `pdf`. For each there is one `χ²` test, at a level of
/// [`FAMILY_LEVEL`] divided by the number of tests (Bonferroni). The share of paths that end is
/// compared as well, to within 5 standard errors.
#[test]
fn directions_follow_the_density() {
    let cases = cases::smooth();
    let comparisons: usize =
        cases.iter().flat_map(|case| OUTGOING.map(|cos| grids(&case.bsdf, outgoing(cos)).len())).sum();
    for (index, Case { name, bsdf }) in cases.iter().enumerate() {
        for (direction, cos) in OUTGOING.into_iter().enumerate() {
            let wo = outgoing(cos);
            let mut stream = stream(1000 + (index * OUTGOING.len() + direction) as u64);
            let samples: Vec<Option<BsdfSample>> =
                (0..DRAWS).map(|_| bsdf.sample(wo, stream.uniform_3())).collect();
            for grid in grids(bsdf, wo) {
                let mut observed = vec![0; grid.len() + 1];
                for sample in &samples {
                    observed[sample.map_or(grid.len(), |s| grid.cell(s.wi))] += 1;
                }
                let mut expected: Vec<f64> = (0..grid.len())
                    .map(|cell| {
                        grid.integrate_cell(cell, QUADRATURE_TOLERANCE, &|wi| f64::from(bsdf.pdf(wo, wi)))
                    })
                    .collect();
                let mass: f64 = expected.iter().sum();
                let ended = f64::from(observed[grid.len()]) / f64::from(DRAWS);
                let error = 5.0 * (ended * (1.0 - ended) / f64::from(DRAWS)).sqrt() + QUADRATURE_ERROR;
                assert!(mass <= 1.0 + QUADRATURE_ERROR, "{name} at {cos}: the density integrates to {mass}");
                assert!((1.0 - mass - ended).abs() < error, "{name} at {cos}: mass {mass}, ended {ended}");
                expected.push(1.0 - mass);
                let p = p_value(&observed, &expected);
                assert!(p > FAMILY_LEVEL / comparisons as f64, "{name} {bsdf:?} at {cos}: p = {p:e}");
            }
        }
    }
}

/// For eleven surfaces, the means of `x`, `y`, `x²`, `y²` and `z` of the drawn direction, or of
/// zeros for a path that ends, agree with quadrature of the density, to within 5 standard errors in
/// 110 comparisons.
///
/// This test is sharper than the `χ²` tests: it detects a lobe that is a few percent too wide in
/// one direction.
#[test]
fn moments_of_directions_agree_with_the_density() {
    const MANY: u32 = 200_000;
    let half = Rgb::gray(0.5);
    let gray = ConductorFresnel::Schlick { f0: half };
    let surfaces = [
        cases::lambert(half),
        cases::phong(half, half, 5.0),
        cases::phong(Rgb::BLACK, half, 300.0),
        cases::conductor(gray, 0.05),
        cases::conductor(gray, 0.3),
        cases::conductor(gray, 1.0),
        cases::coated(half, Rgb::WHITE, 1.5, 0.2),
        cases::metallic_roughness(half, half, 0.2),
        cases::clearcoat(cases::lambert(half), 1.0, 0.1, CoatModel::Disney),
        cases::clearcoat(cases::lambert(Rgb::BLACK), 1.0, 0.02, CoatModel::Mitsuba),
        cases::clearcoat(cases::metallic_roughness(half, half, 0.2), 1.0, 0.1, CoatModel::Layer),
    ];
    let moments = |w: Vec3| [w.x, w.y, w.x * w.x, w.y * w.y, w.z].map(f64::from);
    for (index, bsdf) in surfaces.iter().enumerate() {
        for cos in [0.9, 0.2] {
            let wo = outgoing(cos);
            let mut stream = stream(7000 + index as u64);
            let (mut sum, mut squares) = ([0.0; 5], [0.0; 5]);
            for _ in 0..MANY {
                let drawn = bsdf.sample(wo, stream.uniform_3()).map_or([0.0; 5], |s| moments(s.wi));
                for (moment, value) in drawn.into_iter().enumerate() {
                    sum[moment] += value;
                    squares[moment] += value * value;
                }
            }
            for moment in 0..5 {
                let mean = sum[moment] / f64::from(MANY);
                let error = ((squares[moment] / f64::from(MANY) - mean * mean) / f64::from(MANY)).sqrt();
                let expected = grids(bsdf, wo)[0]
                    .integrate(1e-6, &|wi| moments(wi)[moment] * f64::from(bsdf.pdf(wo, wi)));
                let difference = (mean - expected).abs();
                assert!(
                    difference < 5.0 * error + 3e-5,
                    "{bsdf:?} at {cos}, moment {moment}: {mean} ± {error}, not {expected}"
                );
            }
        }
    }
}

/// For every sample, on both sides of the surface, `weight · pdf = f cos θ`. All three are results
/// of public functions.
#[test]
fn weights_are_the_bsdf_over_the_density() {
    for (index, Case { name, bsdf }) in cases::smooth().iter().enumerate() {
        let mut stream = stream(5000 + index as u64);
        for cos in OUTGOING {
            for side in [1.0, -1.0] {
                let wo = outgoing(cos) * Vec3::new(1.0, 1.0, side);
                for _ in 0..500 {
                    let Some(s) = bsdf.sample(wo, stream.uniform_3()) else { continue };
                    assert!((s.wi.length() - 1.0).abs() < 1e-6, "{name}: length {}", s.wi.length());
                    assert!(!s.lobe.is_specular() && s.wi.z * side > 0.0, "{name}");
                    assert_eq!(s.pdf, bsdf.pdf(wo, s.wi), "{name} at {cos}");
                    let value = bsdf.eval(wo, s.wi) * s.wi.z.abs();
                    assert_eq!(value, bsdf.eval_cos(wo, s.wi), "{name}: the cosine");
                    let from_weight = s.weight * s.pdf;
                    let difference = (from_weight - value).map(f32::abs).max_channel();
                    assert!(difference <= 1e-6 * value.max_channel(), "{name}: {from_weight:?}, {value:?}");
                }
            }
        }
    }
}

/// Surfaces with a diffuse part return samples of `Diffuse`, surfaces with a glossy lobe samples of
/// `Glossy`, and surfaces with both return both.
#[test]
fn lobes_are_named() {
    let lobes = |bsdf: Bsdf| {
        let mut stream = stream(2);
        let (mut diffuse, mut glossy) = (0, 0);
        for _ in 0..2000 {
            match bsdf.sample(outgoing(0.8), stream.uniform_3()).map(|s| s.lobe) {
                Some(Lobe::Diffuse) => diffuse += 1,
                Some(Lobe::Glossy) => glossy += 1,
                Some(Lobe::SpecularReflection | Lobe::SpecularTransmission) => unreachable!("no such lobe"),
                None => {}
            }
        }
        (diffuse > 0, glossy > 0)
    };
    let half = Rgb::gray(0.5);
    assert_eq!(lobes(cases::lambert(half)), (true, false));
    assert_eq!(lobes(cases::phong(half, half, 10.0)), (true, true));
    assert_eq!(lobes(cases::phong(half, Rgb::BLACK, 10.0)), (true, false));
    assert_eq!(lobes(cases::coated(Rgb::BLACK, half, 1.5, 0.1)), (false, true));
    assert_eq!(lobes(cases::metallic_roughness(half, Rgb::gray(0.04), 0.1)), (true, true));
    let coat = |reflectance| cases::clearcoat(cases::lambert(reflectance), 1.0, 0.1, CoatModel::Disney);
    assert_eq!([coat(half), coat(Rgb::BLACK)].map(lobes), [(true, true), (false, true)]);
}

/// Test of the test: if the density is wrong by a tenth in some cells, this is detected.
#[test]
fn the_goodness_of_fit_finds_a_wrong_density() {
    let cells = 100;
    let mut stream = stream(3);
    let mut observed = vec![0; cells];
    for _ in 0..DRAWS {
        observed[stream.below(cells as u64) as usize] += 1;
    }
    let even = vec![1.0 / cells as f64; cells];
    assert!(p_value(&observed, &even) > 1e-4);
    let tilted: Vec<f64> =
        even.iter().enumerate().map(|(i, p)| p * if i < cells / 2 { 1.1 } else { 0.9 }).collect();
    assert!(p_value(&observed, &tilted) < 1e-12);
}
