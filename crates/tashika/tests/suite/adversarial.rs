//! Claims of our method in scenes that are constructed to break the published rule.
//!
//! In these scenes, most pairs of a gather point and a light contribute nothing, and a few pairs
//! contribute nearly all of a pixel's radiance. If all samples happen to be dark, their spread is
//! small, and an interval from the spread alone is narrow around a wrong value.

use std::sync::Arc;

use tashika::accel::Tracer;
use tashika::color::Rgb;
use tashika::film::Window;
use tashika::gather::{GatherOptions, View};
use tashika::integrator::{Claim, ControlOptions, PixelRecord, Promise, Setting, Stop, SumMethod};
use tashika::math::Vec3;
use tashika::rng::{Purpose, Stream};
use tashika::scene::{Camera, Environment, Material, MeshData, SceneBuilder, Surface};
use tashika::tree::LightSet;
use tashika::vpl::{Provenance, Vpl, VplKind, VplSet};
use tashika::warp;

use crate::cases::{builder, cuboid, lambert, parallelogram, place};

const CALIBRATED: SumMethod = SumMethod::Tashika(Promise::Calibrated);
const CERTIFIED: SumMethod = SumMethod::Tashika(Promise::Certified);
/// Number of gather points a pixel.
const POINTS: u32 = 4;
/// Distance below which the contribution of a light is clamped (m), as in traced sets.
const CLAMP: f32 = 0.05;
/// Least share of calibrated intervals that must hold: 95 % minus five standard errors of 160
/// trials. There are 210 to 480 trials, but the seeds of a pixel and its neighbours are correlated.
const LEAST: f64 = 0.95 - 5.0 * 0.0172;

/// Upper limit of the share of intervals of 95 % that hold by the published rule, in scenes in
/// which it breaks. 39 to 62 % hold, which is below the limit by more than four standard errors of
/// 160 trials.
const BROKEN: f64 = 0.8;

/// A scene and its lights.
struct World {
    tracer: Arc<Tracer>,
    lights: LightSet,
    size: [u32; 2],
}

impl World {
    fn new(mut b: SceneBuilder, eye: [f32; 3], target: [f32; 3], fov: f32, lights: Vec<Vpl>) -> Self {
        b.add_camera(Camera::look_at("main", eye.into(), target.into(), Vec3::Y, fov)).unwrap();
        // The scene has no emitters; all light comes from the set.
        Self::lit(Arc::new(Tracer::new(Arc::new(b.build().unwrap()))), lights, CLAMP)
    }

    fn lit(tracer: Arc<Tracer>, lights: Vec<Vpl>, clamp_distance: f32) -> Self {
        let set = VplSet::new(lights, Provenance { clamp_distance, ..Provenance::default() });
        Self { tracer, lights: set.into(), size: [16, 10] }
    }

    fn see<T>(&self, look: impl FnOnce(View<'_>) -> T) -> T {
        let gather = GatherOptions { points: POINTS, ..GatherOptions::default() };
        look(View { camera: &self.tracer.scene().cameras()[0], size: self.size, gather, seed: 2 })
    }

    fn estimate(&self, method: SumMethod, options: &ControlOptions) -> Vec<PixelRecord> {
        let integrator = method.integrator(&self.lights, options).unwrap();
        self.see(|view| {
            integrator.estimate(&Setting { tracer: &self.tracer, view }, &Window::full(self.size))
        })
    }

    fn exact(&self) -> Vec<PixelRecord> {
        self.estimate(SumMethod::Exact, &ControlOptions::default())
    }
}

/// A world and its exact sums.
struct Judged {
    world: World,
    truth: Vec<f64>,
}

/// Shares among the lit pixels, over several seeds.
#[derive(Clone, Copy, Debug, Default)]
struct Kept {
    /// Share of pixels whose interval holds.
    holds: f64,
    /// Share of pixels whose error is at most the requested error.
    within: f64,
    /// Mean number of rays of a pixel.
    rays: f64,
}

impl Judged {
    fn new(world: World) -> Self {
        let truth: Vec<f64> = world.exact().iter().map(luminance).collect();
        assert!(truth.iter().filter(|truth| **truth > 0.0).count() > truth.len() / 2);
        Self { world, truth }
    }

