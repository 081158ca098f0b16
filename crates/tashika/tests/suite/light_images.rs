//! Lights that emit by an image: the conventions of each format in numbers, sums over VPLs against
//! the path tracer and a formula, and bounds of clusters.

use std::f32::consts::PI;
use std::sync::Arc;

use tashika::bounds::{Towards, upper_geometric};
use tashika::color::Rgb;
use tashika::contribution::ContributionKernel;
use tashika::film::Window;
use tashika::integrator::{FullSum, Integrator, Setting};
use tashika::io::save_vpls;
use tashika::math::elementary::{acos, atan2, tan};
use tashika::math::{Aabb, Mat3, Vec3};
use tashika::rng::{Purpose, Stream};
use tashika::scene::{
    Camera, Emitter, Image, IntensityMap, Lookup, Material, Pixels, Sampling, Scene, SceneBuilder,
    SlideWeight, SphereMap, Spread, Surface, Wrap,
};
use tashika::tree::{LightTree, LightTreeBuilder};
use tashika::vpl::{Clamp, VplOptions, VplSet};

use super::light_transport::{agree, transport_agrees};
use super::pbrt::{Folder, V3, V4};
use crate::cases::{builder, cuboid, diffuse_room, lambert, parallelogram, place, tracer, view};

/// `width × height` texels of a function of column and row.
fn image(width: u32, height: u32, texel: impl Fn(u32, u32) -> [f32; 3]) -> Image {
    let pixels = (0..width * height).map(|i| texel(i % width, i / width)).collect();
    Image { name: "test".into(), width, height, pixels: Pixels::Float(pixels) }
}

fn lookup(sampling: Sampling) -> Lookup {
    Lookup { sampling, wrap: [Wrap::Repeat; 2] }
}

/// A coloured slide with dark and bright texels.
fn slide(sampling: Sampling, weight: SlideWeight) -> Arc<IntensityMap> {
    let picture = image(5, 4, |x, y| {
        if (x + y) % 3 == 0 { [0.0; 3] } else { [0.1 + x as f32, 1.0, if y == 2 { 4.0 } else { 0.2 }] }
    });
    let spread = Spread::Slide { tan: [0.6, 0.5], weight };
    Arc::new(IntensityMap::new(picture, spread, lookup(sampling)).unwrap())
}

/// A lamp whose map is bright upward and dim downward.
fn lamp(spread: Spread, sampling: Sampling) -> Arc<IntensityMap> {
    let picture = image(8, 8, |x, y| [0.2 + y as f32, 1.0 + (x % 3) as f32, 0.5 * (y / 4) as f32]);
    Arc::new(IntensityMap::new(picture, spread, lookup(sampling)).unwrap())
}

fn turned() -> Mat3 {
    Mat3::from_cols(Vec3::X, Vec3::NEG_Z, Vec3::Y) * Mat3::from_rotation_x(-0.3)
}

/// The diffuse room, lit by a lamp and by a projector from the open side.
fn lit_room() -> SceneBuilder {
    let mut b = diffuse_room();
    let (even, screen) = (SlideWeight::Even, SlideWeight::Screen);
    let at = Vec3::new(0.1, 1.1, 2.5);
    let back = Mat3::from_diagonal(Vec3::new(1.0, -1.0, -1.0));
    b.add_image_light(&slide(Sampling::Bilinear, screen), at, Rgb::new(1.0, 0.8, 1.2), back).unwrap();
    b.add_image_light(&slide(Sampling::Nearest, even), at, Rgb::gray(0.5), turned()).unwrap();
    let under_the_ceiling = Vec3::new(-0.5, 1.6, 0.5);
    let octahedral = lamp(Spread::Sphere(SphereMap::EqualArea), Sampling::Nearest);
    b.add_image_light(&octahedral, under_the_ceiling, Rgb::gray(0.08), turned()).unwrap();
    let lat_long = lamp(Spread::Sphere(SphereMap::LatLong), Sampling::Bilinear);
    b.add_image_light(&lat_long, Vec3::new(0.6, 1.5, 0.2), Rgb::gray(0.06), turned()).unwrap();
    b
}

