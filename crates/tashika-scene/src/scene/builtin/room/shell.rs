//! Floor, walls and ceiling: single sheets that face inwards, with one hole for the window.

use glam::{Vec2, Vec3};

use super::materials::{Palette, glossy, matte, tinted};
use super::{DEPTH, HEIGHT, WALL, WIDTH, WINDOW};
use crate::color::Rgb;
use crate::error::Result;
use crate::rng::{Purpose, Stream};
use crate::scene::builtin::shapes::{Shape, bevelled_box, quad};
use crate::scene::builtin::stage::Stage;

/// Thickness of the planks (m).
const PLANK: f32 = 0.012;
/// Width of the planks (m).
const PLANK_WIDTH: f32 = 0.15;
/// Colours of the planks.
const PLANK_COLORS: [Rgb; 5] = [
    Rgb::new(0.46, 0.30, 0.18),
    Rgb::new(0.41, 0.26, 0.15),
    Rgb::new(0.48, 0.33, 0.21),
    Rgb::new(0.37, 0.23, 0.13),
    Rgb::new(0.44, 0.27, 0.16),
];

/// Adds floor, walls, ceiling and skirting.
pub fn build(stage: &mut Stage, palette: &Palette) -> Result<()> {
    walls(stage, palette)?;
    planks(stage, palette)?;
    skirting(stage, palette)
}

/// Four pieces of a wall around the window's hole, in the plane at `x` (m) across the `x` axis,
/// facing `+x`.
fn holed_wall(x: f32) -> Shape {
    let ([lo_y, hi_y], [lo_z, hi_z]) = (WINDOW.height, WINDOW.along);
    let piece = |y: [f32; 2], z: [f32; 2]| {
        quad(Vec3::new(x, y[0], z[0]), [Vec3::Y * (y[1] - y[0]), Vec3::Z * (z[1] - z[0])])
    };
    Shape::merged([
        piece([0.0, lo_y], [0.0, DEPTH]),
        piece([hi_y, HEIGHT], [0.0, DEPTH]),
        piece([lo_y, hi_y], [0.0, lo_z]),
        piece([lo_y, hi_y], [hi_z, DEPTH]),
    ])
}

fn walls(stage: &mut Stage, palette: &Palette) -> Result<()> {
    let [x, y, z] = [Vec3::X * WIDTH, Vec3::Y * HEIGHT, Vec3::Z * DEPTH];
    stage.put("accent wall", palette.accent, quad(Vec3::ZERO, [x, y]))?;
    stage.put("ceiling", palette.ceiling, quad(y, [x, z]))?;
    stage.put("walls", palette.wall, Shape::merged([quad(x, [z, y]), quad(z, [y, x]), holed_wall(0.0)]))?;
    let screed = stage.material("screed", matte(Rgb::gray(0.05)))?;
    stage.put("screed", screed, quad(Vec3::ZERO, [z, x]))?;

    // The faces of the hole, from the inner to the outer side of the wall.
    let ([lo_y, hi_y], [lo_z, hi_z]) = (WINDOW.height, WINDOW.along);
    let (outwards, up, along) = (-Vec3::X * WALL, Vec3::Y * (hi_y - lo_y), Vec3::Z * (hi_z - lo_z));
    let (low, high) = (Vec3::new(0.0, lo_y, lo_z), Vec3::new(0.0, hi_y, hi_z));
    let reveal =
        [[low, along, -outwards], [low, -outwards, up], [high, -along, -outwards], [high, -outwards, -up]];
    let reveal = reveal.map(|[corner, e, f]| quad(corner + outwards, [e, f]));
    stage.put("reveal", palette.wall, Shape::merged(reveal))?;
    // The outside of the wall is black: light that misses the window is absorbed there, so that no
    // virtual light is spent on the outside of the house.
    let facade = stage.material("facade", matte(Rgb::BLACK))?;
    stage.put("facade", facade, holed_wall(-WALL))
}

fn planks(stage: &mut Stage, palette: &Palette) -> Result<()> {
    let mut stream = Stream::new(0, Purpose::Modelling, 1);
    let mut shapes: [Shape; PLANK_COLORS.len()] = Default::default();
    let rows = (DEPTH / PLANK_WIDTH).round() as usize;
    for row in 0..rows {
        let z = row as f32 * PLANK_WIDTH;
        let mut x = 0.0;
        let mut next = 0.3 + 1.4 * stream.uniform();
        while x < WIDTH {
            // The last plank ends at the wall and is at least 0.3 m long.
            let end = if next > WIDTH - 0.3 { WIDTH } else { next };
            let plank = bevelled_box(Vec3::new(x, 0.0, z), Vec3::new(end, PLANK, z + PLANK_WIDTH), 0.0015);
            let offset = Vec2::from(stream.uniform_2());
            let plank = plank.mapped(|p, _| Vec2::new(0.5 * p.x, 1.4 * p.z) + offset);
            shapes[stream.below(PLANK_COLORS.len() as u64) as usize].append(plank);
            (x, next) = (end, end + 1.1 + 0.8 * stream.uniform());
        }
    }
    for (i, (shape, color)) in shapes.into_iter().zip(PLANK_COLORS).enumerate() {
        let name = format!("planks {i}");
        let material = stage.material(&name, glossy(tinted(color, palette.grain), 0.30, 90.0))?;
        stage.put(&name, material, shape)?;
    }
    Ok(())
}

fn skirting(stage: &mut Stage, palette: &Palette) -> Result<()> {
    const TALL: f32 = 0.09;
    const DEEP: f32 = 0.014;
    let board = |lo: [f32; 2], hi: [f32; 2]| {
        bevelled_box(Vec3::new(lo[0], PLANK, lo[1]), Vec3::new(hi[0], PLANK + TALL, hi[1]), 0.004)
    };
    let boards = [
        board([DEEP, 0.0], [WIDTH - DEEP, DEEP]),
        board([DEEP, DEPTH - DEEP], [WIDTH - DEEP, DEPTH]),
        board([0.0, 0.0], [DEEP, DEPTH]),
        board([WIDTH - DEEP, 0.0], [WIDTH, DEPTH]),
    ];
    stage.put("skirting", palette.paint, Shape::merged(boards))
}
