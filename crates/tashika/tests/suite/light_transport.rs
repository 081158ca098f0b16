//! Many-light rendering against an independent path tracer, pixel by pixel. On diffuse scenes with
//! every kind of emitter, the mean over unclamped VPL sets is compared. On scenes with gloss,
//! mirrors and glass, VPLs are clamped, and compensation adds the light that they do not carry.

use tashika::accel::{Glass, Tracer};
use tashika::bsdf::{Bsdf, CoatModel, ConductorFresnel, Lambert};
use tashika::color::Rgb;
use tashika::compensation::{Compensation, LightingContext, VplSource};
use tashika::contribution::ContributionKernel;
use tashika::film::{Film, Window};
use tashika::gather::GatherPoint;
use tashika::guidance::learn_light_guide;
use tashika::integrator::{
    ControlOptions, Estimator, FullSum, GuidedLights, LightTransport, PathSampler, PathStop, PathTracer,
    Setting, Truth,
};
use tashika::math::{Mat3, Vec2, Vec3};
use tashika::rng::{Purpose, Stream};
use tashika::scene::{
    Alpha, AlphaMode, Back, CoatBase, Emitter, Environment, FacetInput, Falloff, FalloffShape, Image,
    Material, MeshData, Pixels, SceneBuilder, Surface, TurnedAway,
};
use tashika::stats::Moments;
use tashika::tree::LightTree;
use tashika::vpl::{Clamp, EmitterSampler, LightTracer, VplOptions, VplSet};

use crate::cases::{
    add_ceiling_lamp, cuboid, diffuse_room, film, glowing, lambert, luminances, parallelogram, place, tracer,
    view,
};

const SIZE: [u32; 2] = [6, 6];

fn sky() -> Environment {
    let (w, h) = (32, 16);
    let mut pixels = vec![[0.3, 0.5, 0.9]; w * h];
    pixels[5 * w + 17] = [90.0, 80.0, 60.0];
    let image =
        Image { name: "sky".into(), width: w as u32, height: h as u32, pixels: Pixels::Float(pixels) };
    Environment::lat_long(image, Rgb::WHITE, Mat3::from_rotation_y(1.4))
}

/// Asserts that each pixel of both estimates agrees within the common error, and the whole image
/// more sharply.
pub fn agree(b: SceneBuilder, what: &str) {
    let tracer = tracer(b);
    let sets = 80;
    let mut many = vec![Moments::default(); 36];
    let mut image = Moments::default();
    for seed in 0..sets {
        let options = VplOptions { count: 600, seed, clamp: Clamp::Off, ..VplOptions::default() };
        let set = VplSet::trace(&tracer, &options).unwrap();
        let l = luminances(&film(&tracer, &FullSum::new(&set), SIZE, 4, seed));
        image.push(l.iter().sum::<f64>() / 36.0);
        many.iter_mut().zip(l).for_each(|(m, l)| m.push(l));
    }
    let reference =
        film(&tracer, &PathTracer::new(&tracer, PathStop::Count(4000), 65).unwrap(), SIZE, 1, 1000);
    let errors = reference.plane("standard_error").unwrap().f32_samples().unwrap();
    let expected = luminances(&reference);
    // Two-sided level 10⁻⁵ for each of 36 pixels and for the image. Each VPL set has separate
    // gather points.
    for (i, (m, (l, e))) in many.iter().zip(expected.iter().zip(errors)).enumerate() {
        let error = m.standard_error().hypot(f64::from(*e));
        let found = (m.mean(), m.standard_error());
        assert!((m.mean() - l).abs() < 4.42 * error, "{what}, pixel {i}: {found:?} for {l} ± {e}");
    }
    let mean = expected.iter().sum::<f64>() / 36.0;
    let error =
        image.standard_error().hypot(errors.iter().map(|e| f64::from(*e).powi(2)).sum::<f64>().sqrt() / 36.0);
    assert!(error < 0.03 * mean, "{what}: the comparison is sharp: {error} of {mean}");
    assert!((image.mean() - mean).abs() < 4.42 * error, "{what}: {} ± {error} for {mean}", image.mean());
}

#[test]
fn an_area_light_in_a_diffuse_room() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    agree(b, "area light");
}

#[test]
fn point_spot_and_directional_lights() {
    let mut b = diffuse_room();
    b.add_emitter(Emitter::Point { position: Vec3::new(-0.5, 1.6, 0.5), intensity: Rgb::new(0.5, 0.4, 0.3) })
        .unwrap();
    b.add_emitter(Emitter::Spot {
        position: Vec3::new(0.5, 1.8, 0.6),
        axis: Vec3::new(-0.3, -1.0, -0.4).normalize(),
        intensity: Rgb::new(1.0, 2.0, 1.0),
        falloff: Falloff { cos_inner: 0.9, cos_outer: 0.6, shape: FalloffShape::Squared },
    })
    .unwrap();
    b.add_emitter(Emitter::Directional {
        direction: Vec3::new(0.2, -0.4, -1.0).normalize(),
        irradiance: Rgb::new(1.0, 0.9, 0.7),
    })
    .unwrap();
    agree(b, "punctual lights");
}

#[test]
fn an_environment_with_a_sun_through_the_open_side() {
    let mut b = diffuse_room();
    b.set_environment(sky()).unwrap();
    agree(b, "environment");
}

