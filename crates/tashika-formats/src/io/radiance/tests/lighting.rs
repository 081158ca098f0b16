//! Materials and lights.

use std::f32::consts::PI;

use super::*;
use crate::bsdf::{Bsdf, Conductor, ConductorFresnel, FacetModel, Microfacets};
use crate::color::Rgb;
use crate::math::elementary::{exp, sin_cos};
use crate::scene::{Back, CoatBase, ColorInput, Emitter, Material, Surface};

/// The material of a sphere.
fn material(text: &str) -> (Scene, Material) {
    let scene = scene(&format!("{text}\nm sphere s 0 0 4 0 0 0 1"));
    let id = scene.instance_ids().next().unwrap();
    let material = scene.material_of(id).clone();
    (scene, material)
}

fn surface(text: &str) -> (Scene, Surface) {
    let (scene, material) = material(text);
    let surface = material.surface;
    (scene, surface)
}

fn rgb(color: ColorInput) -> [f32; 3] {
    assert_eq!(color.texture, None);
    color.factor.to_array()
}

fn near(found: [f32; 3], expected: [f32; 3]) {
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 1e-6, "{found:?}, not {expected:?}");
    }
}

/// Expected reflectance and transmittance of all lobes of a mix: (diffuse, lobe, transmitted,
/// straight), each weighted by the probability of its part.
fn lobes(scene: &Scene, surface: &Surface, weight: f32) -> [Rgb; 4] {
    let mut all = [Rgb::BLACK; 4];
    match surface {
        Surface::Lambert { reflectance } => all[0] = reflectance.factor * weight,
        Surface::Mirror { reflectance } => all[1] = reflectance.factor * weight,
        Surface::Conductor { specular, .. } => all[1] = specular.factor * weight,
        Surface::Translucent { reflectance, transmittance } => {
            (all[0], all[2]) = (reflectance.factor * weight, transmittance.factor * weight);
        }
        Surface::ThinGlass { transmittance, .. } => all[3] = transmittance.factor * weight,
        Surface::Mix { first, second, amount } => {
            let part = |id: &crate::scene::MaterialId, share: f32| {
                lobes(scene, &scene.materials()[id.index()].surface, weight * share)
            };
            let (a, b) = (part(first, 1.0 - amount.factor), part(second, amount.factor));
            all = [0, 1, 2, 3].map(|k| a[k] + b[k]);
        }
        other => panic!("{other:?}"),
    }
    all
}

#[test]
fn plastics_and_metals_reflect_the_shares_of_the_file() {
    let (_, surface_) = surface("void plastic m 0 0 5 .6 .4 .2 0 0");
    let Surface::Lambert { reflectance } = surface_ else { panic!("{surface_:?}") };
    near(rgb(reflectance), [0.6, 0.4, 0.2]);

    let (scene, rough) = surface("void plastic m 0 0 5 .6 .4 .2 .05 .1");
    let [diffuse, lobe, ..] = lobes(&scene, &rough, 1.0);
    near(diffuse.to_array(), [0.57, 0.38, 0.19]);
    near(lobe.to_array(), [0.05; 3]);

    let (scene, metal) = surface("void metal m 0 0 5 .6 .4 .2 .9 .1");
    let [diffuse, lobe, ..] = lobes(&scene, &metal, 1.0);
    near(diffuse.to_array(), [0.06, 0.04, 0.02]);
    near(lobe.to_array(), [0.54, 0.36, 0.18]);
    let facets = scene.materials().iter().find_map(|m| match m.surface {
        Surface::Conductor { facets, .. } => Some(facets),
        _ => None,
    });
    let facets = facets.unwrap();
    assert_eq!((facets.alpha, facets.model), (0.1.into(), FacetModel::Beckmann));

    let (_, smooth) = surface("void plastic m 0 0 5 .6 .4 .2 .04 0");
    let Surface::Coated { reflectance, base, ior, facets, .. } = smooth else { panic!("{smooth:?}") };
    near(rgb(reflectance), [0.6, 0.4, 0.2]);
    assert!(base == CoatBase::Proportional && (ior - 1.5).abs() < 1e-6 && facets == 0.0.into(), "{ior}");

    let (scene, faint) = surface("void plastic m 0 0 5 .6 .4 .2 .01 0");
    let [diffuse, lobe, ..] = lobes(&scene, &faint, 1.0);
    near(diffuse.to_array(), [0.594, 0.396, 0.198]);
    near(lobe.to_array(), [0.01; 3]);
}

