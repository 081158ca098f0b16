//! Shapes compared with their volumes, areas and normals.

use std::f64::consts::{PI, TAU};

use glam::{Affine3A, Vec2, Vec3};

use super::*;
use crate::math::elementary::rotation;

/// Volume inside a closed shape, positive if its triangles face outwards (m³): sum of signed
/// tetrahedra.
fn signed_volume(shape: &Shape) -> f64 {
    let corner = |i: u32| shape.positions[i as usize].as_dvec3();
    shape.triangles.iter().map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0).sum()
}

/// Area of a regular polygon of `n` corners relative to its circumscribed circle.
fn polygon_share(n: usize) -> f64 {
    let angle = TAU / n as f64;
    angle.sin() / angle
}

/// Volume of the polyhedron that `lathe` creates from `profile`: frusta with regular polygons as
/// sections.
fn lathe_volume(profile: &[Vec2], segments: usize) -> f64 {
    let frusta = profile.windows(2).map(|w| {
        let (r, s, h) = (f64::from(w[0].x), f64::from(w[1].x), f64::from(w[1].y - w[0].y));
        PI * h / 3.0 * (r * r + r * s + s * s)
    });
    polygon_share(segments) * frusta.sum::<f64>()
}

fn vase() -> Vec<Vec2> {
    [[0.0, 0.0], [0.4, 0.0], [0.4, 0.0], [0.7, 0.5], [0.3, 1.2], [0.45, 1.5], [0.0, 1.5]]
        .map(Vec2::from)
        .to_vec()
}

fn bent_path() -> Vec<Vec3> {
    (0..=64)
        .map(|k| {
            let t = k as f32 / 64.0;
            Vec3::new(2.0 * t, t * t, 0.4 * t * (1.0 - t))
        })
        .collect()
}

/// Closed shapes with the exact volume of the *polyhedron*.
fn polyhedra() -> Vec<(&'static str, Shape, f64)> {
    let (lo, hi) = (Vec3::new(-1.0, 2.0, 0.5), Vec3::new(1.0, 2.75, 3.5));
    let [a, b, c, bevel] = [2.0, 0.75, 3.0, 0.125];
    let bevelled =
        a * b * c - 2.0 * bevel * bevel * (a + b + c - 6.0 * bevel) - 20.0 / 3.0 * bevel * bevel * bevel;
    let mirror = Affine3A::from_scale(Vec3::new(-2.0, 1.0, 0.5));
    let meridian: Vec<Vec2> = (0..=24)
        .map(|j| Vec2::new((PI * f64::from(j) / 24.0).sin() as f32, -(PI * f64::from(j) / 24.0).cos() as f32))
        .collect();
    vec![
        ("box", box_between(lo, hi), a * b * c),
        ("bevelled box", bevelled_box(lo, hi, bevel as f32), bevelled),
        ("mirrored box", bevelled_box(lo, hi, bevel as f32).moved(mirror), bevelled),
        ("cylinder", cylinder(0.5, 2.0, 32), polygon_share(32) * PI * 0.5),
        ("lathe", lathe(&vase(), 40), lathe_volume(&vase(), 40)),
        ("sphere", sphere(1.0, 48, 24), lathe_volume(&meridian, 48)),
    ]
}

