//! Media whose density and albedo are grids, compared with integrals, quadrature, the white furnace
//! and homogeneous media.

use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use tashika::accel::Tracer;
use tashika::bsdf::HenyeyGreenstein;
use tashika::color::Rgb;
use tashika::error::Location;
use tashika::film::Window;
use tashika::integrator::{PathStop, PathTracer, Setting};
use tashika::math::elementary::{exp_f64, rotation, sin_cos_f64};
use tashika::math::{Affine3A, Vec3};
use tashika::render::{RenderOptions, TileShare, render, with_threads};
use tashika::scene::{
    Camera, Emitter, Environment, Material, Medium, MediumId, Scattered, SceneBuilder, Surface, Variation,
    VolumeData, VolumeEdges, VolumeGrid, VolumeSamples, VolumeValues,
};
use tashika::stats::Moments;

use crate::cases::{
    add_ceiling_lamp, builder, cuboid, diffuse_room, film, glowing, lambert, parallelogram, place, tracer,
    view,
};
use crate::media::{assert_means, bounding, colors, mean_of, needle, paths};

/// A grid in the box between two corners; `value` gives the value at the centre of each cell.
pub fn grid(counts: [u32; 3], [lo, hi]: [Vec3; 2], value: impl Fn([f64; 3]) -> [f64; 3]) -> VolumeGrid {
    let middle = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
    let [nx, ny, nz] = counts;
    let of = |i: u32| value([middle(i % nx, nx), middle(i / nx % ny, ny), middle(i / (nx * ny), nz)]);
    let values = (0..nx * ny * nz).map(|i| Rgb::from(of(i).map(|v| v as f32))).collect();
    let data = VolumeData {
        counts,
        values: VolumeValues::Colors(values),
        to_world: (Affine3A::from_translation(lo) * Affine3A::from_scale(hi - lo)).as_daffine3(),
        samples: VolumeSamples::Centers,
        edges: VolumeEdges::Held,
    };
    VolumeGrid::new(data, &Location::default()).unwrap()
}

pub fn add(
    b: &mut SceneBuilder,
    [absorption, scattering]: [[f32; 3]; 2],
    asymmetry: f32,
    density: Option<VolumeGrid>,
    scattered: Scattered,
) -> MediumId {
    let [absorption, scattering] = [absorption, scattering].map(Rgb::from);
    let phase = HenyeyGreenstein { asymmetry };
    let variation = Some(Arc::new(Variation::new(density, scattered)));
    b.add_medium(Medium { name: "smoke".into(), absorption, scattering, phase, variation }).unwrap()
}

const ABSORPTION: [f32; 3] = [0.3, 1.0, 2.5];

/// `∫ D` over a box of a metre. The density rises from 0 to `2` through the centres of `cells`
/// cells, and is constant in the first and the last half cell.
fn ramp(cells: u32) -> f64 {
    // Trapezoids between the samples, and the two constant ends.
    let sample = |i: u32| 2.0 * (f64::from(i) + 0.5) / f64::from(cells);
    let between: f64 = (1..cells).map(|i| 0.5 * (sample(i - 1) + sample(i))).sum();
    (between + 0.5 * (sample(0) + sample(cells - 1))) / f64::from(cells)
}