/// Adds a leaf under the lamp, and beside it a sheet of the surface `gauze`. The leaf transmits
/// more than half of the light.
fn add_leaf_and_gauze(b: &mut SceneBuilder, gauze: Surface) {
    let leaf = Surface::Translucent {
        reflectance: Rgb::new(0.2, 0.5, 0.1).into(),
        transmittance: Rgb::new(0.5, 0.4, 0.1).into(),
    };
    let sheet = |y: f32, x: f32| parallelogram(Vec3::new(x, y, -0.6), Vec3::X * 0.8, Vec3::Z * 1.2);
    place(b, sheet(1.5, -0.9), Material::new("leaf", leaf));
    let alpha = Some(Alpha { value: 0.4.into(), mode: AlphaMode::Blend });
    place(b, sheet(1.4, 0.1), Material { alpha, ..Material::new("gauze", gauze) });
}

/// Surfaces of several parts: a leaf under the lamp, a pane with a grey tint in the open side, a
/// half-transparent sheet, and a block of two materials. The pane has no reflection, because the
/// sum over VPLs omits light that a mirror reflects onto a surface.
#[test]
fn light_through_leaves_panes_and_holes() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    b.set_environment(sky()).unwrap();
    add_leaf_and_gauze(&mut b, lambert(0.8));
    let pane = pane(Rgb::BLACK, 0.0);
    let front = parallelogram(Vec3::new(-1.0, 0.0, 1.0), Vec3::X * 2.0, Vec3::Y * 2.0);
    place(&mut b, front, Material::new("pane", pane));
    let first = b.add_material(Material::new("a", lambert(0.9))).unwrap();
    let second = b.add_material(Material::new("b", lambert(0.1))).unwrap();
    let mix = Surface::Mix { first, second, amount: 0.3.into() };
    let block = cuboid(Vec3::new(-0.8, 0.0, -0.2), Vec3::new(-0.4, 0.4, 0.3), false);
    place(&mut b, block, Material::new("mixed", mix));
    agree(b, "several parts");
}

/// Asserts that the default method agrees with the path tracer: each pixel within the common error,
/// and the whole image more sharply. Also asserts that the light that VPLs do not carry is at least
/// the share `left_out` of the image.
pub fn transport_agrees(b: SceneBuilder, left_out: f64, what: &str) {
    let tracer = tracer(b);
    // A clamp distance large enough to matter.
    let lights = VplOptions { count: 300_000, clamp: Clamp::Distance(0.8), ..VplOptions::default() };
    let options = ControlOptions { error: 0.04, ..ControlOptions::default() };
    let estimate = |lights: &GuidedLights, estimator: Estimator| {
        let ours = LightTransport::new(&tracer, lights, &options).only_by(estimator);
        let film = film(&tracer, &ours, SIZE, 64, 3);
        let errors = film.plane("standard_error").unwrap().f32_samples().unwrap().to_vec();
        (luminances(&film), errors)
    };
    let reference =
        film(&tracer, &PathTracer::new(&tracer, PathStop::Count(14_000), 65).unwrap(), SIZE, 1, 1000);
    let errors = reference.plane("standard_error").unwrap().f32_samples().unwrap();
    let expected = luminances(&reference);
    let traced = |truth: Truth| {
        GuidedLights::trace(&tracer, &lights, truth, &view(tracer.scene(), SIZE, 64, 3)).unwrap()
    };
    let guided = traced(Truth::Transport);
    let of = expected.iter().sum::<f64>();
    for estimator in [Estimator::Vpls, Estimator::Paths] {
        let (ours, our_errors) = estimate(&guided, estimator);
        let mut variance = 0.0;
        for (i, (l, e)) in expected.iter().zip(errors).enumerate() {
            let (found, own) = (ours[i], our_errors[i]);
            let error = f64::from(*e).hypot(own.into());
            variance += error * error;
            let pixel = (what, estimator, i);
            assert!((found - l).abs() < 4.42 * error, "{pixel:?}: {found} ± {own} for {l} ± {e}");
        }
        let (sum, error) = (ours.iter().sum::<f64>(), variance.sqrt());
        assert!(error < 0.01 * of, "{what}: the comparison is sharp: {error} of {of}");
        assert!((sum - of).abs() < 4.42 * error, "{what}, {estimator:?}: {sum} ± {error} for {of}");
    }
    // This part takes most of the time of a test. With `TASHIKA_SLOW_TESTS=1` it runs for all
    // scenes.
    let is_slow = std::env::var("TASHIKA_SLOW_TESTS").is_ok_and(|value| value == "1");
    if is_slow || ["diffuse room", "several parts", "milk and smoke"].contains(&what) {
        drawn_lights_agree(&tracer, &expected, errors, what);
    }
    // Otherwise the agreement would not test the paths that complete the sums.
    let clamped = estimate(&traced(Truth::Clamped), Estimator::Vpls).0.iter().sum::<f64>();
    assert!(clamped < (1.0 - left_out) * of, "{what}: VPLs alone give {clamped} of {of}");
}

