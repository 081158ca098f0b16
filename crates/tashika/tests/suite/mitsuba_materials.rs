//! What Mitsuba's materials reflect here, against Mitsuba 3 itself: numbers that `crates/tashika-bench/mitsuba_materials.py`
//! wrote.

use tashika::color::Rgb;
use tashika::math::elementary::sin_cos;
use tashika::math::{Frame, Vec3};
use tashika::scene::{Material, Scene};

use crate::mitsuba::{load_in, xml};

/// Elevations of the albedos of a row (degrees).
const ELEVATIONS: [f32; 3] = [75.0, 40.0, 12.0];
/// Elevation of the one direction and of the other, azimuth between them, of the values of a row (degrees).
const PAIRS: [[f32; 3]; 3] = [[75.0, 50.0, 150.0], [40.0, 30.0, 100.0], [12.0, 25.0, 170.0]];

/// What is off by more than 1 %, by what a row holds: albedos and values, at most how far; the first that fits counts.
const OFF: [(&str, [f64; 2]); 4] = [
    ("roughplastic", [0.012, 0.022]),
    // The notes say so.
    ("anisotropic", [0.38, 7.0]),
    ("clearcoat", [0.15, 0.16]),
    ("flatness", [0.29, 0.35]),
];

fn direction(elevation: f32, azimuth: f32) -> Vec3 {
    let ((up, across), (y, x)) = (sin_cos(elevation.to_radians()), sin_cos(azimuth.to_radians()));
    Vec3::new(across * x, across * y, up)
}

/// The material of a scene: parts of a mix are older than the mix.
fn material(scene: &Scene) -> &Material {
    scene.materials().last().unwrap()
}

fn opacity(scene: &Scene) -> f64 {
    material(scene).alpha.map_or(1.0, |alpha| f64::from(alpha.value.factor))
}

/// Directional albedo at an elevation, by draws of a sequence that fills the cube evenly.
fn albedo(scene: &Scene, elevation: f32) -> [f64; 3] {
    const DRAWS: u32 = 1 << 16;
    let outgoing = direction(elevation, 0.0);
    let frame = Frame::about(Vec3::Z);
    let mut sum = [0.0; 3];
    for draw in 0..DRAWS {
        // Powers of the inverse root of x⁵ = x + 1.
        let u = [0.856_674_88, 0.733_891_9, 0.628_706_7, 0.538_597_2];
        let u = u.map(|step: f64| (0.5 + step * f64::from(draw)).fract() as f32);
        let part = scene.part_of(material(scene), Default::default(), outgoing.z, u[0]);
        let sample = part.bsdf.sample(frame.to_local(outgoing), [u[1], u[2], u[3]]);
        let weight = sample.map_or(Rgb::BLACK, |sample| sample.weight) * part.weight;
        for (sum, value) in sum.iter_mut().zip(weight.to_array()) {
            *sum += f64::from(value) / f64::from(DRAWS);
        }
    }
    // What passes through holes counts as sent on.
    sum.map(|sum| opacity(scene) * sum + 1.0 - opacity(scene))
}

/// The BSDF times the cosine (sr⁻¹): the mean of parts that numbers spread evenly choose.
fn value(scene: &Scene, [elevation, other, azimuth]: [f32; 3]) -> [f64; 3] {
    const CHOICES: u16 = 1000;
    let (one, other) = (direction(elevation, 0.0), direction(other, azimuth));
    let mut sum = [0.0; 3];
    for choice in 0..CHOICES {
        let u = (f32::from(choice) + 0.5) / f32::from(CHOICES);
        let part = scene.part_of(material(scene), Default::default(), one.z, u);
        let value = if part.through { Rgb::BLACK } else { part.bsdf.eval_cos(one, other) * part.weight };
        for (sum, value) in sum.iter_mut().zip(value.to_array()) {
            *sum += f64::from(value) / f64::from(CHOICES);
        }
    }
    sum.map(|sum| opacity(scene) * sum)
}

#[test]
fn materials_reflect_what_mitsuba_says() {
    let mut wrong = Vec::new();
    for row in include_str!("mitsuba_materials.txt").lines().filter(|row| !row.starts_with('#')) {
        let (bsdf, numbers) = row.rsplit_once('>').unwrap();
        let body = format!("<shape type=\"rectangle\">{bsdf}></shape>");
        let scene = load_in(&[("scene.xml", xml("3.0.0", &body).as_bytes())]).1.unwrap();
        // Rough glass is drawn from, but has no values.
        let has_values = !bsdf.contains("roughdielectric") && !bsdf.contains("spec_trans");
        let allowed =
            OFF.iter().find(|(name, _)| bsdf.contains(name)).map_or([0.01; 2], |(_, allowed)| *allowed);
        let expected: Vec<f64> = numbers.split_whitespace().map(|n| n.parse().unwrap()).collect();
        let (albedos, values) = expected.split_at(3 * ELEVATIONS.len());
        let found: Vec<f64> = ELEVATIONS.iter().flat_map(|&at| albedo(&scene, at)).collect();
        // Noise of Mitsuba's numbers, which have four decimals.
        let mut compare = |what, found: Vec<f64>, expected: &[f64], noise: f64, allowed: f64| {
            assert_eq!(found.len(), expected.len(), "{row}");
            let off = |(f, e): (&f64, &f64)| ((f - e).abs() - noise).max(0.0) / e.max(noise);
            let worst = found.iter().zip(expected).map(off).fold(0.0, f64::max);
            if worst > allowed {
                wrong.push(format!("{what} {worst:.3} {bsdf}>\n    {found:.4?}\n    {expected:.4?}"));
            }
        };
        compare("albedo", found, albedos, 0.002, allowed[0]);
        if has_values {
            let found = PAIRS.iter().flat_map(|&pair| value(&scene, pair)).collect();
            compare("value", found, values, 1e-6, allowed[1]);
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