/// Absorbing smoke whose density is a ramp, in a medium that is larger than the grid. A path to a
/// visible lamp and a slanted shadow segment have the transmittance of the integral.
#[test]
fn a_ramp_absorbs_as_its_integral_says() {
    let cells = 10;
    let smoke = |b: &mut SceneBuilder, along: usize| {
        let mut box_ = [Vec3::splat(-4.0), Vec3::splat(4.0)];
        (box_[0][along], box_[1][along]) = (0.5, 1.5);
        let mut counts = [1; 3];
        counts[along] = cells;
        let density = grid(counts, box_, |place| [2.0 * place[along]; 3]);
        add(b, [ABSORPTION, [0.0; 3]], 0.0, Some(density), Scattered::Evenly)
    };
    let expected = ABSORPTION.map(|sigma| exp_f64(-f64::from(sigma) * ramp(cells)));
    let mut b = builder();
    let medium = smoke(&mut b, 2);
    let lamp = parallelogram(Vec3::new(-1.0, -1.0, 0.0), Vec3::X * 2.0, Vec3::Y * 2.0);
    place(&mut b, lamp, glowing("lamp", lambert(0.0), 1.0));
    b.add_camera(needle(Vec3::Z * 2.0, Some(medium))).unwrap();
    assert_means(&paths(&tracer(b), 200, [16, 16]), expected, 1e-4, 0.01, "a lamp seen");

    let mut b = builder();
    let medium = smoke(&mut b, 1);
    let floor = parallelogram(Vec3::new(-9.0, 0.0, -9.0), Vec3::Z * 18.0, Vec3::X * 18.0);
    place(&mut b, floor, Material::new("floor", lambert(1.0)));
    b.add_emitter(Emitter::Directional { direction: Vec3::new(0.6, -0.8, 0.0), irradiance: Rgb::WHITE })
        .unwrap();
    let camera = Camera::look_at("c", Vec3::Y * 0.4, Vec3::ZERO, Vec3::Z, 1e-4);
    b.add_camera(Camera { medium: Some(medium), ..camera }).unwrap();
    let slanted = ABSORPTION.map(|sigma| 0.8 / PI * exp_f64(-f64::from(sigma) * ramp(cells) / 0.8));
    assert_means(&paths(&tracer(b), 200, [16, 16]), slanted, 1e-4, 0.01, "a shadow");
}

const ALBEDO: f32 = 1e-3;
const EXTINCTION: [f32; 3] = [0.3, 0.6, 1.2];

/// Density of the layers of a slab from `z = −2` to 0: a step after four of eight.
fn step(layer: u32) -> f64 {
    if layer < 4 { 0.5 } else { 2.0 }
}

/// The density at `z`, linear between the centres of layers.
fn density_at(z: f64) -> f64 {
    if !(-2.0..=0.0).contains(&z) {
        return 0.0;
    }
    let at = ((z + 2.0) * 4.0 - 0.5).clamp(0.0, 7.0);
    let below = at.floor().min(6.0);
    let of = |layer: f64| step(layer as u32);
    of(below) + (at - below) * (of(below + 1.0) - of(below))
}

/// Mean of the density between two heights, by the midpoint rule between its kinks, where it is
/// exact.
fn mean_density(from: f64, to: f64) -> f64 {
    let (lo, hi) = (from.min(to), from.max(to));
    if hi - lo < 1e-9 {
        return density_at(lo);
    }
    let inside = [-2.0, -1.125, -0.875, 0.0].into_iter().filter(|z| (lo..hi).contains(z));
    let mut bends: Vec<f64> = inside.chain([hi]).collect();
    let mut from = lo;
    let mut sum = 0.0;
    for to in bends.drain(..) {
        // Evaluated at the midpoint, since the density is linear in between and may drop to zero at
        // an end.
        sum += (to - from) * density_at(0.5 * (from + to));
        from = to;
    }
    sum / (hi - lo)
}

