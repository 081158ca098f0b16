//! The furnished room.
//!
//! A room of 6.0 × 2.8 × 4.5 m, closed except for one window. Daylight comes through venetian
//! blinds, from a panel of luminance about 5 W·m⁻²·sr⁻¹ and from a low sun; a pendant lamp in a
//! shade of slats adds warm light from inside. Most points see both only through gaps. The floor is
//! glossy (Phong exponent 90), and a row of balls has exponents from 5 to 1000. The scene therefore
//! has many lights, most of which matter for few pixels. Error estimation for glossy materials is
//! hard in such scenes (Iwasaki 2019).
//!
//! Axes: `x` from the window's wall to the opposite one, `y` up, `z` from the coloured wall towards
//! the camera.

mod bookshelf;
mod decoration;
mod furniture;
mod lamp;
mod materials;
mod objects;
mod patterns;
mod shell;
mod window;

use std::f32::consts::PI;

use glam::Vec3;

use super::stage::Stage;
use crate::error::Result;
use crate::scene::{Camera, Lens, Scene};

/// Extent along `x` (m).
pub const WIDTH: f32 = 6.0;
/// Extent along `y` (m).
pub const HEIGHT: f32 = 2.8;
/// Extent along `z` (m).
pub const DEPTH: f32 = 4.5;
/// Thickness of the wall at the window (m).
pub const WALL: f32 = 0.16;
/// Height of objects on the floor (m): slightly above the planks, so that surfaces do not coincide.
const FLOOR: f32 = 0.0122;

/// Hole in the wall `x = 0`.
pub struct Opening {
    /// Lowest and highest `y` (m).
    pub height: [f32; 2],
    /// Lowest and highest `z` (m).
    pub along: [f32; 2],
}

/// Hole for the window, in the wall `x = 0`.
pub const WINDOW: Opening = Opening { height: [0.80, 2.45], along: [0.95, 3.05] };
/// Centre of the table's top (m).
const TABLE: Vec3 = Vec3::new(3.75, 0.74, 2.25);
/// Middle of the rear edge of the sideboard's top (m).
const SIDEBOARD: Vec3 = Vec3::new(3.75, 0.78, 0.016);
/// Lower left rear corner of the bookshelf (m).
const BOOKSHELF: Vec3 = Vec3::new(1.10, 0.0, 0.016);
/// Centre of the lamp's bulb (m).
const LAMP: Vec3 = Vec3::new(3.70, 1.72, 2.20);

/// The scene `room`: a furnished glossy room of some 150 000 triangles, 230 000 with all instances.
///
/// Cameras: `main`, the whole room at 640×360 pixels, and `close`, the objects on the table with a
/// shallow depth of field.
pub fn room() -> Scene {
    build().expect("the built-in scene room is valid")
}

fn build() -> Result<Scene> {
    let mut stage = Stage::new("room");
    let grain = stage.texture(patterns::wood_grain())?;
    let palette = materials::Palette::new(&mut stage, grain)?;
    shell::build(&mut stage, &palette)?;
    window::build(&mut stage, &palette)?;
    lamp::build(&mut stage, &palette)?;
    furniture::build(&mut stage, &palette)?;
    bookshelf::build(&mut stage, &palette)?;
    objects::build(&mut stage, &palette)?;
    decoration::build(&mut stage, &palette)?;
    cameras(&mut stage)?;
    stage.build()
}

fn cameras(stage: &mut Stage) -> Result<()> {
    const RESOLUTION: Option<[u32; 2]> = Some([640, 360]);
    let degrees = PI / 180.0;
    let eye = Vec3::new(5.55, 1.55, 4.25);
    let mut main = Camera::look_at("main", eye, Vec3::new(2.25, 0.78, 0.9), Vec3::Y, 45.0 * degrees);
    main.resolution = RESOLUTION;
    stage.camera(main)?;

    let (eye, target) = (TABLE + Vec3::new(0.75, 0.38, 1.0), TABLE + Vec3::new(0.12, 0.05, 0.0));
    let mut close = Camera::look_at("close", eye, target, Vec3::Y, 32.0 * degrees);
    close.lens = Lens::round(0.008, eye.distance(target));
    close.resolution = RESOLUTION;
    stage.camera(close)
}