/// Asserts that the paths of pictures, which draw lights instead of summing over them, agree with
/// the given means: each pixel within the error between VPL sets, and the whole image more sharply.
fn drawn_lights_agree(tracer: &Tracer, expected: &[f64], errors: &[f32], what: &str) {
    // Quantiles of Student's t with 15 degrees of freedom for two-sided levels 10⁻⁵ and 10⁻⁴.
    const SETS: u64 = 16;
    const OF_PIXEL: f64 = 6.50;
    const OF_IMAGE: f64 = 5.24;
    let mut pixels = vec![Moments::default(); expected.len()];
    let mut image = Moments::default();
    for seed in 0..SETS {
        let view = view(tracer.scene(), SIZE, 1, seed);
        let options =
            VplOptions { count: 20_000, seed, clamp: Clamp::Distance(0.2), ..VplOptions::default() };
        let lights = GuidedLights::to_draw(tracer, &options, &view).unwrap();
        let method = LightTransport::new(tracer, &lights, &ControlOptions::default());
        let found = method.path_sampler(Setting { tracer, view }).tile(&Window::full(SIZE), seed, &|_| 400);
        image.push(found.iter().map(|pixel| pixel.luminance.mean()).sum());
        pixels.iter_mut().zip(&found).for_each(|(of_sets, pixel)| of_sets.push(pixel.luminance.mean()));
    }
    for (i, (found, (l, e))) in pixels.iter().zip(expected.iter().zip(errors)).enumerate() {
        let error = found.standard_error().hypot(f64::from(*e));
        let own = (found.mean(), found.standard_error());
        assert!((found.mean() - l).abs() <= OF_PIXEL * error, "{what}, pixel {i}: {own:?} for {l} ± {e}");
    }
    let (sum, of) = (image.mean(), expected.iter().sum::<f64>());
    let error =
        image.standard_error().hypot(errors.iter().map(|e| f64::from(*e).powi(2)).sum::<f64>().sqrt());
    assert!(error < 0.01 * of, "{what}, drawn: the comparison is sharp: {error} of {of}");
    assert!((sum - of).abs() < OF_IMAGE * error, "{what}, drawn: {sum} ± {error} for {of}");
}

fn plastic(alpha: f32) -> Surface {
    Surface::Plastic {
        diffuse: Rgb::new(0.5, 0.4, 0.3).into(),
        specular: Rgb::WHITE.into(),
        ior: 1.5,
        facets: alpha.into(),
    }
}

fn pane(reflectance: Rgb, alpha: f32) -> Surface {
    let (reflectance, transmittance) = (reflectance.into(), Rgb::gray(0.8).into());
    Surface::ThinGlass { ior: 1.5, reflectance, transmittance, facets: alpha.into() }
}

#[test]
fn the_clamp_is_made_good() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    transport_agrees(b, 0.02, "diffuse room");
}

/// Walls whose shading normals lean by up to 65 degrees. Light that is scattered below such a
/// surface is treated alike on light paths and on camera paths; both estimates agree.
#[test]
fn leaning_shading_normals_lose_no_light() {
    leaning_shading_normals(TurnedAway::Flat);
    leaning_shading_normals(TurnedAway::Opposite);
}

fn leaning_shading_normals(rule: TurnedAway) {
    let mut b = diffuse_room();
    b.set_turned_away(rule);
    add_ceiling_lamp(&mut b, 5.0);
    let mut add = |corner: [f32; 3], u: Vec3, v: Vec3| {
        let panel = parallelogram(corner.into(), u, v);
        let normal = u.cross(v).normalize();
        let lean = |[s, t]: [f32; 2]| (normal + 1.5 * (s * u.normalize() + t * v.normalize())).normalize();
        let normals = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(lean).to_vec();
        place(&mut b, MeshData { normals, ..panel }, Material::new("panel", lambert(0.9)));
    };
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| 1.98 * axis);
    add([-0.99, 0.01, -0.99], z, x);
    add([-0.99, 0.01, -0.99], y, z);
    add([-0.99, 0.01, -0.99], x, y);
    add([0.99, 0.01, -0.99], z, y);
    transport_agrees(b, 0.02, &format!("leaning normals, {rule:?}"));
}

/// Screens with a black back, or a back of another material. Camera rays and light that meet the
/// back are reflected by the material of the back.
#[test]
fn backs_scatter_by_themselves() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    let gloss = b.add_material(Material::new("gloss", plastic(0.15))).unwrap();
    for (x, back) in [(-0.6, Back::Black), (0.0, Back::Material(gloss)), (0.5, Back::Black)] {
        let screen = parallelogram(Vec3::new(x, 0.02, -0.3), Vec3::Y, Vec3::new(0.3, 0.0, 0.5));
        place(&mut b, screen, Material { back, ..Material::new("screen", lambert(0.9)) });
    }
    transport_agrees(b, 0.02, "backs");
}

/// Broad and narrow lobes, at gather points and at earlier vertices; coats, whose diffuse part is
/// not a plain cosine lobe. Compensation adds the light that VPLs omit.
#[test]
fn gloss_is_put_back() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    let floor = parallelogram(Vec3::new(-1.0, 0.01, -1.0), Vec3::Z * 2.0, Vec3::X * 2.0);
    place(&mut b, floor, Material::new("floor", plastic(0.15)));
    let metal = Surface::Conductor {
        fresnel: ConductorFresnel::Schlick { f0: Rgb::new(0.9, 0.7, 0.4) },
        specular: Rgb::WHITE.into(),
        facets: 0.4.into(),
    };
    let left = cuboid(Vec3::new(-0.8, 0.02, -0.2), Vec3::new(-0.4, 0.5, 0.3), false);
    place(&mut b, left, Material::new("metal", metal));
    let coated = Surface::Coated {
        reflectance: Rgb::new(0.7, 0.2, 0.2).into(),
        base: CoatBase::Saturating,
        specular: Rgb::WHITE.into(),
        ior: 1.5,
        facets: 0.3.into(),
    };
    let right = cuboid(Vec3::new(0.5, 0.02, -0.1), Vec3::new(0.8, 0.8, 0.3), false);
    place(&mut b, right, Material::new("coated", coated));
    // Anisotropic roughness along a diagonal.
    let facets = FacetInput { across: Some(0.1.into()), ..0.5.into() };
    let Surface::Conductor { fresnel, specular, .. } = metal else { unreachable!() };
    let mut back = parallelogram(Vec3::new(-0.9, 0.6, -0.98), Vec3::X * 0.6, Vec3::Y * 0.6);
    back.uvs = back.positions.iter().map(|p| Vec2::new(p.x + p.y, p.x - p.y)).collect();
    place(&mut b, back, Material::new("brushed", Surface::Conductor { fresnel, specular, facets }));
    transport_agrees(b, 0.02, "gloss");
}

