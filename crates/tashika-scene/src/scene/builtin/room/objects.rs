//! Objects on the table and on the sideboard: the glossiest of the room.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Vec2, Vec3};

use super::materials::{GOLD, Palette, coated, glossy, matte, metal};
use super::{SIDEBOARD, TABLE};
use crate::color::Rgb;
use crate::error::Result;
use crate::math::elementary::{powf, rotation, sin_cos};
use crate::scene::Surface;
use crate::scene::builtin::shapes::{
    Ends, Shape, bevelled_box, cylinder, lathe, sphere, superellipsoid, torus, torus_knot, tube,
};
use crate::scene::builtin::stage::Stage;

/// Phong exponents of the row on the sideboard, from satin to nearly a mirror.
const EXPONENTS: [f32; 5] = [5.0, 20.0, 80.0, 300.0, 1000.0];

/// Adds everything on the table and on the sideboard.
pub fn build(stage: &mut Stage, palette: &Palette) -> Result<()> {
    tea(stage, palette)?;
    fruit(stage, palette)?;
    sculptures(stage, palette)?;
    row_of_exponents(stage, palette)
}

/// Smooth profile through `points` (radius, height; m), by Catmull and Rom's splines (1974).
fn spline(points: &[[f32; 2]], steps: usize) -> Vec<Vec2> {
    let p = |i: isize| Vec2::from(points[i.clamp(0, points.len() as isize - 1) as usize]);
    let mut curve = Vec::new();
    for i in 0..points.len() as isize - 1 {
        for s in 0..steps {
            let t = s as f32 / steps as f32;
            let (a, b, c, d) = (p(i - 1), p(i), p(i + 1), p(i + 2));
            let q = 2.0 * b + (c - a) * t + (2.0 * a - 5.0 * b + 4.0 * c - d) * t * t;
            let q = q + (3.0 * b - a - 3.0 * c + d) * t * t * t;
            curve.push((0.5 * q).max(Vec2::new(0.0, f32::NEG_INFINITY)));
        }
    }
    curve.push(p(points.len() as isize - 1));
    curve
}

/// Profile of an open vessel: a smooth outside, a flat rim, and a smooth inside.
fn vessel(outside: &[[f32; 2]], inside: &[[f32; 2]], steps: usize) -> Vec<Vec2> {
    let (mut profile, inner) = (spline(outside, steps), spline(inside, steps));
    // The points at the rim and around the foot are repeated, which makes creases there.
    profile.extend(profile.last().copied());
    profile.insert(0, Vec2::new(0.0, outside[0][1]));
    profile.insert(1, profile[1]);
    profile.push(inner[0]);
    profile.extend(inner);
    profile
}

/// Point of the cubic with end points `b[0]`, `b[3]` and handles `b[1]`, `b[2]` (Bézier).
fn bezier(b: [Vec3; 4], t: f32) -> Vec3 {
    let s = 1.0 - t;
    b[0] * (s * s * s) + b[1] * (3.0 * s * s * t) + b[2] * (3.0 * s * t * t) + b[3] * (t * t * t)
}

fn teapot() -> Shape {
    let body = [
        [0.0, 0.0],
        [0.045, 0.0],
        [0.052, 0.004],
        [0.078, 0.03],
        [0.088, 0.065],
        [0.078, 0.10],
        [0.052, 0.122],
        [0.046, 0.125],
    ];
    let lid = [
        [0.05, 0.124],
        [0.045, 0.13],
        [0.025, 0.140],
        [0.010, 0.145],
        [0.008, 0.150],
        [0.015, 0.158],
        [0.013, 0.168],
        [0.0, 0.172],
    ];
    let spout = [[0.07, 0.045], [0.115, 0.045], [0.105, 0.10], [0.145, 0.122]]
        .map(|p: [f32; 2]| Vec3::new(p[0], p[1], 0.0));
    let handle = [[-0.068, 0.105], [-0.15, 0.13], [-0.15, 0.03], [-0.076, 0.04]]
        .map(|p: [f32; 2]| Vec3::new(p[0], p[1], 0.0));
    let curve = |b: [Vec3; 4]| (0..=40).map(|k| bezier(b, k as f32 / 40.0)).collect::<Vec<_>>();
    Shape::merged([
        lathe(&spline(&body, 5), 56),
        lathe(&spline(&lid, 5), 40),
        tube(&curve(spout), Ends::Open, 20, |t| 0.022 - 0.013 * t),
        tube(&curve(handle), Ends::Open, 16, |t| 0.006 + 0.002 * sin_cos(PI * t).0),
    ])
}