/// A point light in a slab whose density has a step, and a camera outside. Light that is scattered
/// once towards the camera equals the result of quadrature.
#[test]
fn light_scattered_once_in_a_step_is_that_of_quadrature() {
    let light = [0.4, -0.3, -1.0];
    let mut b = builder();
    let slab = [Vec3::new(-8.0, -8.0, -2.0), Vec3::new(8.0, 8.0, 0.0)];
    let density = grid([1, 1, 8], slab, |[.., z]| [step((z * 8.0) as u32); 3]);
    let coefficients = [EXTINCTION.map(|s| s * (1.0 - ALBEDO)), EXTINCTION.map(|s| s * ALBEDO)];
    let smoke = add(&mut b, coefficients, 0.5, Some(density), Scattered::Evenly);
    b.add_emitter(Emitter::Point { position: Vec3::from(light.map(|v| v as f32)), intensity: Rgb::WHITE })
        .unwrap();
    b.add_camera(needle(Vec3::Z * 0.5, Some(smoke))).unwrap();
    let phase = HenyeyGreenstein { asymmetry: 0.5 };
    let expected = EXTINCTION.map(|sigma| {
        let sigma = f64::from(sigma);
        let steps = 20_000;
        let at = |k: i32| {
            let z = -2.0 * (f64::from(k) + 0.5) / f64::from(steps);
            let to = [light[0], light[1], light[2] - z];
            let d = to.iter().map(|v| v * v).sum::<f64>().sqrt();
            let depth = sigma * (-z * mean_density(z, 0.0) + d * mean_density(z, light[2]));
            let scattered = f64::from(ALBEDO) * sigma * density_at(z);
            scattered * exp_f64(-depth) * f64::from(phase.density((-to[2] / d) as f32)) / (d * d)
        };
        (0..steps).map(at).sum::<f64>() * 2.0 / f64::from(steps)
    });
    let film = paths(&tracer(b), 1000, [16, 16]);
    assert_means(&film, expected, f64::from(ALBEDO) + 1e-4, 0.01, "a step");
}

/// Density with separate waves in the three channels and empty regions.
fn waves([x, y, z]: [f64; 3]) -> [f64; 3] {
    let wave = |at: f64| (sin_cos_f64(at).0).max(0.0) * 2.0;
    [wave(9.0 * x + 4.0 * y), wave(11.0 * y - 5.0 * z), wave(12.0 * z + 6.0 * x)]
}

/// A medium without absorption is invisible if the incident radiance is equal from all sides,
/// whatever its density. Tested under a sky, with the camera inside and outside, and in a room
/// whose walls emit.
#[test]
fn white_media_of_any_density_are_invisible_in_a_furnace() {
    let white = [[0.0; 3], [0.5, 2.0, 6.0]];
    let lit = [[0.5, 2.0, 6.0], [0.0; 3]];
    let box_ = [Vec3::new(-1.0, -1.1, -0.9), Vec3::new(1.0, 0.9, 1.2)];
    let waving = || Some(grid([12, 9, 14], box_, waves));
    let albedo = || Scattered::Albedo(grid([2, 2, 2], box_, |_| [1.0; 3]));
    let coefficient = || Scattered::Coefficient(grid([12, 9, 14], box_, waves));
    let eye = Vec3::new(0.1, 0.2, 3.0);
    type Kind<'a> = (&'a str, [[f32; 3]; 2], &'a dyn Fn() -> Option<VolumeGrid>, &'a dyn Fn() -> Scattered);
    let kinds: [Kind<'_>; 4] = [
        ("density", white, &waving, &|| Scattered::Evenly),
        ("density and albedo", lit, &waving, &albedo),
        ("albedo", lit, &|| None, &albedo),
        ("coefficients", [[0.0; 3], [1.0; 3]], &waving, &coefficient),
    ];
    for (number, (what, coefficients, density, scattered)) in kinds.into_iter().enumerate() {
        for (g, inside) in [(0.0, false), (0.7, true)] {
            let mut b = builder();
            let milk = Some(add(&mut b, coefficients, g, density(), scattered()));
            // The boundary is larger than the grid.
            let about = cuboid(box_[0] - 0.3, box_[1] + 0.2, false);
            bounding(&mut b, about, Surface::Boundary, [milk, None]);
            b.set_environment(Environment::constant(Rgb::WHITE)).unwrap();
            let eye = if inside { eye * 0.2 } else { eye };
            let camera = Camera::look_at("c", eye, Vec3::ZERO, Vec3::Y, 0.4);
            b.add_camera(Camera { medium: milk.filter(|_| inside), ..camera }).unwrap();
            assert_means(&paths(&tracer(b), 40, [16, 16]), [1.0; 3], 2e-5, 0.02, what);
        }
        if number == 0 {
            let mut b = builder();
            let milk = add(&mut b, coefficients, 0.5, density(), scattered());
            let room = cuboid(Vec3::splat(-4.0), Vec3::splat(4.0), true);
            place(&mut b, room, glowing("wall", lambert(0.6), 0.4));
            let camera = Camera::look_at("c", eye, Vec3::ZERO, Vec3::Y, 0.4);
            b.add_camera(Camera { medium: Some(milk), ..camera }).unwrap();
            assert_means(&paths(&tracer(b), 60, [16, 16]), [1.0; 3], 2e-5, 0.03, "a room");
        }
    }
}