/// A diffuse part that is far from a cosine lobe, and sheen. VPLs carry a mean of the former and
/// nothing of the latter; compensation adds the rest.
#[test]
fn cloth_and_retro_reflection_are_put_back() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    let principled = |roughness: f32, metallic: f32| Surface::Principled {
        base_color: Rgb::new(0.6, 0.5, 0.2).into(),
        metallic: metallic.into(),
        roughness: roughness.into(),
        ior: 1.5,
        specular_tint: 0.5.into(),
        sheen: 1.0.into(),
        sheen_tint: 0.5.into(),
        flatness: 0.0.into(),
        anisotropic: 0.0.into(),
    };
    let floor = parallelogram(Vec3::new(-1.0, 0.01, -1.0), Vec3::Z * 2.0, Vec3::X * 2.0);
    place(&mut b, floor, Material::new("floor", principled(1.0, 0.0)));
    let left = cuboid(Vec3::new(-0.8, 0.02, -0.2), Vec3::new(-0.4, 0.5, 0.3), false);
    place(&mut b, left, Material::new("half metal", principled(0.5, 0.4)));
    transport_agrees(b, 0.02, "cloth");
}

/// Coats of each model, at gather points and at earlier vertices of a path.
#[test]
fn clear_coats_are_put_back() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    let principled = Surface::Principled {
        base_color: Rgb::new(0.2, 0.5, 0.6).into(),
        metallic: 0.3.into(),
        roughness: 0.8.into(),
        ior: 1.5,
        specular_tint: 0.0.into(),
        sheen: 0.0.into(),
        sheen_tint: 0.0.into(),
        flatness: 1.0.into(),
        anisotropic: 0.0.into(),
    };
    let principled = b.add_material(Material::new("principled", principled)).unwrap();
    let painted = b.add_material(Material::new("painted", lambert(0.7))).unwrap();
    let coat = |base, alpha: f32, model| {
        let (amount, alpha) = (1.0.into(), alpha.into());
        Material::new("coat", Surface::Clearcoat { base, amount, alpha, model })
    };
    let floor = parallelogram(Vec3::new(-1.0, 0.01, -1.0), Vec3::Z * 2.0, Vec3::X * 2.0);
    place(&mut b, floor, coat(painted, 0.3, CoatModel::Layer));
    let left = cuboid(Vec3::new(-0.8, 0.02, -0.2), Vec3::new(-0.4, 0.5, 0.3), false);
    place(&mut b, left, coat(principled, 0.1, CoatModel::Mitsuba));
    let right = cuboid(Vec3::new(0.4, 0.02, -0.2), Vec3::new(0.8, 0.6, 0.3), false);
    place(&mut b, right, coat(principled, 0.1, CoatModel::Disney));
    let back = parallelogram(Vec3::new(-0.9, 0.6, -0.98), Vec3::X * 0.6, Vec3::Y * 0.6);
    place(&mut b, back, coat(painted, 0.05, CoatModel::Layer));
    transport_agrees(b, 0.02, "coats");
}

/// Sheen on a curtain and on a block, and under a coat. Compensation adds the light that VPLs omit,
/// and the light that fibres scatter further.
#[test]
fn sheen_is_put_back() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    let red = b.add_material(Material::new("red", lambert(0.4))).unwrap();
    let sheen = |base, roughness: f32| Surface::Sheen {
        base,
        color: Rgb::new(1.0, 0.8, 0.4).into(),
        roughness: roughness.into(),
    };
    let cloth = b.add_material(Material::new("cloth", sheen(red, 0.5))).unwrap();
    let coat =
        Surface::Clearcoat { base: cloth, amount: 1.0.into(), alpha: 0.3.into(), model: CoatModel::Layer };
    let floor = parallelogram(Vec3::new(-1.0, 0.01, -1.0), Vec3::Z * 2.0, Vec3::X * 2.0);
    place(&mut b, floor, Material::new("carpet", sheen(red, 1.0)));
    let left = cuboid(Vec3::new(-0.8, 0.02, -0.2), Vec3::new(-0.4, 0.5, 0.3), false);
    place(&mut b, left, Material::new("block", coat));
    let back = parallelogram(Vec3::new(-0.9, 0.2, -0.98), Vec3::X * 1.2, Vec3::Y * 1.0);
    place(&mut b, back, Material::new("curtain", sheen(red, 0.25)));
    transport_agrees(b, 0.02, "sheen");
}

