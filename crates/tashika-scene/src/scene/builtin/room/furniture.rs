//! Table, chairs, sideboard and armchair.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Affine3A, Vec2, Vec3};

use super::materials::{Palette, coated, matte, varnished};
use super::{FLOOR, SIDEBOARD, TABLE};
use crate::color::Rgb;
use crate::error::Result;
use crate::math::elementary::{rotation, sin_cos};
use crate::scene::builtin::shapes::{
    Ends, Section, Shape, bevelled_box, creased, lathe, superellipsoid, sweep, tube,
};
use crate::scene::builtin::stage::Stage;

/// Adds table, chairs, sideboard and armchair.
pub fn build(stage: &mut Stage, palette: &Palette) -> Result<()> {
    table(stage, palette)?;
    chairs(stage, palette)?;
    sideboard(stage, palette)?;
    armchair(stage, palette)
}

/// Texture coordinates with the grain along `x` on all faces of an object made of boards.
fn grain_along_x(p: Vec3, n: Vec3) -> Vec2 {
    let across = if n.y.abs() > 0.5 { p.z } else { p.y };
    Vec2::new(0.5 * p.x, 1.3 * across)
}

/// Texture coordinates with the grain along `y`.
fn grain_along_y(p: Vec3, _: Vec3) -> Vec2 {
    Vec2::new(0.5 * p.y, 1.3 * (p.x + p.z))
}

/// Creates a round leg from the origin up to `height`, thicker at the top, which is shifted by
/// `lean` (m).
fn leg(height: f32, radii: [f32; 2], lean: Vec2) -> Shape {
    let [foot, top] = radii;
    let profile = creased(&[[0.0, 0.0], [foot - 0.002, 0.0], [foot, 0.002], [top, height], [0.0, height]]);
    let straight = lathe(&profile, 20).mapped(grain_along_y);
    let shear = Vec3::new(lean.x / height, 1.0, lean.y / height);
    straight.moved(Affine3A::from_cols(Vec3::X.into(), shear.into(), Vec3::Z.into(), Vec3::ZERO.into()))
}

fn table(stage: &mut Stage, palette: &Palette) -> Result<()> {
    const HALF: Vec2 = Vec2::new(0.80, 0.45);
    let [top, under] = [TABLE.y, TABLE.y - 0.032];
    let (low, high) = (Vec3::new(-HALF.x, under, -HALF.y), Vec3::new(HALF.x, top, HALF.y));
    let mut parts = vec![bevelled_box(low, high, 0.006).mapped(grain_along_x)];
    let [x, z] = [HALF.x - 0.12, HALF.y - 0.10];
    for side in [-1.0, 1.0] {
        let long = Vec3::new(x, 0.035, 0.011);
        let short = Vec3::new(0.011, 0.035, z);
        for (half, at) in [
            (long, Vec3::new(0.0, under - 0.035, side * z)),
            (short, Vec3::new(side * x, under - 0.035, 0.0)),
        ] {
            parts.push(bevelled_box(at - half, at + half, 0.003).mapped(grain_along_x));
        }
        for other in [-1.0, 1.0] {
            let lean = Vec2::new(-side * 0.05, -other * 0.05);
            let foot = Vec3::new(side * (x + 0.03), FLOOR, other * (z + 0.03));
            parts.push(leg(under - FLOOR, [0.014, 0.028], lean).at(foot));
        }
    }
    stage.put("table", palette.walnut, Shape::merged(parts).at(TABLE.with_y(0.0)))
}