/// A block of smoke in a room with a lamp, with the camera outside.
fn room_with_block(medium: impl FnOnce(&mut SceneBuilder, [Vec3; 2]) -> MediumId) -> Tracer {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    let box_ = [Vec3::new(-0.7, 0.05, -0.6), Vec3::new(0.6, 1.4, 0.7)];
    let smoke = Some(medium(&mut b, box_));
    bounding(&mut b, cuboid(box_[0], box_[1], false), Surface::Boundary, [smoke, None]);
    tracer(b)
}

const BLOCK: [[f32; 3]; 2] = [[0.1, 0.5, 1.0], [2.0, 3.0, 1.0]];

/// Channel means of the whole picture with their standard errors, from 32 seeds.
fn picture(tracer: &Tracer) -> [(f64, f64); 3] {
    let path = PathTracer::new(tracer, PathStop::Count(64), 1000).unwrap();
    let mut moments = [Moments::default(); 3];
    for seed in 1..=32 {
        let means = mean_of(&film(tracer, &path, [16, 12], 1, seed));
        moments.iter_mut().zip(means).for_each(|(m, (mean, _))| m.push(mean));
    }
    moments.map(|m| (m.mean(), m.standard_error()))
}

/// Grids of ones, of constant albedo and of constant coefficients give the picture of the
/// homogeneous medium, however they are placed. There are 12 comparisons of two means of 32 seeds:
/// 5.5 standard errors are a level of 5·10⁻⁶ each.
#[test]
fn grids_that_are_even_are_homogeneous() {
    let plain = room_with_block(|b, _| {
        let [absorption, scattering] = BLOCK.map(Rgb::from);
        let phase = HenyeyGreenstein { asymmetry: 0.3 };
        b.add_medium(Medium { name: "plain".into(), absorption, scattering, phase, variation: None }).unwrap()
    });
    let expected = picture(&plain);
    let albedo = [0, 1, 2].map(|k| f64::from(BLOCK[1][k] / (BLOCK[0][k] + BLOCK[1][k])));
    let extinction = [0, 1, 2].map(|k| BLOCK[0][k] + BLOCK[1][k]);
    for kind in 0..4 {
        let tracer = room_with_block(|b, [lo, hi]| {
            let ones = |slack: f32| Some(grid([5, 6, 7], [lo - slack, hi + slack], |_| [1.0; 3]));
            let albedos = || Scattered::Albedo(grid([2, 1, 1], [lo, hi], |_| albedo));
            match kind {
                0 => add(b, BLOCK, 0.3, ones(0.0), Scattered::Evenly),
                1 => add(b, BLOCK, 0.3, ones(0.5), Scattered::Evenly),
                2 => add(b, [extinction, [0.0; 3]], 0.3, None, albedos()),
                _ => {
                    let even = |counts, value: [f32; 3]| grid(counts, [lo, hi], |_| value.map(f64::from));
                    let scattered = Scattered::Coefficient(even([1, 1, 1], BLOCK[1]));
                    add(b, [[0.0; 3], [1.0; 3]], 0.3, Some(even([3, 2, 2], extinction)), scattered)
                }
            }
        });
        for ((found, e), (expected, f)) in picture(&tracer).into_iter().zip(expected) {
            let bound = 5.5 * e.hypot(f);
            assert!(bound < 0.06 * expected, "not sharp: {bound} of {expected}");
            assert!((found - expected).abs() <= bound, "{kind}: {found} for {expected} ± {bound}");
        }
    }
}

