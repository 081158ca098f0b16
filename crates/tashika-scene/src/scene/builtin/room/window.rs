//! The window: frame, venetian blinds, curtains, and the light outside.

use std::f32::consts::TAU;

use glam::{Affine3A, Quat, Vec3};

use super::materials::{Palette, glossy, matte};
use super::{WALL, WINDOW};
use crate::color::Rgb;
use crate::error::Result;
use crate::math::elementary::{rotation, sin_cos};
use crate::scene::builtin::shapes::{Ends, Shape, bevelled_box, cylinder, grid, quad, sphere, tube};
use crate::scene::builtin::stage::Stage;
use crate::scene::{Emitter, Falloff, FalloffShape};

/// Radiance of the panel that represents the sky (W·m⁻²·sr⁻¹).
const SKY: Rgb = Rgb::new(3.7, 5.2, 7.4);
/// Distance of the panel from the inner side of the wall (m).
const SKY_DISTANCE: f32 = 1.4;
/// Irradiance on a surface in the window that faces the sun (W·m⁻²).
const SUN: Rgb = Rgb::new(44.0, 34.0, 22.5);
/// Direction from the window to the sun.
const TO_SUN: Vec3 = Vec3::new(-0.77, 0.64, 0.10);
/// Distance of the sun (m): large enough that the stripes of light are nearly parallel and the cone
/// is narrow.
const SUN_DISTANCE: f32 = 9.0;
/// Angle between a slat and the horizontal (radians), the outer edge up.
const SLAT_TILT: f32 = 0.50;
/// Vertical distance between slats (m).
const SLAT_PITCH: f32 = 0.062;
/// Width of a slat (m).
const SLAT_WIDTH: f32 = 0.066;

/// Adds frame, blinds, curtains and daylight.
pub fn build(stage: &mut Stage, palette: &Palette) -> Result<()> {
    frame(stage, palette)?;
    blinds(stage)?;
    curtains(stage, palette)?;
    daylight(stage)
}

fn frame(stage: &mut Stage, palette: &Palette) -> Result<()> {
    let ([lo_y, hi_y], [lo_z, hi_z]) = (WINDOW.height, WINDOW.along);
    let bar = |y: [f32; 2], z: [f32; 2]| {
        bevelled_box(Vec3::new(-WALL + 0.01, y[0], z[0]), Vec3::new(-WALL + 0.06, y[1], z[1]), 0.006)
    };
    const BAR: f32 = 0.05;
    let middle = 0.5 * (lo_z + hi_z);
    let sill = bevelled_box(
        Vec3::new(0.0, lo_y - 0.035, lo_z - 0.06),
        Vec3::new(0.07, lo_y + 0.002, hi_z + 0.06),
        0.006,
    );
    let parts = [
        bar([lo_y, hi_y], [lo_z, lo_z + BAR]),
        bar([lo_y, hi_y], [hi_z - BAR, hi_z]),
        bar([lo_y, lo_y + BAR], [lo_z + BAR, hi_z - BAR]),
        bar([hi_y - BAR, hi_y], [lo_z + BAR, hi_z - BAR]),
        bar([lo_y + BAR, hi_y - BAR], [middle - 0.5 * BAR, middle + 0.5 * BAR]),
        sill,
    ];
    stage.put("window frame", palette.paint, Shape::merged(parts))
}

/// Adds two blinds beside each other: arched slats on cords, between a head rail and a bottom rail.
fn blinds(stage: &mut Stage) -> Result<()> {
    const X: f32 = -0.04;
    let ([lo_y, hi_y], [lo_z, hi_z]) = (WINDOW.height, WINDOW.along);
    let length = 0.5 * (hi_z - lo_z) - 0.03;
    let centers = [0.25, 0.75].map(|t| lo_z + t * (hi_z - lo_z));
    let top = hi_y - 0.07;
    let count = ((top - lo_y - 0.05) / SLAT_PITCH) as usize;

    let slat = grid([10, 6], [Ends::Open; 2], |i, j| {
        let (s, t) = (i as f32 / 10.0 - 0.5, j as f32 / 6.0 - 0.5);
        // An arch of 3 mm across the slat.
        Vec3::new(SLAT_WIDTH * t, 0.003 * (1.0 - 4.0 * t * t), length * s)
    });
    let tilt = rotation(Vec3::Z, -SLAT_TILT);
    let places: Vec<Affine3A> = (0..count)
        .flat_map(|k| centers.map(|z| Vec3::new(X, top - SLAT_PITCH * (k as f32 + 0.6), z)))
        .map(|at| Affine3A::from_rotation_translation(tilt, at))
        .collect();
    let white = stage.material("slats", glossy(Rgb::new(0.66, 0.65, 0.62), 0.10, 20.0))?;
    stage.repeat("slat", white, slat, &places)?;

    let bottom = top - SLAT_PITCH * (count as f32 + 0.4);
    let mut fittings = Shape::default();
    for z in centers {
        let half = 0.5 * length;
        for [low, high] in [[top, hi_y - 0.004], [bottom - 0.012, bottom]] {
            let (lo, hi) = (Vec3::new(X - 0.025, low, z - half), Vec3::new(X + 0.025, high, z + half));
            fittings.append(bevelled_box(lo, hi, 0.003));
        }
        for (dz, dx) in [(-0.35, -0.022), (-0.35, 0.022), (0.35, -0.022), (0.35, 0.022)] {
            let cord = cylinder(0.0012, top - bottom, 6);
            fittings.append(cord.at(Vec3::new(X + dx, bottom, z + dz * length)));
        }
    }
    stage.put("rails and cords", white, fittings)
}