/// Adds four chairs of wood and cloth around the table; the model faces `+z`.
fn chairs(stage: &mut Stage, palette: &Palette) -> Result<()> {
    const SEAT: f32 = 0.43;
    let mut wood = Shape::default();
    for side in [-1.0, 1.0] {
        wood.append(leg(SEAT, [0.010, 0.017], Vec2::new(-side * 0.03, -0.03)).at(Vec3::new(
            side * 0.21,
            0.0,
            0.20,
        )));
        // The back leg continues as the upright of the backrest.
        let path: Vec<Vec3> = (0..=20)
            .map(|k| {
                let t = k as f32 / 20.0;
                let bend = (t - 0.45) * (t - 0.45);
                Vec3::new(side * (0.20 - 0.02 * t), 0.84 * t, -0.15 - 0.38 * bend)
            })
            .collect();
        wood.append(tube(&path, Ends::Open, 14, |t| 0.011 + 0.007 * sin_cos(PI * t).0));
        let rail = [Vec3::new(side * 0.18, SEAT - 0.03, 0.17), Vec3::new(side * 0.18, SEAT - 0.03, -0.15)];
        wood.append(tube(&rail, Ends::Open, 12, |_| 0.011));
    }
    for (z, half) in [(0.17, 0.18), (-0.15, 0.19)] {
        let rail = [Vec3::new(-half, SEAT - 0.03, z), Vec3::new(half, SEAT - 0.03, z)];
        wood.append(tube(&rail, Ends::Open, 12, |_| 0.011));
    }
    for (height, half) in
        [(0.80, Vec2::new(0.035, 0.007)), (0.68, Vec2::new(0.018, 0.006)), (0.59, Vec2::new(0.018, 0.006))]
    {
        let t = height / 0.84;
        let back = -0.15 - 0.38 * (t - 0.45) * (t - 0.45);
        let path: Vec<Vec3> = (0..=24)
            .map(|k| {
                let s = k as f32 / 12.0 - 1.0;
                Vec3::new(0.185 * s, height, back - 0.035 * (1.0 - s * s))
            })
            .collect();
        let section = Section::superellipse(half, 0.5, 20, Vec3::Y);
        wood.append(sweep(&path, Ends::Open, &section, |_| 1.0));
    }
    let pad = superellipsoid(Vec3::new(0.215, 0.026, 0.205), [0.45, 0.4], 48, 16).at(Vec3::new(
        0.0,
        SEAT + 0.015,
        0.01,
    ));

    let around = |x: f32, z: f32, angle: f32| {
        let at = Vec3::new(TABLE.x + x, FLOOR, TABLE.z + z);
        Affine3A::from_rotation_translation(rotation(Vec3::Y, angle), at)
    };
    let places = [
        around(-0.38, -0.58, 0.06),
        around(0.40, -0.60, -0.10),
        around(-1.02, 0.06, FRAC_PI_2 + 0.12),
        around(0.30, 0.78, PI + 0.35),
    ];
    let cloth = stage.material("chair cloth", matte(Rgb::new(0.52, 0.47, 0.38)))?;
    stage.repeat("chair", palette.ash, wood, &places)?;
    stage.repeat("chair pad", cloth, pad, &places)
}

