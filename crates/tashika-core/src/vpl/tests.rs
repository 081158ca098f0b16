//! Tests of the emitter sampler against closed forms, and of VPL sets for various options.

use std::sync::Arc;

use glam::{Affine3A, Mat3, Vec3};

use super::{EmitterClusters, EmitterSampler, LightGuide, LightTracer, Vpl, VplKind, VplOptions, VplSet};
use crate::accel::Tracer;
use crate::color::Rgb;
use crate::error::Location;
use crate::rng::{Purpose, Stream};
use crate::scene::{
    Alpha, AlphaMode, Emission, Emitter, Environment, Falloff, FalloffShape, Image, Material, MeshData,
    MeshShape, Pixels, SceneBuilder, Surface, builtin,
};
use crate::stats::Moments;

const RADIANCE: f32 = 3.0;

/// A lamp of two triangles, 2 m × 3 m and 2 m × 1 m, and the objects that `more` adds.
fn scene(two_sided: bool, opacity: f32, more: impl FnOnce(&mut SceneBuilder)) -> Tracer {
    let mut b = SceneBuilder::new("lamp", Location::default());
    let mut material = Material::new("lamp", Surface::Lambert { reflectance: Rgb::gray(0.5).into() });
    material.emission = Some(Emission { radiance: Rgb::gray(RADIANCE).into(), two_sided });
    if opacity < 1.0 {
        material.alpha = Some(Alpha { value: opacity.into(), mode: AlphaMode::Blend });
    }
    let material = b.add_material(material).unwrap();
    let positions =
        [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 3.0], [2.0, 0.0, -1.0]].map(Vec3::from).to_vec();
    let triangles = vec![[0, 1, 2], [0, 3, 1]];
    let mesh = b.add_mesh(MeshData { positions, triangles, ..MeshData::default() }, material).unwrap();
    b.add_instance(mesh, Affine3A::IDENTITY).unwrap();
    more(&mut b);
    Tracer::new(Arc::new(b.build().unwrap()))
}

/// Returns the mean luminance of the sampled intensities of one kind, with its standard error.
fn mean_intensity(scene: &Tracer, kind: VplKind) -> Moments {
    let emitters = EmitterSampler::new(scene);
    let mut s = Stream::new(3, Purpose::Test, 0);
    let mut m = Moments::default();
    for _ in 0..40_000 {
        let light = emitters.sample(s.uniform_f64(), s.uniform_2()).unwrap().light;
        m.push(if light.kind == kind { f64::from(light.intensity.luminance()) } else { 0.0 });
    }
    m
}

fn assert_mean(m: &Moments, expected: f64) {
    let error = 5.0 * m.standard_error() + 1e-5 * expected;
    assert!((m.mean() - expected).abs() < error, "{} ± {} for {expected}", m.mean(), m.standard_error());
    assert!(error < 0.1 * expected, "sharp: {error} of {expected}");
}

/// A lamp is turned inside out while the shutter is open. It has no area in the middle of the
/// interval, shines before and after, and is drawn.
#[test]
fn lamps_without_area_in_the_middle_are_drawn() {
    let mut b = SceneBuilder::new("lamp", Location::default());
    let mut material = Material::new("lamp", Surface::Lambert { reflectance: Rgb::BLACK.into() });
    material.emission = Some(Emission { radiance: Rgb::gray(RADIANCE).into(), two_sided: false });
    let material = b.add_material(material).unwrap();
    let open = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let closing = MeshShape { positions: vec![Vec3::ZERO, Vec3::X, Vec3::NEG_Y], ..MeshShape::default() };
    let data = MeshData { positions: open.to_vec(), triangles: vec![[0, 1, 2]], ..MeshData::default() };
    let mesh = b.add_deforming_mesh(data, closing, [0.0, 1.0], material).unwrap();
    b.add_instance(mesh, Affine3A::IDENTITY).unwrap();
    let tracer = Tracer::new(Arc::new(b.build().unwrap()));
    let emitters = EmitterSampler::new(&tracer);
    for (share, area) in [(0.0, 0.5), (0.25, 0.25), (1.0, 0.5_f32)] {
        let (_, sample) = emitters.sample_at(share, 0.3, [0.2, 0.6]).expect("it is drawn");
        let found = sample.light.intensity.r;
        assert!((found - RADIANCE * area).abs() < 1e-5, "{share}: {found}");
    }
}