#[test]
fn translucent_materials_divide_light_as_the_manual_says() {
    // Smooth ones reflect 0.0544 more of the rest: the mean of the file's Fresnel reflection.
    let smooth = 0.1 + 0.9 * 0.0544_f32;
    let (scene, trans) = surface("void trans m 0 0 7 .8 .6 .4 .1 0 .5 .4");
    let [diffuse, lobe, transmitted, straight] = lobes(&scene, &trans, 1.0).map(|c| c.to_array()[0]);
    let half = 0.5 * (1.0 - smooth);
    for (found, expected) in
        [(diffuse, 0.8 * half), (lobe, smooth), (transmitted, 0.48 * half), (straight, 0.32 * half)]
    {
        assert!((found - expected).abs() < 1e-6, "{found}, not {expected}");
    }
    // t = 0.5 · 0.9 = 0.45, of which 0.4 straight; 0.45 is left for diffuse reflection.
    let (scene, trans) = surface("void trans m 0 0 7 .8 .6 .4 .1 .1 .5 .4");
    let [diffuse, lobe, transmitted, straight] = lobes(&scene, &trans, 1.0);
    near(diffuse.to_array(), [0.36, 0.27, 0.18]);
    near(lobe.to_array(), [0.1; 3]);
    near(transmitted.to_array(), [0.216, 0.162, 0.108]);
    near(straight.to_array(), [0.144, 0.108, 0.072]);
}

/// Beckmann's distribution of half vectors (sr⁻¹), with the cosine from the normal.
fn beckmann(cos: f32, alpha: f32) -> f32 {
    let (c2, a2) = (cos * cos, alpha * alpha);
    exp(-(1.0 - c2) / (c2 * a2)) / (PI * a2 * c2 * c2)
}

/// Ward's lobe loses light that Beckmann's facets of this model reflect: `α²` at normal incidence.
#[test]
fn rough_lobes_are_a_little_brighter_than_those_of_ward() {
    for (alpha, degrees, most) in [
        (0.05, 0.0_f32, 0.004),
        (0.05, 60.0, 0.008),
        (0.1, 0.0, 0.012),
        (0.1, 45.0, 0.017),
        (0.1, 60.0, 0.03),
        (0.2, 0.0, 0.045),
        (0.2, 45.0, 0.07),
        (0.2, 60.0, 0.09),
    ] {
        let (sin, cos) = sin_cos(degrees.to_radians());
        let o = Vec3::new(sin, 0.0, cos);
        let facets = Microfacets::even(alpha, FacetModel::Beckmann);
        let fresnel = ConductorFresnel::Schlick { f0: Rgb::WHITE };
        let bsdf = Bsdf::Conductor(Conductor { fresnel, specular: Rgb::WHITE, facets });
        let n = 512;
        let (mut here, mut ward) = (0.0_f64, 0.0_f64);
        for i in 0..n * n {
            // Equal steps of the half vector's slope and azimuth, in the frame of the lobe.
            let (slope, phi) = ((i / n) as f32 + 0.5, (i % n) as f32 + 0.5);
            let (slope, phi) = (slope / n as f32 * 6.0 * alpha, phi / n as f32 * 2.0 * PI);
            let (s, c) = sin_cos(phi);
            let h = Vec3::new(slope * c, slope * s, 1.0).normalize();
            let d = h.dot(o);
            let w = h * (2.0 * d) - o;
            if w.z <= 0.0 || d <= 0.0 {
                continue;
            }
            // dω_i = 4 (ω_i·h) dω_h, and dω_h = slope h_z³ dslope dφ.
            let step = slope * h.z * h.z * h.z * (6.0 * alpha / n as f32) * (2.0 * PI / n as f32) * 4.0 * d;
            here += f64::from(bsdf.eval(o, w).to_array()[0] * w.z * step);
            ward += f64::from(beckmann(h.z, alpha) / (4.0 * d * d) * w.z * step);
        }
        let off = here / ward - 1.0;
        assert!((0.0..most).contains(&off), "α = {alpha} at {degrees}°: {here} and {ward}, {off}");
        assert!((1.0 - ward) > 0.9 * f64::from(alpha * alpha), "{ward}");
    }
}

