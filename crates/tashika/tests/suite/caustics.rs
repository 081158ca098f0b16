//! Light of small lamps over a mirror and through water, against closed forms: it is found, and
//! claims about it hold.

use std::f64::consts::PI;

use tashika::Renderer;
use tashika::accel::Tracer;
use tashika::color::Rgb;
use tashika::film::Film;
use tashika::math::Vec3;
use tashika::request::ClaimName;
use tashika::scene::{Camera, Material, SceneBuilder, Surface};
use tashika::stats::Moments;

use crate::cases::{builder, cuboid, glowing, lambert, luminances, parallelogram, place, tracer};

const SIZE: [u32; 2] = [8, 8];
/// Reflectance of the floor: low, since the closed forms ignore light that the floor sends back to
/// itself.
const REFLECTANCE: f64 = 0.02;
/// Relative error requested for each pixel.
const ERROR: f64 = 0.1;
/// Side (m) and radiance of the lamps.
const LAMP: (f32, f32) = (0.002, 1e6);
const SEEDS: u64 = 2;

/// Returns a floor of two metres, of which a camera at `eye` sees a centimetre around `target`.
fn floor(eye: Vec3, target: Vec3) -> SceneBuilder {
    let mut b = builder();
    let floor = parallelogram(Vec3::new(-1.0, 0.0, -1.0), Vec3::Z * 2.0, Vec3::X * 2.0);
    place(&mut b, floor, Material::new("floor", lambert(REFLECTANCE as f32)));
    b.add_camera(Camera::look_at("main", eye, target, Vec3::Z, 0.005)).unwrap();
    b
}

/// Adds a lamp that shines up, or down.
fn add_lamp(b: &mut SceneBuilder, corner: Vec3, is_up: bool) {
    let [u, v] = if is_up { [Vec3::Z, Vec3::X] } else { [Vec3::X, Vec3::Z] };
    let (side, radiance) = LAMP;
    place(b, parallelogram(corner, side * u, side * v), glowing("lamp", lambert(0.0), radiance));
}

/// Returns the radiant intensity of the lamp along its normal (W/sr).
fn intensity() -> f64 {
    f64::from(LAMP.0).powi(2) * f64::from(LAMP.1)
}

fn render(tracer: &Tracer, seed: u64) -> Film {
    Renderer::on(tracer).size(SIZE).vpls(2000).error(ERROR).seed(seed).render().unwrap().film
}

/// Asserts that nearly all pixels claim, that their claims hold, and that the mean is right.
fn assert_radiance(scene: SceneBuilder, expected: f64) {
    let tracer = tracer(scene);
    let (mut claims, mut kept, mut pixels) = (0.0, 0.0, Moments::default());
    for seed in 1..=SEEDS {
        let film = render(&tracer, seed);
        let claim = film.plane("claim").unwrap().u32_samples().unwrap();
        let half_widths = film.plane("half_width").unwrap().f32_samples().unwrap();
        for (k, found) in luminances(&film).into_iter().enumerate() {
            pixels.push(found);
            if claim[k] > 0 {
                claims += 1.0;
                kept += f64::from((found - expected).abs() <= f64::from(half_widths[k]));
            }
        }
    }
    let all = (u64::from(SIZE[0] * SIZE[1]) * SEEDS) as f64;
    assert!(claims >= 0.95 * all, "{claims} claims of {all}");
    assert!(kept >= 0.9 * claims, "{kept} of {claims} claims hold");
    assert!((pixels.mean() / expected - 1.0).abs() < 0.3 * ERROR, "{} of {expected}", pixels.mean());
    let audited = Renderer::on(&tracer).size(SIZE).error(ERROR).claim(ClaimName::Audited).render().unwrap();
    let of_audited = luminances(&audited.film).iter().sum::<f64>() / f64::from(SIZE[0] * SIZE[1]);
    assert!((of_audited / expected - 1.0).abs() < 0.5 * ERROR, "audited: {of_audited} of {expected}");
}

/// A lamp of two millimetres that shines at a mirror: its image is three metres above the floor.
/// One in seven million directions drawn by the BSDF meets it.
#[test]
fn a_lamp_over_a_mirror_is_found() {
    let mut b = floor(Vec3::new(0.0, 0.8, 0.0), Vec3::ZERO);
    let ceiling = parallelogram(Vec3::new(-50.0, 2.0, -50.0), Vec3::X * 100.0, Vec3::Z * 100.0);
    place(&mut b, ceiling, Material::new("mirror", Surface::Mirror { reflectance: Rgb::WHITE.into() }));
    add_lamp(&mut b, Vec3::new(0.5, 1.0, 0.0), true);
    let (height, aside) = (3.0_f64, 0.501);
    let squared = height * height + aside * aside;
    assert_radiance(b, REFLECTANCE / PI * intensity() * height * height / (squared * squared));
}

/// A lamp above water. The light in a small cone around the vertical covers an area `(h + s/n)²`
/// times its solid angle at the depth `s`, and radiance that leaves the water is `n²` times less.
#[test]
fn a_lamp_above_water_is_found() {
    const IOR: f64 = 1.33;
    let aside = 0.02;
    let mut b = floor(Vec3::new(aside, 2.0, 0.0), Vec3::new(aside, 0.0, 0.0));
    let water = Surface::Glass {
        ior: IOR as f32,
        reflectance: Rgb::WHITE,
        transmittance: Rgb::WHITE,
        facets: 0.0.into(),
    };
    let body = cuboid(Vec3::new(-50.0, -0.1, -50.0), Vec3::new(50.0, 1.0, 50.0), false);
    place(&mut b, body, Material::new("water", water));
    add_lamp(&mut b, Vec3::new(0.0, 2.5, 0.0), false);
    let (height, depth) = (1.5, 1.0);
    let apparent = height + depth / IOR;
    let passed = 1.0 - ((IOR - 1.0) / (IOR + 1.0)).powi(2);
    let irradiance = passed * intensity() / (apparent * apparent);
    assert_radiance(b, passed * REFLECTANCE / PI * irradiance / (IOR * IOR));
}