/// Lights with invalid numbers, directions or cones are reported as not sound.
#[test]
fn lights_that_cannot_be_are_told_apart() {
    let sound =
        Vpl { position: Vec3::ONE, direction: Vec3::Y, intensity: Rgb::gray(1.0), kind: VplKind::Oriented };
    let omni = Vpl { direction: Vec3::ZERO, kind: VplKind::Omni, ..sound };
    assert!(sound.is_sound() && omni.is_sound() && !Vpl { direction: Vec3::Y, ..omni }.is_sound());
    for wrong in [
        Vpl { position: Vec3::NAN, ..sound },
        Vpl { direction: Vec3::Y * 2.0, ..sound },
        Vpl { direction: Vec3::ZERO, ..sound },
        Vpl { intensity: Rgb::new(1.0, -1.0, 1.0), ..sound },
        Vpl { intensity: Rgb::gray(f32::INFINITY), ..sound },
    ] {
        assert!(!wrong.is_sound(), "{wrong:?}");
    }
    let cone = |cos_inner, cos_outer| {
        let falloff = Falloff { cos_inner, cos_outer, shape: FalloffShape::Squared };
        Vpl { kind: VplKind::Spot(falloff), ..sound }
    };
    assert!(cone(0.9, 0.5).is_sound() && !cone(0.5, 0.9).is_sound() && !cone(1.5, 0.5).is_sound());
}

/// One sample represents all emitters. Its mean intensity is `L A` per side for surfaces, `∫ L dω`
/// for the sky, and `I` for points.
#[test]
fn sampled_intensities_add_up_to_the_emitters() {
    let area = 4.0 * f64::from(RADIANCE);
    for (two_sided, opacity, expected) in
        [(false, 1.0, area), (true, 1.0, 2.0 * area), (false, 0.25, 0.25 * area)]
    {
        let lamp = scene(two_sided, opacity, |b| {
            b.add_emitter(Emitter::Point { position: Vec3::Y, intensity: Rgb::gray(2.0) }).unwrap();
        });
        assert_mean(&mean_intensity(&lamp, VplKind::Oriented), expected);
        assert_mean(&mean_intensity(&lamp, VplKind::Omni), 2.0);
    }
    let mut pixels = vec![[0.1, 0.2, 0.1]; 64 * 32];
    pixels[700] = [900.0, 800.0, 500.0];
    let image = Image { name: "sky".into(), width: 64, height: 32, pixels: Pixels::Float(pixels) };
    let sky = Environment::lat_long(image, Rgb::gray(1.5), Mat3::IDENTITY);
    let whole = 4.0 * std::f64::consts::PI * f64::from(sky.mean().luminance());
    let lit = scene(false, 1.0, |b| b.set_environment(sky).unwrap());
    assert_mean(&mean_intensity(&lit, VplKind::Directional), whole);
}