/// Adds a low cupboard with three doors at the back wall.
fn sideboard(stage: &mut Stage, palette: &Palette) -> Result<()> {
    const HALF_WIDTH: f32 = 0.85;
    const DEEP: f32 = 0.42;
    let top = SIDEBOARD.y;
    let board = |lo: [f32; 3], hi: [f32; 3]| {
        let shape = bevelled_box(Vec3::from(lo), Vec3::from(hi), 0.003);
        shape.mapped(grain_along_x).at(SIDEBOARD.with_y(0.0))
    };
    let (w, under, back) = (HALF_WIDTH, 0.17, 0.0);
    let mut body = Shape::merged([
        board([-w, top - 0.025, back], [w, top, DEEP]),
        board([-w, under, back], [w, under + 0.02, DEEP - 0.004]),
        board([-w, under + 0.02, back], [-w + 0.02, top - 0.025, DEEP - 0.004]),
        board([w - 0.02, under + 0.02, back], [w, top - 0.025, DEEP - 0.004]),
        board([-w + 0.02, under + 0.02, back], [w - 0.02, top - 0.025, 0.01]),
    ]);
    for (x, z) in [(-w + 0.1, 0.06), (w - 0.1, 0.06), (-w + 0.1, DEEP - 0.06), (w - 0.1, DEEP - 0.06)] {
        let lean = Vec2::new(-0.03 * x.signum(), 0.0);
        body.append(leg(under - FLOOR, [0.012, 0.022], lean).at(SIDEBOARD + Vec3::new(x, FLOOR - top, z)));
    }
    stage.put("sideboard", palette.walnut, body)?;

    let door_width = (2.0 * w - 0.04) / 3.0;
    let (mut doors, mut handles) = (Shape::default(), Shape::default());
    for k in 0..3 {
        let x = -w + 0.02 + door_width * k as f32;
        let (lo, hi) =
            ([x + 0.002, under + 0.023, DEEP - 0.028], [x + door_width - 0.002, top - 0.028, DEEP - 0.008]);
        doors.append(board(lo, hi));
        let grip = x + if k == 1 { 0.06 } else { door_width - 0.06 };
        let y = 0.5 * (under + top);
        let bow: Vec<Vec3> = (0..=16)
            .map(|i| {
                let t = i as f32 / 8.0 - 1.0;
                Vec3::new(grip, y + 0.07 * t, DEEP - 0.012 + 0.03 * (1.0 - t * t * t * t))
            })
            .collect();
        handles.append(tube(&bow, Ends::Open, 12, |_| 0.005).at(SIDEBOARD.with_y(0.0)));
    }
    let front = stage.material("doors", coated(Rgb::new(0.70, 0.67, 0.60), 0.08))?;
    stage.put("doors", front, doors)?;
    stage.put("handles", palette.brass, handles)
}

/// Adds a rounded armchair with two cushions, facing the table.
fn armchair(stage: &mut Stage, palette: &Palette) -> Result<()> {
    let place = Affine3A::from_rotation_translation(rotation(Vec3::Y, 0.85), Vec3::new(1.12, FLOOR, 1.25));
    let block = |half: [f32; 3], exponents: [f32; 2], at: [f32; 3], tilt: f32| {
        let shape = superellipsoid(Vec3::from(half), exponents, 48, 24);
        shape.turned(rotation(Vec3::X, tilt)).at(Vec3::from(at)).moved(place)
    };
    let shell = Shape::merged([
        block([0.40, 0.10, 0.38], [0.30, 0.25], [0.0, 0.26, 0.0], 0.0),
        block([0.075, 0.19, 0.39], [0.55, 0.35], [-0.38, 0.42, 0.0], 0.0),
        block([0.075, 0.19, 0.39], [0.55, 0.35], [0.38, 0.42, 0.0], 0.0),
        block([0.40, 0.33, 0.085], [0.40, 0.45], [0.0, 0.56, -0.33], -0.20),
    ]);
    let cloth = stage.material("armchair cloth", matte(Rgb::new(0.05, 0.24, 0.27)))?;
    stage.put("armchair", cloth, shell)?;
    let cushions = Shape::merged([
        block([0.295, 0.075, 0.31], [0.50, 0.35], [0.0, 0.415, 0.05], 0.03),
        block([0.29, 0.22, 0.085], [0.50, 0.50], [0.0, 0.66, -0.20], -0.26),
    ]);
    let lighter = stage.material("cushion cloth", matte(Rgb::new(0.08, 0.31, 0.33)))?;
    stage.put("cushions", lighter, cushions)?;
    let pillow = stage.material("pillow", matte(Rgb::new(0.66, 0.42, 0.08)))?;
    stage.put("pillow", pillow, block([0.20, 0.20, 0.06], [0.75, 0.75], [0.10, 0.63, -0.045], -0.42))?;

    let dark = stage.material("armchair legs", varnished(Rgb::new(0.30, 0.16, 0.09), palette.grain, 0.2))?;
    let mut legs = Shape::default();
    for (x, z) in [(-0.31, -0.29), (0.31, -0.29), (-0.31, 0.29), (0.31, 0.29)] {
        legs.append(leg(0.19, [0.013, 0.026], Vec2::ZERO).at(Vec3::new(x, 0.0, z)).moved(place));
    }
    stage.put("armchair legs", dark, legs)
}
