//! Small scenes made for tests, and functions that render them.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use tashika::Renderer;
use tashika::accel::Tracer;
use tashika::color::Rgb;
use tashika::error::Location;
use tashika::film::{Film, Window, keys};
use tashika::gather::{GatherOptions, View};
use tashika::integrator::{Integrator, Setting};
use tashika::io::LoadOptions;
use tashika::math::{Affine3A, Vec3};
use tashika::render::{RenderOptions, TileShare, render};
use tashika::renderer::{AuditedJob, Job};
use tashika::request::{ClaimName, MethodName};
use tashika::scene::{Camera, Emission, Material, MeshData, Scene, SceneBuilder, Surface};

/// Options for scenes that name missing files.
pub fn lenient() -> LoadOptions {
    LoadOptions { allow_missing: true, ..LoadOptions::default() }
}

pub fn builder() -> SceneBuilder {
    SceneBuilder::new("test", Location::default())
}

pub fn lambert(reflectance: f32) -> Surface {
    Surface::Lambert { reflectance: Rgb::gray(reflectance).into() }
}

pub fn emission(radiance: Rgb) -> Emission {
    Emission { radiance: radiance.into(), two_sided: false }
}

/// The parallelogram `corner + s a + t b`, its normal along `a × b`.
pub fn parallelogram(corner: Vec3, a: Vec3, b: Vec3) -> MeshData {
    MeshData {
        positions: vec![corner, corner + a, corner + a + b, corner + b],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..MeshData::default()
    }
}

/// The box from `lo` to `hi`, with its normals inward or outward.
pub fn cuboid(lo: Vec3, hi: Vec3, inward: bool) -> MeshData {
    let positions = (0..8)
        .map(|k| Vec3::new(pick(k & 1, lo.x, hi.x), pick(k & 2, lo.y, hi.y), pick(k & 4, lo.z, hi.z)))
        .collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut triangles = Vec::new();
    for f in faces {
        triangles.push([f[0], f[1], f[2]]);
        triangles.push([f[0], f[2], f[3]]);
    }
    if inward {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    MeshData { positions, triangles, ..MeshData::default() }
}

fn pick(bit: u32, lo: f32, hi: f32) -> f32 {
    if bit == 0 { lo } else { hi }
}

/// Adds a mesh with the identity as its transformation.
pub fn place(b: &mut SceneBuilder, mesh: MeshData, material: Material) {
    let material = b.add_material(material).unwrap();
    let mesh = b.add_mesh(mesh, material).unwrap();
    b.add_instance(mesh, Affine3A::IDENTITY).unwrap();
}

pub fn glowing(name: &str, surface: Surface, radiance: f32) -> Material {
    Material { emission: Some(emission(Rgb::gray(radiance))), ..Material::new(name, surface) }
}

/// The camera of [`diffuse_room`].
pub fn room_camera() -> Camera {
    Camera::look_at("main", Vec3::new(0.0, 1.0, 3.6), Vec3::new(0.0, 1.0, 0.0), Vec3::Y, 0.6)
}

/// A diffuse room with one block and one open side; camera `main`.
pub fn diffuse_room() -> SceneBuilder {
    let mut b = diffuse_walls();
    b.add_camera(room_camera()).unwrap();
    b
}

/// The room of [`diffuse_room`] without a camera.
pub fn diffuse_walls() -> SceneBuilder {
    let mut b = builder();
    let colors = [Rgb::new(0.7, 0.7, 0.7), Rgb::new(0.6, 0.2, 0.1), Rgb::new(0.1, 0.3, 0.6)];
    let mut wall = |corner: [f32; 3], a: [f32; 3], c: [f32; 3], color: usize| {
        let m = Material::new("wall", Surface::Lambert { reflectance: colors[color].into() });
        place(&mut b, parallelogram(corner.into(), a.into(), c.into()), m);
    };
    wall([-1.0, 0.0, -1.0], [0.0, 0.0, 2.0], [2.0, 0.0, 0.0], 0);
    wall([-1.0, 2.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0], 0);
    wall([-1.0, 0.0, -1.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], 0);
    wall([-1.0, 0.0, -1.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0], 1);
    wall([1.0, 0.0, -1.0], [0.0, 0.0, 2.0], [0.0, 2.0, 0.0], 2);
    let block = cuboid(Vec3::new(-0.2, 0.0, -0.5), Vec3::new(0.4, 0.7, 0.1), false);
    place(&mut b, block, Material::new("block", lambert(0.5)));
    b
}

/// A lamp under the ceiling of [`diffuse_room`].
pub fn add_ceiling_lamp(b: &mut SceneBuilder, radiance: f32) {
    let lamp = parallelogram(Vec3::new(-0.4, 1.9, -0.4), Vec3::X * 0.8, Vec3::Z * 0.8);
    place(b, lamp, glowing("lamp", lambert(0.3), radiance));
}

pub fn tracer(b: SceneBuilder) -> Tracer {
    Tracer::new(Arc::new(b.build().unwrap()))
}

pub fn view(scene: &Scene, size: [u32; 2], points: u32, seed: u64) -> View<'_> {
    let gather = GatherOptions { points, ..GatherOptions::default() };
    View { camera: &scene.cameras()[0], size, gather, seed }
}

/// The whole image, all planes.
pub fn film(tracer: &Tracer, integrator: &dyn Integrator, size: [u32; 2], points: u32, seed: u64) -> Film {
    let scene = tracer.scene().clone();
    film_of(tracer, integrator, view(&scene, size, points, seed))
}

/// The whole image of a view, all planes.
pub fn film_of(tracer: &Tracer, integrator: &dyn Integrator, view: View<'_>) -> Film {
    let options = RenderOptions { window: Window::full(view.size), share: TileShare::default() };
    let setting = Setting { tracer, view };
    render(&setting, integrator, &options, &|_| (), &AtomicBool::new(false)).unwrap().film
}

/// Luminance of each pixel, row by row.
pub fn luminances(film: &Film) -> Vec<f64> {
    film.colors().unwrap().map(|c| f64::from(c.luminance())).collect()
}

/// Asserts that path tracing is the default method of a scene with media or motion, and that an
/// audited picture of it uses no VPLs.
pub fn paths_keep_what_the_default_promises(tracer: &Tracer) {
    let renderer = || Renderer::on(tracer).size([4, 4]);
    let image = renderer().paths(1).render().unwrap();
    assert!(image.complete);
    assert_eq!(image.film.metadata().text(keys::METHOD), Some(MethodName::Path.name()));
    let audited = renderer().claim(ClaimName::Audited);
    assert!(matches!(audited.prepare().unwrap().job(), Job::Audited(AuditedJob { lights: None, .. })));
}