/// One of three emitters has nearly all power. With a share of 0.3 for weak emitters, they are
/// drawn with probabilities 0.1, 0.8 and 0.1, and draws remain unbiased.
#[test]
fn a_weak_emitter_is_drawn_as_often_as_its_share_says() {
    let scene = scene(false, 1.0, |b| {
        b.add_emitter(Emitter::Point { position: Vec3::Y, intensity: Rgb::gray(1e6) }).unwrap();
        b.add_emitter(Emitter::Directional { direction: Vec3::X, irradiance: Rgb::gray(1e-6) }).unwrap();
    });
    let emitters = EmitterSampler::new(&scene).with_share_for_each(0.3);
    let mut s = Stream::new(6, Purpose::Test, 0);
    let mut of_kind = [Moments::default(); 3];
    let n = 40_000;
    for _ in 0..n {
        let light = emitters.sample(s.uniform_f64(), s.uniform_2()).unwrap().light;
        for (kind, m) in
            [VplKind::Oriented, VplKind::Omni, VplKind::Directional].into_iter().zip(&mut of_kind)
        {
            m.push(if light.kind == kind { f64::from(light.intensity.luminance()) } else { 0.0 });
        }
    }
    // The triangles of an emitter divide its share by power.
    let drawn = [4.0 * f64::from(RADIANCE), 1e6, 1e-6].into_iter().zip([0.1, 0.8, 0.1]);
    for (m, (intensity, share)) in of_kind.iter().zip(drawn) {
        assert_mean(m, intensity);
        // A draw that is `i/p` with probability `p` and otherwise zero has the variance
        // `i² (1/p − 1)`.
        let found = 1.0 / (1.0 + m.variance() / (intensity * intensity));
        assert!((found / share - 1.0).abs() < 0.1, "drawn with {found} for {share}");
    }
}

#[test]
fn densities_are_those_of_the_samples() {
    let lamp = scene(true, 1.0, |b| b.set_environment(Environment::constant(Rgb::gray(0.7))).unwrap());
    let emitters = EmitterSampler::new(&lamp).with_share_for_each(0.4);
    let (instance, _) = lamp.scene().area_emitters().next().unwrap();
    let mut s = Stream::new(4, Purpose::Test, 0);
    let mut kinds = [0; 2];
    for _ in 0..1000 {
        let sample = emitters.sample(s.uniform_f64(), s.uniform_2()).unwrap();
        let pdf = sample.pdf.unwrap();
        let expected = match sample.light.kind {
            VplKind::Directional => emitters.pdf_of_environment(-sample.light.direction),
            _ => emitters.pdf_on_triangle(instance, u32::from(sample.light.position.z < 0.0)),
        };
        kinds[usize::from(sample.light.kind == VplKind::Directional)] += 1;
        assert!((pdf / expected - 1.0).abs() < 1e-5, "{pdf} {expected}");
    }
    assert!(kinds[0] > 20 && kinds[1] > 20, "{kinds:?}");
}

#[test]
fn sets_have_about_the_number_that_was_asked_for() {
    let tracer = Tracer::new(Arc::new(builtin::tiny()));
    for count in [1000, 10_000, 100_000] {
        let set = VplSet::trace(&tracer, &VplOptions { count, ..VplOptions::default() }).unwrap();
        let ratio = set.len() as f64 / count as f64;
        // The pilot of 4096 paths estimates the mean to 2 %; the set has an additional spread.
        assert!((ratio - 1.0).abs() < 0.12, "{} for {count}", set.len());
        assert_eq!(set.len() as u64, set.provenance().direct + set.provenance().indirect);
        assert!((set.provenance().direct as f64 / count as f64 - 0.25).abs() < 0.01);
    }
}

/// As many point lights as requested VPLs. They do not displace indirect light.
#[test]
fn many_point_lights_leave_room_for_indirect_light() {
    let tracer = scene(false, 1.0, |b| {
        for i in 0..50 {
            let position = Vec3::new(0.02 * i as f32, 1.0, 0.0);
            b.add_emitter(Emitter::Point { position, intensity: Rgb::gray(1.0) }).unwrap();
        }
    });
    let set = VplSet::trace(&tracer, &VplOptions { count: 50, ..VplOptions::default() }).unwrap();
    assert_eq!(
        set.lights().iter().filter(|l| l.kind == VplKind::Omni).count(),
        50,
        "each point is one VPL, exactly"
    );
    assert!(set.provenance().indirect > 5, "{:?}", set.provenance());
}

