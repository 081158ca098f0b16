//! What Mitsuba's materials reflect here, against Mitsuba 3 itself: numbers that `crates/tashika-bench/mitsuba_materials.py`
//! wrote.

use tashika::color::Rgb;
use tashika::math::elementary::sin_cos;
use tashika::math::{Frame, Vec3};
use tashika::scene::Scene;

use crate::mitsuba::{load_in, xml};

/// What is off by more than 1 %, by what a row holds, and at most how far; the first that fits counts.
///
/// At grazing angles the table of rough boundaries is off. The principled BSDF becomes that of glTF, which is the same
/// where it is metal.
const OFF: [(&str, f64); 3] =
    [("roughplastic", 0.012), ("name=\"metallic\" value=\"1.0\"", 0.01), ("principled", 0.24)];

/// Directional albedo at an elevation, by draws of a sequence that fills the cube evenly.
fn albedo(scene: &Scene, elevation: f32) -> [f64; 3] {
    const DRAWS: u32 = 1 << 16;
    // Parts of a mix are older than the mix.
    let material = scene.materials().last().unwrap();
    let (sin, cos) = sin_cos(elevation.to_radians());
    let outgoing = Vec3::new(cos, 0.0, sin);
    let frame = Frame::about(Vec3::Z);
    let mut sum = [0.0; 3];
    for draw in 0..DRAWS {
        // Powers of the inverse root of x⁵ = x + 1.
        let u = [0.856_674_88, 0.733_891_9, 0.628_706_7, 0.538_597_2];
        let u = u.map(|step: f64| (0.5 + step * f64::from(draw)).fract() as f32);
        let part = scene.part_of(material, Default::default(), outgoing.z, u[0]);
        let sample = part.bsdf.sample(frame.to_local(outgoing), [u[1], u[2], u[3]]);
        let weight = sample.map_or(Rgb::BLACK, |sample| sample.weight) * part.weight;
        for (sum, value) in sum.iter_mut().zip(weight.to_array()) {
            *sum += f64::from(value) / f64::from(DRAWS);
        }
    }
    sum
}

#[test]
fn materials_reflect_what_mitsuba_says() {
    let mut wrong = Vec::new();
    for row in include_str!("mitsuba_materials.txt").lines().filter(|row| !row.starts_with('#')) {
        let (bsdf, numbers) = row.rsplit_once('>').unwrap();
        let body = format!("<shape type=\"rectangle\">{bsdf}></shape>");
        let scene = load_in(&[("scene.xml", xml("3.0.0", &body).as_bytes())]).1.unwrap();
        let expected: Vec<f64> = numbers.split_whitespace().map(|n| n.parse().unwrap()).collect();
        let found: Vec<f64> = [75.0, 40.0, 12.0].iter().flat_map(|&at| albedo(&scene, at)).collect();
        assert_eq!(found.len(), expected.len(), "{row}");
        let allowed = OFF.iter().find(|(name, _)| bsdf.contains(name)).map_or(0.01, |(_, allowed)| *allowed);
        // Noise of Mitsuba's numbers, which have four decimals.
        let off = |(f, e): (&f64, &f64)| ((f - e).abs() - 0.002).max(0.0) / e;
        let worst = found.iter().zip(&expected).map(off).fold(0.0, f64::max);
        if worst > allowed {
            wrong.push(format!("{worst:.3} {bsdf}>\n    {found:.3?}\n    {expected:.3?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