/// Adds linen on both sides of the window, on a rod; the second curtain is a mirror image of the
/// first.
fn curtains(stage: &mut Stage, palette: &Palette) -> Result<()> {
    const ROD: f32 = 2.62;
    const X: f32 = 0.125;
    const LENGTH: f32 = 2.56;
    let cloth = grid([84, 32], [Ends::Open; 2], |i, j| {
        let (s, t) = (i as f32 / 84.0, j as f32 / 32.0);
        // Folds open downwards and sway slightly; the cloth hangs from the rod at t = 1.
        let drop = 1.0 - t;
        let depth = 0.016 + 0.028 * drop.sqrt();
        let sway = 0.5 * sin_cos(3.1 * drop + 9.0 * s).0 * drop;
        let width = 0.46 + 0.08 * drop;
        let fold = sin_cos(TAU * 7.0 * s + sway).0 + 0.25 * sin_cos(TAU * 3.0 * s + 2.0 * drop).0;
        Vec3::new(depth * fold, LENGTH * t, -width * s)
    });
    let linen = stage.material("linen", matte(Rgb::new(0.66, 0.60, 0.50)))?;
    let [lo_z, hi_z] = WINDOW.along;
    let places = [
        Affine3A::from_translation(Vec3::new(X, ROD - LENGTH, lo_z + 0.06)),
        Affine3A::from_scale_rotation_translation(
            Vec3::new(1.0, 1.0, -1.0),
            Quat::IDENTITY,
            Vec3::new(X, ROD - LENGTH, hi_z - 0.06),
        ),
    ];
    stage.repeat("curtain", linen, cloth, &places)?;

    let (from, to) = (Vec3::new(X, ROD, lo_z - 0.62), Vec3::new(X, ROD, hi_z + 0.62));
    let mut rod = tube(&[from, to], Ends::Open, 16, |_| 0.012);
    for end in [from, to] {
        rod.append(sphere(0.024, 24, 12).at(end));
        let inner = end.lerp(0.5 * (from + to), 0.04);
        rod.append(tube(&[inner.with_x(0.0), inner], Ends::Open, 12, |_| 0.008));
    }
    stage.put("curtain rod", palette.brass, rod)
}

/// Adds a sky panel outside and a sun above it, both visible only through the window.
///
/// The sun is a spot light whose cone covers little more than the window. With parallel light,
/// nearly all light paths would hit the roof.
fn daylight(stage: &mut Stage) -> Result<()> {
    let ([lo_y, hi_y], [lo_z, hi_z]) = (WINDOW.height, WINDOW.along);
    let sky = stage.emissive("sky", SKY)?;
    let (lo, hi) = (Vec3::new(-SKY_DISTANCE, 0.2, lo_z - 0.85), Vec3::new(-SKY_DISTANCE, 2.68, hi_z + 0.85));
    let (up, along) = (Vec3::Y * (hi.y - lo.y), Vec3::Z * (hi.z - lo.z));
    stage.put("sky", sky, quad(lo, [up, along]))?;

    // The sun is aimed at a point above the sill, since the sky panel blocks the light further
    // down.
    let target = Vec3::new(-0.5 * WALL, 0.3 * lo_y + 0.7 * hi_y, 0.5 * (lo_z + hi_z));
    let to_sun = TO_SUN.normalize();
    let cone =
        |half_width: f32| SUN_DISTANCE / (SUN_DISTANCE * SUN_DISTANCE + half_width * half_width).sqrt();
    let half_width = 0.5 * (hi_z - lo_z);
    stage.emitter(Emitter::Spot {
        position: target + to_sun * SUN_DISTANCE,
        axis: -to_sun,
        intensity: SUN * (SUN_DISTANCE * SUN_DISTANCE),
        falloff: Falloff {
            cos_inner: cone(half_width + 0.1),
            cos_outer: cone(half_width + 0.25),
            shape: FalloffShape::Squared,
        },
    })
}