#[test]
fn many_lights_and_the_path_tracer_agree() {
    agree(lit_room(), "lights of images");
}

#[test]
fn what_vpls_do_not_carry_is_put_back() {
    let mut b = lit_room();
    let mirror = Surface::Mirror { reflectance: Rgb::gray(0.8).into() };
    place(
        &mut b,
        cuboid(Vec3::new(-0.8, 0.0, -0.2), Vec3::new(-0.4, 0.5, 0.3), false),
        Material::new("mirror", mirror),
    );
    transport_agrees(b, 0.01, "lights of images");
}

/// A slide projected onto the plane `y = 0`, seen from above. The reflected radiance of each pixel
/// follows from the intensity by a formula.
#[test]
fn a_slide_on_a_plane_follows_its_formula() {
    let mut b = builder();
    let floor = parallelogram(Vec3::new(-9.0, 0.0, -9.0), Vec3::Z * 18.0, Vec3::X * 18.0);
    place(&mut b, floor, Material::new("floor", lambert(0.6)));
    b.add_camera(Camera::look_at("c", Vec3::new(0.0, 3.0, 0.0), Vec3::ZERO, Vec3::Z, 0.7)).unwrap();
    let at = Vec3::new(0.1, 2.0, -0.2);
    // The slide looks down: its +z is −y of the world, its columns run along +x, its rows along +z.
    let down = Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y);
    let texel = |x: i32, y: i32| Rgb::new(1.0 + x as f32, 2.0 + y as f32, 0.5);
    let picture = image(6, 4, |x, y| texel(x as i32, y as i32).to_array());
    let spread = Spread::Slide { tan: [0.45, 0.3], weight: SlideWeight::Screen };
    let map = IntensityMap::new(picture, spread, lookup(Sampling::Nearest)).unwrap();
    b.add_image_light(&Arc::new(map), at, Rgb::new(3.0, 2.0, 1.0), down).unwrap();
    let tracer = tracer(b);
    let options = VplOptions { max_depth: 0, clamp: Clamp::Off, ..VplOptions::default() };
    let set = VplSet::trace(&tracer, &options).unwrap();
    assert_eq!(set.len(), 1);
    let view = view(tracer.scene(), [24, 24], 1, 1);
    let setting = Setting { tracer: &tracer, view };
    let estimates = FullSum::new(&set).estimate(&setting, &Window::full([24, 24]));
    let (mut lit, mut dark) = (0, 0);
    for (i, e) in (0..).zip(estimates) {
        let ray = view.beginning([i % 24, i / 24], 0).0.ray().unwrap();
        let x = ray.at(-ray.origin.y / ray.direction.y);
        // On a screen at right angles to the axis, at a distance of 2, the irradiance is I₀ texel /
        // 4, at every angle.
        let place = [(x.x - at.x) / 2.0 / 0.45, (x.z - at.z) / 2.0 / 0.3];
        let [u, v] = [(0.5 + 0.5 * place[0]) * 6.0, (0.5 + 0.5 * place[1]) * 4.0];
        // Points near the boundary of a texel are skipped, where rounding decides.
        if [u, v].iter().any(|c| (c - c.round()).abs() < 1e-3) {
            continue;
        }
        let inside = (0.0..6.0).contains(&u) && (0.0..4.0).contains(&v);
        let irradiance = Rgb::new(3.0, 2.0, 1.0) * texel(u as i32, v as i32) / 4.0;
        let expected = if inside { irradiance * (0.6 / PI) } else { Rgb::BLACK };
        *if inside { &mut lit } else { &mut dark } += 1;
        let error = (e.radiance.zip(expected, |a, b| (a - b).abs())).max_channel();
        assert!(error <= 2e-5 * expected.max_channel(), "{:?} for {expected:?} at {u} {v}", e.radiance);
    }
    assert!(lit > 100 && dark > 100, "{lit} lit, {dark} dark");
}

