//! What Mitsuba's materials reflect here, against Mitsuba 3 itself: numbers that
//! `crates/tashika-bench/mitsuba_materials.py` wrote.

use tashika::color::Rgb;
use tashika::math::elementary::sin_cos;
use tashika::math::{Frame, Vec3};
use tashika::scene::{Material, Scene};

use crate::mitsuba::{load_in, xml};

/// Elevations of the albedos of a row (degrees).
const ELEVATIONS: [f32; 3] = [75.0, 40.0, 12.0];
/// Elevation of the one direction and of the other, azimuth between them, of the values of a row
/// (degrees).
const PAIRS: [[f32; 3]; 3] = [[75.0, 50.0, 150.0], [40.0, 30.0, 100.0], [12.0, 25.0, 170.0]];

/// What is off by more than 1 %, by what a row holds: albedos and values, at most how far; the
/// first that fits counts.
const OFF: [(&str, [f64; 2]); 3] = [
    ("roughplastic", [0.012, 0.022]),
    // The notes say so.
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

/// What a row of a table and a scene of its material disagree on, by more than `allowed` of albedos
/// and of values.
///
/// * `row`: for the message.
/// * `numbers`: albedos by elevation, then values by pair, a colour each; NaN where nothing is to
///   be compared.
pub fn disagreements(row: &str, numbers: &str, scene: &Scene, allowed: [f64; 2]) -> Vec<String> {
    let expected: Vec<f64> = numbers.split_whitespace().map(|n| n.parse().unwrap()).collect();
    assert_eq!(expected.len(), 3 * (ELEVATIONS.len() + PAIRS.len()), "{row}");
    let (albedos, values) = expected.split_at(3 * ELEVATIONS.len());
    let compare = |what, found: Vec<f64>, expected: &[f64], noise: f64, allowed: f64| {
        let off = |(f, e): (&f64, &f64)| ((f - e).abs() - noise).max(0.0) / e.max(noise);
        let worst = found.iter().zip(expected).map(off).fold(0.0, f64::max);
        (worst > allowed).then(|| format!("{what} {worst:.3} {row}\n    {found:.4?}\n    {expected:.4?}"))
    };
    let found = [
        ELEVATIONS.iter().flat_map(|&at| albedo(scene, at)).collect(),
        PAIRS.iter().flat_map(|&pair| value(scene, pair)).collect(),
    ];
    let [found_albedos, found_values] = found;
    // Noise of drawn albedos, which have four decimals.
    let albedos = compare("albedo", found_albedos, albedos, 0.002, allowed[0]);
    albedos.into_iter().chain(compare("value", found_values, values, 1e-6, allowed[1])).collect()
}

#[test]
fn materials_reflect_what_mitsuba_says() {
    let mut wrong = Vec::new();
    for row in include_str!("mitsuba_materials.txt").lines().filter(|row| !row.starts_with('#')) {
        let (bsdf, numbers) = row.rsplit_once('>').unwrap();
        let body = format!("<shape type=\"rectangle\">{bsdf}></shape>");
        let scene = load_in(&[("scene.xml", xml("3.0.0", &body).as_bytes())]).1.unwrap();
        let mut allowed =
            OFF.iter().find(|(name, _)| bsdf.contains(name)).map_or([0.01; 2], |(_, allowed)| *allowed);
        // Rough glass is drawn from, but has no values.
        if bsdf.contains("roughdielectric") || bsdf.contains("spec_trans") {
            allowed[1] = f64::INFINITY;
        }
        wrong.extend(disagreements(bsdf, numbers, &scene, allowed));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
