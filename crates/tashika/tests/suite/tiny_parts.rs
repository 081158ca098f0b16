//! Scenes with triangles that are tiny relative to their distance, as exporters write at the caps
//! and poles of cones and spheres. The pictures equal those without these triangles.

use std::sync::Arc;

use tashika::accel::Tracer;
use tashika::film::Window;
use tashika::gather::{GatherOptions, View};
use tashika::integrator::{Integrator, PathStop, PathTracer, Setting};
use tashika::math::Vec3;
use tashika::scene::{Camera, MeshData};

use crate::cases::{builder, glowing, lambert, parallelogram, place};

const SIZE: [u32; 2] = [24, 16];
const PATHS: u32 = 64;

/// Returns the radiance of all pixels. The scene is a floor below a lamp with a square cap of the
/// given radius.
fn picture(cap: Option<f32>, cap_shines: bool) -> Vec<f32> {
    let mut b = builder();
    place(
        &mut b,
        parallelogram(Vec3::new(-3.0, 0.0, -3.0), Vec3::Z * 6.0, Vec3::X * 6.0),
        glowing("floor", lambert(0.5), 0.0),
    );
    let mut lamp = parallelogram(Vec3::new(-0.5, 3.0, -0.5), Vec3::X, Vec3::Z);
    let mut caps = MeshData::default();
    if let Some(r) = cap {
        let at = |x: f32, z: f32| Vec3::new(x, 0.0, z) * r;
        let corners = [at(1.0, 0.0), at(0.0, 1.0), at(-1.0, 0.0), at(0.0, -1.0)];
        let of = if cap_shines { &mut lamp } else { &mut caps };
        let first = of.positions.len() as u32;
        of.positions.extend(corners);
        of.triangles.extend([[first, first + 2, first + 1], [first, first + 3, first + 2]]);
        // The cap shares a leaf of the tree with a large object, so that most rays are tested
        // against it.
        if !cap_shines {
            let first = caps.positions.len() as u32;
            caps.positions.extend([
                Vec3::new(-90.0, -9.0, -90.0),
                Vec3::new(90.0, -9.0, -90.0),
                Vec3::NEG_Y * 9.0,
            ]);
            caps.triangles.push([first, first + 1, first + 2]);
            place(&mut b, caps, glowing("cap", lambert(0.5), 0.0));
        }
    }
    place(&mut b, lamp, glowing("lamp", lambert(0.5), 10.0));
    b.add_camera(Camera::look_at("main", Vec3::new(0.0, 2.0, -6.0), Vec3::ZERO, Vec3::Y, 0.7)).unwrap();
    let tracer = Tracer::new(Arc::new(b.build().unwrap()));
    let scene = tracer.scene().clone();
    let gather = GatherOptions { points: 1, ..GatherOptions::default() };
    let view = View { camera: &scene.cameras()[0], size: SIZE, gather, seed: 1 };
    let paths = PathTracer::new(&tracer, PathStop::Count(PATHS), 4).unwrap();
    let window = Window { x: 0, y: 0, width: SIZE[0], height: SIZE[1] };
    let pixels = paths.begin(Setting { tracer: &tracer, view }).tile(&window);
    pixels.iter().map(|pixel| pixel.radiance.luminance()).collect()
}

/// A cap that does not emit covers no path. All pictures with tiny caps have the same bits, down to
/// the smallest cap that the scene retains.
#[test]
fn a_tiny_cap_is_not_seen_and_casts_no_shadow() {
    let smallest = picture(Some(1e-30), false);
    assert!(smallest.iter().any(|radiance| *radiance > 0.01));
    for r in [1e-8, 1e-10, 1e-13, 1e-17] {
        assert!(picture(Some(r), false) == smallest, "a cap of {r:e} m is seen");
    }
}

/// A cap that is part of the lamp adds no light: the mean difference of pixels is zero within five
/// of its standard errors. The bits differ, since triangles of the lamp are sampled with other
/// random numbers.
#[test]
fn a_tiny_cap_of_a_lamp_adds_no_light() {
    let plain = picture(None, true);
    for r in [1e-8, 1e-10, 1e-12, 1e-14, 1e-17, 1e-19, 1e-30, 1e-44] {
        let found = picture(Some(r), true);
        let differences = || found.iter().zip(&plain).map(|(a, b)| f64::from(a - b));
        let n = plain.len() as f64;
        let mean = differences().sum::<f64>() / n;
        let variance = differences().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n - 1.0);
        assert!(mean.abs() <= 5.0 * (variance / n).sqrt(), "a cap of {r:e} m adds {mean}");
    }
}