/// Facets over a base that fades towards grazing angles, and two rough panes. The scene is seen
/// through one pane; the other stands in it and is lit from behind.
#[test]
fn substrates_and_rough_panes_are_put_back() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    b.set_environment(Environment::constant(Rgb::new(0.3, 0.5, 0.9))).unwrap();
    let substrate = |alpha: f32| Surface::AshikhminShirley {
        diffuse: Rgb::new(0.6, 0.4, 0.2).into(),
        specular_f0: Rgb::gray(0.1).into(),
        facets: alpha.into(),
    };
    let floor = parallelogram(Vec3::new(-1.0, 0.01, -1.0), Vec3::Z * 2.0, Vec3::X * 2.0);
    place(&mut b, floor, Material::new("floor", substrate(0.3)));
    let block = cuboid(Vec3::new(0.4, 0.02, -0.2), Vec3::new(0.8, 0.6, 0.3), false);
    place(&mut b, block, Material::new("block", substrate(0.1)));
    let front = parallelogram(Vec3::new(-1.0, 0.0, 1.0), Vec3::X * 2.0, Vec3::Y * 2.0);
    place(&mut b, front, Material::new("front", pane(Rgb::WHITE, 0.2)));
    let under_lamp = parallelogram(Vec3::new(-0.7, 1.5, -0.6), Vec3::X * 1.2, Vec3::Z * 1.2);
    place(&mut b, under_lamp, Material::new("diffuser", pane(Rgb::WHITE, 0.4)));
    transport_agrees(b, 0.05, "substrates and rough panes");
}

/// A mirror, a smooth coat, a pane, and a block of solid glass, in front of an open side with a
/// sky. Compensation adds the specular light that VPLs cannot carry.
#[test]
fn mirrors_panes_and_glass_are_put_back() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    b.set_environment(Environment::constant(Rgb::new(0.3, 0.5, 0.9))).unwrap();
    let mirror = Surface::Mirror { reflectance: Rgb::gray(0.9).into() };
    let side = parallelogram(Vec3::new(-0.99, 0.3, -0.6), Vec3::Y * 1.2, Vec3::Z * 1.2);
    place(&mut b, side, Material::new("mirror", mirror));
    let coat = cuboid(Vec3::new(0.5, 0.01, -0.2), Vec3::new(0.9, 0.5, 0.3), false);
    place(&mut b, coat, Material::new("smooth coat", plastic(0.0)));
    let glass = Surface::Glass {
        ior: 1.5,
        reflectance: Rgb::WHITE,
        transmittance: Rgb::gray(0.95),
        facets: 0.0.into(),
    };
    let block = cuboid(Vec3::new(-0.7, 0.01, 0.0), Vec3::new(-0.4, 0.6, 0.3), false);
    place(&mut b, block, Material::new("glass", glass));
    let pane = pane(Rgb::WHITE, 0.0);
    let front = parallelogram(Vec3::new(-1.0, 0.0, 1.0), Vec3::X * 2.0, Vec3::Y * 2.0);
    place(&mut b, front, Material::new("pane", pane));
    transport_agrees(b, 0.05, "mirrors and glass");
}

/// Point lights and spots so close to surfaces that their light is clamped, and a sun. Compensation
/// restores the clamped light.
#[test]
fn punctual_lights_near_by_are_made_good() {
    let mut b = diffuse_room();
    b.add_emitter(Emitter::Point { position: Vec3::new(-0.85, 1.0, 0.2), intensity: Rgb::gray(0.2) })
        .unwrap();
    b.add_emitter(Emitter::Directional {
        direction: Vec3::new(0.2, -0.4, -1.0).normalize(),
        irradiance: Rgb::new(1.0, 0.9, 0.7),
    })
    .unwrap();
    transport_agrees(b, 0.02, "punctual lights");
}

/// Leaves and holes beside gloss. VPLs carry light through leaves and holes, and compensation does
/// not add it again.
#[test]
fn leaves_and_holes_are_told_apart_from_gloss() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    add_leaf_and_gauze(&mut b, plastic(0.3));
    transport_agrees(b, 0.02, "leaves");
}

/// Few VPLs, so that their random choice causes most of the error. Intervals include this error;
/// without it they would be far too narrow.
#[test]
fn intervals_reckon_with_the_choice_of_vpls() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    let tracer = tracer(b);
    let size = [12, 12];
    let reference =
        film(&tracer, &PathTracer::new(&tracer, PathStop::Count(10_000), 65).unwrap(), size, 1, 1000);
    let expected = luminances(&reference);
    let (mut kept, mut claims, mut from_lights) = (0, 0, 0);
    for seed in 1..=8 {
        let lights = VplOptions { count: 12_000, seed, ..VplOptions::default() };
        let guided =
            GuidedLights::trace(&tracer, &lights, Truth::Transport, &view(tracer.scene(), size, 64, seed))
                .unwrap();
        let options = ControlOptions { error: 0.05, seed, ..ControlOptions::default() };
        let ours = LightTransport::new(&tracer, &guided, &options).only_by(Estimator::Vpls);
        let film = film(&tracer, &ours, size, 64, seed);
        let (found, claim) = (luminances(&film), film.plane("claim").unwrap().u32_samples().unwrap());
        let half_widths = film.plane("half_width").unwrap().f32_samples().unwrap();
        let parts = film.plane("half_width_parts").unwrap().f32_samples().unwrap();
        for i in (0..144).filter(|&i| claim[i] == 3) {
            claims += 1;
            kept += u64::from((found[i] - expected[i]).abs() <= half_widths[i].into());
            from_lights += u32::from(parts[3 * i + 1] > parts[3 * i].max(parts[3 * i + 2]));
        }
    }
    // The pixels of an image share their VPLs, so their errors are correlated and the limit is
    // loose.
    assert!(claims > 600 && from_lights > 300, "{claims} claims, {from_lights} mostly of the choice of VPLs");
    assert!(kept * 100 >= claims * 93, "{kept} of {claims}");
}

