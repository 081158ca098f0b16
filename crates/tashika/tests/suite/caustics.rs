//! Light of small lamps that arrives by a mirror or through water, compared with closed forms. The
//! light is found, claims about it hold, and the account of light paths includes it.

use std::f64::consts::PI;

use tashika::Renderer;
use tashika::accel::Tracer;
use tashika::color::Rgb;
use tashika::film::{Claim, Film, FoundLight, RenderFilm};
use tashika::integrator::{GuidedLights, Truth};
use tashika::math::Vec3;
use tashika::request::{ClaimName, MethodName};
use tashika::scene::{Camera, Material, MeshData, SceneBuilder, Surface};
use tashika::stats::Moments;
use tashika::vpl::VplOptions;

use crate::cases::{builder, cuboid, glowing, lambert, luminances, parallelogram, place, tracer, view};
use crate::light_transport::transport_agrees;

const SIZE: [u32; 2] = [6, 6];
/// Reflectance of the floor. It is low, because the closed forms ignore light that returns to the
/// floor after it was reflected there.
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

/// A lamp of two millimetres shines up at a mirror. The mirror image of the lamp is three metres
/// above the floor. Only one in seven million directions that the BSDF samples meets the image.
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

/// A lamp at height `h` above water of depth `s`. On the bottom, a narrow vertical cone of light
/// covers `(h + s/n)²` times its solid angle. Radiance that leaves the water is divided by `n²`.
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

/// A floor is lit only by way of a mirror. The account of light paths has all of its light, by
/// route and by emitter, and agrees with a path-traced picture.
#[test]
fn the_account_of_light_paths_is_that_of_the_picture() {
    let mut b = builder();
    let floor = parallelogram(Vec3::new(-1.0, 0.0, -1.0), Vec3::Z * 2.0, Vec3::X * 2.0);
    place(&mut b, floor, Material::new("floor", lambert(0.5)));
    b.add_camera(Camera::look_at("main", Vec3::Y * 0.9, Vec3::ZERO, Vec3::Z, 1.2)).unwrap();
    let ceiling = parallelogram(Vec3::new(-5.0, 2.0, -5.0), Vec3::X * 10.0, Vec3::Z * 10.0);
    place(&mut b, ceiling, Material::new("mirror", Surface::Mirror { reflectance: Rgb::WHITE.into() }));
    let lamp = parallelogram(Vec3::new(-0.1, 1.0, -0.1), Vec3::Z * 0.2, Vec3::X * 0.2);
    place(&mut b, lamp, glowing("lamp", lambert(0.0), 10.0));
    let tracer = tracer(b);
    let view = view(tracer.scene(), [32, 32], 1, 1);
    let lights = GuidedLights::trace(&tracer, &VplOptions::default(), Truth::Transport, &view).unwrap();
    let account = lights.account().expect("the floor is in view");
    let [straight, specular, scattered] = account.by_way;
    assert!(straight == 0.0 && specular > 0.6, "{account:?}");
    assert!((specular + scattered - 1.0).abs() < 1e-6 && account.by_origin == [1.0, 0.0, 0.0], "{account:?}");
    let rendered = Renderer::on(&tracer).size([32, 32]).method(MethodName::Path).paths(400).render().unwrap();
    let pixels = luminances(&rendered.film);
    let mean = pixels.iter().sum::<f64>() / pixels.len() as f64;
    assert!((account.luminance / mean - 1.0).abs() < 0.05, "{account:?} for {mean}");
}

/// Lamps are just below a mirror. Rays toward the mirror image of a lamp hit the lamp itself, which
/// is sampled directly as well. Each contribution must be counted once.
#[test]
fn lamps_before_their_own_image_are_counted_once() {
    let mut b = builder();
    let floor = parallelogram(Vec3::new(-1.0, 0.0, -1.0), Vec3::Z * 2.0, Vec3::X * 2.0);
    place(&mut b, floor, Material::new("floor", lambert(0.5)));
    b.add_camera(Camera::look_at("main", Vec3::Y * 1.5, Vec3::ZERO, Vec3::Z, 0.8)).unwrap();
    let ceiling = parallelogram(Vec3::new(-5.0, 2.0, -5.0), Vec3::X * 10.0, Vec3::Z * 10.0);
    place(&mut b, ceiling, Material::new("mirror", Surface::Mirror { reflectance: Rgb::WHITE.into() }));
    let (corner, side) = (Vec3::new(-0.2, 1.85, -0.2), 0.4);
    let up = parallelogram(corner + Vec3::Y * 0.01, Vec3::Z * side, Vec3::X * side);
    let down = parallelogram(corner, Vec3::X * side, Vec3::Z * side);
    for (name, lamp) in [("up", up), ("down", down)] {
        place(&mut b, lamp, glowing(name, lambert(0.0), 5.0));
    }
    transport_agrees(b, 0.02, "lamps before their image");
}

