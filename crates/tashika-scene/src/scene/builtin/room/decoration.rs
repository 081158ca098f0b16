//! Rug, plant, pictures and mirror.

use std::f32::consts::{PI, TAU};

use glam::{Affine3A, Vec2, Vec3};

use super::materials::{Palette, coated, glossy, matte, tinted};
use super::patterns;
use super::{DEPTH, FLOOR, SIDEBOARD};
use crate::color::Rgb;
use crate::error::Result;
use crate::math::elementary::{rotation, sin_cos};
use crate::rng::{Purpose, Stream};
use crate::scene::Surface;
use crate::scene::builtin::shapes::{
    Ends, Shape, bevelled_box, creased, disk, grid, lathe, quad, torus, tube,
};
use crate::scene::builtin::stage::Stage;

/// Adds rug, plant, mirror and pictures.
pub fn build(stage: &mut Stage, palette: &Palette) -> Result<()> {
    rug(stage)?;
    plant(stage, palette)?;
    mirror(stage, palette)?;
    pictures(stage, palette)
}

/// Adds a woven rug: threads over and under each other, with fringes at its short ends.
fn rug(stage: &mut Stage) -> Result<()> {
    const SIZE: Vec2 = Vec2::new(1.5, 2.3);
    const CELLS: [usize; 2] = [84, 128];
    let place = Affine3A::from_rotation_translation(rotation(Vec3::Y, 0.12), Vec3::new(2.05, FLOOR, 2.35));
    let weave = grid(CELLS, [Ends::Open; 2], |i, j| {
        let (s, t) = (i as f32 / CELLS[0] as f32, j as f32 / CELLS[1] as f32);
        let at_edge = i == 0 || j == 0 || i == CELLS[0] || j == CELLS[1];
        // Each knot of two by two cells is raised or sunk relative to its neighbours.
        let over = ((i / 2 + j / 2) % 2) as f32;
        let (ripple, _) = sin_cos(TAU * (1.3 * s + 0.8 * t));
        let height = if at_edge { 0.001 } else { 0.007 + 0.0025 * over + 0.0008 * ripple };
        Vec3::new((s - 0.5) * SIZE.x, height, (0.5 - t) * SIZE.y)
    });
    let pattern = stage.texture(patterns::rug())?;
    let wool = stage.material("wool", matte(tinted(Rgb::WHITE, pattern)))?;
    stage.repeat("rug", wool, weave, &[place])?;

    let thread = tube(
        &[[0.0, 0.004], [0.02, 0.006], [0.045, 0.003], [0.06, 0.0025]]
            .map(|p: [f32; 2]| Vec3::new(0.0, p[1], p[0])),
        Ends::Open,
        5,
        |t| 0.0024 - 0.0012 * t,
    );
    let mut stream = Stream::new(0, Purpose::Modelling, 3);
    let count = 110;
    let places: Vec<Affine3A> = (0..2 * count)
        .map(|k| {
            let (end, k) = (k / count, k % count);
            let x = ((k as f32 + 0.5) / count as f32 - 0.5) * SIZE.x;
            let turn = rotation(Vec3::Y, PI * end as f32 + 0.5 * (stream.uniform() - 0.5));
            let z = if end == 0 { 0.5 } else { -0.5 } * SIZE.y;
            place * Affine3A::from_rotation_translation(turn, Vec3::new(x, 0.0, z))
        })
        .collect();
    let cream = stage.material("fringe", matte(Rgb::new(0.64, 0.57, 0.44)))?;
    stage.repeat("fringe", cream, thread, &places)
}