#[test]
fn lights_emit_from_their_front_and_mirrors_reflect_there_only() {
    for kind in ["light m 0 0 3 1 2 3", "glow m 0 0 4 1 2 3 0", "illum m 0 0 3 1 2 3"] {
        let (_, lamp) = material(&format!("void {kind}"));
        let emission = lamp.emission.unwrap();
        near(rgb(emission.radiance), [1.0, 2.0, 3.0]);
        assert!(!emission.two_sided, "{kind}");
        let Surface::Lambert { reflectance } = lamp.surface else { panic!() };
        near(rgb(reflectance), [0.0; 3]);
    }
    let (_, mirror) = material("void mirror m 0 0 3 .5 .6 .7");
    let Surface::Mirror { reflectance } = mirror.surface else { panic!() };
    near(rgb(reflectance), [0.5, 0.6, 0.7]);
    assert_eq!(mirror.back, Back::Black);
}

#[test]
fn dielectrics_absorb_inside_and_interfaces_may_bend_either_way() {
    let (scene, glass) = surface("void dielectric m 0 0 5 .5 1 .25 1.5 0");
    let Surface::Glass { ior, .. } = glass else { panic!("{glass:?}") };
    assert_eq!(ior, 1.5);
    let mesh = &scene.meshes()[0];
    let interface = mesh.interface.unwrap();
    assert!(interface.outside.is_none());
    let inside = &scene.media()[interface.inside.unwrap().index()];
    near(inside.transmittance(1.0).to_array(), [0.5, 1.0, 0.25]);
    assert!(surface("void dielectric m 0 0 5 1 1 1 1.5 0").0.meshes()[0].interface.is_none());

    let text = "void dielectric m 0 0 5 .5 1 .25 1.5 0\nm sphere s 0 0 4 0 0 0 1\n";
    let scaled = load(&[("scene.rad", "!xform -s 2 a.rad"), ("a.rad", text)]).unwrap();
    near(scaled.media()[0].transmittance(2.0).to_array(), [0.5, 1.0, 0.25]);

    // Air inside water: the front of the surface is the inside of the sphere.
    let (scene, bubble) = surface("void interface m 0 0 8 1 1 1 1 .5 .5 .5 1.25");
    let Surface::Glass { ior, .. } = bubble else { panic!("{bubble:?}") };
    assert!((ior - 1.25).abs() < 1e-6);
    let interface = scene.meshes()[0].interface.unwrap();
    assert!(interface.inside.is_some() && interface.outside.is_none());
    assert!(triangles(&scene, "s").iter().all(|(p, n, _)| p.dot(*n) < 0.0));
}

#[test]
fn small_sources_are_parallel_light_and_large_ones_the_environment() {
    let sun = scene("void light sun 0 0 3 1e6 2e6 3e6\nsun source s 0 0 4 0 3 4 .533\n");
    let [Emitter::Directional { direction, irradiance }] = sun.emitters() else {
        panic!("{:?}", sun.emitters())
    };
    assert!((*direction - Vec3::new(0.0, -0.6, -0.8)).length() < 1e-6, "to the light in the file");
    let sin = sin_cos(0.533_f32.to_radians() * 0.5).0;
    near((*irradiance * (1.0 / (PI * sin * sin))).to_array().map(|v| v * 1e-6), [1.0, 2.0, 3.0]);
    assert!(sun.environment().is_none());

    let glow = "void glow sky 0 0 4 1 2 4 0\nsky source up 0 0 4 0 0 1 180\n";
    let sky = scene(glow);
    let environment = sky.environment().unwrap();
    let seen = |d: Vec3| environment.radiance(d.normalize()).to_array();
    for d in [Vec3::Z, Vec3::new(1.0, 0.0, 0.02), Vec3::new(0.0, -1.0, 0.02)] {
        near(seen(d), [1.0, 2.0, 4.0]);
        near(seen(-d), [0.0; 3]);
    }
    near((environment.mean() * 2.0).to_array(), [1.0, 2.0, 4.0]);

    let all = scene(&format!("{glow}sky source all 0 0 4 1 0 0 360\n"));
    near(all.environment().unwrap().radiance(Vec3::NEG_Z).to_array(), [1.0, 2.0, 4.0]);
    near(all.environment().unwrap().radiance(Vec3::Z).to_array(), [2.0, 4.0, 8.0]);

    // The solid angle of a cone of 30° across is 2π (1 − cos 15°), wherever it is.
    for direction in ["1 0 0", "1 2 3", "0 0 -1"] {
        let cone = scene(&format!("void glow g 0 0 4 1 1 1 0\ng source c 0 0 4 {direction} 30\n"));
        let share = 0.5 * (1.0 - sin_cos(15_f32.to_radians()).1);
        let mean = cone.environment().unwrap().mean().to_array()[0];
        assert!((mean / share - 1.0).abs() < 1e-4, "{direction}: {mean} {share}");
    }
    let turned = load(&[
        ("scene.rad", "!xform -rx 90 a.rad"),
        ("a.rad", "void glow g 0 0 4 1 1 1 0\ng source c 0 0 4 0 0 1 30\n"),
    ]);
    let radiance = turned.unwrap().environment().unwrap().radiance(Vec3::NEG_Y).to_array();
    // The area of the texels at the rim is estimated from sixteen parts of each.
    assert!(radiance.iter().all(|v| (v - 1.0).abs() < 1e-3), "{radiance:?}");
}