/// For every kind of map, no term of a cluster exceeds the cluster's bound.
#[test]
fn bounds_hold_for_lights_of_images() {
    let mut b = builder();
    let mut s = Stream::new(3, Purpose::Test, 0);
    place(&mut b, cuboid(Vec3::ZERO, Vec3::ONE, true), Material::new("m", lambert(0.5)));
    let maps = [
        slide(Sampling::Bilinear, SlideWeight::Screen),
        slide(Sampling::Nearest, SlideWeight::Even),
        lamp(Spread::Sphere(SphereMap::EqualArea), Sampling::Nearest),
        lamp(Spread::Sphere(SphereMap::LatLong), Sampling::Bilinear),
    ];
    for k in 0..48 {
        // Clusters are bounded by a cone only if all of their lights are slides.
        let map = if k < 24 { &maps[k % 2] } else { &maps[2 + k % 2] };
        let at = Vec3::from(s.uniform_3()) + if k < 24 { Vec3::ZERO } else { Vec3::X * 9.0 };
        let turn = Mat3::from_rotation_y(0.5 * s.uniform()) * Mat3::from_rotation_x(0.5 * s.uniform());
        b.add_image_light(map, at, Rgb::new(s.uniform(), 1.0, 0.3), turn).unwrap();
    }
    let tracer = tracer(b);
    let set = VplSet::trace(&tracer, &VplOptions { max_depth: 0, ..VplOptions::default() }).unwrap();
    assert_eq!(set.len(), 48);
    let tree = LightTree::build(&set, LightTreeBuilder::default());
    tree.validate().unwrap();
    let contribution = ContributionKernel::new(0.05).within(tracer.scene());
    let (mut lit, mut dark, mut near) = (0, 0, 0.0f32);
    for _ in 0..400 {
        let lo = 4.0 * Vec3::from(s.uniform_3()) - 1.5;
        let points = Aabb { lo, hi: lo + 0.2 * Vec3::from(s.uniform_3()) };
        let mut waiting = vec![tree.root().unwrap()];
        while let Some(cluster) = waiting.pop() {
            let bounds = tree.bounds(&cluster);
            let bound = upper_geometric(&bounds, &Towards::between(&bounds, &points), 0.05);
            dark += u32::from(bound == 0.0);
            for light in cluster.lights().map(|number| tree.light(number as u32)) {
                let at = points.lo + (points.hi - points.lo) * Vec3::from(s.uniform_3());
                let link = contribution.link(at, &light);
                assert!(link.geometric <= bound && link.tint.max_channel() <= 1.0, "{link:?} of {bound}");
                lit += u32::from(link.geometric > 0.0);
                near = near.max(link.geometric / bound.max(f32::MIN_POSITIVE));
            }
            waiting.extend(tree.children(&cluster).into_iter().flatten());
        }
    }
    assert!(lit > 1000 && dark > 1000 && near > 0.8, "{lit} {dark} {near}");
}

#[test]
fn sets_are_for_the_scene_that_has_their_maps() {
    let with = tracer(lit_room());
    let set = VplSet::trace(&with, &VplOptions::default()).unwrap();
    set.validate_for(with.scene()).unwrap();
    let without = diffuse_room().build().unwrap();
    let message = set.validate_for(&without).unwrap_err().to_string();
    assert!(message.contains("image that this scene does not have"), "{message}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("set.vpls");
    save_vpls(&path, &set).unwrap();
    assert_eq!(tashika::io::load_vpls(&path).unwrap(), set);
}

/// Intensity of the scene's only light in a direction.
fn intensity(scene: &Scene, direction: Vec3) -> Rgb {
    let [Emitter::Image { intensity, beam, .. }] = *scene.emitters() else {
        panic!("{:?}", scene.emitters())
    };
    intensity * scene.intensity_maps()[beam.map as usize].relative(direction.normalize())
}

fn pfm(image: &Image) -> Vec<u8> {
    let Pixels::Float(texels) = &image.pixels else { panic!() };
    let mut bytes = format!("PF\n{} {}\n-1.0\n", image.width, image.height).into_bytes();
    for row in texels.chunks(image.width as usize).rev() {
        bytes.extend(row.as_flattened().iter().flat_map(|v| v.to_le_bytes()));
    }
    bytes
}

fn close(a: Rgb, b: [f32; 3]) -> bool {
    a.to_array().iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-4 * (1.0 + b.abs()))
}