    /// Computes the shares. Pixels whose truth is zero must be estimated as zero, and are not
    /// counted.
    fn kept(&self, method: SumMethod, options: &ControlOptions, seeds: u64) -> Kept {
        let mut kept = Kept::default();
        let mut lit = 0.0;
        for seed in 1..=seeds {
            let estimates = self.world.estimate(method, &ControlOptions { seed, ..*options });
            for (e, &truth) in estimates.iter().zip(&self.truth) {
                let (found, half_width) = (luminance(e), f64::from(e.half_width));
                assert!(e.stop != Stop::Budget && e.claim != Claim::None, "{method}: {e:?}");
                assert!(half_width <= options.error * found * (1.0 + 1e-5), "{method}: {e:?}");
                if truth == 0.0 {
                    assert_eq!(found, 0.0, "{method}: {e:?}");
                    continue;
                }
                // Allows for rounding: a sum has 10⁴ terms, each rounded to `f32` about a dozen
                // times.
                let rounding = 1e-5 * truth;
                let distance = (found - truth).abs();
                kept.holds += f64::from(distance <= half_width + rounding);
                kept.within += f64::from(distance <= options.error * truth + rounding);
                kept.rays += e.rays as f64;
                lit += 1.0;
            }
        }
        Kept { holds: kept.holds / lit, within: kept.within / lit, rays: kept.rays / lit }
    }

    /// Asserts that certified intervals hold. Every inequality in a certificate is conservative:
    /// none of the 2600 lit pixels below misses, so the rate of misses is at most about one in a
    /// thousand (rule of three). The assertion permits ten times that rate, which chance would not
    /// reach.
    fn certificates_hold(&self) {
        let options = ControlOptions { error: 0.1, confidence: 0.8, ..ControlOptions::default() };
        let kept = self.kept(CERTIFIED, &options, 2);
        assert!(kept.holds >= 0.99 && kept.within >= 0.99, "{kept:?}");
    }

    /// Shares of the calibrated method at a confidence of 95 %, for a requested error of 5 %.
    fn calibrated(&self) -> Kept {
        let options = ControlOptions { error: 0.05, confidence: 0.95, ..ControlOptions::default() };
        self.kept(CALIBRATED, &options, 3)
    }

    fn calibrated_intervals_hold(&self) {
        let kept = self.calibrated();
        assert!(kept.holds >= LEAST && kept.within >= LEAST, "{kept:?}");
    }