/// Closed smooth shapes with the volume of the *formula* and the largest relative loss of an
/// inscribed polyhedron. A chord that subtends the angle `δ` lies below the surface by `δ²/12` of
/// the radius on average. This reduces the volume of a cylinder by a share `δ²/6`, and that of a
/// ball by `δ²/4`, once for each of the two directions of tessellation.
fn smooth_solids() -> Vec<(&'static str, Shape, f64, f64)> {
    let loss = |cells: [usize; 2]| cells.iter().map(|&n| (TAU / n as f64).powi(2) / 4.0).sum::<f64>();
    let straight = [Vec3::ZERO, Vec3::new(0.0, 0.0, 2.0)];
    let tilted = Section::superellipse(Vec2::new(0.5, 0.25), 1.0, 64, Vec3::new(0.3, 1.0, 0.5));
    // Pappus' theorem: the volume of a tube is the area of its section times the length of the path
    // of the section's centroid, whether the path is curved or not.
    let path = bent_path();
    let length: f64 = path.windows(2).map(|w| f64::from((w[1] - w[0]).length())).sum();
    let knot: Vec<Vec3> = (0..=4000)
        .map(|k| {
            let t = TAU * f64::from(k) / 4000.0;
            let r = 0.5 + 0.2 * (3.0 * t).cos();
            Vec3::new(
                (r * (2.0 * t).cos()) as f32,
                0.2 * (3.0 * t).sin() as f32,
                (r * (2.0 * t).sin()) as f32,
            )
        })
        .collect();
    let knot_length: f64 = knot.windows(2).map(|w| f64::from((w[1] - w[0]).length())).sum();
    let beta = statrs::function::beta::beta;
    // Jaklič, Leonardis, Solina 2000, "Segmentation and Recovery of Superquadrics", equation 2.60.
    let super_volume =
        |a: f64, e: f64, f: f64| 2.0 * a * e * f * beta(e / 2.0 + 1.0, e) * beta(f / 2.0, f / 2.0);
    let half = Vec3::new(1.0, 0.5, 0.8);
    vec![
        ("torus", torus(1.0, 0.25, 96, 48), 2.0 * PI * PI * 0.0625, loss([96, 48])),
        ("ellipsoid", superellipsoid(half, [1.0; 2], 64, 64), 4.0 / 3.0 * PI * 0.4, loss([64, 128])),
        ("cushion", superellipsoid(half, [0.4, 0.5], 128, 96), super_volume(0.4, 0.4, 0.5), 0.01),
        ("octahedron", superellipsoid(half, [2.0; 2], 64, 64), 4.0 / 3.0 * 0.4, 1e-5),
        ("straight tube", tube(&straight, Ends::Open, 64, |_| 0.5), PI * 0.5, loss([64, 100_000])),
        ("elliptic bar", sweep(&straight, Ends::Open, &tilted, |_| 1.0), PI * 0.25, loss([64, 100_000])),
        ("bent tube", tube(&path, Ends::Open, 64, |_| 0.1), PI * 0.01 * length, loss([64, 128])),
        (
            "torus knot",
            torus_knot([2, 3], [0.5, 0.2], 0.05, [400, 48]),
            PI * 0.0025 * knot_length,
            loss([100, 48]),
        ),
    ]
}

#[test]
fn solids_have_the_volume_of_their_formula() {
    for (name, shape, volume) in polyhedra() {
        let got = signed_volume(&shape);
        // A few hundred f32 terms of magnitude 10 m³ at most, over volumes of 1 m³.
        assert!((got - volume).abs() < 1e-5 * volume.max(1.0), "{name}: {got}, expected {volume}");
    }
    for (name, shape, volume, loss) in smooth_solids() {
        let missing = 1.0 - signed_volume(&shape) / volume;
        assert!(
            missing > -1e-5 && missing < loss,
            "{name}: misses {missing} of its volume, at most {loss} allowed"
        );
    }
}

/// For each edge of a closed shape, one triangle uses it in one direction and one in the opposite
/// direction.
#[test]
fn solids_are_closed() {
    let all =
        polyhedra().into_iter().map(|s| (s.0, s.1)).chain(smooth_solids().into_iter().map(|s| (s.0, s.1)));
    for (name, shape) in all {
        let key = |i: u32| shape.positions[i as usize].to_array().map(|c| (c + 0.0).to_bits());
        let mut edges = std::collections::BTreeMap::new();
        for t in &shape.triangles {
            for [a, b] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
                *edges.entry((key(a), key(b))).or_insert(0) += 1;
            }
        }
        assert!(edges.iter().all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1)), "{name}");
    }
}