/// VPLs that were traced without regard to a view give light transport, too, if they are
/// compensated.
#[test]
fn lights_that_are_given_do_too() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    place(&mut b, cuboid(Vec3::splat(-0.5), Vec3::splat(0.4), false), Material::new("block", plastic(0.1)));
    let tracer = tracer(b);
    let view = view(tracer.scene(), SIZE, 64, 3);
    let options = VplOptions { count: 100_000, clamp: Clamp::Distance(0.8), ..VplOptions::default() };
    let set = VplSet::trace(&tracer, &options).unwrap();
    let given = GuidedLights::given(&tracer, &set, Truth::Transport, &view).unwrap();
    let options = ControlOptions { error: 0.03, ..ControlOptions::default() };
    let ours = film(&tracer, &LightTransport::new(&tracer, &given, &options), SIZE, 64, 3);
    let reference =
        film(&tracer, &PathTracer::new(&tracer, PathStop::Count(20_000), 65).unwrap(), SIZE, 1, 1000);
    let errors = |film: &Film| film.plane("standard_error").unwrap().f32_samples().unwrap().to_vec();
    let [sum, of] = [&ours, &reference].map(|film| luminances(film).iter().sum::<f64>());
    let variance = [&ours, &reference].map(|film| errors(film).iter().map(|e| f64::from(e * e)).sum::<f64>());
    let error = (variance[0] + variance[1]).sqrt();
    assert!(error < 0.01 * of && (sum - of).abs() < 4.42 * error, "{sum} ± {error} for {of}");

    let mut indirect = set.provenance().clone();
    indirect.direct = 0;
    let refused = VplSet::new(set.lights().to_vec(), indirect);
    let refused = GuidedLights::given(&tracer, &refused, Truth::Transport, &view).unwrap_err();
    assert!(refused.to_string().contains("a set with direct VPLs"), "{refused}");
}

/// A set of VPLs that is guided to a view may be stored and used by another render, with the same
/// bits.
#[test]
fn a_guided_set_that_is_given_back_gives_the_same_bits() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    place(&mut b, cuboid(Vec3::splat(-0.5), Vec3::splat(0.4), false), Material::new("block", plastic(0.1)));
    let tracer = tracer(b);
    let view = view(tracer.scene(), SIZE, 16, 3);
    let lights = |clamp| VplOptions { count: 20_000, clamp, seed: 5, ..VplOptions::default() };
    let rendered = |lights: &GuidedLights| {
        let options = ControlOptions { error: 0.1, max_pairs: Some(400), ..ControlOptions::default() };
        film(&tracer, &LightTransport::new(&tracer, lights, &options), SIZE, 16, 3)
    };
    for clamp in [Clamp::Auto, Clamp::Distance(0.05)] {
        let traced = GuidedLights::trace(&tracer, &lights(clamp), Truth::Transport, &view).unwrap();
        let set = GuidedLights::trace_set(&tracer, &lights(clamp), Truth::Transport, &view).unwrap();
        let given = GuidedLights::given(&tracer, &set, Truth::Transport, &view).unwrap();
        assert_eq!(given.provenance(), traced.provenance());
        assert!(rendered(&given) == rendered(&traced), "{clamp:?}");
    }
}

/// A dark surface scatters less light and tolerates proportionally less error. If its paths ended
/// early because it is dark, the remaining paths would be few and bright.
#[test]
fn paths_from_dark_surfaces_go_as_far() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    let tracer = tracer(b);
    let lights = VplOptions { count: 500, clamp: Clamp::Distance(0.8), ..VplOptions::default() };
    let set = VplSet::trace(&tracer, &lights).unwrap();
    let (tree, emitters) = (LightTree::build(&set, Default::default()), EmitterSampler::new(&tracer));
    let point = view(tracer.scene(), SIZE, 1, 1).pixel(&tracer, [3, 4]).points[0];
    for lights in [Some(&tree), None] {
        let lit = LightingContext {
            tracer: &tracer,
            emitters: &emitters,
            lights,
            vpl_source: VplSource::EmittersAndSurfaces,
            choices: None,
            contribution: ContributionKernel::new(0.8).with_glass(Glass::SolidStops),
            max_depth: 16,
            caustics: None,
        };
        let mut seen = 0;
        for path in 0..5000 {
            let [dark, bright] = [0.01, 0.5].map(|reflectance| {
                let bsdf = Bsdf::Lambert(Lambert { reflectance: Rgb::gray(reflectance) });
                let mut stream = Stream::new(7, Purpose::Test, path);
                let point = GatherPoint { bsdf, ..point };
                Compensation::new(lit).estimate(&point, &bsdf, path, &mut stream).luminance() / reflectance
            });
            assert!((dark - bright).abs() <= 1e-4 * bright.abs(), "path {path}: {dark}, {bright}");
            seen += u32::from(bright != 0.0);
        }
        assert!(seen > 50, "{seen} paths found light");
    }
}

/// With far too few VPLs, pixels are estimated by paths, if these are likely to suffice.
#[test]
fn where_vpls_are_too_few_paths_take_over() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    let tracer = tracer(b);
    // So near that none of the clamp distances that are tried is large enough.
    let lights = VplOptions { count: 200, clamp: Clamp::Distance(0.01), ..VplOptions::default() };
    let guided =
        GuidedLights::trace(&tracer, &lights, Truth::Transport, &view(tracer.scene(), SIZE, 16, 1)).unwrap();
    let options = ControlOptions { error: 0.05, ..ControlOptions::default() };
    let out_of_budget = |ours: LightTransport<'_>| {
        let film = film(&tracer, &ours, SIZE, 16, 1);
        film.plane("stop").unwrap().u32_samples().unwrap().iter().filter(|stop| **stop == 4).count()
    };
    let ours = || LightTransport::new(&tracer, &guided, &options);
    let found = [out_of_budget(ours().only_by(Estimator::Vpls)), out_of_budget(ours())];
    assert!(found[0] > 10 && found[1] < found[0], "out of budget: {found:?}");
}