/// Creates a cup with its saucer.
fn cup() -> Shape {
    let (under, upper) = (
        [[0.03, 0.0], [0.055, 0.005], [0.069, 0.0145]],
        [[0.068, 0.016], [0.055, 0.009], [0.03, 0.004], [0.0, 0.004]],
    );
    let outside = [[0.018, 0.0045], [0.024, 0.012], [0.036, 0.035], [0.041, 0.060]];
    let inside = [[0.0395, 0.060], [0.034, 0.036], [0.022, 0.016], [0.0, 0.012]];
    let handle = [[0.036, 0.05], [0.066, 0.055], [0.062, 0.02], [0.031, 0.025]]
        .map(|p: [f32; 2]| Vec3::new(p[0], p[1], 0.0));
    let path: Vec<Vec3> = (0..=24).map(|k| bezier(handle, k as f32 / 24.0)).collect();
    Shape::merged([
        lathe(&vessel(&under, &upper, 3), 40),
        lathe(&vessel(&outside, &inside, 4), 40),
        tube(&path, Ends::Open, 10, |_| 0.0035),
    ])
}

fn tea(stage: &mut Stage, palette: &Palette) -> Result<()> {
    let glaze = stage.material("teapot glaze", glossy(Rgb::new(0.04, 0.13, 0.24), 0.30, 80.0))?;
    let turn = rotation(Vec3::Y, 0.5);
    let at = TABLE + Vec3::new(0.12, 0.0, -0.06);
    stage.put("teapot", glaze, teapot().moved(Affine3A::from_rotation_translation(turn, at)))?;
    let place = |x: f32, z: f32, angle: f32| {
        Affine3A::from_rotation_translation(rotation(Vec3::Y, angle), TABLE + Vec3::new(x, 0.0, z))
    };
    let places = [place(0.37, 0.12, 0.8), place(-0.10, 0.24, 2.4), place(-0.02, -0.30, -1.9)];
    stage.repeat("cup", palette.porcelain, cup(), &places)
}

/// Adds a bowl of plastic apples.
fn fruit(stage: &mut Stage, palette: &Palette) -> Result<()> {
    let at = TABLE + Vec3::new(-0.38, 0.0, -0.05);
    let outside = [[0.055, 0.0], [0.06, 0.006], [0.12, 0.04], [0.155, 0.085]];
    let inside = [[0.150, 0.085], [0.115, 0.045], [0.06, 0.014], [0.0, 0.010]];
    stage.put("bowl", palette.porcelain, lathe(&vessel(&outside, &inside, 6), 56).at(at))?;

    let apple = lathe(
        &(0..=28)
            .map(|k| {
                let angle = PI * k as f32 / 28.0;
                let (sin, cos) = sin_cos(angle);
                // The profile of a sphere, with dents at both poles.
                let radius = if k == 0 || k == 28 { 0.0 } else { 0.04 * powf(sin, 0.8) };
                Vec2::new(radius, -0.036 * cos * (1.0 - 0.35 * powf(cos.abs(), 6.0)))
            })
            .collect::<Vec<_>>(),
        36,
    );
    let place = |x: f32, y: f32, z: f32, tilt: f32| {
        let turn = rotation(Vec3::X, tilt) * rotation(Vec3::Z, 0.7 * tilt);
        Affine3A::from_rotation_translation(turn, at + Vec3::new(x, y, z))
    };
    let red = stage.material("red plastic", coated(Rgb::new(0.52, 0.045, 0.03), 0.06))?;
    let reds = [
        place(-0.052, 0.066, 0.015, 0.3),
        place(0.040, 0.066, 0.040, -0.5),
        place(-0.002, 0.118, -0.005, 0.8),
    ];
    stage.repeat("apple", red, apple.clone(), &reds)?;
    let green = stage.material("green plastic", coated(Rgb::new(0.24, 0.42, 0.04), 0.06))?;
    let greens = [place(0.030, 0.066, -0.046, 0.4), place(-0.055, 0.075, -0.068, -0.2)];
    stage.repeat("green apple", green, apple, &greens)
}