#[test]
fn normals_agree_with_the_winding() {
    let sheet = grid([20, 10], [Ends::Open; 2], |i, j| {
        let (x, z) = (i as f32 * 0.1, j as f32 * 0.1);
        Vec3::new(x, 0.1 * (3.0 * f64::from(x)).sin() as f32, -z)
    });
    assert!(sheet.normals.iter().all(|n| n.y > 0.5), "front of a sheet: ∂i × ∂j");
    assert!(disk(1.0, 12).normals.iter().all(|n| (*n - Vec3::Y).length() < 1e-6));
    let solids =
        polyhedra().into_iter().map(|s| (s.0, s.1)).chain(smooth_solids().into_iter().map(|s| (s.0, s.1)));
    for (name, shape) in solids.chain([("sheet", sheet)]) {
        assert_eq!(
            (shape.normals.len(), shape.uvs.len()),
            (shape.positions.len(), shape.positions.len()),
            "{name}"
        );
        assert!(shape.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5), "{name}: unit normals");
        for t in &shape.triangles {
            let p = t.map(|i| shape.positions[i as usize]);
            let face = (p[1] - p[0]).cross(p[2] - p[0]).normalize();
            assert!(t.iter().all(|&i| shape.normals[i as usize].dot(face) > 0.0), "{name}: {p:?}");
        }
    }
}

#[test]
fn smooth_normals_are_those_of_the_surface_and_creases_stay_sharp() {
    let ball = sphere(2.0, 48, 24);
    // A vertex normal averages cells symmetrically; across rows of angle δ its error is below δ².
    let tolerance = (TAU as f32 / 48.0).powi(2);
    for (p, n) in ball.positions.iter().zip(&ball.normals) {
        assert!((*n - *p / 2.0).length() < tolerance, "{p} {n}");
    }
    let ring = torus(1.0, 0.3, 64, 48);
    for (p, n) in ring.positions.iter().zip(&ring.normals) {
        let center = Vec3::new(p.x, 0.0, p.z).normalize();
        assert!((*n - (*p - center) / 0.3).length() < tolerance);
    }
    let up = [Vec3::ZERO, Vec3::Y];
    let bar = Section::superellipse(Vec2::ONE, 1.0, 24, Vec3::X);
    let sharp = |n: &Vec3| n.y.abs() < 1e-6 || n.y.abs() > 1.0 - 1e-6;
    for (name, can) in [("lathe", cylinder(1.0, 1.0, 32)), ("sweep", sweep(&up, Ends::Open, &bar, |_| 1.0))] {
        assert!(can.normals.iter().all(sharp), "{name}: rims are creases");
    }
}

#[test]
fn moving_a_shape_moves_normals_with_the_surface() {
    let map = Affine3A::from_scale_rotation_translation(
        Vec3::new(1.0, -3.0, 0.5),
        rotation(Vec3::X, 0.7),
        Vec3::new(4.0, 5.0, 6.0),
    );
    let still = torus(1.0, 0.3, 32, 24);
    let shape = still.clone().moved(map);
    for (before, after) in still.normals.iter().zip(&shape.normals) {
        let (t, b) = before.any_orthonormal_pair();
        let [t, b, n] = [t, b, *before].map(|v| map.transform_vector3(v).normalize());
        assert!(after.dot(t).abs() < 1e-5 && after.dot(b).abs() < 1e-5, "tangents stay tangents");
        assert!(after.dot(n) > 0.0, "outside stays outside");
    }
    for t in &shape.triangles {
        let p = t.map(|i| shape.positions[i as usize]);
        let face = (p[1] - p[0]).cross(p[2] - p[0]);
        assert!(
            t.iter().map(|&i| shape.normals[i as usize]).sum::<Vec3>().dot(face) > 0.0,
            "mirrored winding"
        );
    }
}