    /// Asserts that the scene is hard: intervals of 95 % by the published rule hold far less often.
    fn published_intervals_do_not_hold(&self) {
        let options = ControlOptions { error: 0.05, confidence: 0.95, ..ControlOptions::default() };
        let kept = self.kept(SumMethod::Iwasaki2019, &options, 2);
        assert!(kept.holds < BROKEN, "{kept:?}");
    }
}

fn luminance(e: &PixelRecord) -> f64 {
    f64::from(e.radiance.luminance())
}

/// Adds a gray mesh.
fn put(b: &mut SceneBuilder, mesh: MeshData) {
    place(b, mesh, Material::new("gray", lambert(0.6)));
}

/// Adds a gray parallelogram.
fn sheet(b: &mut SceneBuilder, corner: [f32; 3], e: [f32; 3], f: [f32; 3]) {
    put(b, parallelogram(corner.into(), e.into(), f.into()));
}

/// Adds a gray block.
fn slab(b: &mut SceneBuilder, lo: [f32; 3], hi: [f32; 3]) {
    put(b, cuboid(lo.into(), hi.into(), false));
}

fn stream(index: u64) -> Stream {
    Stream::new(17, Purpose::Test, index)
}

/// Returns omnidirectional lights of equal intensity at random positions inside a box.
fn omni(count: usize, lo: [f32; 3], hi: [f32; 3], intensity: f32, s: &mut Stream) -> Vec<Vpl> {
    let (lo, hi) = (Vec3::from(lo), Vec3::from(hi));
    let at = |s: &mut Stream| lo + Vec3::from(s.uniform_3()) * (hi - lo);
    (0..count)
        .map(|_| Vpl {
            position: at(s),
            direction: Vec3::ZERO,
            intensity: Rgb::gray(intensity),
            kind: VplKind::Omni,
        })
        .collect()
}

/// Lights on all six walls of a box, shining inward.
fn on_walls(count: usize, lo: [f32; 3], hi: [f32; 3], intensity: f32, s: &mut Stream) -> Vec<Vpl> {
    let (lo, hi) = (Vec3::from(lo), Vec3::from(hi));
    (0..count)
        .map(|_| {
            let (axis, up) = (s.below(3) as usize, s.below(2) == 0);
            let inward = Vec3::AXES[axis] * if up { -1.0 } else { 1.0 };
            let mut position = lo + Vec3::from(s.uniform_3()) * (hi - lo);
            position[axis] = if up { hi[axis] } else { lo[axis] };
            Vpl {
                position: position + inward * 1e-3,
                direction: inward,
                intensity: Rgb::gray(intensity),
                kind: VplKind::Oriented,
            }
        })
        .collect()
}

/// A room of 2 m whose ceiling has a hole of 12 cm. Through the hole, each point of the room sees
/// only a few of the sky's 3000 lights, and only a small patch sees the sun.
fn pinhole() -> World {
    let mut b = builder();
    slab(&mut b, [-0.1, -0.1, -0.1], [2.1, 0.0, 2.1]);
    slab(&mut b, [-0.1, 0.0, -0.1], [0.0, 2.0, 2.1]);
    slab(&mut b, [2.0, 0.0, -0.1], [2.1, 2.0, 2.1]);
    slab(&mut b, [0.0, 0.0, -0.1], [2.0, 2.0, 0.0]);
    slab(&mut b, [0.0, 0.0, 2.0], [2.0, 2.0, 2.1]);
    sheet(&mut b, [-0.1, 2.0, -0.1], [2.2, 0.0, 0.0], [0.0, 0.0, 1.0]);
    sheet(&mut b, [-0.1, 2.0, 1.02], [2.2, 0.0, 0.0], [0.0, 0.0, 1.08]);
    sheet(&mut b, [-0.1, 2.0, 0.9], [1.0, 0.0, 0.0], [0.0, 0.0, 0.12]);
    sheet(&mut b, [1.02, 2.0, 0.9], [1.08, 0.0, 0.0], [0.0, 0.0, 0.12]);
    let mut s = stream(1);
    let far = |direction: Vec3, irradiance: f32| Vpl {
        position: Vec3::ZERO,
        direction: direction.normalize(),
        intensity: Rgb::gray(irradiance),
        kind: VplKind::Directional,
    };
    let mut lights = on_walls(1000, [0.0; 3], [2.0; 3], 1e-4, &mut s);
    lights.extend((0..3000).map(|_| {
        let d = warp::sphere(s.uniform_2());
        far(Vec3::new(d.x, -d.y.abs().max(0.05), d.z), 0.1)
    }));
    lights.push(far(Vec3::new(0.3, -1.0, -0.3), 100.0));
    World::new(b, [0.2, 1.2, 1.8], [1.1, 0.2, 0.6], 1.0, lights)
}

/// Two rooms with an opening of 20 cm × 30 cm between them. The lights are in one room, the camera
/// in the other.
fn keyhole() -> World {
    let mut b = builder();
    put(&mut b, cuboid(Vec3::ZERO, Vec3::new(4.0, 2.0, 2.0), true));
    slab(&mut b, [1.95, 0.0, 0.0], [2.05, 2.0, 0.9]);
    slab(&mut b, [1.95, 0.0, 1.1], [2.05, 2.0, 2.0]);
    slab(&mut b, [1.95, 0.0, 0.9], [2.05, 0.8, 1.1]);
    slab(&mut b, [1.95, 1.1, 0.9], [2.05, 2.0, 1.1]);
    let mut s = stream(2);
    let mut lights = on_walls(4000, [2.05, 0.0, 0.0], [4.0, 2.0, 2.0], 1.0, &mut s);
    lights.extend(on_walls(100, [0.0; 3], [1.95, 2.0, 2.0], 1e-3, &mut s));
    World::new(b, [1.7, 1.2, 1.6], [0.2, 0.8, 0.7], 1.1, lights)
}

/// Many layers of slivers of 50 cm × 2 cm, along two axes, between lights and a floor. The
/// visibilities of neighbouring points are unrelated.
fn wires() -> World {
    let mut b = builder();
    slab(&mut b, [-2.0, -0.1, -2.0], [2.0, 0.0, 2.0]);
    let mut s = stream(3);
    let mut mesh = MeshData::default();
    for number in 0..12_000 {
        let at = (Vec3::from(s.uniform_3()) - Vec3::splat(0.5)) * Vec3::new(4.0, 0.4, 4.0) + Vec3::Y;
        let (along, across) = if number % 2 == 0 { (Vec3::X, Vec3::Z) } else { (Vec3::Z, Vec3::X) };
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([at, at + 0.5 * along, at + 0.25 * along + 0.02 * across]);
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    put(&mut b, mesh);
    let lights = omni(2000, [-2.0, 1.8, -2.0], [2.0, 2.2, 2.0], 1.0, &mut s);
    World { size: [12, 8], ..World::new(b, [0.0, 0.6, 1.8], [0.0, 0.0, 0.2], 1.0, lights) }
}

/// One of 20,000 lights, behind slats, gives half of the light.
fn one_of_many() -> World {
    let mut b = builder();
    put(&mut b, cuboid(Vec3::ZERO, Vec3::splat(2.0), true));
    for k in 0..10u8 {
        let x = 0.2 + 0.16 * f32::from(k);
        sheet(&mut b, [x, 1.3, 0.4], [0.11, 0.0, 0.0], [0.0, 0.0, 1.2]);
    }
    let mut s = stream(4);
    let mut lights = on_walls(20_000, [0.0; 3], [2.0; 3], 1e-4, &mut s);
    lights.extend(omni(1, [1.0, 1.5, 1.0], [1.0, 1.5, 1.0], 2.0, &mut s));
    World { size: [12, 8], ..World::new(b, [1.0, 1.0, 1.95], [1.0, 0.3, 0.5], 1.2, lights) }
}

/// A floor with a glossy lobe of 2π/20,000 sr, lit by 10,000 lights. The lobe contains the mirror
/// directions of only a few of them.
fn glossy_peak() -> World {
    let mut b = builder();
    let floor = parallelogram(Vec3::new(-2.0, 0.0, -2.0), Vec3::Z * 4.0, Vec3::X * 4.0);
    let glossy = Surface::Phong {
        diffuse: Rgb::gray(0.001).into(),
        specular: Rgb::gray(0.8).into(),
        exponent: 20_000.0,
    };
    place(&mut b, floor, Material::new("glossy", glossy));
    let mut s = stream(5);
    let lights = omni(10_000, [-2.0, 1.0, -4.0], [2.0, 3.0, -1.0], 1.0, &mut s);
    World::new(b, [0.0, 1.0, 2.0], [0.0, 0.0, 0.2], 0.7, lights)
}

/// A thin wall in view hides 5000 of 5020 lights. The hidden lights are close, so they have the
/// largest bounds, but all of them are in shadow.
fn hidden() -> World {
    let mut b = builder();
    put(&mut b, cuboid(Vec3::ZERO, Vec3::splat(2.0), true));
    slab(&mut b, [0.0, 0.0, 0.3], [2.0, 2.0, 0.32]);
    let mut s = stream(6);
    let mut lights = omni(5000, [0.05, 0.05, 0.1], [1.95, 1.95, 0.25], 1.0, &mut s);
    lights.extend(omni(20, [0.1, 0.1, 1.5], [1.9, 1.9, 1.9], 1.0, &mut s));
    World::new(b, [1.0, 1.0, 1.9], [1.0, 0.7, 0.3], 1.2, lights)
}

#[test]
fn light_through_a_pinhole_is_not_overlooked() {
    let scene = Judged::new(pinhole());
    scene.certificates_hold();
    scene.calibrated_intervals_hold();
    scene.published_intervals_do_not_hold();
}

/// All samples of hundreds of strata are in shadow, but each stratum might have some light. The
/// calibrated interval includes only a small part of that possible light: 87 % of the intervals
/// hold, although 98 % of the errors are as small as requested. The limit on the first share is
/// four standard errors of 160 trials below 87 %.
#[test]
fn behind_a_keyhole_errors_are_as_asked_for_but_calibrated_intervals_are_too_narrow() {
    let scene = Judged::new(keyhole());
    scene.certificates_hold();
    let kept = scene.calibrated();
    assert!(kept.holds >= 0.75 && kept.within >= LEAST, "{kept:?}");
    scene.published_intervals_do_not_hold();
}

#[test]
fn shadows_of_thousands_of_wires_are_no_surprise() {
    let scene = Judged::new(wires());
    scene.certificates_hold();
    scene.calibrated_intervals_hold();
    scene.published_intervals_do_not_hold();
}

/// The published rule also finds this light, since it first refines where bounds are large; 92 % of
/// its intervals hold.
#[test]
fn one_bright_light_of_very_many_is_found() {
    let scene = Judged::new(one_of_many());
    scene.certificates_hold();
    scene.calibrated_intervals_hold();
}

#[test]
fn a_glossy_peak_that_hardly_a_light_meets_is_found() {
    let scene = Judged::new(glossy_peak());
    scene.certificates_hold();
    scene.calibrated_intervals_hold();
    scene.published_intervals_do_not_hold();
}

/// About 80 % of the published rule's intervals of 95 % hold here: too near to the limit of the
/// other scenes to be asserted.
#[test]
fn lights_that_are_nearly_all_hidden_do_not_mislead() {
    let scene = Judged::new(hidden());
    scene.certificates_hold();
    scene.calibrated_intervals_hold();
}

fn floor(reflectance: f32) -> SceneBuilder {
    let mut b = builder();
    let floor = parallelogram(Vec3::new(-2.0, 0.0, -2.0), Vec3::Z * 4.0, Vec3::X * 4.0);
    place(&mut b, floor, Material::new("floor", lambert(reflectance)));
    b
}

/// A floor in the shade of some bars.
fn barred() -> SceneBuilder {
    let mut b = floor(0.6);
    for k in 0..12u8 {
        sheet(&mut b, [-1.5 + 0.25 * f32::from(k), 0.7, -1.5], [0.13, 0.0, 0.0], [0.0, 0.0, 3.0]);
    }
    b
}

/// Eye and target of a view of the floor.
const ABOVE: [[f32; 3]; 2] = [[0.0, 0.6, 1.8], [0.0, 0.0, 0.2]];

#[test]
fn pixels_that_see_the_sky_alone_are_exact_and_cost_nothing() {
    let mut b = floor(0.6);
    b.set_environment(Environment::constant(Rgb::gray(0.5))).unwrap();
    let lights = omni(500, [-1.0, 1.0, -1.0], [1.0, 2.0, 1.0], 1.0, &mut stream(7));
    // The camera looks straight ahead, so the upper half of the image is sky. This half consists of
    // whole cells of the pilot.
    let world = World { size: [16, 64], ..World::new(b, [0.0, 0.6, 1.8], [0.0, 0.6, 0.2], 1.0, lights) };
    let options = ControlOptions { error: 0.2, ..ControlOptions::default() };
    for method in [CALIBRATED, CERTIFIED] {
        let mut sky = 0;
        for (number, e) in world.estimate(method, &options).iter().enumerate() {
            if e.coverage == 0.0 {
                sky += 1;
                assert_eq!((e.radiance, e.pairs, e.standard_error), (Rgb::gray(0.5), 0, 0.0), "{method}");
                assert_eq!((e.claim, e.stop), (Claim::Exact, Stop::Complete), "{method}");
                // The rays of a cell's pilot are shared by all pixels of the cell, including pixels
                // of sky. A cell of sky alone has no pilot.
                assert!(e.rays == 0 || (method == CALIBRATED && number >= 16 * 32), "{method}: {e:?}");
            }
        }
        assert!((16 * 32..16 * 64).contains(&sky), "{method}: {sky}");
    }
}

#[test]
fn black_surfaces_are_exact_and_cost_nothing() {
    let lights = omni(500, [-1.0, 1.0, -1.0], [1.0, 2.0, 1.0], 1.0, &mut stream(8));
    let world = World::new(floor(0.0), ABOVE[0], ABOVE[1], 1.0, lights);
    for method in [CALIBRATED, CERTIFIED] {
        for e in world.estimate(method, &ControlOptions::default()) {
            assert_eq!((e.radiance, e.rays, e.claim), (Rgb::BLACK, 0, Claim::Exact), "{method}");
        }
    }
}

/// A green floor is seen in a red mirror, so every term is zero. Bounds ignore colours and use the
/// largest channel, so they are positive. Both methods must still find that each pixel is exactly
/// black.
#[test]
fn a_green_floor_in_a_red_mirror_is_found_to_be_black() {
    let mut b = builder();
    let quad = |y: f32| parallelogram(Vec3::new(-2.0, y, -2.0), Vec3::Z * 4.0, Vec3::X * 4.0);
    let green = Surface::Lambert { reflectance: Rgb::new(0.0, 0.8, 0.0).into() };
    let red = Surface::Mirror { reflectance: Rgb::new(0.9, 0.0, 0.0).into() };
    place(&mut b, quad(0.0), Material::new("green", green));
    place(&mut b, quad(3.0), Material::new("red", red));
    let lights = omni(2000, [-1.0, 1.0, -1.0], [1.0, 2.0, 1.0], 1.0, &mut stream(9));
    // The field of view is so narrow that the mirror shows only the floor.
    let world = World::new(b, [0.0, 1.0, 0.0], [0.0, 3.0, 0.1], 0.4, lights);
    for method in [CALIBRATED, CERTIFIED] {
        for e in world.estimate(method, &ControlOptions::default()) {
            assert!(e.coverage == 1.0 && e.pairs > 1, "{e:?}");
            assert_eq!((e.radiance, e.claim), (Rgb::BLACK, Claim::Exact), "{method}: {e:?}");
        }
    }
}

#[test]
fn lights_all_at_one_place_are_no_trouble() {
    let one = omni(1, [0.1, 1.4, 0.2], [0.1, 1.4, 0.2], 1.0, &mut stream(10));
    let all_directions = on_walls(3000, [0.1, 1.4, 0.2], [0.1, 1.4, 0.2], 1.0, &mut stream(11));
    let at_one_place = all_directions.into_iter().map(|light| Vpl { position: one[0].position, ..light });
    for lights in [one.clone(), vec![one[0]; 3000], at_one_place.collect()] {
        let world = Judged::new(World::new(barred(), ABOVE[0], ABOVE[1], 1.0, lights));
        world.certificates_hold();
        world.calibrated_intervals_hold();
    }
}

/// Some lights are at the positions of gather points, as happens if a light path ends at a visible
/// point. Without a clamp, their contribution has no bound.
#[test]
fn lights_where_light_is_gathered_are_no_trouble() {
    let scene = World::new(barred(), ABOVE[0], ABOVE[1], 1.0, Vec::new());
    let mut s = stream(12);
    let mut lights = omni(1000, [-1.0, 1.0, -1.0], [1.0, 2.0, 1.0], 1.0, &mut s);
    let [width, height] = scene.size;
    scene.see(|view| {
        for pixel in (0..height).flat_map(|y| (0..width).map(move |x| [x, y])) {
            for point in view.pixel(&scene.tracer, pixel).points {
                let kind = if s.below(2) == 0 { VplKind::Omni } else { VplKind::Oriented };
                let direction = if kind == VplKind::Omni { Vec3::ZERO } else { point.geometric_normal };
                lights.push(Vpl { position: point.position, direction, intensity: Rgb::gray(0.01), kind });
            }
        }
    });
    for clamp in [0.0, CLAMP] {
        let world = Judged::new(World::lit(Arc::clone(&scene.tracer), lights.clone(), clamp));
        world.certificates_hold();
        world.calibrated_intervals_hold();
    }
}