#[test]
fn skies_of_gensky_are_painted_into_the_environment() {
    let text = "void brightfunc f 2 skybr skybright.cal 0 3 2 30 5\nf glow g 0 0 4 1 1 .5 0\n\
        g source up 0 0 4 0 0 1 180\ng source down 0 0 4 0 0 -1 180\n";
    let sky = scene(text);
    let seen = |d: Vec3| sky.environment().unwrap().radiance(d.normalize()).to_array();
    // The blend of sky and ground at the zenith is 1 in 2.01²⁰.
    for (direction, value) in [(Vec3::Z, 30.0), (Vec3::NEG_Z, 5.0)] {
        let found = seen(direction);
        assert!(
            (found[0] - value).abs() < 1e-3 * value && (found[2] - 0.5 * found[0]).abs() < 1e-4,
            "{found:?}"
        );
    }
    assert_eq!(notes(&sky), []);
}

/// Intensity of all lights of a scene in a unit direction (W·sr⁻¹), as seen from far away.
fn intensity(scene: &Scene, direction: Vec3) -> f32 {
    let of = |emitter: &Emitter| match emitter {
        Emitter::Image { intensity, beam, .. } => {
            (*intensity * scene.intensity_maps()[beam.map as usize].relative(direction)).to_array()[0]
        }
        other => panic!("{other:?}"),
    };
    scene.emitters().iter().map(of).sum()
}

#[test]
fn spotlights_shine_within_their_cone() {
    let text =
        "void spotlight l 0 0 7 10 10 10 60 0 0 -.01\nl polygon p 0 0 12 0 0 3 0 .2 3 .1 .2 3 .1 0 3\n";
    let scene = scene(text);
    for (degrees, expected) in
        [(0.0_f32, 0.2), (20.0, 0.2), (29.0, 0.2), (31.0, 0.0), (90.0, 0.0), (180.0, 0.0)]
    {
        let (sin, cos) = sin_cos(degrees.to_radians());
        let found = intensity(&scene, Vec3::new(0.0, sin, -cos));
        assert!((found - expected * cos.max(0.0)).abs() < 2e-3, "{degrees}°: {found}");
    }
    let places: Vec<Vec3> = scene.emitters().iter().filter_map(Emitter::position).collect();
    assert!(places.len() > 1 && places.iter().all(|p| p.z == 3.0));
    let mean = places.iter().sum::<Vec3>() / places.len() as f32;
    assert!((mean - Vec3::new(0.05, 0.1, 3.0)).length() < 0.01, "{mean}");
    assert_eq!(scene.instances().len(), 0);
    let around = load(&[("scene.rad", "!xform -rx 90 a.rad"), ("a.rad", text)]).unwrap();
    // The axis −z turns to +y.
    assert!((intensity(&around, Vec3::Y) - 0.2).abs() < 1e-4);
}

/// Data over φ, folded at 90°, and θ: 100 down, 0 at 90°, and 80 at 45° for φ = 0, 160 for φ = 90°.
const DATA: &str = "2\n0 90 2\n0 90 3\n100 80 0 100 160 0\n";