#[test]
fn threads_and_windows_change_no_bit_in_grids() {
    let tracer = room_with_block(|b, box_| {
        let density = grid([12, 9, 14], box_, waves);
        add(b, [[0.1, 0.0, 0.2], [4.0, 6.0, 8.0]], 0.2, Some(density), Scattered::Evenly)
    });
    let size = [23, 17];
    let run = |threads: usize, window: Window| {
        with_threads(threads, || {
            let scene = tracer.scene().clone();
            let path = PathTracer::new(&tracer, PathStop::Count(4), 16).unwrap();
            let options = RenderOptions { window, share: TileShare::default() };
            let setting = Setting { tracer: &tracer, view: view(&scene, size, 1, 5) };
            render(&setting, &path, &options, &|_| (), &AtomicBool::new(false)).unwrap().film
        })
        .unwrap()
    };
    let one = run(1, Window::full(size));
    assert_eq!(run(3, Window::full(size)), one);
    let part = Window { x: 5, y: 3, width: 9, height: 7 };
    let whole = colors(&one);
    for ((x, y), color) in part.pixels().zip(colors(&run(2, part))) {
        assert_eq!(color, whole[(y * size[0] + x) as usize], "{x}, {y}");
    }
}

/// A grid and its camera are turned and moved together. The picture does not change.
#[test]
fn grids_are_where_their_map_puts_them() {
    let see = |turn: Affine3A| {
        let mut b = builder();
        let own = grid([6, 5, 4], [Vec3::ZERO, Vec3::ONE], waves);
        let data = VolumeData {
            counts: own.counts(),
            values: own.values().clone(),
            to_world: (turn * Affine3A::from_translation(Vec3::splat(-0.5))).as_daffine3(),
            samples: VolumeSamples::Centers,
            edges: VolumeEdges::Zero,
        };
        let density = VolumeGrid::new(data, &Location::default()).unwrap();
        let smoke = add(&mut b, [[1.0, 2.0, 3.0], [0.0; 3]], 0.0, Some(density), Scattered::Evenly);
        b.set_environment(Environment::constant(Rgb::WHITE)).unwrap();
        let [eye, up] = [turn.transform_point3(Vec3::Z * 3.0), turn.transform_vector3(Vec3::Y)];
        let camera = Camera::look_at("c", eye, turn.transform_point3(Vec3::ZERO), up, 0.3);
        // The medium of the camera is the grid, whose density is zero outside, so that the light of
        // the sky gets in.
        b.add_camera(Camera { medium: Some(smoke), ..camera }).unwrap();
        let tracer = tracer(b);
        film(&tracer, &PathTracer::new(&tracer, PathStop::Count(400), 4).unwrap(), [6, 6], 1, 9)
    };
    let plain = see(Affine3A::IDENTITY);
    let axis = Vec3::new(0.6, 0.0, 0.8);
    let turned = see(Affine3A::from_rotation_translation(rotation(axis, 2.0), Vec3::new(5.0, -3.0, 1.0)));
    let mut seen = [0, 0];
    for (a, b) in colors(&plain).into_iter().zip(colors(&turned)) {
        for k in 0..3 {
            // 400 samples between 0 and about 1: five standard errors of at most 0.025 each.
            assert!((a[k] - b[k]).abs() < 0.18, "{a:?} {b:?}");
            seen[usize::from(a[k] < 0.7)] += 1;
        }
    }
    assert!(seen.iter().all(|n| *n > 10), "{seen:?}");
}