/// Adds a rubber plant: stems from a pot, with leaves in a spiral around each.
fn plant(stage: &mut Stage, palette: &Palette) -> Result<()> {
    let at = Vec3::new(0.52, FLOOR, 0.47);
    let pot = [
        [0.0, 0.0],
        [0.13, 0.0],
        [0.14, 0.01],
        [0.18, 0.30],
        [0.19, 0.31],
        [0.19, 0.34],
        [0.175, 0.34],
        [0.17, 0.29],
        [0.0, 0.29],
    ];
    let glaze = stage.material("pot", coated(Rgb::new(0.66, 0.64, 0.60), 0.3))?;
    stage.put("pot", glaze, lathe(&creased(&pot), 48).at(at))?;

    let mut stream = Stream::new(0, Purpose::Modelling, 4);
    let (mut stems, mut places) = (Shape::default(), Vec::new());
    const STEMS: usize = 9;
    for k in 0..STEMS {
        let u = stream.uniform_3();
        let around = TAU * (k as f32 + 0.5 * u[0]) / STEMS as f32;
        let (sin, cos) = sin_cos(around);
        let tall = if k == 0 { 1.25 } else { 0.65 + 0.5 * u[1] };
        let reach = 0.08 + 0.12 * u[2];
        let point = |t: f32| {
            let out = 0.05 + reach * t * t;
            at + Vec3::new(out * cos, 0.27 + tall * t, out * sin)
        };
        let path: Vec<Vec3> = (0..=24).map(|i| point(i as f32 / 24.0)).collect();
        stems.append(tube(&path, Ends::Open, 8, |t| 0.009 - 0.006 * t));
        let leaves = (26.0 * tall) as usize;
        for i in 0..leaves {
            let t = 0.22 + 0.78 * (i as f32 + 0.5) / leaves as f32;
            let u = stream.uniform_3();
            // Successive leaves are the golden angle apart, so that they shade each other little.
            let turn = rotation(Vec3::Y, 2.4 * i as f32 + around + 0.5 * u[0]);
            let lift = rotation(Vec3::Z, 0.15 + 0.75 * t + 0.3 * (u[1] - 0.5));
            let scale = Vec3::splat((1.15 - 0.45 * t) * (0.8 + 0.35 * u[2]));
            places.push(Affine3A::from_scale_rotation_translation(scale, turn * lift, point(t)));
        }
    }
    let bark = stage.material("bark", matte(Rgb::new(0.16, 0.18, 0.07)))?;
    stage.put("stems", bark, stems)?;

    // A leaf along +x: bent down towards its tip, folded along its middle.
    let leaf = grid([8, 4], [Ends::Open; 2], |i, j| {
        let (s, t) = (i as f32 / 8.0, j as f32 / 2.0 - 1.0);
        let width = 0.038 * (0.05 + sin_cos(PI * (0.06 + 0.90 * s)).0) * (1.15 - 0.3 * s);
        let bend = -0.035 * s * s + 0.010 * s;
        Vec3::new(0.18 * s, bend + 0.3 * width * t * t, -width * t)
    });
    let stalk = tube(&[Vec3::ZERO, Vec3::new(0.03, 0.001, 0.0)], Ends::Open, 5, |_| 0.002);
    let green = stage.material("leaves", glossy(Rgb::new(0.055, 0.17, 0.035), 0.10, 50.0))?;
    stage.repeat("leaf", green, Shape::merged([leaf.at(Vec3::X * 0.02), stalk]), &places)?;
    let soil = stage.material("soil", matte(Rgb::new(0.05, 0.035, 0.025)))?;
    stage.put("soil", soil, disk(0.172, 48).at(at + Vec3::Y * 0.30))?;
    // A tray under the pot.
    let tray = [[0.0, 0.0], [0.2, 0.0], [0.21, 0.02], [0.205, 0.02], [0.195, 0.006], [0.0, 0.006]];
    stage.put("tray", palette.black, lathe(&creased(&tray), 48).at(at + Vec3::Y * 0.0002))
}

/// Adds a round mirror in a brass ring above the sideboard.
fn mirror(stage: &mut Stage, palette: &Palette) -> Result<()> {
    const RADIUS: f32 = 0.40;
    let face =
        Affine3A::from_rotation_translation(rotation(Vec3::X, 0.5 * PI), Vec3::new(SIDEBOARD.x, 1.62, 0.018));
    let silver = stage.material("mirror", Surface::Mirror { reflectance: Rgb::gray(0.8).into() })?;
    stage.put("mirror", silver, disk(RADIUS, 96).moved(face))?;
    stage.put("mirror frame", palette.brass, torus(RADIUS, 0.016, 96, 16).moved(face))
}

/// Adds three framed paintings: one beside the mirror, two on the wall behind the camera, visible
/// in the mirror.
fn pictures(stage: &mut Stage, palette: &Palette) -> Result<()> {
    let landscape = stage.texture(patterns::landscape())?;
    let landscape = stage.material("landscape", matte(tinted(Rgb::WHITE, landscape)))?;
    let disks = stage.texture(patterns::disks())?;
    let disks = stage.material("disks", matte(tinted(Rgb::WHITE, disks)))?;

    // Pictures are made in the plane z = 0, centred at the origin and facing +z.
    let back = |x: f32, y: f32| Affine3A::from_translation(Vec3::new(x, y, 0.0));
    let front =
        |x: f32, y: f32| Affine3A::from_rotation_translation(rotation(Vec3::Y, PI), Vec3::new(x, y, DEPTH));
    let hung = [
        ("small picture", disks, Vec2::new(0.17, 0.235), back(SIDEBOARD.x + 0.78, 1.62)),
        ("large picture", landscape, Vec2::new(0.60, 0.40), front(2.0, 1.55)),
        ("tall picture", disks, Vec2::new(0.26, 0.36), front(3.3, 1.55)),
    ];
    let (mut frames, mut mounts) = (Shape::default(), Shape::default());
    for (name, material, half, place) in hung {
        const BAR: f32 = 0.022;
        const MOUNT: f32 = 0.05;
        let outer = half + MOUNT + BAR;
        let bar = |lo: Vec2, hi: Vec2| bevelled_box(lo.extend(0.001), hi.extend(0.026), 0.004);
        let inner = outer - BAR;
        frames.append(
            Shape::merged([
                bar(-outer, Vec2::new(outer.x, -inner.y)),
                bar(Vec2::new(-outer.x, inner.y), outer),
                bar(Vec2::new(-outer.x, -inner.y), Vec2::new(-inner.x, inner.y)),
                bar(Vec2::new(inner.x, -inner.y), Vec2::new(outer.x, inner.y)),
            ])
            .moved(place),
        );
        let sheet =
            |half: Vec2, z: f32| quad((-half).extend(z), [Vec3::X * 2.0 * half.x, Vec3::Y * 2.0 * half.y]);
        mounts.append(sheet(inner, 0.008).moved(place));
        // The rows of an image run from top to bottom.
        let canvas = sheet(half, 0.010)
            .mapped(|p, _| Vec2::new(0.5, 0.5) + p.truncate() * Vec2::new(0.5, -0.5) / half);
        stage.put(name, material, canvas.moved(place))?;
    }
    stage.put("picture frames", palette.black, frames)?;
    stage.put("mounts", palette.paper, mounts)
}
