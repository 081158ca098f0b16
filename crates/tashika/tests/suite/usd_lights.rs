//! Lights of USD against closed forms.
//!
//! Irradiance is summed over the surfaces of the lights, cut into small parts. With `K²` parts per
//! triangle the relative error is below `1/K²`.

use std::f64::consts::PI;

use glam::Vec3;
use tashika::color::Rgb;
use tashika::io::LoadOptions;
use tashika::scene::{Emitter, NoteKind, Scene};

use super::gltf::notes;
use super::usd::{load, load_with, quad};

/// Number of parts along a triangle's side.
const PARTS: u32 = 48;

/// Irradiance (red) of a point with normal `n` by emitting surfaces, without occlusion.
fn irradiance(scene: &Scene, at: Vec3, n: Vec3) -> f64 {
    let mut sum = 0.0;
    for (id, _) in scene.area_emitters() {
        for triangle in 0..scene.mesh_of(id).triangles().len() as u32 {
            let [a, b, c] = scene.world_corners(id, triangle).map(|p| p.as_dvec3());
            let part = 0.5 * (b - a).cross(c - a).length() / f64::from(PARTS * PARTS);
            for i in 0..PARTS {
                for j in 0..2 * (PARTS - i) - 1 {
                    // Centres of the parts, of which every second is upside down.
                    let third = if j % 2 == 0 { 1.0 / 3.0 } else { 2.0 / 3.0 };
                    let u = (i as f32 + third) / PARTS as f32;
                    let v = ((j / 2) as f32 + third) / PARTS as f32;
                    let point = scene.surface_point(id, triangle, [1.0 - u - v, u, v]);
                    let way = at - point.position;
                    let distance = way.length();
                    let direction = way / distance;
                    let cos = point.geometric_normal.dot(direction).abs() * (-n.dot(direction)).max(0.0);
                    let radiance = scene.emitted(&point, direction).r;
                    sum += f64::from(radiance * cos / (distance * distance)) * part;
                }
            }
        }
    }
    sum
}

/// Irradiance below the centre of a rectangle of radiance 1 with sides `2a` and `2b`, at the given
/// distance.
fn below_rectangle(a: f64, b: f64, distance: f64) -> f64 {
    let corner = |x: f64, y: f64| {
        let (p, q) = ((x * x + distance * distance).sqrt(), (y * y + distance * distance).sqrt());
        0.5 * (x / p * (y / p).atan() + y / q * (x / q).atan())
    };
    4.0 * corner(a, b)
}

fn near(found: f64, expected: f64, share: f64) {
    assert!((found / expected - 1.0).abs() < share, "{found}, not {expected}");
}

const BELOW: Vec3 = Vec3::new(0.0, 0.0, -2.0);

#[test]
fn rectangles_shine_down_with_their_radiance_or_power() {
    let lamp = |more: &str| {
        load(&format!("def RectLight \"W\" {{ float inputs:width = 3\n float inputs:height = 1\n {more} }}"))
            .unwrap()
    };
    let expected = below_rectangle(1.5, 0.5, 2.0);
    near(irradiance(&lamp(""), BELOW, Vec3::Z), expected, 2e-3);
    assert_eq!(irradiance(&lamp(""), -BELOW, Vec3::NEG_Z), 0.0, "its back is dark");
    near(
        irradiance(&lamp("float inputs:intensity = 3\n float inputs:exposure = 2"), BELOW, Vec3::Z),
        12.0 * expected,
        2e-3,
    );
    near(irradiance(&lamp("bool inputs:normalize = true"), BELOW, Vec3::Z), expected / 3.0, 2e-3);
    near(irradiance(&lamp("color3f inputs:color = (0.25, 1, 1)"), BELOW, Vec3::Z), expected / 4.0, 2e-3);
    // In the spelling of files before 2021.
    near(irradiance(&lamp("float intensity = 3"), BELOW, Vec3::Z), 3.0 * expected, 2e-3);
}