#[test]
fn options_out_of_range_are_named() {
    let tracer = Tracer::new(Arc::new(builtin::tiny()));
    let said = |o: VplOptions| VplSet::trace(&tracer, &o).unwrap_err().to_string();
    assert!(said(VplOptions { count: 0, ..VplOptions::default() }).contains("vpls = 0; expected 1 to"));
    assert!(said(VplOptions { direct_share: 1.5, ..VplOptions::default() }).contains("direct_share = 1.5"));
    assert!(said(VplOptions { max_depth: 5000, ..VplOptions::default() }).contains("max_depth = 5000"));
}

/// Returns the unoccluded light that a point above the lamp receives from direct and from indirect
/// VPLs.
fn received(set: &VplSet) -> [f64; 2] {
    let at = Vec3::new(0.3, 4.0, 0.4);
    let mut sums = [0.0; 2];
    for light in set.lights() {
        let d = light.position - at;
        let given = -light.direction.dot(d.normalize()).min(0.0) / d.length_squared();
        let is_direct = light.position.y.abs() < 0.1;
        sums[usize::from(!is_direct)] += f64::from(light.intensity.luminance() * given);
    }
    sums
}

/// Sets with different guides have the same light on average.
#[test]
fn guides_change_where_vpls_are_and_not_what_they_give() {
    let tracer = scene(true, 1.0, |b| {
        let white =
            b.add_material(Material::new("floor", Surface::Lambert { reflectance: Rgb::gray(0.8).into() }));
        let positions = [[-9.0, -2.0, -9.0], [-9.0, -2.0, 9.0], [9.0, -2.0, 9.0], [9.0, -2.0, -9.0]];
        let mesh = MeshData {
            positions: positions.map(Vec3::from).to_vec(),
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..MeshData::default()
        };
        let mesh = b.add_mesh(mesh, white.unwrap()).unwrap();
        b.add_instance(mesh, Affine3A::IDENTITY).unwrap();
    });
    // The guide learns half of the lamp, and rays in a twentieth of all directions.
    let mut s = Stream::new(6, Purpose::Test, 0);
    let direct = (0..2000).map(|_| ([0.5 * s.uniform(), s.uniform(), s.uniform()], 1.0)).collect();
    let mut s = Stream::new(7, Purpose::Test, 0);
    let mut ray = |_| ([s.uniform(), s.uniform(), s.uniform(), 0.2 * s.uniform(), 0.25 * s.uniform()], 1.0);
    let guide = LightGuide::learn(direct, (0..2000).map(&mut ray).collect());
    assert!(guide.cells().iter().all(|cells| *cells > 1), "{:?}", guide.cells());
    let options = VplOptions { count: 400, ..VplOptions::default() };
    let plain = LightTracer::new(&tracer, &options).unwrap();
    let guided = LightTracer::new(&tracer, &options).unwrap().guided(guide);
    let mut moments = [[Moments::default(); 2]; 2];
    for seed in 0..300 {
        for (way, of_way) in [&plain, &guided].into_iter().zip(&mut moments) {
            let found = received(&way.trace(seed));
            of_way.iter_mut().zip(found).for_each(|(m, x)| m.push(x));
        }
    }
    let [plain, guided] = moments;
    for (a, b) in plain.iter().zip(&guided) {
        let error = a.standard_error().hypot(b.standard_error());
        assert!(error < 0.03 * a.mean(), "sharp: {error} of {}", a.mean());
        assert!((a.mean() - b.mean()).abs() < 4.5 * error, "{} {} ± {error}", a.mean(), b.mean());
    }
}

