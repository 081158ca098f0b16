//! Closed rooms whose walls all emit `L_e` and reflect `ρ`. For any shape of the room, the radiance
//! is `L_e / (1 − ρ)` everywhere.
//!
//! A z-test compares the mean over independent VPL sets with this value. In a sphere, `cos θ cos φ
//! / d²` is constant, so every VPL contributes the same and the test is precise to a few parts in
//! ten thousand. In a box, the unclamped sum varies more.

use std::f32::consts::PI;

use tashika::accel::Tracer;
use tashika::integrator::{FullSum, PathStop, PathTracer};
use tashika::math::Vec3;
use tashika::math::elementary::sin_cos;
use tashika::scene::{Camera, MeshData};
use tashika::stats::Moments;
use tashika::vpl::{Clamp, VplOptions, VplSet};

use crate::cases::{builder, cuboid, film, glowing, lambert, luminances, place, tracer};

const EMITTED: f32 = 0.8;
const REFLECTANCE: f32 = 0.6;
const EXPECTED: f64 = 2.0;

fn sphere(rows: u32, columns: u32) -> MeshData {
    let mut positions = Vec::new();
    for i in 0..=rows {
        for j in 0..columns {
            let (sin_theta, cos_theta) = sin_cos(PI * i as f32 / rows as f32);
            let (sin_phi, cos_phi) = sin_cos(2.0 * PI * j as f32 / columns as f32);
            let pole = i == 0 || i == rows;
            let r = if pole { 0.0 } else { sin_theta };
            positions.push(Vec3::new(
                r * cos_phi,
                if pole { cos_theta.signum() } else { cos_theta },
                r * sin_phi,
            ));
        }
    }
    let mut triangles = Vec::new();
    for i in 0..rows {
        for j in 0..columns {
            let at = |i: u32, j: u32| i * columns + j % columns;
            if i > 0 {
                triangles.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
            }
            if i + 1 < rows {
                triangles.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
    MeshData { positions, triangles, ..MeshData::default() }
}

/// The furnace, with a camera inside that looks along `−z` with field of view `fov`.
fn furnace(mut mesh: MeshData, fov: f32) -> Tracer {
    let centroid =
        |m: &MeshData, t: &[u32; 3]| t.iter().map(|&i| m.positions[i as usize]).sum::<Vec3>() / 3.0;
    // Turns all triangles so that their normals point inward.
    for k in 0..mesh.triangles.len() {
        let t = mesh.triangles[k];
        let v = t.map(|i| mesh.positions[i as usize]);
        if (v[1] - v[0]).cross(v[2] - v[0]).dot(centroid(&mesh, &t)) > 0.0 {
            mesh.triangles[k].swap(1, 2);
        }
    }
    let mut b = builder();
    place(&mut b, mesh, glowing("wall", lambert(REFLECTANCE), EMITTED));
    b.add_camera(Camera::look_at("c", Vec3::ZERO, Vec3::NEG_Z, Vec3::Y, fov)).unwrap();
    tracer(b)
}

/// Mean and standard error of each pixel over independent sets.
fn over_sets(tracer: &Tracer, sets: u64, count: u64, seed: u64) -> Vec<Moments> {
    let mut pixels = vec![Moments::default(); 16];
    for k in 0..sets {
        let options =
            VplOptions { count, seed: seed + k, clamp: Clamp::Off, max_depth: 1000, ..VplOptions::default() };
        let set = VplSet::trace(tracer, &options).unwrap();
        for (m, l) in pixels.iter_mut().zip(luminances(&film(tracer, &FullSum::new(&set), [4, 4], 2, k))) {
            m.push(l);
        }
    }
    pixels
}

/// Largest permitted |z|, for a two-sided level of 10⁻⁵ in each of 16 pixels.
const Z: f64 = 4.42;

#[test]
fn a_sphere_is_filled_with_constant_radiance() {
    let tracer = furnace(sphere(48, 96), 0.9);
    for (i, m) in over_sets(&tracer, 400, 1000, 100).iter().enumerate() {
        // The test is precise enough to detect that two percent of the indirect light are missing,
        // a change of 0.014.
        assert!(m.standard_error() < 0.0025, "sharp: {}", m.standard_error());
        let z = (m.mean() - EXPECTED) / m.standard_error();
        assert!(z.abs() < Z, "pixel {i}: {} ± {}", m.mean(), m.standard_error());
    }
}

#[test]
fn a_box_is_filled_with_constant_radiance() {
    // The camera sees the middle of a wall. Near the edges, the unclamped 1/d² has no finite
    // variance, so a z-test would not be valid.
    let tracer = furnace(cuboid(Vec3::new(-1.0, -1.2, -1.5), Vec3::new(1.1, 1.0, 1.3), true), 0.5);
    for (i, m) in over_sets(&tracer, 60, 400, 1000).iter().enumerate() {
        assert!(m.standard_error() < 0.1);
        let z = (m.mean() - EXPECTED) / m.standard_error();
        assert!(z.abs() < Z, "pixel {i}: {} ± {}", m.mean(), m.standard_error());
    }
}

#[test]
fn the_path_tracer_finds_the_same() {
    let tracer = furnace(sphere(24, 48), 0.9);
    let film = film(&tracer, &PathTracer::new(&tracer, PathStop::Count(2000), 1000).unwrap(), [4, 4], 1, 1);
    let errors = film.plane("standard_error").unwrap().f32_samples().unwrap();
    for (l, e) in luminances(&film).iter().zip(errors) {
        assert!(*e < 0.05 && (l - EXPECTED).abs() < Z * f64::from(*e), "{l} ± {e}");
    }
}