/// A normalized light keeps its power when it is scaled. The picture does not depend on the unit of
/// the file.
#[test]
fn sizes_are_those_in_the_world_and_in_the_scenes_units() {
    let lamp = |unit: f64, scale: f64| {
        let text = format!(
            "#usda 1.0\n( metersPerUnit = {unit} )\ndef RectLight \"W\" {{ bool inputs:normalize = true
    float inputs:width = 0.2\n float inputs:height = 0.1\n float3 xformOp:scale = ({scale}, {scale}, {scale})
    uniform token[] xformOpOrder = [\"xformOp:scale\"] }}"
        );
        let scene = load(&text).unwrap();
        irradiance(&scene, BELOW * unit as f32, Vec3::Z)
    };
    let expected = lamp(1.0, 1.0);
    near(expected, 1.0 / 4.0, 1e-2);
    near(lamp(0.01, 1.0), expected, 1e-4);
    near(lamp(1.0, 2.0), expected, 2e-2);
    near(lamp(0.01, 2.0), lamp(1.0, 2.0), 1e-4);
}

#[test]
fn disks_spheres_and_cylinders_shine_as_their_closed_forms() {
    let scene = load("def DiskLight \"W\" { float inputs:radius = 1 }").unwrap();
    // π r² / (r² + d²).
    near(irradiance(&scene, BELOW, Vec3::Z), PI / 5.0, 3e-3);
    assert_eq!(irradiance(&scene, -BELOW, Vec3::NEG_Z), 0.0);
    let scene = load("def SphereLight \"W\" { float inputs:radius = 0.5 }").unwrap();
    // π (r / d)².
    near(irradiance(&scene, BELOW, Vec3::Z), PI / 16.0, 5e-3);
    let scene = load("def SphereLight \"W\" { bool inputs:normalize = true }").unwrap();
    near(irradiance(&scene, BELOW, Vec3::Z), PI / 16.0 / PI, 5e-3);
    // A thin line along x: L 2r ∫ cos²θ d / (x² + d²) dx at the distance d.
    let scene =
        load("def CylinderLight \"W\" { float inputs:radius = 0.005\n float inputs:length = 2 }").unwrap();
    let steps = 10_000;
    let line: f64 = (0..steps)
        .map(|i| {
            let x = -1.0 + 2.0 * (f64::from(i) + 0.5) / f64::from(steps);
            let squared = x * x + 4.0;
            0.01 * 4.0 / (squared * squared) * 2.0 / f64::from(steps)
        })
        .sum();
    near(irradiance(&scene, BELOW, Vec3::Z), line, 1e-2);
}

#[test]
fn distant_lights_keep_their_irradiance() {
    let light = |more: &str| {
        let scene = load(&format!("def DistantLight \"W\" {{ {more} }}")).unwrap();
        let [Emitter::Directional { direction, irradiance }] = *scene.emitters() else { panic!() };
        assert!((direction - Vec3::NEG_Z).length() < 1e-6);
        f64::from(irradiance.r)
    };
    let sin = |degrees: f64| (0.5 * degrees.to_radians()).sin();
    near(light("float inputs:intensity = 7\n float inputs:angle = 0"), 7.0, 1e-6);
    near(
        light("float inputs:intensity = 7\n float inputs:angle = 40"),
        7.0 * PI * sin(40.0) * sin(40.0),
        1e-5,
    );
    near(
        light("float inputs:intensity = 7\n float inputs:angle = 40\n bool inputs:normalize = 1"),
        7.0,
        1e-6,
    );
    near(light(""), 50_000.0 * PI * sin(0.53) * sin(0.53), 1e-4);
    near(light("float inputs:intensity = 1\n float inputs:angle = 360"), 2.0 * PI, 1e-5);
}

#[test]
fn points_and_cones_have_the_intensity_of_their_sphere() {
    let emitter = |more: &str| {
        let scene =
            load(&format!("def SphereLight \"W\" {{ float inputs:intensity = 8\n {more} }}")).unwrap();
        scene.emitters()[0]
    };
    let intensity = |more: &str| match emitter(more) {
        Emitter::Point { intensity, .. } | Emitter::Spot { intensity, .. } => f64::from(intensity.r),
        other => panic!("{other:?}"),
    };
    // Far away a sphere of radiance L looks like a disk: I = L π r².
    near(intensity("bool treatAsPoint = true\n float inputs:radius = 0.25"), 8.0 * PI / 16.0, 1e-4);
    near(intensity("bool treatAsPoint = true\n bool inputs:normalize = true"), 2.0, 1e-6);
    near(intensity("float inputs:radius = 0\n bool inputs:normalize = true"), 2.0, 1e-6);
    let cone = "bool treatAsPoint = true\n float inputs:shaping:cone:angle = 40\n float inputs:shaping:cone:softness = 0.25";
    let Emitter::Spot { axis, falloff, .. } = emitter(cone) else { panic!() };
    assert!((axis - Vec3::NEG_Z).length() < 1e-6);
    near(f64::from(falloff.cos_outer), 40.0_f64.to_radians().cos(), 1e-5);
    near(f64::from(falloff.cos_inner), 30.0_f64.to_radians().cos(), 1e-5);
}

/// Expected colours are those of `UsdLuxBlackbodyTemperatureAsRgb`. It uses a spline, so they agree
/// within 3% of the largest channel.
#[test]
fn temperatures_are_the_colours_of_black_bodies() {
    for (kelvin, expected) in [
        (2000, [2.520_566_2, 0.646_888_26, 0.020_403_985]),
        (3000, [1.771_028_4, 0.844_293_53, 0.272_031_75]),
        (6500, [1.043_333_4, 0.983_624_46, 1.034_613_3]),
        (10_000, [0.871_841_3, 0.994_687_9, 1.429_995_9]),
    ] {
        let text = format!(
            "def DistantLight \"W\" {{ float inputs:intensity = 1\n float inputs:angle = 0
    bool inputs:enableColorTemperature = true\n float inputs:colorTemperature = {kelvin} }}"
        );
        let scene = load(&text).unwrap();
        let [Emitter::Directional { irradiance, .. }] = scene.emitters() else { panic!() };
        let expected = Vec3::from(expected);
        let found = Vec3::from(irradiance.to_array());
        assert!((found - expected).abs().max_element() < 0.03 * expected.max_element(), "{kelvin}: {found}");
    }
}