/// The pilot meets no surface. Light paths are traced nevertheless, since there may be indirect
/// light.
#[test]
fn light_that_no_pilot_meets_is_not_dropped() {
    // A plate as wide as a hand, a thousand kilometres from the lamp.
    let tracer = scene(false, 1.0, |b| {
        let white =
            b.add_material(Material::new("plate", Surface::Lambert { reflectance: Rgb::gray(0.8).into() }));
        let at = |x: f32, z: f32| Vec3::new(x, -1e6, z);
        let positions = vec![at(0.0, 0.0), at(0.1, 0.0), at(0.0, 0.1)];
        let mesh = MeshData { positions, triangles: vec![[0, 1, 2]], ..MeshData::default() };
        let mesh = b.add_mesh(mesh, white.unwrap()).unwrap();
        b.add_instance(mesh, Affine3A::IDENTITY).unwrap();
    });
    let set = VplSet::trace(&tracer, &VplOptions { count: 1000, ..VplOptions::default() }).unwrap();
    assert_eq!((set.provenance().indirect, set.provenance().paths), (0, 750));
}

/// Each cluster is drawn with its stated probability and with the densities of the sampler. Draws
/// from all clusters, weighted by these probabilities, estimate all emitters.
#[test]
fn clusters_of_emitters_are_what_the_sampler_draws_from() {
    let mut pixels = vec![[0.1, 0.2, 0.1]; 64 * 32];
    pixels[700] = [90.0, 80.0, 50.0];
    let image = Image { name: "sky".into(), width: 64, height: 32, pixels: Pixels::Float(pixels) };
    let scene = scene(true, 1.0, |b| {
        for x in 0..300 {
            let position = Vec3::new(x as f32, 1.0, (x % 7) as f32);
            b.add_emitter(Emitter::Point { position, intensity: Rgb::gray(0.1) }).unwrap();
        }
        b.add_emitter(Emitter::Directional { direction: Vec3::X, irradiance: Rgb::gray(0.01) }).unwrap();
        b.set_environment(Environment::lat_long(image, Rgb::WHITE, Mat3::IDENTITY)).unwrap();
    });
    let emitters = EmitterSampler::new(&scene).with_share_for_each(0.5);
    let clusters = EmitterClusters::new(&emitters);
    assert!((200..=640).contains(&clusters.count()), "{} clusters", clusters.count());
    let (instance, _) = scene.scene().area_emitters().next().unwrap();
    let mut s = Stream::new(8, Purpose::Test, 0);
    let mut found = vec![0; clusters.count()];
    let n = 40_000;
    let mut whole = Moments::default();
    for _ in 0..n {
        let (cluster, sample) = clusters.sample(&emitters, s.uniform_f64(), s.uniform_2()).unwrap();
        found[cluster] += 1;
        whole.push(sample.light.intensity.luminance().into());
    }
    let mut by_clusters = 0.0;
    let mut all = 0.0;
    for (cluster, found) in found.into_iter().enumerate() {
        let said = clusters.probability(cluster);
        all += said;
        let error = (said * (1.0 - said) / f64::from(n)).sqrt() + 1.0 / f64::from(n);
        assert!((f64::from(found) / f64::from(n) - said).abs() < 5.0 * error, "{found} of {n} for {said}");
        if said == 0.0 {
            continue;
        }
        for _ in 0..100 {
            let sample = clusters.sample_from(&emitters, cluster, s.uniform_f64(), s.uniform_2()).unwrap();
            by_clusters += said * f64::from(sample.light.intensity.luminance()) / 100.0;
            if let (VplKind::Directional, Some(pdf)) = (sample.light.kind, sample.pdf) {
                let density = emitters.pdf_of_environment(-sample.light.direction);
                assert!((pdf / density - 1.0).abs() < 1e-3);
            }
        }
    }
    assert!((all - 1.0).abs() < 1e-9, "{all}");
    assert_mean(&whole, by_clusters);
    let of_lamp = [0, 1].map(|triangle| clusters.of_triangle(&emitters, instance, triangle).unwrap());
    assert!(of_lamp.iter().all(|cluster| clusters.probability(*cluster) > 0.0));
}