/// Expected intensities are Mitsuba 3.9.1's values at points, times their squared distance. The
/// image has 4×2 texels.
#[test]
fn projectors_and_spots_are_mitsubas() {
    let picture = pfm(&image(4, 2, |x, y| [1.0 + x as f32 + 10.0 * y as f32, 0.5, f32::from(x == 3)]));
    let load = |body: &str| {
        let text = super::mitsuba::xml("3.0.0", body);
        let files: super::mitsuba::Files<'_> = &[("scene.xml", text.as_bytes()), ("slide.pfm", &picture)];
        let scene = super::mitsuba::load_in(files).1.unwrap();
        assert_eq!(scene.notes().first_departure(), None, "{body}");
        scene
    };
    let bitmap = |name: &str, filter: &str| {
        format!(
            "<texture type=\"bitmap\" name=\"{name}\"><string name=\"filename\" value=\"slide.pfm\"/>\
             <string name=\"filter_type\" value=\"{filter}\"/><boolean name=\"raw\" value=\"true\"/></texture>"
        )
    };
    let projector = |lens: &str, filter: &str| {
        load(&format!(
            "<emitter type=\"projector\"><float name=\"scale\" value=\"2\"/>{lens}{}</emitter>",
            bitmap("irradiance", filter)
        ))
    };
    let check = |scene: &Scene, expected: &[([f32; 3], [f32; 3])]| {
        for (point, expected) in expected {
            let found = intensity(scene, Vec3::from(*point));
            assert!(close(found, *expected), "{found:?} for {expected:?} at {point:?}");
        }
    };
    let fov = |degrees: u32| format!("<float name=\"fov\" value=\"{degrees}\"/>");
    check(
        &projector(&fov(60), "bilinear"),
        &[
            ([0.1, 0.05, 1.0], [34.7052, 3.20068, 0.0]),
            ([-0.3, 0.1, 1.0], [36.7888, 3.62442, 3.9088]),
            ([0.3, -0.2, 1.0], [71.9461, 3.7737, 0.0]),
            ([0.1, 0.5, 1.0], [0.0; 3]),
            ([0.1, 0.05, -1.0], [0.0; 3]),
        ],
    );
    let vertical = format!("{}<string name=\"fov_axis\" value=\"y\"/>", fov(50));
    check(
        &projector(&vertical, "nearest"),
        &[
            ([0.1, 0.05, 1.0], [12.802726, 3.2006814, 0.0]),
            ([0.3, -0.1, 1.0], [86.98616, 3.6244233, 0.0]),
            ([-0.02, -0.1, 1.0], [82.958954, 3.190729, 0.0]),
        ],
    );
    check(
        &projector("<string name=\"focal_length\" value=\"30mm\"/>", "bilinear"),
        &[([0.3, 0.1, 1.0], [25.1453, 3.62442, 0.0]), ([0.5, 0.3, 1.0], [53.1551, 4.87312, 0.491544])],
    );
    let constant = "<emitter type=\"projector\"><float name=\"fov\" value=\"60\"/>\
        <rgb name=\"irradiance\" value=\"1 2 3\"/></emitter>";
    check(&load(constant), &[([0.1, 0.5, 1.0], [4.4433, 8.8866, 13.3299])]);
    let spot = format!(
        "<emitter type=\"spot\"><float name=\"cutoff_angle\" value=\"40\"/><float name=\"beam_width\" \
         value=\"20\"/><float name=\"intensity\" value=\"3\"/>{}</emitter>",
        bitmap("texture", "bilinear")
    );
    check(
        &load(&spot),
        &[
            ([0.1, 0.05, 1.0], [25.0027, 1.5, 0.0]),
            ([0.3, 0.1, 1.0], [28.2204, 1.5, 0.645156]),
            ([-0.3, 0.1, 1.0], [23.9301, 1.5, 0.0]),
            ([0.3, -0.2, 1.0], [17.4946, 1.5, 0.645156]),
            ([0.1, 0.5, 1.0], [22.9399, 0.973716, 0.0]),
            ([0.5, 0.3, 1.0], [17.9474, 0.731531, 1.01208]),
            ([0.9, 0.3, 1.0], [0.0; 3]),
        ],
    );
}