#[test]
fn domes_are_seen_from_inside() {
    let scene = load("def DomeLight \"W\" { float inputs:intensity = 3 }\ndef DomeLight \"V\" { }").unwrap();
    let sky = scene.environment().unwrap();
    for direction in [Vec3::X, Vec3::NEG_Y, Vec3::new(0.6, 0.0, -0.8)] {
        assert_eq!(sky.radiance(direction), Rgb::gray(4.0));
    }
    // Four columns, at longitudes from π to −π, each of a different colour. The lower half is
    // black.
    let columns = [[1.0_f32, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0]];
    let rows = [[[0.0; 3]; 4], columns];
    // A PFM file begins with the lowest row.
    let texels = rows.iter().flatten().flatten().flat_map(|v| v.to_le_bytes());
    let pfm: Vec<u8> = b"PF 4 2 -1\n".iter().copied().chain(texels).collect();
    let dome = |head: &str, light: &str| {
        let text = format!("#usda 1.0\n( metersPerUnit = 1\n {head} )\n{light}");
        load_with(&text, &[("sky.pfm", &pfm)], &LoadOptions::default()).unwrap()
    };
    let seen = |scene: &Scene, x: f32, y: f32, z: f32| {
        scene.environment().unwrap().radiance(Vec3::new(x, y, z).normalize()).to_array()
    };
    let plain = "def DomeLight \"W\" { asset inputs:texture:file = @sky.pfm@ }";
    let scene = dome("", plain);
    // Centres of the columns: longitudes 3π/4, π/4, −π/4, −3π/4, measured from z towards x.
    for (x, z, expected) in [(1.0, -1.0, 0), (1.0, 1.0, 1), (-1.0, 1.0, 2), (-1.0, -1.0, 3)] {
        let found = Vec3::from(seen(&scene, x, 1.5, z));
        assert!((found - Vec3::from(columns[expected])).length() < 1e-4, "{x} {z}: {found}");
        assert_eq!(seen(&scene, x, -1.5, z), [0.0; 3]);
    }
    // In a file with z up, the pole of a `DomeLight` is still its y, which is −z of the world here.
    // The pole of a `DomeLight_1` is z, and its longitude 0 is at −y, which is +z of the world.
    let scene = dome("upAxis = \"Z\"", plain);
    assert!(seen(&scene, 1.0, 1.0, -1.5) != [0.0; 3] && seen(&scene, 1.0, 1.0, 1.5) == [0.0; 3]);
    let scene = dome("upAxis = \"Z\"", &plain.replace("DomeLight", "DomeLight_1"));
    assert_eq!(seen(&scene, 1.0, -1.5, 1.0), [0.0; 3]);
    assert!((Vec3::from(seen(&scene, 1.0, 1.5, 1.0)) - Vec3::from(columns[1])).length() < 1e-4);
    let scene = dome("", &format!("{plain}\n{}", plain.replace("\"W\"", "\"V\"")));
    assert!(
        notes(&scene).iter().any(|(kind, m)| *kind == NoteKind::Ignored && m.contains("second DomeLight"))
    );
}