/// Adds a golden knot, a torus and a glass ball on the table, with two books under the ball.
fn sculptures(stage: &mut Stage, palette: &Palette) -> Result<()> {
    let gold = stage.material("gold", metal(GOLD, 0.15))?;
    let stand = TABLE + Vec3::new(0.58, 0.0, -0.20);
    let plinth = bevelled_box(Vec3::new(-0.06, 0.0, -0.06), Vec3::new(0.06, 0.03, 0.06), 0.004);
    stage.put("plinth", palette.black, plinth.at(stand))?;
    let knot = torus_knot([2, 3], [0.075, 0.038], 0.020, [220, 18]).turned(rotation(Vec3::X, 0.5 * PI));
    stage.put("golden knot", gold, knot.at(stand + Vec3::Y * (0.03 + 0.128)))?;

    let satin = stage.material("satin", glossy(Rgb::new(0.40, 0.30, 0.08), 0.35, 20.0))?;
    let ring = torus(0.062, 0.020, 72, 24);
    stage.put("ring", satin, ring.at(TABLE + Vec3::new(0.16, 0.0202, 0.25)))?;

    let cloth = stage.material("table books", glossy(Rgb::new(0.42, 0.08, 0.05), 0.08, 40.0))?;
    let books = TABLE + Vec3::new(0.60, 0.0, 0.14);
    let book = |y: f32, half: Vec2, angle: f32| {
        let shape = bevelled_box(Vec3::new(-half.x, 0.0, -half.y), Vec3::new(half.x, 0.028, half.y), 0.002);
        shape.turned(rotation(Vec3::Y, angle)).at(books + Vec3::Y * y)
    };
    stage.put("table books", cloth, book(0.0, Vec2::new(0.11, 0.08), 0.25))?;
    stage.put("upper book", palette.paper, book(0.0285, Vec2::new(0.095, 0.07), -0.1))?;
    let glass = Surface::Glass {
        ior: 1.5,
        reflectance: Rgb::WHITE,
        transmittance: Rgb::new(0.94, 0.97, 0.96),
        facets: 0.0.into(),
    };
    let glass = stage.material("glass", glass)?;
    stage.put("glass ball", glass, sphere(0.055, 56, 28).at(books + Vec3::Y * (0.057 + 0.0555)))
}

/// Adds five balls on rings that differ only in their Phong exponent, between a vase of twigs and a
/// radio.
fn row_of_exponents(stage: &mut Stage, palette: &Palette) -> Result<()> {
    const RADIUS: f32 = 0.1;
    let ball = sphere(RADIUS, 48, 24);
    let place = |k: usize| SIDEBOARD + Vec3::new(-0.46 + 0.24 * k as f32, 0.0, 0.24);
    for (k, exponent) in EXPONENTS.into_iter().enumerate() {
        let name = format!("ball of exponent {exponent}");
        let material = stage.material(&name, glossy(Rgb::new(0.13, 0.16, 0.20), 0.55, exponent))?;
        stage.put(&name, material, ball.clone().at(place(k) + Vec3::Y * (RADIUS + 0.012)))?;
    }
    let places = [0, 1, 2, 3, 4].map(|k| Affine3A::from_translation(place(k) + Vec3::Y * 0.012));
    stage.repeat("stand", palette.brass, torus(0.052, 0.012, 48, 12), &places)?;

    let outside = [[0.055, 0.0], [0.062, 0.012], [0.075, 0.10], [0.055, 0.20], [0.028, 0.28], [0.034, 0.34]];
    let inside = [[0.030, 0.34], [0.022, 0.28], [0.012, 0.272], [0.0, 0.27]];
    let vase = lathe(&vessel(&outside, &inside, 6), 64);
    let glaze = stage.material("vase glaze", glossy(Rgb::new(0.10, 0.22, 0.16), 0.35, 300.0))?;
    stage.put("vase", glaze, vase.at(SIDEBOARD + Vec3::new(-0.71, 0.0, 0.20)))?;
    twigs(stage, SIDEBOARD + Vec3::new(-0.71, 0.27, 0.20))?;

    let body = superellipsoid(Vec3::new(0.075, 0.05, 0.055), [0.3, 0.3], 48, 24).at(Vec3::Y * 0.05);
    let dial =
        cylinder(0.03, 0.004, 48).turned(rotation(Vec3::X, 0.5 * PI)).at(Vec3::new(0.02, 0.055, 0.053));
    let radio =
        Affine3A::from_rotation_translation(rotation(Vec3::Y, -0.3), SIDEBOARD + Vec3::new(0.72, 0.0, 0.2));
    stage.put("radio", palette.porcelain, body.moved(radio))?;
    stage.put("dial", palette.brass, dial.moved(radio))
}

/// Adds dry twigs that fan out of a vase whose inner bottom is at `at`.
fn twigs(stage: &mut Stage, at: Vec3) -> Result<()> {
    let mut all = Shape::default();
    for k in 0..7 {
        let (sin, cos) = sin_cos(TAU * k as f32 / 7.0 + 0.4);
        let reach = 0.10 + 0.02 * (k % 3) as f32;
        let tall = 0.34 + 0.05 * (k % 4) as f32;
        let way = Vec3::new(cos, 0.0, sin);
        let path: Vec<Vec3> = (0..=20)
            .map(|i| {
                let t = i as f32 / 20.0;
                at + way * (0.012 * (1.0 - t) + reach * t * t) + Vec3::Y * tall * t
            })
            .collect();
        all.append(tube(&path, Ends::Open, 6, |t| 0.0025 - 0.0012 * t));
        for i in [9usize, 12, 15, 18, 20] {
            all.append(sphere(0.009, 8, 6).at(path[i] + Vec3::new(0.008 * sin, 0.0, -0.008 * cos)));
        }
    }
    let dry = stage.material("twigs", matte(Rgb::new(0.42, 0.27, 0.14)))?;
    stage.put("twigs", dry, all)
}