/// No pixel exceeds its limits of pairs and paths, whichever estimators it tries.
#[test]
fn the_work_on_a_pixel_is_limited() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    place(&mut b, cuboid(Vec3::splat(-0.5), Vec3::splat(0.4), false), Material::new("block", plastic(0.1)));
    let tracer = tracer(b);
    let lights = VplOptions { count: 2000, ..VplOptions::default() };
    let guided =
        GuidedLights::trace(&tracer, &lights, Truth::Transport, &view(tracer.scene(), SIZE, 16, 1)).unwrap();
    let options = ControlOptions { error: 0.001, max_pairs: Some(500), ..ControlOptions::default() };
    let film = film(&tracer, &LightTransport::new(&tracer, &guided, &options), SIZE, 16, 1);
    let stops = film.plane("stop").unwrap().u32_samples().unwrap();
    assert!(stops.iter().all(|stop| *stop == 4), "{stops:?}");
    // The half-width that was reached is stated, although it is wider than requested.
    let half_widths = film.plane("half_width").unwrap().f32_samples().unwrap();
    let wider = half_widths.iter().zip(luminances(&film)).filter(|(h, l)| f64::from(**h) > 0.001 * l);
    assert_eq!(wider.count(), 36, "{half_widths:?}");
    let pairs = film.plane("pairs").unwrap().f32_samples().unwrap();
    assert!(pairs.iter().all(|pairs| *pairs <= 501.0), "{pairs:?}");
    assert!(luminances(&film).iter().all(|l| *l > 0.0));
}

/// A camera that sees partly nothing, beside a bright room with a caustic. Pixels without a surface
/// are black with certainty.
#[test]
fn pixels_that_see_nothing_are_black_for_certain() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 50.0);
    place(&mut b, cuboid(Vec3::splat(-0.5), Vec3::splat(0.4), false), Material::new("block", plastic(0.1)));
    let tracer = tracer(b);
    let lights = VplOptions { count: 200, ..VplOptions::default() };
    let guided =
        GuidedLights::trace(&tracer, &lights, Truth::Transport, &view(tracer.scene(), [24, 8], 4, 1))
            .unwrap();
    let options = ControlOptions { error: 0.1, max_pairs: Some(4000), ..ControlOptions::default() };
    // The image is wider than the room.
    let film = film(&tracer, &LightTransport::new(&tracer, &guided, &options), [24, 8], 4, 1);
    let stops = film.plane("stop").unwrap().u32_samples().unwrap();
    let pixels = luminances(&film).into_iter().zip(stops);
    let black: Vec<u32> = pixels.filter(|(l, _)| *l == 0.0).map(|(_, stop)| *stop).collect();
    assert!(black.len() > 10 && black.len() < 24 * 8, "{} black pixels", black.len());
    assert!(black.iter().all(|stop| *stop == 3), "the rule is met: {black:?}");
}

/// Without a given absolute error, pixels with less than a hundredth of the view's mean light have
/// the tolerance of that hundredth. This limits their work.
#[test]
fn dark_pixels_are_held_to_a_share_of_the_views_light() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    let hidden = cuboid(Vec3::new(-0.95, 0.001, -0.5), Vec3::new(-0.35, 1.2, 0.3), false);
    place(&mut b, hidden, Material::new("nearly black", lambert(0.0001)));
    let tracer = tracer(b);
    let lights = VplOptions { count: 20_000, ..VplOptions::default() };
    let size = [12, 12];
    let guided =
        GuidedLights::trace(&tracer, &lights, Truth::Transport, &view(tracer.scene(), size, 64, 1)).unwrap();
    let options = ControlOptions { error: 0.02, absolute_error: 0.0, ..ControlOptions::default() };
    let film = film(&tracer, &LightTransport::new(&tracer, &guided, &options), size, 64, 1);
    let half_widths = film.plane("half_width").unwrap().f32_samples().unwrap();
    let stops = film.plane("stop").unwrap().u32_samples().unwrap();
    let found = luminances(&film);
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    let absolute = guided.importance_brightness() * 0.01 * 0.02;
    let dark: Vec<usize> = (0..found.len()).filter(|&i| found[i] > 0.0 && found[i] < 0.002 * mean).collect();
    assert!(dark.len() > 5, "{} dark pixels", dark.len());
    let half_width = |i: usize| f64::from(half_widths[i]);
    assert!(dark.iter().all(|&i| stops[i] == 3 && half_width(i) <= absolute * (1.0 + 1e-5)));
    assert!(dark.iter().any(|&i| half_width(i) > 0.02 * found[i]), "some are wider than their own tolerance");
}