/// Goniometric maps of pbrt-v3 and pbrt-v4: directions in the light's frame are mapped by the
/// formulas of the format.
#[test]
fn goniometric_maps_are_turned_as_each_format_turns_them() {
    let folder = Folder::new();
    let value = |x: u32, y: u32| 1.0 + x as f32 + 10.0 * y as f32;
    folder.write("long.pfm", pfm(&image(16, 8, |x, y| [value(x, y); 3])));
    folder.write("square.pfm", pfm(&image(8, 8, |x, y| [0.0, value(x, y), 2.0 * value(x, y)])));
    let light = "Rotate 30 1 2 3 LightSource \"goniometric\" \"rgb I\" [2 2 1]";
    let own = Mat3::from_axis_angle(Vec3::new(1.0, 2.0, 3.0).normalize(), 30f32.to_radians());
    let old = folder.load(&format!("{V3} {light} \"string mapname\" \"long.pfm\" WorldEnd")).unwrap();
    let new = folder.load(&format!("{V4} {light} \"string filename\" \"square.pfm\"")).unwrap();
    let mut s = Stream::new(1, Purpose::Test, 0);
    for _ in 0..500 {
        let d = tashika::warp::sphere(s.uniform_2());
        // pbrt swaps y and z first: the polar angle is from +y, the azimuth from +x towards +z.
        let u = (atan2(d.z, d.x) / (2.0 * PI)).rem_euclid(1.0) * 16.0;
        let v = acos(d.y) / PI * 8.0;
        // Bilinear values of a ramp equal the ramp, except at the seam and at the poles.
        if (0.5..15.5).contains(&u) && (0.5..7.5).contains(&v) {
            let expected = 1.0 + (u - 0.5) + 10.0 * (v - 0.5);
            let found = intensity(&old, own * d);
            let error = (found.r / (2.0 * expected) - 1.0).abs();
            assert!(error < 1e-3 && found.b < found.r, "{d}: {found:?} for {expected}");
        }
    }
    // The octahedral map has +y at the centre, +x at the right edge, +z at the lower edge and −y in
    // the corners; its value is the mean of the channels.
    for (direction, texel) in [
        ([0.05, 1.0, 0.05], [4, 4]),
        ([-0.05, 1.0, 0.05], [3, 4]),
        ([1.0, 0.02, 0.05], [7, 4]),
        ([0.05, 0.02, 1.0], [4, 7]),
        ([-1.0, 0.02, 0.05], [0, 4]),
        ([0.05, 0.02, -1.0], [4, 0]),
        ([0.05, -1.0, 0.05], [7, 7]),
        ([-0.05, -1.0, -0.05], [0, 0]),
    ] {
        let found = intensity(&new, own * Vec3::from(direction));
        let expected = value(texel[0], texel[1]);
        assert!(close(found, [2.0 * expected, 2.0 * expected, expected]), "{found:?} at {direction:?}");
    }
    // ∫ I = power, and the integral is the mean of the texels times 4π.
    let power = format!("{V4} {light} \"float power\" 100 \"string filename\" \"square.pfm\"");
    let found = intensity(&folder.load(&power).unwrap(), own * Vec3::new(0.05, 1.0, 0.05));
    let expected = 2.0 * value(4, 4) * 100.0 / (4.0 * PI * 39.5);
    assert!((found.r / expected - 1.0).abs() < 1e-4, "{found:?}, {expected}");
    // Without a map it is a point light.
    let plain = folder.load(&format!("{V4} LightSource \"goniometric\" \"float power\" 10")).unwrap();
    let [Emitter::Point { intensity, .. }] = plain.emitters() else { panic!("{:?}", plain.emitters()) };
    assert!(close(*intensity, [10.0 / (4.0 * PI); 3]));
}