#[test]
fn luminaires_of_ies2rad_shine_by_their_data() {
    let of = |correction: &str, surface: &str| {
        let text = format!(
            "void brightdata d 5 {correction} a.dat source.cal src_phi4 src_theta 0 4 .5 .2 .4 .1\n\
             d light l 0 0 3 2 2 2\nl {surface}\n"
        );
        load(&[("scene.rad", &text), ("a.dat", DATA)]).unwrap()
    };
    let down = "polygon p 0 0 12 0 0 3 0 .2 3 .4 .2 3 .4 0 3";
    let at = |degrees: f32, phi: f32| {
        let ((sin, cos), (y, x)) = (sin_cos(degrees.to_radians()), sin_cos(phi.to_radians()));
        Vec3::new(sin * x, sin * y, -cos)
    };
    // 2 (light) · 0.5 (A₁) · area · value; the flat correction takes the cosine away.
    for (scene, area, cos) in [
        (of("flatcorr", down), 0.08, false),
        (of("corr", down), 0.08, true),
        (of("corr", "sphere s 0 0 4 0 0 0 .1"), PI * 0.01, false),
        (of("flatcorr", "ring r 0 0 8 0 0 3 0 0 -1 0 .2"), PI * 0.04, false),
    ] {
        for (degrees, phi, value) in [
            (1.0_f32, 0.0, 99.56),
            (45.0, 0.0, 80.0),
            (45.0, 90.0, 160.0),
            (45.0, 225.0, 120.0),
            (60.0, 180.0, 53.33),
        ] {
            let factor = if cos { sin_cos(degrees.to_radians()).1 } else { 1.0 };
            let (found, expected) = (intensity(&scene, at(degrees, phi)), area * value * factor);
            assert!((found / expected - 1.0).abs() < 0.01, "{degrees}° {phi}°: {found}, not {expected}");
        }
        let up = intensity(&scene, Vec3::Z);
        assert!(up.abs() < 1e-3, "nothing upward: {up}");
    }
    // The mean square of the distance from the centre of a disk is half the square of its radius.
    let disk = of("flatcorr", "ring r 0 0 8 0 0 3 0 0 -1 0 .2");
    let squares: Vec<f32> =
        disk.emitters().iter().filter_map(Emitter::position).map(|p| p.truncate().length_squared()).collect();
    let mean = squares.iter().sum::<f32>() / squares.len() as f32;
    assert!((mean / 0.02 - 1.0).abs() < 1e-5, "{mean}");
    // A box of 0.2 × 0.4 × 0.1 m, whose lower side is seen from below as a whole.
    let boxed = of("boxcorr", "polygon p 0 0 12 0 0 3 0 .4 3 .2 .4 3 .2 0 3");
    assert!((intensity(&boxed, Vec3::NEG_Z) - 100.0).abs() < 1.0, "{}", intensity(&boxed, Vec3::NEG_Z));
    let (found, sum) = (intensity(&boxed, at(45.0, 0.0)), 0.5_f32.sqrt() * (0.08 + 0.04));
    assert!((found - 80.0 * 0.08 * 0.5_f32.sqrt() / sum).abs() < 1.0, "{found}");
}

#[test]
fn luminaires_turn_with_their_file_and_share_their_data() {
    let text = "void brightdata d 7 flatcorr a.dat source.cal src_phi4 src_theta -rz 90 0 1 1\n\
        d light l 0 0 3 1 1 1\nl ring r 0 0 8 0 0 0 0 0 -1 0 .1\n";
    let scene = load(&[("scene.rad", text), ("a.dat", DATA)]).unwrap();
    let side = |x: f32, y: f32| Vec3::new(x, y, -1.0).normalize();
    let area = PI * 0.01;
    // The data's φ = 0 is along +y now.
    for (direction, value) in [(side(0.0, 1.0), 80.0), (side(1.0, 0.0), 160.0)] {
        let found = intensity(&scene, direction) / area;
        assert!((found / value - 1.0).abs() < 0.01, "{direction}: {found}");
    }
    let twice = load(&[("scene.rad", "!xform -rx 90 -a 3 -t 5 0 0 a.rad"), ("a.rad", text), ("a.dat", DATA)])
        .unwrap();
    // The light that went down goes along +y.
    let found = intensity(&twice, Vec3::new(0.0, 1.0, 0.0)) / (3.0 * area);
    assert!((found / 100.0 - 1.0).abs() < 0.01, "{found}");
    let message = error(&[("scene.rad", text)]);
    assert!(message.contains("a.dat"), "{message}");
    let message = error(&[("scene.rad", text), ("a.dat", "1 0 90 2 1 1")]);
    assert!(message.contains("data of 1 axes; expected as many as coordinates: 2"), "{message}");
}