/// Returns a paraboloid above the origin whose focus is at `(0, focal, 0)`. Its front faces the
/// origin.
fn paraboloid(focal: f32, radius: f32) -> MeshData {
    const SIDE: u32 = 64;
    let at = |k: u32| radius * (2.0 * k as f32 / SIDE as f32 - 1.0);
    let places = (0..=SIDE).flat_map(|j| (0..=SIDE).map(move |i| (at(i), at(j))));
    let (positions, normals) = places
        .map(|(x, z)| {
            let height = (x * x + z * z) / (4.0 * focal);
            (Vec3::new(x, height, z), Vec3::new(-x, 2.0 * focal, -z))
        })
        .unzip();
    let corner = |i: u32, j: u32| j * (SIDE + 1) + i;
    let cell = |i, j| {
        let [a, b, c, d] = [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
        [[a, b, c], [a, c, d]]
    };
    let triangles = (0..SIDE).flat_map(|j| (0..SIDE).flat_map(move |i| cell(i, j))).collect();
    MeshData { positions, normals, triangles, ..MeshData::default() }
}

/// A concave mirror forms an image of a lamp on a tile. The image is five millimetres wide and
/// fills less than a thousandth of the pixel, so most sets of camera samples miss it. The account
/// of light paths includes it, so that no pixel makes a claim that ignores this light.
#[test]
fn a_focus_that_camera_samples_miss_is_known_to_be_missing() {
    const SEEDS: u64 = 8;
    let (side, radiance, height) = (0.05_f32, 1e5, 10.0_f64);
    let (focal, radius, tile) = (1.0_f64, 0.5, 0.3);
    let image = 1.0 / (1.0 / focal - 1.0 / height);
    let eye = Vec3::new(0.0, 0.3, 0.0);
    let mut b = builder();
    place(&mut b, paraboloid(focal as f32, radius), {
        Material::new("mirror", Surface::Mirror { reflectance: Rgb::WHITE.into() })
    });
    let (half, y) = (0.5 * tile as f32, image as f32);
    let matt = parallelogram(Vec3::new(-half, y, -half), Vec3::X * 2.0 * half, Vec3::Z * 2.0 * half);
    place(&mut b, matt, Material::new("tile", lambert(0.5)));
    let corner = Vec3::new(-0.5 * side, height as f32, -0.5 * side);
    place(
        &mut b,
        parallelogram(corner, side * Vec3::X, side * Vec3::Z),
        glowing("lamp", lambert(0.0), radiance),
    );
    // The image has one pixel, which shows a square of 0.28 m on the tile.
    let pixel = 0.28;
    let fov = 2.0 * (0.5 * pixel / (image - 0.3)).atan();
    b.add_camera(Camera::look_at("main", eye, Vec3::Y, Vec3::Z, fov as f32)).unwrap();
    let tracer = tracer(b);
    // All light that reaches the square mirror, except in the shadow of the tile, comes to the
    // focus. Light that the tile sends to itself over the mirror adds less than a tenth.
    let lit = f64::from(4.0 * radius * radius) - tile * tile;
    let flux = f64::from(radiance * side * side) / (height * height) * lit;
    let expected = 0.5 / PI * flux / (pixel * pixel);
    let (mut missing, mut claims) = (0, 0);
    for seed in 1..=SEEDS {
        let render = Renderer::on(&tracer).size([1, 1]).vpls(2000).error(0.2).seed(seed).render().unwrap();
        let record = RenderFilm::of(&render.film).at(0, 0);
        let (found, h) = (f64::from(record.radiance.luminance()), f64::from(record.half_width));
        if record.claim == Claim::None {
            let light = FoundLight::of(&render.film).expect("light paths know of the focus");
            missing += 1;
            let known = found + f64::from(record.luminance_parts.missing);
            assert!(known > 0.5 * expected && light.missing > 0.2, "{record:?} for {expected}");
        } else {
            claims += 1;
            assert!((found - expected).abs() <= h + 0.15 * expected, "{found} ± {h} for {expected}");
        }
    }
    assert!(missing + claims == SEEDS && missing > 0, "{missing} of {SEEDS} lack the focus");
}
