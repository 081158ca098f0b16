//! A box in the manner of the Cornell box (Goral, Torrance, Greenberg, Battaile 1984), with a
//! glossy block.

use std::f32::consts::PI;

use glam::{Affine3A, Vec3};

use super::shapes::{Shape, box_between, quad};
use super::stage::Stage;
use crate::color::Rgb;
use crate::error::Result;
use crate::math::elementary::rotation;
use crate::scene::{Camera, Scene, Surface};

/// Edge of the box (m).
const SIZE: f32 = 2.0;
/// Radiance of the light under the ceiling (W·m⁻²·sr⁻¹).
const LIGHT: Rgb = Rgb::new(18.0, 15.0, 11.0);

/// The scene `tiny`: a box of 2 m, open towards the camera, red to the left and green to the right,
/// with a tall block of Phong exponent 40, a low diffuse one, and one light of 0.36 m².
///
/// Its only camera, `main`, is for an image of 32×32 pixels.
pub fn tiny() -> Scene {
    build().expect("the built-in scene tiny is valid")
}

fn build() -> Result<Scene> {
    let mut stage = Stage::new("tiny");
    let matte = |r, g, b| Surface::Lambert { reflectance: Rgb::new(r, g, b).into() };
    let white = stage.material("white", matte(0.72, 0.70, 0.66))?;
    let red = stage.material("red", matte(0.62, 0.07, 0.05))?;
    let green = stage.material("green", matte(0.13, 0.44, 0.10))?;
    let glossy = Surface::Phong {
        diffuse: Rgb::new(0.15, 0.17, 0.22).into(),
        specular: Rgb::gray(0.55).into(),
        exponent: 40.0,
    };
    let glossy = stage.material("glossy", glossy)?;
    let light = stage.emissive("light", LIGHT)?;

    let [x, y, z] = Vec3::AXES.map(|axis| axis * SIZE);
    let walls = [quad(Vec3::ZERO, [z, x]), quad(y, [x, z]), quad(Vec3::ZERO, [x, y])];
    stage.put("floor, ceiling, back", white, Shape::merged(walls))?;
    stage.put("left wall", red, quad(Vec3::ZERO, [y, z]))?;
    stage.put("right wall", green, quad(x, [z, y]))?;

    let block = |half: f32, height: f32, angle: f32, at: Vec3| {
        let shape = box_between(Vec3::new(-half, 0.0, -half), Vec3::new(half, height, half));
        shape.moved(Affine3A::from_rotation_translation(rotation(Vec3::Y, angle), at))
    };
    // A millimetre above the floor, so that no two surfaces coincide.
    stage.put("tall block", glossy, block(0.3, 1.2, 0.32, Vec3::new(0.68, 1e-3, 0.7)))?;
    stage.put("low block", white, block(0.28, 0.55, -0.3, Vec3::new(1.35, 1e-3, 1.25)))?;
    let corner = Vec3::new(0.7, SIZE - 0.01, 0.7);
    stage.put("light", light, quad(corner, [Vec3::X * 0.6, Vec3::Z * 0.6]))?;

    let eye = Vec3::new(0.5 * SIZE, 0.5 * SIZE, 5.2);
    let mut camera = Camera::look_at("main", eye, eye - Vec3::Z, Vec3::Y, 37.0 * PI / 180.0);
    camera.resolution = Some([32, 32]);
    stage.camera(camera)?;
    stage.build()
}