/// A texture's first texel is at `(+x, +y)` of the light, its last at `(−x, −y)`.
#[test]
fn textures_of_rectangles_are_upright_as_seen_from_below() {
    // A PFM file begins with the lowest row. Only the first texel of the upper row is bright.
    let texels = [0.0_f32, 0.0, 1.0, 0.0].iter().flat_map(|v| v.to_le_bytes().repeat(3));
    let pfm: Vec<u8> = b"PF 2 2 -1\n".iter().copied().chain(texels).collect();
    let text = "def RectLight \"W\" { asset inputs:texture:file = @t.pfm@ }";
    let scene = load_with(text, &[("t.pfm", &pfm)], &LoadOptions::default()).unwrap();
    let id = scene.instance_ids().next().unwrap();
    let glow = |x: f32, y: f32| {
        let mut all = (0..2).flat_map(|t| (0..400).map(move |i| (t, i)));
        let hit = all.find_map(|(t, i)| {
            let (u, v) = ((i / 20) as f32 / 20.0 + 0.025, (i % 20) as f32 / 20.0 + 0.025);
            let point = (u + v < 1.0).then(|| scene.surface_point(id, t, [1.0 - u - v, u, v]))?;
            let off = (point.position - Vec3::new(x, y, 0.0)).abs();
            (off.max_element() < 0.05).then_some(point)
        });
        scene.emitted(&hit.unwrap(), Vec3::NEG_Z).r
    };
    assert!(glow(0.25, 0.25) > 0.7);
    for (x, y) in [(-0.25, 0.25), (0.25, -0.25), (-0.25, -0.25)] {
        assert!(glow(x, y) < 0.3, "{x} {y}: {}", glow(x, y));
    }
}

#[test]
fn lights_that_are_hidden_do_not_shine() {
    let text = |more: &str| format!("def DistantLight \"W\" {{ {more} }}\n{}", quad("Q", ""));
    assert_eq!(load(&text("")).unwrap().emitters().len(), 1);
    assert_eq!(load(&text("token visibility = \"invisible\"")).unwrap().emitters().len(), 0);
}
