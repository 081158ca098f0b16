//! A render from code: a scene is made from arrays and rendered to a requested error, the claims
//! are audited, and an OpenEXR file is written.
//!
//!     cargo run --release --example render -- ball.exr

#![expect(clippy::print_stdout, reason = "a program: what it prints is its result")]

use std::env;
use std::path::Path;

use glam::{Affine3A, Vec3};
use tashika::Renderer;
use tashika::color::Rgb;
use tashika::error::{Location, Result};
use tashika::io::{ToneMap, write_exr, write_png};
use tashika::scene::{Camera, Emission, Material, MeshData, Scene, SceneBuilder, Surface};

/// Two triangles from a corner along two edges (m).
fn quad(name: &str, corner: Vec3, [u, v]: [Vec3; 2]) -> MeshData {
    MeshData {
        name: name.to_owned(),
        positions: vec![corner, corner + u, corner + u + v, corner + v],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..MeshData::default()
    }
}

/// A lamp over a table before a wall.
fn scene() -> Result<Scene> {
    let mut builder = SceneBuilder::new("table", Location::default());
    let matte = |r, g, b| Surface::Lambert { reflectance: Rgb::new(r, g, b).into() };
    let wood = builder.add_material(Material::new("wood", matte(0.5, 0.3, 0.15)))?;
    let plaster = builder.add_material(Material::new("plaster", matte(0.8, 0.8, 0.75)))?;
    let mut lamp = Material::new("lamp", matte(0.0, 0.0, 0.0));
    lamp.emission = Some(Emission { radiance: Rgb::new(20.0, 18.0, 15.0).into(), two_sided: false });
    let lamp = builder.add_material(lamp)?;
    for (mesh, material) in [
        (quad("table", Vec3::new(-1.0, 0.0, -1.0), [Vec3::Z * 2.0, Vec3::X * 2.0]), wood),
        (quad("wall", Vec3::new(-1.0, 0.0, -1.0), [Vec3::X * 2.0, Vec3::Y * 2.0]), plaster),
        (quad("lamp", Vec3::new(-0.2, 1.5, -0.6), [Vec3::X * 0.4, Vec3::Z * 0.4]), lamp),
    ] {
        let mesh = builder.add_mesh(mesh, material)?;
        builder.add_instance(mesh, Affine3A::IDENTITY)?;
    }
    let (eye, target) = (Vec3::new(0.0, 1.2, 3.0), Vec3::new(0.0, 0.7, 0.0));
    builder.add_camera(Camera::look_at("main", eye, target, Vec3::Y, 0.7))?;
    builder.build()
}

fn main() -> Result<()> {
    let prepared = Renderer::new(scene()?).error(0.1).size([96, 64]).vpls(100_000).prepare()?;
    let image = prepared.render()?;
    let tally = image.totals.tally;
    println!("{} of {} pixels claim to be within 10 %", tally.claiming(), tally.rendered());
    if let Some(audit) = prepared.audit(&image.film, 50)? {
        println!("of {} at random, {} are", audit.of, audit.within);
    }
    if let Some(path) = env::args().nth(1) {
        write_exr(Path::new(&path), &image.film)?;
        write_png(&Path::new(&path).with_extension("png"), &image.film, &ToneMap::default())?;
    }
    Ok(())
}
