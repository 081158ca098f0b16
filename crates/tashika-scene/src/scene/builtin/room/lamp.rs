//! The pendant lamp over the table: a warm bulb in a shade of slats.

use std::f32::consts::TAU;

use glam::{Affine3A, Vec3};

use super::materials::{Palette, matte};
use super::{HEIGHT, LAMP};
use crate::color::Rgb;
use crate::error::Result;
use crate::math::elementary::{powf, rotation, sin_cos};
use crate::scene::builtin::shapes::{Ends, Shape, creased, cylinder, grid, lathe, sphere, torus, tube};
use crate::scene::builtin::stage::Stage;

/// Radiance of the bulb (W·m⁻²·sr⁻¹).
const BULB: Rgb = Rgb::new(560.0, 385.0, 215.0);
/// Radius of the bulb (m).
const BULB_RADIUS: f32 = 0.08;
/// Number of slats around the shade.
const SLATS: usize = 30;
/// Half the height of the shade (m).
const HALF_HEIGHT: f32 = 0.17;

/// Radius of the shade (m) at a relative height from −1 (bottom) to 1 (top).
fn shade_radius(t: f32) -> f32 {
    let round = (1.0 - powf((0.92 * t).abs(), 2.4)).max(0.0).sqrt();
    0.055 + 0.165 * round
}

/// Adds the lamp, with the centre of its bulb at [`LAMP`].
pub fn build(stage: &mut Stage, palette: &Palette) -> Result<()> {
    let bulb = stage.emissive("bulb", BULB)?;
    stage.put("bulb", bulb, sphere(BULB_RADIUS, 32, 16).at(LAMP))?;

    let slat = grid([2, 28], [Ends::Open; 2], |i, j| {
        let (s, t) = (0.5 * i as f32 - 0.5, j as f32 / 14.0 - 1.0);
        // The width of a slat is proportional to the radius of the shade, so that the gaps take the
        // same share of the circumference at every height.
        let radius = shade_radius(t);
        Vec3::new(radius, HALF_HEIGHT * t, -0.5 * TAU * radius / SLATS as f32 * s)
    });
    let turns = (0..SLATS).map(|k| rotation(Vec3::Y, TAU * k as f32 / SLATS as f32));
    let places: Vec<Affine3A> = turns.map(|turn| Affine3A::from_rotation_translation(turn, LAMP)).collect();
    let veneer = stage.material("veneer", matte(Rgb::new(0.68, 0.50, 0.30)))?;
    stage.repeat("lamp slat", veneer, slat, &places)?;

    let ring = |t: f32| torus(shade_radius(t), 0.005, 64, 8).at(LAMP + Vec3::Y * HALF_HEIGHT * t);
    let spoke = |angle: f32| {
        let (sin, cos) = sin_cos(angle);
        let top = LAMP + Vec3::Y * HALF_HEIGHT;
        let rim = top + Vec3::new(cos, 0.0, sin) * shade_radius(1.0);
        tube(&[top, rim], Ends::Open, 8, |_| 0.003)
    };
    let cord = cylinder(0.0035, HEIGHT - LAMP.y - BULB_RADIUS, 10).at(LAMP + Vec3::Y * BULB_RADIUS);
    let socket = [[0.0, 0.06], [0.026, 0.06], [0.03, 0.085], [0.026, 0.135], [0.006, 0.165], [0.0, 0.165]];
    let socket = lathe(&creased(&socket), 32).at(LAMP);
    let canopy = [[0.0, -0.03], [0.03, -0.03], [0.055, -0.012], [0.06, -0.001], [0.0, -0.001]];
    let canopy = lathe(&creased(&canopy), 32).at(LAMP.with_y(HEIGHT));
    let fittings =
        [ring(-1.0), ring(1.0), spoke(0.0), spoke(TAU / 3.0), spoke(2.0 * TAU / 3.0), cord, socket, canopy];
    stage.put("lamp fittings", palette.black, Shape::merged(fittings))
}