/// Slides of both versions: the field of view spans the shorter side. The top row is at −y in
/// pbrt-v3 and at +y in pbrt-v4.
#[test]
fn projections_are_turned_as_each_format_turns_them() {
    let folder = Folder::new();
    folder.write("wide.pfm", pfm(&image(4, 2, |x, y| [1.0 + x as f32 + 10.0 * y as f32; 3])));
    let slide = "LightSource \"projection\" \"float fov\" 60 \"float scale\" 2";
    let old =
        folder.load(&format!("{V3} {slide} \"rgb I\" [1 2 3] \"string mapname\" \"wide.pfm\" WorldEnd"));
    let old = old.unwrap();
    let new = folder.load(&format!("{V4} {slide} \"string filename\" \"wide.pfm\"")).unwrap();
    let half = tan(30f32.to_radians());
    for (x, y, column, row) in [(0, 0, 0, 0), (1, 0, 1, 0), (2, 1, 2, 1), (3, 1, 3, 1), (3, 0, 3, 0)] {
        // Direction to the centre of a texel; `half` is the tangent of the shorter side's half
        // angle.
        let at = |y: f32| Vec3::new((0.5 * (x as f32 + 0.5) - 1.0) * 2.0 * half, y * half, 1.0);
        let height = y as f32 + 0.5 - 1.0;
        let expected = 2.0 * (1.0 + column as f32 + 10.0 * row as f32);
        let found = intensity(&old, at(height));
        assert!(close(found, [expected, 2.0 * expected, 3.0 * expected]), "v3: {found:?} for {expected}");
        let found = intensity(&new, at(-height));
        assert!(close(found, [expected; 3]), "v4: {found:?} for {expected}");
    }
    assert_eq!(intensity(&new, Vec3::new(0.0, half * 1.01, 1.0)), Rgb::BLACK);
    assert_eq!(intensity(&new, Vec3::new(half * 2.02, 0.0, 1.0)), Rgb::BLACK);
    assert!(!intensity(&new, Vec3::new(half * 1.98, 0.1, 1.0)).is_black());
    // Without an image pbrt-v3 projects a white square.
    let white = folder.load(&format!("{V3} {slide} WorldEnd")).unwrap();
    assert!(close(intensity(&white, Vec3::new(half * 0.99, -half * 0.99, 1.0)), [2.0; 3]));
    assert_eq!(intensity(&white, Vec3::new(half * 1.01, 0.0, 1.0)), Rgb::BLACK);
    assert_eq!(white.notes().first_departure(), None);
    // Expected power by pbrt's own sum: A ∑ texel cos³ / n.
    let power = folder.load(&format!("{V4} {slide} \"float power\" 50 \"string filename\" \"wide.pfm\""));
    let sum: f32 = (0..8)
        .map(|i| {
            let (x, y) = (i % 4, i / 4);
            let d = Vec3::new((0.5 * (x as f32 + 0.5) - 1.0) * 2.0 * half, (y as f32 - 0.5) * half, 1.0);
            (1.0 + x as f32 + 10.0 * y as f32) / d.length().powi(3)
        })
        .sum();
    let k = 4.0 * half * half * 2.0 * sum / 8.0;
    let found = intensity(&power.unwrap(), Vec3::new(0.1, 0.1, 1.0));
    let expected = intensity(&new, Vec3::new(0.1, 0.1, 1.0)).r * 50.0 / k;
    assert!((found.r / expected - 1.0).abs() < 1e-4, "{found:?} for {expected}");
}