#[test]
fn a_path_tracer_stops_by_its_own_interval() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    let tracer = tracer(b);
    let until = |error: f64, most: u32| {
        let options = ControlOptions { error, ..ControlOptions::default() };
        let path = PathTracer::new(&tracer, PathStop::Until { options, first: 64, most }, 65).unwrap();
        film(&tracer, &path, SIZE, 1, 7)
    };
    let film = until(0.05, 1 << 20);
    let paths = film.plane("pairs").unwrap().f32_samples().unwrap();
    let half_widths = film.plane("half_width").unwrap().f32_samples().unwrap();
    for ((paths, half_width), l) in paths.iter().zip(half_widths).zip(luminances(&film)) {
        assert!(f64::from(*half_width) <= 0.05 / 1.05 * l * (1.0 + 1e-5), "{half_width} of {l}");
        // 64, 96, 144, …
        let looks = std::iter::successors(Some(64_u32), |n| Some(n + n / 2));
        assert!(looks.take_while(|n| *n <= 1 << 20).any(|n| n as f32 == *paths), "{paths}");
    }
    let stops = until(0.001, 100).plane("stop").unwrap().u32_samples().unwrap().to_vec();
    assert!(stops.iter().all(|stop| *stop == 4), "out of budget: {stops:?}");
}

/// One lamp with a millionth of all power lights the whole room; the other lamps are enclosed
/// elsewhere. Guiding samples it sufficiently.
#[test]
fn a_lamp_of_a_millionth_of_the_power_is_found() {
    let room = || {
        let mut b = diffuse_room();
        add_ceiling_lamp(&mut b, 5.0);
        b
    };
    let alone = tracer(room());
    let reference =
        film(&alone, &PathTracer::new(&alone, PathStop::Count(10_000), 65).unwrap(), SIZE, 1, 1000);
    let expected = luminances(&reference);
    let mut b = room();
    let (lo, hi) = (Vec3::new(19.0, 0.0, -1.0), Vec3::new(21.0, 2.0, 1.0));
    place(&mut b, cuboid(lo, hi, true), Material::new("shut", lambert(0.5)));
    let bright = cuboid(lo + Vec3::splat(0.6), hi - Vec3::splat(0.6), false);
    place(&mut b, bright, glowing("bright", lambert(0.3), 1e6));
    let tracer = tracer(b);
    let (mut claims, mut kept) = (0, 0);
    for seed in 1..=4 {
        let lights = VplOptions { count: 20_000, seed, ..VplOptions::default() };
        let view = view(tracer.scene(), SIZE, 16, seed);
        let guided = GuidedLights::trace(&tracer, &lights, Truth::Transport, &view).unwrap();
        let options = ControlOptions { error: 0.1, seed, ..ControlOptions::default() };
        let film = film(&tracer, &LightTransport::new(&tracer, &guided, &options), SIZE, 16, seed);
        let claim = film.plane("claim").unwrap().u32_samples().unwrap();
        let half_widths = film.plane("half_width").unwrap().f32_samples().unwrap();
        for (i, found) in luminances(&film).into_iter().enumerate().filter(|(i, _)| claim[*i] == 3) {
            claims += 1;
            kept += u32::from((found - expected[i]).abs() <= half_widths[i].into());
        }
    }
    assert!(claims > 110 && kept * 100 >= claims * 90, "{kept} of {claims} claims are kept");
}

/// A room lit through its open side, on a ground of 200 m. More than 40 % of the guided VPLs on
/// surfaces are in the room; without guiding, fewer than 5 %.
#[test]
fn a_wide_ground_has_few_of_the_vpls() {
    let mut b = diffuse_room();
    b.set_environment(Environment::constant(Rgb::new(0.3, 0.5, 0.9))).unwrap();
    let ground = parallelogram(Vec3::new(-100.0, -0.01, -100.0), Vec3::Z * 200.0, Vec3::X * 200.0);
    place(&mut b, ground, Material::new("ground", lambert(0.5)));
    let tracer = tracer(b);
    let lights = VplOptions { count: 4000, ..VplOptions::default() };
    let in_the_room = |tracing: &LightTracer<'_>| {
        let set = tracing.trace(5);
        let inside = |position: Vec3| position.abs().max_element() < 2.5;
        // Lights at infinity have no position.
        let on_surfaces = || set.lights().iter().filter(|l| l.position != Vec3::ZERO);
        on_surfaces().filter(|l| inside(l.position)).count() as f64 / on_surfaces().count() as f64
    };
    let plain = LightTracer::new(&tracer, &lights).unwrap();
    let share_of_plain = in_the_room(&plain);
    let guided = learn_light_guide(plain, &view(tracer.scene(), SIZE, 1, 1), 3);
    let share_of_guided = in_the_room(&guided.tracing);
    assert!(share_of_plain < 0.05 && share_of_guided > 0.4, "{share_of_plain} {share_of_guided}");
}

/// A pixel shows a leaf, and its sum depends on the choice of camera samples. It varies less the
/// more samples there are: the side of the leaf on which a sample gathers and the point where it
/// meets the leaf are stratified together.
#[test]
fn camera_samples_of_leaves_are_spread_evenly() {
    let mut b = diffuse_room();
    add_ceiling_lamp(&mut b, 5.0);
    add_leaf_and_gauze(&mut b, plastic(0.3));
    let tracer = tracer(b);
    let set = VplSet::trace(&tracer, &VplOptions { count: 300, ..VplOptions::default() }).unwrap();
    let spread = |gather: u32| {
        let mut sums = Moments::default();
        (0..60).for_each(|seed| {
            sums.push(luminances(&film(&tracer, &FullSum::new(&set), SIZE, gather, seed))[8])
        });
        sums.variance().sqrt() / sums.mean()
    };
    let (few, many) = (spread(4), spread(64));
    assert!(many < 0.35 * few, "{few} of 4 samples, {many} of 64");
}
