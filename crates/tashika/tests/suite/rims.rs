//! Rims of objects on a black background: pixels of which all samples may miss the object.

use tashika::color::Rgb;
use tashika::film::{Claim, RenderFilm};
use tashika::integrator::{PathStop, PathTracer};
use tashika::math::{Affine3A, Vec3};
use tashika::request::{ClaimName, MethodName};
use tashika::rng::{Purpose, Stream};
use tashika::scene::{Camera, Emitter, Material, SceneBuilder};
use tashika::{Renderer, accel::Tracer};

use crate::cases::{builder, film, lambert, luminances, parallelogram, tracer};

const SIZE: [u32; 2] = [48, 32];
const SEEDS: u64 = 4;

/// Returns sixty leaves on a black background, lit by a sun from the direction of the camera.
fn leaves() -> Tracer {
    let mut b: SceneBuilder = builder();
    let mut s = Stream::new(3, Purpose::Test, 0);
    let material = b.add_material(Material::new("leaf", lambert(0.8))).unwrap();
    for _ in 0..60 {
        let anywhere = |s: &mut Stream| Vec3::from(s.uniform_3()) * 2.0 - 1.0;
        let (corner, a, c) = (anywhere(&mut s), 0.3 * anywhere(&mut s), 0.3 * anywhere(&mut s));
        let mesh = b.add_mesh(parallelogram(corner, a, c), material).unwrap();
        b.add_instance(mesh, Affine3A::IDENTITY).unwrap();
    }
    let direction = Vec3::new(0.1, -0.2, -1.0).normalize();
    b.add_emitter(Emitter::Directional { direction, irradiance: Rgb::gray(3.0) }).unwrap();
    b.add_camera(Camera::look_at("main", Vec3::new(0.0, 0.0, 4.5), Vec3::ZERO, Vec3::Y, 0.7)).unwrap();
    tracer(b)
}

/// An object covers a thirtieth of a pixel. One in thirty sets of a hundred camera samples misses
/// it. Pixels whose samples meet nothing claim to be black, and their interval contains the truth
/// as often as requested, with VPLs as with paths alone.
#[test]
fn a_rim_that_no_sample_met_is_within_the_interval() {
    let tracer = leaves();
    let reference =
        film(&tracer, &PathTracer::new(&tracer, PathStop::Count(40_000), 65).unwrap(), SIZE, 1, 1000);
    let truths = luminances(&reference);
    let brightest = truths.iter().copied().fold(0.0, f64::max);
    for method in [MethodName::default(), MethodName::Path] {
        let (mut rims, mut kept, mut black, mut exact) = (0.0, 0.0, 0.0, 0.0);
        for seed in 1..=SEEDS {
            let renderer = Renderer::on(&tracer).size(SIZE).method(method).error(0.1).seed(seed);
            let rendered = renderer.claim(ClaimName::Calibrated).render().unwrap();
            let records = RenderFilm::of(&rendered.film);
            for ((x, y), truth) in rendered.film.window().pixels().zip(&truths) {
                let record = records.at(x, y);
                assert_eq!(record.claim, Claim::Calibrated, "{method} {x} {y}: {record:?}");
                let distance = (f64::from(record.radiance.luminance()) - truth).abs();
                if *truth == 0.0 {
                    black += 1.0;
                    exact += f64::from(u8::from(record.half_width == 0.0));
                } else if *truth < 0.04 * brightest {
                    rims += 1.0;
                    // The reference has an error of 3 % if such a share of the pixel is covered.
                    kept += f64::from(u8::from(distance <= f64::from(record.half_width) + 0.1 * truth));
                }
            }
        }
        assert!(rims > 100.0 && kept >= 0.94 * rims, "{method}: {kept} of {rims} claims at rims hold");
        assert!(exact > 0.8 * black, "{method}: {exact} of {black} black pixels are certain");
    }
}
